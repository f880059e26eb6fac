//! The files that a document gives: each fenced block whose marker, a comment in the line before it, names a file. A
//! block with mdBook's line `{{#include FILE}}` has the text of that file.
//!
//! ````text
//! <!-- src/main.rs -->
//! ```rust
//! fn main() {}
//! ```
//! ````

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::workspace;

/// What a reader replaces by the place of the checkout.
const CHECKOUT: &str = "/path/to/bearing-watch";

/// The block with the shell commands; not a file of the project.
const COMMANDS: &str = "commands";

/// The texts of a document by their paths in the project, and its commands.
pub struct Blocks(BTreeMap<String, String>);

impl Blocks {
    /// The blocks of a document of the repository.
    pub fn of_document(document: &str) -> Result<Self> {
        let path = workspace::root().join(document);
        let text = fs::read_to_string(&path).with_context(|| format!("cannot read {document}"))?;
        let (mut blocks, mut lines, mut marker) = (BTreeMap::new(), text.lines(), None);
        while let Some(line) = lines.next() {
            if let (Some(name), true) = (marker.take(), line.starts_with("```")) {
                let inside: Vec<&str> = lines.by_ref().take_while(|line| !line.starts_with("```")).collect();
                let mut text = inside.join("\n") + "\n";
                if let Some(file) = text.trim_end().strip_prefix("{{#include ").and_then(|own| own.strip_suffix("}}")) {
                    text = fs::read_to_string(path.with_file_name(file)).with_context(|| format!("no {file}"))?;
                }
                blocks.insert(name, text);
            }
            let inner = line.strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->"));
            marker = inner.filter(|name| !name.contains(' ')).map(ToOwned::to_owned);
        }
        ensure!(!blocks.is_empty(), "{document} has no marked blocks");
        Ok(Self(blocks))
    }

    /// The text of this name.
    pub fn named(&self, name: &str) -> Result<&str> {
        self.0.get(name).map(String::as_str).with_context(|| format!("no block is marked <!-- {name} -->"))
    }

    /// Writes the files of these names, or all, into a folder, with the place of the checkout.
    pub fn write(&self, names: Option<&[&str]>, folder: &Path, checkout: &Path) -> Result<()> {
        let all = || self.0.keys().map(String::as_str).filter(|name| *name != COMMANDS).collect();
        for name in names.map_or_else(all, <[&str]>::to_vec) {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap_or(folder))?;
            fs::write(&path, self.named(name)?.replace(CHECKOUT, &checkout.to_string_lossy()))?;
        }
        Ok(())
    }

    /// The commands, which copy from a checkout.
    pub fn commands(&self, folder: &Path, checkout: &Path) -> Result<Command> {
        let mut shell = Command::new("bash");
        shell.args(["-e", "-c", self.named(COMMANDS)?]).current_dir(folder).env("BEARING_WATCH", checkout);
        Ok(shell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_template_is_what_the_book_says() -> Result<()> {
        let template = |file: &str| fs::read_to_string(workspace::root().join("template").join(file));
        let blocks = Blocks::of_document("book/src/firmware.md")?;
        for name in ["Cargo.toml", ".cargo/config.toml", "src/main.rs"] {
            assert_eq!(template(name)?, blocks.named(name)?, "{name}");
        }
        let recorded = blocks.named(COMMANDS)?.lines().filter_map(|line| line.split("  #").next().map(str::trim_end));
        let (readme, mut recorded) = (template("README.md")?, recorded.filter(|line| line.contains("traces")));
        assert!(recorded.all(|line| readme.contains(line)));
        for (file, origin) in [("src/model.rs", "examples/support/actuator/model.rs"), ("memory.x", "memory.x")] {
            assert!(template(file)? == fs::read_to_string(workspace::root().join(origin))?, "{file} is not {origin}");
        }
        let generated = template("Cargo.toml.liquid")?.replace("{{project-name}}", "drive-monitor");
        assert_eq!(generated.replace("{{bearing_watch}}", CHECKOUT), template("Cargo.toml")?);
        Ok(())
    }
}
