//! The closed loop of actuator, sensors and drive.
//!
//! At the start of each control interval the drive measures, computes its voltage and applies it without delay until
//! the next interval; a row contains the measured signals and the commands that follow from them. The applied voltage
//! is turned by the error of the measured angle:
//!
//! ```text
//! v_d + j v_q = (v_d,cmd + j v_q,cmd) exp(j p (θ_m − θ))      (1)
//! ```
//!
//! A record starts at rest at the mean of the command, at an angle drawn over ten turns, with the current that holds
//! the load.

use super::super::axis::brake::Watch;
use super::super::axis::cycle::{Path, rests};
use super::super::axis::{Axis, AxisColumns, Payloads};
use super::super::closed_loop::{START_ANGLE_RAD, inner_steps};
use super::super::{NoiseSource, RigError, Stream};
use super::load::ExternalForce;
use super::sensors::EmaSensors;
use super::trace::Row;
use super::{Commands, Controller, DqVoltage, EmaPlant, EmaScenario, EmaTrace, Feedback};

/// Longest integration step; a control interval is divided into equal steps that are not longer.
const INNER_STEP_S: f64 = 1.0 / 24_000.0;

/// One experiment, simulated one control interval at a time.
#[derive(Debug)]
pub(super) struct Experiment {
    pub(super) plant: EmaPlant,
    controller: Controller,
    sensors: EmaSensors,
    force: ExternalForce,
    path: Option<Path>,
    axis: Option<AxisOfRecord>,
    inner_steps: u32,
    interval_s: f64,
}

/// What an axis changes from interval to interval.
#[derive(Debug)]
struct AxisOfRecord {
    ratio: f64,
    payloads: Payloads,
    brake: Option<Watch>,
    /// The last command, which does not change at rest.
    command_m: f64,
    closed: bool,
}

impl AxisOfRecord {
    fn new(axis: &Axis, payloads: Payloads) -> Self {
        let brake = axis.brake.map(|_| Watch::default());
        Self { ratio: axis.ratio, payloads, brake, command_m: f64::NAN, closed: false }
    }

    /// Sets payload and brake at time `t_s` under a position command; returns whether the brake is closed.
    fn set(&mut self, plant: &mut EmaPlant, [t_s, interval_s]: [f64; 2], command_m: f64) -> bool {
        let resting = command_m == self.command_m;
        self.command_m = command_m;
        self.closed = self.brake.as_mut().is_some_and(|brake| brake.closed(resting, interval_s));
        let angle_rad = plant.state().angle_rad;
        if let Some(axis) = plant.axis_mut() {
            axis.set_payload(self.payloads.at(t_s));
            axis.set_brake(self.closed, angle_rad);
        }
        self.closed
    }
}

impl Experiment {
    pub(super) fn new(scenario: &EmaScenario, seed: u64) -> Result<Self, RigError> {
        scenario.validate()?;
        let interval_s = scenario.drive.interval_s;
        let inner_steps = inner_steps(interval_s, INNER_STEP_S);
        let warm = scenario.actuator.at_temperature(scenario.temperature);
        let (springs, step_s) = (scenario.load.springs_n_per_m(), interval_s / f64::from(inner_steps));
        let mut plant = EmaPlant::new(&warm, &scenario.defect, &scenario.bearing, springs, step_s)?;
        let source = NoiseSource::new(seed, Stream::LoadFluctuation);
        let mut force = ExternalForce::new(scenario.load, scenario.load_fluctuation_n, source);
        let angle_rad = NoiseSource::new(seed, Stream::StartAngle).uniform(0.0, START_ANGLE_RAD);
        plant.hold(angle_rad, scenario.offset_m, force.at(0.0));
        let cycles = scenario.cycles(seed);
        let axis = scenario.axis.map(|axis| {
            let rests = cycles.as_deref().map(rests).unwrap_or_default();
            let end_s = scenario.rows as f64 * scenario.row_interval_s();
            let payloads = Payloads::draw(&axis, &rests, end_s, seed);
            let source = |stream| NoiseSource::new(seed, stream);
            let values = axis.transmission.map(|own| own.draw(source(Stream::Payload), source(Stream::Mechanics)));
            plant.drive_axis(&axis, values.as_ref(), payloads.at(0.0), source(Stream::Gear));
            AxisOfRecord::new(&axis, payloads)
        });
        let path = cycles.map(Path::new);
        let mut controller = Controller::new(&scenario.drive, &scenario.actuator);
        controller.hold(plant.state().quadrature_a, warm.r_ohm);
        let sensors = EmaSensors::new(&scenario.sensors, &scenario.actuator, seed);
        Ok(Self { plant, controller, sensors, force, path, axis, inner_steps, interval_s })
    }

