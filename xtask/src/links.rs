//! Links, includes, and paths in the documents: each leads somewhere.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

use crate::workspace;

/// Folders with documents, and documents in the root.
const FOLDERS: [&str; 6] = ["docs", "book/src", "c-api", "c-api/glue", "python", "template"];
const ROOT: [&str; 5] = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"];
/// A piece of code that starts so is a path of the repository.
const PATHS: [&str; 14] = [
    "docs/",
    "book/",
    "src/",
    "workbench/",
    "host-tests/",
    "xtask/",
    "c-api/",
    "python/",
    "examples/",
    "target-tests/",
    "template/",
    "boards/",
    "frameworks/",
    ".github/",
];

fn documents() -> Result<Vec<PathBuf>> {
    let root = workspace::root();
    let mut files: Vec<PathBuf> = ROOT.iter().map(|name| root.join(name)).collect();
    for folder in FOLDERS {
        for entry in root.join(folder).read_dir().with_context(|| format!("no folder {folder}"))? {
            files.push(entry?.path());
        }
    }
    files.retain(|file| file.extension().is_some_and(|extension| extension == "md"));
    Ok(files)
}

/// The identifiers of a document's headings, as GitHub and mdBook make them.
fn headings(text: &str) -> Vec<String> {
    let (mut headings, mut open) = (Vec::new(), None);
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Heading { .. }) => open = Some(String::new()),
            Event::End(TagEnd::Heading(_)) => headings.extend(open.take()),
            Event::Text(own) | Event::Code(own) => {
                if let Some(heading) = &mut open {
                    heading.extend(own.chars().filter_map(identifier));
                }
            }
            _ => {}
        }
    }
    headings
}

/// A character of a heading in its identifier.
fn identifier(own: char) -> Option<char> {
    match own {
        ' ' => Some('-'),
        '-' | '_' => Some(own),
        _ => own.is_alphanumeric().then(|| own.to_lowercase().next().unwrap_or(own)),
    }
}

/// Why a link of a document leads nowhere.
fn broken(file: &Path, link: &str) -> Option<String> {
    if link.starts_with("https://") || link.starts_with("http://") {
        return None;
    }
    let (path, heading) = link.split_once('#').unwrap_or((link, ""));
    let folder = file.parent().unwrap_or(file);
    let target = if path.is_empty() { file.to_path_buf() } else { folder.join(path) };
    let Ok(target) = target.canonicalize() else { return Some(format!("{link}: no such file")) };
    let book = workspace::root().join("book/src").canonicalize().unwrap_or_default();
    if folder.ends_with("book/src") && !target.starts_with(book) {
        return Some(format!("{link}: mdBook follows no link out of the book"));
    }
    if heading.is_empty() {
        return None;
    }
    let text = fs::read_to_string(&target).unwrap_or_default();
    (!headings(&text).iter().any(|own| own == heading)).then(|| format!("{link}: no such heading"))
}

/// Why a line `{{#include file:anchor}}` includes nothing.
fn not_included(file: &Path, line: &str) -> Option<String> {
    let path = line.trim().strip_prefix("{{#include ")?.strip_suffix("}}")?;
    let (path, anchor) = path.split_once(':').unwrap_or((path, ""));
    let Ok(text) = fs::read_to_string(file.parent().unwrap_or(file).join(path)) else {
        return Some(format!("{line}: no such file"));
    };
    let marked = |what: &str| text.matches(&format!("{what}: {anchor} ")).count() == 1;
    let found = anchor.is_empty() || marked("ANCHOR") && marked("ANCHOR_END");
    (!found).then(|| format!("{line}: no such anchor"))
}

/// Whether a piece of code that is a path of the repository, or of a crate made from the template, does not exist.
fn is_missing(file: &Path, code: &str) -> bool {
    let plain = |own: char| own.is_ascii_alphanumeric() || "/._-".contains(own);
    // Capitals stand for a name: `boards/NAME/memory.x`.
    let placeholder = code.split('/').any(|part| part.len() > 1 && part.chars().all(|own| own.is_ascii_uppercase()));
    if !PATHS.iter().any(|start| code.starts_with(start)) || !code.chars().all(plain) || placeholder {
        return false;
    }
    let root = workspace::root();
    let bases = [file.parent().unwrap_or(file).to_path_buf(), root.join("template"), root];
    !bases.iter().any(|base| base.join(code).exists())
}

fn problems(file: &Path, text: &str) -> Vec<String> {
    let mut found: Vec<String> = text.lines().filter_map(|line| not_included(file, line)).collect();
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                found.extend(broken(file, &dest_url));
            }
            Event::Code(code) if is_missing(file, &code) => found.push(format!("`{code}`: no such file")),
            _ => {}
        }
    }
    found
}

/// What a reader takes in before he decides to use the library.
const README_BYTES: u64 = 10_000;

#[test]
fn the_readme_is_short() -> Result<()> {
    let bytes = fs::metadata(workspace::root().join("README.md"))?.len();
    assert!(bytes <= README_BYTES, "README.md has {bytes} bytes; what does not fit belongs into the book");
    Ok(())
}

#[test]
fn every_link_include_and_path_of_a_document_exists() -> Result<()> {
    let mut all = Vec::new();
    for file in documents()? {
        let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        all.extend(problems(&file, &text).into_iter().map(|own| format!("{}: {own}", file.display())));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
    Ok(())
}

#[test]
fn what_leads_nowhere_is_found() {
    let file = workspace::root().join("book/src/introduction.md");
    let text = "# One, two: `x`\n[a](limits.md) [b](#one-two-x) [c](none.md) [d](limits.md#none) [e](../../README.md)\n\n\
                {{#include ../../README.md:none}}\n{{#include none.rs}}\n`docs/none.md` `docs/field.md` `src/a b`\n";
    let found = problems(&file, text);
    assert_eq!(found.len(), 7, "{found:?}");
    // A heading of the file itself is looked for in the file as it is stored.
    assert!(found.iter().any(|own| own.starts_with("#one-two-x")));
    assert_eq!(headings(text), ["one-two-x"]);
}
