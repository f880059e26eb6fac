//! The report of the last segment.

use bearing_watch::plan::MAX_CHANNELS;
use bearing_watch::shaft::{OrderStrength, Parameter};
use bearing_watch::{ArithmeticFault, FrictionTerm, Implausible, Obstacle, Part, Reason, Report, Verdict};

use crate::BwAlignment;
use crate::code::{BwCode, Outcome, code};
use crate::memory::{at, check, put};
use crate::plan::Own;
use crate::state::BwState;

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
    /// sign of 0 the current, 1 the load, 2 velocity and angle, 3 one of them; the gain, unit or rate of 4 the current,
    /// 5 the load, 6 the velocity, 7 one of them; the velocity against the angle, 8 its sign, 9 its unit or the rate; 10
    /// the current follows neither motion nor load; 11 the torque constant; 12 the rate by a clock; 13 the angle is
    /// stuck, 14 it makes steps; 15 the wiring is not decided yet, 16 it is wrong.
    /// 255: what this interface does not know.
    Implausible = 12,
    /// The processor does not compute as the host does where the detector runs; `place` is 0 for the rounding, 1 for
    /// subnormal numbers. An interrupt has settings of its own (FPDSCR).
    Arithmetic = 13,
    /// The segment is that of another model.
    OtherModel = 14,
    /// A fault that was found after the segment may have begun in it (`bw_discard`).
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
    /// Number of the segment since `bw_init` or `bw_reset`; the first is 1.
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
    /// Samples lost since `bw_init` because a function was busy.
    pub lost_samples: u32,
    /// Segments lost since `bw_init` because the one before was not taken.
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
    /// Whether the currents turn with the rotor; `BW_ALIGNMENT_UNKNOWN`: nobody has checked the wiring.
    pub alignment: BwAlignment,
}

/// Lists of numbers behind a verdict.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwValues {
    /// Log-likelihood of each class.
    LogLikelihoods = 0,
    /// Posterior probability of each class.
    Posteriors = 1,
    /// Expected cost of deciding each class.
    ExpectedCosts = 2,
    /// Whether each feature was missing, 1 or 0.
    Missing = 3,
    /// Parameters t, b, g and the constant of the regression, in units of y over units of the signal.
    Parameters = 4,
    /// Their standard deviations.
    ParameterDeviations = 5,
    /// Terms of the torque balance: J/Kt, B/Kt, Tc/Kt, 1/Kt, offset, load friction, Stribeck friction, drag; NaN for a
    /// term that needs a load if the load is not measured.
    Friction = 6,
    /// Their standard deviations.
    FrictionDeviations = 7,
    /// Their distances from healthy in standard deviations.
    FrictionScores = 8,
    /// Score of each bearing order: about standard normal without a defect.
    OrderScores = 9,
    /// Amplitude of each bearing order, A.
    OrderAmplitudes = 10,
    /// Standard deviations of the amplitudes, A.
    OrderDeviations = 11,
    /// Relative slip of the cage at which each order is strongest.
    OrderSlips = 12,
    /// Mean of each averaged channel; NaN if it has none.
    Means = 13,
    /// Root mean square of each averaged channel; NaN if it has none.
    RootMeanSquares = 14,
    /// The smallest defect in each rising coordinate of the model, the last ones, that the segment would have shown: a
    /// part of the usual friction, or the amplitude at a bearing order, A; infinite if it shows none.
    Smallest = 15,
}

impl BwValues {
    const ALL: [Self; 16] = [
        Self::LogLikelihoods,
        Self::Posteriors,
        Self::ExpectedCosts,
        Self::Missing,
        Self::Parameters,
        Self::ParameterDeviations,
        Self::Friction,
        Self::FrictionDeviations,
        Self::FrictionScores,
        Self::OrderScores,
        Self::OrderAmplitudes,
        Self::OrderDeviations,
        Self::OrderSlips,
        Self::Means,
        Self::RootMeanSquares,
        Self::Smallest,
    ];
}

/// Gives the report of the segment that was solved last. It is there until the solve of the next segment starts.
///
/// Returns `BW_CODE_OK`, or `BW_CODE_NO_REPORT`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `report` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_report(state: *mut BwState, report: *mut BwReport) -> BwCode {
    // SAFETY: the same contract.
    let found = unsafe { at(state) }.and_then(summary);
    // SAFETY: the same contract.
    code(found.and_then(|found| unsafe { put(report, found) }).map(|()| BwCode::Ok))
}

