//! The values of all effects in one record.

use super::units::Draws;
use super::{
    Constants, CurrentChainValues, LoadFrictionValues, LoadMeasurement, LoadSensorValues, MagneticsValues,
    MechanicsValues, ResolverValues, SlipValues, StribeckValues, TemperatureValues,
};
use crate::{MotorParameters, Scenario, Stream};

/// The values that a record has drawn; `None` for an effect that is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldValues {
    /// Temperature.
    pub temperature: Option<TemperatureValues>,
    /// Stribeck friction.
    pub stribeck: Option<StribeckValues>,
    /// Load-proportional friction.
    pub load_friction: Option<LoadFrictionValues>,
    /// Torques that depend on the angle.
    pub magnetics: Option<MagneticsValues>,
    /// Angle sensor.
    pub resolver: Option<ResolverValues>,
    /// Load sensor.
    pub load_sensor: Option<LoadSensorValues>,
    /// Payload, compliance and backlash.
    pub mechanics: Option<MechanicsValues>,
    /// Current measurement and bridge.
    pub current_chain: Option<CurrentChainValues>,
    /// Slip.
    pub slip: Option<SlipValues>,
    /// Differences between drives and sessions.
    pub constants: Option<Constants>,
}

impl FieldValues {
    /// The values of the record of this scenario with this seed. Each effect draws from a stream of its own, so
    /// switching one effect on does not change what the others draw.
    #[must_use]
    pub fn draw(scenario: &Scenario, seed: u64) -> Self {
        let field = &scenario.field;
        let draws = Draws { seed, drive: scenario.drive };
        let load_sensor = match field.load {
            LoadMeasurement::Sensor(sensor) => Some(sensor.draw(draws.of_drive(Stream::LoadSensor))),
            LoadMeasurement::Exact | LoadMeasurement::Absent => None,
        };
        Self {
            temperature: field.temperature.map(|t| t.draw(draws.of_record(Stream::Temperature))),
            stribeck: field.stribeck.map(|s| s.draw(draws.of_drive(Stream::Stribeck))),
            load_friction: field.load_friction.map(|f| f.draw(draws.of_drive(Stream::LoadFriction))),
            magnetics: field.magnetics.map(|m| m.draw(draws.of_drive(Stream::Magnetics))),
            resolver: field.resolver.map(|r| r.draw(draws.of_drive(Stream::Resolver))),
            load_sensor,
            mechanics: scenario
                .axis
                .and_then(|axis| axis.transmission)
                .or(field.mechanics)
                .map(|m| m.draw(draws.of_record(Stream::Payload), draws.of_drive(Stream::Mechanics))),
            current_chain: field.current_chain.map(|c| c.draw(draws.of_drive(Stream::CurrentChain))),
            slip: field.slip.map(|s| s.draw(draws.of_record(Stream::Slip))),
            constants: field.units.map(|units| units.draw(draws)),
        }
    }

    /// The factors of drive and session.
    #[must_use]
    pub fn constants(&self) -> Constants {
        self.constants.unwrap_or(Constants::NOMINAL)
    }

    /// The motor at the start of the record, with its whole inertia; bit for bit `nominal` if all effects are off.
    #[must_use]
    pub fn motor(&self, nominal: &MotorParameters) -> MotorParameters {
        let constants = self.constants();
        let warm = |factor: fn(&TemperatureValues) -> f64| self.temperature.as_ref().map_or(1.0, factor);
        let flux = constants.flux * warm(|t| t.flux);
        MotorParameters {
            kt_nm_per_a: nominal.kt_nm_per_a * flux,
            ke_v_s_per_rad: nominal.ke_v_s_per_rad * flux,
            r_ohm: nominal.r_ohm * (constants.resistance * warm(|t| t.resistance)),
            l_h: nominal.l_h,
            j_kg_m2: nominal.j_kg_m2 * (constants.inertia * self.mechanics.map_or(1.0, |m| m.payload)),
            b_nm_s_per_rad: nominal.b_nm_s_per_rad * (constants.viscous * warm(|t| t.viscous)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Field, Magnetics, Resolver, Temperature};

    #[test]
    fn one_effect_draws_the_same_whatever_else_is_on() {
        let all = FieldValues::draw(&Scenario { field: Field::ALL, ..Scenario::STANDARD }, 8);
        let one = |field: Field| FieldValues::draw(&Scenario { field, ..Scenario::STANDARD }, 8);
        let temperature = one(Field { temperature: Some(Temperature::FIELD), ..Field::NONE });
        assert_eq!(temperature.temperature, all.temperature);
        let magnetics = one(Field { magnetics: Some(Magnetics::FIELD), ..Field::NONE });
        assert_eq!(magnetics.magnetics, all.magnetics);
        let resolver = one(Field { resolver: Some(Resolver::FIELD), ..Field::NONE });
        assert_eq!((resolver.resolver, resolver.magnetics), (all.resolver, None));
    }

    #[test]
    fn the_motor_has_all_factors_and_none_by_default() {
        let standard = Scenario::STANDARD;
        assert_eq!(FieldValues::draw(&standard, 1).motor(&standard.motor), standard.motor);
        let values = FieldValues::draw(&Scenario { field: Field::ALL, ..standard }, 1);
        let (t, c) = (values.temperature.expect("on"), values.constants());
        let motor = values.motor(&standard.motor);
        let payload = values.mechanics.expect("on").payload;
        let ratios = [
            motor.r_ohm / 0.5 / (c.resistance * t.resistance),
            motor.kt_nm_per_a / 0.05 / (c.flux * t.flux),
            motor.ke_v_s_per_rad / 0.05 / (c.flux * t.flux),
            motor.j_kg_m2 / 2.5e-4 / (c.inertia * payload),
            motor.b_nm_s_per_rad / 1e-4 / (c.viscous * t.viscous),
        ];
        // Rounding only.
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 1e-15), "{ratios:?}");
    }
}
