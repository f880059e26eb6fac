//! Public functions of the core that the example `panic_free` forgets: those of the types that the core exports.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use crate::{firmware, workspace};

/// The files of the core that export names.
const EXPORTING: [&str; 11] = [
    "lib.rs",
    "alarm/mod.rs",
    "drive/ad2s1210.rs",
    "drive/mod.rs",
    "model/mod.rs",
    "plan/mod.rs",
    "shaft/mod.rs",
    "signature/mod.rs",
    "storage/mod.rs",
    "telemetry/mod.rs",
    "watch/mod.rs",
];
/// The files of the example.
const CALLING: [&str; 10] = [
    "panic_free.rs",
    "support/bus_calls.rs",
    "support/converter.rs",
    "support/drive_calls.rs",
    "support/monitor_calls.rs",
    "support/recursive_calls.rs",
    "support/signature_calls.rs",
    "support/storage_calls.rs",
    "support/telemetry_calls.rs",
    "support/watch_calls.rs",
];
/// Not for programs of a drive: hidden helpers of macros and constants. And the verification of a signature, whose crate
/// has index checks that the compiler cannot prove; all of it but the arithmetic is `Trust::verify_with`.
const ELSEWHERE: [&str; 5] = ["Model::identified", "ModelError::name", "Trust::verify", "check", "identity"];

/// How a public function starts.
const PUBLIC: &[&str] = &["pub fn ", "pub const fn "];
/// How a function of a trait starts.
const OF_TRAIT: &[&str] = &["fn "];

/// Functions by their full names, `Type::name`, or `name` outside an `impl`.
pub fn forgotten() -> Result<Vec<String>> {
    let mut calls = String::new();
    for file in CALLING {
        let path = workspace::root().join(firmware::MEASURING).join(file);
        calls += &fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    }
    let calls = without_generics(&calls);
    let mut names = exported_functions()?;
    names.retain(|name| !is_called(&calls, name));
    Ok(names)
}

/// All functions that a program can call.
fn exported_functions() -> Result<Vec<String>> {
    let source = workspace::root().join("src");
    let mut exported = BTreeSet::new();
    for file in EXPORTING {
        let text = fs::read_to_string(source.join(file)).with_context(|| format!("cannot read src/{file}"))?;
        exported.extend(exports(&text));
    }
    let mut names = Vec::new();
    collect(&source, &mut names)?;
    names.retain(|name| exported.contains(name.split("::").next().unwrap_or_default()));
    // Lengths of arrays, which the compiler evaluates.
    names.retain(|name| !ELSEWHERE.contains(&name.as_str()) && !name.starts_with("Bounds::"));
    names.dedup();
    Ok(names)
}

/// Names that a file of the core exports by `pub use`, and the types and traits that it defines.
fn exports(source: &str) -> BTreeSet<String> {
    let uses = source.split("pub use ").skip(1).filter_map(|rest| rest.split(';').next());
    // Of a path only what is exported: the last name, or those in braces.
    let lists = uses.map(|path| path.rsplit_once("::").map_or(path, |(_, list)| list));
    let used = lists.flat_map(|list| list.split(|c: char| !c.is_alphanumeric() && c != '_')).map(ToOwned::to_owned);
    let defined = source.lines().filter_map(|line| {
        let rest = ["pub struct ", "pub enum ", "pub trait "].iter().find_map(|start| line.strip_prefix(start))?;
        rest.split(['<', ':', ' ', '(', ';']).next().map(ToOwned::to_owned)
    });
    used.chain(defined).filter(|name| !name.is_empty()).collect()
}

/// Functions of all Rust files below a folder.
fn collect(folder: &Path, names: &mut Vec<String>) -> Result<()> {
    for entry in folder.read_dir().with_context(|| format!("no folder {}", folder.display()))? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, names)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            names.extend(public_functions(&fs::read_to_string(&path)?));
        }
    }
    names.sort();
    Ok(())
}

