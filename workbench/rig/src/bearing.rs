//! Defects: characteristic orders, the torque of a bearing defect, a weak magnet.
//!
//! Orders are events per shaft turn, with `r = (BD/PD) cos δ` and n balls (thesis Eq. 1.1, 2.52):
//!
//! ```text
//! outer race  O  = (n/2)(1 − r)        (1)
//! inner race  Oi = (n/2)(1 + r)        (2)
//! cage        Oc = ½(1 − r)            (3)
//! ball        Ob = (PD/2BD)(1 − r²)    (4)
//! ```
//!
//! A defect is a torque that opposes rotation, a function of shaft angle θ, velocity ω and current i.
//! `tanh(ω/ω₀)`, ω₀ = 1 rad/s, approximates the sign of ω without its step.
//!
//! ```text
//! spall      Td tanh(ω/ω₀) p(x)
//!            − ε Kt i [cos((O+1)θ) + cos((O−1)θ) + ½cos((2O+1)θ) + ½cos((2O−1)θ)]   (5)
//!            p(x) = ½(1 − cos(2πx/d)) for x < d, else 0;   x = frac(Oθ/2π)
//! roughness  ΔB ω                                                                   (6)
//! coulomb    Tc tanh(ω/ω₀),   Tc = Td d/2, the mean of the spall's pulses           (7)
//! both       (5) + (6), each of the given severity
//! ```
//!
//! A weak magnet changes the motor and not the bearing; for severity s:
//!
//! ```text
//! Kt ← Kt (1 − 0.05 s),   Ke ← Ke (1 − 0.05 s)                                      (8)
//! ```
//!
//! The second line of the spall is a ripple of the torque constant (`Kt (1 + ε[…]) i` drives the shaft): the rotor is
//! displaced when a ball passes the spall, and this modulates the air gap. Coulomb roughness is not a bearing defect of
//! the thesis but the control for isolation: an estimator that classifies it as a spall has detected mean drag and not
//! a spall. Severity scales Td and ε (spall), ΔB (roughness) and Tc (coulomb). A detector trained on single bearing
//! defects has no training data on both defects at once or on the weak magnet, and must not classify them as healthy.

use core::f64::consts::TAU;

use super::{MotorParameters, PlantState, RigError, finite, not_negative, positive};

/// Width ω₀ of the smoothed sign of ω.
const REVERSAL_RAD_S: f64 = 1.0;
/// Td at severity 1.
pub const PULSE_NM: f64 = 0.06;
/// d, the fraction of a defect period in which the ball is on the spall.
pub const PULSE_DUTY: f64 = 0.15;
/// ε at severity 1.
pub const TORQUE_RIPPLE: f64 = 0.03;
/// ΔB at severity 1. Smaller values hardly change the a-parameters of the models in the thesis.
pub const ADDED_FRICTION_NM_S_PER_RAD: f64 = 2e-3;
/// Fraction of Kt and Ke that a magnet has lost at severity 1.
pub(super) const MAGNET_LOSS: f64 = 0.05;

/// Dimensions of a ball bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingGeometry {
    /// Number of balls n.
    pub balls: u16,
    /// Ball diameter BD.
    pub ball_diameter_mm: f64,
    /// Pitch (not outer) diameter PD.
    pub pitch_diameter_mm: f64,
    /// Contact angle δ.
    pub contact_angle_rad: f64,
}

/// Characteristic orders, events per shaft turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingOrders {
    /// Ball passes over a point of the outer race (1).
    pub outer: f64,
    /// Ball passes over a point of the inner race (2).
    pub inner: f64,
    /// Turns of the cage (3).
    pub cage: f64,
    /// Spins of a ball (4).
    pub ball: f64,
}

impl BearingGeometry {
    /// The bearing of the thesis: 9 balls of 3 mm on a 17 mm pitch circle, contact angle 10°.
    pub const THESIS: Self =
        Self { balls: 9, ball_diameter_mm: 3.0, pitch_diameter_mm: 17.0, contact_angle_rad: 0.1745 };

