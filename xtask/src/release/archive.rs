//! The archive of the C library: header, static libraries for the host and for the drive's chip, files for pkg-config
//! and CMake, examples.
//!
//! The same libraries give the same bytes: files are sorted and have no times and owners.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use flate2::{Compression, GzBuilder};

use super::description::{Library, Targets, cmake_config, cmake_version, pkg_config};
use super::{VERSION, dist, manifests, notices, riscv, user};
use crate::board::{DRIVE, RISCV};
use crate::newcomer::{Folder, blocks, c};
use crate::tally::Tally;
use crate::target::brief;
use crate::toolchain::Way;
use crate::{c_symbols, child, firmware, workspace};

const FILE: &str = "libbearing_watch_c.a";

/// Files of the repository, and their places in the archive.
const FILES: [(&str, &str); 12] = [
    ("CHANGELOG.md", "CHANGELOG.md"),
    ("LICENSE-APACHE", "LICENSE-APACHE"),
    ("LICENSE-MIT", "LICENSE-MIT"),
    ("c-api/ARCHIVE.md", "README.md"),
    ("c-api/README.md", "INTERFACE.md"),
    ("c-api/include/bearing_watch.h", "include/bearing_watch.h"),
    ("c-api/examples/BearingWatch/BearingWatch.ino", "examples/BearingWatch/BearingWatch.ino"),
    ("c-api/examples/print.h", "examples/print.h"),
    ("c-api/examples/records.c", "examples/records.c"),
    ("examples/support/standard_rig/held_out.bin", "examples/held_out.bin"),
    ("examples/support/standard_rig/model.h", "examples/BearingWatch/model.h"),
    ("examples/support/standard_rig/model.h", "examples/model.h"),
];

/// Makes the archive, and goes its ways into empty projects.
pub fn checks(tally: &mut Tally, way: Way) {
    let made = make(way);
    let there = made.is_ok();
    tally.check("archive of the C library", brief(made.map(|path| path.display().to_string())));
    if there {
        user::checks(tally);
        riscv::checks(tally);
    }
}

fn make(way: Way) -> Result<PathBuf> {
    let (host, system) = for_host()?;
    let mut parts = notices::files()?;
    for (from, to) in FILES {
        parts.push((to.to_owned(), fs::read(workspace::root().join(from)).with_context(|| from.to_owned())?));
    }
    parts.extend(project()?);
    let machine = workspace::host()?;
    let targets = Targets { host: &machine, chip: DRIVE.target, riscv: RISCV.target };
    let library = Library { version: VERSION, targets, system: &system };
    parts.push(("lib/pkgconfig/bearing-watch.pc".into(), pkg_config(&library).into()));
    let cmake = |name: &str| format!("lib/cmake/bearing-watch/bearing-watch-{name}.cmake");
    parts.push((cmake("config"), cmake_config(&library).into()));
    parts.push((cmake("config-version"), cmake_version(VERSION).into()));
    // Elsewhere the binary utilities are others.
    let host = if cfg!(target_os = "linux") { c_symbols::export(("", ""), &host)? } else { host };
    parts.push((format!("lib/{}/{FILE}", targets.host), stripped("strip", &host)?));
    let chip = firmware::build_c_library(way, DRIVE, "", "")?;
    let chip = stripped("arm-none-eabi-strip", &chip)?;
    let riscv = stripped("riscv64-unknown-elf-strip", &riscv::library(way)?)?;
    parts.push((format!("lib/{}/{FILE}", targets.riscv), riscv));
    // The Arduino IDE takes libraries and headers from folders of its own.
    let header = fs::read(workspace::root().join("c-api/include/bearing_watch.h"))?;
    parts.extend(manifests::ARDUINO.map(|folder| (format!("src/{folder}/{FILE}"), chip.clone())));
    parts.push(("src/bearing_watch.h".into(), header));
    parts.push((format!("lib/{}/{FILE}", targets.chip), chip));
    parts.extend(manifests::files(&library).into_iter().map(|(name, text)| (name, text.into_bytes())));
    dist::remove(&[ENDING])?;
    let path = dist::folder()?.join(format!("{NAME}-{VERSION}{ENDING}"));
    fs::write(&path, packed(parts)?)?;
    Ok(path)
}

