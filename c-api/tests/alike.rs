//! One table of what may happen to a drive: in C and in Rust the same calls are told the same, at the same reading.
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
#[path = "../../examples/support/actuator/model.rs"]
mod actuator;
#[path = "support/drive.rs"]
mod drive;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::mem::MaybeUninit;
use core::ptr::null_mut;

use bearing_watch::alarm::SilenceLimits;
use bearing_watch::drive::{FrontEndConstants, PhaseCounts, Position, RawSample};
use bearing_watch::model::EvidenceConstants;
use bearing_watch::watch::{Lapse, StartError, Watch};
use bearing_watch::{Alarm, Cause, Conclusion, LivenessLimits, Model, Monitor, Reason, Verdict};
use bearing_watch_c::*;

use actuator::{Drive, DriveFrontEnd, MODEL};
use drive::{CONSTANTS, for_c, raw, raw_for_c};
use support::{ACTUATOR, Memory, bytes};

/// Clean samples of a segment, and readings: of 0.6 s, so that many things happen soon.
const SEGMENT: u32 = 600;
const READINGS: u32 = 10 * SEGMENT;

/// What a context is told.
#[derive(Clone, Debug, PartialEq)]
enum Told {
    /// Report and alarm, and whether the report is one that is withdrawn.
    Report(bool, Fields),
    /// By the clock.
    Lapse(BwCode),
    /// Of an action.
    Done(bool),
}

/// The fields of report and alarm that both have.
#[derive(Clone, Debug, PartialEq)]
struct Fields {
    verdict: BwVerdict,
    /// Class, and numbers of features that are missing.
    class: [u8; 2],
    reason: String,
    /// Segment, rows, rejected and saturated samples.
    counts: [u32; 4],
    /// Distance, surprise, score of the alarm.
    bits: [u32; 3],
    /// Coordinate that departs most, and whether it falls.
    most: Option<(u8, bool)>,
    /// The alarm with its segment, and the silence with its segments.
    alarm: Option<Alarm>,
    silence: Option<u32>,
}

/// What a drive can do in its main loop.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Action {
    Deny,
    Reset,
    Restart,
    ClearFaults,
    /// Ends the run, stops, starts anew and continues from the saved state.
    PowerOff,
    LimitSilence,
}

/// A drive to which something happens.
struct Case {
    name: &'static str,
    /// Changes a reading; `false` if its interrupt is missed.
    reading: fn(u32, &mut RawSample<2>) -> bool,
    /// Whether the lower interrupt, and the main loop, run behind this reading.
    collects: fn(u32) -> bool,
    advances: fn(u32) -> bool,
    /// Milliseconds of the clock for a thousand readings.
    ms: u32,
    actions: &'static [(u32, Action)],
    /// What is expected to be among what both are told.
    expected: fn(&[(u32, Told)]) -> bool,
}

const ALWAYS: fn(u32) -> bool = |_| true;
const USUAL: Case = Case {
    name: "a drive",
    reading: |_, _| true,
    collects: ALWAYS,
    advances: ALWAYS,
    ms: 100,
    actions: &[],
    expected: |told| reports(told, |own| own.reason == "None") >= 3,
};

/// Number of reports of which something holds.
fn reports(told: &[(u32, Told)], holds: impl Fn(&Fields) -> bool) -> usize {
    told.iter().filter(|(_, told)| matches!(told, Told::Report(false, own) if holds(own))).count()
}

fn withdrawn(told: &[(u32, Told)]) -> usize {
    let lost = |told: &Told| matches!(told, Told::Report(true, own) if own.reason == "FoundLate");
    told.iter().filter(|(_, told)| lost(told)).count()
}

/// A sensor of the wrong gain from this reading of the fourth segment on.
fn wrong_gain(from: u32, number: u32, raw: &mut RawSample<2>) -> bool {
    if let (true, PhaseCounts::Three([a, ..])) = (number > 3 * READINGS + from, &mut raw.currents) {
        *a = (32_768.0 + 1.3 * (f32::from(*a) - 32_768.0)) as u16;
    }
    true
}

