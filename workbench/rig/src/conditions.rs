//! Named conditions: changes of the scenario on which a detector was trained.
//!
//! [`Condition::apply`] takes a [`Scenario`] and the seed of a trace, and returns the scenario under the [`Condition`].
//! Factors multiply the values of the scenario, so a condition can be applied to any scenario; physical values in the
//! comments below are those of [`Scenario::STANDARD`].

use super::axis::Axis;
use super::field::{Duty, Field};
use super::{Scenario, SignalLevels, Waveform};

/// Sizes of a defect, in descending order from full size.
pub const SEVERITIES: [f64; 9] =
    [1.0, 1.0 / 2.0, 1.0 / 4.0, 1.0 / 5.0, 1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0, 1.0 / 64.0, 1.0 / 128.0];

/// A named change of a scenario. New conditions are struct literals based on [`Condition::STANDARD`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// Name on the command line, in labels and reports.
    pub name: &'static str,
    /// Unique number that must not change when conditions are added, because seeds depend on it.
    pub number: u8,
    /// Short description.
    pub about: &'static str,
    /// Shape of the reference, if changed.
    pub reference_waveform: Option<Waveform>,
    /// Factor of the reference's amplitude.
    pub reference_amplitude: f64,
    /// Factor of the reference's frequency.
    pub reference_frequency: f64,
    /// Factor of the amplitude of the sinusoidal load.
    pub load_amplitude: f64,
    /// Factor of the load's frequency.
    pub load_frequency: f64,
    /// Factor of the armature resistance.
    pub resistance: f64,
    /// Measurement noise in decibels below [`SignalLevels::STANDARD`], if changed.
    pub signal_to_noise_db: Option<f64>,
    /// Effects of the field, if changed.
    pub field: Option<&'static Field>,
    /// Kind of the reference, if changed.
    pub duty: Option<Duty>,
    /// The axis of a machine, if the motor moves one.
    pub axis: Option<&'static Axis>,
    /// If true, each trace additionally draws random conditions, see [`Scenario::mixed`].
    pub mixed: bool,
}

impl Condition {
    /// The unchanged scenario.
    pub const STANDARD: Self = Self {
        name: "standard",
        number: 0,
        about: "nothing",
        reference_waveform: None,
        reference_amplitude: 1.0,
        reference_frequency: 1.0,
        load_amplitude: 1.0,
        load_frequency: 1.0,
        resistance: 1.0,
        signal_to_noise_db: None,
        field: None,
        duty: None,
        axis: None,
        mixed: false,
    };

    /// Every trace has its own random conditions.
    pub const MIX: Self = Self {
        name: "mix",
        number: 1,
        about: "reference, load, resistance and inertia drawn anew for each trace",
        mixed: true,
        ..Self::STANDARD
    };

    /// Changed reference: amplitude × 0.5–2, frequency × 0.5–2, triangle, square.
    pub const EXCITATION: [Self; 8] = [
        Self {
            name: "amplitude-0.5",
            number: 2,
            about: "reference of 20 rad/s",
            reference_amplitude: 0.5,
            ..Self::STANDARD
        },
        Self {
            name: "amplitude-0.6",
            number: 3,
            about: "reference of 24 rad/s",
            reference_amplitude: 0.6,
            ..Self::STANDARD
        },
        Self {
            name: "amplitude-1.5",
            number: 4,
            about: "reference of 60 rad/s",
            reference_amplitude: 1.5,
            ..Self::STANDARD
        },
        Self {
            name: "amplitude-2",
            number: 5,
            about: "reference of 80 rad/s",
            reference_amplitude: 2.0,
            ..Self::STANDARD
        },
        Self {
            name: "frequency-0.5",
            number: 6,
            about: "reference of 0.1 Hz",
            reference_frequency: 0.5,
            ..Self::STANDARD
        },
        Self {
            name: "frequency-2",
            number: 7,
            about: "reference of 0.4 Hz",
            reference_frequency: 2.0,
            ..Self::STANDARD
        },
        Self {
            name: "triangle",
            number: 8,
            about: "triangular reference of the same peak",
            reference_waveform: Some(Waveform::Triangle),
            ..Self::STANDARD
        },
        Self {
            name: "square",
            number: 9,
            about: "square reference of the same peak",
            reference_waveform: Some(Waveform::Square),
            ..Self::STANDARD
        },
    ];

    /// Changed load: 0.10 and 0.20 N·m, 1 Hz.
    pub const LOAD: [Self; 3] = [
        Self { name: "load-0.67", number: 10, about: "load of 0.10 N·m", load_amplitude: 2.0 / 3.0, ..Self::STANDARD },
        Self { name: "load-1.33", number: 11, about: "load of 0.20 N·m", load_amplitude: 4.0 / 3.0, ..Self::STANDARD },
        Self { name: "load-frequency-2", number: 12, about: "load of 1 Hz", load_frequency: 2.0, ..Self::STANDARD },
    ];

    /// A colder and a warmer winding: R 0.45 and 0.55 Ω.
    pub const RESISTANCE: [Self; 2] = [
        Self { name: "resistance-0.9", number: 13, about: "R of 0.45 Ω", resistance: 0.9, ..Self::STANDARD },
        Self { name: "resistance-1.1", number: 14, about: "R of 0.55 Ω", resistance: 1.1, ..Self::STANDARD },
    ];

