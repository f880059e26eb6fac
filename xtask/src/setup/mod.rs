//! Makes ready what builds of firmware, runs in the emulator and tests of pages need, without root and without touching
//! the system: what is installed in a sufficient version serves, and what is missing is fetched as Debian packages and
//! unpacked below the target directory.

mod apt;
mod need;
mod os;
pub mod script;
mod stanza;
pub mod unpacked;
mod version;

use anyhow::{Context, Result, bail, ensure};

use crate::board::DRIVE;
use crate::child;
use crate::toolchain::{self, Way};

pub use need::{
    BROWSER, C_COMPILER, CMAKE, COMPILER, EMULATOR, LLVM, LLVM_VERSION, MAKE, Need, PIP, PYTHON, RISCV, of_compiler,
    picolibc, pip,
};

/// What the tests need besides firmware.
pub const ALL: [&Need; 6] = [&C_COMPILER, &MAKE, &CMAKE, &BROWSER, &PYTHON, &PIP];

/// What building and running firmware this way need.
pub fn firmware(way: Way) -> Result<Vec<&'static Need>> {
    match way {
        // Left to the user: it changes their toolchain.
        Way::Rustup if !toolchain::rustup_target_installed(DRIVE.target) => {
            bail!("the target {} is not installed; run\n    {}", DRIVE.target, toolchain::rustup_command(DRIVE.target))
        }
        Way::Rustup => Ok(vec![&EMULATOR]),
        Way::Debian => Ok(vec![&COMPILER, &EMULATOR]),
    }
}

/// Returns when all of it is there. What cannot be had is an error before anything large is fetched.
pub fn ensure(needs: &[&'static Need]) -> Result<()> {
    let missing: Vec<&Need> = once(needs).into_iter().filter(|need| !is_ready(need)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let remedy = |need: &Need| format!("{} cannot be set up; remedy:\n    {}\nreason", need.title, need.remedy());
    if let Some(first) = missing.first().filter(|_| !child::on_path("apt-get")) {
        bail!("{}: it is not installed, and there is no apt-get to fetch it", remedy(first));
    }
    let _lock = unpacked::lock()?;
    // Another run may have done it meanwhile.
    let missing: Vec<&Need> = missing.into_iter().filter(|need| !is_ready(need)).collect();
    let Some(first) = missing.first() else { return Ok(()) };
    let apt = apt::Apt::new().with_context(|| remedy(first))?;
    let mut plans = Vec::new();
    for need in &missing {
        plans.push((*need, apt.plan(need.name, need.packages).with_context(|| remedy(need))?));
    }
    for (need, plan) in plans {
        unpack(&apt, need, &plan).with_context(|| remedy(need))?;
    }
    Ok(())
}

/// Each need once: several stages may have the same.
fn once(needs: &[&'static Need]) -> Vec<&'static Need> {
    let mut single: Vec<&Need> = Vec::new();
    for need in needs {
        if !single.iter().any(|own| own.name == need.name) {
            single.push(need);
        }
    }
    single
}

fn unpack(apt: &apt::Apt, need: &Need, plan: &apt::Plan) -> Result<()> {
    eprintln!("fetching {}: {plan}", need.title);
    let archives = apt.fetch(need.name, need.packages, plan)?;
    unpacked::unpack(need, &archives)?;
    apt.forget(need.name)?;
    ensure!(
        (need.serves)(&child::search_path()),
        "the packages of the system's sources are too old, or do not run with its libraries"
    );
    Ok(())
}

/// Whether an installed program serves, or one that was unpacked.
pub fn is_ready(need: &Need) -> bool {
    if (need.serves)(&child::path_of_the_system()) {
        unpacked::unlink(need);
        return true;
    }
    unpacked::is_complete(need) && unpacked::link(need).is_ok() && (need.serves)(&child::search_path())
}

/// The name of a Chromium that is there.
pub fn browser() -> Result<&'static str> {
    ensure(&[&BROWSER])?;
    need::browser(&child::search_path()).context("no Chromium on the search path")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_need_of_several_stages_is_fetched_once() {
        let needs = [&C_COMPILER, &PYTHON, &C_COMPILER, &MAKE, &PYTHON];
        let names: Vec<&str> = once(&needs).iter().map(|need| need.name).collect();
        assert_eq!(names, ["c-compiler", "python", "make"]);
    }
}
