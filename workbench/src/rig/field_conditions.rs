//! Named conditions for the effects of the field, each on top of [`Condition::MIX`].

use super::Condition;
use super::field::{
    CurrentChain, Duty, Field, LoadFriction, LoadMeasurement, LoadSensor, Magnetics, Mechanics, Missing, Resolver,
    SampleJitter, Slip, Stribeck, Temperature, Units,
};

impl Condition {
    /// One effect of the field, one duty, or all effects together.
    pub const FIELD: [Self; 25] = [
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
    ];
}
