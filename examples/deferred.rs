//! The interrupt samples, the main loop solves: [`Detector::exchange`](bearing_watch::Detector::exchange) returns the
//! place with the sums of a closed segment, `Monitor::take_from` takes it, `Monitor::complete` (or `Monitor::advance`,
//! a step at a time) makes the report, and `Detector::adopt` makes its estimate the auxiliary model. Three ways print
//! the same bits: solved at once in the interrupt, solved as a whole in the main loop, and solved there in steps. The
//! program fails if the bits differ, if a segment was lost, or if an estimate came too late to be adopted.
//!
//! **How large must `handover` be?** The estimate must be adopted before the next segment has `handover` samples.
//! Otherwise `adopt` returns `false`, and the old auxiliary model stays for one more segment. Let s be the number of
//! samples between the one that closes the segment and the call of `adopt`:
//!
//! ```text
//! as a whole   s = ⌈(solve + classification + longest other work of the main loop) / (interval − interrupt)⌉
//! in steps     s = ⌈number of steps / steps a sample⌉
//! handover     ≥ s + 1
//! ```
//!
//! The number of steps depends on the plan; the example prints it. With 14 steps and one a sample, s = 14 and
//! `handover` must be at least 15. All steps of a sample must fit into the interval beside the interrupt. Every
//! segment loses the rows of its first `handover + settle` samples; a large `handover` has no other cost.
//!
//! Two queues of `heapless` hand the places over, there and back: the interrupt owns one end of each and the main loop
//! the other, so the main loop takes and returns a place with the interrupt enabled. Only `adopt` is called with the
//! interrupt disabled.
//!
//! On a chip the `SysTick` exception is the sampling interrupt. The host has none: there, the main loop calls the same
//! function where it waits for a sample.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use bearing_watch::{Detector, Exchange, Monitor, Report, Segment, Verdict};
use heapless::spsc;

use support::refined::{MODEL, Plant, Refined};
use timer::with;

/// Number of segments of each way.
const SEGMENTS: usize = 6;

/// Steps of a solve that the main loop runs between two samples.
const STEPS_A_SAMPLE: u32 = 1;

/// Room for a segment.
type Place = &'static mut Segment<Refined>;

/// Holds one place: a queue of this kind has room for one more than it can hold.
type Queue = spsc::Queue<Place, 2>;

/// The interrupt's ends of the queues, of closed places and of free ones.
type Ends = (spsc::Producer<'static, Place>, spsc::Consumer<'static, Place>);

/// The main loop's ends.
struct Closed {
    places: spsc::Consumer<'static, Place>,
    free: spsc::Producer<'static, Place>,
}

main!(run);

/// Samples taken so far.
static SAMPLES: AtomicU32 = AtomicU32::new(0);

/// What the interrupt works on.
struct Shared {
    plant: Plant,
    detector: Detector<'static, Refined, Place>,
    ends: Ends,
    spare: Option<Place>,
    /// Number of closed segments whose next one had no place.
    lost: u32,
}

impl Shared {
    const SEED: u32 = 17;

    fn new((first, second): (Place, Place), ends: Ends) -> Self {
        let detector = Detector::with_place(&MODEL, first);
        Self { plant: Plant::new(Self::SEED), detector, ends, spare: Some(second), lost: 0 }
    }

    /// Starts the same samples again.
    fn restart(&mut self) {
        self.plant = Plant::new(Self::SEED);
        self.detector.restart();
        self.lost = 0;
    }

    /// The interrupt: one sample, always in about the same time.
    fn interrupt(&mut self) {
        SAMPLES.fetch_add(1, Relaxed);
        let sample = self.plant.sample();
        let (closed, free) = &mut self.ends;
        if self.spare.is_none() {
            self.spare = free.dequeue();
        }
        match self.detector.exchange(&sample, &mut self.spare) {
            Exchange::Open => {}
            // Of two places one is open: there is room for the other.
            Exchange::Closed(place) => drop(closed.enqueue(place)),
            Exchange::Lost => self.lost += 1,
        }
    }
}

fn run() {
    let inline = inline();
    let (Some(places), Some((there, back))) = (places!(&MODEL, Refined), timer::queues()) else { return };
    let ((closing, closed), (free, freed)) = (there.split(), back.split());
    timer::start(Shared::new(places, (closing, freed)));
    let mut closed = Closed { places: closed, free };
    let mut monitor = Monitor::new(&MODEL);
    let whole = deferred("whole", &mut closed, |place| {
        monitor.take_from(place);
        loop {
            if let Some(now) = monitor.complete() {
                return now.report.clone();
            }
        }
    });
    let mut steps = 0;
    let in_steps = deferred("in steps", &mut closed, |place| {
        let (report, count) = conclude_in_steps(&mut monitor, place);
        steps = count.max(steps);
        report
    });
    timer::stop();
    say!("a solve has {steps} steps, {STEPS_A_SAMPLE} a sample");
    say!("whole as inline: {}, in steps as inline: {}", whole == inline, in_steps == inline);
    assert!(whole == inline && in_steps == inline, "the ways differ");
}

/// The hashes of reports that are solved with the sample that closes the segment.
fn inline() -> [u32; SEGMENTS] {
    let (mut plant, mut detector) = (Plant::new(Shared::SEED), Detector::new(&MODEL));
    core::array::from_fn(|number| {
        let report = loop {
            if let Some(report) = detector.step(&plant.sample()) {
                break report;
            }
        };
        print("inline", number, &report)
    })
}

