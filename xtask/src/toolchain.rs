//! Two ways to a compiler for the drive's chip, and the choice between them.

use std::env;
use std::fmt;
use std::path::Path;
use std::process::Command;

use anyhow::{Result, bail};
use clap::ValueEnum;

use crate::board::DRIVE;
use crate::{child, setup};

/// Names the way where no argument does.
pub const VARIABLE: &str = "BEARING_WATCH_FIRMWARE";

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
        f.write_str(match self {
            Self::Rustup => "rustup",
            Self::Debian => "debian",
        })
    }
}

/// The way that was asked for, else the one the environment names, else one that is installed,
/// else one that can be.
pub fn choose(asked: Option<Way>) -> Result<Way> {
    let named = env::var(VARIABLE).ok().filter(|name| !name.is_empty());
    let forced = match (asked, named) {
        (Some(way), _) => Some(way),
        (None, Some(name)) => Some(parse(&name)?),
        (None, None) => None,
    };
    decide(forced, rustup_target_installed(DRIVE.target), debian_possible())
}

/// Whether the Debian way is there or can be set up.
fn debian_possible() -> bool {
    child::on_path("apt-get") || setup::is_ready(&setup::COMPILER)
}

fn parse(name: &str) -> Result<Way> {
    match Way::from_str(name, true) {
        Ok(way) => Ok(way),
        Err(_) => bail!("{VARIABLE}={name} is neither `rustup` nor `debian`"),
    }
}

fn decide(forced: Option<Way>, target_installed: bool, debian_possible: bool) -> Result<Way> {
    match (forced, target_installed, debian_possible) {
        (Some(way), _, _) => Ok(way),
        (None, true, _) => Ok(Way::Rustup),
        (None, false, true) => Ok(Way::Debian),
        (None, false, false) => {
            bail!("no compiler library for {}; install it by\n    {}", DRIVE.target, rustup_command(DRIVE.target))
        }
    }
}

/// Whether the compiler at hand has a target's library. It is looked for in the file system,
/// because rustup's own commands may start to download.
pub fn rustup_target_installed(target: &str) -> bool {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    child::output(Command::new(rustc).args(["--print", "sysroot"]))
        .is_some_and(|sysroot| Path::new(&sysroot).join("lib/rustlib").join(target).join("lib").is_dir())
}

/// What a user of rustup runs once.
pub fn rustup_command(target: &str) -> String {
    format!("rustup target add {target}")
}

/// Why this way can't build for a target at present; nothing where it can.
pub fn hindrance(way: Way, target: &str) -> Option<String> {
    (way == Way::Rustup && !rustup_target_installed(target)).then(|| format!("run {}", rustup_command(target)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_installed_target_is_preferred_and_force_wins() {
        assert_eq!(decide(None, true, true).ok(), Some(Way::Rustup));
        assert_eq!(decide(None, false, true).ok(), Some(Way::Debian));
        assert_eq!(decide(Some(Way::Debian), true, true).ok(), Some(Way::Debian));
        assert_eq!(decide(Some(Way::Rustup), false, true).ok(), Some(Way::Rustup));
    }

    #[test]
    fn without_a_way_the_error_tells_the_command() {
        let text = decide(None, false, false).err().map(|e| e.to_string());
        assert!(text.is_some_and(|t| t.contains("rustup target add thumbv7em-none-eabihf")));
    }

    #[test]
    fn a_target_that_is_not_installed_hinders_rustup_only() {
        let text = hindrance(Way::Rustup, "thumbv0-none-eabi");
        assert_eq!(text.as_deref(), Some("run rustup target add thumbv0-none-eabi"));
        assert_eq!(hindrance(Way::Debian, "thumbv0-none-eabi"), None);
    }

    #[test]
    fn an_unknown_way_is_refused() {
        assert_eq!(parse("Debian").ok(), Some(Way::Debian));
        assert!(parse("nix").is_err());
    }
}
