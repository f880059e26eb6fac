//! One experiment: the scenario, the closed loop, the recorded trace.
//!
//! Input: a [`Scenario`] and a seed. Output: a [`RigTrace`], one row per sample.
//!
//! At each sample the drive measures and records, and then applies a new voltage, so the error affects the recorded
//! current one sample later (thesis Fig. 3.1):
//!
//! ```text
//! ω_m(k) = ω(k) + n_ω(k)                        measured velocity
//! i_m(k) = y(k) + n_i(k)                        y: filtered current (module `noise`)
//! e = ref − ω_m;   x ← x + Ki Ts e;   v = Kp e + x      (1), v held over Ts
//! ```
//!
//! The load torque is a sine plus a fluctuation. It is recorded at the samples, and is linear between them. Without the
//! fluctuation, two pure sines would not excite the models of the thesis persistently. The recorded angle is the true
//! angle without noise.

use core::f64::consts::TAU;

use super::{
    BearingGeometry, CurrentFilter, Defect, DefectTorque, LoadFluctuation, MotorParameters, NoiseSource, Plant,
    PlantState, RigError, Stream, TABLE_2_3, Waveform, finite, not_negative, positive,
};

/// Longest integration step; a sampling interval is divided into equal steps that are not longer.
const INNER_STEP_S: f64 = 1e-4;

/// Start angles cover ten shaft turns: orders are not integers, so each further turn is a different phase of the balls.
const START_ANGLE_RAD: f64 = 10.0 * TAU;

/// One experiment on the DC-motor rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scenario {
    /// Shape of the velocity reference.
    pub reference_waveform: Waveform,
    /// Amplitude (peak) of the velocity reference.
    pub reference_amplitude_rad_s: f64,
    /// Frequency of the velocity reference.
    pub reference_frequency_hz: f64,
    /// Amplitude of the sinusoidal load torque.
    pub load_amplitude_nm: f64,
    /// Frequency of the load torque.
    pub load_frequency_hz: f64,
    /// Root mean square of the load fluctuation.
    pub load_fluctuation_nm: f64,
    /// AR(1) pole of the load fluctuation at the sampling interval.
    pub load_fluctuation_pole: f64,
    /// Kp of (1).
    pub proportional_gain_v_s_per_rad: f64,
    /// Ki of (1).
    pub integral_gain_v_per_rad: f64,
    /// Ts of (1), also the recording interval.
    pub sample_time_s: f64,
    /// Number of rows of the trace.
    pub samples: usize,
    /// The motor without defect; [`Defect::motor`] returns the motor with the defect.
    pub motor: MotorParameters,
    /// Standard deviation of the current noise, outside the loop, after the filter.
    pub current_noise_a: f64,
    /// Standard deviation of the velocity noise, inside the loop.
    pub velocity_noise_rad_s: f64,
    /// The bearing's dimensions.
    pub bearing: BearingGeometry,
    /// Defect.
    pub defect: Defect,
}

impl Scenario {
    /// The standard rig; it was calibrated so that the fit of a healthy trace is as high as in the thesis.
    pub const STANDARD: Self = Self {
        reference_waveform: Waveform::Sine,
        reference_amplitude_rad_s: 40.0,
        reference_frequency_hz: 0.2,
        load_amplitude_nm: 0.15,
        load_frequency_hz: 0.5,
        load_fluctuation_nm: 0.06,
        load_fluctuation_pole: 0.2,
        proportional_gain_v_s_per_rad: 0.25,
        integral_gain_v_per_rad: 0.5,
        sample_time_s: 0.002,
        samples: 5000,
        motor: TABLE_2_3,
        current_noise_a: 0.130,
        velocity_noise_rad_s: 0.55,
        bearing: BearingGeometry::THESIS,
        defect: Defect::HEALTHY,
    };

    /// This scenario with the given defect.
    #[must_use]
    pub const fn with_defect(self, defect: Defect) -> Self {
        Self { defect, ..self }
    }

    /// This scenario with random conditions: reference amplitude × 0.6–1.5 and frequency × 0.6–1.8, load
    /// amplitude × 0.6–1.4 and frequency × 0.6–1.8, R ± 10 %, J ± 3 %, each uniform and drawn from
    /// [`Stream::Conditions`] of `seed`.
    #[must_use]
    pub fn mixed(mut self, seed: u64) -> Self {
        let mut source = NoiseSource::new(seed, Stream::Conditions);
        self.reference_amplitude_rad_s *= source.uniform(0.6, 1.5);
        self.reference_frequency_hz *= source.uniform(0.6, 1.8);
        self.load_amplitude_nm *= source.uniform(0.6, 1.4);
        self.load_frequency_hz *= source.uniform(0.6, 1.8);
        self.motor.r_ohm *= source.uniform(0.9, 1.1);
        self.motor.j_kg_m2 *= source.uniform(0.97, 1.03);
        self
    }

