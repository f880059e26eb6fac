//! Requirements of `docs/requirements.toml` have tests that exist, and `book/src/faults.md` lists every `unsafe`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use anyhow::{Context, Result, ensure};
use toml::{Table, Value};

use crate::cargo::files;
use crate::report::Tally;
use crate::workspace::root;

/// The document that names both.
const SAFETY: &str = "book/src/faults.md";

pub fn checks(tally: &mut Tally) {
    tally.check("requirements have tests that exist", requirements());
    tally.check("every unsafe is listed", unsafe_code());
}

/// Each requirement has a test, and each test `FILE::NAME` of the table and of the document exists. The document names
/// all requirements.
fn requirements() -> Result<String> {
    let (safety, table) = (fs::read_to_string(root().join(SAFETY))?, root().join("docs/requirements.toml"));
    let table: Table = fs::read_to_string(table)?.parse()?;
    let list = table.get("requirement").and_then(Value::as_array).context("no [[requirement]]")?;
    let mut tests: BTreeSet<&str> = safety.split(['`', ' ', '\n']).filter(|word| word.contains(".rs::")).collect();
    for requirement in list {
        let id = requirement.get("id").and_then(Value::as_str).context("a requirement without an id")?;
        let own = requirement.get("tests").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
        ensure!(!own.is_empty() && safety.contains(id), "{id} has no test, or {SAFETY} does not name it");
        tests.extend(own.iter().filter_map(Value::as_str));
    }
    for test in &tests {
        let (file, name) = test.split_once("::").with_context(|| format!("{test} is not FILE::NAME"))?;
        let text = fs::read_to_string(root().join(file)).with_context(|| format!("there is no file {file}"))?;
        let found = text.contains(&format!("fn {name}(")) || text.contains(&format!("def {name}("));
        ensure!(found, "{file} has no test {name}");
    }
    Ok(format!("{} requirements, {} tests", list.len(), tests.len()))
}

/// The rows of the document, a path, file or the start of several, and a number, count every `unsafe`: blocks,
/// functions, implementations and foreign items.
fn unsafe_code() -> Result<String> {
    let safety = fs::read_to_string(root().join(SAFETY))?;
    let (_, section) = safety.split_once("## Unsafe code").context("no section on unsafe code")?;
    let row = |line: &str| {
        let mut cells = line.strip_prefix("| `")?.split('|').map(str::trim);
        Some((cells.next()?.trim_end_matches('`').to_owned(), cells.next()?.parse::<usize>().ok()?))
    };
    let listed: BTreeMap<_, _> = section.split("\n## ").next().unwrap_or_default().lines().filter_map(row).collect();
    let mut counted: BTreeMap<&str, usize> = listed.keys().map(|path| (path.as_str(), 0)).collect();
    for file in files()?.iter().filter(|file| file.ends_with(".rs")) {
        let text = fs::read_to_string(root().join(file))?;
        let code = text.lines().filter_map(|line| line.split("// ").next()).collect::<Vec<_>>().join("\n");
        let starts = code.split("unsafe ").zip(code.split("unsafe ").skip(1)).filter(|(before, next)| {
            let is_word = !before.ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '"' | '`'));
            is_word && ["{", "fn ", "impl ", "extern "].iter().any(|start| next.starts_with(start))
        });
        let count = starts.count();
        // The longest path that it starts with.
        let path = listed.keys().filter(|path| file.starts_with(path.as_str())).max_by_key(|path| path.len());
        ensure!(count == 0 || path.is_some(), "{file} has {count} unsafe and is not listed");
        if let Some(sum) = path.and_then(|path| counted.get_mut(path.as_str())) {
            *sum += count;
        }
    }
    for (path, count) in &counted {
        ensure!(listed[*path] == *count, "{path}: {} unsafe are listed, there are {count}", listed[*path]);
    }
    Ok(counted.values().sum::<usize>().to_string())
}
