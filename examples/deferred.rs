//! The interrupt samples, the main loop solves: [`Detector::collect`](bearing_watch::Detector::collect) hands a closed
//! segment out, `Model::conclude` (or `Solver::advance`, a piece at a time) makes the report, and `Detector::adopt`
//! brings its estimate back as auxiliary model. Three ways print the same bits: solved at once in the interrupt,
//! deferred as a whole, and deferred by pieces, one a sample.
//!
//! **How large must `handover` be?** The estimate has to be back before that many samples of the next segment have been
//! taken; else `adopt` gives `false`, and the old auxiliary model stays for a segment. Count the samples taken between
//! the one that closes the segment and `adopt`:
//!
//! ```text
//! whole       (solve + classification + the longest other work of the main loop) / (interval − interrupt), rounded up
//! by pieces   n + 3, if every sample lets one piece run
//! handover    one more than that
//! ```
//!
//! Here n = 8: eleven pieces, at least 12; 16 leaves room. Rows are withheld for `handover + settle` samples of every
//! segment, so a large handover costs rows, no accuracy beyond that.
//!
//! On a chip the `SysTick` exception is the sampling interrupt. On the host, which has none, the same function is called
//! wherever the main loop waits for a sample.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use bearing_watch::{Detector, Report, Segment, Solver, Verdict};

use support::refined::{MODEL, Plant, Refined};
use timer::with;

/// Segments of each way.
const SEGMENTS: usize = 6;

main!(run);

/// What interrupt and main loop share.
struct Shared {
    plant: Plant,
    detector: Detector<'static, Refined>,
    /// The closed segment until the main loop takes it.
    closed: Option<Segment<Refined>>,
    /// Closed segments that the main loop was too late for.
    missed: u32,
    /// Samples taken.
    samples: u32,
}

impl Shared {
    fn new() -> Self {
        Self { plant: Plant::new(17), detector: Detector::new(&MODEL), closed: None, missed: 0, samples: 0 }
    }

    /// The interrupt: one sample, always in about the same time.
    fn interrupt(&mut self) {
        self.samples = self.samples.wrapping_add(1);
        let sample = self.plant.sample();
        if let Some(segment) = self.detector.collect(&sample)
            && self.closed.replace(segment).is_some()
        {
            self.missed += 1;
        }
    }
}

fn run() {
    let mut shared = Shared::new();
    let mut inline = [0; SEGMENTS];
    for (number, hash) in inline.iter_mut().enumerate() {
        let report = loop {
            let sample = shared.plant.sample();
            if let Some(report) = shared.detector.step(&sample) {
                break report;
            }
        };
        *hash = told("inline", number, &report);
    }
    let whole = deferred("whole", |segment| MODEL.conclude(segment));
    let pieces = deferred("by pieces", |segment| {
        let mut solver = Solver::new(&MODEL, segment);
        loop {
            if let Some(report) = solver.advance() {
                break report.clone();
            }
            wait_for_a_sample();
        }
    });
    say!("whole as inline: {}, by pieces as inline: {}", whole == inline, pieces == inline);
}

/// The main loop of a drive that defers the solve.
fn deferred(way: &str, mut conclude: impl FnMut(Segment<Refined>) -> Report<Refined>) -> [u32; SEGMENTS] {
    timer::start(Some(Shared::new()));
    let mut hashes = [0; SEGMENTS];
    for (number, hash) in hashes.iter_mut().enumerate() {
        let segment = loop {
            // The copy of a segment is all that happens with the interrupt held off.
            if let Some(segment) = with(|shared| shared.closed.take()).flatten() {
                break segment;
            }
            wait_for_a_sample();
        };
        let report = conclude(segment);
        let adopted = with(|shared| shared.detector.adopt(&report));
        if adopted != Some(true) {
            say!("{way}: segment {number} was not adopted");
        }
        *hash = told(way, number, &report);
    }
    let missed = with(|shared| shared.missed);
    timer::stop();
    if missed != Some(0) {
        say!("{way}: segments were missed");
    }
    hashes
}

