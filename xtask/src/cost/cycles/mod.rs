//! Cycles of a Cortex-M4F, estimated from a trace of the emulator.
//!
//! A program runs twice. In the first run the emulator logs every block of instructions, and the model of [`pipeline`]
//! adds the cycles of what the counter of the firmware encloses (`examples/support/count.rs`). In the second run the
//! counter takes these numbers instead of its own, and the program prints means and largest ones of cycles under the
//! names that it has for instructions.

mod flash;
mod instruction;
mod pipeline;
mod trace;

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use self::instruction::Instruction;
use self::pipeline::Pipeline;
use self::trace::Trace;
use crate::firmware::board::Board;
use crate::firmware::qemu;
use crate::workspace;

/// Wait states of the flash: none, as for code in RAM, and those of an STM32F405 at 168 MHz.
pub const WAIT_STATES: [u64; 2] = [0, 5];

/// The file that the counter of the firmware reads.
const GIVEN: &str = "counts.bin";

/// Instructions, and cycles for each of [`WAIT_STATES`].
type Counts<T> = [T; 1 + WAIT_STATES.len()];

/// Runs a program that reads no other files. Returns the lines that it prints by itself, and those with the counts of
/// the trace in the place of its own.
pub fn lines(elf: &Path, board: Board) -> Result<(Vec<String>, Counts<Vec<String>>)> {
    let folder = &workspace::target_dir().join("cycles");
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let given = folder.join(GIVEN);
    // Left there by a run that was ended, it would replace the counts.
    let _none_there = fs::remove_file(&given);
    let (mut trace, mut recorder) = (Trace::default(), Recorder::default());
    let lines = qemu::trace(folder, elf, board, &mut |line| trace.line(line, |executed| recorder.execute(executed)))?;
    ensure!(recorder.open.is_none(), "a batch has no end");
    ensure!(!recorder.batches[0].is_empty(), "{} counts nothing", elf.display());
    let mut again = Counts::<Vec<String>>::default();
    for (lines, counts) in again.iter_mut().zip(recorder.batches) {
        fs::write(&given, counts.iter().flat_map(|count| count.to_le_bytes()).collect::<Vec<u8>>())?;
        *lines = qemu::run_in(folder, elf, board)?;
    }
    fs::remove_file(&given)?;
    Ok((lines, again))
}

/// Adds up what lies between two marks, in the order of the program.
#[derive(Debug, Default)]
struct Recorder {
    batches: Counts<Vec<u32>>,
    open: Option<(u32, [Pipeline; WAIT_STATES.len()])>,
}

impl Recorder {
    fn execute(&mut self, executed: &Instruction) {
        match (self.open.take(), executed.is_mark) {
            (None, true) => self.open = Some((0, WAIT_STATES.map(Pipeline::new))),
            (None, false) => {}
            (Some((count, mut pipelines)), false) => {
                pipelines.iter_mut().for_each(|pipeline| pipeline.execute(executed));
                self.open = Some((count + 1, pipelines));
            }
            (Some((count, [none, some])), true) => {
                let counts = [count, none.cycles(), some.cycles()];
                self.batches.iter_mut().zip(counts).for_each(|(all, one)| all.push(one));
            }
        }
    }
}
