//! `cargo xtask trace`: requirements of `docs/requirements.toml` and the tests that prove them, and every `unsafe`.
//!
//! It fails for a requirement without a test, for a test that does not exist, for an id that a document names and the
//! table does not have, and for a file with `unsafe` that `book/src/faults.md` does not list with its number.

mod tests_of;
mod unsafe_code;

use std::collections::BTreeSet;
use std::fs;

use anyhow::{Context, Result};
use toml::{Table, Value};

use crate::tally::Tally;
use crate::workspace;
use tests_of::TestFiles;

/// The table of requirements, and the document that names them.
const REQUIREMENTS: &str = "docs/requirements.toml";
const SAFETY: &str = "book/src/faults.md";

/// A requirement and the tests that prove it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Requirement {
    id: String,
    text: String,
    /// `FILE::NAME`
    tests: Vec<String>,
}

/// Checks, and prints the table; returns whether all is well.
pub fn run() -> Result<bool> {
    let mut tally = Tally::default();
    checks(&mut tally);
    let requirements = requirements(&read(REQUIREMENTS)?)?;
    let width = requirements.iter().map(|own| own.id.len()).max().unwrap_or(0);
    println!("\n{:width$}  tests  requirement", "id");
    for Requirement { id, text, tests } in &requirements {
        println!("{id:width$}  {:>5}  {text}", tests.len());
    }
    let proofs: BTreeSet<&String> = requirements.iter().flat_map(|own| &own.tests).collect();
    println!("\n{} requirements, {} tests\n{tally}", requirements.len(), proofs.len());
    Ok(tally.failed == 0)
}

/// The checks of the stage.
pub fn checks(tally: &mut Tally) {
    tally.check("requirements have tests that exist", count(requirement_problems()));
    tally.check("tests and requirements that book/src/faults.md names exist", count(document_problems()));
    tally.check("every unsafe is listed", count(unsafe_code::problems(SAFETY)));
}

/// A number of things without a problem, or the problems.
fn count(found: Result<(usize, Vec<String>)>) -> Result<String, String> {
    match found {
        Ok((count, problems)) if problems.is_empty() => Ok(count.to_string()),
        Ok((_, problems)) => Err(problems.join("; ")),
        Err(error) => Err(format!("{error:#}")),
    }
}

fn read(name: &str) -> Result<String> {
    fs::read_to_string(workspace::root().join(name)).with_context(|| format!("cannot read {name}"))
}

fn requirement_problems() -> Result<(usize, Vec<String>)> {
    let requirements = requirements(&read(REQUIREMENTS)?)?;
    let mut problems = problems_of(&requirements);
    let files = TestFiles::default();
    let proofs = requirements.iter().flat_map(|own| own.tests.iter().map(move |test| (&own.id, test)));
    for (id, test) in proofs {
        if let Some(problem) = files.problem(test) {
            problems.push(format!("{id}: {problem}"));
        }
    }
    Ok((requirements.len(), problems))
}

/// What is wrong with the table by itself.
fn problems_of(requirements: &[Requirement]) -> Vec<String> {
    let (mut ids, mut problems) = (BTreeSet::new(), Vec::new());
    for Requirement { id, text, tests } in requirements {
        if !ids.insert(id) {
            problems.push(format!("{id} comes twice"));
        }
        if !is_id(id) {
            problems.push(format!("{id} is no id like REQ-MODEL-1"));
        }
        if text.is_empty() || tests.is_empty() {
            problems.push(format!("{id} has no text, or no test"));
        }
    }
    if requirements.is_empty() {
        problems.push("there is no requirement".to_owned());
    }
    problems
}

fn is_id(id: &str) -> bool {
    let mut parts = id.split('-');
    let (first, group, number) = (parts.next(), parts.next(), parts.next());
    first == Some("REQ")
        && group.is_some_and(|group| !group.is_empty() && group.bytes().all(|byte| byte.is_ascii_uppercase()))
        && number.is_some_and(|number| number.parse::<u32>().is_ok())
        && parts.next().is_none()
}

