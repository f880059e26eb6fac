//! The constants of the core's estimator: scales, limits, nominal model, memory.
//!
//! ```text
//! scales      powers of two that scale each column of the rows (with instruments, after the filter A(1)/A) to rms ≈ 1
//! nominal     mean δ over the estimated traces of one class, by least squares or by SRIV                         (1)
//! settle      5/|ln|p||, p the slowest pole of the nominal model: transients have fallen below 1 %               (2)
//! floor       0.01/(1 − λ): the sum for a column of rms 1 if only one row in a hundred contributed               (3)
//! still       a thousandth of the training traces' mean motion                                                   (4)
//! ```
//!
//! At (4) the inputs move by 3 % of their usual motion, which is too little for estimation and for a verdict. After the
//! inputs have stopped, the mean in the core's fading memory falls to (4) within 0.9 of the memory's length.

use std::borrow::Cow;

use bearing_watch::model::{Channel, Forgetting, MAX_LAMBDA, Regression};
use bearing_watch::plan::{MAX_OUTPUT_TERMS, Memory, Method, RegressionLayout, RunTime, Signal};
use bearing_watch::recursive::is_stable;
use nalgebra::DVector;
use rayon::prelude::*;

use crate::Error;
use crate::core::features;
use crate::identify::{Estimate, Structure, least_squares, poles, sriv};
use crate::trace::labels::LabelledTrace;
use crate::trace::{Trace, bridged};
use crate::train::distribution::statistics;

/// Least settling time, samples.
const LEAST_SETTLE: u32 = 100;
/// Settling time of a regression without filters, samples; not used.
const USUAL_SETTLE: u16 = 100;

/// Settings of the estimation of segments, without the traces.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimation {
    /// Least squares or instrumental variables.
    pub method: Method,
    /// The class whose mean is the nominal model.
    pub nominal: usize,
    /// Samples per segment; if not given those of the longest trace, or of equal parts of it if it is long.
    pub segment: Option<usize>,
    /// Magnitudes of y, u1, u2 at which a sensor is saturated.
    pub saturation: Option<[f64; 3]>,
    /// Number of equal samples of y that indicates a stuck sensor; 0 for no limit.
    pub stuck: u16,
    /// Forgetting factor λ per row; without one, each segment is estimated separately.
    pub memory: Option<f64>,
    /// Samples into the next segment at which a segment's model takes over.
    pub handover: u16,
}

impl Default for Estimation {
    fn default() -> Self {
        Self {
            method: Method::LeastSquares,
            nominal: 0,
            segment: None,
            saturation: None,
            stuck: 0,
            memory: None,
            handover: 0,
        }
    }
}

impl Estimation {
    /// Returns whether batch least squares on each segment computes the same estimate as the core: it has no
    /// instruments, no memory beyond the segment and no tests of the sensors.
    pub(crate) fn is_batch(&self) -> bool {
        let Self { method, saturation, stuck, memory, .. } = self;
        *method == Method::LeastSquares && saturation.is_none() && *stuck == 0 && memory.is_none()
    }
}

/// Returns the core's regression with its trained constants.
pub(crate) fn regression(
    traces: &[LabelledTrace],
    classes: &[String],
    (structure, [y, u1, u2]): (Structure, [Signal; 3]),
    (estimation, segment): (&Estimation, usize),
) -> Result<(RegressionLayout, Regression<RunTime>), Error> {
    check(estimation, structure, segment)?;
    let held = without_gaps(traces);
    let traces = held.as_ref();
    let nominal = nominal(traces, classes, structure, estimation)?;
    let memory = match estimation.memory {
        Some(_) => Memory::Fading,
        None => Memory::Segment,
    };
    let layout = RegressionLayout { structure, method: estimation.method, memory, y, u1, u2 };
    let delta: Vec<f32> = nominal.0.iter().map(|x| *x as f32).collect();
    let mut in_rows = Cow::Borrowed(traces);
    let mut settle = USUAL_SETTLE;
    if estimation.method == Method::Instruments {
        require_stable(&delta[..structure.na as usize], &classes[estimation.nominal])?;
        let denominator = nominal.denominator(structure);
        settle = settling(&denominator, segment, estimation.handover);
        in_rows = traces.par_iter().map(|trace| filtered(trace, &denominator)).collect::<Vec<_>>().into();
    }
    let scales = column_scales(&in_rows, structure);
    let lambda = estimation.memory.unwrap_or(f64::from(MAX_LAMBDA));
    let mut scale: Vec<f32> = scales.iter().map(|x| *x as f32).collect();
    scale.resize(layout.columns(), 1.0);
    let regression = Regression {
        scale,
        nominal: delta,
        forgetting: Forgetting { lambda: lambda as f32, floor: (0.01 / (1.0 - lambda)) as f32 }, // (3)
        rest: (1e-3 * mean_motion(&in_rows, structure, &scales)) as f32,                         // (4)
        settle,
        handover: estimation.handover,
    };
    Ok((layout, regression))
}

