//! `penombre-view`: the window.
#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command talks to a person")]

use clap::Parser;
use penombre::render::RenderSettings;
use penombre_view::session::Source;
use penombre_view::window::{self, Start};
use std::path::PathBuf;
use std::process::ExitCode;

/// Look at a scene, turn it, press `r` to render it. Keys: `?` in the window.
#[derive(Debug, Parser)]
#[command(name = "penombre-view", version, about, max_term_width = 110)]
struct Args {
    /// A scene file (.toml), a mesh (.obj, .off, .ply, .stl), or a built-in: sphere, square, cornell, sphere-as-given,
    /// cornell-as-given.
    #[arg(default_value = "sphere")]
    scene: String,
    /// Override a parameter of the scene, e.g. `camera.fov=40` or `material.red.diffuse=[1,0,0]`; repeatable.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Also allow files below this folder, not only below the scene's; repeatable.
    #[arg(long, value_name = "DIR")]
    asset_root: Vec<PathBuf>,
    /// Width and height of the picture, pixels; default: what the scene says.
    #[arg(long, value_name = "WxH", value_parser = RenderSettings::parse_size)]
    size: Option<[u32; 2]>,
    /// Render whenever the camera rests.
    #[arg(long)]
    live: bool,
    /// Show in the window's corner, as a colour, how many inputs were taken into account: for measurements.
    #[arg(long)]
    latency_marker: bool,
}

fn main() -> ExitCode {
    penombre_sys::fail_beyond_file_size_limit();
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    let start = Start {
        source: Source { scene: args.scene, asset_roots: args.asset_root, sets: args.set },
        size: args.size,
        live: args.live,
        latency_marker: args.latency_marker,
    };
    // Libraries below panic where parts of the desktop are missing: said once, in words.
    std::panic::set_hook(Box::new(|_| ()));
    let shown = std::panic::catch_unwind(|| window::run(start, Box::new(|line| println!("{line}"))));
    let message = match shown {
        Ok(Ok(())) => return ExitCode::SUCCESS,
        Ok(Err(message)) => message,
        Err(panic) => format!("the window broke off: {}", text(&*panic)),
    };
    eprintln!("error: {message}");
    ExitCode::FAILURE
}

/// What a panic said.
fn text(panic: &(dyn std::any::Any + Send)) -> &str {
    let owned = panic.downcast_ref::<String>().map(String::as_str);
    owned.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("for no stated reason")
}
