//! `cargo xtask release`: everything that is published, made and tested without publishing it.
//!
//! ```text
//! packages      the crates for crates.io, each built alone from what its package has
//! c             the archive of the C library, and its ways into empty projects: archive, description, user
//! wheel         source distribution, the wheel that is built from it, and its way into an empty environment
//! sbom          bills of materials in the format of CycloneDX
//! interface     the public interface beside that of the last release
//! features      combinations of features on the host and on chips
//! oldest        lowest versions of the dependencies; lowest version of the compiler
//! dependencies  licences, sources, advisories
//! ```

mod archive;
mod arduino;
mod copy;
mod description;
mod dist;
mod features;
mod interface;
mod manifests;
mod notices;
mod oldest;
mod packages;
mod platformio;
mod riscv;
mod sbom;
mod user;
mod wheel;
mod zephyr;

use std::fs;
use std::process::Command;

use anyhow::Result;
use clap::ValueEnum;

use crate::stages::Stages;
use crate::tally::Tally;
use crate::toolchain::Way;
use crate::{child, dependencies, workspace};

/// What is released or checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// The crates for crates.io.
    Packages,
    /// The archive of the C library.
    C,
    /// Source distribution and wheel of the Python package.
    Wheel,
    /// Bills of materials.
    Sbom,
    /// The public interface, compared with that of the last release.
    Interface,
    /// Combinations of features.
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
    let parts = if options.parts.is_empty() { Part::value_variants() } else { &options.parts };
    for part in parts {
        let name = part.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
        stages.stage(&name, |tally| check(*part, tally, way, options.baseline.as_deref()));
    }
    let (table, sums) = dist::tables(&dist::folder()?)?;
    fs::write(dist::folder()?.join(dist::SUMS), sums)?;
    println!("\n{table}");
    if !child::output(Command::new("git").args(["status", "--porcelain"]).current_dir(workspace::root()))
        .is_some_and(|changes| changes.is_empty())
    {
        println!("not a release: the tree has changes that are not committed");
    }
    Ok(stages.end())
}

fn check(part: Part, tally: &mut Tally, way: Way, baseline: Option<&str>) {
    match part {
        Part::Packages => packages::checks(tally),
        Part::C => archive::checks(tally, way),
        Part::Wheel => wheel::checks(tally),
        Part::Sbom => sbom::checks(tally),
        Part::Interface => interface::checks(tally, baseline),
        Part::Features => features::checks(tally, way),
        Part::Oldest => oldest::checks(tally),
        Part::Dependencies => dependencies::checks(tally),
    }
}

/// The version of all packages.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The packages for crates.io.
pub const PUBLIC: [&str; 9] = [
    "bearing-watch",
    "bearing-watch-c",
    "bearing-watch-fleet",
    "bearing-watch-model",
    "bearing-watch-pages",
    "bearing-watch-rig",
    "bearing-watch-studies",
    "bearing-watch-traces",
    "bearing-watch-workbench",
];
