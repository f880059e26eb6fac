//! What may happen to a drive, what a context can be told of it, and what is expected.

use bearing_watch::Alarm;
use bearing_watch::drive::{PhaseCounts, Position, RawSample};
use bearing_watch_c::{BwCode, BwVerdict};

/// Clean samples of a segment, and readings: of 0.6 s, so that many things happen soon.
pub const SEGMENT: u32 = 600;
pub const READINGS: u32 = 10 * SEGMENT;

/// What a context is told.
#[derive(Clone, Debug, PartialEq)]
pub enum Told {
    /// Report and alarm, and whether the report is one that is withdrawn.
    Report(bool, Fields),
    /// By the clock.
    Lapse(BwCode),
    /// Of an action.
    Done(bool),
}

/// The fields of report and alarm that both have.
#[derive(Clone, Debug, PartialEq)]
pub struct Fields {
    pub verdict: BwVerdict,
    /// Class, and numbers of features that are missing.
    pub class: [u8; 2],
    pub reason: String,
    /// Segment, rows, rejected and saturated samples.
    pub counts: [u32; 4],
    /// Distance, surprise, score of the alarm.
    pub bits: [u32; 3],
    /// Coordinate that departs most, and whether it falls.
    pub most: Option<(u8, bool)>,
    /// The alarm with its segment, and the silence with its segments.
    pub alarm: Option<Alarm>,
    pub silence: Option<u32>,
}

/// What a drive can do in its main loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    Deny,
    Reset,
    Restart,
    ClearFaults,
    /// Ends the run, stops, starts anew and continues from the saved state.
    PowerOff,
    LimitSilence,
}

/// A drive to which something happens.
pub struct Case {
    pub name: &'static str,
    /// Changes a reading; `false` if its interrupt is missed.
    pub reading: fn(u32, &mut RawSample<2>) -> bool,
    /// Whether the lower interrupt, and the main loop, run behind this reading.
    pub collects: fn(u32) -> bool,
    pub advances: fn(u32) -> bool,
    /// Milliseconds of the clock for a thousand readings.
    pub ms: u32,
    pub actions: &'static [(u32, Action)],
    /// What both must have been told.
    pub expected: fn(&[(u32, Told)]) -> bool,
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

pub const CASES: [Case; 13] = [
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
