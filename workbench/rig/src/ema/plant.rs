//! Motor, screw and load in the rotor frame.
//!
//! The d axis lies on the magnet and a positive q current drives forward (`Park::Standard` of the core):
//!
//! ```text
//! L di_d/dt = v_d − R i_d + p ω L i_q                                            (1)
//! L di_q/dt = v_q − R i_q − p ω (L i_d + λ)                                      (2)
//! J dω/dt   = Kt i_q − B ω − s(ω) [Tc + T_p(θ) + μ N |F_s|] − N F_s,   dθ/dt = ω (3)
//! s(ω)      = tanh(ω/ω₀), ω₀ = 1 rad/s
//! ```
//!
//! F_s is the force of the screw on the mass. The friction μ|F_s| makes the motor torque N F_s/η if the motor drives
//! the load, N F_s (2 − 1/η) if the load drives the motor, and N F_s at standstill. T_p are the pulses of the spalls.
//!
//! ```text
//! x = x₀ + N (θ − θ₀),   J includes m N²,   F_s = F                              (4)
//! F = F_ext(t) + k_e x                                                           (5)
//! ```
//!
//! On an axis of a machine, F_s includes the weight, and gear and brake oppose the motor ([`axis`](crate::axis)).
//! Behind a belt is a second inertia with its own angle and velocity ([`Mechanics`](crate::field::Mechanics)): screw,
//! gear and weight act on it, and motor, brake and bearing on the first one; x follows the second one.
//!
//! F opposes positive motion: an external force, linear within a step, and springs. With (4), the force that
//! accelerates the mass causes no friction of the screw; it is at most 1 % of the accelerating torque.
//!
//! Integration: Runge–Kutta of fourth order with a fixed step. (1)–(3) are bilinear in ω and i, so they have no exact
//! step like a motor without rotor frame. The fastest rates are pω = 2.9e3 1/s at 4572 rpm and 0.7e3 1/s of the
//! smoothed friction, at most 0.12 a step of 1/24 000 s: the error of a step is (0.12)⁵/5! = 2e-7, and no implicit rule
//! is necessary.

use super::super::axis::{Axis, AxisLoad, Travel};
use super::super::bearing::direction;
use super::super::field::{LoadSide, MechanicsValues};
use super::super::{BearingGeometry, NoiseSource, PlantState, RigError, positive};
use super::scenario::STROKE_M;
use super::{Actuator, EmaDefect, Pulses};

/// Voltage in the rotor frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DqVoltage {
    /// Direct axis.
    pub d_v: f64,
    /// Quadrature axis.
    pub q_v: f64,
}

/// State of the actuator.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EmaState {
    /// Direct current i_d (peak).
    pub direct_a: f64,
    /// Quadrature current i_q (peak).
    pub quadrature_a: f64,
    /// Shaft velocity ω.
    pub velocity_rad_s: f64,
    /// Shaft angle θ, not wrapped.
    pub angle_rad: f64,
    /// Position x of the mass.
    pub position_m: f64,
    /// Angle behind a belt; zero without one.
    pub load_rad: f64,
    /// Velocity behind a belt; zero without one.
    pub load_rad_s: f64,
}

impl EmaState {
    /// `self + h · slope`.
    fn plus(&self, h: f64, slope: &Self) -> Self {
        Self {
            direct_a: self.direct_a + h * slope.direct_a,
            quadrature_a: self.quadrature_a + h * slope.quadrature_a,
            velocity_rad_s: self.velocity_rad_s + h * slope.velocity_rad_s,
            angle_rad: self.angle_rad + h * slope.angle_rad,
            position_m: self.position_m + h * slope.position_m,
            load_rad: self.load_rad + h * slope.load_rad,
            load_rad_s: self.load_rad_s + h * slope.load_rad_s,
        }
    }

    /// Whether every state is a finite number.
    #[must_use]
    pub const fn is_finite(&self) -> bool {
        self.direct_a.is_finite()
            && self.quadrature_a.is_finite()
            && self.velocity_rad_s.is_finite()
            && self.angle_rad.is_finite()
            && self.position_m.is_finite()
            && self.load_rad_s.is_finite()
    }
}

