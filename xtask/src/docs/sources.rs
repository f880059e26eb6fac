//! What computes the blocks of the documents.

use anyhow::{Result, ensure};

use super::block::{self, Block};
use super::compare::Tolerance;
use super::{book, campaign, figures, picture, read, results, timing};
use crate::measure::Figure;
use crate::toolchain::{self, Way};
use crate::{child, field_peers, long, measure, peers, rivals, setup, workspace};

/// A command of the repository that prints blocks of documents.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// The argument of `cargo xtask docs`.
    pub name: &'static str,
    /// Whether it takes more than about a minute, so that it runs by name only.
    pub slow: bool,
    pub tolerance: Tolerance,
    pub blocks: fn(Option<Way>) -> Result<Vec<Block>>,
}

/// All sources, in the order in which they run.
pub const SOURCES: [Source; 25] = [
    quick(figures::NAME, figures::TOLERANCE, target),
    quick("demo", Tolerance::Exact, |_| {
        printed(("system", "demo"), "book/src/introduction.md", "standard_rig::twenty_draws")
    }),
    quick("instruments", Tolerance::Exact, |_| {
        printed(("system", "instruments"), "book/src/mathematics.md", "instruments_model::noise_in_the_field")
    }),
    quick("faults", Tolerance::Exact, |_| {
        printed(("core", "faults"), "book/src/faults.md", "fault_table::faults_of_signals")
    }),
    slow("campaign", Tolerance::Exact, |_| workbench("campaign", "campaign", campaign::DOCUMENT)),
    quick("summary", Tolerance::Exact, |_| Ok(vec![campaign::block(&read(campaign::DOCUMENT)?)?])),
    slow("field", Tolerance::Exact, |_| {
        let blocks = workbench(FIELD, "field", results::FIELD)?;
        save("field", "Detected records over the size of the defect (1 is full size), with 95 % intervals")
            .map(|()| blocks)
    }),
    slow("field-default", Tolerance::Exact, |_| {
        workbench("campaign --field --default --draws 2", "field-default", results::FIELD)
    }),
    slow("field-limits", Tolerance::Exact, |_| workbench("campaign --field --limits", "field-limits", results::FIELD)),
    slow("delay", Tolerance::Exact, |_| workbench("campaign --field --delay --draws 1", "delay", "docs/alarm.md")),
    slow("lasting", Tolerance::Exact, |_| {
        printed(("system", "lasting"), "docs/alarm.md", "lasting::lasting_offsets_of")
    }),
    slow("growth", Tolerance::Exact, |_| {
        workbench("campaign --field --growth --draws 1 --only field-sine", "growth", "docs/alarm.md")
    }),
    slow("field-peers", Tolerance::Any, |_| {
        Ok(vec![Block::new("docs/peers.md", "field-peers", &field_peers::measure(Some(field_peers::SHORT))?.0)])
    }),
    slow("ema", Tolerance::Exact, |_| workbench("campaign --ema --draws 5", "ema", "docs/ema.md")),
    slow("ema-default", Tolerance::Exact, |_| {
        workbench("campaign --ema --default --draws 5", "ema-default", "docs/ema.md")
    }),
    slow("tables", Tolerance::Exact, |_| {
        let mut blocks = workbench(TABLES, "tables", "docs/tables.md")?;
        blocks.iter_mut().for_each(shorten);
        save("park", "Figure 5.35: a healthy record with four angles of the Park transform").map(|()| blocks)
    }),
    slow("recorded", Tolerance::Exact, |_| printed(("system", "recorded"), results::RECORDED, "recorded_")),
    slow("endurance", Tolerance::Exact, |_| endurance()),
    slow("peers", Tolerance::Any, |_| Ok(vec![Block::new("docs/peers.md", "peers", &peers::measure()?.0)])),
    slow("reading", Tolerance::Any, |_| Ok(vec![Block::new("docs/peers.md", "reading", &peers::reading()?.0)])),
    slow("peers-on-target", figures::TOLERANCE, peers_on_target),
    slow("signature", figures::TOLERANCE, |way| {
        let figures = measure::signatures(ready(way)?)?;
        Ok(vec![Block::new(SAFETY, "signature", measure::rows(&figures).trim_end())])
    }),
    slow(book::NAME, Tolerance::Exact, |_| book::blocks()),
    // After those that it quotes.
    quick(results::NAME, Tolerance::Exact, |_| Ok(vec![quoted()?])),
    quick(results::NEEDS, Tolerance::Exact, |_| Ok(vec![results::needs(&read(results::FIELD)?)?])),
];

/// The document for those who assess a drive.
const SAFETY: &str = "book/src/faults.md";

/// The table of the field, and the page with its picture.
const FIELD: &str = "campaign --field --draws 2 --report target/field.html";

/// The source's tables, and the page with Figure 5.35.
const TABLES: &str = "tables --report target/park.html";

