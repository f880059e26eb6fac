//! `cargo xtask book`: builds the book with mdBook.

use std::path::PathBuf;

use anyhow::Result;

use crate::tools::MDBOOK;
use crate::{child, workspace};

/// Builds the book, and returns its first page.
pub fn build() -> Result<PathBuf> {
    let folder = workspace::target_dir().join("book");
    let mut command = MDBOOK.command(&["build", "--dest-dir"])?;
    command.arg(&folder).arg(workspace::root().join("book"));
    child::succeed(&mut command)?;
    Ok(folder.join("index.html"))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::process::Command;

    use super::*;

    fn chapter(name: &str) -> Result<String> {
        Ok(fs::read_to_string(workspace::root().join("book/src").join(name))?)
    }

    /// Names of the files of this kind in the folder.
    fn files(folder: &str, extension: &str) -> Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in workspace::root().join(folder).read_dir()? {
            let path = entry?.path();
            if path.extension().is_some_and(|own| own == extension) {
                names.extend(path.file_name().map(|name| name.to_string_lossy().into_owned()));
            }
        }
        Ok(names)
    }

    #[test]
    fn the_summary_has_every_chapter() -> Result<()> {
        let summary = chapter("SUMMARY.md")?;
        for name in files("book/src", "md")?.iter().filter(|name| *name != "SUMMARY.md") {
            assert_eq!(summary.matches(&format!("]({name})")).count(), 1, "{name}");
        }
        Ok(())
    }

    #[test]
    fn the_code_of_every_chapter_is_compiled() -> Result<()> {
        let compiled = fs::read_to_string(workspace::root().join("src/book.rs"))?;
        for name in files("book/src", "md")? {
            let has_code = chapter(&name)?.contains("```rust\n");
            assert_eq!(has_code, compiled.contains(&format!("../book/src/{name}\"")), "{name}");
        }
        Ok(())
    }

    #[test]
    fn pictures_are_small_and_shown() -> Result<()> {
        let chapters: Result<String> = files("book/src", "md")?.iter().map(|name| chapter(name)).collect();
        let chapters = chapters?;
        let mut total = 0;
        for name in files("book/src/pictures", "svg")? {
            let bytes = fs::metadata(workspace::root().join("book/src/pictures").join(&name))?.len();
            assert!(bytes < 150_000, "{name} has {bytes} bytes");
            assert!(chapters.contains(&format!("](pictures/{name})")), "{name} is in no chapter");
            total += bytes;
        }
        assert!(total < 1_500_000, "{total} bytes");
        Ok(())
    }

    #[test]
    fn code_that_is_not_compiled_is_that_of_a_file() -> Result<()> {
        for name in files("book/src", "md")? {
            for block in chapter(&name)?.split("```rust,ignore\n").skip(1) {
                let lines = block.lines().take_while(|line| *line != "```");
                assert!(lines.into_iter().all(|line| line.starts_with("{{#include ")), "{name}: {block}");
            }
        }
        Ok(())
    }

    #[test]
    fn the_c_code_compiles_as_c_and_as_cpp() -> Result<()> {
        if !child::on_path("cc") {
            println!("skipped: no C compiler on the search path");
            return Ok(());
        }
        let text = fs::read_to_string(workspace::root().join("c-api/README.md"))?;
        let block = text.split("<!-- sizes.c -->\n```c\n").nth(1).and_then(|rest| rest.split("```").next());
        let file = workspace::target_dir().join("sizes.c");
        fs::write(&file, block.unwrap_or("no C code"))?;
        for language in [["-xc", "-std=c99"], ["-xc++", "-std=c++17"]] {
            // gcc without g++ knows no C++.
            let mut empty = Command::new("cc");
            if language[0] == "-xc++" && !child::works(empty.args(["-fsyntax-only", "-xc++", "/dev/null"])) {
                println!("skipped: cc compiles no C++");
                continue;
            }
            let mut compiler = Command::new("cc");
            compiler.args(["-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]).args(language).arg(&file);
            for folder in ["c-api/include", "examples/support/standard_rig"] {
                compiler.arg("-I").arg(workspace::root().join(folder));
            }
            child::succeed(&mut compiler)?;
        }
        Ok(())
    }
}
