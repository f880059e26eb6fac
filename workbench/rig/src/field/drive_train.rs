//! The motor with the torques of the field.
//!
//! All torques that oppose the shaft: load, axis or coupling to the load side, bearing, cogging, dry friction, and the
//! change of the viscous friction since the start of the record. Resistance, viscous friction and slip change once a
//! sample. On an axis, the load of friction and pulses includes the weight.

use super::mechanics::{LoadSide, Opposing};
use super::slip::SlippingBearing;
use super::units::{Draws, Drive};
use super::{FieldValues, TemperatureValues};
use crate::axis::{Axis, AxisLoad, Travel};
use crate::bearing::direction;
use crate::{DefectTorque, MotorParameters, NoiseSource, Plant, PlantState, RigError, Scenario, Stream};

/// Everything that acts on the shaft of a motor in the field.
#[derive(Debug, Clone)]
pub(crate) struct DriveTrain {
    torques: Torques,
    load_side: Option<LoadSide>,
    axis: Option<AxisLoad>,
    r_ohm: f64,
}

/// Torques that depend on the state of the motor only.
#[derive(Debug, Clone)]
struct Torques {
    values: FieldValues,
    kt_nm_per_a: f64,
    b_nm_s_per_rad: f64,
    law: DefectTorque,
    bearing: Option<SlippingBearing>,
    added_viscous_nm_s_per_rad: f64,
}

impl DriveTrain {
    /// A drive train with the motor `motor` (defect and field included), and the plant of its motor side.
    pub(crate) fn new(
        scenario: &Scenario,
        values: &FieldValues,
        motor: &MotorParameters,
        (start, axis): (PlantState, Option<AxisLoad>),
        seed: u64,
    ) -> Result<Self, RigError> {
        let jitter = NoiseSource::new(seed, Stream::SlipJitter);
        let order = scenario.bearing.orders().outer;
        Ok(Self {
            torques: Torques {
                values: *values,
                kt_nm_per_a: motor.kt_nm_per_a,
                b_nm_s_per_rad: motor.b_nm_s_per_rad,
                law: scenario.defect.torque(motor.kt_nm_per_a, &scenario.bearing)?,
                bearing: values
                    .slip
                    .map(|slip| SlippingBearing::new(slip, jitter, order, start.angle_rad, scenario.sample_time_s)),
                added_viscous_nm_s_per_rad: 0.0,
            },
            load_side: values.mechanics.map(|mechanics| {
                let mut side = LoadSide::new(&mechanics, motor.j_kg_m2, &start);
                if let Some(axis) = &axis {
                    side.hold(start.angle_rad, axis.weight_nm(start.angle_rad));
                }
                side
            }),
            axis,
            r_ohm: motor.r_ohm,
        })
    }

    /// Starts a sampling interval at time `t_s`, whose integration steps last `step_s`.
    pub(crate) fn begin(&mut self, plant: &mut Plant, t_s: f64, step_s: f64) {
        let torques = &mut self.torques;
        let warm =
            |factor: fn(&TemperatureValues, f64) -> f64| torques.values.temperature.map_or(1.0, |t| factor(&t, t_s));
        let (resistance, viscous) = (warm(TemperatureValues::resistance_at), warm(TemperatureValues::viscous_at));
        torques.added_viscous_nm_s_per_rad = torques.b_nm_s_per_rad * (viscous - 1.0);
        plant.retune(self.r_ohm * resistance, step_s);
        if let Some(bearing) = &mut torques.bearing {
            bearing.advance(plant.state().angle_rad);
        }
    }

    /// Simulates one integration step under a commanded voltage and an external load.
    pub(crate) fn step(&mut self, plant: &mut Plant, command_v: f64, load_nm: f64) {
        // The weight hardly changes in a step.
        let weight_nm = self.axis(plant).map(|(axis, angle_rad)| axis.weight_nm(angle_rad));
        let loaded_nm = weight_nm.map_or(load_nm, |weight| load_nm + weight);
        let Self { torques, load_side, axis, .. } = self;
        let voltage_v = match &torques.values.current_chain {
            Some(chain) => chain.applied_v(command_v, &plant.state(), plant.motor(), plant.electrical()),
            None => command_v,
        };
        let step_s = plant.step_s();
        let motor = *plant.motor();
        plant.step_staged(voltage_v, |stage, at| {
            let loaded = |point: [f64; 2]| {
                let axis = axis
                    .map_or(Opposing::plain(load_nm), |axis| axis.opposing(point, load_nm + axis.weight_nm(point[0])));
                let friction = torques.load_friction_nm(loaded_nm, point[1]);
                Opposing { torque_nm: axis.torque_nm + friction, ..axis }
            };
            let on_motor =
                torques.at(at, loaded_nm) + axis.map_or(0.0, |a| a.brake_nm(at.angle_rad, at.velocity_rad_s));
            let outside = match load_side {
                Some(side) => side.stage(stage, at, step_s, loaded),
                None => {
                    let driving = motor.kt_nm_per_a * at.current_a - motor.b_nm_s_per_rad * at.velocity_rad_s;
                    loaded([at.angle_rad, at.velocity_rad_s]).on_stiff_shaft(driving - on_motor, motor.j_kg_m2)
                }
            };
            outside + on_motor
        });
        if let Some(axis) = axis {
            axis.settle(plant.state().angle_rad);
        }
    }