const CASES: [Case; 13] = [
    USUAL,
    Case {
        name: "a fault that is found late",
        reading: |number, raw| wrong_gain(100, number, raw),
        expected: |told| withdrawn(told) == 1,
        ..USUAL
    },
    Case {
        name: "one whose report the main loop did not give yet",
        reading: |number, raw| wrong_gain(100, number, raw),
        advances: |number| !(3 * READINGS..3 * READINGS + 1_500).contains(&number),
        expected: |told| withdrawn(told) == 1,
        ..USUAL
    },
    Case {
        name: "one that is found in the second half of a segment",
        reading: |number, raw| wrong_gain(4_200, number, raw),
        expected: |told| withdrawn(told) == 0,
        ..USUAL
    },
    Case { name: "samples that are lost", collects: |number| !(4_000..4_200).contains(&number), ..USUAL },
    Case {
        name: "segments that are lost",
        advances: |number| !(4_000..13_000).contains(&number),
        expected: |told| reports(told, |own| own.reason == "None") == 2,
        ..USUAL
    },
    Case {
        name: "readings that are missed, and an angle that is missing",
        reading: |number, raw| {
            if (7_000..7_100).contains(&number) {
                raw.position = Position::Missing;
            }
            number % 2_500 != 0 || number == 0
        },
        expected: |told| reports(told, |own| own.reason == "TooFewRows") == 5,
        ..USUAL
    },
    Case {
        name: "exchanged phases",
        reading: |_, raw| {
            if let PhaseCounts::Three([_, b, c]) = &mut raw.currents {
                core::mem::swap(b, c);
            }
            true
        },
        expected: |told| reports(told, |own| own.reason == "Implausible") >= 3,
        ..USUAL
    },
    Case {
        name: "a wrong rate",
        ms: 5_000,
        expected: |told| told.iter().any(|(_, told)| *told == Told::Lapse(BwCode::WrongRate)),
        ..USUAL
    },
    Case {
        name: "an interrupt that comes no more",
        collects: |number| number < 15_000,
        expected: |told| told.iter().any(|(_, told)| *told == Told::Lapse(BwCode::NotCollected)),
        ..USUAL
    },
    Case {
        name: "a main loop that comes no more",
        advances: |number| number < 13_000,
        expected: |told| told.iter().any(|(_, told)| *told == Told::Lapse(BwCode::NoSegment)),
        ..USUAL
    },
    Case {
        name: "service",
        actions: &[
            (1, Action::LimitSilence),
            (4_000, Action::Deny),
            (6_500, Action::Restart),
            (6_600, Action::ClearFaults),
            (26_000, Action::Deny),
            (29_000, Action::Reset),
            (29_001, Action::Deny),
        ],
        expected: |told| reports(told, |own| own.alarm.is_some()) > 0 && told.contains(&(26_000, Told::Done(true))),
        ..USUAL
    },
    Case {
        name: "a run that goes on behind a power-off",
        actions: &[(15_500, Action::PowerOff)],
        expected: |told| reports(told, |own| own.counts[0] == 5) > 0,
        ..USUAL
    },
];

/// The model with short segments, and an alarm after a few defects.
fn model() -> &'static Model<Drive> {
    let mut constants = MODEL.constants().clone();
    constants.sampling.segment_samples = SEGMENT;
    constants.evidence = EvidenceConstants { bet: 0.2, limit: 1.0, cap: 5.0, ..EvidenceConstants::NONE };
    Box::leak(Box::new(Drive::model(constants).expect("a good model")))
}

const LIMITS: LivenessLimits = LivenessLimits { sample_s: 0.4, segment_s: 1.5, verdict_s: 99.0 };
const SILENCE: SilenceLimits = SilenceLimits { segments: 2, hours: 0.0 };

/// Runs the case; a side gives what its calls are told.
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

type Own = Watch<Drive, DriveFrontEnd>;

struct Rust(&'static Own, &'static Model<Drive>);

impl Rust {
    fn new(model: &'static Model<Drive>) -> Self {
        let watch: &'static Own = Box::leak(Box::default());
        watch.start(model, &CONSTANTS).expect("it starts");
        watch.limit_liveness(LIMITS);
        Self(watch, model)
    }
}

impl Side for Rust {
    fn sample(&mut self, reading: &RawSample<2>) {
        let _waits = self.0.sample(*reading);
    }

