//! Unpacked packages: a folder for each need, with a script for each program.

use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use super::need::Need;
use super::{os, script};
use crate::{child, workspace};

/// Written last: the packages and the place, which the scripts contain.
const COMPLETE: &str = "complete";

/// The folder of all that is set up.
pub fn folder() -> PathBuf {
    workspace::target_dir().join("tools/debian")
}

/// The unpacked packages of a need.
pub fn root(need: &Need) -> PathBuf {
    folder().join(need.name)
}

/// The folder on the search path, with the programs that are called by name.
pub fn programs() -> PathBuf {
    folder().join("bin")
}

/// The script of a program.
pub fn program(need: &Need, name: &str) -> PathBuf {
    root(need).join("bin").join(name)
}

/// Held by the process that unpacks; another one waits.
pub fn lock() -> Result<File> {
    let path = folder().join("lock");
    fs::create_dir_all(folder()).with_context(|| folder().display().to_string())?;
    let file = File::create(&path).with_context(|| path.display().to_string())?;
    if file.try_lock().is_err() {
        eprintln!("waiting for the set-up of another run");
        file.lock()?;
    }
    Ok(file)
}

/// Counts the ways of unpacking: packages that were unpacked another way are unpacked again.
const WAY: u32 = 2;

fn stamp(need: &Need) -> String {
    format!("{WAY}\n{}\n{}\n", need.packages.join(" "), root(need).display())
}

/// Whether the packages are unpacked, all of them and here.
pub fn is_complete(need: &Need) -> bool {
    fs::read_to_string(root(need).join(COMPLETE)).is_ok_and(|text| text == stamp(need))
}

/// Puts the programs on the search path, where they go before those of the system.
pub fn link(need: &Need) -> Result<()> {
    if !need.by_name {
        return Ok(());
    }
    fs::create_dir_all(programs())?;
    for name in names(need)? {
        let link = programs().join(&name);
        // Another run may do the same.
        if !link.is_symlink() {
            let _ = os::link(&Path::new("..").join(need.name).join("bin").join(&name), &link);
        }
    }
    Ok(())
}

/// Takes them off the search path.
pub fn unlink(need: &Need) {
    for name in names(need).unwrap_or_default() {
        // Another run may have done it.
        let _ = fs::remove_file(programs().join(name));
    }
}

fn names(need: &Need) -> Result<Vec<OsString>> {
    root(need).join("bin").read_dir()?.map(|entry| Ok(entry?.file_name())).collect()
}

/// Unpacks Debian packages; until all is done, under another name.
pub fn unpack(need: &Need, archives: &[PathBuf]) -> Result<()> {
    let part = folder().join(format!("{}.part", need.name));
    for old in [&part, &root(need)] {
        if old.exists() {
            fs::remove_dir_all(old)?;
        }
    }
    fs::create_dir_all(part.join("bin"))?;
    for archive in archives {
        child::succeed(Command::new("dpkg-deb").arg("--extract").arg(archive).arg(&part))?;
    }
    for (link, target) in need.links {
        os::link(Path::new(target), &part.join(link))?;
    }
    let mut libraries = Vec::new();
    tidy(&part, &part, &mut libraries)?;
    let specs = part.join("usr/lib/arm-none-eabi/newlib");
    if specs.is_dir() {
        lead_to(&root(need), &specs)?;
    }
    libraries.sort();
    write_scripts(need, &part, &script::settings(need, &part, &libraries)?)?;
    fs::write(part.join(COMPLETE), stamp(need))?;
    fs::rename(&part, root(need))?;
    link(need)
}

/// A script for each program.
fn write_scripts(need: &Need, part: &Path, settings: &str) -> Result<()> {
    for program in need.programs {
        for place in matching(part, program)? {
            let (script, program) =
                (part.join("bin").join(place.file_name().unwrap_or_default()), root(need).join(&place));
            if place.ends_with("bin/rustc") {
                script::write_compiler(&script, &program, settings, &root(need).join("usr"))?;
            } else {
                script::write(&script, &program, settings)?;
            }
        }
    }
    Ok(())
}

