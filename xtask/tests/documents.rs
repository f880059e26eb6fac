//! Links of the documents lead somewhere, README is short, and the C code of the book compiles.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace").to_path_buf()
}

fn documents() -> Vec<(PathBuf, String)> {
    let folders = ["", "docs", "book/src", "c-api", "c-api/glue", "python", "template"];
    let entries = folders.iter().flat_map(|folder| fs::read_dir(root().join(folder)).expect("a folder"));
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let paths = paths.filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    paths.map(|path| (path.clone(), fs::read_to_string(path).expect("a text"))).collect()
}

#[test]
fn every_link_and_include_of_a_document_exists() {
    let mut broken = Vec::new();
    for (document, text) in documents() {
        let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        let includes = text.split("\n{{#include ").skip(1).filter_map(|rest| rest.split([':', '}']).next());
        for link in links.chain(includes) {
            let path = link.split('#').next().unwrap_or_default();
            if !link.contains("://") && !document.parent().expect("a folder").join(path).exists() {
                broken.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn the_readme_is_short_and_the_summary_of_the_book_is_whole() {
    let bytes = fs::metadata(root().join("README.md")).expect("a README").len();
    assert!(bytes <= 10_000, "README.md has {bytes} bytes; what does not fit belongs into the book");
    let read = |file: &str| fs::read_to_string(root().join(file)).expect("a text");
    let (summary, compiled) = (read("book/src/SUMMARY.md"), read("src/book.rs"));
    for (path, text) in documents().iter().filter(|(path, _)| path.starts_with(root().join("book/src"))) {
        let name = path.file_name().expect("a name").to_string_lossy();
        assert!(name == "SUMMARY.md" || summary.contains(&format!("]({name})")), "{name} is not in the summary");
        let is_compiled = compiled.contains(&format!("../book/src/{name}\""));
        assert_eq!(text.contains("```rust\n"), is_compiled, "{name}: code that no test compiles");
    }
}

#[test]
fn the_c_code_of_the_documents_compiles() {
    let code = [
        ("c-api/README.md", "sizes.c", ["-xc", "-std=c99"]),
        ("c-api/README.md", "sizes.c", ["-xc++", "-std=c++17"]),
        // For a drive with samples of its own, and the model of such a drive.
        ("c-api/README.md", "detector.c", ["-xc", "-std=c99"]),
    ];
    let compiles = |language: &[&str], file: &Path| {
        let mut compiler = Command::new("cc");
        compiler.args(["-fsyntax-only", "-Wall", "-Wextra", "-Werror"]).args(language).arg(file);
        for folder in ["c-api/include", "c-api/tests/chip", "examples/support/standard_rig"] {
            compiler.arg("-I").arg(root().join(folder));
        }
        compiler.stdin(Stdio::null()).status().is_ok_and(|status| status.success())
    };
    for (document, name, language) in code {
        let text = fs::read_to_string(root().join(document)).expect("a document");
        let block = text.split(&format!("<!-- {name} -->\n```c\n")).nth(1).and_then(|rest| rest.split("```").next());
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::write(&file, block.expect("C code")).expect("a file");
        // gcc without g++ knows no C++.
        if compiles(&language, Path::new("/dev/null")) {
            assert!(compiles(&language, &file), "{name} by {language:?}");
        } else {
            println!("skipped: cc does not compile {}", language[0]);
        }
    }
}
