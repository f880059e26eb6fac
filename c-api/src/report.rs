//! The report of the last segment.

use bearing_watch::plan::MAX_CHANNELS;
use bearing_watch::watch::Status;
use bearing_watch::{ArithmeticFault, Evidence, FrictionTerm, Implausible, Obstacle, Part, Reason, Report, Verdict};

use crate::BwAlignment;
use crate::code::{BwCode, code};
use crate::memory::{at, put};
use crate::plan::Own;
use crate::state::{BwState, OwnMonitor};

/// The state of the bearing in one segment.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwVerdict {
    /// A trained class: see `class_index`.
    Class = 0,
    /// Most like healthy, but farther from it than healthy segments are; or far from every class.
    Novel = 1,
    /// No class is plausible enough.
    Ambiguous = 2,
    /// No verdict: see `reason`.
    Undetermined = 3,
}

/// Why a segment has no verdict.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwReason {
    /// It has one.
    None = 0,
    /// The part `part` had too few usable rows, `reason_rows`.
    TooFewRows = 1,
    /// Less than half of the segment was usable.
    ShortSegment = 2,
    /// The shaft hardly moved, or the inputs of the regression hardly changed.
    AtRest = 3,
    /// The data do not excite the parameter `place` of the regression.
    ParameterNotExcited = 4,
    /// The motion does not excite the term `place` of the torque balance.
    TermNotExcited = 5,
    /// The instruments of `part` hardly follow the output.
    WeakInstruments = 6,
    /// The sensor of the channel `place` is stuck.
    Stuck = 7,
    /// More samples of the channel `place` were refused than used.
    LostSamples = 8,
    /// The covariate `place` is outside the range of the training records.
    OutOfRange = 9,
    /// A result of `part` is not a finite number.
    NotFinite = 10,
    /// A reason that this interface does not know.
    Other = 11,
    /// The signals contradict the model or each other: wrong wiring, unit or sampling rate. `place` says which: the
    /// sign of 0 the current, 1 the load, 2 velocity and angle, 3 one of them; the gain, unit or rate of 4 the
    /// current, 5 the load, 6 the velocity, 7 one of them; the velocity against the angle, 8 its sign, 9 its unit or
    /// the rate; 10 the current follows neither motion nor load; 11 the torque constant; 12 the rate by a clock; 13
    /// the angle is stuck, 14 it makes steps; 15 the wiring is not decided yet, 16 it is wrong. 255: what this
    /// interface does not know.
    Implausible = 12,
    /// The processor does not compute as the host does where the detector runs; `place` is 0 for the rounding, 1 for
    /// subnormal numbers. An interrupt has settings of its own (FPDSCR).
    Arithmetic = 13,
    /// The segment is that of another model.
    OtherModel = 14,
    /// A fault that was found after the segment may have begun in it: it has lost its verdict (`BW_CODE_WITHDRAWN`).
    FoundLate = 15,
    /// Healthy is most plausible, but the segment would not have shown an acceptable defect (`BW_VALUES_SMALLEST`):
    /// `place` is 0 if the shaft turned too little for the bearing orders, 1 if they are too noisy.
    Unseen = 16,
}

/// A part of the detector.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwPart {
    /// No part, or the reason is not about one.
    None = 0,
    /// The regression.
    Regression = 1,
    /// The torque balance of the shaft.
    TorqueBalance = 2,
    /// The bearing orders.
    Orders = 3,
    /// The classifier.
    Classifier = 4,
}

/// The verdict on one segment.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwReport {
    /// Number of the segment since `bw_start` or `bw_reset`; the first is 1.
    pub segment: u32,
    /// The state of the bearing.
    pub verdict: BwVerdict,
    /// The class of least expected cost, for any verdict but undetermined: `bw_label` gives its name.
    pub class_index: u8,
    /// Parameter, term, channel, covariate or error of the reason.
    pub place: u8,
    /// Segments in a row, before this one, whose estimate could not serve as auxiliary model; 0 by least squares.
    pub refused: u8,
    /// Number of features that were missing.
    pub missing: u8,
    /// Why there is no verdict.
    pub reason: BwReason,
    /// The part of the reason.
    pub part: BwPart,
    /// Rows of the reason.
    pub reason_rows: u32,
    /// Rows of the regression; in a model without one, usable samples.
    pub rows: u32,
    /// Samples with a channel beyond its limit or not a number.
    pub rejected: u32,
    /// Samples with a saturated sensor and no rejected channel.
    pub saturated: u32,
    /// Rows that fading memory ignored because the inputs hardly changed.
    pub resting: u32,
    /// Channels that were stuck at some time of the segment, bit k for channel k.
    pub stuck: u32,
    /// Samples lost since `bw_start` because `bw_collect` came too late.
    pub lost_samples: u32,
    /// Segments lost since `bw_start` because `bw_advance` came too late.
    pub lost_segments: u32,
    /// Distance from the healthy class in its standard deviations; 0 without a healthy class or a verdict.
    pub distance: f32,
    /// -ln of the probability that a healthy segment is at least so unusual, nats; likewise.
    pub surprise: f32,
    /// The coordinate that departs most from the healthy class, or that of a strong bearing order: a place in
    /// `BW_MODEL_COORDINATE_NAMES` of the model's header; 255 without a healthy class or a verdict.
    pub most: u8,
    /// Whether that one is below its usual value: no bearing defect, but a lost load or belt, or a sensor.
    pub falls: bool,
    /// Whether the currents turn with the rotor; `BW_ALIGNMENT_UNKNOWN`: the wiring is not checked.
    pub alignment: BwAlignment,
}

