//! The payload: its inertia, the compliance and the backlash between motor and load.
//!
//! The payload changes the total inertia J. With a compliance, a part of J sits behind a spring with a dead zone, and
//! the load acts on it:
//!
//! ```text
//! J₁ dω₁/dt = (torques of the motor) − T_k                               (1)
//! J₂ dω₂/dt = T_k − T_load,   dθ₂/dt = ω₂                                (2)
//! T_k = k (φ − clamp(φ, −g/2, g/2)) + c (ω₁ − ω₂),   φ = θ₁ − θ₂         (3)
//! J₁ + J₂ = J,   k = (2πf)² J₁J₂/J,   c = 2ζ (2πf) J₁J₂/J                (4)
//! ```
//!
//! c acts only outside the dead zone. f is the resonance of the two inertias without motor and without backlash. The
//! states of (2) are integrated by the midpoint rule of the motor.
//!
//! The load side may have a further inertia ΔJ that depends on its position. On a stiff shaft, a motor that integrates
//! J dω/dt = M − T gets (J + ΔJ) dω/dt = M − T_load from the torque
//!
//! ```text
//! T = T_load + ΔJ (M − T_load)/(J + ΔJ)                                  (5)
//! ```

use core::f64::consts::TAU;

use super::draws::between;
use crate::{NoiseSource, PlantState, RigError, Stage, fraction, not_negative, positive, within};

/// Ranges of the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mechanics {
    /// Relative variation of the total inertia.
    pub payload: f64,
    /// J₂/J.
    pub load_share: f64,
    /// Lower and upper limit of f of (4).
    pub resonance_hz: [f64; 2],
    /// ζ of (4).
    pub damping_ratio: f64,
    /// Lower and upper limit of g of (3).
    pub backlash_deg: [f64; 2],
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MechanicsValues {
    /// Factor of the total inertia.
    pub payload: f64,
    /// J₂/J.
    pub load_share: f64,
    /// f of (4).
    pub resonance_hz: f64,
    /// ζ of (4).
    pub damping_ratio: f64,
    /// g of (3).
    pub backlash_rad: f64,
}

impl Mechanics {
    /// The ranges of the field.
    pub const FIELD: Self = Self {
        payload: 0.2,
        load_share: 0.4,
        resonance_hz: [30.0, 80.0],
        damping_ratio: 0.05,
        backlash_deg: [0.1, 0.3],
    };

    /// A gear without backlash on an axis, whose payload has its own law.
    pub(crate) const GEAR: Self =
        Self { payload: 0.0, resonance_hz: [40.0, 80.0], backlash_deg: [0.0; 2], ..Self::FIELD };

    pub(crate) fn validate(&self) -> Result<(), RigError> {
        fraction("field.mechanics.payload", self.payload)?;
        positive("field.mechanics.load_share", self.load_share)?;
        within("field.mechanics.load_share", self.load_share, [0.0, 0.95])?;
        for limit in self.resonance_hz {
            positive("field.mechanics.resonance_hz", limit)?;
        }
        not_negative("field.mechanics.damping_ratio", self.damping_ratio)?;
        for limit in self.backlash_deg {
            not_negative("field.mechanics.backlash_deg", limit)?;
        }
        Ok(())
    }

    /// Draws the payload from `job` and the constants of the transmission from `built`.
    pub(crate) fn draw(&self, mut job: NoiseSource, mut built: NoiseSource) -> MechanicsValues {
        MechanicsValues {
            payload: 1.0 + job.uniform(-self.payload, self.payload),
            load_share: self.load_share,
            resonance_hz: between(&mut built, self.resonance_hz),
            damping_ratio: self.damping_ratio,
            backlash_rad: between(&mut built, self.backlash_deg).to_radians(),
        }
    }
}

/// What acts at a point of the load side: torque, and inertia ΔJ beside the constant one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Opposing {
    /// Torque that opposes positive motion.
    pub(crate) torque_nm: f64,
    /// ΔJ.
    pub(crate) added_kg_m2: f64,
}

impl Opposing {
    /// A torque, and no inertia.
    pub(crate) const fn plain(torque_nm: f64) -> Self {
        Self { torque_nm, added_kg_m2: 0.0 }
    }

    /// The torque (5) that opposes a motor of inertia J on a stiff shaft; `driving_nm` is M, all other torques.
    pub(crate) fn on_stiff_shaft(&self, driving_nm: f64, inertia_kg_m2: f64) -> f64 {
        let Self { torque_nm, added_kg_m2 } = *self;
        torque_nm + added_kg_m2 * (driving_nm - torque_nm) / (inertia_kg_m2 + added_kg_m2) // (5)
    }
}

