//! The log of the emulator → the instructions that were executed, in their order.
//!
//! ```text
//! IN: name                                        a block of instructions was translated; then one a line
//! Trace 0: 0x7f5758000100 [flags/address/… ] …    the block at this place of the emulator's memory is executed next
//! Stopped execution of TB chain before …          it was not, and comes again
//! cpu_io_recompile: rewound execution of TB to …  it was executed up to this address; the remainder comes again
//! ```

use std::collections::HashMap;
use std::ops::Range;

use anyhow::{Context, Result};

use super::instruction::Instruction;

/// Reads the log.
#[derive(Debug, Default)]
pub struct Trace {
    /// All instructions of all blocks.
    translated: Vec<Instruction>,
    /// Those that the next new block has.
    new: Option<Range<usize>>,
    /// Of the blocks, by their place.
    blocks: HashMap<u64, Range<usize>>,
    /// The block that is executed next.
    next: Option<Range<usize>>,
}

impl Trace {
    /// Takes a line, and hands over the instructions that it says were executed.
    pub fn line(&mut self, line: &str, executed: impl FnMut(&Instruction)) -> Result<()> {
        if line.starts_with("0x") {
            self.translated.push(Instruction::parse(line)?);
            let new = self.new.as_mut().context("an instruction outside of a block")?;
            new.end = self.translated.len();
        } else if line.starts_with("IN:") {
            self.new = Some(self.translated.len()..self.translated.len());
        } else if let Some(fields) = line.strip_prefix("Trace ") {
            self.leave(None, executed);
            self.next = Some(self.block(fields).with_context(|| format!("not a block: {line}"))?);
        } else if line.starts_with("Stopped execution") {
            self.next = None;
        } else if let Some(end) = line.strip_prefix("cpu_io_recompile: rewound execution of TB to ") {
            self.leave(Some(u32::from_str_radix(end.trim(), 16)?), executed);
        }
        Ok(())
    }

    /// Executes the block, or what comes before an address.
    fn leave(&mut self, end: Option<u32>, mut executed: impl FnMut(&Instruction)) {
        let block = self.next.take().and_then(|block| self.translated.get(block));
        for instruction in block.unwrap_or_default() {
            if Some(instruction.address) == end {
                return;
            }
            executed(instruction);
        }
    }

    fn block(&mut self, fields: &str) -> Result<Range<usize>> {
        let place = fields.split_whitespace().nth(1).context("no place")?;
        let place = u64::from_str_radix(place.trim_start_matches("0x"), 16)?;
        // A block is executed directly after its translation.
        if let Some(new) = self.new.take() {
            self.blocks.insert(place, new);
        }
        self.blocks.get(&place).cloned().context("never translated")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn addresses(log: &str) -> Vec<u32> {
        let (mut trace, mut addresses) = (Trace::default(), Vec::new());
        for line in log.lines() {
            trace.line(line, |instruction| addresses.push(instruction.address)).expect("a line of a log");
        }
        addresses
    }

    const START: &str = "IN: Reset\n\
        0x00000100:  f44f 0170  mov.w    r1, #0xf00000\n\
        0x00000104:  6802       ldr      r2, [r0]\n\
        0x00000106:  e7fb       b        #0x100\n\n\
        Trace 0: 0x7f01 [00800408/00000100/00000110/ff020200] Reset\n";

    #[test]
    fn the_remainder_of_a_block_comes_again() {
        let rewound = "cpu_io_recompile: rewound execution of TB to 00000104\n\
            IN: Reset\n\
            0x00000104:  6802       ldr      r2, [r0]\n\n\
            Trace 0: 0x7f02 [00800408/00000104/00000110/ff038201] Reset\n";
        let next = "Trace 0: 0x7f02 [00800408/00000104/00000110/ff038201] Reset\n";
        assert_eq!(addresses(&format!("{START}{rewound}{next}")), [0x100, 0x104]);
    }
}
