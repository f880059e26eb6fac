//! Corpora: inputs of a door, kept as one archive each, and unpacked to attack with them.

use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use crate::{child, workspace};

/// Most bytes of the inputs of a kept corpus, before they are packed; the shortest go first.
const MOST_BYTES: u64 = 120_000;

/// A folder of the attacks in the target directory.
pub fn folder(name: &str) -> Result<PathBuf> {
    let folder = workspace::target_dir().join("attack").join(name);
    fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// The kept corpus of a door.
fn archive(door: &str) -> PathBuf {
    workspace::root().join("attack/corpus").join(format!("{door}.zip"))
}

/// Unpacks the kept corpus of a door beside what earlier runs have found; returns the folder.
pub fn unpack(door: &str) -> Result<PathBuf> {
    let (folder, path) = (folder(door)?, archive(door));
    if !path.exists() {
        return Ok(folder);
    }
    let mut archive = ZipArchive::new(File::open(&path)?).with_context(|| format!("{}", path.display()))?;
    for place in 0..archive.len() {
        let mut entry = archive.by_index(place)?;
        let Some(name) = entry.enclosed_name() else { continue };
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes)?;
        fs::write(folder.join(name), bytes)?;
    }
    Ok(folder)
}

/// Keeps the smallest corpus with the coverage of everything that was found.
pub fn keep(door: &str, program: &Path) -> Result<()> {
    let all = folder(door)?;
    let least = folder(&format!("{door}.least"))?;
    fs::remove_dir_all(&least)?;
    fs::create_dir_all(&least)?;
    let mut merge = Command::new(program);
    merge.env("ATTACK_DOOR", door).arg("-merge=1").arg(&least).arg(&all);
    let status = child::status(merge.stdout(Stdio::null()).stderr(Stdio::null()))?;
    ensure!(status.success(), "the corpora of {door} cannot be merged: {status}");
    let size = |entry: &fs::DirEntry| entry.metadata().map_or(0, |about| about.len());
    let mut files: Vec<fs::DirEntry> = fs::read_dir(&least)?.collect::<Result<_, _>>()?;
    files.sort_by_key(|entry| (size(entry), entry.file_name()));
    let path = archive(door);
    fs::create_dir_all(path.parent().context("a folder of corpora")?)?;
    let mut archive = ZipWriter::new(File::create(&path)?);
    let (mut count, mut bytes) = (0, 0);
    for entry in &files {
        bytes += size(entry);
        if bytes > MOST_BYTES {
            break;
        }
        archive.start_file(entry.file_name().to_string_lossy(), SimpleFileOptions::default())?;
        archive.write_all(&fs::read(entry.path())?)?;
        count += 1;
    }
    archive.finish()?;
    println!("{door}: kept {count} of {} inputs", files.len());
    Ok(())
}
