//! Reasons as numbers, those of the C interface, and back.

use super::kernel::ArithmeticFault;
use super::{FrictionTerm, Implausible, Obstacle, Part, Reason};

/// A reason as numbers: its kind, its part, parameter, term, channel, covariate, error or kernel, and its rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReasonCode {
    pub kind: u8,
    pub index: u8,
    pub rows: u32,
}

/// In the order of their numbers, the first of which is 1.
const PARTS: [Part; 4] = [Part::Regression, Part::TorqueBalance, Part::Orders, Part::Classifier];

const fn part_code(part: Part) -> u8 {
    match part {
        Part::Regression => 1,
        Part::TorqueBalance => 2,
        Part::Orders => 3,
        Part::Classifier => 4,
    }
}

/// The index of a value among all, 255 if it is none of them.
fn place_in<T: PartialEq, const N: usize>(all: [T; N], value: &T) -> u8 {
    (0_u8..).zip(all).find(|(_, other)| other == value).map_or(u8::MAX, |(index, _)| index)
}

impl Reason {
    /// Kinds have numbers below this one.
    pub(crate) const KINDS: usize = 17;

    pub(crate) fn code(self) -> ReasonCode {
        let of = |kind, index| ReasonCode { kind, index, rows: 0 };
        match self {
            Self::TooFewRows { part, rows } => ReasonCode { rows, ..of(1, part_code(part)) },
            Self::ShortSegment { rows } => ReasonCode { rows, ..of(2, 0) },
            Self::AtRest => of(3, 0),
            Self::ParameterNotExcited(index) => of(4, index),
            Self::TermNotExcited(term) => of(5, place_in(FrictionTerm::ALL, &term)),
            Self::WeakInstruments(part) => of(6, part_code(part)),
            Self::Stuck { channel } => of(7, channel),
            Self::LostSamples { channel } => of(8, channel),
            Self::OutOfRange { covariate } => of(9, covariate),
            Self::NotFinite(part) => of(10, part_code(part)),
            // 11 is a reason that an older build does not know.
            Self::Implausible(error) => of(12, place_in(Implausible::ALL, &error)),
            Self::Arithmetic(kernel) => of(13, place_in(ArithmeticFault::ALL, &kernel)),
            Self::OtherModel => of(14, 0),
            Self::FoundLate => of(15, 0),
            Self::Unseen(obstacle) => of(16, place_in(Obstacle::ALL, &obstacle)),
        }
    }
}

impl ReasonCode {
    /// The reason; `None` for numbers that none has.
    pub fn reason(self) -> Option<Reason> {
        let Self { kind, index, rows } = self;
        let part = || PARTS.into_iter().find(|part| part_code(*part) == index);
        Some(match kind {
            1 => Reason::TooFewRows { part: part()?, rows },
            2 => Reason::ShortSegment { rows },
            3 => Reason::AtRest,
            4 => Reason::ParameterNotExcited(index),
            5 => Reason::TermNotExcited(*FrictionTerm::ALL.get(index as usize)?),
            6 => Reason::WeakInstruments(part()?),
            7 => Reason::Stuck { channel: index },
            8 => Reason::LostSamples { channel: index },
            9 => Reason::OutOfRange { covariate: index },
            10 => Reason::NotFinite(part()?),
            12 => Reason::Implausible(*Implausible::ALL.get(index as usize)?),
            13 => Reason::Arithmetic(*ArithmeticFault::ALL.get(index as usize)?),
            14 => Reason::OtherModel,
            15 => Reason::FoundLate,
            16 => Reason::Unseen(*Obstacle::ALL.get(index as usize)?),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// The numbers that saved states, frames and C programs have: a changed one changes what older ones say.
    fn published() -> Vec<(Reason, [u8; 2], u32)> {
        let parts = [(Part::Regression, 1), (Part::TorqueBalance, 2), (Part::Orders, 3), (Part::Classifier, 4)];
        let terms = [
            FrictionTerm::Inertia,
            FrictionTerm::Viscous,
            FrictionTerm::Coulomb,
            FrictionTerm::InverseTorqueConstant,
            FrictionTerm::Offset,
            FrictionTerm::LoadFriction,
            FrictionTerm::Stribeck,
            FrictionTerm::Drag,
        ];
        let errors = [
            Implausible::CurrentSign,
            Implausible::LoadSign,
            Implausible::MotionSign,
            Implausible::Sign,
            Implausible::CurrentScale,
            Implausible::LoadScale,
            Implausible::MotionScale,
            Implausible::Scale,
            Implausible::VelocitySign,
            Implausible::VelocityScale,
            Implausible::Current,
            Implausible::TorqueConstant,
            Implausible::Rate,
            Implausible::StuckAngle,
            Implausible::AngleSteps,
            Implausible::WiringUndecided,
            Implausible::Wiring,
        ];
        let kernels = [
            ArithmeticFault::Rounding,
            ArithmeticFault::Subnormals,
            ArithmeticFault::Functions,
            ArithmeticFault::Transforms,
            ArithmeticFault::Decimation,
            ArithmeticFault::Factor,
            ArithmeticFault::Solution,
        ];
        let mut table = Vec::from([
            (Reason::ShortSegment { rows: 7 }, [2, 0], 7),
            (Reason::AtRest, [3, 0], 0),
            (Reason::ParameterNotExcited(14), [4, 14], 0),
            (Reason::Stuck { channel: 3 }, [7, 3], 0),
            (Reason::LostSamples { channel: 15 }, [8, 15], 0),
            (Reason::OutOfRange { covariate: 1 }, [9, 1], 0),
            (Reason::OtherModel, [14, 0], 0),
            (Reason::FoundLate, [15, 0], 0),
            (Reason::Unseen(Obstacle::TooLittleMotion), [16, 0], 0),
            (Reason::Unseen(Obstacle::TooNoisy), [16, 1], 0),
        ]);
        for (part, index) in parts {
            table.push((Reason::TooFewRows { part, rows: 1_000_000 }, [1, index], 1_000_000));
            table.push((Reason::WeakInstruments(part), [6, index], 0));
            table.push((Reason::NotFinite(part), [10, index], 0));
        }
        table.extend((0..).zip(terms).map(|(index, term)| (Reason::TermNotExcited(term), [5, index], 0)));
        table.extend((0..).zip(errors).map(|(index, error)| (Reason::Implausible(error), [12, index], 0)));
        table.extend((0..).zip(kernels).map(|(index, kernel)| (Reason::Arithmetic(kernel), [13, index], 0)));
        table
    }

    #[test]
    fn every_reason_has_its_published_number_and_comes_back() {
        for (reason, [kind, index], rows) in published() {
            let code = ReasonCode { kind, index, rows };
            assert_eq!((reason.code(), code.reason()), (code, Some(reason)));
            assert!(usize::from(kind) < Reason::KINDS);
        }
    }

    #[test]
    fn numbers_without_a_meaning_are_refused() {
        let refused = [(0, 0), (11, 0), (16, 2), (17, 0), (1, 0), (1, 5), (5, 8), (12, 17), (13, 7)];
        for (kind, index) in refused {
            assert_eq!(ReasonCode { kind, index, rows: 0 }.reason(), None, "{kind} {index}");
        }
    }
}
