//! The closed loop of all parts.
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
//! angle without noise. The effects of the module [`field`](super::field) change plant, reference and measurement.

use core::f64::consts::TAU;

use super::axis::brake::Watch;
use super::axis::{self, AxisColumns, AxisLoad, Payloads};
use super::field::{Clock, Constants, DriveTrain, FieldValues, LoadMeasurement, LoadSensorValues, Profile};
use super::sensors::Sensors;
use super::trace::Row;
use super::{
    CurrentFilter, DefectTorque, LoadFluctuation, MotorParameters, NoiseSource, Plant, PlantState, RigError, RigTrace,
    Scenario, Stream,
};

/// Longest integration step; a sampling interval is divided into equal steps that are not longer.
const INNER_STEP_S: f64 = 1e-4;

/// Start angles cover ten shaft turns: orders are not integers, so each further turn is a different phase of the balls.
pub(super) const START_ANGLE_RAD: f64 = 10.0 * TAU;

/// The digital controller of (1).
#[derive(Debug)]
struct VelocityLoop {
    kp: f64,
    ki_ts: f64,
    integral_v: f64,
}

impl VelocityLoop {
    /// A controller that has held a motor at `start` for a long time.
    fn new(scenario: &Scenario, motor: &MotorParameters, start: &PlantState) -> Self {
        Self {
            kp: scenario.proportional_gain_v_s_per_rad,
            ki_ts: scenario.integral_gain_v_per_rad * scenario.sample_time_s,
            integral_v: motor.r_ohm * start.current_a + motor.ke_v_s_per_rad * start.velocity_rad_s,
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
    /// `None` if all effects of the field are off.
    field: Option<DriveTrain>,
}

impl Shaft {
    fn new(
        scenario: &Scenario,
        values: &FieldValues,
        (start, axis): (PlantState, Option<AxisLoad>),
        seed: u64,
    ) -> Result<Self, RigError> {
        let inner_steps = inner_steps(scenario.sample_time_s, INNER_STEP_S);
        let step_s = scenario.sample_time_s / f64::from(inner_steps);
        let motor = motor(scenario, values);
        let own = values.mechanics.map_or(1.0, |mechanics| 1.0 - mechanics.load_share);
        let mut plant = Plant::new(&MotorParameters { j_kg_m2: own * motor.j_kg_m2, ..motor }, step_s)?;
        plant.set_state(start);
        let mut filter = CurrentFilter::new(step_s);
        filter.settle(start.current_a);
        let in_field = scenario.field != super::Field::NONE || axis.is_some();
        let field = in_field.then(|| DriveTrain::new(scenario, values, &motor, (start, axis), seed)).transpose()?;
        let defect = scenario.defect.torque(motor.kt_nm_per_a, &scenario.bearing)?;
        Ok(Self { plant, filter, defect, inner_steps, field })
    }

    /// Simulates the interval from `t_s`; `load_nm` is the load torque at its beginning and at its end.
    fn advance(&mut self, voltage_v: f64, load_nm: [f64; 2], [t_s, interval_s]: [f64; 2]) {
        if let Some(field) = &mut self.field {
            let step_s = interval_s / f64::from(self.inner_steps);
            field.begin(&mut self.plant, t_s, step_s);
            self.filter.set_step(step_s);
        }
        let [from, to] = load_nm;
        for step in 0..self.inner_steps {
            let elapsed = (f64::from(step) + 0.5) / f64::from(self.inner_steps);
            let load = from + (to - from) * elapsed;
            if let Some(field) = &mut self.field {
                field.step(&mut self.plant, voltage_v, load);
            } else {
                let defect = self.defect;
                self.plant.step(voltage_v, |at| load + defect.at(at));
            }
            self.filter.update(self.plant.state().current_a);
        }
    }
}

/// The motor with the defect and the field's values.
fn motor(scenario: &Scenario, values: &FieldValues) -> MotorParameters {
    scenario.defect.motor(&values.motor(&scenario.motor))
}

/// The state of the motor at the start of a record.
fn start(motor: &MotorParameters, velocity_rad_s: f64, seed: u64) -> PlantState {
    PlantState {
        current_a: motor.b_nm_s_per_rad * velocity_rad_s / motor.kt_nm_per_a,
        velocity_rad_s,
        angle_rad: NoiseSource::new(seed, Stream::StartAngle).uniform(0.0, START_ANGLE_RAD),
    }
}

/// The same on an axis, whose weight the current holds.
fn start_on(axis: &AxisOfRecord, motor: &MotorParameters, state: PlantState) -> PlantState {
    let angle_rad = axis.start_rad;
    let hold_a = axis.at_start.weight_nm(angle_rad) / motor.kt_nm_per_a;
    PlantState { current_a: state.current_a + hold_a, angle_rad, ..state }
}

/// What an axis changes from sample to sample.
#[derive(Debug)]
struct AxisOfRecord {
    ratio: f64,
    /// Angle of the motor at the start, after `turns_rad` of whole turns that are not recorded.
    start_rad: f64,
    turns_rad: f64,
    at_start: AxisLoad,
    payloads: Payloads,
    brake: Option<Watch>,
}

impl AxisOfRecord {
    fn new(scenario: &Scenario, motor: &MotorParameters, profile: &Profile, seed: u64) -> Option<Self> {
        let axis = scenario.axis?;
        let [phi, turns] = axis::start(scenario.duty.motion(), seed);
        let (turns_rad, end_s) = (TAU * turns, scenario.samples as f64 * scenario.sample_time_s);
        let payloads = Payloads::draw(&axis, &profile.rests_s(), end_s, seed);
        let mut at_start = super::field::axis(&axis, scenario.drive, [turns_rad, motor.j_kg_m2], seed);
        at_start.set_payload(payloads.at(0.0));
        Some(Self {
            ratio: axis.ratio,
            start_rad: axis.ratio * phi + turns_rad,
            turns_rad,
            at_start,
            payloads,
            brake: axis.brake.map(|_| Watch::default()),
        })
    }
}

/// Number of equal steps of at most `longest_s` in a sampling interval.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the range of u32 before the cast"
)]
pub(super) fn inner_steps(sample_time_s: f64, longest_s: f64) -> u32 {
    // The tolerance prevents that rounding of an exact multiple adds a step.
    let steps = (sample_time_s / longest_s - 1e-9).ceil();
    steps.clamp(1.0, f64::from(u32::MAX)) as u32
}

