//! Named conditions of the EMA rig.
//!
//! The thesis records five conditions at Moog with sine, triangle and square commands, and one rig at RIT. It does not
//! say which command and which load belong to which number; the assignment here is an assumption. The command of the
//! squares has an amplitude of 5 mm: its first velocity command is then 412 rad/s, below the limit of the drive.
//! Conditions whose names end with `mix` draw amplitude, frequency, load, temperature and start position of each trace
//! ([`EmaScenario::mixed`]).

use super::super::Waveform;
use super::{EmaLoad, EmaScenario};

/// A named experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmaCondition {
    /// Name on the command line, in labels and reports.
    pub name: &'static str,
    /// Unique number, different from those of the DC-motor rig, that must not change: seeds may depend on it.
    pub number: u8,
    /// Short description.
    pub about: &'static str,
    /// The experiment without random conditions.
    pub scenario: EmaScenario,
    /// If true, each trace additionally draws random conditions.
    pub mixed: bool,
}

const SQUARE_M: f64 = 0.005;
const CONSTANT: EmaLoad = EmaLoad::Constant { force_n: 8e3 };

const MOOG_2: EmaScenario = EmaScenario { command: Waveform::Triangle, ..EmaScenario::MOOG };
const MOOG_3: EmaScenario = EmaScenario { command: Waveform::Square, amplitude_m: SQUARE_M, ..EmaScenario::MOOG };
const MOOG_4: EmaScenario = EmaScenario { load: CONSTANT, ..MOOG_3 };
const MOOG_5: EmaScenario = EmaScenario { load: CONSTANT, ..EmaScenario::MOOG };

impl EmaCondition {
    /// A sine command against a load sine, recorded at 1200 Hz.
    pub const STANDARD: Self = Self {
        name: "standard",
        number: 128,
        about: "sine command, load sine of 4 kN, 1200 Hz",
        scenario: EmaScenario::STANDARD,
        mixed: false,
    };

    /// The standard experiment with random conditions.
    pub const MIX: Self = Self {
        name: "mix",
        number: 129,
        about: "the same, conditions drawn for each trace",
        mixed: true,
        ..Self::STANDARD
    };

    /// All conditions.
    pub const ALL: [Self; 14] = [
        Self::STANDARD,
        Self::MIX,
        Self::new("moog-1", 130, "sine command, load sine, held for three rows", EmaScenario::MOOG),
        Self::new("moog-2", 131, "triangle command, load sine, held for three rows", MOOG_2),
        Self::new("moog-3", 132, "square command, load sine, held for three rows", MOOG_3),
        Self::new("moog-4", 133, "square command, constant load of 8 kN, held for three rows", MOOG_4),
        Self::new("moog-5", 134, "sine command, constant load of 8 kN, held for three rows", MOOG_5),
        Self::new("rit", 135, "sine command against springs, 10 kHz", EmaScenario::RIT),
        Self::new("moog-1-mix", 136, "moog-1, conditions drawn for each trace", EmaScenario::MOOG).drawn(),
        Self::new("moog-2-mix", 137, "moog-2, conditions drawn for each trace", MOOG_2).drawn(),
        Self::new("moog-3-mix", 138, "moog-3, conditions drawn for each trace", MOOG_3).drawn(),
        Self::new("moog-4-mix", 139, "moog-4, conditions drawn for each trace", MOOG_4).drawn(),
        Self::new("moog-5-mix", 140, "moog-5, conditions drawn for each trace", MOOG_5).drawn(),
        Self::new("rit-mix", 141, "rit, conditions drawn for each trace", EmaScenario::RIT).drawn(),
    ];

    const fn new(name: &'static str, number: u8, about: &'static str, scenario: EmaScenario) -> Self {
        Self { name, number, about, scenario, mixed: false }
    }

    const fn drawn(self) -> Self {
        Self { mixed: true, ..self }
    }

    /// The condition with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|condition| condition.name == name)
    }

    /// The experiment of a trace; random conditions are drawn from `seed`, the seed of the trace.
    #[must_use]
    pub fn scenario(&self, seed: u64) -> EmaScenario {
        if self.mixed { self.scenario.mixed(seed) } else { self.scenario }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Condition;

    #[test]
    fn names_and_numbers_are_distinct() {
        for (k, one) in EmaCondition::ALL.iter().enumerate() {
            assert_eq!(EmaCondition::named(one.name), Some(*one));
            assert!(Condition::all().all(|dc| dc.number != one.number), "{}", one.name);
            for other in &EmaCondition::ALL[..k] {
                assert!(one.name != other.name && one.number != other.number, "{} {}", one.name, other.name);
            }
            assert_eq!(one.mixed, one.name.ends_with("mix"));
            assert_eq!(one.scenario(1) != one.scenario(2), one.mixed);
            assert!(one.scenario(3).validate().is_ok());
        }
        assert_eq!(EmaCondition::named("moog-6"), None);
    }

    #[test]
    fn moog_holds_three_rows_at_1200_hz_and_rit_records_at_10_khz() {
        for condition in EmaCondition::ALL {
            let logging = condition.scenario.logging;
            let rate = 1.0 / condition.scenario.row_interval_s();
            let expected = if condition.name.starts_with("rit") { 10_000.0 } else { 1200.0 };
            // Rounding only.
            assert!((rate / expected - 1.0).abs() < 1e-12, "{}", condition.name);
            assert_eq!(logging.hold, if condition.name.starts_with("moog") { 3 } else { 1 });
        }
    }
}
