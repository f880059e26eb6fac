//! Every `unsafe` of the repository, beside the list of `book/src/faults.md`.

use std::collections::BTreeMap;
use std::fs;

use anyhow::{Context, Result, ensure};

use crate::workspace;

/// The heading of the list in the document. Its rows start with a path in backquotes, a file or the start of several,
/// and a number.
const HEADING: &str = "## Unsafe code";

/// Files with `unsafe`, and what is wrong with the list.
pub fn problems(document: &str) -> Result<(usize, Vec<String>)> {
    let text = fs::read_to_string(workspace::root().join(document)).with_context(|| format!("no {document}"))?;
    let listed = listed(&text)?;
    let mut counted = BTreeMap::new();
    for file in workspace::files()?.into_iter().filter(|file| file.ends_with(".rs")) {
        // Files that git has and that are gone.
        let Ok(text) = fs::read_to_string(workspace::root().join(&file)) else { continue };
        let count = uses(&text);
        if count > 0 {
            counted.insert(file, count);
        }
    }
    Ok((counted.values().sum(), differences(&listed, &counted)))
}

fn differences(listed: &BTreeMap<String, usize>, counted: &BTreeMap<String, usize>) -> Vec<String> {
    let mut sums: BTreeMap<&str, usize> = listed.keys().map(|path| (path.as_str(), 0)).collect();
    let mut problems = Vec::new();
    for (file, count) in counted {
        // The longest path that it starts with.
        match listed.keys().filter(|path| file.starts_with(path.as_str())).max_by_key(|path| path.len()) {
            Some(path) => *sums.entry(path).or_default() += count,
            None => problems.push(format!("{file} has {count} unsafe and is not listed")),
        }
    }
    for (path, count) in sums {
        let said = listed.get(path).copied().unwrap_or_default();
        if said != count {
            problems.push(format!("{path}: {said} unsafe are listed, there are {count}"));
        }
    }
    problems
}

/// The rows of the list: path and number.
fn listed(document: &str) -> Result<BTreeMap<String, usize>> {
    let (_, rest) = document.split_once(HEADING).with_context(|| format!("no heading {HEADING}"))?;
    let section = rest.split("\n## ").next().unwrap_or_default();
    let rows: BTreeMap<String, usize> = section.lines().filter_map(row).collect();
    ensure!(!rows.is_empty(), "{HEADING} has no rows");
    Ok(rows)
}

fn row(line: &str) -> Option<(String, usize)> {
    let mut cells = line.strip_prefix("| `")?.split('|').map(str::trim);
    Some((cells.next()?.trim_end_matches('`').to_owned(), cells.next()?.parse().ok()?))
}

/// Number of uses of `unsafe`: blocks, functions, implementations and foreign items; attributes, comments and texts are
/// none.
fn uses(text: &str) -> usize {
    let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    code.map(|line| {
        let line = line.split(" // ").next().unwrap_or_default();
        let parts: Vec<&str> = line.split("unsafe ").collect();
        let starts = parts.windows(2).filter(|pair| {
            let is_word = !pair[0].ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '"' | '`'));
            let next = ["{", "fn ", "impl ", "extern "];
            is_word && next.iter().any(|start| pair[1].starts_with(start))
        });
        starts.count()
    })
    .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uses_are_blocks_functions_and_implementations() {
        let word = "unsafe";
        let text = format!(
            "{word} {{ a }} {word} {{ b }}\npub {word} extern \"C\" fn f() {{}}\n{word} impl A for B {{\n\
             // {word} {{ no }}\n#[{word}(no_mangle)]\nx_{word} {{}}\nlet x = 1; // {word} {{ no }}\n"
        );
        assert_eq!(uses(&text), 4);
    }

    #[test]
    fn the_list_has_to_be_whole_and_right() {
        let document = "## Unsafe code\n\n| File | Number | Why |\n|---|---:|---|\n| `c/` | 3 | x |\n| `a.rs` | 1 | y |\n\n## Next\n";
        let listed = listed(document).expect("a list");
        let counted = |own: &[(&str, usize)]| own.iter().map(|(file, count)| ((*file).to_owned(), *count)).collect();
        assert!(differences(&listed, &counted(&[("a.rs", 1), ("c/x.rs", 1), ("c/y.rs", 2)])).is_empty());
        for wrong in [&[("a.rs", 1)][..], &[("a.rs", 2), ("c/x.rs", 3)], &[("a.rs", 1), ("c/x.rs", 3), ("z.rs", 1)]] {
            assert_eq!(differences(&listed, &counted(wrong)).len(), 1, "{wrong:?}");
        }
    }
}
