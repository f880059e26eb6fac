//! Lines from `defmt`: a program of its own decodes them, and what they say is read here.

use std::path::Path;
use std::process::{ChildStdout, Command, Stdio};

use anyhow::Result;

use crate::processes::Started;
use crate::{child, elf, workspace};

/// Returns a call of the decoder for the frames of this firmware; nothing where it doesn't log by `defmt`.
pub fn decoder(elf: &Path) -> Result<Option<Command>> {
    if !elf::has_section(elf, ".defmt")? {
        return Ok(None);
    }
    let mut decoder = workspace::program("log-decoder")?;
    decoder.arg(std::path::absolute(elf)?);
    Ok(Some(decoder))
}

/// Starts it behind a program that sends frames.
pub fn decode(decoder: &mut Command, frames: ChildStdout) -> Result<Started> {
    child::start(decoder.stdin(frames).stdout(Stdio::piped()))
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
}
