//! A drive that watches its bearings: interrupt and main loop around the code in `detector.rs`.

#![no_std]
#![no_main]

mod converters;
mod detector;
mod model;

use core::cell::RefCell;
use core::panic::PanicInfo;

use bearing_watch::{Detector, Segment};
use cortex_m::interrupt::{self, Mutex};
use cortex_m::peripheral::Peripherals;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::{debug, hprintln};

use converters::Converters;
use model::{Drive, DriveFrontEnd};

/// Clock cycles between two interrupts: 0.5 ms at 168 MHz. The emulator executes only 3.9 instructions in 1 µs, so the
/// recording of 10 kHz is played at 2 kHz.
const CYCLES: u32 = 84_000;

/// What the interrupt works on. If the current loop interrupts this one, use locks that mask only some priorities:
/// `frameworks/rtic` of bearing-watch shows that.
struct Interrupt {
    converters: Converters,
    front_end: DriveFrontEnd,
    detector: Detector<'static, Drive>,
    /// For the main loop; a segment that is not taken before the next one closes is lost.
    closed: Option<Segment<Drive>>,
    ended: bool,
    tested: bool,
    failed: Option<&'static str>,
}

static INTERRUPT: Mutex<RefCell<Option<Interrupt>>> = Mutex::new(RefCell::new(None));

/// Runs `work` on the interrupt's data, with interrupts masked.
fn masked<T>(work: impl FnOnce(&mut Interrupt) -> T) -> Option<T> {
    interrupt::free(|cs| INTERRUPT.borrow(cs).borrow_mut().as_mut().map(work))
}

/// On a board, the interrupt at the end of the current conversion.
#[exception]
fn SysTick() {
    masked(|data| {
        if !data.tested {
            (data.tested, data.failed) = (true, detector::test().err());
            return;
        }
        match data.converters.next() {
            Some(reading) => {
                if let Some(segment) = detector::interrupt(&mut data.front_end, &mut data.detector, &reading) {
                    data.closed = Some(segment);
                }
            }
            None => data.ended = true,
        }
    });
}

#[entry]
fn main() -> ! {
    let (front_end, detector, mut monitor) = match detector::start() {
        Ok(parts) => parts,
        Err(message) => fail(message),
    };
    let converters = Converters::new();
    let data = Interrupt { converters, front_end, detector, closed: None, ended: false, tested: false, failed: None };
    interrupt::free(|cs| INTERRUPT.borrow(cs).replace(Some(data)));
    start_interrupt();
    loop {
        if let Some(segment) = masked(|data| data.closed.take()).flatten() {
            let now = monitor.conclude(segment); // now.silence: whether verdicts have been missing for too long, and why
            masked(|data| data.detector.adopt(now.report)); // for instrumental variables and --huber
            let alarm = if now.alarm.is_some() { ", ALARM" } else { "" };
            hprintln!("{}, {} rows{}", detector::name(now.report.verdict), now.report.rows, alarm);
        } else if masked(|data| data.ended) == Some(true) {
            debug::exit(debug::EXIT_SUCCESS); // the recording ended; a drive goes on, and calls `end_run` at power-down
        } else if let Some(message) = masked(|data| data.failed).flatten() {
            fail(message); // the interrupt computes otherwise than main
        }
        // The other work of the main loop; feed the watchdog here.
    }
}

fn start_interrupt() {
    let Some(peripherals) = Peripherals::take() else { fail("the peripherals are taken") };
    let mut timer = peripherals.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CYCLES - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

/// A drive goes into its safe state instead.
fn fail(message: &str) -> ! {
    hprintln!("{}", message);
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    fail("panic")
}