    /// Measures at time `t_s` and decides on the voltage of the interval. Returns the row and the applied voltage (1).
    pub(super) fn decide(&mut self, scenario: &EmaScenario, t_s: f64) -> Result<(Row, DqVoltage), RigError> {
        let state = self.plant.state();
        if !state.is_finite() {
            return Err(RigError::Diverged { t_s });
        }
        let seen = self.sensors.measure(&state);
        let position_ref_m = scenario.position_ref_m(self.path.as_ref(), t_s);
        let at = [t_s, self.interval_s];
        let closed = self.axis.as_mut().is_some_and(|axis| axis.set(&mut self.plant, at, position_ref_m));
        let feedback = Feedback {
            position_m: seen.position_m,
            velocity_rad_s: seen.velocity_rad_s,
            direct_a: seen.direct_a,
            quadrature_a: seen.quadrature_a,
        };
        let commands = if closed {
            Commands { velocity_ref_rad_s: 0.0, current_ref_a: 0.0, voltage: DqVoltage::default() }
        } else {
            self.controller.update(position_ref_m, &feedback)
        };
        let DqVoltage { d_v, q_v } = commands.voltage;
        let [cos, sin] = seen.misalignment;
        let applied = DqVoltage { d_v: d_v * cos - q_v * sin, q_v: d_v * sin + q_v * cos }; // (1)
        let load_n = self.plant.load_n(self.force.at(t_s));
        let row = Row {
            position_ref_m,
            position_m: seen.position_m,
            velocity_ref_rad_s: commands.velocity_ref_rad_s,
            velocity_rad_s: seen.velocity_rad_s,
            current_a: seen.quadrature_a,
            current_d_a: seen.direct_a,
            current_ref_a: commands.current_ref_a,
            phases_a: seen.phases_a,
            resolver_counts: seen.resolver_counts,
            angle_rad: seen.angle_rad,
            load_n,
            load_torque_nm: load_n * scenario.actuator.metres_per_rad(),
            voltage_d_v: d_v,
            voltage_q_v: q_v,
        };
        Ok((row, applied))
    }

    /// Adds a row that says what the axis is.
    fn describe_axis(&mut self, columns: &mut AxisColumns) {
        let angle_rad = self.plant.screw_rad();
        if let Some((own, axis)) = self.axis.as_ref().zip(self.plant.axis_mut()) {
            columns.push(own.ratio, axis, angle_rad, own.closed);
        }
    }

    /// Simulates the interval from `t_s`. `watch` sees the external force at the start and at the end of each step, and
    /// the plant after it.
    pub(super) fn advance(&mut self, t_s: f64, applied: DqVoltage, mut watch: impl FnMut([f64; 2], &EmaPlant)) {
        let mut from = self.force.at(t_s);
        for step in 1..=self.inner_steps {
            let to = self.force.at(t_s + self.interval_s * f64::from(step) / f64::from(self.inner_steps));
            self.plant.step(applied, [from, to]);
            watch([from, to], &self.plant);
            from = to;
        }
    }
}

/// Runs one experiment. The same scenario and seed produce the same trace.
///
/// # Errors
/// Returns an error with the name of a field that cannot be simulated, or if the loop diverges.
pub fn simulate(scenario: &EmaScenario, seed: u64) -> Result<EmaTrace, RigError> {
    let mut experiment = Experiment::new(scenario, seed)?;
    let mut trace = EmaTrace::default();
    let mut held = None;
    let (every, hold) = (u64::from(scenario.logging.every), u64::from(scenario.logging.hold));
    for k in 0_u64.. {
        let t_s = scenario.drive.interval_s * k as f64;
        let (row, applied) = experiment.decide(scenario, t_s)?;
        if k.is_multiple_of(every) {
            let kept = held.filter(|_| !(k / every).is_multiple_of(hold)).unwrap_or(row);
            trace.push(t_s, &kept);
            experiment.describe_axis(&mut trace.axis);
            held = Some(kept);
        }
        if trace.len() == scenario.rows {
            break;
        }
        experiment.advance(t_s, applied, |_, _| {});
    }
    Ok(trace)
}

#[cfg(test)]
mod tests;
