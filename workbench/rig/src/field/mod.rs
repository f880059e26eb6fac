//! Effects that drives in the field have and the standard rig does not have.
//!
//! Each effect is a field of [`Field`] with its ranges; it is off by default. A record draws its values from streams of
//! its seed, one stream for each effect; [`FieldValues::draw`] returns them. [`Scenario::duty`](super::Scenario::duty)
//! is the kind of the velocity reference, and [`Scenario::drive`](super::Scenario::drive) names the drive if several
//! records belong to one.
//!
//! | module | effect |
//! |---|---|
//! | [`temperature`] | resistance, flux, viscous and Coulomb friction; warm-up within the record |
//! | [`friction`] | Stribeck friction, friction in proportion to the load |
//! | [`magnetics`] | cogging, ripple of the torque constant, unbalance |
//! | [`angle`] | errors and resolution of the angle, velocity from its differences |
//! | [`load_sensor`] | gain, offset, noise and delay of the load sensor, or no load sensor |
//! | [`mechanics`] | inertia of the payload, compliance, backlash |
//! | [`current_chain`] | offset, gain, resolution and ripple of the measured current, dead time of the bridge |
//! | [`slip`] | slip of the balls, width of the pulses, pulses that grow with the load |
//! | [`duty`] | steps, trapezoids, set points, one direction, constant speed |
//! | [`sampling`] | missing samples, jitter of the sampling instants |
//! | [`units`] | differences between drives and from day to day |
//! | [`values`] | the values of all effects in one record |
//!
//! ```
//! use bearing_watch_rig::field::{Field, FieldValues, Temperature};
//! use bearing_watch_rig::{Duty, Scenario, simulate};
//!
//! let warm = Field { temperature: Some(Temperature::FIELD), ..Field::NONE };
//! let scenario = Scenario { field: warm, duty: Duty::Trapezoids, samples: 500, ..Scenario::STANDARD };
//! let values = FieldValues::draw(&scenario, 7).temperature.expect("switched on");
//! assert!((0.0..1.0).contains(&values.state));
//! assert_eq!(simulate(&scenario, 7)?.voltage_v.len(), 500);
//! # Ok::<(), bearing_watch_rig::RigError>(())
//! ```

pub mod angle;
pub mod current_chain;
pub(super) mod draws;
mod drive_train;
pub mod duty;
pub mod friction;
pub mod load_sensor;
pub mod magnetics;
pub mod mechanics;
mod profile;
pub mod sampling;
pub mod slip;
pub mod temperature;
pub mod units;
pub mod values;

pub(super) use angle::DifferencedVelocity;
pub use angle::{Resolver, ResolverValues};
pub use current_chain::{CurrentChain, CurrentChainValues};
pub(super) use drive_train::{DriveTrain, axis};
pub use duty::Duty;
pub use friction::{LoadFriction, LoadFrictionValues, Stribeck, StribeckValues};
pub use load_sensor::{LoadMeasurement, LoadSensor, LoadSensorValues};
pub use magnetics::{Magnetics, MagneticsValues};
pub(super) use mechanics::{LoadSide, Opposing};
pub use mechanics::{Mechanics, MechanicsValues};
pub(super) use profile::Profile;
pub(super) use sampling::Clock;
pub use sampling::{Missing, SampleJitter};
pub use slip::{Slip, SlipValues};
pub use temperature::{Temperature, TemperatureValues};
pub use units::{Constants, Drive, Units};
pub use values::FieldValues;

use super::RigError;

/// Effects of the field with their ranges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// Temperature and warm-up.
    pub temperature: Option<Temperature>,
    /// Stribeck friction and break-away.
    pub stribeck: Option<Stribeck>,
    /// Friction in proportion to the load.
    pub load_friction: Option<LoadFriction>,
    /// Cogging, ripple of the torque constant, unbalance.
    pub magnetics: Option<Magnetics>,
    /// Angle sensor; if it is off, the angle is exact and the velocity has white noise.
    pub resolver: Option<Resolver>,
    /// Measurement of the load.
    pub load: LoadMeasurement,
    /// Payload, compliance and backlash.
    pub mechanics: Option<Mechanics>,
    /// Measurement of the current, and dead time.
    pub current_chain: Option<CurrentChain>,
    /// Slip and shape of the spall's pulses.
    pub slip: Option<Slip>,
    /// Missing samples.
    pub missing: Option<Missing>,
    /// Jitter of the sampling instants.
    pub jitter: Option<SampleJitter>,
    /// Differences between drives and sessions.
    pub units: Option<Units>,
}

