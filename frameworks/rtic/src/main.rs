//! The drive monitor of `examples/drive.rs` under RTIC 2.
//!
//! ```text
//! control  priority 2, every control period   row ─► WATCH.sample, WATCH.collect
//! solve    priority 1, once a segment         WATCH.advance ─► verdict, alarm
//! idle                                        the other work of the drive
//! ```
//!
//! `control` interrupts `solve` at any time, and nothing locks it out. `cargo xtask frameworks` runs it in the
//! emulator.

#![no_std]
#![no_main]

#[allow(unused_macros, reason = "the framework has its own entry")]
#[macro_use]
#[path = "../../../examples/support/mod.rs"]
mod support;

mod device;
#[path = "../../../examples/support/lines.rs"]
mod lines;
#[allow(dead_code, reason = "rows contain angles, not counts of the position")]
#[path = "../../../examples/support/actuator/model.rs"]
mod model;
#[path = "../../../examples/support/rows.rs"]
mod rows;

#[rtic::app(device = crate::device, peripherals = false, dispatchers = [EXTI0])]
mod app {
    use cortex_m::peripheral::syst::SystClkSource;

    use crate::lines::{self, Lines};
    use crate::model::{FURTHER, WATCH};
    use crate::rows::Rows;
    use crate::support::target;

    /// Clock cycles of a control period: 0.5 ms at 168 MHz. The emulator executes only 3.9 instructions in 1 µs, so the
    /// recording of 10 kHz is played at 2 kHz.
    const CYCLES: u32 = 84_000;

    #[shared]
    struct Shared {
        lines: Lines,
    }

    #[local]
    struct Local {
        rows: Rows<FURTHER>,
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        if let Err(message) = lines::start() {
            panic!("{message}")
        }
        let Some(rows) = Rows::open() else { panic!("no recording rows.bin: see cargo xtask pil") };
        let mut timer = cx.core.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(CYCLES - 1);
        timer.clear_current();
        timer.enable_counter();
        timer.enable_interrupt();
        (Shared { lines: Lines::default() }, Local { rows })
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::nop();
        }
    }

    /// On a board bound to the interrupt at the end of the current conversion.
    #[task(binds = SysTick, priority = 2, local = [rows])]
    fn control(cx: control::Context) {
        let Some(raw) = cx.local.rows.next() else {
            // Already spawned by the period before if it fails.
            let _ = end::spawn();
            return;
        };
        if WATCH.sample(raw) && WATCH.collect() {
            // There is one closed segment at a time, and so one task.
            let _spawned = solve::spawn().is_ok();
        }
    }

    #[task(priority = 1, shared = [lines])]
    async fn solve(mut cx: solve::Context) {
        // More steps than a solve has.
        cx.shared.lines.lock(|lines| (0..99).for_each(|_| lines.advance()));
    }

    /// The recording has ended; of the same priority as `solve`, so that a segment is solved first.
    #[task(priority = 1, shared = [lines])]
    async fn end(mut cx: end::Context) {
        cx.shared.lines.lock(Lines::end);
        target::succeed()
    }
}
