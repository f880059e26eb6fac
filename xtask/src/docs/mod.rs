//! `cargo xtask docs`: writes the figures that the documents quote, or checks them.
//!
//! A document carries blocks between the lines `<!-- generated: cargo xtask docs NAME -->` and `<!-- end -->`. A
//! [`Source`] computes the lines of one or more blocks.

mod block;
mod compare;
mod template;

use std::fs;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::child;
use crate::cost::measure::{self, Figure};
use crate::cost::rivals;
use crate::firmware::way::Way;
use crate::python::with_packages;
use crate::workspace::{root, target_dir};
use crate::{cargo, setup};
use block::Block;

/// What computes blocks.
#[derive(Clone, Copy, Debug)]
enum Origin {
    /// A study, whose output is the block, and the start of the title of a figure on the page that it
    /// writes, of which a picture is saved; or nothing.
    Study(&'static str, &'static str),
    /// Tests of `host-tests` that print blocks: the program, and a part of their names.
    Tests(&'static str, &'static str),
    /// Cells of other documents. It follows every change of these documents, which are those of the named sources.
    Quotes(&'static str, &'static [&'static str]),
    /// Figures that firmware counts.
    Figures,
    Endurance,
    /// Kernels of the core beside those of others, on the emulated chip.
    Chip,
    /// A script of `xtask`, which prints the block.
    Script(&'static str),
}

/// A source: the argument of `cargo xtask docs`, its document, and what computes it.
type Source = (&'static str, &'static str, Origin);

use Origin::{Chip, Endurance, Figures, Quotes, Script, Study, Tests};

/// Sources that take seconds; others run by name only.
const QUICK: [&str; 7] = ["target", "demo", "instruments", "faults", "summary", "results", "needs"];

/// All sources, in the order in which they run.
#[rustfmt::skip]
const SOURCES: [Source; 27] = [
    ("target", "book/src/target.md", Figures),
    ("demo", "book/src/introduction.md", Tests("system", "standard_rig::twenty_draws")),
    ("instruments", "book/src/mathematics.md", Tests("system", "instruments_model::noise_in_the_field")),
    ("faults", "book/src/faults.md", Tests("core", "faults::table::faults_of_signals")),
    ("campaign", "docs/campaign.md", Study("campaign", "")),
    ("field", "docs/field.md", Study(
        "campaign --field --draws 2 --report target/field.html",
        "Detected records over the size of the defect (1 is full size), with 95 % intervals",
    )),
    ("field-default", "docs/field.md", Study("campaign --field --default --draws 2", "")),
    ("field-axes", "docs/field.md", Study("campaign --field --default --only axes --draws 5", "")),
    ("field-runs", "docs/field.md", Study(
        "campaign --field --default --only axis-cycle-steps,axis-any-cycle-steps,no-load-sensor --draws 1 \
         --together 12 --healthy 100 --defects 20",
        "",
    )),
    ("field-limits", "docs/field.md", Study("campaign --field --limits", "")),
    ("delay", "docs/alarm.md", Study("campaign --field --delay --draws 1", "")),
    ("lasting", "docs/alarm.md", Tests("system", "lasting::lasting_offsets_of")),
    ("growth", "docs/alarm.md", Study("campaign --field --growth --draws 1 --only field-sine", "")),
    ("ema", "docs/ema.md", Study("campaign --ema --draws 5", "")),
    ("ema-default", "docs/ema.md", Study("campaign --ema --default --draws 5", "")),
    ("tables", "docs/tables.md", Study(
        "tables --report target/park.html", "Figure 5.35: a healthy record with four angles of the Park transform",
    )),
    ("recorded", "docs/recorded.md", Tests("system", "recorded::")),
    ("endurance", "docs/endurance.md", Endurance),
    ("peers", "docs/peers.md", Script("peers/peers.sh")),
    ("reading", "docs/peers.md", Script("peers/reading.sh")),
    ("field-peers", "docs/peers.md", Script("peers/field.sh")),
    ("peers-on-target", "docs/peers.md", Chip),
    ("signature", "book/src/faults.md", Figures),
    ("book", "book/src/plots.md", Script("docs/book.sh")),
    // After those that they quote.
    ("summary", "book/src/introduction.md", Quotes(include_str!("../../docs/templates/summary.md"), &["campaign"])),
    ("results", "README.md", Quotes(include_str!("../../docs/templates/results.md"), &["campaign", "field", "recorded", "target"])),
    ("needs", "book/src/limits.md", Quotes(include_str!("../../docs/templates/needs.md"), &["field"])),
];

/// Templates of the tables of cost, with their documents.
const COST: [(&str, &str, &str); 4] = [
    ("target", "book/src/target.md", include_str!("../../docs/templates/target.md")),
    ("target-cycles", "book/src/target.md", include_str!("../../docs/templates/target-cycles.md")),
    ("target-interrupt", "book/src/target.md", include_str!("../../docs/templates/target-interrupt.md")),
    ("signature", "book/src/faults.md", include_str!("../../docs/templates/signature.md")),
];

/// How the paragraphs of the source's tables start that the document shows.
const SHOWN: [&str; 3] = ["Overview", "Table 4.1", "Figure 5.35"];

/// The same source gives the same counts with one compiler; other compilers differ by a few percent.
const OF_COUNTS: f64 = 0.05;

/// Writes or checks the blocks of the named sources; without a name, those of all sources that take seconds. Returns
/// whether all checked blocks agree.
pub fn run(names: &[String], check: bool, way: Option<Way>) -> Result<bool> {
    let known: Vec<&str> = SOURCES.iter().map(|source| source.0).collect();
    for name in names {
        ensure!(known.contains(&name.as_str()), "no block `{name}`; there are {}", known.join(", "));
    }
    let wanted = |(own, _, from): &&Source| match from {
        _ if names.is_empty() => QUICK.contains(own),
        Quotes(_, of) => names.iter().any(|name| name == own || of.contains(&name.as_str())),
        _ => names.iter().any(|name| name == own),
    };
    let mut agree = true;
    for (name, document, from) in SOURCES.iter().filter(wanted) {
        println!("{name}");
        let tolerance = match from {
            Figures | Chip => OF_COUNTS,
            // Measured times.
            _ if *document == "docs/peers.md" => 1.0,
            _ => 0.0,
        };
        for block in blocks(name, document, *from, way).with_context(|| format!("cargo xtask docs {name}"))? {
            if check {
                let difference = agrees(&block, tolerance).err();
                agree &= difference.is_none();
                difference.iter().for_each(|difference| println!("{difference:#}"));
            } else {
                let text = fs::read_to_string(root().join(block.file))?;
                fs::write(root().join(block.file), block::replace(&text, &block)?)?;
                println!("  {}: written", block.file);
            }
        }
    }
    Ok(agree)
}

fn blocks(name: &str, document: &'static str, from: Origin, way: Option<Way>) -> Result<Vec<Block>> {
    let single = |text: &str| Ok(vec![Block::new(document, name, text)]);
    match from {
        Study(command, picture) => {
            let program = "run --release --quiet --package bearing-watch-studies --";
            let mut cargo = cargo::cargo(&program.split(' ').chain(command.split(' ')).collect::<Vec<_>>());
            let lines = child::printed(&mut cargo)?;
            // The page is no part of the block.
            let lines: Vec<String> = lines.into_iter().filter(|line| !line.starts_with("Written: ")).collect();
            if let Some((_, page)) = command.split_once("--report ").filter(|_| !picture.is_empty()) {
                let svg = page.replace("target/", "docs/pictures/").replace(".html", ".svg");
                child::succeed(&mut script("docs/picture.sh", &[page, picture, &svg])?)?;
            }
            let text = lines.join("\n");
            let shown = |part: &&str| name != "tables" || SHOWN.iter().any(|start| part.starts_with(start));
            let text = text.split("\n\n").filter(shown).collect::<Vec<_>>().join("\n\n");
            single(&format!("```text\n{}\n```", text.trim_end()))
        }
        Tests(program, filter) => of_tests(name, document, program, filter),
        Quotes(template, _) => single(&template::filled(template, &[])?.join("\n")),
        Figures => {
            let way = Way::ready(way)?;
            let mut figures = measure::kernels(way)?;
            figures.extend(measure::any_data(way, &figures)?);
            of_figures(&figures)
        }
        Endurance => {
            let steps: String = (1..=10).map(|step| format!(" {step} |")).collect();
            let head = format!("| what | one step |{steps}\n|{}", "---|".repeat(12));
            single(&format!("{head}\n{}", cargo::measure_long()?.join("\n")))
        }
        Chip => single(&rivals::table(Way::ready(way)?)?),
        Script(name) => single(&child::printed(&mut script(name, &[])?)?.join("\n")),
    }
}

/// The tables of cost on the target.
fn of_figures(figures: &[Figure]) -> Result<Vec<Block>> {
    let block = |(name, file, template)| {
        Ok(Block { file, name: String::from(name), lines: template::filled(template, figures)? })
    };
    COST.into_iter().map(block).collect()
}

/// Checks the tables of cost against measured figures.
pub fn check_figures(figures: &[Figure]) -> Result<&'static str> {
    of_figures(figures)?.iter().try_for_each(|block| agrees(block, OF_COUNTS)).map(|()| "")
}

/// Fails with the file, the command and a short difference if the document does not agree.
fn agrees(block: &Block, tolerance: f64) -> Result<()> {
    let documented = block::find(&fs::read_to_string(root().join(block.file))?, block)?;
    let difference = compare::difference(&documented, &block.lines, tolerance);
    let Block { file, name, .. } = block;
    ensure!(difference.is_none(), "{file}: run `cargo xtask docs {name}`\n{}", difference.unwrap_or_default());
    Ok(())
}

/// A call of a script of `xtask`, with what it needs.
fn script(name: &str, arguments: &[&str]) -> Result<Command> {
    let mut script = Command::new("sh");
    script.arg(format!("xtask/{name}")).args(arguments).current_dir(root()).env("TARGET", target_dir());
    if name.starts_with("peers") {
        script.env("PYTHON", with_packages("peers", &["--requirement", "xtask/peers/requirements.txt"])?);
    } else {
        setup::ensure(&["chromium"])?;
    }
    Ok(script)
}

/// The blocks that tests print. A test fails where the document differs from what it prints, so its failure is no
/// obstacle, but all blocks of the document that belong to `name` must be printed.
fn of_tests(name: &str, file: &'static str, program: &str, filter: &str) -> Result<Vec<Block>> {
    let mut cargo = cargo::cargo(&["test", "--quiet", "--package", "host-tests", "--test", program, "--", filter]);
    let mut lines = Vec::new();
    child::lines(cargo.args(["--show-output", "--include-ignored"]), |line| lines.push(line.to_owned()))?;
    let blocks = block::all(&lines.join("\n"), file)?;
    for wanted in block::names(&fs::read_to_string(root().join(file))?)? {
        let found = !fills(name, wanted) || blocks.iter().any(|block| block.name == wanted);
        ensure!(found, "the tests `{filter}` printed no block `{wanted}`:\n{}", lines.join("\n"));
    }
    Ok(blocks)
}

/// Whether a block belongs to the source of this name: it has the same name, or one that continues it after a hyphen
/// and is not that of another source.
fn fills(source: &str, block: &str) -> bool {
    let rest = block.strip_prefix(source);
    rest == Some("") || rest.is_some_and(|rest| rest.starts_with('-')) && !SOURCES.iter().any(|other| other.0 == block)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_of_a_document_has_a_source_and_is_there_once() -> Result<()> {
        let mut files = vec![root().join("README.md")];
        for folder in ["docs", "book/src"] {
            for entry in root().join(folder).read_dir()? {
                files.push(entry?.path());
            }
        }
        let mut found = Vec::new();
        for file in files.iter().filter(|file| file.extension().is_some_and(|extension| extension == "md")) {
            let blocks = block::all(&fs::read_to_string(file)?, "").with_context(|| file.display().to_string())?;
            found.extend(blocks.into_iter().map(|block| block.name));
        }
        found.sort();
        assert!(found.windows(2).all(|pair| pair[0] != pair[1]), "a name occurs twice: {found:?}");
        for name in &found {
            assert!(SOURCES.iter().any(|source| fills(source.0, name)), "no source of `{name}`");
        }
        for (source, ..) in SOURCES {
            assert!(found.iter().any(|name| fills(source, name)), "no document has `{source}`");
        }
        Ok(())
    }

    #[test]
    fn quoted_tables_are_those_of_their_documents() -> Result<()> {
        for (name, document, from) in SOURCES.into_iter().filter(|source| matches!(source.2, Quotes(..))) {
            blocks(name, document, from, None)?.iter().try_for_each(|block| agrees(block, 0.0))?;
        }
        Ok(())
    }
}