/// Reference, motor, sensors and controller of one experiment.
#[derive(Debug)]
struct Experiment {
    profile: Profile,
    axis: Option<AxisOfRecord>,
    shaft: Shaft,
    sensors: Sensors,
    control: VelocityLoop,
}

impl Experiment {
    fn new(scenario: &Scenario, values: &FieldValues, seed: u64) -> Result<Self, RigError> {
        let profile = Profile::draw(scenario, seed);
        let motor = motor(scenario, values);
        let axis = AxisOfRecord::new(scenario, &motor, &profile, seed);
        let start = start(&motor, profile.initial_rad_s(scenario), seed);
        let start = axis.as_ref().map_or(start, |axis| start_on(axis, &motor, start));
        let load = axis.as_ref().map(|axis| axis.at_start);
        Ok(Self {
            profile,
            axis,
            shaft: Shaft::new(scenario, values, (start, load), seed)?,
            sensors: Sensors::new(scenario, values, start.velocity_rad_s, seed),
            control: VelocityLoop::new(scenario, &motor, &start),
        })
    }

    /// Measures at time `t_s`, `interval_s` after the last sample, and decides on the next voltage.
    fn row(
        &mut self,
        scenario: &Scenario,
        [t_s, interval_s]: [f64; 2],
        load_nm: f64,
        columns: &mut AxisColumns,
    ) -> Result<Row, RigError> {
        let state = self.shaft.plant.state();
        let seen = self.sensors.measure(&state, self.shaft.filter.output_a(), interval_s);
        if !(self.shaft.plant.is_finite() && seen.current_a.is_finite()) {
            return Err(RigError::Diverged { t_s });
        }
        let reference = self.profile.at(scenario, t_s);
        let mut row = Row {
            t_s,
            velocity_ref_rad_s: reference,
            velocity_rad_s: seen.velocity_rad_s,
            current_a: seen.current_a,
            load_torque_nm: load_nm,
            angle_rad: seen.angle_rad,
            voltage_v: 0.0,
        };
        if !self.on_axis(&mut row, interval_s, columns) {
            row.voltage_v = self.control.voltage_v(reference - seen.velocity_rad_s);
        }
        Ok(row)
    }

