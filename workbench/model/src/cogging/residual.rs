//! The residual of the torque balance of each recording, and waves of its angle behind the same filter.
//!
//! ```text
//! e = Kt i − J dω/dt − B ω − Tc tanh(ref/ω₀) − T                                              (1)
//! ```
//!
//! The constants are those of [`motor`], estimated on each recording; their means by precision hold for the drive. The
//! signals at the right of (1) and the angle are delayed by the lag of the current; then one low-pass filters e and
//! every column that is compared with it, so that neither its gain nor its delay has an effect on a wave, at whatever
//! speed. Friction and load of each recording may differ from the means, and the constants were estimated as if nothing
//! turned with the rotor: of e and of every column, the part that ω, tanh, T and a constant explain is left out, which
//! is the same as to estimate them again together with the waves. Not dω/dt: its noise would draw J towards zero.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::Error;
use crate::grey_box::GreyBox;
use crate::grey_box::filter::LowPass;
use crate::grey_box::motor::{self, Load, MotorRecord, MotorSettings};

/// Cut-off of the filter, cycles per sample: above it the derivative of the velocity is mostly noise.
const CUTOFF: f64 = 0.1;
/// Samples after which the filter has settled, and rows that are left out where a delay reaches beyond the end.
const SETTLED: usize = 16;
/// Samples from row to row: the filter leaves little above 0.2 cycles per sample.
const STEP: usize = 2;
/// Time over which the residual is correlated: that of the filter of [`motor`].
const CORRELATED_S: f64 = 0.2;

/// One recording.
#[derive(Clone, Copy, Debug)]
pub struct Recording<'a> {
    /// Signals of the torque balance.
    pub motor: MotorRecord<'a>,
    /// Angle of the shaft, without jumps by whole turns.
    pub angle_rad: &'a [f64],
}

/// The residual of one recording.
#[derive(Clone, Debug)]
pub struct Residual {
    /// Name of the trace.
    pub id: String,
    /// The constants of its torque balance.
    pub constants: GreyBox,
    /// Kt of the drive.
    pub torque_constant_nm_a: f64,
    /// Whether the lag of the current was estimated.
    pub knows_lag: bool,
    /// The angle at the instant of the current.
    pub(super) angle_rad: Vec<f64>,
    /// Kt i, unfiltered.
    torque_nm: Vec<f64>,
    /// (1), filtered, a value a row.
    rows_nm: Vec<f64>,
    /// Orthonormal columns of what is left out.
    left_out: DMatrix<f64>,
    filter: LowPass,
    interval_s: f64,
}

