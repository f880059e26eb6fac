//! Waiting for the flash of an STM32F4, after its reference manual (RM0090, section 3.5).
//!
//! A read gives a line of 128 bits and takes 1 + W cycles, where W is the number of wait states. While instructions of
//! a line are executed, the next line is read. A jump to a line that is neither at hand nor read ahead is looked up in
//! a cache of 64 lines, least recently used out first, and waits W cycles if it is not there; only such lines are kept.
//! Constants between instructions have a cache of 8 lines. The caches start empty, as after other code.

use super::instruction::Instruction;

/// Bytes of a line, as a power of two.
const LINE: u32 = 4;
const INSTRUCTION_LINES: usize = 64;
const CONSTANT_LINES: usize = 8;

/// The flash with its caches.
#[derive(Clone, Debug)]
pub struct Flash {
    wait_states: u64,
    /// The line at hand.
    line: Option<u32>,
    /// The line that is read ahead, and when it will be there.
    ahead: Option<(u32, u64)>,
    instructions: Vec<u32>,
    constants: Vec<u32>,
}

impl Flash {
    pub const fn new(wait_states: u64) -> Self {
        Self { wait_states, line: None, ahead: None, instructions: Vec::new(), constants: Vec::new() }
    }

    /// Cycles of waiting for an instruction that is fetched at a time.
    pub fn fetch(&mut self, instruction: &Instruction, cycles: u64) -> u64 {
        if self.wait_states == 0 {
            return 0;
        }
        let first = instruction.address >> LINE;
        let last = (instruction.end() - 1) >> LINE;
        let waited = self.line(first, cycles);
        if last == first { waited } else { waited + self.line(last, cycles + waited) }
    }

    fn line(&mut self, line: u32, cycles: u64) -> u64 {
        if self.line == Some(line) {
            return 0;
        }
        let waited = match self.ahead {
            Some((ahead, ready)) if ahead == line => ready.saturating_sub(cycles),
            _ if used(&mut self.instructions, line, INSTRUCTION_LINES) => 0,
            _ => self.wait_states,
        };
        self.line = Some(line);
        self.ahead = Some((line.wrapping_add(1), cycles + waited + 1 + self.wait_states));
        waited
    }

    /// Cycles of waiting for a constant.
    pub fn constant(&mut self, address: u32) -> u64 {
        if used(&mut self.constants, address >> LINE, CONSTANT_LINES) { 0 } else { self.wait_states }
    }
}

/// Whether a cache has a line, which becomes its last used one.
fn used(cache: &mut Vec<u32>, line: u32, most: usize) -> bool {
    let known = cache.iter().rposition(|&other| other == line);
    match known {
        Some(place) => drop(cache.remove(place)),
        None if cache.len() == most => drop(cache.remove(0)),
        None => {}
    }
    cache.push(line);
    known.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cycles of waiting for 16-bit instructions that take a cycle each.
    fn waited(flash: &mut Flash, addresses: impl IntoIterator<Item = u32>) -> u64 {
        let mut cycles = 0;
        let mut sum = 0;
        for address in addresses {
            let line = format!("0x{address:08x}:  bf00       nop");
            let one = flash.fetch(&Instruction::parse(&line).expect("an instruction"), cycles);
            (cycles, sum) = (cycles + one + 1, sum + one);
        }
        sum
    }

    #[test]
    fn lines_are_read_ahead_and_targets_of_jumps_and_constants_have_caches() {
        let mut flash = Flash::new(5);
        // The first line waits 5. Eight instructions of a cycle take longer than the next line's 6.
        assert_eq!(waited(&mut flash, (0..32).map(|k| 0x0800_0000 + 2 * k)), 5);
        // One instruction a line waits 6 − 1 for each further one.
        assert_eq!(waited(&mut Flash::new(5), (0..3).map(|k| 0x0800_0000 + 16 * k)), 5 + 5 + 5);
        let round = [0x0801_0000, 0x0801_0100, 0x0801_0200];
        assert_eq!([waited(&mut flash, round), waited(&mut flash, round)], [15, 0]);
        assert_eq!([0, 4, 16, 0].map(|address| flash.constant(address)), [5, 0, 5, 0]);
    }
}
