//! The drive monitor of `examples/drive.rs` under embassy.
//!
//! ```text
//! control  interrupt, every control period   row ─► WATCH.sample, WATCH.collect ─► NEWS
//! main     task of the thread executor       NEWS ─► WATCH.advance, a step at a time ─► verdict, alarm
//! ```
//!
//! Between two steps other tasks run. `cargo xtask frameworks` runs it in the emulator.

#![no_std]
#![no_main]

#[allow(unused_macros, reason = "the framework has its own entry")]
#[macro_use]
#[path = "../../../examples/support/mod.rs"]
mod support;

#[path = "../../../examples/support/lines.rs"]
mod lines;
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

use lines::Lines;
use model::{FURTHER, WATCH};
use rows::Rows;
use support::target;

/// Clock cycles of a control period: 0.5 ms at 168 MHz. The emulator executes only 3.9 instructions in 1 µs, so the
/// recording of 10 kHz is played at 2 kHz.
const CYCLES: u32 = 84_000;

/// The recording, which the interrupt reads.
static ROWS: Mutex<CriticalSectionRawMutex, RefCell<Option<Rows<FURTHER>>>> = Mutex::new(RefCell::new(None));

/// What the interrupt tells the task.
#[derive(Clone, Copy)]
enum News {
    /// A segment has closed.
    Closed,
    /// The recording has ended.
    Ended,
}

static NEWS: Channel<CriticalSectionRawMutex, News, 2> = Channel::new();

/// On a board, the interrupt at the end of the current conversion.
#[exception]
fn SysTick() {
    match ROWS.lock(|rows| rows.borrow_mut().as_mut().and_then(Iterator::next)) {
        Some(raw) => {
            if WATCH.sample(raw) && WATCH.collect() {
                // There is one closed segment at a time, and room for it.
                drop(NEWS.try_send(News::Closed));
            }
        }
        // If there is no room, the next period tries again.
        None => drop(NEWS.try_send(News::Ended)),
    }
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    if let Err(message) = lines::start() {
        panic!("{message}")
    }
    let Some(rows) = Rows::open() else { panic!("no recording rows.bin: see cargo xtask pil") };
    ROWS.lock(|all| all.replace(Some(rows)));
    start_interrupt();
    let mut lines = Lines::default();
    while matches!(NEWS.receive().await, News::Closed) {
        // More steps than a solve has, between which other tasks run.
        for _ in 0..99 {
            lines.advance();
            yield_now().await;
        }
    }
    lines.end();
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
