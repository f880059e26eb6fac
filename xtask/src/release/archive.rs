//! The archive of the C library: header, static libraries for the host and for chips, the project of the documents, and
//! the files of `c-api/package`, by which pkg-config, CMake, Zephyr, PlatformIO, the Arduino IDE, CMSIS packs and ESP-IDF
//! take the unpacked archive.
//!
//! The same libraries give the same bytes: files are sorted and have no times and owners.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use flate2::{Compression, GzBuilder};

use super::dist::{self, VERSION};
use super::notices;
use crate::cargo::{cargo, files, rustc};
use crate::firmware::board::{Board, DRIVE, RISCV};
use crate::firmware::build::{c_library, export};
use crate::firmware::elf;
use crate::firmware::way::Way;
use crate::test::newcomer::blocks::Blocks;
use crate::test::newcomer::{self, Folder};
use crate::workspace::{root, target_dir};
use crate::{child, setup};

/// Start and end of the archive's name.
pub const NAME: &str = "bearing-watch-c";
pub const ENDING: &str = ".tar.gz";
/// The document of the archive, and its files that go into a project of firmware.
pub const DOCUMENT: &str = "c-api/ARCHIVE.md";
const OF_FIRMWARE: [&str; 2] = ["bearing_watch.mk", "cubemx.cmake"];

const LIBRARY: &str = "libbearing_watch_c.a";
/// Files of the archive that are copied with replaced words.
const PACKAGE: &str = "c-api/package/";

/// Files of the repository, and their places in the archive.
const FILES: [(&str, &str); 13] = [
    ("CHANGELOG.md", "CHANGELOG.md"),
    ("LICENSE-APACHE", "LICENSE-APACHE"),
    ("LICENSE-MIT", "LICENSE-MIT"),
    ("c-api/ARCHIVE.md", "README.md"),
    ("c-api/README.md", "INTERFACE.md"),
    ("c-api/include/bearing_watch.h", "include/bearing_watch.h"),
    ("c-api/include/bearing_watch.h", "src/bearing_watch.h"),
    ("c-api/examples/BearingWatch/BearingWatch.ino", "examples/BearingWatch/BearingWatch.ino"),
    ("c-api/examples/print.h", "examples/print.h"),
    ("c-api/examples/records.c", "examples/records.c"),
    ("examples/support/standard_rig/held_out.bin", "examples/held_out.bin"),
    ("examples/support/standard_rig/model.h", "examples/BearingWatch/model.h"),
    ("examples/support/standard_rig/model.h", "examples/model.h"),
];

/// Makes the archive.
pub fn make(way: Way) -> Result<PathBuf> {
    setup::ensure(&[&setup::C_COMPILER, &setup::MAKE, &setup::CMAKE, &setup::RISCV])?;
    let (machine, _) = rustc()?;
    let (host, system) = for_host()?;
    let mut parts = notices::files()?;
    for (from, to) in FILES {
        parts.push((to.to_owned(), fs::read(root().join(from)).with_context(|| from.to_owned())?));
    }
    parts.extend(project()?);
    parts.extend(package(&machine, &system)?);
    // Elsewhere the binary utilities are others.
    let host = if cfg!(target_os = "linux") { export("", "", &host)? } else { host };
    let (chip, riscv) = (for_chip(way, DRIVE, "arm-none-eabi-")?, for_chip(way, RISCV, "riscv64-unknown-elf-")?);
    parts.push((format!("lib/{machine}/{LIBRARY}"), stripped("strip", &host)?));
    parts.push((format!("lib/{}/{LIBRARY}", RISCV.target), riscv));
    // The Arduino IDE takes libraries from folders of its own, by the names of cores and units.
    for folder in ["src/cortex-m4/fpv4-sp-d16-hard", "src/cortex-m7/fpv5-sp-d16-hard", &format!("lib/{}", DRIVE.target)]
    {
        parts.push((format!("{folder}/{LIBRARY}"), chip.clone()));
    }
    dist::remove(NAME, ENDING)?;
    let path = dist::folder()?.join(format!("{NAME}-{VERSION}{ENDING}"));
    fs::write(&path, packed(parts)?)?;
    Ok(path)
}