    /// Returns an error with the name of the field if the scenario cannot be simulated.
    pub fn validate(&self) -> Result<(), RigError> {
        finite("reference_amplitude_rad_s", self.reference_amplitude_rad_s)?;
        not_negative("reference_frequency_hz", self.reference_frequency_hz)?;
        finite("load_amplitude_nm", self.load_amplitude_nm)?;
        not_negative("load_frequency_hz", self.load_frequency_hz)?;
        not_negative("load_fluctuation_nm", self.load_fluctuation_nm)?;
        let pole = finite("load_fluctuation_pole", self.load_fluctuation_pole)?;
        if pole.abs() >= 1.0 {
            return Err(RigError::UnstableFluctuation(pole));
        }
        finite("proportional_gain_v_s_per_rad", self.proportional_gain_v_s_per_rad)?;
        finite("integral_gain_v_per_rad", self.integral_gain_v_per_rad)?;
        positive("sample_time_s", self.sample_time_s)?;
        if self.samples == 0 {
            return Err(RigError::NoSamples);
        }
        not_negative("defect.severity", self.defect.severity)?;
        self.defect.motor(&self.motor).validate()?;
        not_negative("current_noise_a", self.current_noise_a)?;
        not_negative("velocity_noise_rad_s", self.velocity_noise_rad_s)?;
        self.bearing.validate()?;
        Ok(())
    }

    fn reference_at(&self, t_s: f64) -> f64 {
        self.reference_amplitude_rad_s * self.reference_waveform.at(self.reference_frequency_hz, t_s)
    }

    fn load_at(&self, t_s: f64) -> f64 {
        self.load_amplitude_nm * libm::sin(TAU * self.load_frequency_hz * t_s)
    }
}

/// One recording: columns of the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RigTrace {
    /// Time of the sample.
    pub t_s: Vec<f64>,
    /// Velocity reference.
    pub velocity_ref_rad_s: Vec<f64>,
    /// Measured velocity.
    pub velocity_rad_s: Vec<f64>,
    /// Measured current.
    pub current_a: Vec<f64>,
    /// Load torque.
    pub load_torque_nm: Vec<f64>,
    /// Shaft angle, not wrapped.
    pub angle_rad: Vec<f64>,
}

impl RigTrace {
    fn with_capacity(samples: usize) -> Self {
        let column = || Vec::with_capacity(samples);
        Self {
            t_s: column(),
            velocity_ref_rad_s: column(),
            velocity_rad_s: column(),
            current_a: column(),
            load_torque_nm: column(),
            angle_rad: column(),
        }
    }

    /// Number of samples.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether there are no samples.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }
}

/// The digital controller of (1).
#[derive(Debug)]
struct VelocityLoop {
    kp: f64,
    ki_ts: f64,
    integral_v: f64,
}

impl VelocityLoop {
    const fn new(scenario: &Scenario) -> Self {
        Self {
            kp: scenario.proportional_gain_v_s_per_rad,
            ki_ts: scenario.integral_gain_v_per_rad * scenario.sample_time_s,
            integral_v: 0.0,
        }
    }

    fn voltage_v(&mut self, error_rad_s: f64) -> f64 {
        self.integral_v += self.ki_ts * error_rad_s; // (1)
        self.kp * error_rad_s + self.integral_v
    }
}

/// The motor with its defect and its current measurement, simulated one sampling interval at a time.
#[derive(Debug)]
struct Shaft {
    plant: Plant,
    filter: CurrentFilter,
    defect: DefectTorque,
    inner_steps: u32,
}

impl Shaft {
    fn new(scenario: &Scenario, seed: u64) -> Result<Self, RigError> {
        let inner_steps = inner_steps(scenario.sample_time_s);
        let step_s = scenario.sample_time_s / f64::from(inner_steps);
        let motor = scenario.defect.motor(&scenario.motor);
        let mut plant = Plant::new(&motor, step_s)?;
        plant.set_state(PlantState {
            angle_rad: NoiseSource::new(seed, Stream::StartAngle).uniform(0.0, START_ANGLE_RAD),
            ..PlantState::default()
        });
        Ok(Self {
            plant,
            filter: CurrentFilter::new(step_s),
            defect: scenario.defect.torque(motor.kt_nm_per_a, &scenario.bearing)?,
            inner_steps,
        })
    }

