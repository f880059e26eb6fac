//! Mass and friction of a linear drive, or inertia and friction of a rotary one: position is then the angle in rad,
//! force the torque in N·m.
//!
//! Input: position and force at a constant rate. Output: M, Fv, Fc and offset, or M with one-sided friction.
//!
//! ```text
//! F = M a + Fv v + Fc sign v + offset                                                        (1)
//! F = M a + { Fv⁺ v + Fc⁺ for v > 0,  Fv⁻ v − Fc⁻ for v < 0 }                                (2)
//! ```
//!
//! Velocity and acceleration are central differences of the position after a fourth-order Butterworth filter run
//! forward and backward. Force and every column of (1) then pass the same zero-phase Chebyshev filter and are
//! decimated, which keeps the equation between them valid (Janot, Gautier, Brunot 2019). If the two sides of (2) differ
//! by more than the standard deviation of the difference, the screw is worn or misaligned:
//!
//! ```text
//! D = F⁻ − F⁺,   var D = var F⁻ + var F⁺ − 2 cov(F⁻, F⁺),   z = D / sd D                     (3)
//! ```
//!
//! The covariance is valid for correlated residuals. (2) has no offset of the force sensor; an offset appears there as
//! a difference of the Coulomb friction (Fc⁻ − Fc⁺ = −2 offset), so the viscous difference is the more reliable
//! indicator of wear.

use nalgebra::{DMatrix, DVector};

use super::filter::LowPass;
use super::{GreyBox, regression};
use crate::Error;

/// Force and position of a drive.
#[derive(Clone, Copy, Debug)]
pub struct LinearRecord<'a> {
    /// Name of the trace, for messages.
    pub id: &'a str,
    /// Sampling interval.
    pub interval_s: f64,
    /// Measured position.
    pub position_m: &'a [f64],
    /// Force on the carriage.
    pub force_n: &'a [f64],
}

/// Friction model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Friction {
    /// (1).
    Symmetric,
    /// (2).
    OneSided,
}

/// Filter settings before the regression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearSettings {
    /// Friction model.
    pub friction: Friction,
    /// Cut-off of the position filter.
    pub cutoff_hz: f64,
    /// Decimation factor: samples per row.
    pub decimate: usize,
    /// Angle and torque instead of position and force.
    pub rotary: bool,
}

impl Default for LinearSettings {
    fn default() -> Self {
        Self { friction: Friction::Symmetric, cutoff_hz: 100.0, decimate: 10, rotary: false }
    }
}

/// Filter periods dropped at each end, where the position filter has end effects.
const DROPPED_PERIODS: f64 = 5.0;

const SYMMETRIC: [(&str, &str); 4] = [("M", "kg"), ("Fv", "N·s/m"), ("Fc", "N"), ("offset", "N")];
const ROTARY: [(&str, &str); 4] = [("J", "kg·m²"), ("B", "N·m·s/rad"), ("Tc", "N·m"), ("offset", "N·m")];
const ROTARY_ONE_SIDED: [(&str, &str); 5] =
    [("J", "kg·m²"), ("B+", "N·m·s/rad"), ("Tc+", "N·m"), ("B-", "N·m·s/rad"), ("Tc-", "N·m")];
const ONE_SIDED: [(&str, &str); 5] = [("M", "kg"), ("Fv+", "N·s/m"), ("Fc+", "N"), ("Fv-", "N·s/m"), ("Fc-", "N")];

/// Estimates (1) or (2) by least squares.
///
/// # Errors
/// Settings that are invalid at the record's rate; a record that is too short or does not move in both directions.
pub fn estimate(record: &LinearRecord, settings: &LinearSettings) -> Result<GreyBox, Error> {
    let (x, force) = rows(record, settings)?;
    let names = names(settings);
    if x.nrows() < 4 * names.len() {
        let problem = format!("{} rows after decimation are too few; record more or decimate less", x.nrows());
        return Err(Error::trace(record.id, problem));
    }
    // Newey and West's rule of thumb for the number of lags.
    let lags = (4.0 * (x.nrows() as f64 / 100.0).powf(2.0 / 9.0)).ceil() as usize;
    let solution = regression::solve(&x, &x, &force, lags).map_err(|column| {
        let name = names[column].0;
        let problem = format!("the motion does not determine {name}; drive both ways, at several speeds");
        Error::trace(record.id, problem)
    })?;
    let found = (solution.relative_error, x.nrows());
    let mut grey_box = GreyBox::new(names, solution.theta.as_slice(), solution.covariance, found);
    grey_box.note_undetermined();
    Ok(grey_box)
}

