//! `cargo xtask docs`: writes the figures that the documents quote, or checks them.
//!
//! A document carries blocks between the lines `<!-- generated: cargo xtask docs NAME -->` and `<!-- end -->`. A
//! [`Source`] computes the lines of one or more blocks.

mod block;
mod book;
mod campaign;
mod compare;
mod figures;
mod picture;
mod results;
mod sources;
mod timing;

use std::fs;

use anyhow::{Context, Result, bail};

use crate::measure::Figure;
use crate::toolchain::Way;
use crate::workspace;
use block::Block;
use compare::Tolerance;
use sources::{SOURCES, Source};

/// Writes or checks the blocks of the named sources; without a name, those of all sources that take seconds. Returns
/// whether all checked blocks agree.
pub fn run(names: &[String], check: bool, way: Option<Way>) -> Result<bool> {
    let mut agree = true;
    for source in selected(names)? {
        println!("{}", source.name);
        for block in (source.blocks)(way).with_context(|| format!("cargo xtask docs {}", source.name))? {
            if !check {
                write(&block)?;
            } else if let Err(difference) = agrees(&block, source.tolerance) {
                println!("{difference}");
                agree = false;
            }
        }
    }
    Ok(agree)
}

/// Checks the tables of cost against measured figures.
pub fn check_figures(figures: &[Figure]) -> Result<&'static str, String> {
    let blocks = sources::of_figures(figures).map_err(|error| format!("{error:#}"))?;
    blocks.iter().try_for_each(|block| agrees(block, figures::TOLERANCE)).map(|()| "")
}

/// The sources to run. A table that quotes documents follows every change of these documents.
fn selected(names: &[String]) -> Result<Vec<&'static Source>> {
    for name in names {
        if !SOURCES.iter().any(|source| source.name == name) {
            let known: Vec<&str> = SOURCES.iter().map(|source| source.name).collect();
            bail!("no block `{name}`; there are {}", known.join(", "));
        }
    }
    let wanted = |source: &&Source| match names {
        [] => !source.slow,
        _ => {
            let quotes: &[&str] = match source.name {
                "summary" => &["campaign"],
                results::NAME => &results::SOURCES,
                results::NEEDS => &["field"],
                _ => &[],
            };
            names.iter().any(|name| source.name == name || quotes.contains(&name.as_str()))
        }
    };
    Ok(SOURCES.iter().filter(wanted).collect())
}

fn read(file: &str) -> Result<String> {
    fs::read_to_string(workspace::root().join(file)).with_context(|| format!("cannot read {file}"))
}

fn write(block: &Block) -> Result<()> {
    let text = read(block.file)?;
    let new = block::replace(&text, block)?;
    if new == text {
        println!("  {}: unchanged", block.file);
        return Ok(());
    }
    fs::write(workspace::root().join(block.file), new).with_context(|| format!("cannot write {}", block.file))?;
    println!("  {}: written", block.file);
    Ok(())
}

/// Returns the file, the command and a short difference if the document does not agree.
fn agrees(block: &Block, tolerance: Tolerance) -> Result<(), String> {
    let documented =
        read(block.file).and_then(|text| block::find(&text, block)).map_err(|error| format!("{error:#}"))?;
    compare::difference(&documented, &block.lines, tolerance).map_or(Ok(()), |difference| {
        Err(format!("{} differs; run `cargo xtask docs {}`\n{difference}", block.file, block.name))
    })
}

#[cfg(test)]
mod tests {
    use anyhow::ensure;

    use super::*;

    #[test]
    fn every_block_of_a_document_has_a_source_and_is_there_once() -> Result<()> {
        let mut files = vec![workspace::root().join("README.md")];
        for folder in ["docs", "book/src"] {
            for entry in workspace::root().join(folder).read_dir().with_context(|| format!("no folder `{folder}`"))? {
                files.push(entry?.path());
            }
        }
        files.retain(|file| file.extension().is_some_and(|extension| extension == "md"));
        let mut found = Vec::new();
        for file in files {
            let text = fs::read_to_string(&file)?;
            found.extend(block::names(&text).with_context(|| file.display().to_string())?);
        }
        let mut once = found.clone();
        once.sort();
        once.dedup();
        ensure!(once.len() == found.len(), "a name occurs twice: {found:?}");
        for name in &found {
            ensure!(SOURCES.iter().any(|source| sources::fills(source.name, name)), "no source of `{name}`");
        }
        for source in &SOURCES {
            ensure!(found.iter().any(|name| sources::fills(source.name, name)), "no document has `{}`", source.name);
        }
        Ok(())
    }

    #[test]
    fn quoted_tables_are_those_of_their_documents() -> Result<()> {
        let summary = campaign::block(&read(campaign::DOCUMENT)?)?;
        agrees(&summary, Tolerance::Exact).map_err(anyhow::Error::msg)?;
        agrees(&sources::quoted()?, Tolerance::Exact).map_err(anyhow::Error::msg)?;
        agrees(&results::needs(&read(results::FIELD)?)?, Tolerance::Exact).map_err(anyhow::Error::msg)
    }

    #[test]
    fn an_unknown_name_is_refused_and_the_campaign_brings_the_tables_that_quote_it() {
        assert!(selected(&["campain".to_owned()]).is_err());
        let names: Vec<&str> =
            selected(&["campaign".to_owned()]).unwrap_or_default().iter().map(|source| source.name).collect();
        assert_eq!(names, ["campaign", "summary", "results"]);
    }
}
