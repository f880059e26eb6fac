//! Counting what passed, and the names of what failed or was left out.

use std::env;
use std::fmt;

/// Most characters of a reason in a list; the whole one stands where the check was made.
const LONGEST_REASON: usize = 400;

/// How many checks ended how.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    pub passed: u64,
    pub failed: u64,
    pub skipped: u64,
    /// Checks that failed, by name.
    pub broken: Vec<Named>,
    /// Checks that were not made, by name.
    pub left: Vec<Named>,
}

/// A check and why it failed or was not made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    pub what: String,
    pub reason: String,
}

impl Named {
    /// A reason can have lines, and an indented command: here it is one line.
    pub fn new(what: &str, reason: &str) -> Self {
        let mut line = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        if let Some((end, _)) = line.char_indices().nth(LONGEST_REASON) {
            line.truncate(end);
            line.push_str(" ...");
        }
        Self { what: what.to_owned(), reason: line }
    }
}

impl Tally {
    /// One check's outcome, said aloud.
    pub fn check<T: fmt::Display, E: fmt::Display>(&mut self, what: &str, outcome: Result<T, E>) {
        match outcome {
            Ok(detail) => {
                self.passed += 1;
                println!("pass  {what}{}", Detail(detail));
            }
            Err(detail) => {
                self.failed += 1;
                let detail = detail.to_string();
                self.broken.push(Named::new(what, &detail));
                println!("FAIL  {what}{}", Detail(detail));
            }
        }
    }

    /// A check that has no place in this run, said aloud.
    pub fn skip(&mut self, what: &str, reason: &str) {
        self.skipped += 1;
        println!("skip  {what}: {reason}");
        self.name(what, reason);
    }

    /// A check without its tool or its data, said aloud: skipped, and in continuous integration failed.
    pub fn missing(&mut self, what: &str, reason: &str) {
        self.missing_in(is_continuous(env::var("CI").ok().as_deref()), what, reason);
    }

    fn missing_in(&mut self, continuous: bool, what: &str, reason: &str) {
        if continuous {
            self.check::<&str, _>(what, Err(reason));
            self.name(what, reason);
        } else {
            self.skip(what, reason);
        }
    }

    /// Names a check that was not made, and is counted elsewhere.
    pub fn name(&mut self, what: &str, reason: &str) {
        self.left.push(Named::new(what, reason));
    }

    pub fn add(&mut self, other: &Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
        self.broken.extend_from_slice(&other.broken);
        self.left.extend_from_slice(&other.left);
    }

    /// The checks that were not made and those that failed, a line each. The failed ones come last, where a reader of a
    /// long output looks first.
    pub fn list(&self) -> String {
        let list = |title: &str, checks: &[Named]| {
            let lines = checks.iter().map(|Named { what, reason }| format!("  {what}{}\n", Detail(reason)));
            if checks.is_empty() { String::new() } else { format!("{title}:\n{}", lines.collect::<String>()) }
        };
        list("not checked", &self.left) + &list("failed", &self.broken)
    }
}

/// Whether the variable `CI` says so.
fn is_continuous(variable: Option<&str>) -> bool {
    variable.is_some_and(|value| !["", "0", "false"].contains(&value))
}

/// A colon and the text, or nothing where there is none.
struct Detail<T>(T);

impl<T: fmt::Display> fmt::Display for Detail<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0.to_string();
        if text.is_empty() { Ok(()) } else { write!(f, ": {text}") }
    }
}

/// The last line of a run; scripts read it.
impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { passed, failed, skipped, .. } = self;
        write!(f, "{passed} passed, {failed} failed, {skipped} skipped")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named_and_fails_in_continuous_integration_only() {
        let mut tally = Tally::default();
        tally.missing_in(false, "a", "no\n    data");
        assert_eq!(tally.to_string(), "0 passed, 0 failed, 1 skipped");
        tally.missing_in(true, "b", "no tool");
        tally.skip("c", "no place");
        assert_eq!(tally.to_string(), "0 passed, 1 failed, 2 skipped");
        let left = "not checked:\n  a: no data\n  b: no tool\n  c: no place\n";
        assert_eq!(tally.list(), format!("{left}failed:\n  b: no tool\n"));
        tally.check::<&str, _>("d", Err(""));
        assert_eq!(tally.list(), format!("{left}failed:\n  b: no tool\n  d\n"));
        assert_eq!(Tally::default().list(), "");
        assert_eq!(Named::new("e", &"ä".repeat(500)).reason, format!("{} ...", "ä".repeat(LONGEST_REASON)));
    }

    #[test]
    fn continuous_integration_is_a_variable_that_says_yes() {
        assert!(is_continuous(Some("true")) && is_continuous(Some("1")));
        assert!([None, Some(""), Some("false"), Some("0")].iter().all(|variable| !is_continuous(*variable)));
    }
}