/// The main loop of a drive that defers the solve; returns the hashes of the reports.
fn deferred(
    way: &str,
    closed: &mut Closed,
    mut conclude: impl FnMut(&mut Segment<Refined>) -> Report<Refined>,
) -> [u32; SEGMENTS] {
    with(|shared| {
        while let Some(place) = closed.places.dequeue() {
            drop(closed.free.enqueue(place));
        }
        shared.restart();
    });
    let hashes = core::array::from_fn(|number| {
        let place = loop {
            if let Some(place) = closed.places.dequeue() {
                break place;
            }
            wait_for_a_sample();
        };
        let report = conclude(place);
        drop(closed.free.enqueue(place));
        let adopted = with(|shared| shared.detector.adopt(&report));
        assert!(adopted == Some(true), "{way}: segment {number} was not adopted");
        print(way, number, &report)
    });
    assert!(with(|shared| shared.lost) == Some(0), "{way}: segments were lost");
    hashes
}

/// The report, and the number of its steps.
fn conclude_in_steps(monitor: &mut Monitor<'_, Refined>, place: &mut Segment<Refined>) -> (Report<Refined>, u32) {
    monitor.take_from(place);
    let mut steps = 0_u32;
    loop {
        steps += 1;
        if let Some(now) = monitor.advance() {
            return (now.report.clone(), steps);
        }
        if steps.is_multiple_of(STEPS_A_SAMPLE) {
            wait_for_a_sample();
        }
    }
}

/// Prints a report; returns the hash of its bits.
fn print(way: &str, number: usize, report: &Report<Refined>) -> u32 {
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
    let before = SAMPLES.load(Relaxed);
    timer::interrupt_of_host();
    // No sleep: in the emulator a sleeping core waits in real time.
    while SAMPLES.load(Relaxed) == before {
        core::hint::spin_loop();
    }
}

/// The sampling timer of the chip, and what it shares.
#[cfg(target_os = "none")]
mod timer {
    use core::cell::RefCell;

    use cortex_m::asm;
    use cortex_m::interrupt::{self, Mutex};
    use cortex_m::peripheral::{Peripherals, SYST, syst::SystClkSource};
    use cortex_m_rt::exception;

    use super::{Queue, Shared};

    /// From sample to sample, rounds of a loop of two instructions: enough for the interrupt and the steps of a
    /// sample.
    const INTERVAL: u32 = 5_000;
    /// Largest value of the timer.
    const MOST: u32 = 0x00FF_FFFF;

    static SHARED: Mutex<RefCell<Option<Shared>>> = Mutex::new(RefCell::new(None));
    static TIMER: Mutex<RefCell<Option<SYST>>> = Mutex::new(RefCell::new(None));

    /// The static queues, once.
    pub fn queues() -> Option<(&'static mut Queue, &'static mut Queue)> {
        let there = cortex_m::singleton!(: Queue = Queue::new());
        there.zip(cortex_m::singleton!(: Queue = Queue::new()))
    }

    /// Runs `work` with the interrupt disabled.
    pub fn with<T>(work: impl FnOnce(&mut Shared) -> T) -> Option<T> {
        interrupt::free(|section| SHARED.borrow(section).try_borrow_mut().ok()?.as_mut().map(work))
    }

    pub fn start(shared: Shared) {
        let Some(Peripherals { SYST: mut timer, .. }) = Peripherals::take() else { return };
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(MOST);
        timer.clear_current();
        timer.enable_counter();
        // Measured, since each machine of the emulator has another number of ticks for an instruction.
        let before = SYST::get_current();
        asm::delay(INTERVAL);
        let ticks = before.wrapping_sub(SYST::get_current()) & MOST;
        timer.set_reload(ticks);
        timer.clear_current();
        timer.enable_interrupt();
        interrupt::free(|section| {
            SHARED.borrow(section).replace(Some(shared));
            TIMER.borrow(section).replace(Some(timer));
        });
    }

    pub fn stop() {
        if let Some(mut timer) = interrupt::free(|section| TIMER.borrow(section).take()) {
            timer.disable_counter();
            timer.disable_interrupt();
        }
    }

    #[exception]
    fn SysTick() {
        with(Shared::interrupt);
    }

    /// Nothing: the chip's interrupt comes by itself.
    pub fn interrupt_of_host() {}
}

/// The host's stand-in: its interrupt comes when the main loop waits.
#[cfg(not(target_os = "none"))]
mod timer {
    use std::cell::RefCell;

    use super::{Queue, Shared};

    thread_local! {
        static SHARED: RefCell<Option<Shared>> = const { RefCell::new(None) };
    }

    pub fn queues() -> Option<(&'static mut Queue, &'static mut Queue)> {
        Some((Box::leak(Box::new(Queue::new())), Box::leak(Box::new(Queue::new()))))
    }

    pub fn with<T>(work: impl FnOnce(&mut Shared) -> T) -> Option<T> {
        SHARED.with_borrow_mut(|shared| shared.as_mut().map(work))
    }

    pub fn start(shared: Shared) {
        SHARED.set(Some(shared));
    }

    pub fn stop() {}

    pub fn interrupt_of_host() {
        with(Shared::interrupt);
    }
}