/// An actuator simulated step by step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmaPlant {
    actuator: Actuator,
    pulses: Pulses,
    springs_n_per_m: f64,
    step_s: f64,
    kt_nm_per_a: f64,
    metres_per_rad: f64,
    inertia_kg_m2: f64,
    screw_friction: f64,
    /// Position of the nut at angle zero.
    origin_m: f64,
    axis: Option<AxisLoad>,
    belt: Option<LoadSide>,
    state: EmaState,
}

impl EmaPlant {
    /// A sound actuator with a defect, at rest at angle and position zero. `springs_n_per_m` is k_e of (5), zero for no
    /// springs.
    ///
    /// # Errors
    /// Returns an error with the name of a constant that cannot be simulated.
    pub fn new(
        sound: &Actuator,
        defect: &EmaDefect,
        bearing: &BearingGeometry,
        springs_n_per_m: f64,
        step_s: f64,
    ) -> Result<Self, RigError> {
        defect.validate()?;
        bearing.validate()?;
        positive("step_s", step_s)?;
        let actuator = defect.actuator(sound);
        actuator.validate()?;
        Ok(Self {
            actuator,
            pulses: defect.pulses(bearing),
            springs_n_per_m,
            step_s,
            kt_nm_per_a: actuator.kt_nm_per_a(),
            metres_per_rad: actuator.metres_per_rad(),
            inertia_kg_m2: actuator.inertia_kg_m2(),
            screw_friction: actuator.screw_friction(),
            origin_m: 0.0,
            axis: None,
            belt: None,
            state: EmaState::default(),
        })
    }

    /// Sets the actuator at rest at an angle and a position of the nut, with the current that holds `external_n`.
    pub fn hold(&mut self, angle_rad: f64, position_m: f64, external_n: f64) {
        self.origin_m = position_m - self.metres_per_rad * angle_rad;
        let force_n = external_n + self.springs_n_per_m * position_m;
        self.state = EmaState {
            quadrature_a: self.metres_per_rad * force_n / self.kt_nm_per_a,
            angle_rad,
            position_m,
            ..EmaState::default()
        };
    }

    /// Makes the nut move an axis with this payload, behind a belt if there is a transmission, and holds its weight at
    /// rest.
    pub(super) fn drive_axis(
        &mut self,
        axis: &Axis,
        values: Option<&MechanicsValues>,
        payload: f64,
        gear: NoiseSource,
    ) {
        let travel = Travel::linear(self.metres_per_rad, STROKE_M);
        let middle_rad = -self.origin_m / self.metres_per_rad;
        let mut load = AxisLoad::new(axis, travel, [middle_rad, self.inertia_kg_m2], gear);
        load.set_payload(payload);
        let held_nm = self.kt_nm_per_a * self.state.quadrature_a + load.weight_nm(self.state.angle_rad);
        self.state.quadrature_a = held_nm / self.kt_nm_per_a;
        self.belt = values.map(|values| {
            let mut belt = LoadSide::new(values, self.inertia_kg_m2, &PlantState::default());
            belt.hold(self.state.angle_rad, held_nm);
            self.state.load_rad = belt.angle_rad();
            belt
        });
        self.axis = Some(load);
    }

    /// The axis, if there is one.
    pub(super) const fn axis_mut(&mut self) -> Option<&mut AxisLoad> {
        self.axis.as_mut()
    }

    /// The angle of the screw.
    pub(super) const fn screw_rad(&self) -> f64 {
        if self.belt.is_some() { self.state.load_rad } else { self.state.angle_rad }
    }

    /// The actuator with its defect.
    #[must_use]
    pub const fn actuator(&self) -> &Actuator {
        &self.actuator
    }

    /// The current state.
    #[must_use]
    pub const fn state(&self) -> EmaState {
        self.state
    }

    /// Sets the state; the position of the mass must fit the angle.
    pub const fn set_state(&mut self, state: EmaState) {
        self.state = state;
    }

    /// The force (5) that opposes positive motion.
    #[must_use]
    pub fn load_n(&self, external_n: f64) -> f64 {
        let force_n = external_n + self.springs_n_per_m * self.state.position_m; // (5)
        self.axis.map_or(force_n, |axis| force_n + axis.weight_nm(self.screw_rad()) / self.metres_per_rad)
    }