/// The inertia behind the compliance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LoadSide {
    inertia_kg_m2: f64,
    stiffness_nm_per_rad: f64,
    damping_nm_s_per_rad: f64,
    half_gap_rad: f64,
    angle_rad: f64,
    velocity_rad_s: f64,
    middle: [f64; 2],
}

impl LoadSide {
    /// The load side of a drive with total inertia `j_kg_m2`, at rest relative to the motor and amid its backlash.
    pub(crate) fn new(values: &MechanicsValues, j_kg_m2: f64, motor: &PlantState) -> Self {
        let share = values.load_share;
        let (reduced, w) = (j_kg_m2 * share * (1.0 - share), TAU * values.resonance_hz);
        let (angle_rad, velocity_rad_s) = (motor.angle_rad, motor.velocity_rad_s);
        Self {
            inertia_kg_m2: j_kg_m2 * share,
            stiffness_nm_per_rad: w * w * reduced, // (4)
            damping_nm_s_per_rad: 2.0 * values.damping_ratio * w * reduced,
            half_gap_rad: 0.5 * values.backlash_rad,
            angle_rad,
            velocity_rad_s,
            middle: [angle_rad, velocity_rad_s],
        }
    }

    /// One stage of a step of `step_s`: returns T_k at this stage, and integrates (2) to the middle or to the end of
    /// the step. `load` returns the torque on the load side at an angle and a velocity, and its further inertia.
    pub(super) fn stage(
        &mut self,
        stage: Stage,
        motor: &PlantState,
        step_s: f64,
        load: impl Fn([f64; 2]) -> Opposing,
    ) -> f64 {
        let [angle, velocity] = match stage {
            Stage::Start => [self.angle_rad, self.velocity_rad_s],
            Stage::Middle => self.middle,
        };
        let coupling = self.coupling_nm(motor.angle_rad - angle, motor.velocity_rad_s - velocity);
        let load = load([angle, velocity]);
        let acceleration = (coupling - load.torque_nm) / (self.inertia_kg_m2 + load.added_kg_m2); // (2)
        match stage {
            Stage::Start => {
                let half = 0.5 * step_s;
                self.middle = [angle + half * velocity, velocity + half * acceleration];
            }
            Stage::Middle => {
                self.angle_rad += step_s * velocity;
                self.velocity_rad_s += step_s * acceleration;
            }
        }
        coupling
    }

    /// Puts the load side where it holds a torque at rest.
    pub(crate) fn hold(&mut self, motor_rad: f64, torque_nm: f64) {
        let gap = if torque_nm == 0.0 { 0.0 } else { self.half_gap_rad.copysign(torque_nm) };
        self.angle_rad = motor_rad - torque_nm / self.stiffness_nm_per_rad - gap;
    }

    /// Angle of the load side.
    pub(crate) const fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// J₂.
    pub(crate) const fn inertia_kg_m2(&self) -> f64 {
        self.inertia_kg_m2
    }

    /// T_k (3).
    pub(crate) fn coupling_nm(&self, twist_rad: f64, slip_rad_s: f64) -> f64 {
        let strain = twist_rad - twist_rad.clamp(-self.half_gap_rad, self.half_gap_rad);
        // Without backlash the spring is always in contact.
        let contact = strain != 0.0 || self.half_gap_rad == 0.0;
        let damping = if contact { self.damping_nm_s_per_rad * slip_rad_s } else { 0.0 };
        self.stiffness_nm_per_rad * strain + damping
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MotorParameters, Plant, Stream, TABLE_2_3};

    const STIFF: MechanicsValues =
        MechanicsValues { payload: 1.0, load_share: 0.4, resonance_hz: 50.0, damping_ratio: 0.0, backlash_rad: 0.0 };

    /// A motor without torque of its own; its inertia is that of the motor side.
    fn free_motor() -> Plant {
        let motor = MotorParameters {
            kt_nm_per_a: 1e-12,
            ke_v_s_per_rad: 1e-12,
            b_nm_s_per_rad: 0.0,
            j_kg_m2: 0.6 * TABLE_2_3.j_kg_m2,
            ..TABLE_2_3
        };
        Plant::new(&motor, 1e-4).expect("valid")
    }

