//! Columns at irregular times → columns at a constant rate.
//!
//! ```text
//! t_k = t_0 + k/(m f)    straight lines between the samples, m f: the least multiple of f not below the recorded rate
//! every m-th             behind a zero-phase low pass (`super::prepare::decimate`)
//! ```
//!
//! Rows that lack their time or a number of a column are left out.
//! A step of more than [`GAP`] usual ones and of more than `BRIDGED` new ones is a gap: columns are cut there, since
//! straight lines across it would be invented. An angle that jumps by more than half a turn is unwrapped first, and is
//! not limited to one turn after.

use model::Error;
use model::trace::median;
use model::trace::prepare::{decimate, resample};

/// Usual steps that a gap is longer than.
pub const GAP: f64 = 3.0;
/// Steps of the new rate that straight lines may bridge.
const BRIDGED: f64 = 1.5;
/// The fewest samples of a piece.
const FEWEST: usize = 8;

/// Columns without a gap at a constant rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Time of the first row, s.
    pub start_s: f64,
    /// The columns, of one length.
    pub columns: Vec<Vec<f64>>,
}

/// What was found in the times.
#[derive(Clone, Debug, PartialEq)]
pub struct Resampled {
    /// What lies between the gaps, in its order.
    pub pieces: Vec<Piece>,
    /// Start and length of each gap, s.
    pub gaps: Vec<[f64; 2]>,
    /// The usual step, s.
    pub usual_s: f64,
    /// Number of rows that were left out, since they lack a number.
    pub left_out: usize,
}

/// Returns the columns at a rate; `turns` has the length of a turn in the unit of each column that is an angle.
///
/// # Errors
/// Times that do not grow, fewer than eight samples, or a rate above the recorded one.
pub fn at_rate(times_s: &[f64], columns: &[Vec<f64>], turns: &[Option<f64>], rate_hz: f64) -> Result<Resampled, Error> {
    let is_whole = |row: &usize| times_s[*row].is_finite() && columns.iter().all(|column| column[*row].is_finite());
    let whole: Vec<usize> = (0..times_s.len()).filter(is_whole).collect();
    let left_out = times_s.len() - whole.len();
    if left_out > 0 {
        let of = |column: &[f64]| -> Vec<f64> { whole.iter().map(|row| column[*row]).collect() };
        let columns: Vec<Vec<f64>> = columns.iter().map(|column| of(column)).collect();
        return Ok(Resampled { left_out, ..at_rate(&of(times_s), &columns, turns, rate_hz)? });
    }
    let steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if let Some(at) = steps.iter().position(|step| *step <= 0.0 || step.is_nan()) {
        return Err(Error::Usage(format!("row {} is not later than the one before it", at + 2)));
    }
    let usual_s = if steps.is_empty() { f64::INFINITY } else { median(&steps) };
    let longest_s = (GAP * usual_s).max(BRIDGED / rate_hz);
    let breaks: Vec<usize> = (1..times_s.len()).filter(|row| times_s[*row] - times_s[row - 1] > longest_s).collect();
    if times_s.len() < FEWEST || rate_hz * usual_s > 1.02 {
        let recorded = 1.0 / usual_s;
        return Err(Error::Usage(format!(
            "{} rows at about {recorded:.2} a second cannot be had at {rate_hz} a second; give a lower rate",
            times_s.len()
        )));
    }
    // The rounding of recorded times makes no rate a little higher.
    let factor = (0.98 / (rate_hz * usual_s)).ceil().max(1.0);
    let gaps = breaks.iter().map(|row| [times_s[row - 1], times_s[*row] - times_s[row - 1]]).collect();
    let bounds: Vec<usize> = std::iter::once(0).chain(breaks).chain([times_s.len()]).collect();
    let mut pieces = Vec::new();
    for rows in bounds.windows(2).map(|pair| pair[0]..pair[1]).filter(|rows| rows.len() >= FEWEST) {
        let times = &times_s[rows.clone()];
        let each = |(column, turn): (&Vec<f64>, &Option<f64>)| {
            let own = column[rows.clone()].to_vec();
            let own = turn.map_or_else(|| own.clone(), |turn| unwrapped(&own, turn));
            Ok(decimate(&resample(times, &own, factor * rate_hz)?, factor as usize))
        };
        let columns = columns.iter().zip(turns).map(each).collect::<Result<_, Error>>()?;
        pieces.push(Piece { start_s: times[0], columns });
    }
    Ok(Resampled { pieces, gaps, usual_s, left_out: 0 })
}