fn summary(state: &BwState) -> Outcome<BwReport> {
    use core::sync::atomic::Ordering::Relaxed;
    let (lost_samples, lost_segments) = (state.lost_samples.load(Relaxed), state.lost_segments.load(Relaxed));
    state.settled(|monitor| {
        let report = monitor.report().ok_or(BwCode::NoReport)?;
        let counts = report.counts;
        let stuck = (0..MAX_CHANNELS).filter(|channel| counts.stuck.contains(*channel));
        let decision = report.decision.as_ref();
        let most = decision.and_then(|decision| decision.most);
        let (verdict, reason) = verdict(report);
        Ok(BwReport {
            segment: monitor.evidence().segments().0,
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
            alignment: state.alignment().into(),
            lost_segments,
            distance: decision.map_or(0.0, |decision| decision.distance),
            surprise: decision.map_or(0.0, |decision| decision.surprise),
            most: most.map_or(u8::MAX, |most| most.coordinate),
            falls: most.is_some_and(|most| most.falls),
        })
    })?
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

/// Gives a list of numbers behind the last report, `what` of `BwValues`, and in `count` how many there are: 0 if the
/// model does not have this part, or this segment no such result.
///
/// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, `BW_CODE_OUT_OF_RANGE` if there is no such list, or
/// `BW_CODE_BUFFER_TOO_SMALL`, where `count` is what is needed.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes. `values` is NULL or has `capacity`
/// writable numbers. `count` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_values(
    state: *mut BwState,
    what: i32,
    values: *mut f32,
    capacity: usize,
    count: *mut usize,
) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| {
        check(values)?;
        check(count)?;
        let what = BwValues::ALL.into_iter().find(|known| *known as i32 == what).ok_or(BwCode::OutOfRange)?;
        // SAFETY: not NULL, aligned, and writable by the contract.
        unsafe { copy(state, what, (values, capacity), count) }
    }))
}

unsafe fn copy(state: &BwState, what: BwValues, (values, capacity): (*mut f32, usize), count: *mut usize) -> Outcome {
    let mut length = 0_usize;
    let each = |value: f32| {
        if length < capacity {
            // SAFETY: within the capacity that the caller promises.
            unsafe { values.add(length).write(value) };
        }
        length = length.wrapping_add(1);
    };
    let written = state.settled(|monitor| monitor.report().map(|report| list(report, what, each)))?;
    written.ok_or(BwCode::NoReport)?;
    // SAFETY: writable by the contract.
    unsafe { put(count, length)? };
    if length <= capacity { Ok(BwCode::Ok) } else { Err(BwCode::BufferTooSmall) }
}

fn list(report: &Report<Own>, what: BwValues, mut each: impl FnMut(f32)) {
    let decision = report.decision.as_ref();
    let estimate = report.estimate().filter(|estimate| estimate.reason.is_none());
    let shaft = report.shaft();
    let mut friction = |value: fn(Parameter) -> f32| {
        if let Some(shaft) = shaft.filter(|shaft| shaft.friction_reason.is_none()) {
            let parameters = FrictionTerm::ALL.map(|term| shaft.friction.parameter(term));
            parameters.into_iter().for_each(|own| each(own.map_or(f32::NAN, value)));
        }
    };
    match what {
        BwValues::Friction => return friction(|own| own.value),
        BwValues::FrictionDeviations => return friction(|own| own.deviation),
        BwValues::FrictionScores => return friction(|own| own.score),
        _ => {}
    }
    let mut orders = |value: fn(&OrderStrength) -> f32| {
        if let Some(shaft) = shaft.filter(|shaft| shaft.orders_reason.is_none()) {
            shaft.orders().iter().for_each(|own| each(value(own)));
        }
    };
    match what {
        BwValues::OrderScores => return orders(|own| own.score),
        BwValues::OrderAmplitudes => return orders(|own| own.amplitude),
        BwValues::OrderDeviations => return orders(|own| own.deviation),
        BwValues::OrderSlips => return orders(|own| own.slip),
        _ => {}
    }
    let averages = report.averages().iter();
    match what {
        BwValues::LogLikelihoods => decision.iter().flat_map(|own| own.log_likelihoods()).for_each(|x| each(*x)),
        BwValues::Posteriors => decision.iter().flat_map(|own| own.posteriors()).for_each(|x| each(*x)),
        BwValues::ExpectedCosts => decision.iter().flat_map(|own| own.expected_costs()).for_each(|x| each(*x)),
        BwValues::Missing => {
            decision.iter().flat_map(|own| own.missing()).for_each(|own| each(f32::from(u8::from(*own))));
        }
        BwValues::Parameters => estimate.iter().flat_map(|own| own.delta()).for_each(|x| each(*x)),
        BwValues::ParameterDeviations => {
            if let Some(estimate) = estimate {
                (0..estimate.delta().len()).for_each(|k| each(estimate.deviation(k)));
            }
        }
        BwValues::Means => averages.for_each(|own| each(own.mean().unwrap_or(f32::NAN))),
        BwValues::Smallest => report.smallest().iter().for_each(|size| each(*size)),
        BwValues::RootMeanSquares => averages.for_each(|own| each(own.rms().unwrap_or(f32::NAN))),
        _ => {}
    }
}