    /// The axis and the angle of its load side.
    pub(crate) fn axis(&mut self, plant: &Plant) -> Option<(&mut AxisLoad, f64)> {
        let angle_rad = self.load_side.map_or(plant.state().angle_rad, |side| side.angle_rad());
        self.axis.as_mut().map(|axis| (axis, angle_rad))
    }
}

/// The axis of a record, by the angle of the motor at φ = 0 and the inertia of the whole.
pub(crate) fn axis(axis: &Axis, drive: Option<Drive>, at: [f64; 2], seed: u64) -> AxisLoad {
    let gear = Draws { seed, drive }.of_drive(Stream::Gear);
    AxisLoad::new(axis, Travel::rotary(axis.ratio), at, gear)
}

impl Torques {
    fn load_friction_nm(&self, load_nm: f64, velocity_rad_s: f64) -> f64 {
        self.values.load_friction.map_or(0.0, |friction| friction.torque_nm(load_nm, velocity_rad_s))
    }

    fn at(&self, at: &PlantState, load_nm: f64) -> f64 {
        let defect = match &self.bearing {
            Some(bearing) => bearing.torque_nm(&self.law, at, load_nm),
            None => self.law.at(at),
        };
        let magnetic = self.values.magnetics.as_ref().map_or(0.0, |m| m.torque_nm(at, self.kt_nm_per_a));
        defect + magnetic + self.dry_nm(at.velocity_rad_s) + self.added_viscous_nm_s_per_rad * at.velocity_rad_s
    }

    /// Coulomb and Stribeck friction.
    fn dry_nm(&self, velocity_rad_s: f64) -> f64 {
        let FieldValues { temperature, stribeck, .. } = &self.values;
        if temperature.is_none() && stribeck.is_none() {
            return 0.0;
        }
        let coulomb = temperature.map_or(0.0, |t| t.coulomb_nm);
        let dry = coulomb + stribeck.map_or(0.0, |s| s.magnitude_nm(velocity_rad_s));
        self.values.constants().coulomb * dry * direction(velocity_rad_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RigTrace;
    use crate::field::tests::{QUIET, run};
    use crate::field::{Duty, Field, Mechanics};

    /// Kt i − B ω and dω/dt at a sample of a trace of [`TABLE_2_3`](crate::TABLE_2_3).
    fn balance(trace: &RigTrace, k: usize) -> [f64; 2] {
        let slope = (trace.velocity_rad_s[k + 1] - trace.velocity_rad_s[k - 1]) / 0.004;
        [0.05 * trace.current_a[k] - 1e-4 * trace.velocity_rad_s[k], slope]
    }

    #[test]
    fn motor_and_load_side_accelerate_together_with_the_payload() {
        let mechanics = Mechanics { backlash_deg: [0.0; 2], ..Mechanics::FIELD };
        let field = Field { mechanics: Some(mechanics), ..Field::NONE };
        // 1 Hz, far below the resonance.
        let rigid = Scenario { duty: Duty::Waveform, reference_frequency_hz: 1.0, ..QUIET };
        // Least squares of the torque on dω/dt over nine whole periods.
        let inertia = |trace: &RigTrace| {
            let sums = (400..4900).map(|k| balance(trace, k)).fold([0.0; 2], |[product, square], [torque, slope]| {
                [product + torque * slope, square + slope * slope]
            });
            sums[0] / sums[1]
        };
        for seed in 0..3 {
            let scenario = Scenario { field, ..rigid };
            let payload = FieldValues::draw(&scenario, seed).mechanics.expect("on").payload;
            let ratio = inertia(&run(&scenario, seed)) / inertia(&run(&rigid, seed));
            // The load side moves by 1/(1 − (1 Hz/23 Hz)²) more than the motor, 23 Hz being the lowest resonance with
            // the motor held: 0.2 % of 40 % of the inertia. The lags of the samples change an inertia by 0.24 % in the
            // rigid rig, and by less than half as much between two payloads.
            assert!((ratio / payload - 1.0).abs() < 2e-3, "{ratio} {payload}");
        }
    }

    #[test]
    fn the_load_reaches_the_motor_through_the_spring() {
        let field = Field { mechanics: Some(Mechanics::FIELD), ..Field::NONE };
        // 0.25 Hz: peaks at 5 s (positive) and 7 s (negative), where the load does not change.
        let scenario = Scenario { field, load_amplitude_nm: 0.15, load_frequency_hz: 0.25, ..QUIET };
        let inertia = FieldValues::draw(&scenario, 7).motor(&scenario.motor).j_kg_m2;
        let trace = run(&scenario, 7);
        for (sample, load) in [(2500, 0.15), (3500, -0.15)] {
            let [torque, slope] = balance(&trace, sample);
            // The measured current lags by 1.6 ms. The load is at its peak, so this is second order in the load; the
            // acceleration, at most 4 rad/s², changes by 1 % in this time: 1e-5 N·m.
            assert!((torque - inertia * slope - load).abs() < 2e-5, "{torque} {slope}");
        }
    }
}
