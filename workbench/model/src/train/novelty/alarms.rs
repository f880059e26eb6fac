//! Settings of gate, reject option and alarm.

use crate::Error;

/// Mean time between false alarms if none is given: in hours if the rate is known, else in segments.
const USUAL_HOURS: f64 = 1000.0;
const USUAL_SEGMENTS: f64 = 1e5;

/// Mean time between false alarms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlarmInterval {
    /// 1000 hours, or 100 000 segments if the sampling interval is not known.
    Usual,
    /// Hours.
    Hours(f64),
    /// Segments.
    Segments(f64),
}

/// Settings of gate, reject option and alarm.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarms {
    /// The healthy class; no gate and no alarm without one.
    pub healthy: Option<usize>,
    /// Rate of healthy segments called novel.
    pub false_alarm: f64,
    /// Whether too few segments for a gate are an error; if false, the model then has no gate.
    pub required: bool,
    /// Whether the rate is that of the next run, by the groups of the validation; if false, segments are independent.
    pub by_run: bool,
    /// Cost of no decision; infinite if a decision is always required.
    pub reject_cost: f64,
    /// Mean time between false alarms.
    pub interval: AlarmInterval,
    /// Number of segments after which a run ends by itself in service; if not given, that of the longest healthy
    /// training run, or 1 if segments are independent.
    pub segments_a_run: Option<u32>,
    /// Whether the groups of the validation are drives, and the model is for another one, whose offset lasts.
    pub other_drive: bool,
    /// The smallest defect that a segment shows may be so many times the usual one of training; with a larger one the
    /// segment is not called healthy.
    pub acceptable: f64,
}

/// [`Alarms::acceptable`] if it is not given.
pub const ACCEPTABLE: f64 = 2.0;

impl Default for Alarms {
    fn default() -> Self {
        let interval = AlarmInterval::Usual;
        let reject_cost = f64::INFINITY;
        Self {
            healthy: None,
            false_alarm: 0.01,
            required: false,
            by_run: false,
            reject_cost,
            interval,
            segments_a_run: None,
            other_drive: false,
            acceptable: ACCEPTABLE,
        }
    }
}

/// Returns the mean number of segments between false alarms.
pub(super) fn segments_between(interval: AlarmInterval, segment_s: Option<f64>) -> Result<f64, Error> {
    let segments = match (interval, segment_s) {
        (AlarmInterval::Usual, None) => USUAL_SEGMENTS,
        (AlarmInterval::Usual, Some(seconds)) => (USUAL_HOURS * 3600.0 / seconds).max(USUAL_SEGMENTS.sqrt()),
        (AlarmInterval::Segments(segments), _) => segments,
        (AlarmInterval::Hours(hours), Some(seconds)) => hours * 3600.0 / seconds,
        (AlarmInterval::Hours(_), None) => {
            let problem =
                "the traces have no time, so --alarm-interval-h has no meaning; give --alarm-interval-segments";
            return Err(Error::Usage(problem.into()));
        }
    };
    if segments.is_finite() && segments >= 10.0 {
        return Ok(segments);
    }
    Err(Error::Usage(format!("one false alarm in {segments} segments is no interval; give at least 10 segments")))
}
