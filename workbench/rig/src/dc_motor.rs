//! The permanent-magnet DC motor (thesis Eq. 2.24–2.25).
//!
//! Inputs: the terminal voltage, held constant over a step, and a torque on the shaft that may depend on the state.
//! Outputs: current, velocity and shaft angle after the step.
//!
//! ```text
//! L di/dt = v − R i − Ke ω                      (1)
//! J dω/dt = Kt i − B ω − T(θ, ω, i)             (2)
//! dθ/dt   = ω                                   (3)
//! ```
//!
//! `T` *opposes* positive rotation: external load, Coulomb friction and a bearing defect.
//!
//! With `x = [i ω θ]ᵀ`, `u = [v T]ᵀ` and inputs held over a step `h`, (1)–(3) have the exact solution (zero-order hold)
//!
//! ```text
//! x(t+h) = Φ x(t) + Γ u,     [Φ Γ; 0 I] = exp([A E; 0 0] h)     (4)
//! ```
//!
//! computed once per step size. A state-dependent torque is evaluated at the midpoint, which a half step of (4)
//! predicts: exact for the linear motor, second order in `h` for the torque.
//!
//! If `L/R` is much smaller than `h`, the current follows the voltage within the step and (1) becomes
//! `i = (v − Ke ω)/R`  (5), as for the motor of Table 2.3 (L/R = 0.9 µs); (2) and (3) are then integrated by the
//! midpoint rule.

use nalgebra::{SMatrix, SVector};

use super::{RigError, not_negative, positive};

/// One inch-pound-force in N·m.
const NM_PER_INCH_POUND: f64 = 0.112_985;

/// Largest `(L/R)/h` at which the current is treated as quasi-static: (5) neglects a transient, which is `exp(−h R/L)`
/// ≤ 2e-9 of a voltage step at the end of the integration step.
const QUASI_STATIC_RATIO: f64 = 0.05;

/// Constants of a permanent-magnet DC motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorParameters {
    /// Torque constant Kt.
    pub kt_nm_per_a: f64,
    /// Back-EMF constant Ke.
    pub ke_v_s_per_rad: f64,
    /// Armature resistance R.
    pub r_ohm: f64,
    /// Armature inductance L.
    pub l_h: f64,
    /// Inertia J.
    pub j_kg_m2: f64,
    /// Viscous friction B.
    pub b_nm_s_per_rad: f64,
}

/// Thesis Table 2.1, the motor of the model validation, converted from inch-pounds.
pub const TABLE_2_1: MotorParameters = MotorParameters {
    kt_nm_per_a: 1.141 * NM_PER_INCH_POUND,
    ke_v_s_per_rad: 0.129,
    r_ohm: 0.5,
    l_h: 4.5e-4,
    j_kg_m2: 2.43e-4 * NM_PER_INCH_POUND,
    b_nm_s_per_rad: 3.125e-4 * NM_PER_INCH_POUND,
};

/// Thesis Table 2.3, the motor of all fault simulations.
pub const TABLE_2_3: MotorParameters = MotorParameters {
    kt_nm_per_a: 0.05,
    ke_v_s_per_rad: 0.05,
    r_ohm: 0.5,
    l_h: 4.5e-7,
    j_kg_m2: 2.5e-4,
    b_nm_s_per_rad: 1e-4,
};

impl MotorParameters {
    /// Returns an error for constants that no motor can have. `L = 0` is allowed: it means quasi-static.
    pub fn validate(&self) -> Result<(), RigError> {
        positive("kt_nm_per_a", self.kt_nm_per_a)?;
        positive("ke_v_s_per_rad", self.ke_v_s_per_rad)?;
        positive("r_ohm", self.r_ohm)?;
        not_negative("l_h", self.l_h)?;
        positive("j_kg_m2", self.j_kg_m2)?;
        not_negative("b_nm_s_per_rad", self.b_nm_s_per_rad)?;
        Ok(())
    }

    /// The system matrix and input matrix of (1)–(3), augmented for (4).
    fn augmented(&self) -> SMatrix<f64, 5, 5> {
        let (l, j) = (self.l_h, self.j_kg_m2);
        let mut a = SMatrix::<f64, 5, 5>::zeros();
        a[(0, 0)] = -self.r_ohm / l;
        a[(0, 1)] = -self.ke_v_s_per_rad / l;
        a[(0, 3)] = 1.0 / l;
        a[(1, 0)] = self.kt_nm_per_a / j;
        a[(1, 1)] = -self.b_nm_s_per_rad / j;
        a[(1, 4)] = -1.0 / j;
        a[(2, 1)] = 1.0;
        a
    }
}