/// Reads formatted source: an `impl` or public trait at the margin owns what is indented below it, and the tests come
/// last.
fn public_functions(source: &str) -> Vec<String> {
    let source = source.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let mut names = Vec::new();
    let (mut owner, mut starts) = (None, PUBLIC);
    let mut lines = source.lines();
    while let Some(line) = lines.next() {
        if line.starts_with("impl") {
            let mut header = line.to_owned();
            while !header.contains('{') {
                let Some(next) = lines.next() else { break };
                header += next.trim_start();
            }
            (owner, starts) = (Some(type_of(&header)), PUBLIC);
        } else if let Some(header) = line.strip_prefix("pub trait ") {
            (owner, starts) = (header.split(['<', ':', ' ']).next().map(ToOwned::to_owned), OF_TRAIT);
        } else if line.starts_with('}') {
            (owner, starts) = (None, PUBLIC);
        }
        let words = line.trim_start();
        let function = starts.iter().find_map(|start| words.strip_prefix(start));
        if let Some(name) = function.and_then(|rest| rest.split(['(', '<']).next()) {
            names.push(owner.as_ref().map_or_else(|| name.to_owned(), |owner| format!("{owner}::{name}")));
        }
    }
    names
}

/// The type's name in `impl<…> Type<…> {`.
fn type_of(header: &str) -> String {
    let header = without_generics(header);
    let header = header.split("where").next().unwrap_or_default();
    header.trim_start_matches("impl").trim().trim_end_matches(['{', ' ']).to_owned()
}

/// Drops what stands in angle brackets, and the `::` before them; of `<Type as Trait>` the trait's name stays.
fn without_generics(source: &str) -> String {
    let (mut text, mut inside) = (String::new(), String::new());
    let (mut depth, mut before) = (0_usize, ' ');
    let mut rest = source.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            // Arrows and comparisons are no brackets: the latter have spaces.
            '<' if !matches!(rest.peek(), Some(' ' | '=' | '<')) => {
                if depth == 0 && text.ends_with("::") {
                    text.truncate(text.len() - 2);
                }
                depth += 1;
            }
            '>' if depth > 0 && before != '-' => {
                depth -= 1;
                if depth == 0 {
                    text.extend(inside.split_once(" as ").map(|(_, name)| name));
                    inside.clear();
                }
            }
            _ if depth == 0 => text.push(c),
            _ if depth == 1 => inside.push(c),
            _ => {}
        }
        before = c;
    }
    text
}

/// Whether a call by this name is there, and not by a longer one.
fn is_called(calls: &str, name: &str) -> bool {
    let call = format!("{name}(");
    calls.match_indices(&call).any(|(at, _)| {
        let before = calls.get(..at).and_then(|text| text.chars().next_back());
        before.is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != ':' && c != '.')
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "\
pub fn notes(bytes: &[u8]) -> bool {
}
impl<const M: usize, R>
    Model<M, R>
where
    R: Rows<M>,
{
    pub const fn new() -> Self {
    }
    fn own(&self) {}
}
pub trait Rows<const M: usize>: Clone {
    fn push(&mut self);
}
#[cfg(test)]
mod tests {
    pub fn helper() {}
}
";

    #[test]
    fn functions_come_with_their_types_and_without_the_tests() {
        assert_eq!(public_functions(SOURCE), ["notes", "Model::new", "Rows::push"]);
    }

    #[test]
    fn exports_are_names_in_uses_and_definitions() {
        let source = "pub use a::{B, C};\npub struct D<P> {\n}\npub use e::F;\npub mod g {\n    pub use h::H;\n}\n";
        let found = exports(source);
        assert!(["B", "C", "D", "F", "H"].iter().all(|name| found.contains(*name)), "{found:?}");
    }

    #[test]
    fn calls_are_found_by_full_names_only() {
        let calls = without_generics("if a < b { Model::<6, { N - 1 }>::new(x); f::<u8>(); push_notes(); x.push() }");
        assert!(is_called(&calls, "Model::new") && is_called(&calls, "f"));
        assert!(is_called(&without_generics("x(<R as Rows<M>>::fits(y))"), "Rows::fits"));
        assert!(!is_called(&calls, "new") && !is_called(&calls, "notes") && !is_called(&calls, "push"));
    }

    #[test]
    fn the_core_has_functions_and_none_is_forgotten() -> Result<()> {
        let names = exported_functions()?;
        assert!(names.contains(&"Detector::step".to_owned()), "{names:?}");
        assert_eq!(forgotten()?, Vec::<String>::new());
        Ok(())
    }
}