    /// Simulates one interval; `load_nm` is the load torque at its beginning and at its end.
    fn advance(&mut self, voltage_v: f64, load_nm: [f64; 2]) {
        let [from, to] = load_nm;
        for step in 0..self.inner_steps {
            let elapsed = (f64::from(step) + 0.5) / f64::from(self.inner_steps);
            let load = from + (to - from) * elapsed;
            let defect = self.defect;
            let state = self.plant.step(voltage_v, |at| load + defect.at(at));
            self.filter.update(state.current_a);
        }
    }
}

/// Number of equal steps of at most [`INNER_STEP_S`] in a sampling interval.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the range of u32 before the cast"
)]
fn inner_steps(sample_time_s: f64) -> u32 {
    // The tolerance prevents that rounding of an exact multiple adds a step.
    let steps = (sample_time_s / INNER_STEP_S - 1e-9).ceil();
    steps.clamp(1.0, f64::from(u32::MAX)) as u32
}

/// Runs one experiment. The same scenario and seed produce the same trace.
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<RigTrace, RigError> {
    scenario.validate()?;
    let mut shaft = Shaft::new(scenario, seed)?;
    let mut control = VelocityLoop::new(scenario);
    let mut current_noise = NoiseSource::new(seed, Stream::CurrentNoise);
    let mut velocity_noise = NoiseSource::new(seed, Stream::VelocityNoise);
    let mut fluctuation = LoadFluctuation::new(
        NoiseSource::new(seed, Stream::LoadFluctuation),
        scenario.load_fluctuation_nm,
        scenario.load_fluctuation_pole,
    );
    let mut trace = RigTrace::with_capacity(scenario.samples);
    let mut load = scenario.load_at(0.0) + fluctuation.draw();
    let mut t_s = 0.0;
    for k in 1..=scenario.samples {
        let state = shaft.plant.state();
        let reference = scenario.reference_at(t_s);
        let velocity = state.velocity_rad_s + scenario.velocity_noise_rad_s * velocity_noise.gaussian();
        let current = shaft.filter.output_a() + scenario.current_noise_a * current_noise.gaussian();
        if !(shaft.plant.is_finite() && current.is_finite()) {
            return Err(RigError::Diverged { t_s });
        }
        trace.t_s.push(t_s);
        trace.velocity_ref_rad_s.push(reference);
        trace.velocity_rad_s.push(velocity);
        trace.current_a.push(current);
        trace.load_torque_nm.push(load);
        trace.angle_rad.push(state.angle_rad);

        t_s = k as f64 * scenario.sample_time_s;
        let next_load = scenario.load_at(t_s) + fluctuation.draw();
        shaft.advance(control.voltage_v(reference - velocity), [load, next_load]);
        load = next_load;
    }
    Ok(trace)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_cut_into_whole_steps() {
        assert_eq!(inner_steps(0.002), 20);
        assert_eq!(inner_steps(1e-4), 1);
        assert_eq!(inner_steps(1e-5), 1);
        assert_eq!(inner_steps(2.5e-4), 3);
    }

    #[test]
    fn refuses_what_cannot_be_simulated() {
        let refused = |scenario: Scenario| simulate(&scenario, 0).expect_err("invalid");
        let standard = Scenario::STANDARD;
        assert_eq!(refused(Scenario { samples: 0, ..standard }), RigError::NoSamples);
        for sample_time_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            refused(Scenario { sample_time_s, ..standard });
        }
        refused(Scenario { reference_amplitude_rad_s: f64::NAN, ..standard });
        refused(Scenario { current_noise_a: -0.1, ..standard });
        refused(Scenario { load_fluctuation_pole: 1.0, ..standard });
        let message = refused(Scenario { sample_time_s: -1.0, ..standard }).to_string();
        assert_eq!(message, "sample_time_s must be positive, got -1");
    }

    #[test]
    fn a_loop_that_runs_away_is_an_error_not_a_trace() {
        let wild = Scenario { proportional_gain_v_s_per_rad: 50.0, ..Scenario::STANDARD };
        assert!(matches!(simulate(&wild, 0), Err(RigError::Diverged { .. })));
    }

    #[test]
    fn mixed_conditions_leave_noise_and_defect_alone() {
        let mixed = Scenario::STANDARD.mixed(5);
        assert_ne!(mixed, Scenario::STANDARD.mixed(6));
        assert_ne!(mixed.motor.r_ohm, TABLE_2_3.r_ohm);
        assert_eq!(mixed.current_noise_a, Scenario::STANDARD.current_noise_a);
        assert_eq!(mixed.defect, Scenario::STANDARD.defect);
    }
}
