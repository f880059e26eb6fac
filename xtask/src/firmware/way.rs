//! Two ways to a compiler for the drive's chip, and the choice between them.

use std::env;
use std::fmt;
use std::path::Path;

use anyhow::{Result, bail};
use clap::ValueEnum;

use super::board::DRIVE;
use crate::cargo::sysroot;
use crate::child;
use crate::setup;

/// Names the way where no argument does.
const VARIABLE: &str = "BEARING_WATCH_FIRMWARE";

/// How firmware is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Way {
    /// The user's own toolchain, with the target's library installed by rustup.
    Rustup,
    /// Debian's packages: compiler, library source (core is built with the firmware) and linker.
    Debian,
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Self::Rustup { "rustup" } else { "debian" })
    }
}

impl Way {
    /// The way that was asked for, else the one the environment names, else one that is installed, else one that can
    /// be.
    fn choose(asked: Option<Self>, target: &str) -> Result<Self> {
        let named = env::var(VARIABLE).ok().filter(|name| !name.is_empty());
        match (asked, named) {
            (Some(way), _) => Ok(way),
            (None, Some(name)) => Self::from_str(&name, true).map_err(|error| anyhow::anyhow!("{VARIABLE}: {error}")),
            (None, None) if Self::Rustup.hindrance(target).is_none() => Ok(Self::Rustup),
            (None, None) if child::on_path("apt-get") || setup::is_ready("compiler") => Ok(Self::Debian),
            (None, None) => {
                bail!("no compiler for {target}; run\n    rustup target add {target}")
            }
        }
    }

    /// The same way, when what building and running firmware needs is there.
    pub fn ready(asked: Option<Self>) -> Result<Self> {
        Self::ready_for(asked, DRIVE.target, [&["qemu"], &["compiler", "qemu"]])
    }

    /// The same for another target, with what this needs by rustup's way and by Debian's.
    pub fn ready_for(asked: Option<Self>, target: &str, [rustup, debian]: [&[&str]; 2]) -> Result<Self> {
        let way = Self::choose(asked, target)?;
        if let Some(hindrance) = way.hindrance(target) {
            // Left to the user: it changes their toolchain.
            bail!("the target {target} is not installed; {hindrance}");
        }
        setup::ensure(if way == Self::Rustup { rustup } else { debian })?;
        Ok(way)
    }

    /// Why this way can't build for a target at present; nothing where it can. The target's library is looked for in
    /// the file system, because rustup's own commands may start to download.
    pub fn hindrance(self, target: &str) -> Option<String> {
        let library = |sysroot: String| Path::new(&sysroot).join("lib/rustlib").join(target).join("lib");
        let installed = || sysroot().is_some_and(|sysroot| library(sysroot).is_dir());
        (self == Self::Rustup && !installed()).then(|| format!("run rustup target add {target}"))
    }
}
