//! Blocks of a document between marker lines.

use anyhow::{Context, Result, ensure};

const START: &str = "<!-- generated: cargo xtask docs ";
const CLOSE: &str = " -->\n";
const END: &str = "<!-- end -->";

/// The lines of one block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// The document, relative to the workspace's root.
    pub file: &'static str,
    pub name: String,
    pub lines: Vec<String>,
}

impl Block {
    /// A block with the lines of a text.
    pub fn new(file: &'static str, name: &str, text: &str) -> Self {
        Self { file, name: name.to_owned(), lines: text.lines().map(ToOwned::to_owned).collect() }
    }
}

/// A text before the lines of a block, these lines, and what follows them.
fn parts<'t>(text: &'t str, name: &str) -> Result<[&'t str; 3]> {
    let start = format!("{START}{name}{CLOSE}");
    let at = text.find(&start).with_context(|| format!("no line `{}`", start.trim_end()))? + start.len();
    let (before, rest) = text.split_at(at);
    let end = rest.find(END).filter(|end| !rest[..*end].contains(START));
    let (lines, after) = rest.split_at(end.with_context(|| format!("the block `{name}` has no line `{END}`"))?);
    Ok([before, lines, after])
}

/// The names of all blocks of a document.
pub fn names(text: &str) -> Result<Vec<&str>> {
    let names: Vec<&str> = text.split(START).skip(1).filter_map(|rest| Some(rest.split_once(CLOSE)?.0)).collect();
    names.iter().try_for_each(|name| parts(text, name).map(|_| ()))?;
    ensure!(text.matches(END).count() == names.len(), "a line `{END}` without a start");
    Ok(names)
}

/// The blocks of a document, or of what a program prints for one.
pub fn all(text: &str, file: &'static str) -> Result<Vec<Block>> {
    names(text)?.into_iter().map(|name| Ok(Block::new(file, name, parts(text, name)?[1]))).collect()
}

/// The lines of a block in a document.
pub fn find(text: &str, block: &Block) -> Result<Vec<String>> {
    let [_, lines, _] = parts(text, &block.name).with_context(|| block.file.to_owned())?;
    Ok(lines.lines().map(ToOwned::to_owned).collect())
}

/// The document with new lines in the block.
pub fn replace(text: &str, block: &Block) -> Result<String> {
    let [before, _, after] = parts(text, &block.name).with_context(|| block.file.to_owned())?;
    Ok(format!("{before}{}\n{after}", block.lines.join("\n")))
}

#[test]
fn a_block_is_found_and_replaced() -> Result<()> {
    let text = "a\n<!-- generated: cargo xtask docs one -->\nold\n<!-- end -->\nb\n";
    assert_eq!(all(text, "x.md")?, [Block::new("x.md", "one", "old")]);
    let block = Block::new("x.md", "one", "new\nlines");
    let new = replace(text, &block)?;
    assert_eq!((new.as_str(), find(&new, &block)?), (&*text.replace("old", "new\nlines"), block.lines));
    assert!(find(text, &Block::new("x.md", "two", "")).is_err());
    assert!(names(&text.replace("<!-- end -->\n", "")).is_err() && names(&format!("{END}\n{text}")).is_err());
    Ok(())
}