fn check(estimation: &Estimation, structure: Structure, segment: usize) -> Result<(), Error> {
    let refuse = |problem: String| Err(Error::Usage(problem));
    let Estimation { method, stuck, memory, handover, .. } = estimation;
    let na = structure.na as usize;
    if *method == Method::Instruments && !(1..=MAX_OUTPUT_TERMS).contains(&na) {
        return refuse(format!(
            "--method instruments wants 1 to {MAX_OUTPUT_TERMS} output terms, but --order has {na}"
        ));
    }
    if *stuck == 1 {
        return refuse("--stuck 1: one sample is no run; give at least 2, or 0 for none".into());
    }
    // The memory must exceed twice as many rows as parameters, or the variance cannot be estimated.
    let least = 1.0 - 0.5 / structure.parameters() as f64;
    if let Some(lambda) = memory.filter(|lambda| !(*lambda > least && (*lambda as f32) <= MAX_LAMBDA)) {
        return refuse(format!("--memory {lambda}: at this order a factor above {least:.4}, at most {MAX_LAMBDA}"));
    }
    if usize::from(*handover) > segment / 4 {
        return refuse(format!("--handover {handover}: at most a quarter of the segment of {segment} samples"));
    }
    Ok(())
}

/// Sets the limits for saturated and stuck sensors in the channels of the regression.
pub(crate) fn guard(channels: &mut [Channel], [y, u1, u2]: [Signal; 3], estimation: &Estimation) -> Result<(), Error> {
    if let Some(saturation) = estimation.saturation {
        for ((signal, asked), name) in [y, u1, u2].into_iter().zip(saturation).zip(["Y", "U1", "U2"]) {
            if !(asked.is_finite() && asked > 0.0) {
                return Err(Error::Usage(format!("--saturation: {name} is {asked}, but must be above 0")));
            }
            for place in [Some(signal.channel), signal.minus].into_iter().flatten() {
                if let Some(channel) = channels.get_mut(place as usize) {
                    channel.saturation = (asked as f32).min(channel.limit);
                }
            }
        }
    }
    if let Some(channel) = channels.get_mut(y.channel as usize) {
        channel.stuck_samples = estimation.stuck;
    }
    Ok(())
}

/// The nominal model (1), in δ-form.
struct Mean(DVector<f64>);

fn nominal(
    traces: &[LabelledTrace],
    classes: &[String],
    structure: Structure,
    estimation: &Estimation,
) -> Result<Mean, Error> {
    let estimate: fn(&Trace, Structure) -> Result<Estimate, Error> = match estimation.method {
        Method::LeastSquares => least_squares,
        Method::Instruments => sriv,
    };
    let own: Vec<&Trace> = traces.iter().filter(|t| t.class == estimation.nominal).map(|t| &t.trace).collect();
    if own.is_empty() {
        let place = estimation.nominal;
        let name = classes.get(place).map_or_else(|| place.to_string(), Clone::clone);
        return Err(Error::Training(format!("no training trace of class {name} for the nominal model")));
    }
    let estimates = successful(own.par_iter().map(|trace| estimate(trace, structure)).collect())?;
    let deltas: Vec<_> = estimates.iter().map(|e| features::delta_from_raw(structure, &e.theta)).collect();
    Ok(Mean(statistics::mean(&deltas)))
}

