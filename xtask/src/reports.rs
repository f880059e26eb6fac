//! Reading what libtest and pytest print: counts, and the names of tests that failed or were not made.

use crate::tally::{Named, Tally};

/// What a test prints that cannot be made without something; it passes for libtest.
const SKIPPED: &str = "skipped: ";
/// Lines of a failed test's output that are its reason: where it panicked, and what it says.
const REASON_LINES: usize = 6;

/// Reads the lines of `cargo test -- --show-output`.
#[derive(Debug, Default)]
pub struct Libtest {
    /// The test whose output follows.
    test: Option<String>,
    /// Whether outputs of failed tests follow.
    failures: bool,
    /// Passed tests of this program that say that they were skipped.
    skipped: Vec<Named>,
    /// Failed tests of this program, and the last lines of their outputs.
    failed: Vec<(String, Vec<String>)>,
}

impl Libtest {
    pub fn read(&mut self, line: &str, tally: &mut Tally) {
        let output = line.strip_prefix("---- ").and_then(|rest| rest.strip_suffix(" stdout ----"));
        let ignored = line.strip_prefix("test ").and_then(|rest| rest.split_once(" ... ignored"));
        if let Some(result) = line.strip_prefix("test result: ") {
            self.end(result, tally);
        } else if let Some((test, reason)) = ignored {
            tally.name(test, reason.strip_prefix(", ").unwrap_or("ignored"));
        } else if line == "successes:" || line == "failures:" {
            (self.failures, self.test) = (line == "failures:", None);
        } else if let Some(test) = line.strip_prefix("test ").and_then(|rest| rest.strip_suffix(" ... FAILED")) {
            self.failed.push((test.to_owned(), Vec::new()));
        } else if let Some(test) = output {
            self.test = Some(test.to_owned());
        } else if let Some(test) = &self.test {
            match line.strip_prefix(SKIPPED) {
                _ if self.failures => {
                    let of_test = self.failed.iter_mut().find(|(name, _)| name == test);
                    of_test.into_iter().for_each(|(_, lines)| lines.push(line.to_owned()));
                }
                // A test is skipped once, for its first reason.
                Some(reason) if self.skipped.iter().all(|left| left.what != *test) => {
                    self.skipped.push(Named::new(test, reason));
                }
                _ => {}
            }
        }
    }

    /// Adds the counts of a line such as `test result: ok. 5 passed; 0 failed; 2 ignored; 0 measured; …`.
    fn end(&mut self, result: &str, tally: &mut Tally) {
        let mut number = 0;
        for word in result.split([' ', ';']) {
            match word {
                "passed" => tally.passed += number,
                "failed" => tally.failed += number,
                "ignored" => tally.skipped += number,
                other => number = other.parse().unwrap_or(0),
            }
        }
        let Self { skipped, failed, .. } = std::mem::take(self);
        for (test, lines) in failed {
            // What a test prints before it panics can be long.
            let panicked = lines.iter().position(|line| line.contains("panicked at")).unwrap_or(0);
            let reason = lines.into_iter().skip(panicked).take(REASON_LINES).collect::<Vec<_>>().join(" ");
            tally.broken.push(Named::new(&test, &reason));
        }
        for Named { what, reason } in skipped {
            tally.passed = tally.passed.saturating_sub(1);
            tally.missing(&what, &reason);
        }
    }
}

/// Reads the lines of `pytest -rfEs`.
#[derive(Debug, Default)]
pub struct Pytest {
    /// Skipped tests, and how many a line stands for.
    skipped: Vec<(Named, u64)>,
}

impl Pytest {
    pub fn read(&mut self, line: &str, tally: &mut Tally) {
        // `SKIPPED [2] tests/test_x.py:12: reason`
        if let Some((number, rest)) = line.strip_prefix("SKIPPED [").and_then(|rest| rest.split_once("] ")) {
            let (what, reason) = rest.split_once(": ").unwrap_or((rest, "skipped"));
            return self.skipped.push((Named::new(what, reason), number.parse().unwrap_or(1)));
        }
        // `FAILED tests/test_x.py::test_y - assert 1 == 2`
        if let Some(rest) = line.strip_prefix("FAILED ").or_else(|| line.strip_prefix("ERROR ")) {
            let (what, reason) = rest.split_once(" - ").unwrap_or((rest, ""));
            return tally.broken.push(Named::new(what, reason));
        }
        if let Some(counts) = counts(line) {
            self.end(counts, tally);
        }
    }

