//! The motor with the torques of the field.
//!
//! All torques that oppose the shaft: load or coupling to the load side, bearing, cogging, dry friction, and the change of
//! the viscous friction since the start of the record. Resistance, viscous friction and slip change once a sample.

use super::mechanics::LoadSide;
use super::slip::SlippingBearing;
use super::{FieldValues, TemperatureValues};
use crate::rig::bearing::direction;
use crate::rig::{DefectTorque, MotorParameters, NoiseSource, Plant, PlantState, RigError, Scenario, Stream};

/// Everything that acts on the shaft of a motor in the field.
#[derive(Debug, Clone)]
pub(in crate::rig) struct DriveTrain {
    torques: Torques,
    load_side: Option<LoadSide>,
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
    pub(in crate::rig) fn new(
        scenario: &Scenario,
        values: &FieldValues,
        motor: &MotorParameters,
        start: PlantState,
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
            load_side: values.mechanics.map(|mechanics| LoadSide::new(&mechanics, motor.j_kg_m2, &start)),
            r_ohm: motor.r_ohm,
        })
    }

    /// Starts a sampling interval at time `t_s`, whose integration steps last `step_s`.
    pub(in crate::rig) fn begin(&mut self, plant: &mut Plant, t_s: f64, step_s: f64) {
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
    pub(in crate::rig) fn step(&mut self, plant: &mut Plant, command_v: f64, load_nm: f64) {
        let Self { torques, load_side, .. } = self;
        let voltage_v = match &torques.values.current_chain {
            Some(chain) => chain.applied_v(command_v, &plant.state(), plant.motor(), plant.electrical()),
            None => command_v,
        };
        let step_s = plant.step_s();
        plant.step_staged(voltage_v, |stage, at| {
            let loaded = |velocity_rad_s: f64| load_nm + torques.load_friction_nm(load_nm, velocity_rad_s);
            let outside = match load_side {
                Some(side) => side.stage(stage, at, step_s, loaded),
                None => loaded(at.velocity_rad_s),
            };
            outside + torques.at(at, load_nm)
        });
    }
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
