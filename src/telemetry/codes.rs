//! Verdicts, alarms and reasons as numbers. The numbers of reasons and parts are those of the C interface.

use serde::{Deserialize, Serialize};

use crate::decide::{Alarm, Cause};
use crate::reason::{FrictionTerm, Implausible, Part, Reason};
use crate::report::Verdict;

/// A verdict: 0 class, 1 novel, 2 ambiguous, 3 undetermined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct VerdictCode {
    verdict: u8,
    /// The class, or the number of the reason.
    detail: u8,
    /// Part, parameter, term, channel, covariate or error of the reason.
    place: u8,
    /// Rows of the reason.
    #[serde(with = "postcard::fixint::le")]
    rows: u32,
}

const PARTS: [Part; 4] = [Part::Regression, Part::TorqueBalance, Part::Orders, Part::Classifier];

fn part_code(part: Part) -> u8 {
    match part {
        Part::Regression => 1,
        Part::TorqueBalance => 2,
        Part::Orders => 3,
        Part::Classifier => 4,
    }
}

/// The place of a value among all, 255 if it is none of them.
fn place_in<T: PartialEq, const N: usize>(all: [T; N], value: &T) -> u8 {
    (0_u8..).zip(all).find(|(_, other)| other == value).map_or(u8::MAX, |(place, _)| place)
}

impl From<Verdict> for VerdictCode {
    fn from(verdict: Verdict) -> Self {
        let plain = |verdict, detail| Self { verdict, detail, place: 0, rows: 0 };
        let reason = match verdict {
            Verdict::Class(class) => return plain(0, class),
            Verdict::Novel => return plain(1, 0),
            Verdict::Ambiguous => return plain(2, 0),
            Verdict::Undetermined(reason) => reason,
        };
        let of = |detail, place| Self { place, ..plain(3, detail) };
        match reason {
            Reason::TooFewRows { part, rows } => Self { rows, ..of(1, part_code(part)) },
            Reason::ShortSegment { rows } => Self { rows, ..of(2, 0) },
            Reason::AtRest => of(3, 0),
            Reason::ParameterNotExcited(place) => of(4, place),
            Reason::TermNotExcited(term) => of(5, place_in(FrictionTerm::ALL, &term)),
            Reason::WeakInstruments(part) => of(6, part_code(part)),
            Reason::Stuck { channel } => of(7, channel),
            Reason::LostSamples { channel } => of(8, channel),
            Reason::OutOfRange { covariate } => of(9, covariate),
            Reason::NotFinite(part) => of(10, part_code(part)),
            Reason::Implausible(error) => of(12, place_in(Implausible::ALL, &error)),
        }
    }
}

impl VerdictCode {
    /// The verdict; `None` for numbers that none has.
    pub fn verdict(self) -> Option<Verdict> {
        let Self { verdict, detail, place, .. } = self;
        match verdict {
            0 => Some(Verdict::Class(detail)),
            1 => Some(Verdict::Novel),
            2 => Some(Verdict::Ambiguous),
            3 => self.reason(detail, place).map(Verdict::Undetermined),
            _ => None,
        }
    }

    fn reason(self, code: u8, place: u8) -> Option<Reason> {
        let part = || PARTS.into_iter().find(|part| part_code(*part) == place);
        Some(match code {
            1 => Reason::TooFewRows { part: part()?, rows: self.rows },
            2 => Reason::ShortSegment { rows: self.rows },
            3 => Reason::AtRest,
            4 => Reason::ParameterNotExcited(place),
            5 => Reason::TermNotExcited(*FrictionTerm::ALL.get(place as usize)?),
            6 => Reason::WeakInstruments(part()?),
            7 => Reason::Stuck { channel: place },
            8 => Reason::LostSamples { channel: place },
            9 => Reason::OutOfRange { covariate: place },
            10 => Reason::NotFinite(part()?),
            12 => Reason::Implausible(*Implausible::ALL.get(place as usize)?),
            _ => return None,
        })
    }
}

/// An alarm: 0 none, 1 of a class, 2 of an unknown cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AlarmCode {
    alarm: u8,
    cause: u8,
    #[serde(with = "postcard::fixint::le")]
    segment: u32,
}

impl From<Option<Alarm>> for AlarmCode {
    fn from(alarm: Option<Alarm>) -> Self {
        match alarm {
            None => Self { alarm: 0, cause: 0, segment: 0 },
            Some(Alarm { segment, cause: Cause::Class(cause) }) => Self { alarm: 1, cause, segment },
            Some(Alarm { segment, cause: Cause::Unknown }) => Self { alarm: 2, cause: 0, segment },
        }
    }
}

impl AlarmCode {
    /// The alarm, if there is one; `None` for numbers that none has.
    #[expect(clippy::option_option, reason = "no alarm is a value")]
    pub const fn alarm(self) -> Option<Option<Alarm>> {
        let segment = self.segment;
        match self.alarm {
            0 => Some(None),
            1 => Some(Some(Alarm { segment, cause: Cause::Class(self.cause) })),
            2 => Some(Some(Alarm { segment, cause: Cause::Unknown })),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn every_verdict_and_alarm_comes_back() {
        let mut verdicts: Vec<Verdict> = Vec::from([Verdict::Class(0), Verdict::Class(255), Verdict::Novel]);
        verdicts.push(Verdict::Ambiguous);
        let of_terms = FrictionTerm::ALL.map(Reason::TermNotExcited);
        let of_parts = PARTS.map(|part| {
            [Reason::TooFewRows { part, rows: 1_000_000 }, Reason::WeakInstruments(part), Reason::NotFinite(part)]
        });
        let others = [
            Reason::ShortSegment { rows: 7 },
            Reason::AtRest,
            Reason::ParameterNotExcited(14),
            Reason::Stuck { channel: 3 },
            Reason::LostSamples { channel: 15 },
            Reason::OutOfRange { covariate: 1 },
        ];
        let of_errors = Implausible::ALL.map(Reason::Implausible);
        let reasons = of_terms.into_iter().chain(of_parts.into_iter().flatten()).chain(of_errors).chain(others);
        verdicts.extend(reasons.map(Verdict::Undetermined));
        for verdict in verdicts {
            assert_eq!(VerdictCode::from(verdict).verdict(), Some(verdict));
        }
        for alarm in [None, Some(Cause::Class(2)), Some(Cause::Unknown)] {
            let alarm = alarm.map(|cause| Alarm { segment: 9, cause });
            assert_eq!(AlarmCode::from(alarm).alarm(), Some(alarm));
        }
    }

    #[test]
    fn numbers_without_a_meaning_are_refused() {
        let code = |verdict, detail, place| VerdictCode { verdict, detail, place, rows: 0 }.verdict();
        assert_eq!([code(4, 0, 0), code(3, 0, 0), code(3, 11, 0)], [None; 3]);
        assert_eq!([code(3, 1, 0), code(3, 1, 5), code(3, 5, 8)], [None; 3], "no such part or term");
        assert_eq!(code(3, 12, 11), None, "no such error");
        assert_eq!(AlarmCode { alarm: 3, cause: 0, segment: 0 }.alarm(), None);
    }
}