    fn end(&mut self, counts: Vec<(u64, &str)>, tally: &mut Tally) {
        for (number, word) in counts {
            match word {
                "passed" | "xfailed" => tally.passed += number,
                "failed" | "error" | "errors" | "xpassed" => tally.failed += number,
                "skipped" => {
                    let named: u64 = self.skipped.iter().map(|(_, number)| number).sum();
                    tally.skipped += number.saturating_sub(named);
                }
                _ => {}
            }
        }
        for (left, number) in std::mem::take(self).skipped {
            // The place is in another package, for example a check of scikit-learn that does not apply: nothing is
            // missing here.
            let foreign = left.what.starts_with("..");
            (0..number).for_each(|_| match foreign {
                true => tally.skip(&left.what, &left.reason),
                false => tally.missing(&left.what, &left.reason),
            });
        }
    }
}

/// Reads a line such as `2 failed, 121 passed, 1 skipped, 3 xfailed, 1 error in 4.50s`, the last one of pytest.
fn counts(line: &str) -> Option<Vec<(u64, &str)>> {
    let line = line.trim_matches(['=', ' ']);
    let (counts, _) = line.rsplit_once(" in ").filter(|(_, time)| time.contains('s'))?;
    let parts = counts.split(", ").map(|part| part.split_once(' '));
    parts.map(|part| part.and_then(|(number, word)| Some((number.parse().ok()?, word)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_libtest(text: &str) -> Tally {
        let (mut libtest, mut tally) = (Libtest::default(), Tally::default());
        text.lines().for_each(|line| libtest.read(line, &mut tally));
        tally
    }

    #[test]
    fn results_of_libtest_add_up_and_ignored_tests_are_named() {
        let tally = of_libtest(
            "test a ... ok\ntest b ... ignored, takes minutes\ntest c ... ignored\n\
             test result: ok. 5 passed; 0 failed; 2 ignored; 0 measured; 1 filtered out; finished in 0.00s\n\
             test d ... FAILED\n\nfailures:\n\n---- d stdout ----\n3 %\n\nthread 'd' panicked at d.rs:3:5:\nno\n\n\
             failures:\n    d\n\n\
             test result: FAILED. 1 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.20s\n",
        );
        assert_eq!(tally.to_string(), "6 passed, 3 failed, 2 skipped");
        let failed = "failed:\n  d: thread 'd' panicked at d.rs:3:5: no\n";
        assert_eq!(tally.list(), format!("not checked:\n  b: takes minutes\n  c: ignored\n{failed}"));
    }

    #[test]
    fn a_test_that_prints_that_it_is_skipped_has_not_passed() {
        let tally = of_libtest(
            "successes:\n\n---- a stdout ----\nskipped: no data\nskipped: no more\n\n---- b stdout ----\n3 %\n\n\
             successes:\n    a\n    b\n\nfailures:\n\n---- c stdout ----\nskipped: a part\n\nfailures:\n    c\n\n\
             test result: FAILED. 2 passed; 1 failed; 0 ignored; 0 measured\nskipped: outside of a test\n\
             test result: ok. 4 passed; 0 failed; 0 ignored; 0 measured\n",
        );
        // In continuous integration it has failed.
        assert_eq!((tally.passed, tally.failed + tally.skipped), (5, 2));
        assert_eq!(tally.left, [Named::new("a", "no data")]);
    }

    #[test]
    fn the_last_line_of_pytest_adds_up_and_skipped_tests_are_named() {
        let (mut pytest, mut tally) = (Pytest::default(), Tally::default());
        let text = "tests/test_x.py ....    [ 12%]\n9 bottles hang in 3 rows\nSKIPPED [1] tests/t.py:5: no numpy\n\
                    FAILED tests/t.py::test_a - assert 1 == 2\nERROR tests/t.py\n\
                    = 2 failed, 121 passed, 1 skipped, 3 xfailed, 4 warnings, 1 error in 405.51s (0:06:45) =\n\
                    5 passed, 1 skipped in 1.20s\n";
        text.lines().for_each(|line| pytest.read(line, &mut tally));
        assert_eq!((tally.passed, tally.failed + tally.skipped), (129, 5));
        assert_eq!(tally.left, [Named::new("tests/t.py:5", "no numpy")]);
        assert!(tally.list().contains("failed:\n  tests/t.py::test_a: assert 1 == 2\n  tests/t.py\n"));
    }
}