/// Gives the report of the segment that was solved last. It is there until the solve of the next segment starts.
///
/// Returns `BW_CODE_OK`, or `BW_CODE_NO_REPORT`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `report` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_report(state: *mut BwState, report: *mut BwReport) -> BwCode {
    // SAFETY: the same contract.
    let found = unsafe { at(state) }.and_then(|state| {
        let status = state.watch.status();
        let summary =
            |monitor: &mut OwnMonitor| monitor.report().map(|report| summary(status, report, monitor.evidence()));
        state.settled(summary)?.ok_or(BwCode::NoReport)
    });
    // SAFETY: the same contract.
    code(found.and_then(|found| unsafe { put(report, found) }).map(|()| BwCode::Ok))
}

/// The fields of a report.
pub(crate) fn summary(status: Status, report: &Report<Own>, evidence: &Evidence<Own>) -> BwReport {
    let Status { lost_samples, lost_segments, alignment, .. } = status;
    let counts = report.counts;
    let stuck = (0..MAX_CHANNELS).filter(|channel| counts.stuck.contains(*channel));
    let decision = report.decision.as_ref();
    let most = decision.and_then(|decision| decision.most);
    let (verdict, reason) = verdict(report);
    BwReport {
        segment: evidence.segments().0,
        verdict,
        class_index: decision.map_or(0, |decision| decision.class),
        place: reason.place,
        refused: counts.refused,
        missing: decision.map_or(0, |decision| u8::try_from(decision.missing_count()).unwrap_or(u8::MAX)),
        reason: reason.reason,
        part: reason.part,
        reason_rows: reason.rows,
        rows: report.rows,
        rejected: counts.rejected,
        saturated: counts.saturated,
        resting: counts.resting,
        stuck: stuck.fold(0, |mask, channel| mask | (1 << channel)),
        lost_samples,
        alignment: alignment.into(),
        lost_segments,
        distance: decision.map_or(0.0, |decision| decision.distance),
        surprise: decision.map_or(0.0, |decision| decision.surprise),
        most: most.map_or(u8::MAX, |most| most.coordinate),
        falls: most.is_some_and(|most| most.falls),
    }
}

/// A reason without payload.
struct Why {
    reason: BwReason,
    part: BwPart,
    place: u8,
    rows: u32,
}

impl Why {
    const NONE: Self = Self::plain(BwReason::None);

    const fn plain(reason: BwReason) -> Self {
        Self { reason, part: BwPart::None, place: 0, rows: 0 }
    }
}

fn verdict(report: &Report<Own>) -> (BwVerdict, Why) {
    match report.verdict {
        Verdict::Class(_) => (BwVerdict::Class, Why::NONE),
        Verdict::Novel => (BwVerdict::Novel, Why::NONE),
        Verdict::Ambiguous => (BwVerdict::Ambiguous, Why::NONE),
        Verdict::Undetermined(reason) => (BwVerdict::Undetermined, why(reason)),
    }
}

/// A reason and its place.
pub(crate) fn named(reason: Reason) -> (BwReason, u8) {
    let Why { reason, place, .. } = why(reason);
    (reason, place)
}

fn why(reason: Reason) -> Why {
    let plain = Why::plain;
    match reason {
        Reason::TooFewRows { part: own, rows } => Why { part: part(own), rows, ..plain(BwReason::TooFewRows) },
        Reason::ShortSegment { rows } => Why { rows, ..plain(BwReason::ShortSegment) },
        Reason::AtRest => plain(BwReason::AtRest),
        Reason::ParameterNotExcited(place) => Why { place, ..plain(BwReason::ParameterNotExcited) },
        Reason::TermNotExcited(term) => {
            Why { place: place_in(FrictionTerm::ALL, &term), ..plain(BwReason::TermNotExcited) }
        }
        Reason::WeakInstruments(own) => Why { part: part(own), ..plain(BwReason::WeakInstruments) },
        Reason::Stuck { channel } => Why { place: channel, ..plain(BwReason::Stuck) },
        Reason::LostSamples { channel } => Why { place: channel, ..plain(BwReason::LostSamples) },
        Reason::OutOfRange { covariate } => Why { place: covariate, ..plain(BwReason::OutOfRange) },
        Reason::NotFinite(own) => Why { part: part(own), ..plain(BwReason::NotFinite) },
        Reason::Implausible(error) => Why { place: place_in(Implausible::ALL, &error), ..plain(BwReason::Implausible) },
        Reason::Arithmetic(kernel) => {
            Why { place: place_in(ArithmeticFault::ALL, &kernel), ..plain(BwReason::Arithmetic) }
        }
        Reason::OtherModel => plain(BwReason::OtherModel),
        Reason::FoundLate => plain(BwReason::FoundLate),
        Reason::Unseen(own) => Why { place: place_in(Obstacle::ALL, &own), ..plain(BwReason::Unseen) },
        // What a later version of the core adds.
        _ => plain(BwReason::Other),
    }
}

const fn part(part: Part) -> BwPart {
    match part {
        Part::Regression => BwPart::Regression,
        Part::TorqueBalance => BwPart::TorqueBalance,
        Part::Orders => BwPart::Orders,
        Part::Classifier => BwPart::Classifier,
    }
}

/// The place of a value among all; 255 for what a later version of the core adds.
fn place_in<T: PartialEq, const N: usize>(all: [T; N], value: &T) -> u8 {
    (0..).zip(all).find(|(_, other)| other == value).map_or(u8::MAX, |(place, _)| place)
}
