//! `penombre completions` and `penombre man`: what shells and manuals want to know of the command line.

use crate::args::Cli;
use crate::{Exit, report, terminal};
use clap::CommandFactory;
use clap_complete::Shell;

/// Prints completions.
pub fn completions(shell: Shell) -> Exit {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "penombre", &mut text);
    terminal::out(String::from_utf8_lossy(&text).trim_end());
    Exit::Done
}

/// Prints the manual page, with a section for each command.
pub fn man() -> Exit {
    let mut text = Vec::new();
    match render(&mut text) {
        Ok(()) => terminal::out(String::from_utf8_lossy(&text).trim_end()),
        Err(e) => {
            report::error(&format!("the manual page cannot be made: {e}"), "");
            return Exit::Failure;
        }
    }
    Exit::Done
}

fn render(out: &mut Vec<u8>) -> std::io::Result<()> {
    let mut command = Cli::command();
    command.build();
    clap_mangen::Man::new(command.clone()).render(out)?;
    for inner in command.get_subcommands().filter(|c| c.get_name() != "help") {
        let page = clap_mangen::Man::new(inner.clone());
        out.extend_from_slice(format!("\n.SH \"PENOMBRE {}\"\n", inner.get_name().to_uppercase()).as_bytes());
        page.render_description_section(out)?;
        page.render_synopsis_section(out)?;
        page.render_options_section(out)?;
    }
    Ok(())
}
