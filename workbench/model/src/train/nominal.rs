//! The nominal parameters of the torque balance, and how much they vary, from healthy traces.
//!
//! ```text
//! nominal    median p over the traces that determine it, estimated by the core                            (1)
//! prior      three times the deviation of p over these traces; for terms on which a defect has no effect, 1.5
//!            times what of it the deviations of the estimates do not explain                           (2)
//! ```
//!
//! Without a load sensor the estimates of the core are biased: [`super::reference_instruments`] then corrects them.

use bearing_watch::FrictionTerm;
use bearing_watch::model::Balance;
use bearing_watch::shaft::Friction;

use crate::trace;

/// Terms on which a defect of a bearing has no effect: their spread over healthy traces is that over all traces.
const SPARED: [FrictionTerm; 3] = [FrictionTerm::Offset, FrictionTerm::LoadFriction, FrictionTerm::Stribeck];

/// Sets nominal parameters (1), their prior deviations (2), and the deviation of a row.
pub(super) fn learn(balance: &mut Balance, estimates: &[Friction]) {
    for (term, (nominal, prior)) in
        FrictionTerm::ALL.into_iter().zip(balance.nominal.iter_mut().zip(&mut balance.prior))
    {
        let all: Vec<(f64, f64)> = estimates
            .iter()
            .filter_map(|friction| friction.parameter(term))
            .map(|own| (f64::from(own.value), f64::from(own.deviation)))
            .collect();
        let (usual, determined) = (usual(&all), determined(&all));
        if determined.is_empty() {
            continue;
        }
        let middle = median(determined.clone());
        let spread = 1.483 * median(determined.iter().map(|value| (value - middle).abs()).collect());
        *nominal = middle as f32;
        let width = if SPARED.contains(&term) {
            let own = (spread * spread - usual * usual).max(0.0).sqrt();
            (1.5 * own).max(0.25 * usual)
        } else {
            (3.0 * spread).max(usual)
        };
        *prior = width.max(0.01 * middle.abs()).max(1e-9) as f32;
    }
    let variance = median(estimates.iter().map(|friction| f64::from(friction.variance)).collect());
    balance.deviation = variance.sqrt().max(1e-6) as f32;
}

/// The values whose deviation is at most twice the usual one.
fn determined(all: &[(f64, f64)]) -> Vec<f64> {
    let usual = usual(all);
    all.iter().filter(|(_, own)| *own <= 2.0 * usual).map(|(value, _)| *value).collect()
}

/// The median deviation of values.
fn usual(all: &[(f64, f64)]) -> f64 {
    median(all.iter().map(|(_, deviation)| *deviation).collect())
}

/// The median; zero of nothing.
pub(super) fn median(values: Vec<f64>) -> f64 {
    if values.is_empty() { 0.0 } else { trace::median(values) }
}
