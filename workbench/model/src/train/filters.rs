//! The filters of the residual in which the shaft's orders are tracked, from healthy traces.
//!
//! ```text
//! cost = mean ln σ_A + ½ ln mean prominence                                                            (1)
//! ```
//!
//! (1) is the deviation of the orders' amplitudes: the geometric mean of what the control orders say, and how much more
//! noise there is at the orders themselves. A high-pass costs signal where the shaft turns slowly, and removes what the
//! torque balance does not know; parameters of the segment itself know more than nominal ones, and change meanwhile.
//! Which is better depends on the drive: each is tried with the core.

use bearing_watch::model::ShaftConstants;
use bearing_watch::plan::RunTime;
use bearing_watch::shaft::ShaftEstimate;

use super::bench::{Bench, OWN_FROM_ROWS, Watched};
use crate::Error;

/// Traces on which filters are compared.
pub(super) const MOST_COMPARED: usize = 16;

/// Corners of the residual's low-pass and high-pass that are compared.
const POLES_HZ: [f32; 10] = [2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 32.0, 64.0, 128.0, 256.0];
const SLOW_HZ: [f32; 3] = [0.0, 2.0, 4.0];

/// Returns the constants with the best high-pass and parameters, then with the best low-pass.
pub(super) fn best(
    bench: &Bench,
    constants: ShaftConstants<RunTime>,
    healthy: &[Watched<'_>],
) -> Result<ShaftConstants<RunTime>, Error> {
    let healthy = &healthy[..healthy.len().min(MOST_COMPARED)];
    let half = std::f32::consts::PI * constants.balance.interval_s;
    let with = |rows: u16, slow_hz: f32| {
        let mut own = constants.clone();
        own.balance.own_from_rows = rows;
        own.tracking.blocks.high_pass = 1.0 - (-2.0 * half * slow_hz).exp();
        own
    };
    // What is never formed with own parameters stays so.
    let rows = if constants.balance.own_from_rows == u16::MAX { &[u16::MAX][..] } else { &[OWN_FROM_ROWS, u16::MAX] };
    let slow = rows.iter().flat_map(|rows| SLOW_HZ.map(|slow_hz| with(*rows, slow_hz)));
    let best = least(bench, slow.collect(), healthy)?.map_or(constants, |(_, best)| best);
    Ok(least(bench, poles(&best), healthy)?.map_or(best, |(_, best)| best))
}

/// Returns the least cost (1) of any low-pass.
pub(super) fn cost(bench: &Bench, constants: &ShaftConstants<RunTime>, healthy: &[Watched<'_>]) -> Result<f64, Error> {
    let healthy = &healthy[..healthy.len().min(MOST_COMPARED)];
    Ok(least(bench, poles(constants), healthy)?.map_or(f64::INFINITY, |(cost, _)| cost))
}

fn poles(constants: &ShaftConstants<RunTime>) -> Vec<ShaftConstants<RunTime>> {
    let half = std::f32::consts::PI * constants.balance.interval_s;
    let with = |corner_hz: f32| {
        let mut own = constants.clone();
        own.tracking.blocks.pole = ((1.0 - half * corner_hz) / (1.0 + half * corner_hz)).max(0.0);
        own
    };
    POLES_HZ.map(with).to_vec()
}

/// Returns the constants with the least cost (1), and the cost.
fn least(
    bench: &Bench,
    tried: Vec<ShaftConstants<RunTime>>,
    healthy: &[Watched<'_>],
) -> Result<Option<(f64, ShaftConstants<RunTime>)>, Error> {
    let cost = |own: &ShaftConstants<RunTime>| -> Result<f64, Error> {
        let runs = bench.run_all(own, healthy)?;
        let orders = || runs.iter().filter(|run| run.orders_reason.is_none()).flat_map(ShaftEstimate::orders);
        let count = orders().count() as f64;
        if count == 0.0 {
            return Ok(f64::INFINITY);
        }
        let deviations = orders().map(|order| f64::from(order.deviation).max(1e-30).ln()).sum::<f64>() / count;
        let prominence = orders().map(|order| f64::from(order.prominence)).sum::<f64>() / count;
        Ok(deviations + 0.5 * prominence.max(1e-30).ln()) // (1)
    };
    let costs: Vec<f64> = tried.iter().map(cost).collect::<Result<_, _>>()?;
    Ok(costs.into_iter().zip(tried).min_by(|(one, _), (other, _)| one.total_cmp(other)))
}
