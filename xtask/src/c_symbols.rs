//! What the static library exports: the functions `bw_…` alone, so that a program which links it calls the functions of
//! its own C library, wherever that comes on the linker's command line.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use crate::{child, elf, workspace};

/// The name of the library that exports the interface only, beside the one that cargo makes.
const FILE: &str = "libbearing_watch.a";

/// Makes the library by the script that users call, with the binary utilities of a prefix and options of their linker.
pub fn export((prefix, options): (&str, &str), library: &Path) -> Result<PathBuf> {
    let made = library.with_file_name(FILE);
    let script = workspace::root().join("c-api/export.sh");
    let mut shell = Command::new("sh");
    shell.arg(script).arg(prefix).args([library, &made]).env("LD_FLAGS", options);
    child::succeed(&mut shell)?;
    Ok(made)
}

/// All global symbols are those of the interface.
pub fn check(library: &Path) -> Result<()> {
    let (functions, others): (Vec<_>, Vec<_>) =
        elf::global_symbols(library)?.into_iter().partition(|name| name.starts_with("bw_"));
    ensure!(functions.iter().any(|name| name == "bw_init"), "no bw_init among {functions:?}");
    ensure!(others.is_empty(), "it defines {}", others.join(", "));
    Ok(())
}