impl Field {
    /// All effects off.
    pub const NONE: Self = Self {
        temperature: None,
        stribeck: None,
        load_friction: None,
        magnetics: None,
        resolver: None,
        load: LoadMeasurement::Exact,
        mechanics: None,
        current_chain: None,
        slip: None,
        missing: None,
        jitter: None,
        units: None,
    };

    /// All effects on; the load is measured and no sample is missing.
    pub const ALL: Self = Self {
        temperature: Some(Temperature::FIELD),
        stribeck: Some(Stribeck::FIELD),
        load_friction: Some(LoadFriction::FIELD),
        magnetics: Some(Magnetics::FIELD),
        resolver: Some(Resolver::FIELD),
        load: LoadMeasurement::Sensor(LoadSensor::FIELD),
        mechanics: Some(Mechanics::FIELD),
        current_chain: Some(CurrentChain::FIELD),
        slip: Some(Slip::FIELD),
        missing: None,
        jitter: Some(SampleJitter::FIELD),
        units: Some(Units::FIELD),
    };

    /// Returns an error with the name of the range that cannot be simulated at this sampling interval.
    pub fn validate(&self, sample_time_s: f64) -> Result<(), RigError> {
        self.temperature.map_or(Ok(()), |effect| effect.validate())?;
        self.stribeck.map_or(Ok(()), |effect| effect.validate())?;
        self.load_friction.map_or(Ok(()), |effect| effect.validate())?;
        self.magnetics.map_or(Ok(()), |effect| effect.validate())?;
        self.resolver.map_or(Ok(()), |effect| effect.validate(sample_time_s))?;
        if let LoadMeasurement::Sensor(sensor) = self.load {
            sensor.validate()?;
        }
        self.mechanics.map_or(Ok(()), |effect| effect.validate())?;
        self.current_chain.map_or(Ok(()), |effect| effect.validate())?;
        self.slip.map_or(Ok(()), |effect| effect.validate())?;
        self.missing.map_or(Ok(()), |effect| effect.validate())?;
        self.jitter.map_or(Ok(()), |effect| effect.validate())?;
        self.units.map_or(Ok(()), |effect| effect.validate())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{Duty, RigTrace, Scenario, simulate};

    /// A healthy motor at a constant speed without noise and load.
    pub(crate) const QUIET: Scenario = Scenario {
        duty: Duty::ConstantSpeed,
        load_amplitude_nm: 0.0,
        load_fluctuation_nm: 0.0,
        current_noise_a: 0.0,
        velocity_noise_rad_s: 0.0,
        ..Scenario::STANDARD
    };

    pub(crate) fn run(scenario: &Scenario, seed: u64) -> RigTrace {
        simulate(scenario, seed).expect("valid scenario")
    }

    /// Mean and standard deviation.
    pub(crate) fn moments(x: &[f64]) -> (f64, f64) {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        (mean, (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
    }

    #[test]
    fn all_effects_together_can_be_simulated() {
        for seed in 0..6 {
            let scenario = Scenario { field: Field::ALL, duty: Duty::Any, samples: 1000, ..Scenario::STANDARD };
            let trace = run(&scenario, seed);
            for (name, column) in trace.recorded() {
                assert!(column.len() == 1000 && column.iter().all(|x| x.is_finite()), "{name}");
            }
            assert_eq!(trace, run(&scenario, seed));
        }
    }

    #[test]
    fn impossible_ranges_are_refused_by_name() {
        let refused = |field: Field| Scenario { field, ..QUIET }.validate().expect_err("impossible").to_string();
        let cold = Temperature { viscous_cold: 0.0, ..Temperature::FIELD };
        let message = refused(Field { temperature: Some(cold), ..Field::NONE });
        assert_eq!(message, "field.temperature.viscous_cold must be positive, got 0");
        // The Nyquist frequency of the rig is 250 Hz.
        let fast = Resolver { cutoff_hz: 250.0, ..Resolver::FIELD };
        let message = refused(Field { resolver: Some(fast), ..Field::NONE });
        assert_eq!(message, "field.resolver.cutoff_hz must lie between 0 and 245, got 250");
        let wild = SampleJitter { fraction: f64::NAN };
        assert!(refused(Field { jitter: Some(wild), ..Field::NONE }).contains("field.jitter.fraction"));
        let none = Missing::Periodic { every: 0 };
        assert!(refused(Field { missing: Some(none), ..Field::NONE }).contains("field.missing.every"));
    }
}
