//! The lines of all recordings together.
//!
//! ```text
//! e = Σ (a_k cos kθ + b_k sin kθ) − Kt i Σ (c_k cos kθ + d_k sin kθ)                           (1)
//! ```
//!
//! The first sum does not depend on the current: cogging and unbalance. The second is the ripple of the torque
//! constant, Kt(θ) = Kt (1 + Σ …). Each order is fitted alone first, then those that stand out together, since orders
//! are not orthogonal if the shaft turns unevenly; what no longer stands out is left out.

use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;

use super::residual::{Residual, stacked};
use super::usable;
use super::wave::Wave;
use crate::Error;
use crate::grey_box::normal;

/// What is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinesSettings {
    /// The highest order.
    pub highest_order: u32,
    /// Rate at which any line is reported where there is none.
    pub false_alarm: f64,
}

impl Default for LinesSettings {
    fn default() -> Self {
        Self { highest_order: 48, false_alarm: 0.01 }
    }
}

/// One order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// k of (1).
    pub order: u32,
    /// Torque that does not depend on the current, N·m.
    pub torque_nm: Option<Wave>,
    /// Ripple of the torque constant, relative to it.
    pub ripple: Option<Wave>,
}

/// The lines of recordings.
#[derive(Clone, Debug)]
pub struct Lines {
    /// Those that stand out, by order.
    pub lines: Vec<Line>,
    /// Mean Kt of the recordings.
    pub torque_constant_nm_a: f64,
    /// Turns of the shaft forward and backward.
    pub turns: [f64; 2],
    /// Root mean square of the residual, and of what the lines leave of it.
    pub residual_nm: [f64; 2],
    /// Whether the lag of the current is known in all recordings.
    pub knows_lag: bool,
}

/// The two sums of (1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Torque,
    Ripple,
}

/// A pair of columns.
type Pair = (u32, Part);

/// Finds the lines that stand out.
///
/// # Errors
/// Recordings of too few turns or of one direction; an angle that is not absolute.
pub fn fit(residuals: &[Residual], settings: &LinesSettings) -> Result<Lines, Error> {
    let turns = usable::turns(residuals)?;
    let orders: Vec<u32> = (1..=settings.highest_order).collect();
    // χ² with two degrees of freedom, shared by both parts of all orders.
    let limit = -2.0 * (settings.false_alarm / (2 * orders.len().max(1)) as f64).ln();
    let alone = |&order: &u32| {
        let waves = waves(residuals, &[(order, Part::Torque), (order, Part::Ripple)])?.0;
        Some(waves.into_iter().filter(|(_, wave)| wave.significance() > limit).collect::<Vec<_>>())
    };
    let significant: Vec<(Pair, Wave)> = orders.par_iter().filter_map(alone).flatten().collect();
    // In short recordings a strong order leaks into others, so only the strongest one tells the zero of the angle.
    let of_each: Vec<(u32, Vec<(&str, Wave)>)> =
        orders.par_iter().map(|&order| (order, in_each(residuals, order))).collect();
    let strength = |waves: &[(&str, Wave)]| waves.iter().map(|(_, wave)| wave.significance()).sum::<f64>();
    let strongest = of_each.iter().max_by(|(_, one), (_, other)| strength(one).total_cmp(&strength(other)));
    strongest.map_or(Ok(()), |(order, waves)| usable::absolute(*order, waves))?;
    let mut pairs: Vec<Pair> = significant.into_iter().map(|(pair, _)| pair).collect();
    loop {
        let (all, left) = waves(residuals, &pairs).unwrap_or_default();
        let kept: Vec<Pair> =
            all.iter().filter(|(_, wave)| wave.significance() > limit).map(|(pair, _)| *pair).collect();
        if kept.len() == pairs.len() || kept.is_empty() {
            return Ok(collected(residuals, &all, (turns, left)));
        }
        pairs = kept;
    }
}

/// The torques of these orders and the ripples of those, whether or not they stand out.
///
/// # Errors
/// Those of [`fit`]; signals that do not determine the lines.
pub fn fit_of(residuals: &[Residual], torque_orders: &[u32], ripple_orders: &[u32]) -> Result<Lines, Error> {
    let turns = usable::turns(residuals)?;
    let torques = torque_orders.iter().map(|order| (*order, Part::Torque));
    let pairs: Vec<Pair> = torques.chain(ripple_orders.iter().map(|order| (*order, Part::Ripple))).collect();
    let (all, left) = waves(residuals, &pairs).ok_or_else(usable::undetermined)?;
    Ok(collected(residuals, &all, (turns, left)))
}

/// The torque of one order in each recording.
fn in_each(residuals: &[Residual], order: u32) -> Vec<(&str, Wave)> {
    let one =
        |residual| waves(std::slice::from_ref(residual), &[(order, Part::Torque)])?.0.first().map(|(_, wave)| *wave);
    residuals.iter().filter_map(|residual| Some((residual.id.as_str(), one(residual)?))).collect()
}

/// (1) with these pairs: their waves, and the root mean square of what is left; `None` if they are not determined.
fn waves(residuals: &[Residual], pairs: &[Pair]) -> Option<(Vec<(Pair, Wave)>, f64)> {
    let y = stacked(residuals, |residual| residual.rows_nm().to_vec());
    let column = |order: u32, part: Part, wave: fn(f64) -> f64| {
        stacked(residuals, |residual| {
            residual.column(|angle, torque| {
                let wave = wave(f64::from(order) * angle);
                if part == Part::Torque { wave } else { -torque * wave }
            })
        })
    };
    let mut columns = vec![];
    for &(order, part) in pairs {
        columns.extend([column(order, part, f64::cos), column(order, part, f64::sin)]);
    }
    let lags = residuals.iter().map(Residual::lags).max().unwrap_or(0);
    let solution = normal::solve(&columns, &y, lags)?;
    let left = columns.iter().zip(solution.theta.iter()).fold(y, |left, (column, theta)| left - column * *theta);
    let wave = |(place, pair): (usize, &Pair)| {
        let first = 2 * place;
        let value = Vector2::new(solution.theta[first], solution.theta[first + 1]);
        let covariance = Matrix2::from_fn(|row, column| solution.covariance[(first + row, first + column)]);
        (*pair, Wave { value, covariance })
    };
    Some((pairs.iter().enumerate().map(wave).collect(), left.norm() / (left.len() as f64).sqrt()))
}

fn collected(residuals: &[Residual], all: &[(Pair, Wave)], (turns, left): ([f64; 2], f64)) -> Lines {
    let mut orders: Vec<u32> = all.iter().map(|((order, _), _)| *order).collect();
    orders.sort_unstable();
    orders.dedup();
    let of = |pair: Pair| all.iter().find(|(other, _)| *other == pair).map(|(_, wave)| *wave);
    let line = |&order: &u32| Line { order, torque_nm: of((order, Part::Torque)), ripple: of((order, Part::Ripple)) };
    let y = stacked(residuals, |residual| residual.rows_nm().to_vec());
    let constants = residuals.iter().map(|residual| residual.torque_constant_nm_a);
    Lines {
        lines: orders.iter().map(line).collect(),
        torque_constant_nm_a: constants.sum::<f64>() / residuals.len() as f64,
        turns,
        residual_nm: [y.norm() / (y.len() as f64).sqrt(), left],
        knows_lag: residuals.iter().all(|residual| residual.knows_lag),
    }
}
