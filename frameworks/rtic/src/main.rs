//! The drive monitor of `examples/drive.rs` under RTIC 2.
//!
//! ```text
//! control  priority 2, every control period   row ─► FrontEnd ─► Sample ─► Detector::exchange ─► solve
//! solve    priority 1, once a segment         Monitor::take_from, advance ─► adopt, alarm
//! idle                                        the other work of the drive
//! ```
//!
//! `control` interrupts `solve` at any time; only `adopt` and the return of the place lock it out. `cargo xtask
//! frameworks` runs it in the emulator.

#![no_std]
#![no_main]

#[allow(unused_macros, reason = "the framework has its own entry")]
#[macro_use]
#[path = "../../../examples/support/mod.rs"]
mod support;

mod device;
#[path = "../../../examples/support/drive_parts.rs"]
mod drive_parts;
#[allow(dead_code, reason = "rows contain angles, not counts of the position")]
#[path = "../../../examples/support/actuator/model.rs"]
mod model;
#[path = "../../../examples/support/rows.rs"]
mod rows;

#[rtic::app(device = crate::device, peripherals = false, dispatchers = [EXTI0])]
mod app {
    use cortex_m::peripheral::syst::SystClkSource;

    use crate::drive_parts::{Place, Sampler, Watch};
    use crate::model::FURTHER;
    use crate::rows::Rows;
    use crate::support::target;

    /// Clock cycles of a control period: 0.5 ms at 168 MHz. The emulator executes only 3.9 instructions in 1 µs, so the
    /// recording of 10 kHz is played at 2 kHz.
    const CYCLES: u32 = 84_000;

    #[shared]
    struct Shared {
        sampler: Sampler,
        watch: Watch,
    }

    #[local]
    struct Local {
        rows: Rows<FURTHER>,
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let sampler = match Sampler::new() {
            Ok(sampler) => sampler,
            Err(message) => panic!("{message}"),
        };
        let Some(rows) = Rows::open() else { panic!("no recording rows.bin: see cargo xtask pil") };
        let mut timer = cx.core.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(CYCLES - 1);
        timer.clear_current();
        timer.enable_counter();
        timer.enable_interrupt();
        (Shared { sampler, watch: Watch::new() }, Local { rows })
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::nop();
        }
    }

    /// On a board bound to the interrupt at the end of the current conversion.
    #[task(binds = SysTick, priority = 2, shared = [sampler], local = [rows])]
    fn control(mut cx: control::Context) {
        let Some(raw) = cx.local.rows.next() else {
            // Already spawned by the period before if it fails.
            let _ = end::spawn();
            return;
        };
        if let Some(place) = cx.shared.sampler.lock(|sampler| sampler.sample(&raw)) {
            // There is one closed place at a time, and so one task.
            let _spawned = solve::spawn(place).is_ok();
        }
    }

    #[task(priority = 1, shared = [sampler, watch])]
    async fn solve(mut cx: solve::Context, place: Place) {
        let sampler = &mut cx.shared.sampler;
        cx.shared.watch.lock(|watch| {
            watch.monitor.take_from(place);
            sampler.lock(|sampler| sampler.spare = Some(place));
            while watch.monitor.is_solving() {
                watch.advance(|report| sampler.lock(|sampler| sampler.detector.adopt(report)));
            }
        });
    }

    /// The recording has ended; of the same priority as `solve`, so that a segment is solved first.
    #[task(priority = 1, shared = [sampler, watch])]
    async fn end(cx: end::Context) {
        (cx.shared.sampler, cx.shared.watch).lock(|sampler, watch| watch.end(sampler));
        target::succeed()
    }
}
