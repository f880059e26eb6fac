//! A drive that watches its bearings: interrupt and main loop around the code in `detector.rs`.

#![no_std]
#![no_main]

mod converters;
mod detector;
mod model;

use core::cell::RefCell;
use core::panic::PanicInfo;

use bearing_watch::Segment;
use cortex_m::interrupt::{self, Mutex};
use cortex_m::peripheral::Peripherals;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::singleton;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::{debug, hprintln};

use converters::Converters;
use detector::{Place, Sampler};
use model::{Drive, MODEL};

/// Clock cycles between two interrupts: 0.5 ms at 168 MHz. The emulator executes only 3.9 instructions in 1 µs, so the
/// recording of 10 kHz is played at 2 kHz.
const CYCLES: u32 = 84_000;

/// What the interrupt works on. If the current loop interrupts this one, use locks that mask only some priorities:
/// `frameworks/rtic` of bearing-watch shows that.
struct Interrupt {
    converters: Converters,
    sampler: Sampler,
    /// For the main loop; it gives the place back before the next segment closes, or that one is lost.
    closed: Option<Place>,
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
                if let Some(place) = detector::interrupt(&mut data.sampler, &reading) {
                    data.closed = Some(place);
                }
            }
            None => data.ended = true,
        }
    });
}

#[entry]
fn main() -> ! {
    let first = singleton!(: Segment<Drive> = Segment::new(&MODEL));
    let second = singleton!(: Segment<Drive> = Segment::new(&MODEL));
    let (Some(first), Some(second)) = (first, second) else { fail("the places are taken") };
    let (sampler, mut monitor) = match detector::start(first, second) {
        Ok(parts) => parts,
        Err(message) => fail(message),
    };
    let converters = Converters::new();
    let data = Interrupt { converters, sampler, closed: None, ended: false, tested: false, failed: None };
    interrupt::free(|cs| INTERRUPT.borrow(cs).replace(Some(data)));
    start_interrupt();
    loop {
        if let Some(place) = masked(|data| data.closed.take()).flatten() {
            // now.silence says whether verdicts have been missing for too long, and why.
            let now = monitor.conclude_from(place);
            masked(|data| data.sampler.spare = Some(place));
            masked(|data| data.sampler.detector.adopt(now.report)); // for instrumental variables and --huber
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
