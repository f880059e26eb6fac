//! Duties: the velocity reference of a record.
//!
//! | duty | reference |
//! |---|---|
//! | waveform | the waveform of the scenario |
//! | random steps | levels from −A to A, each held for 0.5–1.5 s |
//! | trapezoids | standstill 0.3–1 s, ramp 0.1–0.4 s to ± A × 0.5–1, held for 0.4–1.2 s, ramp to standstill |
//! | set points | ramps of 0.2–0.6 s to levels from −A to A, each held for 0.3–1 s |
//! | one-way | `A (1 + 0.3 sin 2πft)`: the shaft never reverses |
//! | constant speed | A |
//! | cycle, any cycle | five moves and rests of a machine: [`cycle`](crate::axis::cycle) |
//!
//! A and f are amplitude and frequency of the scenario's reference; levels and times are uniform. Trapezoids change
//! their direction at each standstill. The shaft is at rest at the start of a record, except for the last two duties,
//! where it turns at the reference and the controller is settled.

use super::draws::choice;
use crate::axis::Motion;
use crate::{NoiseSource, Stream};

/// Kind of the velocity reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Duty {
    /// The waveform of the scenario.
    Waveform,
    /// Steps between random levels.
    RandomSteps,
    /// Trapezoids in both directions, with standstill between them.
    Trapezoids,
    /// Ramps between random levels.
    SetPoints,
    /// A modulated velocity that never reverses.
    OneWay,
    /// A constant velocity.
    ConstantSpeed,
    /// Moves and rests of a machine.
    Cycle(Motion),
    /// Each record draws one of the six duties above.
    Any,
    /// Each record draws one of the four duties that reverse.
    AnyReversing,
}

impl Duty {
    /// The duties that [`Duty::Any`] draws; the four that reverse come first.
    pub const SINGLE: [Self; 6] =
        [Self::Waveform, Self::RandomSteps, Self::Trapezoids, Self::SetPoints, Self::OneWay, Self::ConstantSpeed];

    /// Name in labels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Waveform => "waveform",
            Self::RandomSteps => "random-steps",
            Self::Trapezoids => "trapezoids",
            Self::SetPoints => "set-points",
            Self::OneWay => "one-way",
            Self::ConstantSpeed => "constant-speed",
            Self::Cycle(motion) => motion.name(),
            Self::Any => "any",
            Self::AnyReversing => "any-reversing",
        }
    }

    /// The duty of the record with this seed, none of those that draw.
    #[must_use]
    pub fn of_record(self, seed: u64) -> Self {
        self.drawn(&mut NoiseSource::new(seed, Stream::Duty))
    }

    /// The motion of a machine, if the duty is one.
    pub(crate) const fn motion(self) -> Option<Motion> {
        if let Self::Cycle(motion) = self { Some(motion) } else { None }
    }

    pub(super) fn drawn(self, source: &mut NoiseSource) -> Self {
        let count = match self {
            Self::Any => 6,
            Self::AnyReversing => 4,
            single => return single,
        };
        Self::SINGLE[choice(source, count) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_duty_draws_all_of_its_kinds_and_no_other() {
        for (duty, kinds) in [(Duty::Any, 6), (Duty::AnyReversing, 4)] {
            let drawn: Vec<Duty> = (0..200).map(|seed| duty.of_record(seed)).collect();
            for (k, single) in Duty::SINGLE.into_iter().enumerate() {
                // 200 draws miss one of six with a probability of 1e-16.
                assert_eq!(drawn.contains(&single), k < kinds, "{duty:?} {single:?}");
            }
        }
        assert!(Duty::SINGLE.into_iter().all(|duty| duty.of_record(5) == duty));
    }
}