/// How the paragraphs of its output start that the document shows.
const SHOWN: [&str; 4] = ["```", "Overview", "Table 4.1", "Figure 5.35"];

/// Leaves the paragraphs of [`SHOWN`] in a block of fixed-width text.
fn shorten(block: &mut Block) {
    let text = block.lines.join("\n");
    let shown = text.split("\n\n").filter(|part| SHOWN.iter().any(|start| part.starts_with(start)));
    let text = shown.collect::<Vec<_>>().join("\n\n");
    block.lines = text.trim_end_matches("\n```").lines().chain(["```"]).map(str::to_owned).collect();
}

/// Saves a figure of the page of this name as the picture of this name.
fn save(name: &str, title: &str) -> Result<()> {
    let page = workspace::root().join("target").join(name).with_extension("html");
    picture::save(&page, title, &format!("docs/pictures/{name}.svg"))
}

type Blocks = fn(Option<Way>) -> Result<Vec<Block>>;

const fn quick(name: &'static str, tolerance: Tolerance, blocks: Blocks) -> Source {
    Source { name, slow: false, tolerance, blocks }
}

const fn slow(name: &'static str, tolerance: Tolerance, blocks: Blocks) -> Source {
    Source { name, slow: true, tolerance, blocks }
}

/// Whether a block belongs to the source of this name: it has the same name, or one that continues it after a hyphen
/// and is not that of another source.
pub fn fills(source: &str, block: &str) -> bool {
    match block.strip_prefix(source) {
        Some("") => true,
        Some(rest) => rest.starts_with('-') && !SOURCES.iter().any(|other| other.name == block),
        None => false,
    }
}

fn ready(way: Option<Way>) -> Result<Way> {
    let way = toolchain::choose(way)?;
    setup::ensure(&setup::firmware(way)?)?;
    Ok(way)
}

fn target(way: Option<Way>) -> Result<Vec<Block>> {
    let way = ready(way)?;
    let mut all = measure::kernels(way)?;
    all.extend(measure::any_data(way, &all)?);
    of_figures(&all)
}

/// The tables of cost on the target.
pub fn of_figures(figures: &[Figure]) -> Result<Vec<Block>> {
    let [calls, interrupt] = timing::blocks(figures)?;
    Ok(vec![figures::block(figures)?, calls, interrupt])
}

fn peers_on_target(way: Option<Way>) -> Result<Vec<Block>> {
    Ok(vec![Block::new("docs/peers.md", "peers-on-target", &rivals::table(ready(way)?)?)])
}

/// The table of results, from the documents as they stand.
pub fn quoted() -> Result<Block> {
    results::block(&results::Documents {
        campaign: read(campaign::DOCUMENT)?,
        field: read(results::FIELD)?,
        recorded: read(results::RECORDED)?,
        target: read(figures::DOCUMENT)?,
    })
}

/// The output of a study, as a block of fixed-width text.
fn workbench(command: &str, name: &str, file: &'static str) -> Result<Vec<Block>> {
    let program = ["run", "--release", "--quiet", "--package", "bearing-watch-studies"];
    let mut text = String::from("```text\n");
    let status = child::lines(workspace::cargo(&program).arg("--").args(command.split(' ')), |line| {
        // The page is no part of the block.
        if !line.starts_with("Written: ") {
            text += line;
            text.push('\n');
        }
    })?;
    ensure!(status.success(), "bearing-watch-studies {command}: {status}");
    Ok(vec![Block::new(file, name, &format!("{}\n```", text.trim_end()))])
}

/// The blocks that tests of the system print. A test fails where the document differs from what it prints, so its
/// failure is no obstacle, but all blocks of the document that belong to `name` must be printed.
fn printed((test, name): (&str, &str), file: &'static str, filter: &str) -> Result<Vec<Block>> {
    let mut cargo = workspace::cargo(&["test", "--quiet", "--package", "host-tests", "--test", test, "--"]);
    let mut lines = Vec::new();
    child::lines(cargo.args([filter, "--show-output", "--include-ignored"]), |line| lines.push(line.to_owned()))?;
    let blocks = block::printed(&lines, file);
    for wanted in block::names(&read(file)?)? {
        let own = fills(name, &wanted);
        let found = !own || blocks.iter().any(|block| block.name == wanted);
        ensure!(found, "the tests `{filter}` printed no block `{wanted}`:\n{}", lines.join("\n"));
    }
    Ok(blocks)
}

fn endurance() -> Result<Vec<Block>> {
    let (rows, passed) = long::measure()?;
    ensure!(passed, "a test failed");
    let steps: String = (1..=10).map(|step| format!(" {step} |")).collect();
    let head = format!("| what | one step |{steps}\n|{}", "---|".repeat(12));
    let rows = rows.join("\n");
    Ok(vec![Block::new("docs/endurance.md", "endurance", &format!("{head}\n{rows}"))])
}
