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

/// What the counter of the firmware enclosed, in the order of the program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Batches {
    instructions: Vec<u64>,
    cycles: [Vec<u64>; WAIT_STATES.len()],
}

/// The lines that a program prints: of instructions, of those of the trace, and of cycles for each of [`WAIT_STATES`].
#[derive(Clone, Debug)]
pub struct Lines {
    pub instructions: Vec<String>,
    pub traced: Vec<String>,
    pub cycles: [Vec<String>; WAIT_STATES.len()],
}

/// Runs a program that reads no other files.
pub fn lines(elf: &Path, board: Board) -> Result<Lines> {
    let folder = &workspace::target_dir().join("cycles");
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    // Left there by a run that was ended, it would replace the counts.
    let _none_there = fs::remove_file(folder.join(GIVEN));
    let (mut trace, mut recorder) = (Trace::default(), Recorder::default());
    let instructions =
        qemu::trace((folder, elf), board, |line| trace.line(line, |executed| recorder.execute(executed)))?;
    ensure!(recorder.open.is_none(), "a batch has no end");
    ensure!(!recorder.batches.instructions.is_empty(), "{} counts nothing", elf.display());
    let again = |counts: &[u64]| again(folder, elf, board, counts);
    let Batches { instructions: traced, cycles: [none, some] } = &recorder.batches;
    Ok(Lines { instructions, traced: again(traced)?, cycles: [again(none)?, again(some)?] })
}

fn again(folder: &Path, elf: &Path, board: Board, counts: &[u64]) -> Result<Vec<String>> {
    let file = folder.join(GIVEN);
    let words: Vec<u32> = counts.iter().map(|&count| u32::try_from(count)).collect::<Result<_, _>>()?;
    fs::write(&file, words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>())?;
    let lines = qemu::run_in(folder, elf, board);
    fs::remove_file(&file)?;
    lines
}

/// Adds up what lies between two marks.
#[derive(Debug, Default)]
struct Recorder {
    batches: Batches,
    open: Option<(u64, [Pipeline; WAIT_STATES.len()])>,
}

impl Recorder {
    fn execute(&mut self, executed: &Instruction) {
        match (&mut self.open, executed.is_mark) {
            (None, true) => self.open = Some((0, WAIT_STATES.map(Pipeline::new))),
            (Some((count, pipelines)), false) => {
                *count += 1;
                pipelines.iter_mut().for_each(|pipeline| pipeline.execute(executed));
            }
            (open @ Some(_), true) => {
                if let Some((count, pipelines)) = open.take() {
                    self.batches.instructions.push(count);
                    for (all, pipeline) in self.batches.cycles.iter_mut().zip(pipelines) {
                        all.push(pipeline.cycles());
                    }
                }
            }
            (None, false) => {}
        }
    }
}
