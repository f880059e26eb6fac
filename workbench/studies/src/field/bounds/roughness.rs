//! Roughness in one record, where the temperature changes the friction: the rate at which a detector finds it at 1 %
//! false alarms if it knows how friction and torque constant vary over healthy drives.
//!
//! ```text
//! Λ = Σ_s p(b − ΔB | s) p(κ | s) / Σ_s p(b | s) p(κ | s),   s: temperature, evenly over its range           (1)
//! b = B + σ n,   n ~ N(0, 1)                                                                               (2)
//! κ = ln Kt as the drive measures it, with the errors of its load sensor and current; if known, κ = s       (3)
//! ln B | s ~ N(β₀ + β₁ s, σ_B²),   κ | s ~ N(γ₀ + γ₁ s, σ_κ²)   by least squares over healthy drives          (4)
//! ```
//!
//! (1) is the likelihood ratio, which no test of b and κ exceeds; its limit is that of a part of the healthy drives. σ
//! of (2) is zero, or the error with which the core estimates B, which differs between records: at constant speed it is
//! many times that of a sine.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::field::rows::Row;
use model::evaluate::Rate;
use rig::bearing::ADDED_FRICTION_NM_S_PER_RAD;
use rig::field::FieldValues;
use rig::{NoiseSource, Scenario, Stream};

/// Healthy drives over which a rate is counted.
const DRIVES: u64 = 4000;
/// Temperatures of the sums of (1).
const STATES: usize = 101;
/// Steps of the sum of p(b | s) for (2) on each side of zero, and their width, deviations of ln B.
const SCATTERS: i32 = 14;
const SCATTER_STEP: f64 = 0.25;

/// The bound and what is found, for roughness of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughnessBound {
    /// Size of the roughness.
    pub severity: f64,
    /// By an exact viscous friction.
    pub exact: f64,
    /// By a viscous friction with the error that the core has.
    pub with_error: f64,
    /// The same at the false-alarm rate of one part of the gate.
    pub at_share: f64,
    /// Found by the detector of the table.
    pub found: Option<Rate>,
}

/// s, B and κ of a drive.
#[derive(Clone, Copy, Debug)]
struct Drive {
    state: f64,
    viscous: f64,
    told: f64,
}

impl Drive {
    fn of(row: &Row, seed: u64) -> Option<Self> {
        let (scenario, values) = row.drive(seed);
        let state = values.temperature?.state;
        let gain =
            values.load_sensor.map_or(1.0, |sensor| sensor.gain) / values.current_chain.map_or(1.0, |chain| chain.gain);
        let kt = values.motor(&scenario.motor).kt_nm_per_a;
        let told = if row.known { state } else { (kt * gain).ln() };
        Some(Self { state, viscous: mean_viscous(&scenario, &values), told })
    }
}

/// B, averaged over the warm-up of a record.
pub(super) fn mean_viscous(scenario: &Scenario, values: &FieldValues) -> f64 {
    let duration_s = scenario.samples as f64 * scenario.sample_time_s;
    let warm = values.temperature.map_or(1.0, |own| own.mean_viscous(duration_s));
    values.motor(&scenario.motor).b_nm_s_per_rad * warm
}

/// A normal law whose mean is linear in s.
#[derive(Clone, Copy, Debug)]
struct Line {
    at_zero: f64,
    slope: f64,
    deviation: f64,
}

impl Line {
    /// By least squares; the deviation is at least what a step of s changes.
    fn through(points: &[(f64, f64)]) -> Self {
        let n = points.len() as f64;
        let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / n, y + point.1 / n));
        let sum = |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|point| of(point.0 - x, point.1 - y)).sum::<f64>();
        let slope = sum(&|x, y| x * y) / sum(&|x, _| x * x);
        let deviation = (sum(&|x, y| (y - slope * x).powi(2)) / n).sqrt();
        Self { at_zero: y - slope * x, slope, deviation: deviation.max(slope.abs() / STATES as f64).max(1e-6) }
    }

    fn at(&self, state: f64) -> f64 {
        self.at_zero + self.slope * state
    }

    /// The density at a value, without the factor that does not depend on s.
    fn density(&self, state: f64, value: f64) -> f64 {
        bell((value - self.at(state)) / self.deviation)
    }
}

fn bell(x: f64) -> f64 {
    (-0.5 * x * x).exp()
}

/// Healthy drives of a row, and the laws (4).
#[derive(Clone, Debug)]
pub(super) struct Population {
    drives: Vec<Drive>,
    viscous: Line,
    told: Line,
}

impl Population {
    /// `None` if no temperature changes the friction of the row.
    pub(super) fn of(row: &Row) -> Option<Self> {
        let drives: Vec<Drive> = (0..DRIVES).map(|seed| Drive::of(row, seed)).collect::<Option<_>>()?;
        let through = |pick: fn(&Drive) -> f64| {
            Line::through(&drives.iter().map(|own| (own.state, pick(own))).collect::<Vec<_>>())
        };
        let (viscous, told) = (through(|own| own.viscous.ln()), through(|own| own.told));
        Some(Self { drives, viscous, told })
    }