    /// Returns an error for dimensions that no bearing can have.
    pub fn validate(&self) -> Result<(), RigError> {
        positive("bearing.balls", f64::from(self.balls))?;
        positive("bearing.ball_diameter_mm", self.ball_diameter_mm)?;
        positive("bearing.pitch_diameter_mm", self.pitch_diameter_mm)?;
        finite("bearing.contact_angle_rad", self.contact_angle_rad)?;
        Ok(())
    }

    /// The characteristic orders, equations (1)–(4).
    #[must_use]
    pub fn orders(&self) -> BearingOrders {
        let n = f64::from(self.balls);
        let r = self.ball_diameter_mm / self.pitch_diameter_mm * libm::cos(self.contact_angle_rad);
        BearingOrders {
            outer: 0.5 * n * (1.0 - r),                                                 // (1)
            inner: 0.5 * n * (1.0 + r),                                                 // (2)
            cage: 0.5 * (1.0 - r),                                                      // (3)
            ball: 0.5 * self.pitch_diameter_mm / self.ball_diameter_mm * (1.0 - r * r), // (4)
        }
    }
}

/// Kind of defect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DefectKind {
    /// No defect.
    Healthy,
    /// Defect A: single-point spall of the outer race.
    Spall,
    /// Defect B: generalised roughness, which acts as viscous friction.
    Roughness,
    /// Control for isolation: Coulomb friction with the same mean torque as the spall.
    Coulomb,
    /// Defects A and B at once.
    SpallAndRoughness,
    /// A magnet that has lost a part of its flux (8); the bearing has no defect.
    WeakMagnet,
}

impl DefectKind {
    /// All kinds, in the order of the class tables.
    pub const ALL: [Self; 6] =
        [Self::Healthy, Self::Spall, Self::Roughness, Self::Coulomb, Self::SpallAndRoughness, Self::WeakMagnet];

    /// Class name used on the command line, in labels and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Healthy => "healthy",
            Self::Spall => "spall",
            Self::Roughness => "roughness",
            Self::Coulomb => "coulomb",
            Self::SpallAndRoughness => "spall-and-roughness",
            Self::WeakMagnet => "weak-magnet",
        }
    }

    /// Short description.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::Healthy => "nothing is wrong",
            Self::Spall => "single-point defect of the outer race",
            Self::Roughness => "raised viscous friction: lost lubrication",
            Self::Coulomb => "Coulomb friction of a spall's mean torque: the control for isolation",
            Self::SpallAndRoughness => "both bearing defects at once",
            Self::WeakMagnet => "torque and back-EMF constant 5 % low, bearing sound",
        }
    }

    /// Unique number below 8 that must not change when kinds are added, because seeds depend on it.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Healthy => 0,
            Self::Spall => 1,
            Self::Roughness => 2,
            Self::Coulomb => 3,
            Self::SpallAndRoughness => 4,
            Self::WeakMagnet => 5,
        }
    }
}

/// A defect and its size; severity 1 is full size, 0 is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defect {
    /// Kind of defect.
    pub kind: DefectKind,
    /// Size relative to full size.
    pub severity: f64,
}

impl Defect {
    /// A bearing without defect.
    pub const HEALTHY: Self = Self::full(DefectKind::Healthy);

    /// A defect of this kind at full size.
    #[must_use]
    pub const fn full(kind: DefectKind) -> Self {
        Self { kind, severity: 1.0 }
    }

    /// The torque of the defect on a motor with torque constant `kt_nm_per_a` and this bearing.
    pub fn torque(&self, kt_nm_per_a: f64, geometry: &BearingGeometry) -> Result<DefectTorque, RigError> {
        let severity = not_negative("defect.severity", self.severity)?;
        let pulse_nm = PULSE_NM * severity;
        let ripple_nm_per_a = TORQUE_RIPPLE * severity * kt_nm_per_a;
        let outer_order = geometry.orders().outer;
        let friction_nm_s_per_rad = ADDED_FRICTION_NM_S_PER_RAD * severity;
        Ok(match self.kind {
            DefectKind::Healthy | DefectKind::WeakMagnet => DefectTorque::None,
            DefectKind::Spall => DefectTorque::Spall { pulse_nm, ripple_nm_per_a, outer_order },
            DefectKind::Roughness => DefectTorque::Viscous { friction_nm_s_per_rad },
            DefectKind::Coulomb => DefectTorque::Coulomb { torque_nm: 0.5 * PULSE_DUTY * PULSE_NM * severity },
            DefectKind::SpallAndRoughness => {
                DefectTorque::SpallAndViscous { pulse_nm, ripple_nm_per_a, outer_order, friction_nm_s_per_rad }
            }
        })
    }

