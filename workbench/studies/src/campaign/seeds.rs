//! Seeds that encode what a trace is for, so that two different traces never have the same seed:
//!
//! ```text
//! bit  63  62…61    60…45       44…37      36…34  33…22     21…0
//!      1   purpose  repetition  condition  class  severity  number      (1)
//! ```
//!
//! The severity is stored in steps of 1/1920: all [`SEVERITIES`](rig::SEVERITIES), their thirds and their fifths
//! are integer multiples of this step. The top bit is set, so these seeds differ from
//! [`trace_seed`](rig::trace_seed) of sets below 2³¹. The conditions of both rigs have different numbers.

use model::Error;
use rig::Defect;

/// Number of severity steps at full size.
const SEVERITY_STEPS: f64 = 1920.0;
/// Upper limit of the repetition number, exclusive.
const REPETITIONS: u32 = 1 << 16;
/// Upper limit of the severity in steps, exclusive.
const SEVERITIES: f64 = 4096.0;
/// Upper limit of the number of traces of one cell.
pub(super) const NUMBERS: u32 = 1 << 22;

/// Purpose of traces. Traces of different purposes never share a seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Purpose {
    /// Training.
    Training,
    /// Validation of the trained model.
    Validation,
    /// Selection of settings or thresholds, separate from training and validation.
    Selection,
    /// Measurement of a bound or a level, for example a noise floor.
    Reference,
}

impl Purpose {
    /// All purposes.
    pub const ALL: [Self; 4] = [Self::Training, Self::Validation, Self::Selection, Self::Reference];

    pub(super) const fn number(self) -> u64 {
        match self {
            Self::Training => 0,
            Self::Validation => 1,
            Self::Selection => 2,
            Self::Reference => 3,
        }
    }
}

/// What the seed of a trace encodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeedKey {
    /// Purpose of the trace.
    pub purpose: Purpose,
    /// Number of the repetition of the campaign, below 65 536.
    pub repetition: u32,
    /// Number of the condition, of [`Condition`](rig::Condition) or
    /// [`EmaCondition`](rig::ema::EmaCondition).
    pub condition: u8,
    /// Class and severity, a multiple of 1/1920 and at most 2.13.
    pub defect: Defect,
}

impl SeedKey {
    /// The seed of trace `number` (1).
    ///
    /// # Errors
    /// [`Error::Usage`] if a field does not fit its bits: the seed would then equal that of another key.
    pub fn seed(&self, number: u32) -> Result<u64, Error> {
        let refused = |what: &str| Err(Error::Usage(format!("a campaign's traces have no seed for {what}")));
        let steps = self.defect.severity * SEVERITY_STEPS;
        // The comparison is written so that NaN is rejected too.
        let whole = (steps - steps.round()).abs() < 1e-9;
        if !(whole && steps.round() >= 0.0 && steps.round() < SEVERITIES) {
            return refused(&format!("severity {}; take a multiple of 1/1920 up to 2.13", self.defect.severity));
        }
        if self.repetition >= REPETITIONS {
            return refused(&format!("repetition {}; there are {REPETITIONS}", self.repetition));
        }
        if number >= NUMBERS {
            return refused(&format!("trace {number} of a cell; there are {NUMBERS}"));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number in 0…4095, checked above"
        )]
        let severity = steps.round() as u64;
        Ok((1 << 63)
            | (self.purpose.number() << 61)
            | (u64::from(self.repetition) << 45)
            | (u64::from(self.condition) << 37)
            | (u64::from(self.defect.kind.number()) << 34)
            | (severity << 22)
            | u64::from(number)) // (1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rig::DefectKind;
    use rig::ema::EmaCondition;

    #[test]
    fn traces_of_the_actuator_have_seeds_of_their_own() {
        let mut seen = std::collections::HashSet::new();
        for condition in EmaCondition::ALL {
            for purpose in Purpose::ALL {
                for kind in DefectKind::ALL {
                    let key =
                        SeedKey { purpose, repetition: 3, condition: condition.number, defect: Defect::full(kind) };
                    for number in [0, 1, NUMBERS - 1] {
                        assert!(seen.insert(key.seed(number).expect("fits")), "{key:?}");
                    }
                }
            }
        }
        assert_eq!(seen.len(), 14 * 4 * 6 * 3);
    }
}