/// Reads the table.
fn requirements(text: &str) -> Result<Vec<Requirement>> {
    let table: Table = text.parse().with_context(|| format!("{REQUIREMENTS} is no TOML"))?;
    let list = table.get("requirement").and_then(Value::as_array).context("no [[requirement]]")?;
    list.iter().map(requirement).collect()
}

fn requirement(value: &Value) -> Result<Requirement> {
    let text = |key: &str| value.get(key).and_then(Value::as_str).map(str::to_owned);
    let id = text("id").context("a requirement without an id")?;
    let tests = value.get("tests").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    let tests = tests.iter().filter_map(Value::as_str).map(str::to_owned).collect();
    Ok(Requirement { text: text("text").unwrap_or_default(), id, tests })
}

/// Every id and every test in the document, and every id of the table in the document.
fn document_problems() -> Result<(usize, Vec<String>)> {
    let (text, files) = (read(SAFETY)?, TestFiles::default());
    let requirements = requirements(&read(REQUIREMENTS)?)?;
    let (ids, tests) = named(&text);
    let mut problems: Vec<String> = tests.iter().filter_map(|test| files.problem(test)).collect();
    let known: BTreeSet<String> = requirements.into_iter().map(|own| own.id).collect();
    problems.extend(ids.difference(&known).map(|id| format!("{SAFETY} names {id}, which {REQUIREMENTS} has not")));
    problems.extend(known.difference(&ids).map(|id| format!("{SAFETY} does not name {id}")));
    Ok((ids.len() + tests.len(), problems))
}

/// Ids and tests between backquotes, or ids in plain text.
fn named(text: &str) -> (BTreeSet<String>, BTreeSet<String>) {
    let words = text.split(|c: char| c.is_whitespace() || matches!(c, '`' | ',' | '|' | '(' | ')' | ';'));
    let words = words.map(|word| word.trim_end_matches(['.', ':']));
    let (mut ids, mut tests) = (BTreeSet::new(), BTreeSet::new());
    for word in words {
        if is_id(word) {
            ids.insert(word.to_owned());
        } else if word.contains(".rs::") || word.contains(".py::") {
            tests.insert(word.to_owned());
        }
    }
    (ids, tests)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_requirement_without_a_test_is_a_problem() {
        let read = |tests: &str| {
            requirements(&format!("[[requirement]]\nid = \"REQ-A-1\"\ntext = \"t\"\ntests = [{tests}]\n"))
                .map(|own| problems_of(&own))
        };
        assert_eq!(read("\"a.rs::b\"").ok(), Some(vec![]));
        assert_eq!(read("").map(|problems| problems.len()).ok(), Some(1));
        assert!(requirements("[other]").is_err() && requirements("[[requirement]]\ntext = \"t\"").is_err());
    }

    #[test]
    fn ids_are_single_and_of_one_form() {
        let own = |id: &str| Requirement { id: id.into(), text: "t".into(), tests: vec!["a.rs::b".into()] };
        assert!(problems_of(&[own("REQ-A-1"), own("REQ-A-2")]).is_empty());
        assert_eq!(problems_of(&[own("REQ-A-1"), own("REQ-A-1")]).len(), 1);
        for bad in ["REQ-a-1", "REQ-A", "REQ-A-x", "REQ--1", "REQ-A-1-2", "A-1"] {
            assert!(!is_id(bad), "{bad}");
        }
        assert_eq!(problems_of(&[]).len(), 1);
    }

    #[test]
    fn a_document_names_ids_and_tests() {
        let (ids, tests) = named("| x | `src/a.rs::b`, REQ-A-1; REQ-B-22 |\nsee REQ-A-1.");
        assert_eq!(ids.into_iter().collect::<Vec<_>>(), ["REQ-A-1", "REQ-B-22"]);
        assert_eq!(tests.into_iter().collect::<Vec<_>>(), ["src/a.rs::b"]);
    }
}