    fn collect(&mut self) {
        self.0.collect();
    }

    fn advance(&mut self) -> Option<Told> {
        self.0.advance(|now| Told::Report(now.withdrawn, fields(&now)))
    }

    fn clock(&mut self, milliseconds: u32) -> Option<Told> {
        self.0.clock(milliseconds).map(|lapse| {
            Told::Lapse(match lapse {
                Lapse::NoSample => BwCode::NoSample,
                Lapse::NotCollected => BwCode::NotCollected,
                Lapse::Arithmetic(_) => BwCode::Arithmetic,
                Lapse::NoSegment => BwCode::NoSegment,
                Lapse::Rate => BwCode::WrongRate,
                _ => BwCode::NoVerdict,
            })
        })
    }

    fn act(&mut self, action: Action) -> bool {
        let Self(watch, model) = self;
        match action {
            Action::Deny => watch.monitor(Monitor::deny) == Some(true),
            Action::Reset => watch.reset(),
            Action::Restart => watch.restart(),
            Action::ClearFaults => {
                watch.clear_faults();
                true
            }
            Action::LimitSilence => watch.monitor(|own| own.limit_silence(SILENCE)).is_some(),
            Action::PowerOff => {
                let mut state = [0; 4096];
                let length = watch.end_run(&mut state).unwrap();
                let stopped = watch.stop();
                watch.start(model, &CONSTANTS).unwrap();
                watch.limit_liveness(LIMITS);
                stopped && watch.restore(&state[..length]).is_ok()
            }
        }
    }

    fn end(&mut self) -> ([u32; 3], BwFrontEndFaults, Vec<u8>) {
        let (status, mut state) = (self.0.status(), vec![0; 4096]);
        let length = self.0.end_run(&mut state).unwrap();
        state.truncate(length);
        let lost = [status.rows, status.lost_samples, status.lost_segments];
        (lost, status.faults.unwrap().into(), state)
    }
}

fn fields(now: &Conclusion<'_, Drive>) -> Fields {
    let (report, decision) = (now.report, now.report.decision.as_ref());
    let (verdict, reason) = match report.verdict {
        Verdict::Class(_) => (BwVerdict::Class, "None".into()),
        Verdict::Novel => (BwVerdict::Novel, "None".into()),
        Verdict::Ambiguous => (BwVerdict::Ambiguous, "None".into()),
        Verdict::Undetermined(reason) => (BwVerdict::Undetermined, name(reason)),
    };
    let missing = decision.map_or(0, |own| own.missing_count() as u8);
    Fields {
        verdict,
        class: [decision.map_or(0, |own| own.class), missing],
        reason,
        counts: [now.evidence.segments().0, report.rows, report.counts.rejected, report.counts.saturated],
        bits: [
            decision.map_or(0.0, |own| own.distance),
            decision.map_or(0.0, |own| own.surprise),
            now.evidence.score(),
        ]
        .map(f32::to_bits),
        most: decision.and_then(|own| own.most).map(|most| (most.coordinate, most.falls)),
        alarm: now.alarm,
        silence: now.silence.map(|own| own.segments),
    }
}

/// The name of a reason, which is the same in both.
fn name(reason: Reason) -> String {
    let text = format!("{reason:?}");
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().into()
}

struct C(*mut BwState, Memory, Vec<u8>);

impl C {
    fn new(model: &'static Model<Drive>) -> Self {
        let (mut memory, bytes) = (Memory::new(), bytes(model));
        let state = memory.drive(&bytes, &for_c(&CONSTANTS, 10, 2)).expect("it starts");
        let own = Self(state, memory, bytes);
        own.limit();
        own
    }

    fn limit(&self) {
        // SAFETY: the state runs.
        let code = unsafe { bw_limit_liveness(self.0, LIMITS.sample_s, LIMITS.segment_s, LIMITS.verdict_s) };
        assert_eq!(code, BwCode::Ok);
    }
}

// In all of them the state runs, and the places are writable; what is read was written if the code says so.
impl Side for C {
    fn sample(&mut self, reading: &RawSample<2>) {
        // SAFETY: as above.
        let code = unsafe { bw_sample_raw(self.0, &raw_for_c(reading), reading.further.as_ptr(), 2) };
        assert!(matches!(code, BwCode::Ok | BwCode::Collect), "{code:?}");
    }

