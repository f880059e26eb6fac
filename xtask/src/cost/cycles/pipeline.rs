//! Cycles of a sequence of instructions on a Cortex-M4F, after sections 3.3 and 7.2.3 of its reference manual.
//!
//! ```text
//! integer 1; MLA, MLS 2; UDIV, SDIV 12, the most; IT 0 after a 16-bit instruction, otherwise 1
//! LDR, VLDR 2, or 1 directly after another load whose result is no part of the address
//! STR at an immediate offset 1; otherwise STR, VSTR 2, or 1 directly after such a load
//! N words at once (LDM, STM, PUSH, POP, LDRD, …) 1 + N; never overlapped
//! a load or store whose address the integer instruction before has computed: + 1
//! VADD, VSUB, VMUL, VCMP, VCVT, VABS, VNEG 1; VMLA, VMLS 3; + 1 if the next instruction takes the result
//! VDIV, VSQRT 14, of which integer instructions overlap 13; + 1 as above
//! a jump that is taken: + P; P = 2 to an address of the instruction, 3 to one of a register or of memory, and 3 to an
//! instruction of 32 bits that is not at a multiple of 4
//! ```
//!
//! The manual gives P as 1 to 3 by alignment, and by whether the address is known early. A conditional instruction
//! counts as executed. [`Flash`] adds what waiting for instructions and for constants between them takes. Other loads
//! are of memory without wait states, as RAM is: a constant that is read from flash by a pointer takes longer.

use super::flash::Flash;
use super::instruction::{Class, Instruction, Jump};

/// Cycles of a division or square root.
const DIVISION: u64 = 14;

/// The processor.
#[derive(Clone, Debug)]
pub struct Pipeline {
    flash: Flash,
    cycles: u64,
    /// When the floating-point unit has the result of its division.
    divided: u64,
    previous: Option<Instruction>,
}

impl Pipeline {
    /// With nothing under way, and nothing of the flash in its caches.
    pub fn new(wait_states: u64) -> Self {
        Self { flash: Flash::new(wait_states), cycles: 0, divided: 0, previous: None }
    }

    /// Cycles so far.
    pub fn cycles(&self) -> u32 {
        u32::try_from(self.cycles).unwrap_or(u32::MAX)
    }

    /// Takes the next instruction that was executed.
    pub fn execute(&mut self, next: &Instruction) {
        let previous = self.previous.replace(*next);
        self.cycles += previous.as_ref().map_or(0, |previous| refill(previous, next));
        self.cycles += self.flash.fetch(next, self.cycles);
        if next.is_float() {
            self.cycles = self.cycles.max(self.divided);
        }
        self.cycles += previous.as_ref().map_or(0, |previous| stall(previous, next));
        if next.class == Class::Divide {
            self.divided = self.cycles + DIVISION;
        }
        self.cycles += issue(previous.as_ref(), next);
        if let Some(address) = next.literal {
            self.cycles += self.flash.constant(address);
        }
    }
}

/// Cycles of the instruction itself.
fn issue(previous: Option<&Instruction>, next: &Instruction) -> u64 {
    let overlaps =
        previous.is_some_and(|previous| previous.class == Class::Load && previous.writes & next.address_of == 0);
    match next.class {
        Class::Condition => u64::from(previous.is_none_or(|previous| previous.bytes != 2)),
        Class::Load | Class::SlowStore => 2 - u64::from(overlaps),
        Class::Several(words) => 1 + words,
        Class::Integer(cycles) | Class::Float(cycles) => cycles,
        Class::Store | Class::Divide | Class::Move => 1,
    }
}

/// Cycles of waiting for a result of the instruction before.
fn stall(previous: &Instruction, next: &Instruction) -> u64 {
    match previous.class {
        Class::Integer(_) => u64::from(previous.writes & next.address_of != 0),
        Class::Float(_) | Class::Divide => u64::from(previous.writes & next.reads != 0),
        _ => 0,
    }
}

/// Cycles of filling the pipeline again after a jump.
const fn refill(previous: &Instruction, next: &Instruction) -> u64 {
    if previous.end() == next.address {
        return 0;
    }
    let is_split = next.bytes == 4 && !next.address.is_multiple_of(4);
    match previous.jump {
        Jump::Direct if !is_split => 2,
        _ => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cycles of 16-bit instructions one behind the other, without wait states.
    fn cycles(texts: &[&str]) -> u32 {
        let mut pipeline = Pipeline::new(0);
        for (number, text) in (0..).zip(texts) {
            let line = format!("0x{:08x}:  bf00       {text}", 0x0800_0000 + 2 * number);
            pipeline.execute(&Instruction::parse(&line).expect("an instruction"));
        }
        pipeline.cycles()
    }

    #[test]
    fn examples_of_the_manual_take_what_it_says() {
        assert_eq!(cycles(&["ldr r0, [r1]", "ldr r1, [r2]"]), 3);
        assert_eq!(cycles(&["ldr r0, [r1, r2]", "str r0, [r3, #20]"]), 3);
        assert_eq!(cycles(&["ldr r0, [r1, r2]", "str r1, [r3, r2]"]), 3);
        assert_eq!(cycles(&["ldr r0, [r1, r5]", "ldr r1, [r2]", "ldr r2, [r3, #4]"]), 4);
        assert_eq!(cycles(&["ldm r2, {r0, r1, r3, r4, r5, r6, r7, ip}"]), 9);
        // An address waits for its result; a sum takes a product one later; only integers overlap a division.
        assert_eq!(cycles(&["adds r0, r1, r2", "ldr r3, [r0]"]), 4);
        assert_eq!(cycles(&["vldr s1, [r0]", "vldr s2, [r1]", "vmul.f32 s3, s1, s2", "vadd.f32 s0, s0, s3"]), 6);
        assert_eq!(cycles(&["vdiv.f32 s0, s1, s2", "adds r0, r1, r2", "vadd.f32 s3, s0, s1"]), 15);
        assert_eq!(cycles(&["cmp r0, r1", "it ne", "movne r0, r1"]), 2);
    }

    #[test]
    fn jumps_fill_the_pipeline_again() {
        let mut pipeline = Pipeline::new(0);
        let lines = [
            "0x08000000:  d1fe       bne      #0x8000010", // taken: 1 + 2
            "0x08000010:  f44f 0170  mov.w    r1, #0xf00000",
            "0x08000014:  d1fe       bne      #0x8000022", // taken, to a split instruction: 1 + 3
            "0x08000022:  f44f 0170  mov.w    r1, #0xf00000",
            "0x08000026:  d1fe       bne      #0x8000022", // not taken: 1
            "0x08000028:  bd80       pop      {r7, pc}",   // 3 + 3
            "0x08000100:  bf00       nop",
        ];
        for line in lines {
            pipeline.execute(&Instruction::parse(line).expect("an instruction"));
        }
        assert_eq!(pipeline.cycles(), 3 + 1 + 4 + 1 + 1 + 6 + 1);
    }
}
