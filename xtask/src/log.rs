//! Lines from `defmt`: firmware sends places of texts and raw values, and the texts are in its ELF file.

use std::fs;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, Result, bail};
use defmt_decoder::{DecodeError, Table};

/// The texts of an ELF file; nothing where it doesn't log by `defmt`.
pub fn table(elf: &Path) -> Result<Option<Table>> {
    let bytes = fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    Table::parse(&bytes).with_context(|| format!("{} has no readable defmt table", elf.display()))
}

/// Decodes a stream of frames; every frame is a line with its level.
pub fn split(mut stream: impl Read, table: &Table, mut each: impl FnMut(&str)) -> Result<()> {
    let mut decoder = table.new_stream_decoder();
    let mut bytes = [0; 1024];
    loop {
        let count = stream.read(&mut bytes)?;
        if count == 0 {
            return Ok(());
        }
        decoder.received(bytes.get(..count).unwrap_or_default());
        loop {
            match decoder.decode() {
                Ok(frame) => each(&frame.display(false).to_string()),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => bail!("a malformed defmt frame"),
            }
        }
    }
}

/// The classes that lines name after the word `verdict: `.
pub fn verdicts(lines: &[String]) -> Vec<&str> {
    lines.iter().filter_map(|line| line.split_once("verdict: ")).map(|(_, class)| class.trim()).collect()
}

/// Whether warnings tell of lost and saturated samples, and of the segment that a stuck sensor denied its verdict; or
/// what is missing.
pub fn refusals(lines: &[String]) -> Result<&'static str, String> {
    let warned = |pieces: &[&str]| {
        lines.iter().any(|line| line.contains("WARN") && pieces.iter().all(|piece| line.contains(piece)))
    };
    if !warned(&["samples refused: 5 rejected, 5 saturated"]) {
        Err("no warning of 5 lost and 5 saturated samples".to_owned())
    } else if !warned(&["no verdict: Stuck { channel: 0 }", "stuck: ChannelSet(1)"]) {
        Err("no warning of the stuck sensor".to_owned())
    } else {
        Ok("")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_are_found_behind_levels_and_numbers() {
        let lines = ["INFO sample 5000: verdict: spall", "verdict: healthy", "INFO Decision"].map(ToOwned::to_owned);
        assert_eq!(verdicts(&lines), ["spall", "healthy"]);
    }

    #[test]
    fn refusals_are_warnings() {
        let refused = "WARN samples refused: 5 rejected, 5 saturated".to_owned();
        let stuck = "WARN 2800 rows, Counts { stuck: ChannelSet(1) }, no verdict: Stuck { channel: 0 }".to_owned();
        assert!(refusals(&[refused.clone(), stuck.clone()]).is_ok());
        assert!(
            refusals(std::slice::from_ref(&refused)).is_err()
                && refusals(&[refused.replace("WARN", "INFO"), stuck]).is_err()
        );
    }

    #[test]
    fn a_program_without_defmt_has_no_table() -> Result<()> {
        // The test's own program stands for one.
        assert!(table(&std::env::current_exe()?)?.is_none());
        Ok(())
    }
}
