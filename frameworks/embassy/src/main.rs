//! The drive monitor of `examples/drive.rs` under embassy.
//!
//! ```text
//! control  interrupt, every control period   row ─► FrontEnd ─► Sample ─► Detector::exchange ─► CLOSED
//! main     task of the thread executor       CLOSED ─► Monitor::advance, a step at a time ─► adopt, evidence, alarm
//! ```
//!
//! Between two steps other tasks run. `cargo xtask frameworks` runs it in the emulator.

#![no_std]
#![no_main]

#[allow(unused_macros, reason = "the framework has its own entry")]
#[macro_use]
#[path = "../../../examples/support/mod.rs"]
mod support;

#[path = "../../../examples/support/drive_parts.rs"]
mod drive_parts;
#[allow(dead_code, reason = "rows contain angles, not counts of the position")]
#[path = "../../../examples/support/actuator/model.rs"]
mod model;
#[path = "../../../examples/support/rows.rs"]
mod rows;

use core::cell::RefCell;

use cortex_m::peripheral::Peripherals;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;
use embassy_executor::Spawner;
use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;

use drive_parts::{Place, Sampler, Watch};
use model::FURTHER;
use rows::Rows;
use support::target;

/// Clock cycles of a control period: 0.5 ms at 168 MHz. The emulator executes only 3.9 instructions in 1 µs, so the
/// recording of 10 kHz is played at 2 kHz.
const CYCLES: u32 = 84_000;

/// What the interrupt works on.
struct Control {
    rows: Rows<FURTHER>,
    sampler: Sampler,
}

static CONTROL: Mutex<CriticalSectionRawMutex, RefCell<Option<Control>>> = Mutex::new(RefCell::new(None));

/// From the interrupt to the task: closed segments, and `None` when the recording has ended.
static CLOSED: Channel<CriticalSectionRawMutex, Option<Place>, 2> = Channel::new();

/// Runs `work` on the interrupt's data, with interrupts masked.
fn masked<T>(work: impl FnOnce(&mut Control) -> T) -> Option<T> {
    CONTROL.lock(|control| control.borrow_mut().as_mut().map(work))
}

/// On a board, the interrupt at the end of the current conversion.
#[exception]
fn SysTick() {
    masked(|control| match control.rows.next() {
        Some(raw) => {
            if let Some(place) = control.sampler.sample(&raw) {
                // There is one closed place at a time, and room for it.
                drop(CLOSED.try_send(Some(place)));
            }
        }
        // If there is no room, the next period tries again.
        None => drop(CLOSED.try_send(None)),
    });
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let sampler = match Sampler::new() {
        Ok(sampler) => sampler,
        Err(message) => panic!("{message}"),
    };
    let Some(rows) = Rows::open() else { panic!("no recording rows.bin: see cargo xtask pil") };
    CONTROL.lock(|control| control.replace(Some(Control { rows, sampler })));
    start_interrupt();
    let mut watch = Watch::new();
    while let Some(place) = CLOSED.receive().await {
        watch.monitor.take_from(place);
        masked(|control| control.sampler.spare = Some(place));
        // By steps, between which other tasks run.
        while watch.monitor.is_solving() {
            watch.advance(|report| masked(|control| control.sampler.detector.adopt(report)));
            yield_now().await;
        }
    }
    masked(|control| watch.end(&control.sampler));
    target::succeed()
}

fn start_interrupt() {
    let Some(peripherals) = Peripherals::take() else { panic!("the peripherals are taken") };
    let mut timer = peripherals.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CYCLES - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}