    /// Sets payload and brake of the axis and records them. Returns whether the brake is closed.
    fn on_axis(&mut self, row: &mut Row, interval_s: f64, columns: &mut AxisColumns) -> bool {
        let Some(of_record) = &mut self.axis else { return false };
        let resting = row.velocity_ref_rad_s == 0.0;
        let closed = of_record.brake.as_mut().is_some_and(|brake| brake.closed(resting, interval_s));
        let Shaft { plant, field, .. } = &mut self.shaft;
        if let Some((axis, angle_rad)) = field.as_mut().and_then(|field| field.axis(plant)) {
            axis.set_payload(of_record.payloads.at(row.t_s));
            axis.set_brake(closed, plant.state().angle_rad);
            row.load_torque_nm += axis.weight_nm(angle_rad);
            columns.push(of_record.ratio, axis, angle_rad, closed);
        }
        row.angle_rad -= of_record.turns_rad;
        closed
    }
}

/// Runs one experiment. The same scenario and seed produce the same trace.
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<RigTrace, RigError> {
    scenario.validate()?;
    let source = |stream| NoiseSource::new(seed, stream);
    let values = FieldValues::draw(scenario, seed);
    let mut experiment = Experiment::new(scenario, &values, seed)?;
    let mut clock = Clock::new(scenario.sample_time_s, scenario.field.jitter, source(Stream::SampleJitter));
    let (rms_nm, pole) = (scenario.load_fluctuation_nm, scenario.load_fluctuation_pole);
    let mut fluctuation = LoadFluctuation::new(source(Stream::LoadFluctuation), rms_nm, pole);
    let mut trace = RigTrace::with_capacity(scenario.samples);
    let mut load = scenario.load_at(0.0) + fluctuation.draw();
    let [mut t_s, mut interval_s] = [0.0, scenario.sample_time_s];
    for k in 1..=scenario.samples {
        let row = experiment.row(scenario, [t_s, interval_s], load, &mut trace.axis)?;
        trace.push(row);
        [t_s, interval_s] = clock.advance(k);
        let next_load = scenario.load_at(t_s) + fluctuation.draw();
        experiment.shaft.advance(row.voltage_v, [load, next_load], [row.t_s, interval_s]);
        load = next_load;
    }
    finish(&mut trace, scenario, &values, seed);
    Ok(trace)
}