/// Returns the traces with the last sample in place of missing ones. The core leaves out rows with a missing sample;
/// means over whole traces need not.
fn without_gaps(traces: &[LabelledTrace]) -> Cow<'_, [LabelledTrace]> {
    let complete = |own: &LabelledTrace| {
        let Trace { y, u1, u2, .. } = &own.trace;
        [y, u1, u2].into_iter().flatten().all(|x| x.is_finite())
    };
    if traces.iter().all(complete) {
        return Cow::Borrowed(traces);
    }
    let each = |own: &LabelledTrace| {
        let signals = [&own.trace.y, &own.trace.u1, &own.trace.u2].map(|signal| bridged(signal));
        let trace = own.trace.with_signals(signals);
        LabelledTrace { trace, class: own.class }
    };
    traces.par_iter().map(each).collect::<Vec<_>>().into()
}

/// Returns the estimates of the traces that have one: others, such as records at rest, have no part in a mean.
///
/// # Errors
/// That of the first trace, if no trace has an estimate.
pub(crate) fn successful<T>(estimates: Vec<Result<T, Error>>) -> Result<Vec<T>, Error> {
    let (good, bad): (Vec<_>, Vec<_>) = estimates.into_iter().partition(Result::is_ok);
    match bad.into_iter().next() {
        Some(Err(error)) if good.is_empty() => Err(error),
        _ => Ok(good.into_iter().flatten().collect()),
    }
}

impl Mean {
    /// Returns the coefficients 1, a₁, …, a_na.
    fn denominator(&self, structure: Structure) -> Vec<f64> {
        let na = structure.na as usize;
        let t = |k: usize| if k < na { self.0[k] } else { 0.0 };
        let a = (0..na).map(|k| if k == 0 { -1.0 - t(0) - t(1) } else { t(k) - t(k + 1) });
        std::iter::once(1.0).chain(a).collect()
    }
}

fn require_stable(t: &[f32], class: &str) -> Result<(), Error> {
    if is_stable(t) {
        return Ok(());
    }
    Err(Error::Training(format!(
        "the nominal model, the mean of class {class}, is not stable, so it cannot make instruments; name another class \
         by --nominal, lower the order, or use --method ls"
    )))
}

/// Computes (2), limited to the part of the segment that is available for settling.
fn settling(denominator: &[f64], segment: usize, handover: u16) -> u16 {
    let slowest = poles(denominator).iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    // With rounding errors a pole may lie on the unit circle.
    let samples = (-5.0 / slowest.min(1.0 - 1e-9).ln()).ceil();
    let samples = samples.clamp(f64::from(LEAST_SETTLE), f64::from(u16::MAX)) as u16;
    let most = (segment / 4).saturating_sub(usize::from(handover));
    samples.min(u16::try_from(most).unwrap_or(u16::MAX))
}

/// Returns the signals as they enter the rows of instrumental variables: filtered by A(1)/A, in steady state at the
/// first sample.
fn filtered(labelled: &LabelledTrace, denominator: &[f64]) -> LabelledTrace {
    let gain: f64 = denominator.iter().sum();
    let filter = |signal: &[f64]| {
        let mut past = vec![signal.first().copied().unwrap_or(0.0); denominator.len() - 1];
        let each = |x: &f64| {
            let feedback: f64 = denominator[1..].iter().zip(&past).map(|(a, x)| a * x).sum();
            let now = gain * x - feedback;
            past.rotate_right(1);
            past[0] = now;
            now
        };
        signal.iter().map(each).collect()
    };
    let Trace { y, u1, u2, .. } = &labelled.trace;
    let trace = Trace { y: filter(y), u1: filter(u1), u2: filter(u2), ..labelled.trace.clone() };
    LabelledTrace { trace, class: labelled.class }
}

