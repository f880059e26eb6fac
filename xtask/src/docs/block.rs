//! Blocks of a document between marker lines.

use anyhow::{Context, Result, bail, ensure};

const START: &str = "<!-- generated: cargo xtask docs ";
const CLOSE: &str = " -->";
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

/// The name in a start marker.
fn name(line: &str) -> Option<&str> {
    line.strip_prefix(START)?.strip_suffix(CLOSE)
}

/// Number of the start marker's line and of the end marker's line.
fn place(lines: &[&str], wanted: &str) -> Result<(usize, usize)> {
    let start = lines.iter().position(|line| name(line) == Some(wanted));
    let start = start.with_context(|| format!("no line `{START}{wanted}{CLOSE}`"))?;
    let rest = lines.iter().enumerate().skip(start + 1);
    let end = rest.into_iter().find(|(_, line)| **line == END || line.starts_with(START));
    match end {
        Some((end, line)) if *line == END => Ok((start, end)),
        _ => bail!("the block `{wanted}` has no line `{END}`"),
    }
}

/// The names of all blocks of a document.
pub fn names(text: &str) -> Result<Vec<String>> {
    let lines: Vec<&str> = text.lines().collect();
    let names: Vec<String> = lines.iter().filter_map(|line| name(line)).map(ToOwned::to_owned).collect();
    for name in &names {
        place(&lines, name)?;
    }
    ensure!(lines.iter().filter(|line| **line == END).count() == names.len(), "a line `{END}` without a start");
    Ok(names)
}

/// The lines of a block in a document.
pub fn find(text: &str, block: &Block) -> Result<Vec<String>> {
    let lines: Vec<&str> = text.lines().collect();
    let (start, end) = place(&lines, &block.name).with_context(|| block.file.to_owned())?;
    Ok(lines.get(start + 1..end).unwrap_or_default().iter().map(|line| (*line).to_owned()).collect())
}

/// The document with new lines in the block.
pub fn replace(text: &str, block: &Block) -> Result<String> {
    let lines: Vec<&str> = text.lines().collect();
    let (start, end) = place(&lines, &block.name).with_context(|| block.file.to_owned())?;
    let before = lines.iter().take(start + 1).copied();
    let new = before.chain(block.lines.iter().map(String::as_str)).chain(lines.iter().skip(end).copied());
    Ok(new.fold(String::new(), |text, line| text + line + "\n"))
}

/// The marked blocks that a program prints, for a document.
pub fn printed(lines: &[String], file: &'static str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut open = false;
    for line in lines {
        if let Some(name) = name(line) {
            blocks.push(Block { file, name: name.to_owned(), lines: Vec::new() });
            open = true;
        } else if line == END {
            open = false;
        } else if open && let Some(block) = blocks.last_mut() {
            block.lines.push(line.clone());
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a\n<!-- generated: cargo xtask docs one -->\nold\n<!-- end -->\nb\n";

    #[test]
    fn a_block_is_found_and_replaced() -> Result<()> {
        let block = Block::new("x.md", "one", "new\nlines");
        assert_eq!(find(TEXT, &block)?, ["old"]);
        let new = replace(TEXT, &block)?;
        assert_eq!(new, TEXT.replace("old", "new\nlines"));
        assert_eq!(find(&new, &block)?, block.lines);
        assert!(find(TEXT, &Block::new("x.md", "two", "")).is_err());
        assert!(
            find(&TEXT.replace("<!-- end -->\n", ""), &block).is_err() && names(&format!("{END}\n{TEXT}")).is_err()
        );
        let lines: Vec<String> = format!("noise\n{TEXT}more\n").lines().map(ToOwned::to_owned).collect();
        assert_eq!(printed(&lines, "x.md"), [Block::new("x.md", "one", "old")]);
        Ok(())
    }
}
