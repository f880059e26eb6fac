//! The interrupt of a drive, as README has it: instructions of a row of raw counts, one JSON object a line.
//!
//! The model is that of `examples/support/actuator`, with shorter segments: three currents, a converter of 14 bits, two
//! further channels, decimation from 10 kHz to 1 kHz, least squares of 8 parameters, shaft with four orders of three
//! harmonics. `cargo xtask pil` counts the same on a recording.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

/// Written by `bearing-watch train --front-end … --rust`.
#[allow(dead_code, reason = "the position is not counted, and nothing is printed of the model")]
mod model {
    include!(env!("BEARING_WATCH_MODEL_FILE"));
}

use core::hint::black_box;

use bearing_watch::drive::{PhaseCounts, RawSample};
use bearing_watch::{Detector, Exchange, Model, Monitor, Segment};

use model::{Drive, DriveFrontEnd, FRONT_END, FURTHER, MODEL};
use support::count::Counter;
use support::raw::{Motor, Sensors};

/// Samples of a segment, at the rate of identification.
const SEGMENT: u32 = 600;
/// Rows before the first one that is counted: the tracking settles and the filters fill.
const WARM: u32 = 2000;
/// Rows that are counted: those of a segment and some.
const ROWS: u32 = 6500;
/// Rows with a wrong gain of a current, which the front end finds after a window.
const FAULTY: u32 = 3000;
/// The error of the first current in these rows, in counts.
const ERROR: u16 = 300;

main!(run);

fn run() {
    let Some(counter) = &mut Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask measure");
        return;
    };
    let mut constants = MODEL.constants().clone();
    constants.sampling.segment_samples = SEGMENT;
    let Ok(model) = Model::new(MODEL.plan(), constants) else { return say!("no model with short segments") };
    let Ok(front_end) = DriveFrontEnd::new(&FRONT_END) else { return say!("no front end") };
    let [mut one, mut other] = [(); 2].map(|()| Segment::new(&model));
    let detector = Detector::with_place(black_box(&model), &mut one);
    let mut drive = Interrupt { front_end, detector, spare: Some(&mut other), closed: None };
    let mut monitor = Monitor::new(&model);
    let mut motor = Motor::<FURTHER>::new(Sensors::Converter);
    for _ in 0..WARM {
        drive.row(&row(&mut motor, 0));
        drive.give_back(&mut monitor);
    }
    let (mut sum, mut longest, mut closing, mut discarding) = (0, 0, 0, 0);
    for number in 0..ROWS + FAULTY {
        let raw = row(&mut motor, if number < ROWS { 0 } else { ERROR });
        let mut event = Event::None;
        let taken = counter.instructions_once(|| event = drive.row(black_box(&raw)));
        drive.give_back(&mut monitor);
        match event {
            Event::Closed => closing = taken,
            Event::Discarded => discarding = taken.max(discarding),
            Event::None => longest = taken.max(longest),
        }
        if number < ROWS {
            sum += taken;
        }
    }
    if closing == 0 || discarding == 0 {
        say!("no segment was closed, or no fault was found");
    }
    line("mean row", sum / ROWS);
    line("longest row", longest);
    line("row that closes", closing);
    line("row that discards", discarding);
}

/// What a row caused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Event {
    None,
    Closed,
    Discarded,
}

/// What the interrupt works on.
struct Interrupt<'a> {
    front_end: DriveFrontEnd,
    detector: Detector<'a, Drive, &'a mut Segment<Drive>>,
    spare: Option<&'a mut Segment<Drive>>,
    closed: Option<&'a mut Segment<Drive>>,
}

impl Interrupt<'_> {
    fn row(&mut self, raw: &RawSample<FURTHER>) -> Event {
        let Some(clean) = self.front_end.push(raw) else { return Event::None };
        let found_late = clean.found_late;
        if found_late {
            self.detector.discard();
        }
        if let Exchange::Closed(place) = self.detector.exchange(&clean.into(), &mut self.spare) {
            self.closed = Some(place);
            return Event::Closed;
        }
        if found_late { Event::Discarded } else { Event::None }
    }

    /// What the main loop does with a closed segment.
    fn give_back(&mut self, monitor: &mut Monitor<'_, Drive>) {
        if let Some(place) = self.closed.take() {
            monitor.take_from(place);
            self.spare = Some(place);
        }
    }
}

/// A row of the motor with its third current, and an error of the first one.
fn row(motor: &mut Motor<FURTHER>, error: u16) -> RawSample<FURTHER> {
    let raw = motor.sample();
    let currents = match raw.currents {
        PhaseCounts::Two([a, b]) => PhaseCounts::Three([a.saturating_add(error), b, 3 * 2048 - a - b]),
        currents @ PhaseCounts::Three(_) => currents,
    };
    RawSample { currents, ..raw }
}

fn line(what: &str, instructions: u32) {
    say!(r#"{{"name":"interrupt of a drive, {what}","n":10,"instructions":{instructions},"bytes":null}}"#);
}
