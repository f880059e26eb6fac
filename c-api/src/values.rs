//! The numbers behind a report.

use bearing_watch::shaft::{OrderStrength, Parameter};
use bearing_watch::{FrictionTerm, Report};

use crate::code::{BwCode, Outcome, code};
use crate::memory::{at, check, put};
use crate::plan::Own;
use crate::state::BwState;

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
    /// Amplitude of the weight on an axis and its standard deviation, A; none in a plan without one.
    Weight = 16,
}

impl BwValues {
    const ALL: [Self; 17] = [
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
        Self::Weight,
    ];
}

/// Gives a list of numbers behind the last report, `what` of `BwValues`, and in `count` how many there are: 0 if the
/// model does not have this part, or this segment no such result.
///
/// Returns `BW_CODE_OK`, `BW_CODE_NO_REPORT`, `BW_CODE_OUT_OF_RANGE` if there is no such list, or
/// `BW_CODE_BUFFER_TOO_SMALL`, where `count` is what is needed.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes. `values` is NULL or has `capacity`
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
        BwValues::Weight => {
            let weight = shaft.filter(|own| own.friction_reason.is_none()).and_then(|own| own.friction.weight_a());
            return weight.into_iter().flat_map(|(value, deviation)| [value, deviation]).for_each(each);
        }
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