/// Start and end of the archive's name.
pub const NAME: &str = "bearing-watch-c";
pub const ENDING: &str = ".tar.gz";

/// The project of the documents, with its recording, in `firmware/`.
fn project() -> Result<Vec<(String, Vec<u8>)>> {
    let folder = Folder::new("for-archive")?;
    c::write_project(folder.path(), &workspace::root())?;
    let blocks = blocks::of_document(user::DOCUMENT)?;
    for name in user::OF_FIRMWARE {
        // These take the place of those that use a checkout.
        blocks::write_named(&blocks, name, folder.path())?;
    }
    let names = c::FILES.iter().chain(&["main.c", "Makefile", "CMakeLists.txt"]).chain(&user::OF_FIRMWARE);
    let file = |name: &str| fs::read(folder.path().join(name)).with_context(|| format!("no {name}"));
    names.map(|name| Ok((format!("firmware/{name}"), file(name)?))).collect()
}

/// The library for this machine and any model, and what a program links with besides.
fn for_host() -> Result<(PathBuf, String)> {
    let target = workspace::target_dir().join("release-c");
    fs::create_dir_all(&target)?;
    let needs = target.join("native-static-libs.txt");
    let mut cargo = workspace::cargo(&["rustc", "--release", "--package", "bearing-watch-c", "--lib"]);
    cargo.args(["--crate-type", "staticlib", "--", "--print"]).arg(format!("native-static-libs={}", needs.display()));
    child::succeed(cargo.env("BEARING_WATCH_PLAN", "").env("CARGO_TARGET_DIR", &target))?;
    let system = fs::read_to_string(&needs).with_context(|| format!("no {}", needs.display()))?;
    // Each once; some are named again for each crate.
    let mut flags: Vec<&str> = Vec::new();
    for flag in system.split_whitespace() {
        ensure!(flag.starts_with("-l"), "unexpected {flag} in {system}");
        if !flags.contains(&flag) {
            flags.push(flag);
        }
    }
    Ok((target.join("release").join(FILE), flags.join(" ")))
}

/// A library without debugging information, which names folders of this machine.
fn stripped(program: &str, library: &Path) -> Result<Vec<u8>> {
    let copy = env::temp_dir().join(format!("bearing-watch-{}.a", std::process::id()));
    let mut strip = Command::new(program);
    let outcome = child::succeed(strip.args(["--strip-debug", "-D", "-o"]).arg(&copy).arg(library));
    let bytes = outcome.and_then(|()| Ok(fs::read(&copy)?));
    let _no_harm_if_it_stays = fs::remove_file(&copy);
    bytes
}

/// The archive with these files in one folder.
fn packed(mut parts: Vec<(String, Vec<u8>)>) -> Result<Vec<u8>> {
    parts.sort();
    let mut archive = tar::Builder::new(GzBuilder::new().write(Vec::new(), Compression::best()));
    for (name, bytes) in parts {
        let mut header = tar::Header::new_ustar();
        header.set_size(u64::try_from(bytes.len())?);
        header.set_mode(0o644);
        archive.append_data(&mut header, format!("{NAME}-{VERSION}/{name}"), bytes.as_slice())?;
    }
    Ok(archive.into_inner()?.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_archive_is_one_folder_in_order_and_always_the_same() -> Result<()> {
        let parts = || vec![("b".to_owned(), b"two".to_vec()), ("a/c".to_owned(), b"one".to_vec())];
        let bytes = packed(parts())?;
        assert_eq!(bytes, packed(parts().into_iter().rev().collect())?);
        let mut archive = tar::Archive::new(flate2::read::GzDecoder::new(bytes.as_slice()));
        let names =
            archive.entries()?.map(|entry| Ok(entry?.path()?.display().to_string())).collect::<Result<Vec<_>>>();
        assert_eq!(names?, [format!("{NAME}-{VERSION}/a/c"), format!("{NAME}-{VERSION}/b")]);
        Ok(())
    }

    #[test]
    fn every_packed_file_exists() {
        for (from, _) in FILES {
            assert!(workspace::root().join(from).is_file(), "{from}");
        }
    }
}
