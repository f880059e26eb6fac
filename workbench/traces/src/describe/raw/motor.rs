//! Pole pairs, electrical offset and directions, from currents under field-oriented control.
//!
//! ```text
//! i = j i_q exp(j (p θ + φ)),   S_k = Σ i² exp(−2jkθ) / Σ |i|²                               (1)
//! p = argmax |S_k|,   φ = ½ arg(−S_p)                                                        (2)
//! ```
//!
//! As `WiringCheck` of the core, which checks a given number; (2) leaves half a turn open, which the sign decides by
//! which the quadrature current goes with acceleration and velocity.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};

use model::audit::pairs::correlation;

use super::phases::mean;
use super::position::turned;

/// Largest number of pole pairs that is tried.
const MOST: i32 = 32;
/// Least |S| of a current that turns with the rotor, and by how much it must exceed that of any other number.
const COHERENT: f64 = 0.6;
const BETTER: f64 = 0.05;
/// Of good signals it is nearly one.
const SURE: f64 = 0.95;
/// Time of a block, s, and the correlation of changes from which on it decides the sign.
const BLOCK_S: f64 = 0.005;
const SAYS: f64 = 0.2;
/// Samples that are taken at most.
const SAMPLES: usize = 200_000;

/// What the motor is.
#[derive(Debug)]
pub(super) struct Motor {
    pole_pairs: i32,
    offset_rad: f64,
    coherence: f64,
    /// Whether the position counts against the order of the phases.
    pub(super) reversed: bool,
    /// Correlation of the quadrature current with what it accelerates and moves.
    correlation: f64,
}

impl Motor {
    /// Of two or three phases, the angle of the shaft, and rows a second.
    ///
    /// # Errors
    /// Currents that do not turn with the position, or several numbers of pole pairs that fit.
    pub(super) fn of(amperes: &[Vec<f64>], angles_rad: &[f64], rate_hz: f64) -> Result<Self, String> {
        let rows = angles_rad.len().min(amperes[0].len());
        let every = rows.div_ceil(SAMPLES).max(1);
        let samples: Vec<([f64; 2], f64)> = (0..rows)
            .step_by(every)
            .map(|row| (vector(amperes, row), angles_rad[row]))
            .filter(|([x, y], angle)| (x + y + angle).is_finite())
            .collect();
        let power: f64 = samples.iter().map(|([x, y], _)| x * x + y * y).sum();
        let sum = |k: i32| {
            let (mut re, mut im) = (0.0, 0.0);
            for ([x, y], angle) in &samples {
                let (sin, cos) = (2.0 * f64::from(k) * angle).sin_cos();
                let (square_re, square_im) = (x * x - y * y, 2.0 * x * y);
                re += square_re * cos + square_im * sin;
                im += square_im * cos - square_re * sin;
            }
            [re / power, im / power]
        };
        let mut fits: Vec<(f64, i32, [f64; 2])> = (1..=MOST)
            .flat_map(|k| [k, -k])
            .map(|k| {
                let [re, im] = sum(k);
                (re.hypot(im), k, [re, im])
            })
            .collect();
        fits.sort_by(|one, other| other.0.total_cmp(&one.0));
        let [(coherence, k, [re, im]), (next, other, _), ..] = fits[..] else {
            return Err("no pole pairs were tried".into());
        };
        if coherence.is_nan() || coherence < COHERENT {
            return Err(format!(
                "the currents do not turn with the position (coherence {coherence:.2} at {} pole pairs): too little \
                 current or motion, other columns than those of the phases, or no field-oriented control",
                k.abs()
            ));
        }
        if coherence - next < BETTER {
            return Err(format!(
                "{} and {} pole pairs fit the recording: record some turns in both directions",
                k.abs(),
                other.abs()
            ));
        }
        let mut motor = Self {
            pole_pairs: k.abs(),
            offset_rad: 0.5 * (-im).atan2(-re),
            coherence,
            reversed: k < 0,
            correlation: 0.0,
        };
        motor.correlation = motor.correlation(amperes, angles_rad, rate_hz);
        if motor.correlation < 0.0 {
            (motor.offset_rad, motor.correlation) = (motor.offset_rad + PI, -motor.correlation);
        }
        motor.offset_rad = turned(0.0, motor.offset_rad);
        Ok(motor)
    }

