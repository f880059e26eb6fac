//! Counting what passed, and the names of what was left out.

use std::env;
use std::fmt;

/// How many checks ended how.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    pub passed: u64,
    pub failed: u64,
    pub skipped: u64,
    /// Checks that were not made, by name.
    pub left: Vec<Left>,
}

/// A check that was not made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Left {
    pub what: String,
    pub reason: String,
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
        // A reason can have lines, and an indented command.
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        self.left.push(Left { what: what.to_owned(), reason });
    }

    pub fn add(&mut self, other: &Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
        self.left.extend_from_slice(&other.left);
    }

    /// The checks that were not made, a line each.
    pub fn list(&self) -> String {
        if self.left.is_empty() {
            return String::new();
        }
        let lines = self.left.iter().map(|Left { what, reason }| format!("  {what}: {reason}\n"));
        format!("not checked:\n{}", lines.collect::<String>())
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
        assert_eq!(tally.list(), "not checked:\n  a: no data\n  b: no tool\n  c: no place\n");
        assert_eq!(Tally::default().list(), "");
    }

    #[test]
    fn continuous_integration_is_a_variable_that_says_yes() {
        assert!(is_continuous(Some("true")) && is_continuous(Some("1")));
        assert!([None, Some(""), Some("false"), Some("0")].iter().all(|variable| !is_continuous(*variable)));
    }
}
