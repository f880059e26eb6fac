//! The length of a segment, if none is given.
//!
//! A trace is one segment, unless it is much longer than a verdict needs: then it is cut into equal segments of at
//! least ten seconds, a hundred turns and ten thousand samples. They have enough rows for a feature's error to be small
//! beside its spread between records, enough turns to tell the orders of a bearing apart, and the drive has a verdict
//! long before the end of such a trace. Without fading memory a segment has at most [`MAX_SEGMENT_ROWS`].

use std::f64::consts::TAU;

use bearing_watch::model::{MAX_SEGMENT_ROWS, MAX_SEGMENT_SAMPLES};

use super::{Estimation, Recipe};
use crate::trace::labels::LabelledTrace;
use crate::trace::median;

const SECONDS: f64 = 10.0;
const TURNS: f64 = 100.0;
const SAMPLES: f64 = 10_000.0;

/// Returns the number of samples in a segment, and the recipe with it if it was not given and traces are longer.
pub(super) fn resolved(traces: &[LabelledTrace], recipe: &Recipe) -> (usize, Recipe) {
    if let Some(samples) = recipe.estimation.segment {
        return (samples, recipe.clone());
    }
    let longest = traces.iter().map(|t| t.trace.y.len()).max().unwrap_or(0);
    let most = recipe.estimation.memory.map_or(MAX_SEGMENT_ROWS, |_| MAX_SEGMENT_SAMPLES) as usize;
    let samples = longest / (longest / least(traces)).max(longest.div_ceil(most)).max(1);
    let segment = (samples < longest).then_some(samples);
    (samples, Recipe { estimation: Estimation { segment, ..recipe.estimation.clone() }, ..recipe.clone() })
}

/// Returns the fewest samples of a part of a trace.
fn least(traces: &[LabelledTrace]) -> usize {
    let interval_s = traces.iter().find_map(|t| t.trace.interval_s).unwrap_or(0.0);
    let of_time = if interval_s > 0.0 { SECONDS / interval_s } else { 0.0 };
    let speeds: Vec<f64> = traces.iter().filter_map(mean_speed).collect();
    let turns_a_sample = if speeds.is_empty() { 0.0 } else { median(speeds) * interval_s / TAU };
    let of_turns = if turns_a_sample > 0.0 { TURNS / turns_a_sample } else { 0.0 };
    let least = SAMPLES.max(of_time).max(of_turns);
    if least < f64::from(MAX_SEGMENT_ROWS) { least.ceil() as usize } else { MAX_SEGMENT_ROWS as usize }
}

/// Mean magnitude of a trace's velocity, rad/s.
fn mean_speed(labelled: &LabelledTrace) -> Option<f64> {
    let motion = labelled.trace.motion.as_ref()?;
    let speeds = || motion.velocity_rad_s.iter().copied().filter(|speed| speed.is_finite());
    let count = speeds().count();
    (count > 0).then(|| speeds().map(f64::abs).sum::<f64>() / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::Structure;
    use crate::trace::{MotionTrace, Trace};

    /// Returns the samples in a segment of traces at 500 Hz with these numbers of samples, and what the recipe has
    /// then.
    fn of(samples: &[usize], velocity_rad_s: f64) -> (usize, Option<usize>) {
        let trace = |&n: &usize| {
            let motion = MotionTrace { velocity_rad_s: vec![velocity_rad_s; n], ..MotionTrace::default() };
            let trace = Trace { interval_s: Some(0.002), y: vec![0.0; n], motion: Some(motion), ..Trace::default() };
            LabelledTrace { trace, class: 0 }
        };
        let traces: Vec<LabelledTrace> = samples.iter().map(trace).collect();
        let recipe = Recipe::new(Structure::new(1, 1, 1, 1, 1));
        let (samples, recipe) = resolved(&traces, &recipe);
        (samples, recipe.estimation.segment)
    }

    #[test]
    fn long_traces_are_cut_into_equal_parts() {
        // Less than two parts of 10 000 samples: the whole trace.
        assert_eq!(of(&[5000, 4000], 40.0), (5000, None));
        assert_eq!(of(&[19_999], 40.0), (19_999, None));
        // 150 000 samples are 15 parts; a shorter trace is cut as well.
        assert_eq!(of(&[150_000, 30_000], 40.0), (10_000, Some(10_000)));
        assert_eq!(of(&[25_000], 40.0), (12_500, Some(12_500)));
        // At 2 rad/s a hundred turns take 314 s, 157 080 samples: more than the core sums.
        assert_eq!(of(&[100_000], 2.0), (100_000, None));
        assert_eq!(of(&[150_000], 2.0), (75_000, Some(75_000)));
        assert_eq!(of(&[290_000], 2.0), (96_666, Some(96_666)));
        assert_eq!(of(&[], 2.0), (0, None));
    }
}
