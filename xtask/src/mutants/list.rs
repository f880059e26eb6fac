//! The lists of mutants, `attack/mutants/ROOM.toml`.
//!
//! ```text
//! package = ["--package", "bearing-watch-model", "--lib"]              arguments of `cargo test`
//! tests = "audit:: rates::"                                            parts of the names of the room's own tests
//!
//! [[mutant]]
//! file = "workbench/model/src/audit/times.rs"                          from the root of the repository
//! old = "count < 2"                                                    in this file exactly once
//! new = "count < 3"
//! why = "two rows have no rate"                                        what a user would get
//! ```

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use toml::Table;

/// A part of the source with the tests that hold it.
#[derive(Clone, Debug)]
pub struct Room {
    pub name: String,
    /// Arguments of `cargo test`.
    pub package: Vec<String>,
    /// Parts of the names of the room's own tests; none for all.
    pub tests: String,
    pub mutants: Vec<Mutant>,
}

/// A change of the source that a test has to notice.
#[derive(Clone, Debug)]
pub struct Mutant {
    pub file: String,
    pub old: String,
    pub new: String,
    pub why: String,
}

impl Room {
    /// The folder of the package, from the root of the repository.
    pub fn folder(&self) -> &str {
        let file = self.mutants.first().map_or("", |mutant| mutant.file.as_str());
        file.split_once("src/").map_or("", |(folder, _)| folder)
    }
}

impl Mutant {
    /// The text of the file with the change.
    pub fn applied(&self, text: &str) -> Result<String> {
        ensure!(self.old != self.new, "the mutant of {} changes nothing: {:?}", self.file, self.old);
        let count = text.matches(&self.old).count();
        ensure!(count == 1, "{} has {count} times instead of once: {:?}", self.file, self.old);
        Ok(text.replacen(&self.old, &self.new, 1))
    }

    /// Start of the names of the tests beside the change: the module of the file.
    pub fn module(&self) -> String {
        let inside = self.file.split_once("src/").map_or(self.file.as_str(), |(_, inside)| inside);
        let module = inside.trim_end_matches(".rs").trim_end_matches("/mod").replace('/', "::");
        if module == "lib" { String::new() } else { format!("{module}::") }
    }

    /// File and line of the change, for people.
    pub fn place(&self, text: &str) -> String {
        let before = text.split(&self.old).next().unwrap_or_default();
        format!("{}:{}", self.file, before.matches('\n').count() + 1)
    }
}

/// All lists of a folder by name.
pub fn rooms(folder: &Path) -> Result<Vec<Room>> {
    let mut files = Vec::new();
    for entry in folder.read_dir().with_context(|| format!("no folder {}", folder.display()))? {
        files.push(entry?.path());
    }
    files.sort();
    let room = |path: &std::path::PathBuf| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        read(name, &fs::read_to_string(path)?).with_context(|| path.display().to_string())
    };
    files.iter().map(room).collect()
}

fn read(name: String, text: &str) -> Result<Room> {
    let table: Table = text.parse()?;
    let package = table.get("package").and_then(toml::Value::as_array).context("no list `package`")?;
    let package = package.iter().map(|word| word.as_str().map(ToOwned::to_owned).context("a word is no text"));
    let tests = table.get("tests").and_then(toml::Value::as_str).context("no text `tests`")?.to_owned();
    let mutants = table.get("mutant").and_then(toml::Value::as_array).context("no [[mutant]]")?;
    let mutants = mutants.iter().map(|entry| mutant(entry.as_table().context("a mutant is no table")?));
    Ok(Room { name, package: package.collect::<Result<_>>()?, tests, mutants: mutants.collect::<Result<_>>()? })
}

fn mutant(entry: &Table) -> Result<Mutant> {
    let text = |key: &str| {
        let value = entry.get(key).and_then(toml::Value::as_str).map(ToOwned::to_owned);
        value.with_context(|| format!("a mutant without the text `{key}`: {entry}"))
    };
    Ok(Mutant { file: text("file")?, old: text("old")?, new: text("new")?, why: text("why")? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{mutants, workspace};

    #[test]
    fn every_listed_mutant_can_be_made() -> Result<()> {
        let rooms = rooms(&mutants::lists())?;
        assert!(rooms.len() > 1);
        for Room { name, package, mutants, .. } in &rooms {
            assert!(!package.is_empty() && mutants.len() >= 5, "{name}");
            for mutant in mutants {
                let text = fs::read_to_string(workspace::root().join(&mutant.file)).context(mutant.file.clone())?;
                mutant.applied(&text).with_context(|| format!("attack/mutants/{name}.toml"))?;
                assert!(!mutant.why.is_empty(), "{name}: {}", mutant.old);
            }
        }
        Ok(())
    }

    #[test]
    fn a_text_that_is_not_there_once_is_refused() -> Result<()> {
        let list = "package = [\"--lib\"]\ntests = \"\"\n[[mutant]]\nfile = \"a.rs\"\nold = \"x < 1\"\nnew = \"x < 2\"\nwhy = \"late\"\n";
        let room = read("one".to_owned(), list)?;
        let [mutant] = &room.mutants[..] else { panic!("{room:?}") };
        assert_eq!(mutant.applied("if x < 1 {}\n")?, "if x < 2 {}\n");
        assert_eq!((mutant.module().as_str(), room.tests.as_str()), ("a::", ""));
        let elsewhere = Mutant { file: "workbench/model/src/audit/mod.rs".to_owned(), ..mutant.clone() };
        assert_eq!(elsewhere.module(), "audit::");
        assert_eq!(mutant.place("\n\nif x < 1 {}\n"), "a.rs:3");
        assert!(mutant.applied("x < 1 && x < 1").is_err() && mutant.applied("x < 3").is_err());
        let same = Mutant { new: mutant.old.clone(), ..mutant.clone() };
        assert!(same.applied("x < 1").is_err());
        for broken in [list.replace("old", "odd"), list.replace("tests", "test"), list.replace("[[mutant]]", "[m]")] {
            assert!(read("broken".to_owned(), &broken).is_err(), "{broken}");
        }
        Ok(())
    }
}
