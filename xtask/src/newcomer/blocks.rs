//! The files that a document gives: each fenced block whose marker, a comment in the line before it, names a file. A
//! block with mdBook's line `{{#include FILE}}` has the text of that file.
//!
//! ````text
//! <!-- src/main.rs -->
//! ```rust
//! fn main() {}
//! ```
//! ````

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::workspace;

/// What a reader replaces by the place of the checkout.
const CHECKOUT: &str = "/path/to/bearing-watch";

/// The block with the shell commands; not a file of the project.
pub const COMMANDS: &str = "commands";

/// A file of a document: its name, and its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// The path in the project, or [`COMMANDS`].
    pub name: String,
    /// The text as it stands there.
    pub text: String,
}

/// The blocks of a document of the repository.
pub fn of_document(document: &str) -> Result<Vec<Block>> {
    let path = workspace::root().join(document);
    let mut blocks = parse(&fs::read_to_string(&path).with_context(|| format!("cannot read {document}"))?);
    ensure!(!blocks.is_empty(), "{document} has no marked blocks");
    for block in &mut blocks {
        if let Some(file) = included(&block.text) {
            let file = path.with_file_name(file);
            block.text = fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
        }
    }
    Ok(blocks)
}

/// The file whose text a block has.
fn included(text: &str) -> Option<&str> {
    text.trim_end().strip_prefix("{{#include ")?.strip_suffix("}}")
}

/// The block of this name.
pub fn named<'a>(blocks: &'a [Block], name: &str) -> Result<&'a Block> {
    blocks.iter().find(|block| block.name == name).with_context(|| format!("no block is marked <!-- {name} -->"))
}

/// Writes all blocks but the commands into a folder, with the place of the checkout.
pub fn write(blocks: &[Block], folder: &Path, checkout: &Path) -> Result<()> {
    for block in blocks.iter().filter(|block| block.name != COMMANDS) {
        let path = folder.join(&block.name);
        let text = block.text.replace(CHECKOUT, &checkout.to_string_lossy());
        fs::create_dir_all(path.parent().unwrap_or(folder))?;
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Writes the block of this name, with the place of this checkout.
pub fn write_named(blocks: &[Block], name: &str, folder: &Path) -> Result<()> {
    write(&[named(blocks, name)?.clone()], folder, &workspace::root())
}

fn parse(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = text.lines();
    let mut marker = None;
    while let Some(line) = lines.next() {
        if let (Some(name), true) = (marker.take(), line.starts_with("```")) {
            let inside: Vec<&str> = lines.by_ref().take_while(|line| !line.starts_with("```")).collect();
            blocks.push(Block { name, text: inside.join("\n") + "\n" });
        }
        let inner = line.strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->"));
        marker = inner.filter(|name| !name.contains(' ')).map(ToOwned::to_owned);
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::super::crates::CHAPTER;
    use super::*;

    #[test]
    fn only_marked_blocks_are_files() {
        let text =
            "<!-- a/b.c -->\n```c\nint x;\n\n```\n<!-- end -->\n```sh\nls\n```\n<!-- generated: x y -->\n```\n1\n```\n";
        let names: Vec<_> = parse(text).into_iter().map(|block| (block.name, block.text)).collect();
        // A marker needs no known name: `end` closes generated text, which no block follows in a document.
        assert_eq!(names, [("a/b.c".into(), "int x;\n\n".into()), ("end".into(), "ls\n".into())]);
        assert_eq!(parse("<!-- a -->\n\n```c\n1\n```\n"), [], "the marker stands in the line before");
        assert_eq!(included("{{#include ../x.rs}}\n"), Some("../x.rs"));
        assert_eq!(included("fn main() {}\n"), None);
    }

    fn template(file: &str) -> String {
        fs::read_to_string(workspace::root().join("template").join(file)).unwrap_or_default()
    }

    #[test]
    fn the_template_has_the_files_of_the_book() -> Result<()> {
        let blocks = of_document(CHAPTER)?;
        for name in ["Cargo.toml", ".cargo/config.toml", "src/main.rs"] {
            assert_eq!(template(name), named(&blocks, name)?.text, "{name}");
        }
        Ok(())
    }

    #[test]
    fn the_template_records_as_the_book_does() -> Result<()> {
        let (blocks, own) = (of_document(CHAPTER)?, template("README.md"));
        let commands = named(&blocks, COMMANDS)?.text.lines().filter_map(|line| line.split("  #").next());
        let commands: Vec<_> = commands.map(str::trim_end).filter(|line| line.contains("traces")).collect();
        assert!(commands.len() == 2 && commands.iter().all(|line| own.contains(line)), "{commands:?}");
        Ok(())
    }

    #[test]
    fn the_template_has_the_model_and_the_memory_map_of_the_examples() -> Result<()> {
        for (file, origin) in [("src/model.rs", "examples/support/actuator/model.rs"), ("memory.x", "memory.x")] {
            assert!(template(file) == fs::read_to_string(workspace::root().join(origin))?, "{file} is not {origin}");
        }
        Ok(())
    }

    #[test]
    fn the_generated_manifest_is_that_of_a_copy() {
        let generated = template("Cargo.toml.liquid");
        let filled = generated.replace("{{project-name}}", "drive-monitor").replace("{{bearing_watch}}", CHECKOUT);
        assert!(generated != filled && !filled.contains("{{"), "{filled}");
        assert_eq!(filled, template("Cargo.toml"));
    }
}
