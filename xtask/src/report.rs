//! What ended how: checks of this program, and tests of libtest and pytest, with the names of those that failed or were
//! not made; and the table at the end of a run.

use std::env;
use std::fmt::{self, Display, Write as _};
use std::time::{Duration, Instant};

use anyhow::Result;

/// Most characters of a reason in a list; the whole one stands where the check was made.
const LONGEST_REASON: usize = 400;

/// How many checks ended how.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub passed: u64,
    pub failed: u64,
    pub skipped: u64,
    /// Checks that failed, and those that were not made, by name and reason.
    broken: Vec<String>,
    left: Vec<String>,
}

/// A check and its reason in one line: a reason can have lines, and an indented command.
fn named(what: &str, reason: &str) -> String {
    let mut reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((end, _)) = reason.char_indices().nth(LONGEST_REASON) {
        reason.truncate(end);
        reason.push_str(" ...");
    }
    format!("{what}{}{reason}", if reason.is_empty() { "" } else { ": " })
}

impl Tally {
    /// One check's outcome, said aloud.
    pub fn check(&mut self, what: &str, outcome: Result<impl Display>) {
        match outcome.map(|detail| detail.to_string()) {
            Ok(detail) => {
                self.passed += 1;
                println!("pass  {what}{}{detail}", if detail.is_empty() { "" } else { ": " });
            }
            Err(error) => {
                self.failed += 1;
                println!("FAIL  {what}: {error:#}");
                self.broken.push(named(what, &format!("{error:#}")));
            }
        }
    }

    /// A check that has no place in this run, said aloud.
    pub fn skip(&mut self, what: &str, reason: &str) {
        self.skipped += 1;
        println!("skip  {what}: {reason}");
        self.left.push(named(what, reason));
    }

    /// A check without its tool or its data, said aloud: skipped, and in continuous integration (the variable `CI`)
    /// failed.
    pub fn missing(&mut self, what: &str, reason: &str) {
        if env::var("CI").is_ok_and(|value| !["", "0", "false"].contains(&value.as_str())) {
            self.left.push(named(what, reason));
            self.check(what, Err::<&str, _>(anyhow::anyhow!("{reason}")));
        } else {
            self.skip(what, reason);
        }
    }
}

/// The last line of a run; scripts read it.
impl Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} passed, {} failed, {} skipped", self.passed, self.failed, self.skipped)
    }
}

/// The stages of a run, with their times in milliseconds.
#[derive(Debug, Default)]
pub struct Stages(Vec<(String, Tally, u64)>);

impl Stages {
    /// Runs a stage: a heading, its checks, its time.
    pub fn stage<T>(&mut self, title: &str, work: impl FnOnce(&mut Tally) -> T) -> T {
        println!("\n== {title}");
        let (start, mut tally) = (Instant::now(), Tally::default());
        let result = work(&mut tally);
        self.0.push((title.to_owned(), tally, u64::try_from(start.elapsed().as_millis()).unwrap_or(u64::MAX)));
        result
    }

    /// The stages as lines for [`Stages::take_row`].
    pub fn rows(&self) -> String {
        let mut text = String::new();
        for (title, Tally { passed, failed, skipped, broken, left }, time) in &self.0 {
            let _string_grows = writeln!(text, "stage\t{title}\t{passed}\t{failed}\t{skipped}\t{time}");
            broken.iter().for_each(|line| text += &format!("broken\t{line}\n"));
            left.iter().for_each(|line| text += &format!("left\t{line}\n"));
        }
        text
    }