    /// The motor with this defect (8); bearing defects do not change the motor.
    #[must_use]
    pub fn motor(&self, sound: &MotorParameters) -> MotorParameters {
        match self.kind {
            DefectKind::WeakMagnet => {
                let flux = 1.0 - MAGNET_LOSS * self.severity;
                MotorParameters {
                    kt_nm_per_a: flux * sound.kt_nm_per_a,
                    ke_v_s_per_rad: flux * sound.ke_v_s_per_rad,
                    ..*sound
                }
            }
            _ => *sound,
        }
    }
}

/// The torque of one defect, with all constants computed in advance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DefectTorque {
    /// No torque.
    None,
    /// Equation (5).
    Spall {
        /// Td.
        pulse_nm: f64,
        /// ε Kt.
        ripple_nm_per_a: f64,
        /// O.
        outer_order: f64,
    },
    /// Equation (6).
    Viscous {
        /// ΔB.
        friction_nm_s_per_rad: f64,
    },
    /// Equation (7).
    Coulomb {
        /// Tc.
        torque_nm: f64,
    },
    /// Equations (5) and (6) at once.
    SpallAndViscous {
        /// Td.
        pulse_nm: f64,
        /// ε Kt.
        ripple_nm_per_a: f64,
        /// O.
        outer_order: f64,
        /// ΔB.
        friction_nm_s_per_rad: f64,
    },
}

impl DefectTorque {
    /// The torque in N·m that opposes positive rotation in this state.
    #[must_use]
    pub fn at(&self, state: &PlantState) -> f64 {
        let omega = state.velocity_rad_s;
        match *self {
            Self::None => 0.0,
            Self::Spall { pulse_nm, ripple_nm_per_a, outer_order } => {
                spall(state, pulse_nm, ripple_nm_per_a, outer_order)
            }
            Self::Viscous { friction_nm_s_per_rad } => friction_nm_s_per_rad * omega, // (6)
            Self::Coulomb { torque_nm } => torque_nm * direction(omega),              // (7)
            Self::SpallAndViscous { pulse_nm, ripple_nm_per_a, outer_order, friction_nm_s_per_rad } => {
                spall(state, pulse_nm, ripple_nm_per_a, outer_order) + friction_nm_s_per_rad * omega
            }
        }
    }
}

/// Equation (5).
fn spall(state: &PlantState, pulse_nm: f64, ripple_nm_per_a: f64, outer_order: f64) -> f64 {
    let drag = pulse_nm * direction(state.velocity_rad_s) * pulse(outer_order * state.angle_rad / TAU, PULSE_DUTY);
    drag - ripple_nm_per_a * state.current_a * ripple(outer_order, state.angle_rad)
}

/// The smoothed sign of ω.
pub(super) fn direction(omega: f64) -> f64 {
    libm::tanh(omega / REVERSAL_RAD_S)
}

/// p of (5) at a phase in defect periods, for pulses that last the fraction `duty` of a period.
pub(super) fn pulse(periods: f64, duty: f64) -> f64 {
    let x = periods - periods.floor();
    if x < duty { 0.5 * (1.0 - libm::cos(TAU * x / duty)) } else { 0.0 }
}

