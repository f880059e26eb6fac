//! Counts instructions of calls that outlast the 24-bit counter of [`super::count`], by a timer of the emulated chip.
//!
//! Under `-icount shift=8` every instruction takes 256 ns of the emulated time. The emulator clocks the timer TIM2 by
//! 1 GHz; divided by 256 it counts instructions in 32 bits.

use cortex_m::asm;

const TIM2: usize = 0x4000_0000;
const COUNT: *const u32 = (TIM2 + 0x24) as *const u32;
const PRESCALER: *mut u32 = (TIM2 + 0x28) as *mut u32;

/// The timer as an instruction counter.
pub struct LongCounter(());

impl LongCounter {
    /// The counter. It first counts a loop whose length is known, because an emulator that clocks its timer otherwise
    /// would give plausible, wrong figures.
    pub fn new() -> Self {
        // SAFETY: a register of the chip, which nothing else in the program uses.
        unsafe { PRESCALER.write_volatile(255) };
        let counter = Self(());
        // A subtraction and a branch a round.
        let known = counter.instructions(|| asm::delay(4_000_000));
        assert!((8_000_000..8_000_100).contains(&known), "8 000 000 instructions counted as {known}");
        counter
    }

    /// Instructions of a call, with some ten of the counter.
    pub fn instructions(&self, work: impl FnOnce()) -> u32 {
        let start = count();
        work();
        count().wrapping_sub(start)
    }
}

fn count() -> u32 {
    // SAFETY: as above; reading has no effect.
    unsafe { COUNT.read_volatile() }
}
