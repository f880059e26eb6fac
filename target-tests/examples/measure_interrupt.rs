//! The interrupts of a drive, as README has them: instructions of a row of raw counts in the current loop, and of a
//! clean sample in the interrupt below it, one JSON object a line.
//!
//! The model is that of `examples/support/actuator`, with shorter segments: three currents, a converter of 14 bits, two
//! further channels, decimation from 10 kHz to 1 kHz, least squares of 8 parameters, shaft with four orders of three
//! harmonics. `cargo xtask pil` counts both together on a recording.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

/// Written by `bearing-watch train --front-end … --rust`.
#[allow(dead_code, reason = "the position is not counted, and nothing is printed of the model")]
mod model {
    include!(env!("BEARING_WATCH_MODEL_FILE"));
}

use core::hint::black_box;

use bearing_watch::Model;
use bearing_watch::drive::{PhaseCounts, RawSample};
use static_cell::StaticCell;

use model::{Drive, DriveFrontEnd, FRONT_END, FURTHER, MODEL, WATCH};
use support::count::Counter;
use support::raw::{Motor, Sensors};

/// The model with shorter segments.
static SHORT: StaticCell<Model<Drive>> = StaticCell::new();

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
    let Ok(short) = Model::new(MODEL.plan(), constants) else { return say!("no model with short segments") };
    if WATCH.start(black_box(SHORT.init(short)), &FRONT_END).is_err() {
        return say!("the drive does not start");
    }
    // It tells what the samples are that the other one counts.
    let Ok(mut front_end) = DriveFrontEnd::new(&FRONT_END) else { return say!("no front end") };
    let mut motor = Motor::<FURTHER>::new(Sensors::Converter);
    for _ in 0..WARM {
        let raw = row(&mut motor, 0);
        front_end.push(&raw);
        _ = WATCH.sample(raw);
        WATCH.collect();
    }
    let (mut rows, mut samples, mut closing, mut discarding) = ([0; 3], [0; 3], 0, 0);
    for number in 0..ROWS + FAULTY {
        let raw = row(&mut motor, if number < ROWS { 0 } else { ERROR });
        let clean = front_end.push(&raw);
        add(&mut rows, counter.instructions_once(|| _ = WATCH.sample(black_box(raw))), number < ROWS);
        if let Some(clean) = clean {
            let mut closed = false;
            let taken = counter.instructions_once(|| closed = WATCH.collect());
            match (closed, clean.found_late) {
                (true, _) => closing = taken.max(closing),
                (false, true) => discarding = taken.max(discarding),
                (false, false) => add(&mut samples, taken, number < ROWS),
            }
        }
        // The main loop does its steps between two rows.
        WATCH.advance(|_| ());
    }
    if closing == 0 || discarding == 0 || WATCH.status().lost_samples > 0 {
        say!("no segment was closed, no fault was found, or a sample was lost");
    }
    line("current loop of a drive, mean row", mean(rows));
    line("current loop of a drive, longest row", rows[2]);
    line("below the current loop, mean sample", mean(samples));
    line("below the current loop, longest sample", samples[2]);
    line("below the current loop, sample that closes", closing);
    line("below the current loop, sample that discards", discarding);
}

/// Adds to sum and number, if the data are good, and to the longest.
fn add([sum, number, longest]: &mut [u32; 3], taken: u32, good: bool) {
    *longest = taken.max(*longest);
    if good {
        (*sum, *number) = (*sum + taken, *number + 1);
    }
}

fn mean([sum, number, _]: [u32; 3]) -> u32 {
    sum / number.max(1)
}

/// A row of the motor with its third current, and an error of the first one.
fn row(motor: &mut Motor<FURTHER>, error: u16) -> RawSample<FURTHER> {
    let raw = motor.sample();
    let currents = match raw.currents {
        PhaseCounts::Two([a, b]) => PhaseCounts::Three([a.saturating_add(error), b, 3 * 2048 - a - b]),
        currents @ (PhaseCounts::Quadrature(_) | PhaseCounts::Three(_)) => currents,
    };
    RawSample { currents, ..raw }
}

fn line(what: &str, instructions: u32) {
    say!(r#"{{"name":"{what}","n":10,"instructions":{instructions},"bytes":null}}"#);
}
