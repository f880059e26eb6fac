//! `cargo xtask release`: everything that is published, made and tested without publishing it.

mod archive;
mod crates;
mod dist;
mod notices;
mod projects;
mod wheel;

use std::process::Command;

use anyhow::Result;
use clap::ValueEnum;

use crate::firmware::way::Way;
use crate::report::{Stages, Tally};
use crate::{child, test, workspace};

/// What is released or checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// The crates for crates.io, each built alone from what its package has.
    Packages,
    /// The archive of the C library, and its ways into empty projects.
    C,
    /// Source distribution and wheel of the Python package, and its way into an empty environment.
    Wheel,
    /// Bills of materials in the format of CycloneDX.
    Sbom,
    /// The public interface, compared with that of the last release.
    Interface,
    /// Combinations of features on the host and on chips.
    Features,
    /// Lowest versions of dependencies and compiler.
    Oldest,
    /// Licences, sources, advisories.
    Dependencies,
}

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Parts, instead of all.
    #[arg(value_enum)]
    parts: Vec<Part>,
    /// The revision with which the public interface is compared, instead of the last release.
    #[arg(long)]
    baseline: Option<String>,
}

/// Makes and checks the parts, prints the table of artefacts; whether nothing failed.
pub fn run(options: &Options, way: Way) -> Result<bool> {
    let mut stages = Stages::default();
    for part in if options.parts.is_empty() { Part::value_variants() } else { &options.parts } {
        let name = part.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
        stages.stage(&name, |tally| check(*part, tally, way, options.baseline.as_deref()));
    }
    println!("\n{}", dist::table()?);
    let status = child::output(Command::new("git").args(["status", "--porcelain"]).current_dir(workspace::root()));
    if !status.is_some_and(|changes| changes.is_empty()) {
        println!("not a release: the tree has changes that are not committed");
    }
    Ok(stages.end())
}

fn check(part: Part, tally: &mut Tally, way: Way, baseline: Option<&str>) {
    match part {
        Part::Packages => tally.check("packages, each built alone", crates::packages()),
        Part::C => {
            let made = archive::make(way);
            let there = made.is_ok();
            tally.check("archive of the C library", made.map(|path| path.display().to_string()));
            if there {
                projects::checks(tally);
            }
        }
        Part::Wheel => tally.check("source distribution, and its wheel in an empty environment", wheel::check()),
        Part::Sbom => crates::bills(tally),
        Part::Interface => crates::interface(tally, baseline),
        Part::Features => crates::features(tally, way),
        Part::Oldest => crates::oldest(tally),
        Part::Dependencies => test::dependencies(tally),
    }
}
