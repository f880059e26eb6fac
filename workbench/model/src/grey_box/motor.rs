//! Inertia, friction and torque constant of a motor from the torque balance.
//!
//! Input: current, velocity, velocity reference and load torque at a constant rate. Output: J, B, Tc, Kt, and the delay
//! of the measured current.
//!
//! ```text
//! Kt i = J dω/dt + B ω + Tc sign ω + T_load                                                  (1)
//! i = θ₁ dω/dt + θ₂ ω + θ₃ tanh(ref/ω₀) + θ₄ dT_load/dt + θ₅ T_load                          (2)
//! Kt = 1/θ₅,  J = θ₁/θ₅,  B = θ₂/θ₅,  Tc = θ₃/θ₅,  lag = −θ₄/θ₅                              (3)
//! ```
//!
//! The load torque determines the scale, so it must be measured, or Kt known. With a known Kt,
//!
//! ```text
//! Kt i − T_load = J dω/dt + B ω + Tc sign ω − lag dT_load/dt             measured load             (4)
//! Kt i          = J dω/dt + B ω + Tc sign ω + T0                         constant load T0, or none (5)
//! ```
//! A filter of the current measurement delays the current
//! against the load torque (a filter of the load measurement: negative delay); θ₄ accounts for it, otherwise it would
//! count as noise. Every signal of (2) passes one second-order Butterworth filter, whose state also provides the
//! derivative; no noisy signal is differenced. The velocity is noisy and in a feedback loop: all are solved by
//! instrumental variables, with dω/dt and ω replaced by those of the *reference*. The direction of motion is also taken
//! from the reference, so the drive must follow it. Standard deviations are propagated through (3) by its Jacobian.

use nalgebra::{DMatrix, DVector};

use super::filter::LowPass;
use super::{GreyBox, regression};
use crate::Error;

/// Signals of a motor under velocity control.
#[derive(Clone, Copy, Debug)]
pub struct MotorRecord<'a> {
    /// Name of the trace, for messages.
    pub id: &'a str,
    /// Sampling interval.
    pub interval_s: f64,
    /// Torque-producing current.
    pub current_a: &'a [f64],
    /// Measured velocity.
    pub velocity_rad_s: &'a [f64],
    /// Velocity reference.
    pub velocity_ref_rad_s: &'a [f64],
    /// The load torque, opposing positive rotation.
    pub load: Load<'a>,
}

/// What is known of the load torque.
#[derive(Clone, Copy, Debug)]
pub enum Load<'a> {
    /// Measured, N·m.
    Measured(&'a [f64]),
    /// Constant but unknown.
    Constant,
    /// There is none.
    Absent,
}

/// Filter settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorSettings {
    /// Cut-off of the state-variable filter.
    pub cutoff_hz: f64,
    /// ω₀ of (2): below this velocity the direction term decreases smoothly.
    pub direction_rad_s: f64,
    /// Kt, if it is known.
    pub torque_constant_nm_a: Option<f64>,
}

impl Default for MotorSettings {
    fn default() -> Self {
        Self { cutoff_hz: 8.0, direction_rad_s: 2.0, torque_constant_nm_a: None }
    }
}

/// Time dropped at the start, in periods of the cut-off: the initial transient of the filter has decayed to e⁻⁷.
const DROPPED_PERIODS: f64 = 1.6;

const KT: (&str, &str) = ("Kt", "N·m/A");
const LAG: (&str, &str) = ("lag", "s");
const NAMES: [(&str, &str); 3] = [("J", "kg·m²"), ("B", "N·m·s/rad"), ("Tc", "N·m")];