    /// Velocities of motor and load side after each step, from a motor that turns against a load side at rest.
    fn free_run(values: &MechanicsValues, steps: u32) -> Vec<[f64; 2]> {
        let mut plant = free_motor();
        let mut side = LoadSide::new(values, TABLE_2_3.j_kg_m2, &plant.state());
        plant.set_state(PlantState { velocity_rad_s: 1.0, ..plant.state() });
        let mut step = || {
            plant.step_staged(0.0, |stage, at| side.stage(stage, at, 1e-4, |_| Opposing::plain(0.0)));
            [plant.state().velocity_rad_s, side.velocity_rad_s]
        };
        (0..steps).map(|_| step()).collect()
    }

    #[test]
    fn two_inertias_swing_at_the_resonance() {
        let run = free_run(&STIFF, 10_000);
        // ω₁ − ω₂ = cos 2πft, J₁ω₁ + J₂ω₂ = J₁.
        for (k, [motor, load]) in (1..).zip(&run) {
            let t = 1e-4 * f64::from(k);
            // The midpoint rule shifts the frequency by (2πfh)²/6 = 1.6e-4: 0.052 rad after 50 periods; and it gains
            // (2πfh)⁴/8 a step, 1.2e-3 in all.
            assert!((motor - load - (TAU * 50.0 * t).cos()).abs() < 0.055, "{t}");
            // Rounding of 1e4 steps.
            assert!((0.6 * motor + 0.4 * load - 0.6).abs() < 1e-11);
        }
    }

    #[test]
    fn damping_has_its_ratio() {
        let run = free_run(&MechanicsValues { damping_ratio: 0.05, ..STIFF }, 2000);
        // Peaks of |ω₁ − ω₂| fall by exp(−ζ 2πf t): over ten periods by e^(−π).
        let peak = |from: usize| run[from..from + 200].iter().map(|[m, l]| (m - l).abs()).fold(0.0, f64::max);
        let ratio = peak(1200) / peak(200);
        // 1 − ζ² in the frequency, and the phase of the peaks in a window of one period: 1 % each.
        assert!((ratio / (-0.05 * TAU * 50.0 * 0.1).exp() - 1.0).abs() < 0.03, "{ratio}");
    }

    #[test]
    fn in_the_backlash_there_is_no_torque() {
        let values = MechanicsValues { backlash_rad: 0.004, damping_ratio: 0.05, ..STIFF };
        let side = LoadSide::new(&values, 2.5e-4, &PlantState::default());
        let stiffness = (TAU * 50.0).powi(2) * 2.5e-4 * 0.24;
        for (twist, torque) in [(0.0, 0.0), (0.002, 0.0), (-0.0019, 0.0), (0.003, 0.001), (-0.005, -0.003)] {
            // Rounding only.
            assert!((side.coupling_nm(twist, 0.0) - stiffness * torque).abs() < 1e-14, "{twist}");
        }
        assert_eq!(side.coupling_nm(0.001, 5.0), 0.0);
        let damped = side.coupling_nm(0.003, 5.0) - side.coupling_nm(0.003, 0.0);
        assert!((damped - 5.0 * 0.1 * TAU * 50.0 * 2.5e-4 * 0.24).abs() < 1e-14);
    }

    #[test]
    fn a_constant_load_hangs_on_the_spring() {
        // Free fall of both inertias under a load on the load side: both accelerate by −T/J, T_k = J₁ T/J.
        let mut plant = free_motor();
        let values = MechanicsValues { damping_ratio: 1.0, ..STIFF };
        let mut side = LoadSide::new(&values, 2.5e-4, &plant.state());
        for _ in 0..10_000 {
            plant.step_staged(0.0, |stage, at| side.stage(stage, at, 1e-4, |_| Opposing::plain(0.01)));
        }
        // e⁻³¹⁴ of the swing is left; rounding of 1e4 steps on a velocity of 40 rad/s.
        assert!((plant.state().velocity_rad_s + 0.01 / 2.5e-4).abs() < 1e-9);
        let twist = plant.state().angle_rad - side.angle_rad;
        assert!((side.coupling_nm(twist, 0.0) - 0.6 * 0.01).abs() < 1e-9);
    }

    #[test]
    fn values_stay_in_their_ranges() {
        for seed in 0..1000 {
            let source = |stream| NoiseSource::new(seed, stream);
            let values = Mechanics::FIELD.draw(source(Stream::Payload), source(Stream::Mechanics));
            assert!((0.8..1.2).contains(&values.payload) && (30.0..80.0).contains(&values.resonance_hz));
            // Degrees to radians is rounded.
            assert!((0.1 - 1e-12..0.3 + 1e-12).contains(&values.backlash_rad.to_degrees()));
        }
    }
}