/// State of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlantState {
    /// Armature current i.
    pub current_a: f64,
    /// Shaft velocity ω.
    pub velocity_rad_s: f64,
    /// Shaft angle θ, not wrapped.
    pub angle_rad: f64,
}

impl PlantState {
    const fn is_finite(&self) -> bool {
        self.current_a.is_finite() && self.velocity_rad_s.is_finite() && self.angle_rad.is_finite()
    }
}

/// Model of the current.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Electrical {
    /// The current follows the voltage without delay, Eq. (5).
    QuasiStatic,
    /// The current is a state, Eq. (1).
    BothStates,
}

/// Equation (4) for one step size.
#[derive(Debug, Clone, Copy, PartialEq)]
struct HeldStep {
    phi: SMatrix<f64, 3, 3>,
    gamma: SMatrix<f64, 3, 2>,
}

impl HeldStep {
    fn new(motor: &MotorParameters, step_s: f64) -> Self {
        let exponential = (motor.augmented() * step_s).exp(); // (4)
        Self {
            phi: exponential.fixed_view::<3, 3>(0, 0).into_owned(),
            gamma: exponential.fixed_view::<3, 2>(0, 3).into_owned(),
        }
    }

    fn advance(&self, from: PlantState, voltage_v: f64, torque_nm: f64) -> PlantState {
        let x = SVector::<f64, 3>::new(from.current_a, from.velocity_rad_s, from.angle_rad);
        let next = self.phi * x + self.gamma * SVector::<f64, 2>::new(voltage_v, torque_nm);
        PlantState { current_a: next[0], velocity_rad_s: next[1], angle_rad: next[2] }
    }
}

/// Steps of a motor with the current as a state: the half step of the predictor and the full step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct HeldSteps {
    half: HeldStep,
    full: HeldStep,
}

impl HeldSteps {
    fn new(motor: &MotorParameters, step_s: f64) -> Self {
        Self { half: HeldStep::new(motor, 0.5 * step_s), full: HeldStep::new(motor, step_s) }
    }
}

/// Point of a step at which the torque is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// At the start of the step.
    Start,
    /// At the predicted middle of the step.
    Middle,
}

/// A motor simulated step by step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant {
    motor: MotorParameters,
    step_s: f64,
    /// `None` if the current is quasi-static.
    held: Option<HeldSteps>,
    state: PlantState,
}

impl Plant {
    /// A motor at rest; the current is quasi-static only if `L/R` is below a twentieth of the step.
    pub fn new(motor: &MotorParameters, step_s: f64) -> Result<Self, RigError> {
        let electrical = if motor.l_h <= QUASI_STATIC_RATIO * motor.r_ohm * step_s {
            Electrical::QuasiStatic
        } else {
            Electrical::BothStates
        };
        Self::with_electrical(motor, step_s, electrical)
    }

    /// A motor at rest with the given model of the current.
    pub fn with_electrical(motor: &MotorParameters, step_s: f64, electrical: Electrical) -> Result<Self, RigError> {
        motor.validate()?;
        positive("step_s", step_s)?;
        let held = match electrical {
            Electrical::QuasiStatic => None,
            Electrical::BothStates => {
                positive("l_h", motor.l_h)?;
                Some(HeldSteps::new(motor, step_s))
            }
        };
        Ok(Self { motor: *motor, step_s, held, state: PlantState::default() })
    }

    /// The model of the current.
    #[must_use]
    pub const fn electrical(&self) -> Electrical {
        match self.held {
            None => Electrical::QuasiStatic,
            Some(_) => Electrical::BothStates,
        }
    }

    /// The constants of the motor.
    #[must_use]
    pub const fn motor(&self) -> &MotorParameters {
        &self.motor
    }

    /// The integration step.
    #[must_use]
    pub const fn step_s(&self) -> f64 {
        self.step_s
    }

    /// The current state.
    #[must_use]
    pub const fn state(&self) -> PlantState {
        self.state
    }

    /// Sets the state, for example a start angle.
    pub const fn set_state(&mut self, state: PlantState) {
        self.state = state;
    }

    /// Whether every state is a finite number.
    #[must_use]
    pub const fn is_finite(&self) -> bool {
        self.state.is_finite()
    }

    /// Changes resistance and step size; the state does not change.
    pub(crate) fn retune(&mut self, r_ohm: f64, step_s: f64) {
        if r_ohm == self.motor.r_ohm && step_s == self.step_s {
            return;
        }
        (self.motor.r_ohm, self.step_s) = (r_ohm, step_s);
        if self.held.is_some() {
            self.held = Some(HeldSteps::new(&self.motor, step_s));
        }
    }