/// The files of [`PACKAGE`] with version, targets, and what a program for the host links with besides.
fn package(host: &str, system: &str) -> Result<Vec<(String, Vec<u8>)>> {
    let numbers: Vec<&str> = VERSION.split('.').collect();
    let words = [
        ("@VERSION@", VERSION),
        ("@MAJOR@", numbers[0]),
        ("@MINOR@", numbers[1]),
        ("@HOST@", host),
        ("@PROCESSOR@", host.split('-').next().unwrap_or_default()),
        ("@CHIP@", DRIVE.target),
        ("@RISCV@", RISCV.target),
        ("@SYSTEM@", system),
    ];
    let mut parts = Vec::new();
    for file in files()? {
        let Some(name) = file.strip_prefix(PACKAGE) else { continue };
        let text = fs::read_to_string(root().join(&file))?;
        let text = words.iter().fold(text, |text, (word, value)| text.replace(word, value));
        ensure!(!text.contains('@'), "{file} has a word that is not replaced");
        parts.push((name.to_owned(), text.into_bytes()));
    }
    Ok(parts)
}

/// The project of the documents, with its recording, in `firmware/`.
fn project() -> Result<Vec<(String, Vec<u8>)>> {
    let folder = Folder::new("for-archive")?;
    newcomer::write_project(folder.path(), &root())?;
    // These take the place of those that use a checkout.
    Blocks::of_document(DOCUMENT)?.write(Some(&OF_FIRMWARE), folder.path(), &root())?;
    let names = newcomer::FILES.iter().chain(&["main.c", "Makefile", "CMakeLists.txt"]).chain(&OF_FIRMWARE);
    let file = |name: &str| fs::read(folder.path().join(name)).with_context(|| format!("no {name}"));
    names.map(|name| Ok((format!("firmware/{name}"), file(name)?))).collect()
}

/// The library for this machine and any model, and what a program links with besides.
fn for_host() -> Result<(PathBuf, String)> {
    let target = target_dir().join("release-c");
    fs::create_dir_all(&target)?;
    let needs = target.join("native-static-libs.txt");
    let mut cargo = cargo(&["rustc", "--release", "--package", "bearing-watch-c", "--lib"]);
    cargo.args(["--crate-type", "staticlib", "--", "--print"]).arg(format!("native-static-libs={}", needs.display()));
    child::succeed(cargo.env("BEARING_WATCH_PLAN", "").env("CARGO_TARGET_DIR", &target))?;
    let system = fs::read_to_string(&needs).with_context(|| format!("no {}", needs.display()))?;
    // Each once; some are named again for each crate.
    let mut flags: Vec<&str> = Vec::new();
    for flag in system.split_whitespace() {
        ensure!(flag.starts_with("-l"), "unexpected {flag} in {system}");
        flags.extend((!flags.contains(&flag)).then_some(flag));
    }
    Ok((target.join("release").join(LIBRARY), flags.join(" ")))
}

/// The library for a chip and any model.
fn for_chip(way: Way, board: Board, utilities: &str) -> Result<Vec<u8>> {
    if let Some(hindrance) = way.hindrance(board.target) {
        bail!("{hindrance}");
    }
    let library = c_library((way, board), "", "", &[])?;
    elf::ensure_exports(&library)?;
    stripped(&format!("{utilities}strip"), &library)
}

/// A library without debugging information, which names folders of this machine.
fn stripped(program: &str, library: &Path) -> Result<Vec<u8>> {
    let copy = env::temp_dir().join(format!("bearing-watch-{}.a", std::process::id()));
    child::succeed(Command::new(program).args(["--strip-debug", "-D", "-o"]).arg(&copy).arg(library))?;
    let bytes = fs::read(&copy)?;
    fs::remove_file(&copy)?;
    Ok(bytes)
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

#[test]
fn every_packed_file_exists_and_all_words_are_replaced() -> Result<()> {
    assert!(FILES.iter().all(|(from, _)| root().join(from).is_file()));
    assert!(package("x86_64-unknown-linux-gnu", "-lm -lc")?.len() > 10);
    Ok(())
}
