//! The archive as a library of PlatformIO: its own packer reads the manifest, and its own build makes the firmware.
//!
//! Its registry has the builder SCons and the compiler of a chip. In their places are SCons of pip and the compiler of
//! this machine, which the stand-ins in `c-api/tests/platformio` name.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use anyhow::{Context, Result, ensure};

use super::user::{self, Recorded};
use crate::newcomer::{Folder, blocks, copy, timed};
use crate::tally::Tally;
use crate::target::brief;
use crate::{child, python, workspace};

/// The versions of PlatformIO and of the builder that it asks for.
const PACKAGES: [&str; 2] = ["platformio==6.2.0", "scons==4.11.1"];
/// What it says where it cannot have the list of licences.
const NO_LICENCES: &str = "{'license': ['Could not load SPDX licenses for validation']}";
const STAND_INS: &str = "c-api/tests/platformio";
const PROJECT: &str = "platformio.ini";
/// The line of the project that the library needs of every platform.
const FLAGS: &str = "build_flags = -mfpu=fpv4-sp-d16 -mfloat-abi=hard\n";

/// Packs the archive, and builds a project with it.
pub fn checks(tally: &mut Tally, recorded: &Recorded) {
    let titles = ["the archive packed by PlatformIO", "the archive in a project of PlatformIO"];
    match python::with_packages("platformio", &PACKAGES) {
        Ok(python) => {
            tally.check(titles[0], brief(packed(&python)));
            tally.check(titles[1], brief(timed(|| firmware(&python, recorded))));
        }
        Err(reason) => titles.iter().for_each(|title| tally.missing(title, &format!("{reason:#}"))),
    }
}

/// Runs PlatformIO in a project; whether it succeeded, and what it said.
fn platformio(python: &Path, folder: &Folder, project: &Path, arguments: &[&str]) -> Result<(bool, String)> {
    let mut command = Command::new(python);
    command.args(["-m", "platformio"]).args(arguments).current_dir(project);
    command.env("PLATFORMIO_CORE_DIR", folder.path().join("core"));
    let Output { status, stdout, stderr } = child::captured(&mut command)?;
    Ok((status.success(), String::from_utf8_lossy(&[stdout, stderr].concat()).into_owned()))
}

/// The packer reads the manifest and takes the files.
fn packed(python: &Path) -> Result<&'static str> {
    let folder = Folder::new("platformio-pack")?;
    user::unpacked(folder.path())?;
    let pack = || platformio(python, &folder, folder.path(), &["pkg", "pack", user::UNPACKED]);
    let (packed, said) = pack()?;
    if packed {
        return Ok("");
    }
    ensure!(said.contains(NO_LICENCES), "{said}");
    // Of all fields, this one alone was not right: the others are checked without it.
    let manifest = folder.path().join(user::UNPACKED).join("library.json");
    let all = fs::read_to_string(&manifest)?;
    let others: Vec<&str> = all.lines().filter(|line| !line.trim_start().starts_with("\"license\"")).collect();
    ensure!(others.len() + 1 == all.lines().count(), "the manifest has no line with its licence");
    fs::write(manifest, others.join("\n"))?;
    let (packed, said) = pack()?;
    ensure!(packed, "{said}");
    Ok("its licence unchecked: no access to the list of licences")
}

/// The project of the document with the project file of the archive's document. Without the flags that the library
/// needs, the build must end with an error that names them.
fn firmware(python: &Path, recorded: &Recorded) -> Result<String> {
    let folder = Folder::new("platformio")?;
    stand_ins(folder.path())?;
    let blocks = user::unpacked(folder.path())?;
    let (archive, project) = (folder.path().join(user::UNPACKED), folder.path().join("project"));
    // As a project of PlatformIO has them; data and linker script are read where it runs.
    for (names, part) in [
        (["main.c", "board.c", "recorded_drive.c", "rows.s"].as_slice(), "src"),
        (&["board.h", "recorded_drive.h", "model/model.h"], "include"),
        (&["stm32f405.ld", "model/rows.bin"], ""),
    ] {
        fs::create_dir_all(project.join(part))?;
        for name in names {
            let name = Path::new(name);
            let file = name.file_name().context("no name")?;
            fs::copy(archive.join("firmware").join(name), project.join(part).join(file))?;
        }
    }
    let text = of_stand_in(&blocks::named(&blocks, PROJECT)?.text, folder.path())?;
    ensure!(text.contains(FLAGS), "{PROJECT} has no line {FLAGS}");
    fs::write(project.join(PROJECT), text.replace(FLAGS, ""))?;
    let build = || platformio(python, &folder, &project, &["run"]);
    let (built, said) = build()?;
    ensure!(!built && said.contains(&format!("needs {FLAGS}")), "without the flags: {said}");
    fs::write(project.join(PROJECT), text)?;
    let (built, said) = build()?;
    ensure!(built, "{said}");
    recorded.outcome(&project.join("src/main.c"), &project, ".pio/build/drive/program")
}

/// A core folder with the builder, and the platform.
fn stand_ins(folder: &Path) -> Result<()> {
    let from = workspace::root().join(STAND_INS);
    let tool = folder.join("core/packages/tool-scons");
    copy(&from.join("platform"), &folder.join("platform"))?;
    copy(&from.join("tool-scons"), &tool)?;
    // As PlatformIO notes which package it has installed.
    fs::rename(tool.join("piopm.json"), tool.join(".piopm"))?;
    Ok(())
}

/// The project file with the platform that stands in, and with the place of the archive.
fn of_stand_in(text: &str, folder: &Path) -> Result<String> {
    let place = |part: &str| format!("symlink://{}", folder.join(part).display());
    let line = |line: &str| match line.split_once(" = ").unwrap_or_default().0 {
        "platform" => Some(format!("platform = {}", place("platform"))),
        "board" => Some("board = drive".to_owned()),
        "framework" => None,
        "lib_deps" => Some(format!("lib_deps = {}", place(user::UNPACKED))),
        _ => Some(line.to_owned()),
    };
    let lines: Vec<String> = text.lines().filter_map(line).collect();
    ensure!(lines.len() + 1 == text.lines().count(), "{PROJECT} has no framework");
    Ok(lines.join("\n") + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_project_keeps_what_the_library_needs() -> Result<()> {
        let blocks = blocks::of_document(user::DOCUMENT)?;
        let text = of_stand_in(&blocks::named(&blocks, PROJECT)?.text, Path::new("/f"))?;
        let expected = format!(
            "[env:drive]\nplatform = symlink:///f/platform\nboard = drive\nlib_deps = symlink:///f/bearing-watch\n{FLAGS}"
        );
        assert_eq!(text, expected);
        Ok(())
    }
}
