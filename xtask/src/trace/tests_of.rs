//! Tests by file and name.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use crate::workspace;

/// Files of tests that were read, with the names of their tests.
#[derive(Debug, Default)]
pub struct TestFiles(RefCell<BTreeMap<String, Option<BTreeSet<String>>>>);

impl TestFiles {
    /// Why there is no test `FILE::NAME`, if there is none.
    pub fn problem(&self, test: &str) -> Option<String> {
        let Some((file, name)) = test.split_once("::") else { return Some(format!("{test} is not FILE::NAME")) };
        let mut files = self.0.borrow_mut();
        let names = files.entry(file.to_owned()).or_insert_with(|| {
            let text = fs::read_to_string(workspace::root().join(file)).ok()?;
            Some(names(&text))
        });
        match names {
            None => Some(format!("there is no file {file}")),
            Some(names) if names.contains(name) => None,
            Some(_) => Some(format!("{file} has no test {name}")),
        }
    }
}

/// Names of the tests of a file: functions after `#[test]`, also in `proptest!`, and Python's `def test_…`.
fn names(text: &str) -> BTreeSet<String> {
    let (mut names, mut is_test) = (BTreeSet::new(), false);
    for line in text.lines().map(str::trim_start) {
        if line.starts_with("#[test]") {
            is_test = true;
        } else if let Some(rest) = line.strip_prefix("fn ") {
            if std::mem::take(&mut is_test) {
                names.insert(word(rest));
            }
        } else if let Some(rest) = line.strip_prefix("def ") {
            names.extend(rest.starts_with("test_").then(|| word(rest)));
        }
    }
    names
}

/// The letters, digits and underscores that a text starts with.
fn word(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_tests_are_names() {
        let text = "fn helper() {}\n    #[test]\n    #[ignore = \"x\"]\n    fn one() {\n    }\nfn two() {}\ndef test_a(x):\ndef b():";
        assert_eq!(names(text).into_iter().collect::<Vec<_>>(), ["one", "test_a"]);
    }

    #[test]
    fn what_is_missing_is_said() {
        let files = TestFiles::default();
        assert_eq!(files.problem("xtask/src/trace/tests_of.rs::only_tests_are_names"), None);
        assert!(files.problem("xtask/src/trace/tests_of.rs::word").is_some_and(|text| text.contains("no test")));
        assert!(files.problem("nowhere.rs::a").is_some_and(|text| text.contains("no file")));
        assert!(files.problem("only_tests_are_names").is_some());
    }
}
