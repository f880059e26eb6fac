//! Blocks of the book and docs that tests compute: `cargo xtask docs` fills them from what the tests print.

use std::path::Path;

use studies::campaign::render::grid_cells;

/// The text of a document, by its path from the workspace's root.
///
/// # Panics
/// If the document cannot be read.
#[must_use]
pub fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Prints a table with the markers of its block, and requires that the document has the same lines.
///
/// # Panics
/// If the document does not have this block.
pub fn check(file: &str, name: &str, rows: Vec<Vec<String>>) {
    check_all(file, &[(name, rows)]);
}

/// [`check`] of several blocks; all are printed before a difference fails the test.
///
/// # Panics
/// If the document does not have one of the blocks.
pub fn check_all(file: &str, blocks: &[(&str, Vec<Vec<String>>)]) {
    let written = blocks.iter().map(|(name, rows)| {
        format!("<!-- generated: cargo xtask docs {name} -->\n{}\n<!-- end -->\n", table(rows).join("\n"))
    });
    let written: Vec<String> = written.collect();
    written.iter().for_each(|block| println!("{block}"));
    let document = text(file);
    for ((name, _), block) in blocks.iter().zip(&written) {
        let command = name.split('-').next().unwrap_or(name);
        assert!(document.contains(block), "{file} differs; run `cargo xtask docs {command}`");
    }
}

/// A table in Markdown; the first row has the headings.
fn table(rows: &[Vec<String>]) -> Vec<String> {
    let line = |row: &Vec<String>| format!("| {} |", row.join(" | ")).replace("|  |", "| |").replace("|  |", "| |");
    let mut lines: Vec<String> = rows.iter().map(line).collect();
    let columns = rows.first().map_or(0, Vec::len);
    lines.insert(1.min(lines.len()), format!("|{}", "---|".repeat(columns)));
    lines
}

/// The rows of the table whose title starts so, in fixed-width text of a document; an empty line ends a table.
#[must_use]
pub fn rows<'d>(document: &'d str, title: &str) -> Vec<Vec<&'d str>> {
    let lines = document.lines().skip_while(|line| !line.starts_with(title));
    let lines = lines.take_while(|line| !line.is_empty() && !line.starts_with("```"));
    lines.filter(|line| line.starts_with("  ")).map(grid_cells).collect()
}