/// Estimates (2), or (4) or (5) with a known torque constant.
///
/// # Errors
/// A cut-off that is invalid at the record's rate; too few samples; signals that do not determine a constant.
pub fn estimate(record: &MotorRecord, settings: &MotorSettings) -> Result<GreyBox, Error> {
    let cutoff = settings.cutoff_hz * record.interval_s;
    if !(cutoff > 0.0 && cutoff < 0.5 && settings.direction_rad_s > 0.0) {
        let half_rate_hz = 0.5 / record.interval_s;
        return Err(Error::Usage(format!(
            "the filter needs a cut-off between 0 and {half_rate_hz} Hz (half the sampling rate), and the direction a \
             positive velocity"
        )));
    }
    let dropped = (DROPPED_PERIODS / cutoff).ceil() as usize;
    let measured = match record.load {
        Load::Measured(load) => Some(load),
        Load::Constant | Load::Absent => None,
    };
    if measured.is_none() && settings.torque_constant_nm_a.is_none() {
        let problem = "without a measured load torque, the torque constant must be known: give --kt, N·m/A";
        return Err(Error::Usage(problem.into()));
    }
    let samples = [Some(record.current_a), Some(record.velocity_rad_s), Some(record.velocity_ref_rad_s), measured];
    let count = samples.iter().flatten().map(|x| x.len()).min().unwrap_or(0);
    if count < 4 * dropped + 16 {
        let problem = format!("{count} samples are too few for a filter of {} Hz; record more", settings.cutoff_hz);
        return Err(Error::trace(record.id, problem));
    }
    let [current, velocity, reference] =
        [record.current_a, record.velocity_rad_s, record.velocity_ref_rad_s].map(|x| &x[..count]);
    let filter = LowPass::butterworth(1, cutoff);
    let smooth = |x: &[f64]| filter.forward(x)[dropped..].to_vec();
    let slope =
        |x: &[f64]| -> Vec<f64> { filter.derivative(x)[dropped..].iter().map(|d| d / record.interval_s).collect() };
    let direction: Vec<f64> = reference.iter().map(|r| (r / settings.direction_rad_s).tanh()).collect();
    let direction = smooth(&direction);
    let load = measured.map(|load| (slope(&load[..count]), smooth(&load[..count])));
    let (mut names, mut further, mut target) = (NAMES.to_vec(), vec![], smooth(current));
    if let Some(kt) = settings.torque_constant_nm_a {
        target.iter_mut().for_each(|current| *current *= kt);
    }
    match (load, settings.torque_constant_nm_a) {
        (Some((load_slope, load)), None) => {
            names.extend([LAG, KT]);
            further.extend([load_slope, load]);
        }
        (Some((mut load_slope, load)), Some(_)) => {
            names.push(LAG);
            target.iter_mut().zip(load).for_each(|(torque, load)| *torque -= load);
            load_slope.iter_mut().for_each(|slope| *slope = -*slope);
            further.push(load_slope);
        }
        (None, _) if matches!(record.load, Load::Constant) => {
            names.push(("T0", "N·m"));
            further.push(vec![1.0; target.len()]);
        }
        (None, _) => {}
    }
    let matrix = |speed: &[f64]| {
        let columns = [vec![slope(speed), smooth(speed), direction.clone()], further.clone()].concat();
        DMatrix::from_columns(&columns.into_iter().map(DVector::from_vec).collect::<Vec<_>>())
    };
    let (x, z) = (matrix(velocity), matrix(reference));
    // The memory of the filter, over which residuals are correlated.
    let lags = dropped;
    let solution = regression::solve(&x, &z, &DVector::from_vec(target), lags).map_err(|column| {
        let unknown_scale = column >= NAMES.len() && settings.torque_constant_nm_a.is_none();
        let name = if unknown_scale { KT.0 } else { names[column].0 };
        let remedy = match record.load {
            Load::Measured(_) => "the load torque must vary, the motor run both ways at several speeds",
            Load::Constant => {
                "the motor must run both ways at several speeds: a constant load is not told from friction in one"
            }
            Load::Absent => "the motor must run both ways at several speeds",
        };
        Error::trace(record.id, format!("the signals do not determine {name}; {remedy}"))
    })?;
    let found = (solution.relative_error, x.nrows());
    let mut grey_box = match settings.torque_constant_nm_a {
        Some(_) => GreyBox::new(&names, solution.theta.as_slice(), solution.covariance, found),
        None => scaled(record.id, &names, &solution, found)?,
    };
    grey_box.note_undetermined();
    Ok(grey_box)
}

