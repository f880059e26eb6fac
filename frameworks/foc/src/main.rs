//! The firmware: the current loop of `drive_foc` in closed loop with its motor, and the bearing watched beside it.
//!
//! It checks the wiring, says what it finds of the sound bearing, then gives the bearing a spall, and ends with the
//! alarm. `cargo xtask frameworks` records the drive on the computer, trains, builds this program and runs it.

#![no_std]
#![no_main]

/// What `train --rust` has written for the recordings of the example `record`.
#[allow(dead_code, reason = "what `train` writes is for other programs, too")]
mod model {
    include!(env!("MODEL_FILE"));
}

use core::cell::Cell;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use bearing_watch::drive::{Wiring, WiringCheck, WiringFault, WiringLimits};
use cortex_m::interrupt::{self, Mutex};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SCB};
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::{debug, hprintln};
use drive_foc::{Drive, Duty, RATE_HZ};

use model::{FRONT_END, MODEL, Reading, WATCH};

/// Seed of this drive, which no recording has.
const SEED: u32 = 9000;
/// Torque of the pulses of the spall, N·m.
const SPALL_NM: f32 = 0.02;
/// Steps of the current loop in which the wiring is checked: the shaft goes to and fro.
const COMMISSIONING: u32 = 3 * RATE_HZ as u32;
const WIRING: WiringLimits =
    WiringLimits { least_current_a: 0.05, offset_rad: 0.1, delay_s: 2e-4, velocity_tolerance: 0.1, slowest_rad_s: 5.0 };
/// Segments of the sound bearing, and all.
const SOUND: u32 = 3;
const MOST: u32 = 9;
/// Clock cycles of a step. The emulator executes only 3.9 instructions in 1 µs, so the drive runs slower here.
const CYCLES: u32 = 320_000;

/// Whether the bearing has its spall.
static DAMAGED: AtomicBool = AtomicBool::new(false);
/// Steps of the current loop.
static STEPS: AtomicU32 = AtomicU32::new(0);
/// What the check of the wiring has found.
static WIRED: Mutex<Cell<Option<Result<Wiring, WiringFault>>>> = Mutex::new(Cell::new(None));

/// The current loop.
#[exception]
fn SysTick() {
    static mut DRIVE: Option<Drive> = None;
    static mut CHECK: Option<WiringCheck> = None;
    let drive = DRIVE.get_or_insert_with(|| Drive::new(Duty { seed: SEED, spall_nm: 0.0 }));
    if DAMAGED.load(Ordering::Relaxed) {
        drive.damage(SPALL_NM);
    }
    let counts = drive.step();
    let number = STEPS.load(Ordering::Relaxed);
    STEPS.store(number.wrapping_add(1), Ordering::Relaxed);
    let reading = Reading { number, phases: counts.phases, position: Some(u32::from(counts.encoder)) };
    if number < COMMISSIONING {
        let check = CHECK.get_or_insert_with(|| WiringCheck::new(FRONT_END.frame, RATE_HZ, WIRING));
        WATCH.check_wiring(reading, f32::NAN, check);
        if number == COMMISSIONING - 1 {
            let wiring = check.conclude();
            interrupt::free(|cs| WIRED.borrow(cs).set(Some(wiring)));
        }
    } else if WATCH.sample(reading) {
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
        fail(error.message());
    }
    let Some(peripherals) = Peripherals::take() else { fail("the peripherals are taken") };
    start(peripherals);
    let (mut segments, mut alarmed) = (0, false);
    while segments < MOST && !alarmed {
        match interrupt::free(|cs| WIRED.borrow(cs).take()) {
            Some(Ok(wiring)) => hprintln!("wiring right, coherence {:.2}", wiring.coherence),
            Some(Err(fault)) => {
                hprintln!("{:?}", fault);
                fail("the wiring is wrong");
            }
            None => {}
        }
        let milliseconds = u64::from(STEPS.load(Ordering::Relaxed)) * 1000 / RATE_HZ as u64;
        if let Some(lapse) = WATCH.clock(milliseconds as u32) {
            hprintln!("{}", lapse.message());
        }
        WATCH.advance(|now| {
            segments += 1;
            alarmed = now.alarm.is_some();
            let alarm = if alarmed { ", ALARM" } else { "" };
            hprintln!("{}, {} rows{}", MODEL.verdict_name(now.report.verdict), now.report.rows, alarm);
        });
        if segments == SOUND && !DAMAGED.swap(true, Ordering::Relaxed) {
            hprintln!("a spall of {} N m", SPALL_NM);
        }
    }
    let status = WATCH.status();
    hprintln!("lost: {} samples, {} segments", status.lost_samples, status.lost_segments);
    match status.faults {
        Some(faults) if !faults.is_clear() => hprintln!("{:?}", faults),
        _ => hprintln!("no faults"),
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}

fn start(mut peripherals: Peripherals) {
    // SAFETY: no interrupt runs yet whose priority would change.
    unsafe { peripherals.SCB.set_priority(SystemHandler::PendSV, 0xff) };
    let mut timer = peripherals.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CYCLES - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

fn fail(message: &str) -> ! {
    hprintln!("{}", message);
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    fail("panic")
}
