//! Starting other programs, always from the root of the workspace.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What a task ends with: nothing, or one message for the person.
pub type Outcome = Result<(), String>;

/// Root of the workspace.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace")
}

/// The folder with the big test corpora: `$PENOMBRE_TESTDATA`, else `shared` beside the workspace, if there.
pub fn test_data() -> Option<PathBuf> {
    let named = std::env::var_os("PENOMBRE_TESTDATA").map(PathBuf::from);
    let folder = named.or_else(|| Some(root().parent()?.join("shared")))?;
    folder.is_dir().then_some(folder)
}

/// The release build of the command `penombre`.
pub fn release_binary() -> PathBuf {
    built("release", "penombre")
}

/// A program of the workspace as built by the named profile, by the name of the profile's folder.
pub fn built(profile: &str, program: &str) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    target.join(profile).join(format!("{program}{}", std::env::consts::EXE_SUFFIX))
}

/// A program with arguments and added environment, as a value that can be shown and repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    program: OsString,
    arguments: Vec<OsString>,
    environment: Vec<(String, OsString)>,
}

impl Call {
    /// `cargo` with arguments: the one that started this program.
    pub fn cargo(arguments: &[&str]) -> Self {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        Self::new(cargo, arguments)
    }

    /// Any program with arguments.
    pub fn new(program: impl Into<OsString>, arguments: &[&str]) -> Self {
        let arguments = arguments.iter().map(|&a| a.into()).collect();
        Self { program: program.into(), arguments, environment: Vec::new() }
    }

    /// Adds an environment variable.
    pub fn env(mut self, name: &str, value: impl Into<OsString>) -> Self {
        self.environment.push((name.to_owned(), value.into()));
        self
    }

    /// The call as one would type it in the workspace's root.
    pub fn typed(&self) -> String {
        let program = Path::new(&self.program).file_name().unwrap_or(&self.program).to_string_lossy();
        let quoted = |text: &OsString| {
            let text = text.to_string_lossy();
            if text.contains(' ') { format!("'{text}'") } else { text.into_owned() }
        };
        let variables = self.environment.iter().map(|(name, value)| format!("{name}={}", quoted(value)));
        let words = variables.chain([program.into_owned()]).chain(self.arguments.iter().map(quoted));
        words.collect::<Vec<_>>().join(" ")
    }

    /// Runs it with the terminal's own output.
    pub fn status(&self) -> Outcome {
        let status = self.command().status();
        self.judge(status)
    }

    /// Runs it and hands each line of standard output to `line`, which decides what to show.
    pub fn lines(&self, mut line: impl FnMut(&str)) -> Outcome {
        let mut child = self.command().stdout(Stdio::piped()).spawn().map_err(|e| self.cannot_start(&e))?;
        let output = child.stdout.take().expect("standard output is piped");
        for text in BufReader::new(output).split(b'\n') {
            let text = text.map_err(|e| format!("`{}`: {e}", self.typed()))?;
            line(&String::from_utf8_lossy(&text));
        }
        let status = child.wait();
        self.judge(status)
    }

    /// Runs it and returns its standard output.
    pub fn output(&self) -> Result<String, String> {
        let mut all = String::new();
        self.lines(|line| {
            all.push_str(line);
            all.push('\n');
        })?;
        Ok(all)
    }

    /// Whether the program can be started and succeeds, in silence.
    pub fn succeeds(&self) -> bool {
        let status = self.command().stdout(Stdio::null()).stderr(Stdio::null()).status();
        status.is_ok_and(|s| s.success())
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.arguments).current_dir(root()).stdin(Stdio::null());
        command.envs(self.environment.iter().map(|(name, value)| (name, value)));
        command
    }

    fn judge(&self, status: std::io::Result<std::process::ExitStatus>) -> Outcome {
        match status {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(format!("`{}` ended with {status}", self.typed())),
            Err(error) => Err(self.cannot_start(&error)),
        }
    }

    fn cannot_start(&self, error: &std::io::Error) -> String {
        format!("cannot start `{}`: {error}", self.typed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_shows_itself_as_typed() {
        let call = Call::new("/usr/bin/python3", &["-B", "a b.py"]).env("X", "1");
        assert_eq!(call.typed(), "X=1 python3 -B 'a b.py'");
    }

    #[test]
    fn success_failure_and_missing_programs_are_told_apart() {
        assert!(Call::cargo(&["--version"]).output().unwrap().starts_with("cargo "));
        assert!(!Call::cargo(&["no-such-command"]).succeeds());
        assert!(Call::new("penombre-no-such-program", &[]).status().unwrap_err().contains("cannot start"));
        assert!(!Call::new("penombre-no-such-program", &[]).succeeds());
    }
}