/// The constants (3).
fn scaled(
    id: &str,
    names: &[(&'static str, &'static str)],
    solution: &regression::Solution,
    found: (f64, usize),
) -> Result<GreyBox, Error> {
    let theta = &solution.theta;
    let scale = theta[4];
    if scale <= 0.0 {
        let problem = "the current falls as the load grows; check the sign of the load torque (it opposes rotation)";
        return Err(Error::trace(id, problem));
    }
    let values = [theta[0] / scale, theta[1] / scale, theta[2] / scale, -theta[3] / scale, 1.0 / scale];
    let jacobian = DMatrix::from_fn(5, 5, |row, column| match (row, column) {
        (_, 4) => -values[row] / scale,
        (3, 3) => -1.0 / scale,
        (row, column) if row == column => 1.0 / scale,
        _ => 0.0,
    });
    let covariance = &jacobian * &solution.covariance * jacobian.transpose();
    Ok(GreyBox::new(names, &values, covariance, found))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rig::{Defect, DefectKind, RigTrace, Scenario, simulate, trace_seed};

    fn record(trace: &RigTrace) -> MotorRecord<'_> {
        MotorRecord {
            id: "x",
            interval_s: 0.002,
            current_a: &trace.current_a,
            velocity_rad_s: &trace.velocity_rad_s,
            velocity_ref_rad_s: &trace.velocity_ref_rad_s,
            load: Load::Measured(&trace.load_torque_nm),
        }
    }

    fn found(trace: &RigTrace) -> GreyBox {
        estimate(&record(trace), &MotorSettings::default()).expect("rich signals")
    }

    fn mean_and_sd(x: &[f64]) -> (f64, f64) {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        (mean, (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (x.len() - 1) as f64).sqrt())
    }

    #[test]
    fn constants_of_the_rig_come_back_with_honest_deviations() {
        let runs: Vec<GreyBox> = (0..60)
            .map(|k| {
                let seed = trace_seed(11, DefectKind::Healthy, k);
                found(&simulate(&Scenario::STANDARD, seed).expect("valid"))
            })
            .collect();
        // The delay is that of the rig's current filter, √2/(2π·140 Hz) = 1.6 ms, except for fractions of a sample of 2
        // ms.
        for (name, truth, tolerance) in
            [("J", 2.5e-4, 0.02), ("B", 1e-4, 0.1), ("Kt", 0.05, 0.01), ("Tc", 0.0, 0.0), ("lag", 1.3e-3, 0.5)]
        {
            let all: Vec<_> = runs.iter().map(|run| run.get(name).expect("named")).collect();
            let (mean, scatter) = mean_and_sd(&all.iter().map(|q| q.value).collect::<Vec<_>>());
            let (told, _) = mean_and_sd(&all.iter().map(|q| q.sd).collect::<Vec<_>>());
            println!("{name}: {mean:.4e} (truth {truth:.4e}), scatter {scatter:.2e}, told {told:.2e}");
            assert!((mean - truth).abs() <= tolerance * truth + scatter, "{name}: {mean}");
            // 60 runs determine a scatter to 9 %; Bartlett's weights add a negative bias.
            assert!((0.7..1.4).contains(&(told / scatter)), "{name}: told {told}, scatter {scatter}");
        }
    }

    #[test]
    fn roughness_shows_in_the_viscous_friction_alone() {
        let rough = Scenario::STANDARD.with_defect(Defect::full(DefectKind::Roughness));
        let run = found(&simulate(&rough, trace_seed(12, DefectKind::Roughness, 0)).expect("valid"));
        let b = run.get("B").expect("named");
        assert!((b.value - 2.1e-3).abs() < 4.0 * b.sd + 2e-5 && b.sd < 1e-4, "{b:?}");
        let kt = run.get("Kt").expect("named");
        assert!((kt.value - 0.05).abs() < 1e-3, "{kt:?}");
    }

    #[test]
    fn a_motor_without_load_has_no_scale() {
        let mut trace = simulate(&Scenario::STANDARD, 5).expect("valid");
        trace.load_torque_nm.fill(0.0);
        let message = estimate(&record(&trace), &MotorSettings::default()).expect_err("no load").to_string();
        assert!(message.contains("do not determine Kt"), "{message}");
    }

    /// With a known Kt, a measured, constant or absent load gives the same constants.
    #[test]
    fn a_known_torque_constant_does_without_a_load_sensor() {
        let settings = MotorSettings { torque_constant_nm_a: Some(0.05), ..MotorSettings::default() };
        let loaded = simulate(&Scenario::STANDARD, 5).expect("valid");
        let measured = estimate(&record(&loaded), &settings).expect("rich signals");
        // A constant load of 0.4 N·m is held by 8 A.
        let free = Scenario { load_amplitude_nm: 0.0, load_fluctuation_nm: 0.0, ..Scenario::STANDARD };
        let mut constant = simulate(&free, 5).expect("valid");
        constant.current_a.iter_mut().for_each(|current| *current += 8.0);
        let expected = found(&loaded);
        let without = |load| estimate(&MotorRecord { load, ..record(&constant) }, &settings).expect("rich signals");
        let of_constant = without(Load::Constant);
        for name in ["J", "B", "Tc"] {
            for found in [&measured, &of_constant] {
                let (found, expected) = (found.get(name).expect("named"), expected.get(name).expect("named"));
                let sd = found.sd.hypot(expected.sd);
                assert!((found.value - expected.value).abs() < 4.0 * sd, "{found:?} {expected:?}");
            }
        }
        let load = of_constant.get("T0").expect("named");
        assert!((load.value - 0.4).abs() < 4.0 * load.sd + 4e-3, "{load:?}");
        assert!(without(Load::Absent).relative_error_percent > 3.0 * of_constant.relative_error_percent);
        let unknown = estimate(&MotorRecord { load: Load::Absent, ..record(&constant) }, &MotorSettings::default());
        assert!(unknown.expect_err("no scale").to_string().contains("--kt"));
    }
}
