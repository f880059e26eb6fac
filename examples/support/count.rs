//! Counts executed instructions on two of QEMU's machines, to the instruction.
//!
//! Under `-icount shift=8` every instruction takes 2⁸ ns of the emulated time. `SysTick` runs from
//! its reference clock, on netduinoplus2 an eighth of 168 MHz, or without one from the processor's,
//! on microbit 16 MHz:
//!
//! ```text
//! ticks an instruction = 256 ns · 21 MHz = 5.376 = 672 / 125,   256 ns · 16 MHz = 4.096 = 512 / 125
//! ```
//!
//! More than one tick an instruction, so rounding the ticks gives the exact count. The 24-bit
//! counter wraps after 3.1 million instructions; a batch that long panics instead of misleading.
//!
//! These are instructions, not cycles. `cargo xtask measure` estimates cycles from a trace of the
//! emulator, in which the instruction SEV marks start and end of a batch, and runs the program
//! again with the file `counts.bin`, whose numbers then stand for those of the batches.

#[cfg(target_os = "none")]
#[path = "file.rs"]
mod file;

/// The `SysTick` as an instruction counter.
pub struct Counter {
    #[cfg(target_os = "none")]
    timer: cortex_m::peripheral::SYST,
    /// Ticks of 125 instructions.
    #[cfg(target_os = "none")]
    ticks: u32,
    /// Number of calls and instructions of the last empty loop.
    #[cfg(target_os = "none")]
    empty: (u32, u32),
    /// The counts of all batches, if they are given.
    #[cfg(target_os = "none")]
    given: Option<file::File<4>>,
}

#[cfg(not(target_os = "none"))]
impl Counter {
    /// The host has no such counter.
    pub const fn new() -> Option<Self> {
        None
    }

    /// Never reached: the host gets no counter.
    pub fn instructions_per_call(&mut self, _calls: u32, _kernel: impl FnMut(u32)) -> u32 {
        0
    }

    /// Never reached: the host gets no counter.
    pub fn instructions_once(&mut self, _work: impl FnOnce()) -> u32 {
        0
    }
}

#[cfg(target_os = "none")]
mod on_target {
    use core::hint::black_box;

    use cortex_m::asm;
    use cortex_m::peripheral::{Peripherals, SYST, syst::SystClkSource};

    use super::Counter;
    use super::file::File;

    const LAST: u32 = 0x00ff_ffff;

    /// Ticks of 125 instructions, on each machine.
    const CLOCKS: [u32; 2] = [672, 512];

    impl Counter {
        /// The counter; there is one. It first counts a stretch whose length is known, because an
        /// emulator that clocks its `SysTick` otherwise would give plausible, wrong figures.
        pub fn new() -> Option<Self> {
            let mut timer = Peripherals::take()?.SYST;
            timer.set_clock_source(SystClkSource::External);
            timer.set_reload(LAST);
            let given = File::open("counts.bin\0");
            let mut counter = Self { timer, ticks: 0, empty: (0, 0), given };
            for ticks in CLOCKS {
                (counter.ticks, counter.empty) = (ticks, (0, 0));
                let four = counter.instructions_per_call(100, |_| {
                    asm::nop();
                    asm::nop();
                    asm::nop();
                    asm::nop();
                });
                if four == 4 || counter.given.is_some() {
                    return Some(counter);
                }
            }
            panic!("not a SysTick clock this counter was made for");
        }

        /// Instructions of one `kernel(k)`, averaged over k = 0 … `calls` − 1 and rounded; the
        /// loop around it is measured empty and subtracted. What goes into the kernel and what it
        /// gives must pass through `black_box`, or the optimiser removes the work.
        pub fn instructions_per_call(&mut self, calls: u32, mut kernel: impl FnMut(u32)) -> u32 {
            if self.empty.0 != calls {
                let empty = self.batch(calls, |k| {
                    black_box(k);
                });
                self.empty = (calls, empty);
            }
            let (_, empty) = self.empty;
            let full = self.batch(calls, |k| kernel(black_box(k)));
            (full.saturating_sub(empty) + calls / 2) / calls
        }

        /// Instructions of one call.
        pub fn instructions_once(&mut self, work: impl FnOnce()) -> u32 {
            let mut work = Some(work);
            self.instructions_per_call(1, |_| {
                if let Some(work) = work.take() {
                    work();
                }
            })
        }

        /// Not inlined, so that every kernel gets the same loop and the same two readings.
        #[inline(never)]
        fn batch(&mut self, calls: u32, mut kernel: impl FnMut(u32)) -> u32 {
            self.timer.clear_current();
            self.timer.enable_counter();
            let start = SYST::get_current();
            asm::sev();
            for k in 0..calls {
                kernel(k);
            }
            asm::sev();
            let end = SYST::get_current();
            assert!(!self.timer.has_wrapped(), "too many calls for the 24-bit counter");
            self.timer.disable_counter();
            self.given().unwrap_or(instructions(start.wrapping_sub(end) & LAST, self.ticks))
        }

        /// The next count of the file, if there is one.
        fn given(&mut self) -> Option<u32> {
            let mut bytes = [0; 4];
            assert!(self.given.as_mut()?.fill(&mut bytes), "more batches than counts");
            Some(u32::from_le_bytes(bytes))
        }
    }

    /// Ticks to instructions, rounded; so many are exactly 125 instructions.
    const fn instructions(ticks: u32, of_125: u32) -> u32 {
        // In parts, since ticks · 125 overflows.
        ticks / of_125 * 125 + (ticks % of_125 * 125 + of_125 / 2) / of_125
    }
}