    /// Changed measurement noise.
    pub const NOISE: [Self; 3] = [
        Self {
            name: "noise-30-db",
            number: 15,
            about: "current and velocity noise 30 dB below the signals",
            signal_to_noise_db: Some(30.0),
            ..Self::STANDARD
        },
        Self {
            name: "noise-20-db",
            number: 16,
            about: "current and velocity noise 20 dB below the signals",
            signal_to_noise_db: Some(20.0),
            ..Self::STANDARD
        },
        Self {
            name: "noise-10-db",
            number: 17,
            about: "current and velocity noise 10 dB below the signals",
            signal_to_noise_db: Some(10.0),
            ..Self::STANDARD
        },
    ];

    /// All conditions: those of this module, and then [`Condition::FIELD`] and [`Condition::AXES`].
    pub fn all() -> impl Iterator<Item = Self> {
        let shifts = Self::EXCITATION.into_iter().chain(Self::LOAD).chain(Self::RESISTANCE);
        [Self::STANDARD, Self::MIX].into_iter().chain(shifts).chain(Self::NOISE).chain(Self::FIELD).chain(Self::AXES)
    }

    /// The condition with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|condition| condition.name == name)
    }

    /// Returns `scenario` under this condition; random conditions are drawn from `seed`, the seed of the trace.
    #[must_use]
    pub fn apply(&self, scenario: Scenario, seed: u64) -> Scenario {
        let mut changed = scenario;
        changed.reference_waveform = self.reference_waveform.unwrap_or(scenario.reference_waveform);
        changed.reference_amplitude_rad_s *= self.reference_amplitude;
        changed.reference_frequency_hz *= self.reference_frequency;
        changed.load_amplitude_nm *= self.load_amplitude;
        changed.load_frequency_hz *= self.load_frequency;
        changed.motor.r_ohm *= self.resistance;
        changed.field = self.field.copied().unwrap_or(scenario.field);
        changed.duty = self.duty.unwrap_or(scenario.duty);
        if let Some(decibels) = self.signal_to_noise_db {
            changed = changed.with_signal_to_noise(SignalLevels::STANDARD, decibels);
        }
        if let Some(axis) = self.axis {
            changed = changed.with_axis(*axis);
        }
        if self.mixed { changed.mixed(seed) } else { changed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn under(name: &str) -> Scenario {
        Condition::named(name).expect("known").apply(Scenario::STANDARD, 5)
    }

    #[test]
    fn names_and_numbers_are_distinct() {
        let all: Vec<Condition> = Condition::all().collect();
        assert_eq!(all.len(), 18 + 26 + 8);
        for (k, one) in all.iter().enumerate() {
            assert_eq!(Condition::named(one.name), Some(*one));
            for other in &all[..k] {
                assert!(one.name != other.name && one.number != other.number, "{} {}", one.name, other.name);
            }
        }
        assert_eq!(Condition::named("Standard"), None);
    }

    #[test]
    fn each_changes_what_its_note_says_and_nothing_else() {
        let standard = Scenario::STANDARD;
        assert_eq!(under("standard"), standard);
        assert_eq!(under("mix"), standard.mixed(5));
        for (name, rad_s) in
            [("amplitude-0.5", 20.0), ("amplitude-0.6", 24.0), ("amplitude-1.5", 60.0), ("amplitude-2", 80.0)]
        {
            assert_eq!(under(name), Scenario { reference_amplitude_rad_s: rad_s, ..standard });
        }
        for (name, hz) in [("frequency-0.5", 0.1), ("frequency-2", 0.4)] {
            assert_eq!(under(name), Scenario { reference_frequency_hz: hz, ..standard });
        }
        for (name, shape) in [("triangle", Waveform::Triangle), ("square", Waveform::Square)] {
            assert_eq!(under(name), Scenario { reference_waveform: shape, ..standard });
        }
        for (name, nm) in [("load-0.67", 0.10), ("load-1.33", 0.20)] {
            let changed = under(name);
            // 2/3 and 4/3 are rounded.
            assert!((changed.load_amplitude_nm - nm).abs() < 1e-15);
            assert_eq!(Scenario { load_amplitude_nm: 0.15, ..changed }, standard);
        }
        assert_eq!(under("load-frequency-2"), Scenario { load_frequency_hz: 1.0, ..standard });
        for (name, ohm) in [("resistance-0.9", 0.45), ("resistance-1.1", 0.55)] {
            let changed = under(name);
            // 0.9 and 1.1 are rounded.
            assert!((changed.motor.r_ohm - ohm).abs() < 1e-15);
            assert_eq!(Scenario { motor: standard.motor, ..changed }, standard);
        }
    }

    #[test]
    fn every_severity_is_smaller_than_the_last() {
        assert_eq!((SEVERITIES[0], SEVERITIES[8]), (1.0, 0.007_812_5));
        assert!(SEVERITIES.windows(2).all(|pair| pair[1] < pair[0]));
    }
}
