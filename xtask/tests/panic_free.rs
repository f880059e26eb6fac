//! The example `panic_free`, which links without a panic handler, calls every public function of the types that the
//! core exports.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Not for programs of a drive: lengths of arrays, which the compiler evaluates, hidden helpers of macros and
/// constants, and the verification of a signature, whose crate has index checks that the compiler cannot prove; all of
/// it but the arithmetic is `Trust::verify_with`.
const ELSEWHERE: [&str; 4] = ["Model::identified", "ModelError::name", "Trust::verify", "Bounds::"];

/// The Rust files below a folder without their tests.
fn sources(folder: &Path) -> Vec<String> {
    let paths: Vec<PathBuf> = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("one").path()).collect();
    let text = |path: &PathBuf| match path.is_dir() {
        true => sources(path),
        false => {
            vec![fs::read_to_string(path).expect("a text").split("#[cfg(test)]\nmod ").next().unwrap_or("").into()]
        }
    };
    paths.iter().flat_map(text).collect()
}

/// The names that a module exports, and those of its public modules.
fn exported(file: &Path, names: &mut BTreeSet<String>) {
    let text = fs::read_to_string(file).expect("a module");
    let uses = text.split("pub use ").skip(1).filter_map(|rest| Some(rest.split_once(';')?.0));
    names.extend(uses.flat_map(|list| list.split(|c: char| !c.is_alphanumeric())).map(ToOwned::to_owned));
    for kind in ["\npub struct ", "\npub enum ", "\npub trait "] {
        names.extend(
            text.split(kind)
                .skip(1)
                .filter_map(|rest| rest.split(|c: char| !c.is_alphanumeric()).next())
                .map(Into::into),
        );
    }
    let modules = text.split("\npub mod ").skip(1).filter_map(|rest| Some(rest.split_once(';')?.0));
    for name in modules.filter(|name| !name.contains('{')) {
        let folder = file.parent().expect("a folder").join(name);
        let module = folder.join("mod.rs");
        exported(&if module.is_file() { module } else { folder.with_extension("rs") }, names);
    }
}

/// The type of an `impl`, whose text starts behind that word.
fn owner(item: &str) -> &str {
    let mut depth = 0;
    let behind = item.find(|c: char| {
        depth += i32::from(c == '<') - i32::from(c == '>');
        depth == 0 && c.is_alphanumeric()
    });
    item[behind.unwrap_or(0)..].split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default()
}

#[test]
fn every_public_function_is_called() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let (mut types, mut forgotten) = (BTreeSet::new(), BTreeSet::new());
    exported(&root.join("src/lib.rs"), &mut types);
    let calls = sources(&root.join("target-tests/examples")).join("\n");
    let is_called = |owner: &str, name: &str| {
        let is_of =
            |(at, _): (usize, &str)| calls[calls.floor_char_boundary(at.saturating_sub(60))..at].contains(owner);
        ["(", "::<"].iter().any(|end| calls.match_indices(&format!("::{name}{end}")).any(is_of))
    };
    for source in sources(&root.join("src")) {
        for item in source.split("\nimpl").skip(1).filter_map(|item| item.split("\n}\n").next()) {
            let owner = owner(item);
            for function in item.split("    pub ").skip(1).filter_map(|rest| rest.split(['(', '<']).next()) {
                let name = function.rsplit(' ').next().unwrap_or_default();
                let full = format!("{owner}::{name}");
                let is_function = function.contains("fn ") && !ELSEWHERE.iter().any(|own| full.contains(own));
                if is_function && types.contains(owner) && !is_called(owner, name) {
                    forgotten.insert(full);
                }
            }
        }
    }
    assert!(types.contains("Monitor") && forgotten.is_empty(), "{forgotten:?}");
}
