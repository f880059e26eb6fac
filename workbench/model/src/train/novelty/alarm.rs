//! Constants of the alarm over many runs.
//!
//! ```text
//! limit = ln(K T)                                                          (1)  K scores, T segments between false alarms
//! cap   = (limit − ln n)/2 + max(ln μ₀(cap), 0)                            (2)  n segments a run
//! ```
//!
//! By (2) a run adds at most half of what the limit demands: one disturbed record raises no alarm, and two runs of a
//! large defect do, whatever the size of the baseline. ln μ₀ grows with the cap, and with a small baseline so fast that
//! (2) has no solution within the surprises that the core follows: then the alarm is refused.

use bearing_watch::model::EvidenceConstants;

use super::baseline::{Means, Size};
use super::gate::Gate;
use crate::Error;
use crate::train::directions::{Directions, limit_and_cap};

/// κ of the evidence: a mean surprise of 5 nats is detected fastest, and a mean surprise of 2 instead of 1 in the
/// healthy state does not yet cause an alarm.
pub const BET: f32 = 0.2;
/// Fewest runs between false alarms.
const LEAST_RUNS: f64 = 10.0;
/// Iterations of (2).
const ITERATIONS: usize = 200;

/// Returns the constants for so many scores and so many segments between false alarms; `lasting` if the drive at hand
/// is another one than those of the training set. ln μ of the defects is 0.
///
/// # Errors
/// More alarms than every tenth run; a baseline that is too small, with what it supports.
pub fn constants(
    gate: &Gate,
    scores: usize,
    segments: f64,
    (segments_a_run, lasting): (u32, bool),
) -> Result<EvidenceConstants, Error> {
    enough(segments, segments_a_run)?;
    let size = match &gate.runs {
        Some(spread) => Size::of_runs(spread, gate.rows, lasting),
        None => Size::independent(gate.mean.len(), gate.rows),
    };
    let means = Means::draw(&size, &gate.knots, f64::from(BET));
    let limit = (scores as f64 * segments).ln();
    let half = 0.5 * (limit - f64::from(segments_a_run).ln());
    let Some((cap, log_mean)) = solve(&means, half) else {
        return Err(Error::Training(refusal(&means, gate, scores, segments, segments_a_run)));
    };
    Ok(EvidenceConstants {
        bet: BET,
        limit: limit as f32,
        cap: cap as f32,
        segments_a_run,
        log_mean: log_mean as f32,
        defect_log_mean: 0.0,
    })
}

/// Returns the constants of an alarm by directions, for so many segments between false alarms; a run ends after those
/// of the longest one if nothing else is said.
///
/// # Errors
/// More alarms than every tenth run.
pub(super) fn of_directions(
    directions: &Directions,
    segments: f64,
    segments_a_run: Option<u32>,
) -> Result<EvidenceConstants, Error> {
    let segments_a_run = segments_a_run.unwrap_or(u32::try_from(directions.longest).unwrap_or(u32::MAX));
    enough(segments, segments_a_run)?;
    let [limit, cap] = limit_and_cap(segments, directions.list.len(), directions.usual);
    Ok(EvidenceConstants {
        bet: BET,
        limit: limit as f32,
        cap: cap as f32,
        segments_a_run,
        log_mean: 0.0,
        defect_log_mean: 0.0,
    })
}

/// Refuses alarms that are more frequent than every tenth run.
fn enough(segments: f64, segments_a_run: u32) -> Result<(), Error> {
    let least = LEAST_RUNS * f64::from(segments_a_run);
    if segments >= least {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "one false alarm in {segments} segments is too often for runs of {segments_a_run} segments; give at least \
         {least} segments"
    )))
}

/// Solves (2) for the cap and ln μ₀.
fn solve(means: &Means, half: f64) -> Option<(f64, f64)> {
    let mut cap = half;
    for _ in 0..ITERATIONS {
        let log_mean = means.log_mean(cap)?;
        let next = half + log_mean.max(0.0);
        if next - cap < 1e-7 {
            return Some((cap, log_mean));
        }
        cap = next;
    }
    None
}

/// Says which time between false alarms the baseline supports.
fn refusal(means: &Means, gate: &Gate, scores: usize, segments: f64, segments_a_run: u32) -> String {
    let (mut low, mut high) = (0.0, 0.5 * (scores as f64 * segments / f64::from(segments_a_run)).ln());
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if solve(means, middle).is_some() { low = middle } else { high = middle }
    }
    let supported = (2.0 * low).exp() * f64::from(segments_a_run) / scores as f64;
    let rows = gate.rows;
    let of = gate.runs.as_ref().map_or_else(|| format!("{rows} segments"), |runs| format!("{} runs", runs.count));
    let instead = if supported < LEAST_RUNS * f64::from(segments_a_run) {
        "support no alarm".to_string()
    } else {
        format!("support one in {supported:.2e} segments")
    };
    format!(
        "{of} say too little of the healthy drive for one false alarm in {segments:.2e} segments: they {instead}; give \
         more, use fewer features, or a shorter --alarm-interval-h or --alarm-interval-segments"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::novelty::laws::knots::knots;
    use crate::train::novelty::laws::law::DistanceLaw;

    fn means(coordinates: usize, rows: usize) -> Means {
        let law = DistanceLaw::gaussian(coordinates, rows);
        Means::draw(&Size::independent(coordinates, rows), &knots(&law, 100_f64.ln()), f64::from(BET))
    }

    #[test]
    fn two_large_runs_reach_the_limit_and_one_does_not() {
        for rows in [12, 40, 1000] {
            let half = 6.9;
            let (cap, log_mean) = solve(&means(2, rows), half).expect("a solution");
            println!("{rows} segments: cap {cap:.3}, ln μ₀ {log_mean:.3}");
            assert!(2.0 * (cap - log_mean) >= 2.0 * half - 1e-6 && cap - log_mean < half + 0.25, "{rows}");
        }
    }
}
