//! The artefacts of a release: files of `target/dist`, and their table.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use sha2::{Digest, Sha256};

use crate::workspace;

/// The folder of artefacts.
pub fn folder() -> Result<PathBuf> {
    let folder = workspace::target_dir().join("dist");
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    Ok(folder)
}

/// Removes artefacts of earlier runs whose names end so.
pub fn remove(endings: &[&str]) -> Result<()> {
    for file in files(&folder()?)? {
        if endings.iter().any(|ending| file.to_string_lossy().ends_with(ending)) {
            fs::remove_file(&file)?;
        }
    }
    Ok(())
}

/// The one artefact whose name starts and ends so.
pub fn find(start: &str, end: &str) -> Result<PathBuf> {
    let name = |file: &PathBuf| file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut found = files(&folder()?)?;
    found.retain(|file| name(file).starts_with(start) && name(file).ends_with(end));
    found.pop().with_context(|| format!("there is no {start}…{end} in target/dist"))
}

/// Name, bytes and SHA-256 of all files of a folder, as a table and as the lines of `sha256sum`.
pub fn tables(folder: &Path) -> Result<(String, String)> {
    let (mut table, mut sums) = (format!("{:64} {:>10}  {}\n", "artefact", "bytes", "sha256"), String::new());
    for file in files(folder)? {
        let bytes = fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        let _string_grows = writeln!(table, "{name:64} {:>10}  {hash}", bytes.len());
        let _string_grows = writeln!(sums, "{hash}  {name}");
    }
    Ok((table, sums))
}

/// The files of a folder but the list of their sums, sorted.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in folder.read_dir().with_context(|| format!("no folder {}", folder.display()))? {
        let path = entry?.path();
        if path.is_file() && !path.ends_with(SUMS) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// The file of sums, which `sha256sum --check` reads.
pub const SUMS: &str = "SHA256SUMS";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_bytes_and_sum_of_each_file() -> Result<()> {
        let folder = std::env::temp_dir().join(format!("bearing-watch-dist-{}", std::process::id()));
        fs::create_dir_all(&folder)?;
        fs::write(folder.join("b.txt"), "abc")?;
        fs::write(folder.join("a.txt"), "")?;
        fs::write(folder.join(SUMS), "no artefact")?;
        let (table, sums) = tables(&folder)?;
        fs::remove_dir_all(&folder)?;
        // The test vectors of FIPS 180-2.
        let (empty, abc) = ("e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855", "ba7816bf8f01cfea");
        assert!(sums.starts_with(&format!("{empty}  a.txt\n{abc}")) && sums.ends_with("  b.txt\n"), "{sums}");
        let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[2][..2], ["b.txt", "3"]);
        Ok(())
    }
}