    /// Adds a stage of another process, or the name of a check to the last stage; whether the line is one of
    /// [`Stages::rows`].
    pub fn take_row(&mut self, line: &str) -> bool {
        let cells: Vec<&str> = line.split('\t').collect();
        match (cells.as_slice(), self.0.last_mut()) {
            (["broken", name], Some((_, tally, _))) => tally.broken.push((*name).to_owned()),
            (["left", name], Some((_, tally, _))) => tally.left.push((*name).to_owned()),
            (["stage", title, numbers @ ..], _) => {
                let numbers: Vec<u64> = numbers.iter().filter_map(|number| number.parse().ok()).collect();
                let [passed, failed, skipped, time] = numbers[..] else { return false };
                self.0.push(((*title).to_owned(), Tally { passed, failed, skipped, ..Tally::default() }, time));
            }
            _ => return false,
        }
        true
    }

    /// The table, what was not checked and what failed, and as the last line the count. What failed comes last, where a
    /// reader of a long output looks first.
    fn summary(&self) -> String {
        let (mut text, mut total) = (
            format!("{:16} {:>6} {:>6} {:>7} {:>9}\n", "stage", "passed", "failed", "skipped", "time"),
            Tally::default(),
        );
        for (title, tally, time) in &self.0 {
            let Tally { passed, failed, skipped, broken, left } = tally;
            let (verdict, time) = (if *failed > 0 { "  FAIL" } else { "" }, Duration::from_millis(*time).as_secs_f32());
            let _string_grows =
                writeln!(text, "{title:16} {passed:>6} {failed:>6} {skipped:>7} {time:>7.1} s{verdict}");
            total.passed += passed;
            total.failed += failed;
            total.skipped += skipped;
            total.broken.extend_from_slice(broken);
            total.left.extend_from_slice(left);
        }
        for (title, list) in [("not checked", &total.left), ("failed", &total.broken)] {
            if !list.is_empty() {
                text += &format!("\n{title}:\n  {}\n", list.join("\n  "));
            }
        }
        format!("{text}\n{total}")
    }

    /// Whether nothing has failed.
    pub fn passed(&self) -> bool {
        self.0.iter().all(|(_, tally, _)| tally.failed == 0)
    }

    /// Prints the summary; whether nothing has failed.
    pub fn end(&self) -> bool {
        println!("\n{}", self.summary());
        self.passed()
    }
}

/// Reads the lines of `cargo test -- --show-output`. A test that lacks something prints `skipped: REASON` and returns,
/// and passes for libtest.
#[derive(Debug, Default)]
pub struct Libtest {
    /// The passed test whose output follows.
    test: Option<String>,
    /// Tests of this program that were skipped, with the first reason.
    skipped: Vec<(String, String)>,
}

impl Libtest {
    pub fn read(&mut self, line: &str, tally: &mut Tally) {
        let test = line.strip_prefix("test ");
        if let Some(result) = line.strip_prefix("test result: ") {
            // `ok. 5 passed; 0 failed; 2 ignored; 0 measured; …`
            count(result, tally);
            for (test, reason) in std::mem::take(self).skipped {
                tally.passed = tally.passed.saturating_sub(1);
                tally.missing(&test, &reason);
            }
        } else if let Some((test, reason)) = test.and_then(|rest| rest.split_once(" ... ignored")) {
            tally.left.push(named(test, reason.strip_prefix(", ").unwrap_or("ignored")));
        } else if let Some(test) = test.and_then(|rest| rest.strip_suffix(" ... FAILED")) {
            tally.broken.push(named(test, ""));
        } else if line == "failures:" {
            self.test = None;
        } else if let Some(test) = line.strip_prefix("---- ").and_then(|rest| rest.strip_suffix(" stdout ----")) {
            let failed = tally.broken.iter().any(|broken| broken == test);
            self.test = (!failed).then(|| test.to_owned());
        } else if let (Some(reason), Some(test)) = (line.strip_prefix("skipped: "), self.test.take()) {
            self.skipped.push((test, reason.to_owned()));
        }
    }
}

/// Adds numbers before words, as libtest and pytest print them.
fn count(text: &str, tally: &mut Tally) {
    let mut number = 0;
    for word in text.split([' ', ';', ',']) {
        match word {
            "passed" | "xfailed" => tally.passed += number,
            "failed" | "error" | "errors" | "xpassed" => tally.failed += number,
            "ignored" | "skipped" => tally.skipped += number,
            other => number = other.parse().unwrap_or(0),
        }
    }
}

