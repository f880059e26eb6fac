//! Constants of the actuator: synchronous motor, ball screw, friction.
//!
//! ```text
//! Kt  = (3/2) p λ                 torque per ampere of q current (peak)      (1)
//! N   = lead/2π                   travel per radian of the shaft             (2)
//! J_t = J + m N²                  inertia of all on the shaft                (3)
//! μ   = 1/η − 1                   friction of the screw in proportion to its force  (4)
//! ```
//!
//! p: pole pairs, λ: flux linkage of one phase, m: mass of nut, rod and load, η: efficiency of the driving screw.

use super::super::{RigError, not_negative, positive, within};
use core::f64::consts::TAU;

/// Constants of the actuator without defect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Actuator {
    /// Pole pairs p.
    pub pole_pairs: u32,
    /// Resistance R of one phase.
    pub r_ohm: f64,
    /// Synchronous inductance Ls, the same in both axes.
    pub l_h: f64,
    /// Flux linkage λ of one phase (peak).
    pub flux_wb: f64,
    /// Inertia J of rotor and screw.
    pub rotor_kg_m2: f64,
    /// Mass m that the nut moves.
    pub mass_kg: f64,
    /// Viscous friction B of the shaft.
    pub viscous_nm_s_per_rad: f64,
    /// Coulomb friction Tc of the shaft.
    pub coulomb_nm: f64,
    /// Travel of the nut per turn.
    pub lead_m: f64,
    /// Efficiency η of the screw if the motor drives the load.
    pub efficiency: f64,
}

impl Actuator {
    /// The 12-pole actuator of thesis Table 5.1: 3700 lbf at 15.6 A rms, 4572 rpm. The table has no other constants;
    /// λ follows from the rated force and current through (1), (2) and η.
    pub const MAXFORCE: Self = Self {
        pole_pairs: 6,
        r_ohm: 0.6,
        l_h: 3e-3,
        flux_wb: 0.0559,
        rotor_kg_m2: 1.5e-3,
        mass_kg: 40.0,
        viscous_nm_s_per_rad: 2e-3,
        coulomb_nm: 0.25,
        lead_m: 3.81e-3,
        efficiency: 0.9,
    };

    /// Torque constant (1).
    #[must_use]
    pub fn kt_nm_per_a(&self) -> f64 {
        1.5 * f64::from(self.pole_pairs) * self.flux_wb // (1)
    }

    /// Travel per radian of the shaft (2).
    pub(crate) const fn metres_per_rad(&self) -> f64 {
        self.lead_m / TAU // (2)
    }

    /// Inertia of rotor, screw and mass on the shaft (3).
    #[must_use]
    pub const fn inertia_kg_m2(&self) -> f64 {
        let n = self.metres_per_rad();
        self.rotor_kg_m2 + self.mass_kg * n * n // (3)
    }

    /// Coefficient of the screw's friction (4).
    pub(crate) const fn screw_friction(&self) -> f64 {
        1.0 / self.efficiency - 1.0 // (4)
    }

    /// The actuator at a temperature, 0 for cold and 1 for hot: R + 40 %, λ − 5 %.
    pub(crate) const fn at_temperature(self, state: f64) -> Self {
        Self { r_ohm: self.r_ohm * (1.0 + 0.4 * state), flux_wb: self.flux_wb * (1.0 - 0.05 * state), ..self }
    }

    /// Returns an error with the name of a constant that no actuator can have. An efficiency of at most 1/2 is refused:
    /// the screw would be self-locking (μ ≥ 1).
    pub fn validate(&self) -> Result<(), RigError> {
        positive("actuator.pole_pairs", f64::from(self.pole_pairs))?;
        positive("actuator.r_ohm", self.r_ohm)?;
        positive("actuator.l_h", self.l_h)?;
        positive("actuator.flux_wb", self.flux_wb)?;
        positive("actuator.rotor_kg_m2", self.rotor_kg_m2)?;
        not_negative("actuator.mass_kg", self.mass_kg)?;
        not_negative("actuator.viscous_nm_s_per_rad", self.viscous_nm_s_per_rad)?;
        not_negative("actuator.coulomb_nm", self.coulomb_nm)?;
        positive("actuator.lead_m", self.lead_m)?;
        within("actuator.efficiency", self.efficiency, [0.501, 1.0])?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_follow_from_the_rated_force_and_current() {
        let actuator = Actuator::MAXFORCE;
        let newtons = 3700.0 * 4.448_221_615;
        // 16 458 N on a lead of 3.81 mm at an efficiency of 0.9 and 15.6 A rms: 0.5027 N·m/A; λ is rounded to three
        // digits, 0.1 %.
        let torque = newtons * 3.81e-3 / TAU / 0.9;
        let kt = torque / (15.6 * 2.0_f64.sqrt());
        assert!((actuator.kt_nm_per_a() / kt - 1.0).abs() < 1.5e-3, "{kt}");
        // 1.5e-3 + 40 · (0.60638e-3)², all digits by hand.
        assert!((actuator.inertia_kg_m2() - 1.514_708e-3).abs() < 1e-9);
    }

    #[test]
    fn heat_raises_the_resistance_and_weakens_the_magnet() {
        let hot = Actuator::MAXFORCE.at_temperature(1.0);
        // Rounding only.
        assert!((hot.r_ohm - 0.84).abs() < 1e-15 && (hot.flux_wb - 0.053_105).abs() < 1e-15);
        assert_eq!(Actuator { r_ohm: 0.6, flux_wb: 0.0559, ..hot }, Actuator::MAXFORCE);
        assert_eq!(Actuator::MAXFORCE.at_temperature(0.0), Actuator::MAXFORCE);
    }

    #[test]
    fn impossible_constants_are_refused_by_name() {
        let refused = |actuator: Actuator| actuator.validate().expect_err("impossible").to_string();
        let sound = Actuator::MAXFORCE;
        assert!(sound.validate().is_ok());
        assert!(refused(Actuator { efficiency: 0.5, ..sound }).contains("actuator.efficiency"));
        assert!(refused(Actuator { l_h: 0.0, ..sound }).contains("actuator.l_h"));
        assert!(refused(Actuator { mass_kg: -1.0, ..sound }).contains("actuator.mass_kg"));
        assert!(Actuator { mass_kg: 0.0, ..sound }.validate().is_ok());
    }
}