/// Estimates the torque balances and forms the residuals.
///
/// # Errors
/// The errors of [`motor::estimate`].
pub fn residuals(recordings: &[Recording<'_>], settings: &MotorSettings) -> Result<Vec<Residual>, Error> {
    let estimate = |recording: &Recording<'_>| motor::estimate(&recording.motor, settings);
    let constants =
        recordings.par_iter().map(estimate).collect::<Vec<_>>().into_iter().collect::<Result<Vec<_>, _>>()?;
    let drive = Drive::of(&constants, settings);
    let both: Vec<_> = recordings.iter().zip(constants).collect();
    Ok(both.into_par_iter().map(|(recording, motor)| Residual::of(recording, motor, &drive, settings)).collect())
}

/// The constants of the drive.
struct Drive {
    torque_constant_nm_a: f64,
    inertia_kg_m2: f64,
    viscous_nm_s: f64,
    coulomb_nm: f64,
    lag_s: Option<f64>,
}

impl Drive {
    fn of(constants: &[GreyBox], settings: &MotorSettings) -> Self {
        let mean = |name: &str| {
            let all = || constants.iter().filter_map(|box_of_one| box_of_one.get(name));
            let weights: f64 = all().map(|quantity| quantity.sd.powi(-2)).sum();
            let sum: f64 = all().map(|quantity| quantity.value * quantity.sd.powi(-2)).sum();
            (weights > 0.0).then(|| sum / weights).filter(|mean| mean.is_finite())
        };
        Self {
            torque_constant_nm_a: settings.torque_constant_nm_a.or(mean("Kt")).unwrap_or(0.0),
            inertia_kg_m2: mean("J").unwrap_or(0.0),
            viscous_nm_s: mean("B").unwrap_or(0.0),
            coulomb_nm: mean("Tc").unwrap_or(0.0),
            lag_s: mean("lag"),
        }
    }
}

impl Residual {
    fn of(recording: &Recording<'_>, constants: GreyBox, drive: &Drive, settings: &MotorSettings) -> Self {
        let (record, interval_s) = (&recording.motor, recording.motor.interval_s);
        let farthest = 0.5 * SETTLED as f64;
        let lag = drive.lag_s.map_or(0.0, |lag| (lag / interval_s).clamp(-farthest, farthest));
        let late = |x: &[f64]| delayed(x, lag);
        let (velocity, reference) = (late(record.velocity_rad_s), late(record.velocity_ref_rad_s));
        let direction: Vec<f64> =
            reference.iter().map(|velocity| (velocity / settings.direction_rad_s).tanh()).collect();
        let load = match record.load {
            Load::Measured(load) => late(load),
            Load::Constant | Load::Absent => vec![],
        };
        let torque_nm: Vec<f64> = record.current_a.iter().map(|current| drive.torque_constant_nm_a * current).collect();
        let filter = LowPass::butterworth(1, CUTOFF);
        let count = torque_nm.len().min(velocity.len()).min(direction.len());
        let load_at = |k: usize| load.get(k).copied().unwrap_or(0.0);
        let direct =
            |k: usize| torque_nm[k] - drive.viscous_nm_s * velocity[k] - drive.coulomb_nm * direction[k] - load_at(k);
        let smooth = filter.forward(&(0..count).map(direct).collect::<Vec<_>>());
        let slope = filter.derivative(&velocity);
        let inertia = drive.inertia_kg_m2 / interval_s;
        let e: Vec<f64> = smooth.iter().zip(&slope).map(|(x, slope)| x - inertia * slope).collect(); // (1)
        let constant = vec![1.0; count];
        let others = [&constant, &velocity, &direction, &load].map(|x| filter.forward(&x[..count.min(x.len())]));
        let others: Vec<_> = others.iter().map(|x| DVector::from_vec(rows(x).collect())).collect();
        let others: Vec<_> = others.into_iter().filter(|x| x.norm() > 0.0).collect();
        let left_out = if others.is_empty() { DMatrix::zeros(0, 0) } else { DMatrix::from_columns(&others).qr().q() };
        let rows_nm = without(rows(&e).collect(), &left_out);
        Self {
            id: record.id.to_owned(),
            constants,
            torque_constant_nm_a: drive.torque_constant_nm_a,
            knows_lag: drive.lag_s.is_some(),
            angle_rad: late(recording.angle_rad).into_iter().take(count).collect(),
            torque_nm,
            rows_nm,
            left_out,
            filter,
            interval_s,
        }
    }

    /// The rows of (1).
    #[must_use]
    pub fn rows_nm(&self) -> &[f64] {
        &self.rows_nm
    }

    /// The filtered values of a function of angle and motor torque, in the rows of (1).
    pub(super) fn column(&self, of: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let both = self.angle_rad.iter().zip(&self.torque_nm);
        let x: Vec<f64> = both.map(|(angle, torque)| of(*angle, *torque)).collect();
        without(rows(&self.filter.forward(&x)).collect(), &self.left_out)
    }

    /// Rows over which the residual is correlated.
    pub(super) fn lags(&self) -> usize {
        (CORRELATED_S / (self.interval_s * STEP as f64)).ceil() as usize
    }
}

/// The columns of several recordings, one below the other.
pub(super) fn stacked(residuals: &[Residual], of: impl Fn(&Residual) -> Vec<f64>) -> DVector<f64> {
    DVector::from_vec(residuals.iter().flat_map(of).collect())
}

/// A column less its part along orthonormal ones.
fn without(x: Vec<f64>, along: &DMatrix<f64>) -> Vec<f64> {
    let x = DVector::from_vec(x);
    if along.is_empty() {
        return x.data.into();
    }
    (&x - along * along.tr_mul(&x)).data.into()
}

/// Every second sample once the filter has settled, up to where delays reach.
fn rows(x: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let last = x.len().saturating_sub(SETTLED);
    x.iter().take(last).skip(2 * SETTLED).step_by(STEP).copied()
}

/// The signal `x`, delayed by this number of samples, by cubic interpolation (Catmull and Rom). Beyond an end, the
/// signal keeps its value there.
fn delayed(x: &[f64], samples: f64) -> Vec<f64> {
    let whole = samples.floor();
    let (back, part) = (whole as i64, samples - whole);
    let last = x.len() as i64 - 1;
    let at = |place: i64| x[place.clamp(0, last) as usize];
    let value = |k: i64| {
        // From the sample after the instant back to that before it.
        let [a, b, c, d] = [1, 0, -1, -2].map(|step| at(k - back + step));
        let slopes = [0.5 * (c - a), 0.5 * (d - b)];
        let (square, cube) = (part * part, part * part * part);
        b * (2.0 * cube - 3.0 * square + 1.0)
            + slopes[0] * (cube - 2.0 * square + part)
            + c * (3.0 * square - 2.0 * cube)
            + slopes[1] * (cube - square)
    };
    (0..=last).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_moves_a_slow_wave_by_its_phase() {
        let wave = |k: f64| (0.3 * k).sin();
        let x: Vec<f64> = (0..200).map(|k| wave(f64::from(k))).collect();
        for samples in [-1.7, -1.0, 0.0, 0.65, 3.2] {
            let late = delayed(&x, samples);
            let worst = (10..190).map(|k| (late[k] - wave(k as f64 - samples)).abs()).fold(0.0, f64::max);
            // Slopes by differences are low by 0.3²/6, of which an eighth counts amid two samples: 0.3 · 0.015 · 2/8.
            assert!(worst < 1.3e-3, "{samples}: {worst}");
        }
    }
}