    /// Simulates one step with constant voltage `voltage_v`; `torque_nm` is the torque that opposes positive rotation.
    pub fn step(&mut self, voltage_v: f64, torque_nm: impl Fn(&PlantState) -> f64) -> &PlantState {
        self.step_staged(voltage_v, |_, at| torque_nm(at))
    }

    /// Same as [`Plant::step`] for a torque with states of its own. `torque_nm` is called once at the start and once at
    /// the middle, in this order, so that these states can be integrated by the same midpoint rule.
    pub(crate) fn step_staged(
        &mut self,
        voltage_v: f64,
        mut torque_nm: impl FnMut(Stage, &PlantState) -> f64,
    ) -> &PlantState {
        self.state = match &self.held {
            None => self.midpoint(voltage_v, torque_nm),
            Some(HeldSteps { half, full }) => {
                let middle = half.advance(self.state, voltage_v, torque_nm(Stage::Start, &self.state));
                full.advance(self.state, voltage_v, torque_nm(Stage::Middle, &middle))
            }
        };
        &self.state
    }

    fn midpoint(&self, voltage_v: f64, mut torque_nm: impl FnMut(Stage, &PlantState) -> f64) -> PlantState {
        let m = &self.motor;
        let state_at = |velocity_rad_s: f64, angle_rad: f64| PlantState {
            current_a: (voltage_v - m.ke_v_s_per_rad * velocity_rad_s) / m.r_ohm, // (5)
            velocity_rad_s,
            angle_rad,
        };
        let mut acceleration = |stage: Stage, at: &PlantState| {
            let friction = m.b_nm_s_per_rad * at.velocity_rad_s;
            (m.kt_nm_per_a * at.current_a - friction - torque_nm(stage, at)) / m.j_kg_m2 // (2)
        };
        let (h, omega, theta) = (self.step_s, self.state.velocity_rad_s, self.state.angle_rad);
        let start = state_at(omega, theta);
        let middle = state_at(omega + 0.5 * h * acceleration(Stage::Start, &start), theta + 0.5 * h * omega);
        state_at(omega + h * acceleration(Stage::Middle, &middle), theta + h * middle.velocity_rad_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_shaft_without_friction_gains_torque_times_time() {
        // The constants are so small that current and friction have no effect: ω = −T t/J, θ = −T t²/(2J).
        let motor = MotorParameters {
            kt_nm_per_a: 1e-12,
            ke_v_s_per_rad: 1e-12,
            r_ohm: 1.0,
            l_h: 1e-3,
            j_kg_m2: 2.0,
            b_nm_s_per_rad: 0.0,
        };
        for electrical in [Electrical::QuasiStatic, Electrical::BothStates] {
            let mut plant = Plant::with_electrical(&motor, 0.5, electrical).expect("valid");
            plant.step(0.0, |_| -4.0);
            let end = plant.step(0.0, |_| -4.0);
            // Rounding errors only: both rules are exact for a constant acceleration.
            assert!((end.velocity_rad_s - 2.0).abs() < 1e-12);
            assert!((end.angle_rad - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn current_is_a_state_unless_far_faster_than_the_step() {
        let mode = |motor: &MotorParameters, h| Plant::new(motor, h).expect("valid").electrical();
        assert_eq!(mode(&TABLE_2_3, 1e-4), Electrical::QuasiStatic);
        assert_eq!(mode(&TABLE_2_3, 1e-6), Electrical::BothStates);
        assert_eq!(mode(&TABLE_2_1, 1e-4), Electrical::BothStates);
    }

    #[test]
    fn a_retuned_motor_is_a_new_motor_in_the_same_state() {
        for motor in [TABLE_2_1, TABLE_2_3] {
            let warm = MotorParameters { r_ohm: 0.6, ..motor };
            let [mut plant, mut fresh] = [motor, warm].map(|m| Plant::new(&m, 1e-4).expect("valid"));
            let at = PlantState { current_a: 0.5, velocity_rad_s: 3.0, angle_rad: 1.0 };
            plant.set_state(at);
            fresh.set_state(at);
            plant.retune(0.6, 1e-4);
            for _ in 0..10 {
                assert_eq!(plant.step(1.0, |_| 0.01), fresh.step(1.0, |_| 0.01));
            }
        }
    }

    #[test]
    fn refuses_impossible_motors_by_name() {
        let bad = MotorParameters { j_kg_m2: 0.0, ..TABLE_2_3 };
        let error = Plant::new(&bad, 1e-4).expect_err("invalid");
        assert!(matches!(error, RigError::NotPositive { name: "j_kg_m2", .. }));
        let bad = MotorParameters { r_ohm: f64::NAN, ..TABLE_2_3 };
        assert!(Plant::new(&bad, 1e-4).is_err());
        assert!(Plant::new(&TABLE_2_3, 0.0).is_err());
    }
}