    fn collect(&mut self) {
        // SAFETY: as above.
        unsafe { bw_collect(self.0) };
    }

    fn advance(&mut self) -> Option<Told> {
        let (mut report, mut alarm) = (MaybeUninit::<BwReport>::uninit(), MaybeUninit::<BwAlarm>::uninit());
        // SAFETY: as above.
        let (code, report, alarm) = unsafe {
            let code = bw_advance(self.0, report.as_mut_ptr(), alarm.as_mut_ptr());
            if !matches!(code, BwCode::Report | BwCode::Withdrawn) {
                return None;
            }
            (code, report.assume_init(), alarm.assume_init())
        };
        let cause = match alarm {
            BwAlarm { known: true, class_index, .. } => Cause::Class(class_index),
            BwAlarm { fallen: true, coordinate, .. } => Cause::Fallen(coordinate),
            BwAlarm { risen: true, coordinate, .. } => Cause::Coordinate(coordinate),
            _ => Cause::Unknown,
        };
        let fields = Fields {
            verdict: report.verdict,
            class: [report.class_index, report.missing],
            reason: format!("{:?}", report.reason),
            counts: [report.segment, report.rows, report.rejected, report.saturated],
            bits: [report.distance, report.surprise, alarm.score].map(f32::to_bits),
            most: (report.most != u8::MAX).then_some((report.most, report.falls)),
            alarm: alarm.raised.then_some(Alarm { segment: alarm.segment, cause }),
            silence: alarm.silent.then_some(alarm.silent_segments),
        };
        Some(Told::Report(code == BwCode::Withdrawn, fields))
    }

    fn clock(&mut self, milliseconds: u32) -> Option<Told> {
        // SAFETY: as above.
        match unsafe { bw_clock(self.0, milliseconds) } {
            BwCode::Ok => None,
            lapse => Some(Told::Lapse(lapse)),
        }
    }

    fn act(&mut self, action: Action) -> bool {
        let Self(state, memory, model) = self;
        let mut saved = [0; 4096];
        // SAFETY: as above.
        let code = unsafe {
            match action {
                Action::Deny => bw_deny(*state),
                Action::Reset => bw_reset(*state),
                Action::Restart => bw_restart(*state),
                Action::ClearFaults => bw_clear_faults(*state),
                Action::LimitSilence => bw_limit_silence(*state, SILENCE.segments, SILENCE.hours),
                Action::PowerOff => {
                    let mut length = 0;
                    assert_eq!(bw_end_run(*state, saved.as_mut_ptr(), saved.len(), &raw mut length), BwCode::Ok);
                    assert_eq!(bw_stop(*state), BwCode::Ok);
                    *state = memory.drive(model, &for_c(&CONSTANTS, 10, 2)).expect("it starts");
                    bw_restore(*state, saved.as_ptr(), length)
                }
            }
        };
        self.limit_after(action);
        code == BwCode::Ok
    }

    fn end(&mut self) -> ([u32; 3], BwFrontEndFaults, Vec<u8>) {
        let (mut status, mut faults) = (MaybeUninit::<BwStatus>::uninit(), MaybeUninit::<BwFrontEndFaults>::uninit());
        let (mut state, mut length) = (vec![0; 4096], 0);
        // SAFETY: as above.
        let (status, faults) = unsafe {
            assert_eq!(bw_status(self.0, status.as_mut_ptr()), BwCode::Ok);
            assert_eq!(bw_faults(self.0, faults.as_mut_ptr()), BwCode::Ok);
            assert_eq!(bw_end_run(self.0, state.as_mut_ptr(), state.len(), &raw mut length), BwCode::Ok);
            (status.assume_init(), faults.assume_init())
        };
        state.truncate(length);
        assert_eq!((status.failed, status.alignment), (0, faults.alignment));
        ([status.samples, status.lost_samples, status.lost_segments], faults, state)
    }
}

impl C {
    /// A state that was started anew has its own limits.
    fn limit_after(&self, action: Action) {
        if action == Action::PowerOff {
            self.limit();
        }
    }
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
