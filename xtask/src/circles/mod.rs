//! Within the core, the C interface, and each crate of the workbench no file uses another one that uses it, directly or
//! through others.
//!
//! A file uses those that define the names of its `use` and of its code. A name that a module only hands on is that of
//! the file that defines it. `mod`, `pub use`, comments and tests use nothing.

mod module;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::Result;

use crate::workspace;
use module::Module;

/// The modules of a crate by their paths: `crate`, `crate::train`, `crate::train::shaft`.
type Modules = BTreeMap<String, Module>;

/// The module whose file defines what a path in a module names; `None` of modules, locals and other crates.
fn definer(modules: &Modules, module: &str, path: &str, of_use: bool) -> Option<String> {
    let (mut at, mut rest) = (module.to_owned(), path);
    for place in 0.. {
        let (part, behind) = rest.split_once("::").unwrap_or((rest, ""));
        let brought = modules.get(&at)?.brought.get(part).filter(|_| place > 0 || !of_use);
        let child = format!("{at}::{part}");
        match part {
            "" => return None,
            "crate" if place == 0 => part.clone_into(&mut at),
            "self" if place == 0 => {}
            "super" => at = at.rsplit_once("::")?.0.to_owned(),
            // A function may have the name of its module.
            _ if modules.contains_key(&child) && (brought.is_none() || !behind.is_empty()) => at = child,
            _ => {
                let Some(path) = brought else { return (place > 0).then_some(at) };
                return definer(modules, &at, format!("{path}::{behind}").trim_matches(':'), true);
            }
        }
        rest = behind;
    }
    None
}

/// Each use of a file by one that it uses itself, directly or through others.
fn circles(modules: &Modules) -> Vec<String> {
    let mut uses: BTreeMap<&str, BTreeMap<String, Vec<&str>>> = BTreeMap::new();
    for (name, module) in modules {
        for path in &module.paths {
            if let Some(to) = definer(modules, name, path, false).filter(|to| to != name) {
                uses.entry(name).or_default().entry(to).or_default().push(path);
            }
        }
    }
    let reaches = |from: &str, to: &str| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(module) = open.pop() {
            let next = uses.get(module).into_iter().flat_map(BTreeMap::keys).map(String::as_str);
            open.extend(next.filter(|module| seen.insert(*module)));
        }
        seen.contains(to)
    };
    let file = |module: &str| &modules[module].file;
    let back = |from| uses[from].iter().filter(|(to, _)| reaches(to, from));
    let told = |from| back(from).map(|(to, by)| format!("{} uses {} by {}", file(from), file(to), by.join(", ")));
    uses.keys().copied().flat_map(told).collect()
}

/// Adds the modules of the files in a folder, which are those in `module`.
fn gather(folder: &Path, module: &str, modules: &mut Modules) -> Result<()> {
    for entry in folder.read_dir()? {
        let path = entry?.path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let name = if ["lib", "mod"].contains(&&*stem) { module.to_owned() } else { format!("{module}::{stem}") };
        if path.is_dir() {
            gather(&path, &name, modules)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            modules.insert(name, Module::of(path.strip_prefix(workspace::root())?, &fs::read_to_string(&path)?));
        }
    }
    Ok(())
}

#[test]
fn no_file_uses_one_that_uses_it() -> Result<()> {
    let mut crates = vec![workspace::root(), workspace::root().join("c-api")];
    for entry in workspace::root().join("workbench").read_dir()? {
        crates.push(entry?.path());
    }
    let mut circular = Vec::new();
    for folder in crates {
        let mut modules = Modules::new();
        gather(&folder.join("src"), "crate", &mut modules)?;
        circular.extend(circles(&modules));
    }
    assert!(circular.is_empty(), "{}", circular.join("\n"));
    Ok(())
}

#[test]
fn a_circle_through_names_that_are_handed_on_is_found() {
    let circular = |b: &str| {
        let texts = [("crate", "mod a;\npub use a::A;\n"), ("crate::a", "use crate::b::B;\n"), ("crate::b", b)];
        circles(&texts.map(|(name, text)| (name.to_owned(), Module::of(Path::new(name), text))).into())
    };
    assert_eq!(circular("// super::A\nstruct B;\n#[cfg(test)]\nmod tests {\n    use crate::A;\n}\n"), [""; 0]);
    let both = ["crate::a uses crate::b by crate::b::B", "crate::b uses crate::a by crate::A"];
    assert_eq!(circular("use crate::{\n    A as C,\n};\n"), both);
    assert_eq!(circular("fn f(a: super::A) {}\n").len(), 2);
}
