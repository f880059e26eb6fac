//! The text of a module → the names that it brings by `use`, and those that it uses.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A module in a file of its own.
#[derive(Default)]
pub(super) struct Module {
    /// Its path in the repository.
    pub(super) file: String,
    /// The path of each name that a `use` brings.
    pub(super) brought: BTreeMap<String, String>,
    /// The names and paths in its code, and those that a `use` brings for itself.
    pub(super) paths: BTreeSet<String>,
}

impl Module {
    pub(super) fn of(file: &Path, text: &str) -> Self {
        let mut module = Self { file: file.display().to_string(), ..Self::default() };
        let mut lines = text.lines().map(|line| line.split("//").next().unwrap_or(line));
        while let Some(line) = lines.next() {
            // Not a text that begins so.
            let tree = line.split_once("use ").filter(|(_, tree)| tree.contains("::"));
            let (before, tree) = tree.unwrap_or((".", ""));
            if line.starts_with("#[cfg(test)]") {
                // Tests stand last in a file; only tests use those in a file of their own.
                if lines.next().is_some_and(|line| line.contains("mod ") && line.ends_with('{')) {
                    break;
                }
            } else if before.trim().is_empty() || before.trim_start().starts_with("pub") {
                let mut tree = tree.to_owned();
                while !tree.contains(';') {
                    tree += lines.next().unwrap_or(";");
                }
                let tree = tree.replace(" as _", "").replace(" as ", "@").replace([' ', ';'], "");
                module.bring(&tree, before.trim_start().starts_with("pub"));
            } else if !line.contains("mod ") {
                let paths = line.split(|c: char| !c.is_ascii_alphanumeric() && !"_:".contains(c));
                module.paths.extend(paths.map(|path| path.trim_matches(':').to_owned()));
            }
        }
        module
    }

    /// Takes in a tree of `use` without spaces: `a::{b,c::{d,e@f}}`.
    fn bring(&mut self, tree: &str, handed_on: bool) {
        let (mut before, mut path) = (vec![], String::new());
        for c in tree.chars().chain([',']) {
            match c {
                '{' => before.push(path.clone()),
                ',' | '}' => {
                    let whole = path.strip_suffix("::self").unwrap_or(&path);
                    let last = whole.rsplit("::").next().unwrap_or(whole);
                    let (whole, name) = whole.split_once('@').unwrap_or((whole, last));
                    self.brought.insert(name.to_owned(), whole.to_owned());
                    self.paths.extend((!handed_on).then(|| whole.to_owned()));
                    before.truncate(before.len() - usize::from(c == '}'));
                    path = before.last().cloned().unwrap_or_default();
                }
                _ => path.push(c),
            }
        }
    }
}