/// What does not feed back into the loop: load sensor, temperature sensor and missing samples.
fn finish(trace: &mut RigTrace, scenario: &Scenario, values: &FieldValues, seed: u64) {
    let Constants { load_gain, .. } = values.constants();
    let noise = NoiseSource::new(seed, Stream::LoadSensorNoise);
    match (scenario.field.load, values.load_sensor) {
        (LoadMeasurement::Absent, _) => trace.no_load_sensor = true,
        (LoadMeasurement::Exact, _) if values.constants.is_none() => {}
        (_, sensor) => {
            let sensor = sensor.unwrap_or(LoadSensorValues::EXACT);
            let sensor = LoadSensorValues { gain: load_gain * sensor.gain, ..sensor };
            trace.load_torque_nm = sensor.measure(&trace.t_s, &trace.load_torque_nm, noise);
        }
    }
    if let Some(temperature) = values.temperature {
        trace.temperature_c = temperature.measured_c(&trace.t_s, NoiseSource::new(seed, Stream::TemperatureSensor));
    }
    if let Some(missing) = scenario.field.missing {
        trace.lose(&missing.draw(NoiseSource::new(seed, Stream::Missing), scenario.samples));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Defect, DefectKind, Field, trace_seed};

    #[test]
    fn an_interval_is_cut_into_whole_steps() {
        assert_eq!(inner_steps(0.002, INNER_STEP_S), 20);
        assert_eq!(inner_steps(1e-4, INNER_STEP_S), 1);
        assert_eq!(inner_steps(1e-5, INNER_STEP_S), 1);
        assert_eq!(inner_steps(2.5e-4, INNER_STEP_S), 3);
    }

    #[test]
    fn a_loop_that_runs_away_is_an_error_not_a_trace() {
        let wild = Scenario { proportional_gain_v_s_per_rad: 50.0, ..Scenario::STANDARD };
        assert!(matches!(simulate(&wild, 0), Err(RigError::Diverged { .. })));
    }

    /// FNV-1a of the bits of the columns that the rig has always had.
    fn hash(trace: &RigTrace) -> u64 {
        let columns = trace.recorded().into_iter().filter(|(name, _)| *name != "voltage_v");
        let bytes = columns.flat_map(|(_, column)| column.iter().flat_map(|x| x.to_bits().to_le_bytes()));
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
    }

    #[test]
    fn without_the_field_a_seed_still_means_its_old_bits() {
        // Without noise all numbers are computed by the rig and by libm: they are the same on every machine.
        let quiet = Scenario {
            current_noise_a: 0.0,
            velocity_noise_rad_s: 0.0,
            load_fluctuation_nm: 0.0,
            ..Scenario::STANDARD
        };
        let recorded = [
            (DefectKind::Healthy, 0x2640_6367_dbf7_256a, 0xf933_5cdb_50bd_5d00),
            (DefectKind::Spall, 0x79e2_1ba9_31c6_586c, 0x2124_d7ee_bd5a_1de9),
            (DefectKind::Roughness, 0xfb05_099b_236c_d528, 0xa27f_b7b5_ed44_d338),
            (DefectKind::Coulomb, 0x074c_ff22_a923_03a5, 0x2f8e_6463_3e6e_cc16),
            (DefectKind::SpallAndRoughness, 0x4864_f96a_95e6_e51c, 0x5c5c_6886_7d30_c2c3),
            (DefectKind::WeakMagnet, 0xcc8d_6bb4_f555_0d4e, 0x2e1a_656d_20a7_7fbf),
        ];
        for (kind, standard, mixed) in recorded {
            let seed = trace_seed(1, kind, 0);
            let scenario = quiet.with_defect(Defect::full(kind));
            assert_eq!(hash(&simulate(&scenario, seed).expect("valid")), standard, "{kind:?}");
            assert_eq!(hash(&simulate(&scenario.mixed(seed), seed).expect("valid")), mixed, "{kind:?}");
        }
    }

    #[test]
    fn the_plant_of_the_field_without_effects_is_the_plant_of_the_rig() {
        let scenario = Scenario::STANDARD.with_defect(Defect::full(DefectKind::SpallAndRoughness)).mixed(4);
        let field = Field { load: LoadMeasurement::Absent, ..Field::NONE };
        let (plain, unloaded) = (simulate(&scenario, 4), simulate(&Scenario { field, ..scenario }, 4));
        let (plain, unloaded) = (plain.expect("valid"), unloaded.expect("valid"));
        assert!(unloaded.no_load_sensor && unloaded.recorded().len() == 6);
        assert_eq!(RigTrace { no_load_sensor: false, ..unloaded.clone() }, plain);
        assert_eq!(unloaded.recorded_load_nm(), vec![0.0; 5000]);
    }

    #[test]
    fn the_voltage_of_a_row_drives_the_next_interval() {
        let quiet = Scenario { velocity_noise_rad_s: 0.0, load_fluctuation_nm: 0.0, ..Scenario::STANDARD };
        let trace = simulate(&quiet, 2).expect("valid");
        let motor = quiet.motor;
        let mut plant = Plant::new(&motor, 1e-4).expect("valid");
        plant.set_state(PlantState { angle_rad: trace.angle_rad[0], ..PlantState::default() });
        for k in 0..4999 {
            for step in 0..20 {
                let part = (f64::from(step) + 0.5) / 20.0;
                let load = trace.load_torque_nm[k] + (trace.load_torque_nm[k + 1] - trace.load_torque_nm[k]) * part;
                plant.step(trace.voltage_v[k], |_| load);
            }
            assert_eq!(plant.state().velocity_rad_s, trace.velocity_rad_s[k + 1]);
        }
    }
}