    /// The rates at which roughness of this size is found at these false-alarm rates, in records with these σ of (2) in
    /// turn, N·m·s/rad.
    pub(super) fn powers(&self, severity: f64, errors: &[f64], rates: &[f64]) -> Vec<f64> {
        let added = ADDED_FRICTION_NM_S_PER_RAD * severity;
        let mut noise = NoiseSource::new(0, Stream::CurrentNoise);
        let of = |(own, error): (&Drive, &f64)| ((own.viscous + error * noise.gaussian(), *error), own.told);
        let measured: Vec<((f64, f64), f64)> = self.drives.iter().zip(errors.iter().cycle()).map(of).collect();
        let ratio = |b: (f64, f64), told: f64| self.ratio(b, told, added);
        let mut healthy: Vec<f64> = measured.par_iter().map(|(b, told)| ratio(*b, *told)).collect();
        healthy.sort_by(f64::total_cmp);
        let defective: Vec<f64> =
            measured.par_iter().map(|((b, error), told)| ratio((b + added, *error), *told)).collect();
        let limit = |rate: f64| healthy[(((1.0 - rate) * DRIVES as f64) as usize).min(healthy.len() - 1)];
        let found = |limit: f64| defective.iter().filter(|own| **own > limit).count() as f64 / DRIVES as f64;
        rates.iter().map(|rate| found(limit(*rate))).collect()
    }

    /// ln Λ of (1).
    fn ratio(&self, (measured, error): (f64, f64), told: f64, added: f64) -> f64 {
        let (mut with, mut without) = (f64::MIN_POSITIVE, f64::MIN_POSITIVE);
        for k in 0..STATES {
            let state = k as f64 / (STATES - 1) as f64;
            let own = self.told.density(state, told);
            with += own * self.density(state, measured - added, error);
            without += own * self.density(state, measured, error);
        }
        with.ln() - without.ln()
    }

    /// p(b | s), without the same factor as [`Line::density`].
    fn density(&self, state: f64, measured: f64, error: f64) -> f64 {
        if error <= 0.0 {
            return if measured > 0.0 { self.viscous.density(state, measured.ln()) / measured } else { 0.0 };
        }
        let middle = self.viscous.at(state);
        let of = |k: i32| {
            let scatter = SCATTER_STEP * f64::from(k);
            let own = (middle + scatter * self.viscous.deviation).exp();
            SCATTER_STEP * bell(scatter) * bell((measured - own) / error) / ((2.0 * PI).sqrt() * error)
        };
        self.viscous.deviation * (-SCATTERS..=SCATTERS).map(of).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::recipe::FALSE_ALARM;
    use crate::field::rows::named;

    fn found(row: &str, severity: f64, error: f64) -> Option<f64> {
        let row = named(&[row.into()]).expect("known")[0];
        Population::of(&row).map(|drives| drives.powers(severity, &[error], &[FALSE_ALARM])[0])
    }

    #[test]
    fn friction_that_is_known_at_a_known_temperature_shows_what_exceeds_its_scatter() {
        assert_eq!(found("mix", 0.125, 0.0), None);
        // B is lognormal, with the deviation 0.2 and 0.037 of the warm-up, and its medians lie evenly, in the
        // logarithm, between 0.25 and 0.04 mN·m·s; an alarm at 1 % of each median.
        let normal = |x: f64| statrs::function::erf::erfc(-x / 2.0_f64.sqrt()) / 2.0;
        let each = |k: i32| {
            let median = 2.34e-4 * (0.16_f64).powf((f64::from(k) + 0.5) / 200.0);
            let limit = median * (2.326 * 0.204_f64).exp();
            let below = limit - 6.25e-5;
            if below <= 0.0 { 1.0 } else { 1.0 - normal((below / median).ln() / 0.204) }
        };
        let even = (0..200).map(each).sum::<f64>() / 200.0;
        let exact = found("temperature-known", 1.0 / 32.0, 0.0).expect("varies");
        // The best limits are not even: they find somewhat more.
        assert!(exact > even - 0.02 && exact < even + 0.1, "{exact} {even}");
    }

    #[test]
    fn what_is_known_less_well_shows_less() {
        let at = |row, error| found(row, 0.125, error).expect("varies");
        let exact = at("field-sine", 0.0);
        assert!(at("temperature", 0.0) > exact && exact > at("field-sine", 5e-5) + 0.1, "{exact}");
        // Without a defect, nothing but false alarms.
        assert!((found("field-sine", 0.0, 0.0).expect("varies") - FALSE_ALARM).abs() <= FALSE_ALARM);
    }
}
