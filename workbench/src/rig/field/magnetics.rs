//! Torques that depend on the angle of the shaft: cogging, ripple of the torque constant, unbalance.
//!
//! ```text
//! T = Σ c_n sin(nθ + γ_n) + Σ u_n sin(nθ + υ_n) − Kt i Σ k_n sin(nθ + κ_n)       (1)
//! ```
//!
//! with the orders n of [`ORDERS`]; T opposes positive rotation. The phases are uniform over a turn. Each cogging
//! amplitude c_n varies about its nominal value; the amplitudes of unbalance u_n and ripple k_n are fixed.
//!
//! Cost: the sines of all orders are powers of one `exp(jθ)`.

use core::f64::consts::TAU;

use crate::rig::{NoiseSource, PlantState, RigError, not_negative};

/// Orders of the torques, periods per turn of the shaft.
pub const ORDERS: [u32; 6] = [1, 2, 6, 12, 24, 36];

/// Ranges of the effect; one amplitude for each of [`ORDERS`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Magnetics {
    /// Nominal amplitudes of the cogging torque.
    pub cogging_nm: [f64; 6],
    /// Relative variation of each cogging amplitude.
    pub cogging_spread: f64,
    /// Amplitudes of the ripple, relative to Kt.
    pub torque_constant_ripple: [f64; 6],
    /// Amplitudes of the unbalance.
    pub unbalance_nm: [f64; 6],
}

/// Values of one record: (1) with sines and cosines of zero phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MagneticsValues {
    /// Amplitudes of cos nθ and sin nθ of the torque without current.
    pub torque_nm: [[f64; 2]; 6],
    /// Amplitudes of cos nθ and sin nθ of the ripple, relative to Kt.
    pub ripple: [[f64; 2]; 6],
}

impl Magnetics {
    /// The ranges of the field.
    pub const FIELD: Self = Self {
        cogging_nm: [0.0, 0.0, 0.003, 0.006, 0.004, 0.003],
        cogging_spread: 0.3,
        torque_constant_ripple: [0.004, 0.004, 0.01, 0.015, 0.01, 0.006],
        unbalance_nm: [0.006, 0.003, 0.0, 0.0, 0.0, 0.0],
    };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        for k in 0..ORDERS.len() {
            not_negative("field.magnetics.cogging_nm", self.cogging_nm[k])?;
            not_negative("field.magnetics.torque_constant_ripple", self.torque_constant_ripple[k])?;
            not_negative("field.magnetics.unbalance_nm", self.unbalance_nm[k])?;
        }
        super::fraction("field.magnetics.cogging_spread", self.cogging_spread)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> MagneticsValues {
        // a sin(nθ + φ) = a sin φ cos nθ + a cos φ sin nθ.
        let mut wave = |amplitude: f64, spread: f64| {
            let amplitude = amplitude * source.uniform(1.0 - spread, 1.0 + spread);
            let (sin, cos) = libm::sincos(source.uniform(0.0, TAU));
            [amplitude * sin, amplitude * cos]
        };
        let cogging = self.cogging_nm.map(|amplitude| wave(amplitude, self.cogging_spread));
        let ripple = self.torque_constant_ripple.map(|amplitude| wave(amplitude, 0.0));
        let unbalance = self.unbalance_nm.map(|amplitude| wave(amplitude, 0.0));
        let torque_nm = core::array::from_fn(|n| [0, 1].map(|part: usize| cogging[n][part] + unbalance[n][part]));
        MagneticsValues { torque_nm, ripple }
    }
}

impl MagneticsValues {
    /// The torque (1) that opposes positive rotation of a motor with torque constant `kt_nm_per_a`.
    #[must_use]
    pub fn torque_nm(&self, at: &PlantState, kt_nm_per_a: f64) -> f64 {
        let turn = powers(at.angle_rad);
        let sum = |waves: &[[f64; 2]; 6]| -> f64 {
            waves.iter().zip(turn).map(|([a, b], [cos, sin])| a * cos + b * sin).sum()
        };
        sum(&self.torque_nm) - kt_nm_per_a * at.current_a * sum(&self.ripple) // (1)
    }
}

/// Cosine and sine of nθ for each of [`ORDERS`].
fn powers(theta: f64) -> [[f64; 2]; 6] {
    let times = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c - b * d, a * d + b * c];
    let (sin, cos) = libm::sincos(theta);
    let first = [cos, sin];
    let second = times(first, first);
    let sixth = times(times(second, second), second);
    let twelfth = times(sixth, sixth);
    let twenty_fourth = times(twelfth, twelfth);
    [first, second, sixth, twelfth, twenty_fourth, times(twenty_fourth, twelfth)]
}
