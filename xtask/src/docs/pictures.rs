//! Pictures of documents: figures of the workbench's pages, drawn by Chromium and saved as SVG.

use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::block::{self, Block};
use crate::cargo::cargo;
use crate::child;
use crate::setup;
use crate::workspace::{root, target_dir};

/// The chapter that shows the pictures of the book, one of each kind of plot, and the block with the commands that make
/// their pages.
const CHAPTER: &str = "book/src/plots.md";
const COMMANDS: &str = "book";

/// Page, start of the figure's title, and picture of the book.
const PICTURES: [(&str, &str, &str); 15] = [
    ("audit", "Signals", "signals"),
    ("audit", "Amplitude of the current", "orders"),
    ("structure", "Free-run fit on the validation traces", "fit"),
    ("validate", "Output from the inputs alone", "free-run"),
    ("validate", "Cross-correlation of the residuals", "independence"),
    ("validate", "Autocorrelation of the residuals", "whiteness"),
    ("validate", "Poles and zeros", "poles"),
    ("validate", "Frequency response from u2", "frequency"),
    ("train", "Distribution of a1", "distribution"),
    ("train", "Features in the plane", "regions"),
    ("train", "Features over runs", "runs"),
    ("train", "Posterior of each segment", "posteriors"),
    ("train", "Posteriors beside what came true", "reliability"),
    ("replay", "Signals and verdicts", "verdicts"),
    ("replay", "Distance and evidence", "evidence"),
];

/// Runs the commands of the chapter, and saves the pictures; the block with the commands, as it is.
pub fn of_book() -> Result<Block> {
    let text = fs::read_to_string(root().join(CHAPTER))?;
    let mut commands = Block::new(CHAPTER, COMMANDS, "");
    commands.lines = block::find(&text, &commands)?;
    let folder = target_dir().join("book-pages");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    child::succeed(&mut cargo(&["build", "--release", "--quiet", "-p", "bearing-watch-workbench"]))?;
    let own = [target_dir().join("release")];
    let path = env::join_paths(own.into_iter().chain(env::split_paths(&child::search_path())))?;
    let shell = commands.lines.iter().filter(|line| !line.starts_with("```")).cloned().collect::<Vec<_>>().join("\n");
    // An audit that has found something ends with 1.
    let shell = shell.replace("audit.html", "audit.html || [ $? = 1 ]");
    child::succeed(Command::new("bash").args(["-e", "-c", &shell]).current_dir(&folder).env("PATH", path))?;
    for (page, title, name) in PICTURES {
        save(&folder.join(page).with_extension("html"), title, &format!("book/src/pictures/{name}.svg"))?;
    }
    // The traces take tens of megabytes.
    fs::remove_dir_all(&folder)?;
    Ok(commands)
}

/// Saves the first figure of a page whose title starts so.
pub fn save(page: &Path, title: &str, picture: &str) -> Result<()> {
    setup::ensure(&[&setup::BROWSER])?;
    let html = fs::read_to_string(page).with_context(|| format!("cannot read {}", page.display()))?;
    let figure = html.split("<figure>").find(|own| own.contains(&format!("<figcaption>{title}")));
    ensure!(figure.is_some(), "{} has no figure “{title}”", page.display());
    let script = include_str!("picture.html").replace("TITLE", &format!("{title:?}"));
    let copy = page.with_extension("picture.html");
    fs::write(&copy, html.replace("</body>", &format!("{script}</body>")))?;
    let mut command = Command::new(setup::browser()?);
    // Its own sandbox does not work for root; the page is ours.
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom"]);
    // A profile of its own: a browser does not start while another one with its profile ends.
    let profile = target_dir().join("chromium").join(Path::new(picture).file_stem().unwrap_or_default());
    command.arg(format!("--user-data-dir={}", profile.display()));
    let drawn = child::output(command.arg(format!("file://{}", copy.display())));
    // What a process of the browser still holds is removed next time.
    let _ = fs::remove_dir_all(&profile);
    let drawn = drawn.context("Chromium drew nothing")?;
    let shown = drawn.split("<pre id=\"picture\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let svg = shown.context("Chromium drew no picture")?;
    let svg = svg.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}").replace("&amp;", "&");
    fs::write(root().join(picture), svg + "\n").with_context(|| format!("cannot write {picture}"))
}

#[test]
fn every_picture_of_the_chapter_is_made_and_small() -> Result<()> {
    let chapter = fs::read_to_string(root().join(CHAPTER))?;
    assert_eq!(chapter.lines().filter(|line| line.contains("](pictures/")).count(), PICTURES.len());
    for (page, title, name) in PICTURES {
        assert!(chapter.contains(&format!("](pictures/{name}.svg)")), "{name} is not shown");
        assert!(chapter.contains(&format!("{page}.html")), "{title}");
        assert!(fs::metadata(root().join(format!("book/src/pictures/{name}.svg")))?.len() < 150_000, "{name} is large");
    }
    Ok(())
}