/// Difference (3) of one friction constant between backward and forward motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asymmetry {
    /// Symbol of the friction: `Fv` or `Fc`.
    pub name: &'static str,
    /// Unit, SI.
    pub unit: &'static str,
    /// D.
    pub value: f64,
    /// Standard deviation of D.
    pub sd: f64,
}

impl Asymmetry {
    /// D divided by its standard deviation.
    #[must_use]
    pub fn z(&self) -> f64 {
        self.value / self.sd
    }
}

/// The differences (3) of viscous and Coulomb friction; empty if the friction model is symmetric.
#[must_use]
pub fn asymmetries(found: &GreyBox) -> Vec<Asymmetry> {
    let place = |name: &str| found.quantities.iter().position(|q| q.name == name);
    let each = |(name, forward, backward): (&'static str, &str, &str)| {
        let (f, b) = (place(forward)?, place(backward)?);
        let variance = found.covariance[(f, f)] + found.covariance[(b, b)] - 2.0 * found.covariance[(f, b)];
        let value = found.quantities[b].value - found.quantities[f].value;
        Some(Asymmetry { name, unit: found.quantities[f].unit, value, sd: variance.sqrt() })
    };
    let pairs = [("Fv", "Fv+", "Fv-"), ("Fc", "Fc+", "Fc-"), ("B", "B+", "B-"), ("Tc", "Tc+", "Tc-")];
    pairs.into_iter().filter_map(each).collect()
}

/// 100 ‖F − F̂‖/‖F‖ on this record, for constants estimated from another record.
///
/// # Errors
/// The errors of [`estimate`].
pub fn cross_validate(record: &LinearRecord, settings: &LinearSettings, found: &GreyBox) -> Result<f64, Error> {
    let (x, force) = rows(record, settings)?;
    let theta = DVector::from_iterator(found.quantities.len(), found.quantities.iter().map(|q| q.value));
    if x.ncols() != theta.len() {
        return Err(Error::Usage("the constants are those of another friction model; estimate with the same".into()));
    }
    Ok(100.0 * (&force - x * theta).norm() / force.norm())
}

fn names(settings: &LinearSettings) -> &'static [(&'static str, &'static str)] {
    match (settings.friction, settings.rotary) {
        (Friction::Symmetric, false) => &SYMMETRIC,
        (Friction::OneSided, false) => &ONE_SIDED,
        (Friction::Symmetric, true) => &ROTARY,
        (Friction::OneSided, true) => &ROTARY_ONE_SIDED,
    }
}

/// Columns of (1) or (2), and the force.
fn rows(record: &LinearRecord, settings: &LinearSettings) -> Result<(DMatrix<f64>, DVector<f64>), Error> {
    let cutoff = settings.cutoff_hz * record.interval_s;
    if !(cutoff > 0.0 && cutoff < 0.5) || settings.decimate == 0 {
        let half_rate_hz = 0.5 / record.interval_s;
        return Err(Error::Usage(format!(
            "the position filter needs a cut-off between 0 and {half_rate_hz} Hz (half the sampling rate) and \
             decimation by at least 1"
        )));
    }
    let dropped = (DROPPED_PERIODS / cutoff).ceil() as usize;
    let count = record.position_m.len().min(record.force_n.len());
    if count < 2 * dropped + 20 * settings.decimate {
        let problem = format!("{count} samples are too few for these filters; record more");
        return Err(Error::trace(record.id, problem));
    }
    let position = LowPass::butterworth(2, cutoff).zero_phase(&record.position_m[..count]);
    let velocity = central_difference(&position, record.interval_s);
    let acceleration = central_difference(&velocity, record.interval_s);
    let direction: Vec<f64> = velocity.iter().map(|v| sign(*v)).collect();
    let decimated = |x: &[f64]| decimate(&x[dropped..count - dropped], settings.decimate);
    let [a, v, s, force] =
        [&acceleration, &velocity, &direction, &record.force_n[..count].to_vec()].map(|x| decimated(x));
    let row = |t: usize, column: usize| match (settings.friction, column) {
        (_, 0) => a[t],
        (Friction::Symmetric, 1) => v[t],
        (Friction::Symmetric, 2) => s[t],
        (Friction::Symmetric, _) => 1.0,
        (Friction::OneSided, 1) => v[t].max(0.0),
        (Friction::OneSided, 2) => s[t].max(0.0),
        (Friction::OneSided, 3) => v[t].min(0.0),
        (Friction::OneSided, _) => s[t].min(0.0),
    };
    Ok((DMatrix::from_fn(a.len(), names(settings).len(), row), DVector::from_vec(force)))
}