/// The bracket of (5): the defect order and its double, each shifted up and down by one shaft order.
fn ripple(order: f64, theta: f64) -> f64 {
    let pair = |m: f64| libm::cos((m + 1.0) * theta) + libm::cos((m - 1.0) * theta);
    pair(order) + 0.5 * pair(2.0 * order)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn torque(kind: DefectKind, severity: f64, state: PlantState) -> f64 {
        let law = Defect { kind, severity }.torque(0.05, &BearingGeometry::THESIS).expect("valid");
        law.at(&state)
    }

    #[test]
    fn at_angle_zero_a_spall_is_only_ripple() {
        // p(0) = 0 and all four cosines are 1: −0.03 · 0.05 · 2 A · (1 + 1 + ½ + ½).
        let state = PlantState { current_a: 2.0, velocity_rad_s: 30.0, angle_rad: 0.0 };
        // Rounding errors of a few operations on a value near 1e-2.
        assert!((torque(DefectKind::Spall, 1.0, state) + 0.009).abs() < 1e-15);
    }

    #[test]
    fn coulomb_has_the_mean_torque_of_the_pulses() {
        let order = BearingGeometry::THESIS.orders().outer;
        let points = 100_000;
        let at = |angle_rad: f64| PlantState { current_a: 0.0, velocity_rad_s: 50.0, angle_rad };
        let mean = (0..points)
            .map(|k| f64::from(k) / f64::from(points) * TAU / order)
            .map(|angle| torque(DefectKind::Spall, 0.7, at(angle)))
            .sum::<f64>()
            / f64::from(points);
        // The rectangle rule over the full period of a function with a continuous slope has an error of O(1/n²).
        assert!((mean / torque(DefectKind::Coulomb, 0.7, at(0.0)) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn severity_scales_and_reversal_flips_the_drag() {
        let at = |velocity_rad_s: f64| PlantState { velocity_rad_s, angle_rad: 0.05, current_a: 0.0 };
        for kind in DefectKind::ALL {
            let full = torque(kind, 1.0, at(20.0));
            // Rounding errors only: each torque is linear in severity and odd in ω at i = 0.
            assert!((torque(kind, 0.25, at(20.0)) - 0.25 * full).abs() < 1e-15);
            assert!((torque(kind, 1.0, at(-20.0)) + full).abs() < 1e-15);
            let sound_bearing = matches!(kind, DefectKind::Healthy | DefectKind::WeakMagnet);
            assert_eq!(full > 1e-3, !sound_bearing, "{kind:?}");
        }
        let negative = Defect { kind: DefectKind::Spall, severity: -0.5 };
        assert!(negative.torque(0.05, &BearingGeometry::THESIS).is_err());
    }

    #[test]
    fn both_defects_are_the_sum_of_their_torques() {
        for severity in [1.0, 0.3] {
            for k in 0..1000 {
                let x = f64::from(k);
                let state = PlantState { current_a: 0.01 * x, velocity_rad_s: 40.0 - 0.08 * x, angle_rad: 0.037 * x };
                let sum = torque(DefectKind::Spall, severity, state) + torque(DefectKind::Roughness, severity, state);
                assert_eq!(torque(DefectKind::SpallAndRoughness, severity, state), sum);
            }
        }
    }

    #[test]
    fn a_weak_magnet_is_the_motor_and_no_other_defect_is() {
        let sound = crate::TABLE_2_3;
        for kind in DefectKind::ALL {
            let motor = Defect { kind, severity: 0.5 }.motor(&sound);
            assert_eq!(motor == sound, kind != DefectKind::WeakMagnet);
        }
        let weak = Defect { kind: DefectKind::WeakMagnet, severity: 0.5 }.motor(&sound);
        // 0.975 × 0.05, up to rounding.
        assert!((weak.kt_nm_per_a - 0.04875).abs() < 1e-17 && (weak.ke_v_s_per_rad - 0.04875).abs() < 1e-17);
        assert_eq!(MotorParameters { kt_nm_per_a: 0.05, ke_v_s_per_rad: 0.05, ..weak }, sound);
    }

    #[test]
    fn numbers_and_names_are_distinct() {
        for (k, kind) in DefectKind::ALL.into_iter().enumerate() {
            assert!(kind.number() < 8);
            for other in &DefectKind::ALL[..k] {
                assert!(kind.number() != other.number() && kind.name() != other.name());
            }
        }
    }
}