/// Reads the lines of `pytest -rfEs`: the skipped tests that were named so far.
#[derive(Debug, Default)]
pub struct Pytest(u64);

impl Pytest {
    pub fn read(&mut self, line: &str, tally: &mut Tally) {
        // The last line, as `2 failed, 121 passed, 1 skipped in 4.50s`.
        let last = line.trim_matches(['=', ' ']).rsplit_once(" in ").map(|(counts, _)| counts);
        let last = last.filter(|text| text.starts_with(|own: char| own.is_ascii_digit()) && text.contains("ed"));
        if let Some((number, rest)) = line.strip_prefix("SKIPPED [").and_then(|rest| rest.split_once("] ")) {
            // `SKIPPED [2] tests/test_x.py:12: reason`. In another package, for example a check of scikit-learn that
            // does not apply, nothing is missing.
            let (what, reason) = rest.split_once(": ").unwrap_or((rest, "skipped"));
            for _ in 0..number.parse().unwrap_or(1) {
                match what.starts_with("..") {
                    true => tally.skip(what, reason),
                    false => tally.missing(what, reason),
                }
                self.0 += 1;
            }
        } else if let Some(rest) = line.strip_prefix("FAILED ").or_else(|| line.strip_prefix("ERROR ")) {
            let (what, reason) = rest.split_once(" - ").unwrap_or((rest, ""));
            tally.broken.push(named(what, reason));
        } else if let Some(counts) = last {
            count(counts, tally);
            tally.skipped = tally.skipped.saturating_sub(std::mem::take(&mut self.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_of_libtest_add_up_with_names_of_what_failed_or_was_skipped() {
        let (mut libtest, mut stages) = (Libtest::default(), Stages::default());
        let text = "test b ... ignored, takes minutes\n\
                    test result: ok. 5 passed; 0 failed; 1 ignored; 0 measured; 1 filtered out; finished in 0.00s\n\
                    test d ... FAILED\n\nsuccesses:\n\n---- a stdout ----\nskipped: no data\nskipped: no more\n\n\
                    failures:\n\n---- d stdout ----\nskipped: a part\n\nfailures:\n    d\n\n\
                    test result: FAILED. 2 passed; 1 failed; 0 ignored; 0 measured\n";
        stages.stage("host", |tally| text.lines().for_each(|line| libtest.read(line, tally)));
        let (_, tally, _) = &stages.0[0];
        // In continuous integration the skipped one has failed.
        assert_eq!((tally.passed, tally.failed + tally.skipped), (6, 3));
        let summary = stages.summary();
        assert!(summary.contains("not checked:\n  b: takes minutes\n  a: no data\n"), "{summary}");
        assert!(summary.contains("failed:\n  d\n"), "{summary}");
        let mut other = Stages::default();
        assert!(stages.rows().lines().all(|line| other.take_row(line)) && !other.take_row("stage\tone\t1"));
        assert_eq!(other.summary(), summary);
    }

    #[test]
    fn the_last_line_of_pytest_adds_up_and_skipped_tests_are_named() {
        let (mut pytest, mut tally) = (Pytest::default(), Tally::default());
        let text = "tests/test_x.py ....    [ 12%]\n9 bottles hang in 3 rows\nSKIPPED [1] ../x.py:5: no numpy\n\
                    FAILED tests/t.py::test_a - assert 1 == 2\n\
                    = 2 failed, 121 passed, 1 skipped, 3 xfailed, 4 warnings, 1 error in 405.51s (0:06:45) =\n";
        text.lines().for_each(|line| pytest.read(line, &mut tally));
        assert_eq!(tally.to_string(), "124 passed, 3 failed, 1 skipped");
        assert_eq!((tally.left[0].as_str(), tally.broken.len()), ("../x.py:5: no numpy", 1));
    }
}