/// Returns the mean of the scaled (Δu1)² + (Δu2)².
fn mean_motion(traces: &[LabelledTrace], structure: Structure, scales: &[f64]) -> f64 {
    let order = structure;
    let (na, nb) = (order.na as usize, order.nb as usize);
    let motion = |signal: &[f64], terms: u8, place: usize| {
        let scale = if terms > 0 { scales[place] } else { 0.0 };
        signal.windows(2).map(|pair| ((pair[1] - pair[0]) * scale).powi(2)).sum::<f64>()
    };
    let of_trace = |t: &LabelledTrace| motion(&t.trace.u1, order.nb, na) + motion(&t.trace.u2, order.nc, na + nb);
    let steps: usize = traces.iter().map(|t| t.trace.y.len().saturating_sub(1)).sum();
    traces.iter().map(of_trace).sum::<f64>() / steps.max(1) as f64
}

/// Returns the powers of two that scale each δ-form column, pooled over the training set, to rms ≈ 1.
fn column_scales(traces: &[LabelledTrace], structure: Structure) -> Vec<f64> {
    let scale = |pick: Column, difference: bool| {
        let pooled = traces.iter().flat_map(|t| {
            let x = pick(&t.trace);
            let before = [&[0.0], x].concat();
            let lag = move |k: usize| if difference { before[k] } else { 0.0 };
            x.iter().enumerate().skip(usize::from(difference)).map(move |(k, x)| x - lag(k))
        });
        let (sum, count) = pooled.fold((0.0, 0.0_f64), |(sum, count), x| (sum + x * x, count + 1.0));
        let rms = (sum / count.max(1.0)).sqrt();
        if rms > 0.0 { (-rms.log2().round()).clamp(-60.0, 60.0).exp2() } else { 1.0 }
    };
    let order = structure;
    let signals: [(Column, u8); 3] = [(|t| &t.y, order.na), (|t| &t.u1, order.nb), (|t| &t.u2, order.nc)];
    let mut scales: Vec<f64> =
        signals.iter().flat_map(|&(pick, terms)| (0..terms).map(move |term| scale(pick, term > 0))).collect();
    scales.extend(structure.offset.then_some(1.0));
    scales.push(scale(|t| &t.y, order.na > 0));
    scales
}

type Column = fn(&Trace) -> &[f64];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settling_by_the_slowest_pole() {
        // Poles 0.99 and 0.5: 5/0.01005 = 497.5; a single pole at 0.5 settles within 8 samples.
        assert_eq!(settling(&[1.0, -1.49, 0.495], 5000, 0), 498);
        assert_eq!(settling(&[1.0, -0.5], 5000, 0), 100);
        assert_eq!(settling(&[1.0, -0.99], 1000, 50), 200, "a quarter of the segment, the handover included");
        assert_eq!(settling(&[1.0, -1.0], 1_000_000, 0), u16::MAX);
    }

    #[test]
    fn an_unstable_nominal_model_is_refused() {
        assert!(require_stable(&[-0.1], "healthy").is_ok());
        let error = require_stable(&[0.1], "healthy").expect_err("a growing model").to_string();
        assert!(error.contains("healthy, is not stable") && error.contains("--method ls"), "{error}");
    }

    #[test]
    fn motion_by_hand() {
        let order = crate::identify::Structure::new(1, 1, 1, 1, 1);
        let structure = order;
        let (u1, u2) = (vec![0.0, 1.0, 1.0], vec![0.0, 0.0, 2.0]);
        let trace = Trace {
            id: "t".into(),
            interval_s: None,
            irregular_steps: 0,
            y: vec![0.0; 3],
            u1,
            u2,
            motion: None,
            ..Trace::default()
        };
        let traces = [LabelledTrace { trace, class: 0 }];
        let scales = [1.0, 2.0, 0.5, 1.0];
        // u1 changes once by 1 · 2, u2 once by 2 · 0.5, over two steps.
        assert_eq!(mean_motion(&traces, structure, &scales), 2.5);
        // After the filter 0.5/(1 − 0.5 z⁻¹), u1 is 0, 0.5, 0.75 and u2 is 0, 0, 1.
        let behind = filtered(&traces[0], &[1.0, -0.5]);
        assert_eq!(behind.trace.u1, [0.0, 0.5, 0.75]);
        assert_eq!(mean_motion(&[behind], structure, &scales), (1.0 + 0.25 + 0.25) / 2.0);
    }
}
