//! A drive that watches its bearings: current loop, the interrupt below it, and main loop. `board.rs` has what a board
//! has.

#![no_std]
#![no_main]

mod board;
#[allow(dead_code, reason = "what `train` writes is for other programs, too")]
mod model;

use cortex_m::peripheral::SCB;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::hprintln;

use model::{FRONT_END, MODEL, WATCH};

/// The interrupt of the current loop, of the highest priority: what it has read passes the front end.
#[exception]
fn SysTick() {
    if let Some(reading) = board::read()
        && WATCH.sample(reading)
    {
        SCB::set_pendsv();
    }
}

/// An interrupt below it: the detector.
#[exception]
fn PendSV() {
    WATCH.collect();
}

#[entry]
fn main() -> ! {
    if let Err(error) = WATCH.start(&MODEL, &FRONT_END) {
        board::fail(error.message());
    }
    let mut state = [0; 2048];
    if let Some(saved) = board::load(&mut state)
        && WATCH.restore(saved).is_err()
    {
        hprintln!("the saved state is damaged or of another model: the evidence starts anew");
    }
    board::start_interrupts();
    // A drive runs until power-down.
    while board::runs() {
        if let Some(lapse) = WATCH.clock(board::milliseconds()) {
            hprintln!("{}", lapse.message());
        }
        WATCH.advance(|now| {
            let alarm = if now.alarm.is_some() { ", ALARM" } else { "" };
            hprintln!("{}, {} rows{}", MODEL.verdict_name(now.report.verdict), now.report.rows, alarm);
        });
        // The other work of the main loop; feed the watchdog here.
    }
    match WATCH.end_run(&mut state) {
        Ok(length) => board::store(state.get(..length).unwrap_or_default()),
        Err(error) => board::fail(error.message()),
    }
    board::finish()
}