/// Prints a report; gives the hash of its bits.
fn told(way: &str, number: usize, report: &Report<Refined>) -> u32 {
    let mut hash = support::hash::Hash::new();
    if let Some(estimate) = report.estimate() {
        hash.add_estimate(estimate);
    }
    report.decision.iter().for_each(|decision| hash.add(decision.log_likelihoods()));
    let (rows, bits) = (report.rows, hash.bits());
    match report.verdict {
        Verdict::Class(class) => say!("{way} {number}: {rows} rows, {bits:08x}, {}", MODEL.label(class)),
        Verdict::Novel => say!("{way} {number}: {rows} rows, {bits:08x}, novel"),
        Verdict::Ambiguous => say!("{way} {number}: {rows} rows, {bits:08x}, ambiguous"),
        Verdict::Undetermined(reason) => say!("{way} {number}: {rows} rows, {bits:08x}, {reason}"),
    }
    bits
}

fn wait_for_a_sample() {
    let samples = || with(|shared| shared.samples);
    let before = samples();
    timer::host_turn();
    // Awake, since a sleeping core in the emulator would wait in real time.
    while before.is_some() && samples() == before {
        core::hint::spin_loop();
    }
}

/// The sampling timer of the chip, and what it shares.
#[cfg(target_os = "none")]
mod timer {
    use core::cell::RefCell;

    use cortex_m::interrupt::{self, Mutex};
    use cortex_m::peripheral::{Peripherals, SYST, syst::SystClkSource};
    use cortex_m_rt::exception;

    use super::Shared;

    /// Ticks of the core's clock: a millisecond of an STM32F405, and room for the solve also without a floating-point
    /// unit.
    const INTERVAL: u32 = 168_000;

    static SHARED: Mutex<RefCell<Option<Shared>>> = Mutex::new(RefCell::new(None));
    static TIMER: Mutex<RefCell<Option<SYST>>> = Mutex::new(RefCell::new(None));

    /// Runs `work` with the interrupt held off.
    pub fn with<T>(work: impl FnOnce(&mut Shared) -> T) -> Option<T> {
        interrupt::free(|section| SHARED.borrow(section).try_borrow_mut().ok()?.as_mut().map(work))
    }

    pub fn start(shared: Option<Shared>) {
        let timer = Peripherals::take().map(|peripherals| peripherals.SYST);
        interrupt::free(|section| {
            if let Ok(mut place) = SHARED.borrow(section).try_borrow_mut() {
                *place = shared;
            }
            let Ok(mut place) = TIMER.borrow(section).try_borrow_mut() else { return };
            if timer.is_some() {
                *place = timer;
            }
            if let Some(timer) = place.as_mut() {
                timer.set_clock_source(SystClkSource::Core);
                timer.set_reload(INTERVAL - 1);
                timer.clear_current();
                timer.enable_interrupt();
                timer.enable_counter();
            }
        });
    }

    pub fn stop() {
        interrupt::free(|section| {
            if let Ok(mut place) = TIMER.borrow(section).try_borrow_mut()
                && let Some(timer) = place.as_mut()
            {
                timer.disable_counter();
                timer.disable_interrupt();
            }
        });
    }

    #[exception]
    fn SysTick() {
        with(Shared::interrupt);
    }

    /// The chip's interrupt comes by itself.
    pub fn host_turn() {}
}

/// The host's stand-in: its interrupt comes when the main loop waits.
#[cfg(not(target_os = "none"))]
mod timer {
    use std::cell::RefCell;

    use super::Shared;

    thread_local! {
        static SHARED: RefCell<Option<Shared>> = const { RefCell::new(None) };
    }

    pub fn with<T>(work: impl FnOnce(&mut Shared) -> T) -> Option<T> {
        SHARED.with_borrow_mut(|shared| shared.as_mut().map(work))
    }

    pub fn start(shared: Option<Shared>) {
        SHARED.set(shared);
    }

    pub fn stop() {}

    pub fn host_turn() {
        with(Shared::interrupt);
    }
}