    /// Of the changes of quadrature current and acceleration from block to block, in which a load that follows the
    /// position or rests is small; where these say little, of current and velocity, by friction.
    fn correlation(&self, amperes: &[Vec<f64>], angles_rad: &[f64], rate_hz: f64) -> f64 {
        let block = ((BLOCK_S * rate_hz) as usize).max(2);
        let sign = if self.reversed { -1.0 } else { 1.0 };
        let (mut currents, mut velocities) = (Vec::new(), Vec::new());
        for start in (0..angles_rad.len().saturating_sub(block)).step_by(block) {
            let rows = start..start + block;
            let quadrature = |row: usize| {
                let [x, y] = vector(amperes, row);
                let (sin, cos) = (f64::from(self.pole_pairs) * sign * angles_rad[row] + self.offset_rad).sin_cos();
                y * cos - x * sin
            };
            currents.push(rows.clone().map(quadrature).sum::<f64>() / block as f64);
            velocities.push(rows.map(|row| sign * turned(angles_rad[row], angles_rad[row + 1])).sum::<f64>());
        }
        // The acceleration at a block, from those beside it.
        let accelerations: Vec<f64> = velocities.windows(3).map(|own| own[2] - own[0]).collect();
        let changes = |values: &[f64]| values.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>();
        let between = currents.get(1..currents.len().saturating_sub(1)).unwrap_or_default();
        let by_acceleration = correlation(&changes(between), &changes(&accelerations));
        if by_acceleration.abs() > SAYS { by_acceleration } else { correlation(&currents, &velocities) }
    }

    /// Errors of the offsets of the phases: the part of the direct current, which is constant by (1), that turns
    /// against the rotor.
    ///
    /// ```text
    /// Re(i exp(−j(p θ + φ))) = c + Re(o exp(−j(p θ + φ)))                                    (3)
    /// ```
    pub(super) fn offsets(&self, amperes: &[Vec<f64>], angles_rad: &[f64]) -> Vec<f64> {
        let sign = if self.reversed { -1.0 } else { 1.0 };
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (row, angle) in angles_rad.iter().enumerate().take(amperes[0].len()) {
            let [x, y] = vector(amperes, row);
            let (sin, cos) = (f64::from(self.pole_pairs) * sign * angle + self.offset_rad).sin_cos();
            let (direct, regressors) = (x * cos + y * sin, Vector3::new(1.0, cos, sin));
            if direct.is_finite() {
                normal += regressors * regressors.transpose();
                right += regressors * direct;
            }
        }
        let Some(solved) = normal.cholesky().map(|factor| factor.solve(&right)) else {
            return vec![0.0; amperes.len()];
        };
        let (alpha, beta) = (solved[1], solved[2]);
        let phase = |k: f64| alpha * (k * TAU / 3.0).cos() + beta * (k * TAU / 3.0).sin();
        // Of three, what is common to all is in their sum.
        let common = if let [a, b, c] = amperes { (mean(a) + mean(b) + mean(c)) / 3.0 } else { 0.0 };
        (0..amperes.len()).map(|k| common + phase(k as f64)).collect()
    }

    /// The electrical angles at these angles of the shaft.
    pub(super) fn electrical(&self, angles_rad: &[f64]) -> Vec<f64> {
        let sign = if self.reversed { -1.0 } else { 1.0 };
        angles_rad.iter().map(|angle| f64::from(self.pole_pairs) * sign * angle + self.offset_rad).collect()
    }

    /// The section of the file.
    pub(super) fn lines(&self, first: usize) -> Vec<String> {
        // The file has it from phase a on.
        let offset_rad = self.offset_rad + first as f64 * TAU / 3.0;
        vec![
            format!("pole_pairs = {}  # coherence {:.2}", self.pole_pairs, self.coherence),
            format!("electrical_offset_rad = {:.4}", turned(0.0, offset_rad)),
            "park = \"standard\"".into(),
        ]
    }

    /// What is doubtful.
    pub(super) fn said(&self) -> Vec<String> {
        let mut said = Vec::new();
        if self.coherence < SURE {
            said.push(format!(
                "the currents turn with the position by a coherence of {:.2} only: check the pole pairs and the position",
                self.coherence
            ));
        }
        if self.correlation < SAYS {
            said.push(format!(
                "the current goes with velocity and acceleration by a correlation of {:.2} only: its sign, half a turn of \
                 electrical_offset_rad, is a guess",
                self.correlation
            ));
        }
        said
    }
}

/// The current of two or three phases in the stator frame.
fn vector(amperes: &[Vec<f64>], row: usize) -> [f64; 2] {
    let (a, b) = (amperes[0][row], amperes[1][row]);
    match amperes.get(2) {
        Some(c) => [(2.0 * a - b - c[row]) / 3.0, (b - c[row]) / 3.0_f64.sqrt()],
        None => [a, (a + 2.0 * b) / 3.0_f64.sqrt()],
    }
}