/// `f64::signum` of zero is one; here it is zero at standstill.
fn sign(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v.signum() }
}

/// (x(t+1) − x(t−1)) / 2T, one-sided at the ends.
fn central_difference(x: &[f64], interval_s: f64) -> Vec<f64> {
    let last = x.len() - 1;
    let at = |t: usize| match t {
        0 => x[1] - x[0],
        t if t == last => x[t] - x[t - 1],
        t => (x[t + 1] - x[t - 1]) / 2.0,
    };
    (0..=last).map(|t| at(t) / interval_s).collect()
}

/// Every n-th sample after an eighth-order Chebyshev filter of 0.05 dB ripple, pass band to 0.8 of the new Nyquist
/// frequency.
fn decimate(x: &[f64], factor: usize) -> Vec<f64> {
    if factor == 1 {
        return x.to_vec();
    }
    LowPass::chebyshev(4, 0.05, 0.4 / factor as f64).zero_phase(x).into_iter().step_by(factor).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Position as the sum of two sines, and the force of (2).
    fn record(one_sided: bool) -> (Vec<f64>, Vec<f64>) {
        let (w1, w2) = (TAU * 0.5, TAU * 1.3);
        let times: Vec<f64> = (0..20_000).map(|k| f64::from(k) * 1e-3).collect();
        let position = times.iter().map(|t| 0.1 * (w1 * t).sin() + 0.02 * (w2 * t).sin()).collect();
        let force = times.iter().map(|t| {
            let v = 0.1 * w1 * (w1 * t).cos() + 0.02 * w2 * (w2 * t).cos();
            let a = -0.1 * w1 * w1 * (w1 * t).sin() - 0.02 * w2 * w2 * (w2 * t).sin();
            let (fv, fc) = if one_sided && v < 0.0 { (240.0, 25.0) } else { (170.0, 20.0) };
            95.0 * a + fv * v + fc * v.signum() - if one_sided { 0.0 } else { 3.0 }
        });
        (position, force.collect())
    }

    #[test]
    fn constants_of_an_exact_motion_come_back() {
        for (friction, truth) in [
            (Friction::Symmetric, vec![95.0, 170.0, 20.0, -3.0]),
            (Friction::OneSided, vec![95.0, 170.0, 20.0, 240.0, 25.0]),
        ] {
            let (position, force) = record(friction == Friction::OneSided);
            let record = LinearRecord { id: "x", interval_s: 1e-3, position_m: &position, force_n: &force };
            let settings = LinearSettings { friction, ..LinearSettings::default() };
            let found = estimate(&record, &settings).expect("rich motion");
            for (q, truth) in found.quantities.iter().zip(truth) {
                // Central differences have an error of (ωT)²/6 ≈ 1e-5; rows across a reversal mix the two sides of (2):
                // 1 %.
                let tolerance = if friction == Friction::Symmetric { 1e-3 } else { 1e-2 };
                assert!((q.value / truth - 1.0).abs() < tolerance, "{q:?}, truth {truth}");
                assert!(q.sd > 0.0);
            }
            let differences = asymmetries(&found);
            if friction == Friction::Symmetric {
                assert!(differences.is_empty());
            } else {
                // 240 − 170 and 25 − 20; each constant is within 1 % above.
                assert!((differences[0].value - 70.0).abs() < 4.0 && (differences[1].value - 5.0).abs() < 0.5);
                assert!(differences.iter().all(|d| d.sd > 0.0 && d.z() > 3.0), "{differences:?}");
            }
            let again = cross_validate(&record, &settings, &found).expect("same record");
            assert!((again - found.relative_error_percent).abs() < 1e-9); // the same rows
        }
    }

    #[test]
    fn what_cannot_be_estimated_is_said() {
        let still = vec![0.0; 2000];
        let record = LinearRecord { id: "x", interval_s: 1e-3, position_m: &still, force_n: &still };
        let message = estimate(&record, &LinearSettings::default()).expect_err("no motion").to_string();
        assert!(message.contains("trace x: the motion does not determine M"), "{message}");
        let fast = LinearSettings { cutoff_hz: 600.0, ..LinearSettings::default() };
        assert!(estimate(&record, &fast).expect_err("above Nyquist").to_string().contains("500 Hz"));
        let short = LinearRecord { position_m: &still[..100], ..record };
        assert!(estimate(&short, &LinearSettings::default()).is_err());
    }
}
