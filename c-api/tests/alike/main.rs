//! The same happens to a drive whose firmware is in C and to one in Rust: their calls return the same at each reading.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

#[allow(dead_code, reason = "the front end is that of the test")]
#[path = "../../../examples/support/actuator/model.rs"]
mod actuator;
mod cases;
#[path = "../support/drive.rs"]
mod drive;
mod in_c;
mod in_rust;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../support/mod.rs"]
mod support;

use core::ptr::null_mut;

use bearing_watch::alarm::SilenceLimits;
use bearing_watch::drive::{FrontEndConstants, RawSample};
use bearing_watch::model::EvidenceConstants;
use bearing_watch::watch::StartError;
use bearing_watch::{LivenessLimits, Model};
use bearing_watch_c::*;

use actuator::{Drive, MODEL};
use cases::{Action, CASES, Case, READINGS, SEGMENT, Told};
use drive::{CONSTANTS, for_c, raw, raw_for_c};
use in_c::C;
use in_rust::{Own, Rust};
use support::{ACTUATOR, Memory};

const LIMITS: LivenessLimits = LivenessLimits { sample_s: 0.4, segment_s: 1.5, verdict_s: 99.0 };
const SILENCE: SilenceLimits = SilenceLimits { segments: 2, hours: 0.0 };

/// One of the two languages.
trait Side {
    fn sample(&mut self, reading: &RawSample<2>);
    fn collect(&mut self);
    fn advance(&mut self) -> Option<Told>;
    fn clock(&mut self, milliseconds: u32) -> Option<Told>;
    fn act(&mut self, action: Action) -> bool;
    /// What was lost, counts of refusals, and the saved state.
    fn end(&mut self) -> ([u32; 3], BwFrontEndFaults, Vec<u8>);
}

/// The model with short segments, and an alarm after a few defects.
fn model() -> &'static Model<Drive> {
    let mut constants = MODEL.constants().clone();
    constants.sampling.segment_samples = SEGMENT;
    constants.evidence = EvidenceConstants { bet: 0.2, limit: 1.0, cap: 5.0, ..EvidenceConstants::NONE };
    Box::leak(Box::new(Drive::model(constants).expect("a good model")))
}

/// Runs the case; returns what the calls of a side return, with the number of the reading.
fn run(case: &Case, side: &mut dyn Side) -> Vec<(u32, Told)> {
    let mut told = Vec::new();
    for number in 0..6 * READINGS {
        let mut reading = raw(number);
        if (case.reading)(number, &mut reading) {
            side.sample(&reading);
        }
        if (case.collects)(number) {
            side.collect();
        }
        if (case.advances)(number) {
            told.extend((0..40).filter_map(|_| side.advance()).map(|own| (number, own)));
        }
        let milliseconds = (u64::from(number) * u64::from(case.ms) / 1000) as u32;
        told.extend(side.clock(milliseconds).map(|own| (number, own)));
        let now = case.actions.iter().filter(|(at, _)| *at == number);
        told.extend(now.map(|(_, action)| (number, Told::Done(side.act(*action)))));
    }
    told
}

#[test]
fn what_happens_to_a_drive_is_told_alike() {
    let model = model();
    for case in CASES {
        let (mut rust, mut c) = (Rust::new(model), C::new(model));
        let (own, other) = (run(&case, &mut rust), run(&case, &mut c));
        let differ = own.iter().zip(&other).find(|(own, other)| own != other);
        assert!(own == other, "{}: {differ:?} of {} and {}", case.name, own.len(), other.len());
        assert!((case.expected)(&own), "{}: {own:#?}", case.name);
        let (own, other) = (rust.end(), c.end());
        assert_eq!((own.0, own.1), (other.0, other.1), "{}", case.name);
        assert!(own.2 == other.2, "{}: the saved states", case.name);
    }
}

/// A start: what is wrong with it, and with what both refuse it.
type Start = (&'static str, fn(&mut FrontEndConstants), fn(&StartError) -> bool, BwCode);

const STARTS: [Start; 5] = [
    (
        "a control rate that is no number",
        |own| own.control_rate_hz = f32::NAN,
        |error| matches!(error, StartError::FrontEnd(_)),
        BwCode::FrontEndControlRate,
    ),
    (
        "a sensor without a gain",
        |own| own.sensors[1].gain_a = 0.0,
        |error| matches!(error, StartError::FrontEnd(_)),
        BwCode::FrontEndSensor,
    ),
    (
        "another rate than that of the training",
        |own| own.control_rate_hz = 9_000.0,
        |error| matches!(error, StartError::Model(_)),
        BwCode::ModelInterval,
    ),
    (
        "the other sign convention",
        |own| own.frame.park = bearing_watch::Park::Thesis,
        |error| matches!(error, StartError::Model(_)),
        BwCode::ModelPark,
    ),
    (
        "no pole pairs",
        |own| own.frame.pole_pairs = 0,
        |error| matches!(error, StartError::FrontEnd(_)),
        BwCode::FrontEndPolePairs,
    ),
];

#[test]
fn a_refused_start_leaves_nothing_running_and_a_right_one_follows() {
    for (name, change, refusal, code) in STARTS {
        let mut constants = CONSTANTS;
        change(&mut constants);
        let watch: &'static Own = Box::leak(Box::default());
        let error = watch.start(&MODEL, &constants).expect_err(name);
        assert!(refusal(&error), "{name}: {error}");
        assert!(!watch.sample(raw(0)) && watch.monitor(|_| ()).is_none(), "{name}");
        let mut memory = Memory::new();
        assert_eq!(memory.drive(ACTUATOR, &for_c(&constants, 10, 2)), Err(code), "{name}");
        let state = memory.address().cast();
        // SAFETY: the memory is that of a state, but none runs there.
        unsafe {
            assert_eq!(bw_sample_raw(state, &raw_for_c(&raw(0)), [0.0; 2].as_ptr(), 2), BwCode::NotInitialised);
            assert_eq!(bw_advance(state, null_mut(), null_mut()), BwCode::NotInitialised);
        }
        assert_eq!(watch.start(&MODEL, &CONSTANTS), Ok(()), "{name}");
        assert_eq!(memory.drive(ACTUATOR, &for_c(&CONSTANTS, 10, 2)), Ok(state), "{name}");
        // A start of what runs is refused, and it goes on.
        assert_eq!(watch.start(&MODEL, &CONSTANTS), Err(StartError::Started));
        assert!(watch.sample(raw(0)));
    }
}