    /// Simulates one step with the voltage held in the rotor frame; `external_n` is F_ext at its start and at its end.
    pub fn step(&mut self, voltage: DqVoltage, external_n: [f64; 2]) {
        let [from, to] = external_n;
        let (h, x) = (self.step_s, self.state);
        let middle = 0.5 * (from + to);
        let k1 = self.slope(&x, voltage, from);
        let k2 = self.slope(&x.plus(0.5 * h, &k1), voltage, middle);
        let k3 = self.slope(&x.plus(0.5 * h, &k2), voltage, middle);
        let k4 = self.slope(&x.plus(h, &k3), voltage, to);
        let sum = k1.plus(2.0, &k2).plus(2.0, &k3).plus(1.0, &k4);
        self.state = x.plus(h / 6.0, &sum);
        // Exact (4), without the rounding of a sum over millions of steps.
        self.state.position_m = self.origin_m + self.metres_per_rad * self.screw_rad();
        if let Some(axis) = &mut self.axis {
            axis.settle(self.state.angle_rad);
        }
    }

    /// Equations (1)–(5).
    fn slope(&self, x: &EmaState, voltage: DqVoltage, external_n: f64) -> EmaState {
        let a = &self.actuator;
        let n = self.metres_per_rad;
        let electrical = f64::from(a.pole_pairs) * x.velocity_rad_s;
        let screw_n = external_n + self.springs_n_per_m * x.position_m; // (4), (5)
        let [acceleration, load_rad_s, load_acceleration] = self.accelerations(x, screw_n);
        EmaState {
            direct_a: (voltage.d_v - a.r_ohm * x.direct_a) / a.l_h + electrical * x.quadrature_a, // (1)
            quadrature_a: (voltage.q_v - a.r_ohm * x.quadrature_a - electrical * a.flux_wb) / a.l_h
                - electrical * x.direct_a, // (2)
            velocity_rad_s: acceleration,
            angle_rad: x.velocity_rad_s,
            position_m: n * if self.belt.is_some() { load_rad_s } else { x.velocity_rad_s }, // (4)
            load_rad: load_rad_s,
            load_rad_s: load_acceleration,
        }
    }

    /// Acceleration of the motor (3), and velocity and acceleration behind the belt; `screw_n` is F_s without weight.
    fn accelerations(&self, x: &EmaState, screw_n: f64) -> [f64; 3] {
        let a = &self.actuator;
        let n = self.metres_per_rad;
        let driving = self.kt_nm_per_a * x.quadrature_a;
        let dry = a.coulomb_nm + self.pulses.at(x.angle_rad);
        let viscous = a.viscous_nm_s_per_rad * x.velocity_rad_s;
        let Some(axis) = &self.axis else {
            let friction = viscous + direction(x.velocity_rad_s) * (dry + self.screw_friction * n * screw_n.abs());
            return [(driving - friction - n * screw_n) / self.inertia_kg_m2, 0.0, 0.0]; // (3)
        };
        let brake = axis.brake_nm(x.angle_rad, x.velocity_rad_s);
        let motor = driving - viscous - direction(x.velocity_rad_s) * dry - brake;
        let opposing = |[angle_rad, velocity_rad_s]: [f64; 2]| {
            let load_nm = n * screw_n + axis.weight_nm(angle_rad);
            let load = axis.opposing([angle_rad, velocity_rad_s], load_nm);
            let screw = self.screw_friction * load_nm.abs();
            [load.torque_nm + direction(velocity_rad_s) * screw, load.added_kg_m2]
        };
        let Some(belt) = &self.belt else {
            let [load, added] = opposing([x.angle_rad, x.velocity_rad_s]);
            return [(motor - load) / (self.inertia_kg_m2 + added), 0.0, 0.0];
        };
        let coupling = belt.coupling_nm(x.angle_rad - x.load_rad, x.velocity_rad_s - x.load_rad_s);
        let [load, added] = opposing([x.load_rad, x.load_rad_s]);
        let behind = belt.inertia_kg_m2();
        let acceleration = (motor - coupling) / (self.inertia_kg_m2 - behind);
        [acceleration, x.load_rad_s, (coupling - load) / (behind + added)]
    }
}

#[cfg(test)]
mod axis_tests;
#[cfg(test)]
mod tests;
