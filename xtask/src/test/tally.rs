//! What the runs of `cargo test` said, summed up for the end of a long output.

/// Counts over all test programs, and what could not be run.
#[derive(Debug, Default)]
pub struct Tally {
    programs: usize,
    passed: usize,
    failed: usize,
    ignored: usize,
    not_run: Vec<String>,
}

impl Tally {
    /// Shows one line of a test program's output and takes what counts from it.
    pub fn line(&mut self, line: &str) {
        println!("{line}");
        self.take(line);
    }

    /// Takes what counts. Shows nothing, so that this program's own tests do not count themselves.
    fn take(&mut self, line: &str) {
        if let Some(result) = line.strip_prefix("test result: ") {
            self.programs += 1;
            self.passed += count_before(result, " passed");
            self.failed += count_before(result, " failed");
            self.ignored += count_before(result, " ignored");
        }
        if let Some(at) = line.find("NOT RUN") {
            self.not_run(&line[at..]);
        }
    }

    /// Remembers something that this run leaves out; once, however often it is said.
    pub fn not_run(&mut self, what: &str) {
        if !self.not_run.iter().any(|known| known == what) {
            self.not_run.push(what.to_owned());
        }
    }

    /// Says loudly what is left out.
    pub fn print_not_run(&self) {
        for line in &self.not_run {
            println!("!!! {line}");
        }
    }

    /// One line with the sums over all test programs.
    pub fn print_totals(&self) {
        if self.programs > 0 {
            let Self { programs, passed, failed, ignored, .. } = self;
            println!("tests: {passed} passed, {failed} failed, {ignored} ignored in {programs} programs");
        }
    }
}

/// The number in front of `word`.
fn count_before(text: &str, word: &str) -> usize {
    let before = text.split(word).next().unwrap_or_default();
    before.rsplit(' ').next().and_then(|n| n.parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_results_and_keeps_what_was_not_run() {
        let mut tally = Tally::default();
        tally.take(
            "test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.1s",
        );
        tally.take("test result: FAILED. 3 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out");
        tally.take("NOT RUN: no corpus");
        tally.take("NOT RUN: no corpus");
        assert_eq!((tally.programs, tally.passed, tally.failed, tally.ignored), (2, 15, 2, 1));
        assert_eq!(tally.not_run, ["NOT RUN: no corpus"]);
    }
}