/// Lets absolute links lead to what is unpacked, and finds the folders of shared libraries.
fn tidy(root: &Path, folder: &Path, libraries: &mut Vec<PathBuf>) -> Result<()> {
    for entry in folder.read_dir()? {
        let path = entry?.path();
        if path.is_symlink() {
            let target = fs::read_link(&path)?;
            let below = target.strip_prefix("/").ok().map(|rest| root.join(rest));
            if let Some(below) = below.filter(|below| below.exists()) {
                fs::remove_file(&path)?;
                os::link(&relative(root, &path, &below), &path)?;
            }
        } else if path.is_dir() {
            tidy(root, &path, libraries)?;
            continue;
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let own = folder.strip_prefix(root)?;
        if name.starts_with("lib") && name.contains(".so") && !libraries.iter().any(|known| known == own) {
            libraries.push(own.to_path_buf());
        }
    }
    Ok(())
}

/// Lets the descriptions of C libraries, which name folders of the system, lead to those of this root.
fn lead_to(root: &Path, folder: &Path) -> Result<()> {
    for entry in folder.read_dir()? {
        let path = entry?.path();
        if path.is_dir() {
            lead_to(root, &path)?;
        } else if path.extension().is_some_and(|extension| extension == "specs") {
            let text = fs::read_to_string(&path)?;
            fs::write(&path, text.replace(" /usr/", &format!(" {}/usr/", root.display())))?;
        }
    }
    Ok(())
}

/// The way from a link to a file, both below the root: the whole can be moved.
fn relative(root: &Path, link: &Path, target: &Path) -> PathBuf {
    let up = link.strip_prefix(root).map_or(0, |own| own.components().count().saturating_sub(1));
    let mut way = PathBuf::from("../".repeat(up));
    way.push(target.strip_prefix(root).unwrap_or(target));
    way
}

/// Files at a place; a `*` at its end stands for any end.
fn matching(root: &Path, place: &str) -> Result<Vec<PathBuf>> {
    let place = Path::new(place);
    let name = place.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let Some(start) = name.strip_suffix('*') else { return Ok(vec![place.to_path_buf()]) };
    let folder = place.parent().unwrap_or(place);
    let names = root.join(folder).read_dir().with_context(|| format!("no {} is unpacked", folder.display()))?;
    let names = names.map(|entry| Ok(entry?.file_name())).collect::<Result<Vec<_>>>()?;
    Ok(names.iter().filter(|own| own.to_string_lossy().starts_with(start)).map(|own| folder.join(own)).collect())
}

/// A folder for a test.
#[cfg(test)]
pub fn folder_for(name: &str) -> Result<PathBuf> {
    let folder = workspace::target_dir().join("tests").join(format!("{name}-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    Ok(folder)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn absolute_links_lead_into_the_folder_and_libraries_are_found() -> Result<()> {
        let root = folder_for("tidy")?;
        for folder in ["usr/lib/a/b", "usr/src/x"] {
            fs::create_dir_all(root.join(folder))?;
        }
        fs::write(root.join("usr/lib/a/b/libz.so.1"), "")?;
        fs::write(root.join("usr/src/x/file"), "text")?;
        os::link(Path::new("/usr/src/x"), &root.join("usr/lib/link"))?;
        os::link(Path::new("/usr/bin/env"), &root.join("usr/lib/of-the-system"))?;
        let mut libraries = Vec::new();
        tidy(&root, &root, &mut libraries)?;
        assert_eq!(libraries, [Path::new("usr/lib/a/b")]);
        assert_eq!(fs::read_to_string(root.join("usr/lib/link/file"))?, "text");
        assert_eq!(fs::read_link(root.join("usr/lib/link"))?, Path::new("../../usr/src/x"));
        assert_eq!(fs::read_link(root.join("usr/lib/of-the-system"))?, Path::new("/usr/bin/env"));
        fs::remove_dir_all(root)?;
        Ok(())
    }

    #[test]
    fn ends_of_names_match() -> Result<()> {
        let root = folder_for("matching")?;
        for name in ["arm-gcc", "arm-ld", "other"] {
            fs::write(root.join(name), "")?;
        }
        assert_eq!(matching(&root, "arm-*")?.len(), 2);
        assert_eq!(matching(&root, "other")?, [Path::new("other")]);
        assert!(matching(&root, "none/x*").is_err());
        fs::remove_dir_all(root)?;
        Ok(())
    }
}
