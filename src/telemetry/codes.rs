//! Verdicts, alarms and reasons as numbers. The numbers of reasons and parts are those of the C interface.

use serde::{Deserialize, Serialize};

use crate::alarm::evidence::{Alarm, Cause};
use crate::reason::ReasonCode;
use crate::report::Verdict;

/// A verdict: 0 class, 1 novel, 2 ambiguous, 3 undetermined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct VerdictCode {
    verdict: u8,
    /// The class, or the number of the reason.
    detail: u8,
    /// Part, parameter, term, channel, covariate or error of the reason.
    index: u8,
    /// Rows of the reason.
    #[serde(with = "postcard::fixint::le")]
    rows: u32,
}

impl From<Verdict> for VerdictCode {
    fn from(verdict: Verdict) -> Self {
        let plain = |verdict, detail| Self { verdict, detail, index: 0, rows: 0 };
        let reason = match verdict {
            Verdict::Class(class) => return plain(0, class),
            Verdict::Novel => return plain(1, 0),
            Verdict::Ambiguous => return plain(2, 0),
            Verdict::Undetermined(reason) => reason,
        };
        let ReasonCode { kind, index, rows } = reason.code();
        Self { index, rows, ..plain(3, kind) }
    }
}

impl VerdictCode {
    /// The verdict; `None` for numbers that none has.
    pub fn verdict(self) -> Option<Verdict> {
        let Self { verdict, detail, index, rows } = self;
        match verdict {
            0 => Some(Verdict::Class(detail)),
            1 => Some(Verdict::Novel),
            2 => Some(Verdict::Ambiguous),
            3 => ReasonCode { kind: detail, index, rows }.reason().map(Verdict::Undetermined),
            _ => None,
        }
    }
}

/// An alarm: 0 none, 1 of a class, 2 of an unknown cause, 3 of a coordinate, 4 of one that has fallen.
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
            Some(Alarm { segment, cause: Cause::Coordinate(cause) }) => Self { alarm: 3, cause, segment },
            Some(Alarm { segment, cause: Cause::Fallen(cause) }) => Self { alarm: 4, cause, segment },
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
            3 => Some(Some(Alarm { segment, cause: Cause::Coordinate(self.cause) })),
            4 => Some(Some(Alarm { segment, cause: Cause::Fallen(self.cause) })),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reason::{Part, Reason};

    /// The bytes of a frame, of which older programs read the same verdict.
    #[test]
    fn verdicts_and_alarms_are_the_bytes_of_the_format() {
        let rows = Reason::TooFewRows { part: Part::Orders, rows: 0x0102_0304 };
        let verdicts = [
            (Verdict::Class(0), [0, 0, 0, 0, 0, 0, 0]),
            (Verdict::Class(255), [0, 255, 0, 0, 0, 0, 0]),
            (Verdict::Novel, [1, 0, 0, 0, 0, 0, 0]),
            (Verdict::Ambiguous, [2, 0, 0, 0, 0, 0, 0]),
            (Verdict::Undetermined(rows), [3, 1, 3, 4, 3, 2, 1]),
            (Verdict::Undetermined(Reason::OutOfRange { covariate: 1 }), [3, 9, 1, 0, 0, 0, 0]),
        ];
        for (verdict, bytes) in verdicts {
            let mut buffer = [0xA5; 7];
            assert_eq!(postcard::to_slice(&VerdictCode::from(verdict), &mut buffer).unwrap(), bytes);
            let read: VerdictCode = postcard::from_bytes(&bytes).unwrap();
            assert_eq!(read.verdict(), Some(verdict));
        }
        let at = |cause| Some(Alarm { segment: 0x0102_0304, cause });
        let alarms = [
            (None, [0, 0, 0, 0, 0, 0]),
            (at(Cause::Class(2)), [1, 2, 4, 3, 2, 1]),
            (at(Cause::Unknown), [2, 0, 4, 3, 2, 1]),
            (at(Cause::Fallen(3)), [4, 3, 4, 3, 2, 1]),
        ];
        for (alarm, bytes) in alarms {
            let mut buffer = [0xA5; 6];
            assert_eq!(postcard::to_slice(&AlarmCode::from(alarm), &mut buffer).unwrap(), bytes);
            let read: AlarmCode = postcard::from_bytes(&bytes).unwrap();
            assert_eq!(read.alarm(), Some(alarm));
        }
    }

    #[test]
    fn numbers_without_a_meaning_are_refused() {
        let code = |verdict, detail, index| VerdictCode { verdict, detail, index, rows: 0 }.verdict();
        assert_eq!([code(4, 0, 0), code(3, 0, 0), code(3, 11, 0)], [None; 3]);
        assert_eq!(AlarmCode { alarm: 5, cause: 0, segment: 0 }.alarm(), None);
    }
}
