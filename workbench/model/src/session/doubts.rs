//! What is doubtful about traces.

use std::f64::consts::TAU;

use crate::Error;
use crate::audit::angle::velocity_ratio;
use crate::audit::column::Column;
use crate::audit::held::{held, too_slow};
use crate::audit::scale::{are_whole, slope_by_velocity, wraps_at};
use crate::trace::{Channels, Trace, is_reference};

/// Returns an error if samples of a trace are missing: batch methods that filter or simulate signals need all of them.
///
/// # Errors
/// Some are.
pub fn refuse_gaps(trace: &Trace) -> Result<(), Error> {
    let wrong = |problem: String| Err(Error::trace(&trace.id, problem));
    match (&trace.refused, trace.missing.is_within()) {
        (Some(refused), _) => wrong(format!("{refused}; record it again, or cut the recording around them")),
        (None, true) => wrong(format!(
            "{}; this method needs every sample: cut the recording there, or resample it to a constant rate",
            trace.missing.words()
        )),
        (None, false) => Ok(()),
    }
}

/// Returns an error if the output, the first input or the current changes too rarely to show a bearing.
///
/// # Errors
/// One is.
pub fn refuse_held(trace: &Trace, channels: &Channels) -> Result<(), Error> {
    // What is wanted may come from a slower bus, and a drive follows it all the same.
    let u1 = (!is_reference(&channels.u1)).then_some(&trace.u1);
    let current = trace.motion.as_ref().map(|own| &own.current_a);
    let rate = trace.interval_s.map(|interval| 1.0 / interval);
    let slow = |x: &Vec<f64>| held(x).and_then(|rows| too_slow(rows, rate));
    match [Some(&trace.y), u1, current].into_iter().flatten().find_map(slow) {
        Some(problem) => Err(Error::trace(&trace.id, format!("a signal {problem}"))),
        None => Ok(()),
    }
}

/// Warns of traces of which the front end refused samples; the detector counts them and goes on.
pub fn refused<'a>(traces: impl Iterator<Item = &'a Trace>) -> Vec<String> {
    let refused = traces.filter_map(|trace| Some((trace, trace.refused?)));
    refused.map(|(trace, refused)| format!("trace {}: {refused}", trace.id)).collect()
}

/// Warns of traces with an irregular sampling interval.
pub fn irregular<'a>(traces: impl Iterator<Item = &'a Trace> + Clone) -> Option<String> {
    let irregular = traces.clone().filter(|trace| is_irregular(trace));
    let first = irregular.clone().next().map(|first| first.id.as_str());
    of_irregular(irregular.count(), traces.count(), first)
}

/// Warns of traces whose velocity is not the slope of the angle.
pub fn contradictory<'a>(traces: impl Iterator<Item = &'a Trace> + Clone) -> Option<String> {
    let ratio = |trace: &'a Trace| {
        let (motion, interval_s) = (trace.motion.as_ref()?, trace.interval_s?);
        Some((trace.id.as_str(), velocity_ratio(&motion.angle_rad, &motion.velocity_rad_s, 1.0 / interval_s)?))
    };
    let found: Vec<(&str, f64)> = traces.clone().filter_map(ratio).collect();
    let (first, ratio) = found.first()?;
    let (count, all) = (found.len(), traces.count());
    Some(format!(
        "{count} of {all} traces have a velocity that is not the slope of the angle, first {first} with {ratio:.4} times \
         it: another unit or gain, or a wrong rate; a segment with such a velocity has no verdict"
    ))
}

/// Returns an error if the angle of most traces is in another unit, or of another shaft, than their velocity says, or
/// begins anew elsewhere than after whole turns.
///
/// # Errors
/// It is.
pub fn refuse_scale<'a>(traces: impl Iterator<Item = &'a Trace>) -> Result<(), Error> {
    /// Ratios from which on, and up to whose inverse, a gain may be wrong.
    const OFF: f64 = 0.5;
    let (mut count, mut first): (usize, Option<(&str, String)>) = (0, None);
    let mut all = 0;
    for trace in traces {
        let Some(motion) = &trace.motion else { continue };
        all += 1;
        let rate_hz = trace.interval_s.map_or(f64::NAN, |interval_s| 1.0 / interval_s);
        let period = wraps_at(&motion.angle_rad);
        let is_whole = period.is_none_or(|period| are_whole(period / TAU));
        let times = slope_by_velocity(&motion.angle_rad, &motion.velocity_rad_s, rate_hz, period);
        let problem = match times.filter(|times| !(OFF..1.0 / OFF).contains(times)) {
            Some(times) if times < 0.0 => {
                format!("the angle turns {times:.4} times as far as the velocity says: the sign")
            }
            Some(times) => format!("the angle turns {times:.4} times as far as the velocity says"),
            None if !is_whole => format!("the angle begins anew at {:.4} rad, which is no turn", period.unwrap_or(0.0)),
            None => continue,
        };
        count += 1;
        first = first.or(Some((trace.id.as_str(), problem)));
    }
    match first.filter(|_| 2 * count > all) {
        Some((id, problem)) => Err(Error::trace(
            id,
            format!(
                "{problem} ({count} of {all} traces). Another unit, an electrical angle, or a gear? Write the unit behind \
                 the column, such as position[turn], or unwrap(theta_e[rad])/7 for 7 pole pairs"
            ),
        )),
        None => Ok(()),
    }
}

/// Warns of values of the shaft that are no measurements.
pub fn codes<'a>(traces: impl Iterator<Item = &'a Trace>) -> Option<String> {
    let of_trace = |trace: &'a Trace| {
        let motion = trace.motion.as_ref()?;
        let signals = [("current", &motion.current_a), ("velocity", &motion.velocity_rad_s), ("load", &motion.load_nm)];
        let told = |(name, x): (&str, &Vec<f64>)| {
            let column = Column::of(x);
            column.outside?;
            column.findings(None).into_iter().next().map(|what| format!("{name}: {what}"))
        };
        Some((trace.id.as_str(), signals.into_iter().find_map(told)?))
    };
    let coded: Vec<(&str, String)> = traces.filter_map(of_trace).collect();
    let (first, what) = coded.first()?;
    Some(format!("{} traces have values that are no measurements, first {first}: {what}", coded.len()))
}

/// Whether more than 2 % of the steps are off by a tenth.
#[must_use]
pub const fn is_irregular(trace: &Trace) -> bool {
    50 * trace.irregular_steps > trace.y.len()
}

/// Warns of so many traces with an irregular sampling interval, if there are any.
#[must_use]
pub fn of_irregular(count: usize, all: usize, first: Option<&str>) -> Option<String> {
    first.map(|first| {
        format!(
            "{count} of {all} traces are sampled irregularly (more than 2 % of the steps off by a tenth), first \
             {first}; resample them"
        )
    })
}
