//! Verdicts, alarms and reasons as numbers. The numbers of reasons and parts are those of the C interface.

use serde::{Deserialize, Serialize};

use crate::decide::{Alarm, Cause};
use crate::reason::ReasonCode;
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

impl From<Verdict> for VerdictCode {
    fn from(verdict: Verdict) -> Self {
        let plain = |verdict, detail| Self { verdict, detail, place: 0, rows: 0 };
        let reason = match verdict {
            Verdict::Class(class) => return plain(0, class),
            Verdict::Novel => return plain(1, 0),
            Verdict::Ambiguous => return plain(2, 0),
            Verdict::Undetermined(reason) => reason,
        };
        let ReasonCode { kind, place, rows } = reason.code();
        Self { place, rows, ..plain(3, kind) }
    }
}

impl VerdictCode {
    /// The verdict; `None` for numbers that none has.
    pub fn verdict(self) -> Option<Verdict> {
        let Self { verdict, detail, place, rows } = self;
        match verdict {
            0 => Some(Verdict::Class(detail)),
            1 => Some(Verdict::Novel),
            2 => Some(Verdict::Ambiguous),
            3 => ReasonCode { kind: detail, place, rows }.reason().map(Verdict::Undetermined),
            _ => None,
        }
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
    use crate::reason::{Part, Reason};

    #[test]
    fn every_verdict_and_alarm_comes_back() {
        let reasons = [Reason::TooFewRows { part: Part::Orders, rows: 1_000_000 }, Reason::OutOfRange { covariate: 1 }];
        let plain = [Verdict::Class(0), Verdict::Class(255), Verdict::Novel, Verdict::Ambiguous];
        let verdicts = plain.into_iter().chain(reasons.map(Verdict::Undetermined));
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
        assert_eq!(AlarmCode { alarm: 3, cause: 0, segment: 0 }.alarm(), None);
    }
}
