//! Frames of `defmt` from standard input become lines on standard output, each with its level. Firmware sends places of
//! texts and raw values; the texts are in its ELF file, the only argument.

use std::env;
use std::fs;
use std::io::{self, Read, Write};

use anyhow::{Context, Result, bail};
use defmt_decoder::{DecodeError, Table};

fn main() -> Result<()> {
    let elf = env::args_os().nth(1).context("usage: log-decoder ELF")?;
    let bytes = fs::read(&elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let table = Table::parse(&bytes)?.with_context(|| format!("{} does not log by defmt", elf.display()))?;
    decode(io::stdin(), &table, io::stdout())
}

fn decode(mut frames: impl Read, table: &Table, mut lines: impl Write) -> Result<()> {
    let mut decoder = table.new_stream_decoder();
    let mut bytes = [0; 1024];
    loop {
        let count = frames.read(&mut bytes)?;
        if count == 0 {
            return Ok(());
        }
        decoder.received(bytes.get(..count).unwrap_or_default());
        loop {
            match decoder.decode() {
                Ok(frame) => writeln!(lines, "{}", frame.display(false))?,
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => bail!("a malformed defmt frame"),
            }
        }
    }
}