/// An angle without its jumps by whole turns.
#[must_use]
pub fn unwrapped(angle: &[f64], turn: f64) -> Vec<f64> {
    let (mut turns, mut last) = (0.0, angle.first().copied().unwrap_or(0.0));
    let each = |value: &f64| {
        turns -= ((value - last) / turn).round();
        last = *value;
        value + turns * turn
    };
    angle.iter().map(each).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Times of 3 to 9 ms, as of a logger that polls.
    fn times(count: u32) -> Vec<f64> {
        let step = |k: u32| 0.003 + 0.006 * f64::from(k * 7 % 13) / 12.0;
        (0..count).map(|k| (0..k).map(step).sum()).collect()
    }

    #[test]
    fn slow_signals_at_irregular_times_stay() {
        let times = times(3000);
        let wave = times.iter().map(|t| (TAU * t).sin()).collect();
        let found = at_rate(&times, &[wave], &[None], 50.0).expect("resampled");
        assert!(found.gaps.is_empty() && found.pieces.len() == 1 && (found.usual_s - 0.006).abs() < 1e-3);
        let slow = &found.pieces[0].columns[0];
        // Straight lines of 9 ms under a sine of 1 Hz are off by (2π·9 ms)²/8 = 4e-4 at most.
        assert!((50..slow.len() - 50).all(|k| (slow[k] - (TAU * k as f64 / 50.0).sin()).abs() < 1e-3));
    }

    #[test]
    fn frequencies_beyond_the_new_limit_go() {
        let times: Vec<f64> = (0..2000).map(|k| f64::from(k) / 200.0).collect();
        let wave = times.iter().map(|t| (TAU * 60.0 * t).sin()).collect();
        let found = at_rate(&times, &[wave], &[None], 50.0).expect("resampled");
        let fast = &found.pieces[0].columns[0];
        // 60 Hz would be 10 Hz; the filter stops 60 dB.
        assert!((50..fast.len() - 50).all(|k| fast[k].abs() < 1.1e-3));
    }

    #[test]
    fn a_gap_shorter_than_a_new_step_is_bridged() {
        let times: Vec<f64> = (0..400).map(|k| 0.004 * f64::from(k + 3 * (k / 20))).collect();
        let ramp = vec![times.clone()];
        let slow = at_rate(&times, &ramp, &[None], 50.0).expect("resampled");
        assert!(slow.gaps.is_empty() && slow.pieces.len() == 1, "{:?}", slow.gaps);
        assert_eq!(at_rate(&times, &ramp, &[None], 200.0).expect("resampled").gaps.len(), 19);
    }

    #[test]
    fn rows_without_a_number_are_left_out_and_a_run_of_them_is_a_gap() {
        let times: Vec<f64> = (0..300).map(|k| 0.01 * f64::from(k)).collect();
        let mut ramp = times.clone();
        (ramp[20], ramp[150], ramp[151], ramp[152]) = (f64::NAN, f64::NAN, f64::NAN, f64::NAN);
        let found = at_rate(&times, &[ramp], &[None], 100.0).expect("resampled");
        assert_eq!((found.left_out, found.pieces.len(), found.gaps.len()), (4, 2, 1));
        // A straight line goes through its missing value, but for rounding.
        assert!((found.pieces[0].columns[0][20] - 0.2).abs() < 1e-9);
    }

    #[test]
    fn gaps_cut_and_angles_do_not_jump() {
        let mut times: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        times.iter_mut().skip(120).for_each(|t| *t += 0.5);
        let angle: Vec<f64> = times.iter().map(|t| (8.0 * t).rem_euclid(TAU)).collect();
        let found = at_rate(&times, &[angle], &[Some(TAU)], 100.0).expect("resampled");
        assert_eq!((found.pieces.len(), found.gaps.len()), (2, 1));
        assert!((found.gaps[0][0] - 1.19).abs() < 1e-9 && (found.gaps[0][1] - 0.51).abs() < 1e-9);
        for piece in &found.pieces {
            assert!(piece.columns[0].windows(2).all(|pair| (pair[1] - pair[0] - 0.08).abs() < 1e-9));
        }
        assert!((found.pieces[1].start_s - 1.7).abs() < 1e-9);
    }

    #[test]
    fn higher_rates_and_disorder_are_refused() {
        let times: Vec<f64> = (0..20).map(|k| 0.01 * f64::from(k)).collect();
        let column = vec![vec![0.0; 20]];
        assert!(at_rate(&times, &column, &[None], 100.5).is_ok(), "the rounding of times");
        let problem = at_rate(&times, &column, &[None], 200.0).expect_err("higher").to_string();
        assert!(problem.contains("at about 100.00 a second cannot be had at 200"), "{problem}");
        let back: Vec<f64> = times.iter().rev().copied().collect();
        assert!(at_rate(&back, &column, &[None], 50.0).expect_err("back").to_string().contains("row 2"));
    }

    #[test]
    fn a_gap_of_a_few_rows_cuts_and_short_pieces_go() {
        // 20 rows, a gap of 10 steps, 7 rows, a gap, 20 rows.
        let start = |row: u32| {
            row + if row >= 27 {
                18
            } else if row >= 20 {
                9
            } else {
                0
            }
        };
        let times: Vec<f64> = (0..47).map(|row| 0.01 * f64::from(start(row))).collect();
        let found = at_rate(&times, std::slice::from_ref(&times), &[None], 100.0).expect("resampled");
        assert_eq!(found.gaps.len(), 2, "{:?}", found.gaps);
        assert!(found.gaps.iter().all(|gap| (gap[1] - 0.1).abs() < 1e-9), "{:?}", found.gaps);
        let starts: Vec<f64> = found.pieces.iter().map(|piece| piece.start_s).collect();
        assert!(starts.len() == 2 && starts[0] == 0.0 && (starts[1] - 0.45).abs() < 1e-9, "{starts:?}");
        let few = times.first_chunk::<7>().expect("47 rows");
        assert!(at_rate(few, &[few.to_vec()], &[None], 100.0).is_err(), "seven rows");
    }
}
