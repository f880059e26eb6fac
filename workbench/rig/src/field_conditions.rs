//! Named conditions for the effects of the field, each on top of [`Condition::MIX`].

use super::Condition;
use super::field::{
    CurrentChain, Duty, Field, LoadFriction, LoadMeasurement, LoadSensor, Magnetics, Mechanics, Missing, Resolver,
    SampleJitter, Slip, Stribeck, Temperature, Units,
};

impl Condition {
    /// One effect of the field, one duty, or all effects together.
    pub const FIELD: [Self; 26] = [
        Self {
            name: "temperature",
            number: 18,
            about: "cold to hot drives: resistance, flux and friction, with warm-up",
            field: Some(&Field { temperature: Some(Temperature::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "load-friction",
            number: 19,
            about: "friction in proportion to the load",
            field: Some(&Field { load_friction: Some(LoadFriction::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "stribeck",
            number: 20,
            about: "Stribeck friction and break-away",
            field: Some(&Field { stribeck: Some(Stribeck::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "cogging",
            number: 21,
            about: "cogging, ripple of the torque constant and unbalance",
            field: Some(&Field { magnetics: Some(Magnetics::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "angle-errors",
            number: 22,
            about: "errors and resolution of the angle, velocity from its differences",
            field: Some(&Field { resolver: Some(Resolver::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "bad-load-sensor",
            number: 23,
            about: "load sensor with gain, offset, noise and delay",
            field: Some(&Field { load: LoadMeasurement::Sensor(LoadSensor::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "no-load-sensor",
            number: 24,
            about: "load torque not recorded",
            field: Some(&Field { load: LoadMeasurement::Absent, ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "payload",
            number: 25,
            about: "inertia of the payload, compliance and backlash",
            field: Some(&Field { mechanics: Some(Mechanics::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "current-chain",
            number: 26,
            about: "offset, gain, resolution and ripple of the current, dead time",
            field: Some(&Field { current_chain: Some(CurrentChain::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "slip",
            number: 27,
            about: "balls that slip, pulses of any width that grow with the load",
            field: Some(&Field { slip: Some(Slip::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "slip-300-turns",
            number: 28,
            about: "the same at a reference of 300 rad/s: about 300 turns a record",
            reference_amplitude: 7.5,
            field: Some(&Field { slip: Some(Slip::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "duty-steps",
            number: 29,
            about: "steps between random velocities",
            duty: Some(Duty::RandomSteps),
            ..Self::MIX
        },
        Self {
            name: "duty-trapezoids",
            number: 30,
            about: "trapezoids in both directions with standstill",
            duty: Some(Duty::Trapezoids),
            ..Self::MIX
        },
        Self {
            name: "duty-set-points",
            number: 31,
            about: "ramps between random velocities",
            duty: Some(Duty::SetPoints),
            ..Self::MIX
        },
        Self {
            name: "duty-one-way",
            number: 32,
            about: "modulated velocity of one direction",
            duty: Some(Duty::OneWay),
            ..Self::MIX
        },
        Self {
            name: "duty-constant",
            number: 33,
            about: "constant velocity",
            duty: Some(Duty::ConstantSpeed),
            ..Self::MIX
        },
        Self {
            name: "duty-any",
            number: 34,
            about: "each trace has one of the six duties",
            duty: Some(Duty::Any),
            ..Self::MIX
        },
        Self {
            name: "missing-1-percent",
            number: 35,
            about: "one sample in a hundred is missing, at random",
            field: Some(&Field { missing: Some(Missing::Random { rate: 0.01 }), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "missing-periodic",
            number: 36,
            about: "every hundredth sample is missing",
            field: Some(&Field { missing: Some(Missing::Periodic { every: 100 }), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "missing-bursts",
            number: 37,
            about: "one sample in a hundred is missing, in runs of 20",
            field: Some(&Field { missing: Some(Missing::Bursts { rate: 0.01, samples: 20 }), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "sampling-jitter",
            number: 38,
            about: "sampling instants off by up to a tenth of the interval",
            field: Some(&Field { jitter: Some(SampleJitter::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "field-sine",
            number: 39,
            about: "all effects of the field together, sine reference",
            field: Some(&Field::ALL),
            ..Self::MIX
        },
        Self {
            name: "field-duties",
            number: 40,
            about: "all effects of the field together, one of the four duties that reverse",
            field: Some(&Field::ALL),
            duty: Some(Duty::AnyReversing),
            ..Self::MIX
        },
        Self {
            name: "field-any",
            number: 41,
            about: "all effects of the field together, one of the six duties",
            field: Some(&Field::ALL),
            duty: Some(Duty::Any),
            ..Self::MIX
        },
        Self {
            name: "units",
            number: 42,
            about: "each trace is another drive on another day",
            field: Some(&Field { units: Some(Units::FIELD), ..Field::NONE }),
            ..Self::MIX
        },
        Self {
            name: "field-stiff",
            number: 43,
            about: "all effects of field-sine but compliance, backlash and payload",
            field: Some(&Field { mechanics: None, ..Field::ALL }),
            ..Self::MIX
        },
    ];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RigTrace, Scenario, simulate};

    fn under(name: &str, seed: u64) -> Scenario {
        Condition::named(name).expect("known").apply(Scenario::STANDARD, seed)
    }

    #[test]
    fn each_is_mix_with_one_effect() {
        for (number, condition) in (18..).zip(Condition::FIELD) {
            assert_eq!(condition.number, number);
            let scenario = under(condition.name, 5);
            let effect = scenario.field != Field::NONE;
            let duty = scenario.duty != Duty::Waveform;
            assert!(effect || duty, "{}", condition.name);
            assert_eq!(effect && duty, ["field-duties", "field-any"].contains(&condition.name));
            let plain = Scenario { field: Field::NONE, duty: Duty::Waveform, ..scenario };
            if condition.name == "slip-300-turns" {
                // 7.5 is exact, and both products are rounded once.
                let factor = plain.reference_amplitude_rad_s / Scenario::STANDARD.mixed(5).reference_amplitude_rad_s;
                assert!((factor - 7.5).abs() < 1e-14);
            } else {
                assert_eq!(plain, Scenario::STANDARD.mixed(5), "{}", condition.name);
            }
        }
        assert_eq!(under("field-any", 1).field, Field::ALL);
        assert_eq!(under("temperature", 1).field, Field { temperature: Some(Temperature::FIELD), ..Field::NONE });
    }

    #[test]
    fn each_changes_the_trace_of_mix_and_what_it_names() {
        let trace = |name: &str| simulate(&under(name, 3), 3).expect("valid");
        let mix = trace("mix");
        for condition in Condition::FIELD {
            // Slip changes nothing without a spall.
            assert_eq!(trace(condition.name) == mix, condition.name == "slip", "{}", condition.name);
        }
        let sensor = trace("bad-load-sensor");
        assert_ne!(sensor.load_torque_nm, mix.load_torque_nm);
        assert_eq!(RigTrace { load_torque_nm: mix.load_torque_nm.clone(), ..sensor }, mix);
    }

    #[test]
    fn a_fast_reference_has_about_three_hundred_turns() {
        let turns = |seed: u64| {
            let trace = simulate(&under("slip-300-turns", seed), seed).expect("valid");
            let travel: f64 = trace.angle_rad.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
            travel / core::f64::consts::TAU
        };
        let mean = (0..20).map(turns).sum::<f64>() / 20.0;
        // 300 rad/s · 2/π · 10 s = 304 turns, times 1.05 (the mean of × 0.6–1.5); its scatter over 20 is 0.26/√20.
        assert!((mean / 319.0 - 1.0).abs() < 0.24, "{mean}");
    }
}
