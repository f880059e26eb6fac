//! The report of a segment as one data frame of 8 bytes, for a drive whose line is CAN or CAN FD.
//!
//! Enters: report and evidence. Leaves: [`SegmentFrame`], whose bytes the program sends under an identifier of its own
//! choice, one frame a segment. `bearing-watch dbc` describes the frame for the programs at the other end, and
//! `bearing-watch listen --can-id` reads it from logs.
//!
//! ```
//! # mod model { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/support/standard_rig/model.rs")); }
//! # use model::{MODEL, Sample};
//! use bearing_watch::telemetry::SegmentFrame;
//! use bearing_watch::{Detector, Monitor, Verdict};
//!
//! let (mut detector, mut monitor) = (Detector::new(&MODEL), Monitor::new(&MODEL));
//! for k in 0..5000 {
//!     let sample = Sample { current_a: (0.1 * k as f32).sin(), velocity_ref_rad_s: 0.5, load_torque_nm: 0.0 };
//!     if let Some(now) = monitor.step(&mut detector, &sample) {
//!         let report = now.report.clone();
//!         let bytes = SegmentFrame::of(&MODEL, &report, monitor.evidence()).to_bytes();
//!         // can.send(id, bytes)
//!         let frame = SegmentFrame::from_bytes(bytes).ok_or("not a segment")?;
//!         assert_eq!((frame.segment(), matches!(frame.verdict(), Verdict::Undetermined(_))), (1, true));
//!     }
//! }
//! # Ok::<(), &str>(())
//! ```
//!
//! # Signals
//!
//! ```text
//! signal        start  bits  step  unit
//! Segment           0     8     1        number of the segment, which wraps: frames that are missing or doubled
//! Verdict           8     8     1        0 undetermined, 1 novel, 2 ambiguous, 3 + k class k
//! Reason           16     5     1        of an undetermined verdict, else 0
//! Undetermined     21     3     1        number of undetermined segments, which wraps
//! Place            24     8     1        part, parameter, term, channel, covariate, error or kernel of the reason
//! Alarm            32     8     1        0 none, 1 unknown, 2 + k class k, 128 + k coordinate k risen, 192 + k fallen
//! Deviations       40     8  0.25  sd    by how much the coordinate of the alarm has risen; 63.75 or more
//! Usable           48     7     1  %     share of the segment's samples that are usable rows
//! Silent           55     1     1        no segment has had a verdict for too long
//! Distance         56     8  0.25  sd    distance from the healthy class; 63.75 or more, 0 without a verdict
//! ```
//!
//! All signals are unsigned and little-endian, with an offset of 0: bit 0 is the lowest one of the first byte, as in a
//! DBC file. Each byte but the third and the seventh is one signal. [`SegmentFrame::SIGNALS`] is this table; encoder,
//! decoder and DBC file use it. Reasons and places have the numbers of the C interface; rows of a reason are not sent
//! and are 0. Classes from 252 on share the last number of their signal, as do classes from 125 on and coordinates from
//! 63 on as the cause of an alarm.
//!
//! A report may be withdrawn until the next segment ([`Monitor::withdraw`](crate::Monitor::withdraw)). Its frame is
//! then sent again, with the same number and the reason [`Reason::FoundLate`]. If it is not, *Undetermined* rises by
//! one more than the verdicts say.
//!
//! Cost: some shifts and divisions once a segment, and no state.

mod signal;

pub use signal::CanSignal;

use crate::alarm::evidence::{Cause, Evidence};
use crate::model::Model;
use crate::plan::Plan;
use crate::reason::{Reason, ReasonCode};
use crate::report::{Report, Verdict};

const SEGMENT: CanSignal = CanSignal::of("Segment", 0, 8, "Number of the segment, which wraps");
const VERDICT: CanSignal = CanSignal::of("Verdict", 8, 8, "Class of the segment, or why there is none");
const REASON: CanSignal = CanSignal::of("Reason", 16, 5, "Why the verdict is undetermined");
const UNDETERMINED: CanSignal = CanSignal::of("Undetermined", 21, 3, "Number of undetermined segments, which wraps");
const PLACE: CanSignal =
    CanSignal::of("Place", 24, 8, "Part, parameter, term, channel, covariate, error or kernel of the reason");
const ALARM: CanSignal = CanSignal::of("Alarm", 32, 8, "Cause of the alarm that stands");
const DEVIATIONS: CanSignal =
    CanSignal::of("Deviations", 40, 8, "By how much the coordinate of the alarm has risen").in_steps(0.25, "sd");
const USABLE: CanSignal =
    CanSignal::of("Usable", 48, 7, "Share of the samples of the segment that are usable rows").in_steps(1.0, "%");
const SILENT: CanSignal = CanSignal::of("Silent", 55, 1, "No segment has had a verdict for too long");
const DISTANCE: CanSignal = CanSignal::of("Distance", 56, 8, "Distance from the healthy class").in_steps(0.25, "sd");

const UNDECIDED: u8 = 0;
const NOVEL: u8 = 1;
const AMBIGUOUS: u8 = 2;
const FIRST_CLASS: u8 = 3;

const NO_ALARM: u8 = 0;
const UNKNOWN_CAUSE: u8 = 1;
const FIRST_DEFECT: u8 = 2;
const FIRST_COORDINATE: u8 = 128;
const FIRST_FALLEN: u8 = 192;

/// Percent.
const WHOLE: u8 = 100;

/// The report of a segment in 8 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SegmentFrame {
    bits: u64,
}

impl SegmentFrame {
    /// All signals, in the order of their bits.
    pub const SIGNALS: [CanSignal; 10] =
        [SEGMENT, VERDICT, REASON, UNDETERMINED, PLACE, ALARM, DEVIATIONS, USABLE, SILENT, DISTANCE];

    /// The names of the numbers of the signal `Reason`; empty for those without a reason.
    pub const REASONS: [&'static str; Reason::KINDS] = [
        "none",
        "too few rows",
        "short segment",
        "at rest",
        "parameter not excited",
        "term not excited",
        "weak instruments",
        "stuck sensor",
        "lost samples",
        "covariate out of range",
        "not finite",
        "",
        "implausible signals",
        "arithmetic of the processor",
        "other model",
        "withdrawn: fault found late",
        "too little seen",
    ];

    /// The frame of a report, and of the evidence that has observed it.
    #[must_use]
    pub fn of<P: Plan>(model: &Model<P>, report: &Report<P>, evidence: &Evidence<P>) -> Self {
        let decision = report.decision.as_ref();
        let (segment, undetermined) = evidence.segments();
        let reason = match report.verdict {
            Verdict::Undetermined(reason) => reason.code(),
            _ => ReasonCode { kind: 0, index: 0, rows: 0 },
        };
        let of_segment = model.constants().sampling.segment_samples.max(1) as f32;
        let deviations = evidence.main_contribution().map_or(0.0, |main| main.deviations);
        let numbers = [
            segment.to_le_bytes()[0],
            Self::verdict_number(report.verdict),
            reason.kind,
            undetermined.to_le_bytes()[0],
            reason.index,
            Self::alarm_number(evidence.alarm().map(|alarm| alarm.cause)),
            DEVIATIONS.steps(deviations),
            USABLE.steps(100.0 * report.rows as f32 / of_segment).min(WHOLE),
            u8::from(evidence.silence().is_some()),
            DISTANCE.steps(decision.map_or(0.0, |decision| decision.distance)),
        ];
        let signals = Self::SIGNALS.iter().zip(numbers);
        Self { bits: signals.fold(0, |bits, (signal, number)| bits | signal.bits(number)) }
    }

    /// The data of the frame.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; 8] {
        self.bits.to_le_bytes()
    }

    /// From the data of a frame; `None` if they are not those of a segment: a reason beside a verdict, one that this
    /// version does not know, or a share above 100 %.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 8]) -> Option<Self> {
        let frame = Self { bits: u64::from_le_bytes(bytes) };
        let fits = match frame.number(&VERDICT) {
            UNDECIDED => frame.reason().is_some(),
            _ => frame.number(&REASON) == 0 && frame.number(&PLACE) == 0,
        };
        (fits && frame.number(&USABLE) <= WHOLE).then_some(frame)
    }

    const fn number(self, signal: &CanSignal) -> u8 {
        signal.number(self.bits)
    }

    /// Why there is no verdict; `None` if there is one.
    fn reason(self) -> Option<Reason> {
        ReasonCode { kind: self.number(&REASON), index: self.number(&PLACE), rows: 0 }.reason()
    }

    /// The number of a verdict in the signal `Verdict`.
    #[must_use]
    pub const fn verdict_number(verdict: Verdict) -> u8 {
        match verdict {
            Verdict::Undetermined(_) => UNDECIDED,
            Verdict::Novel => NOVEL,
            Verdict::Ambiguous => AMBIGUOUS,
            Verdict::Class(class) => class.saturating_add(FIRST_CLASS),
        }
    }

    /// The number of the cause of an alarm, if there is one, in the signal `Alarm`.
    #[must_use]
    pub const fn alarm_number(cause: Option<Cause>) -> u8 {
        match cause {
            None => NO_ALARM,
            Some(Cause::Unknown) => UNKNOWN_CAUSE,
            Some(Cause::Class(class)) if class < FIRST_COORDINATE - FIRST_DEFECT => class.saturating_add(FIRST_DEFECT),
            Some(Cause::Class(_)) => FIRST_COORDINATE - 1,
            Some(Cause::Coordinate(index)) if index < FIRST_FALLEN - FIRST_COORDINATE => {
                index.saturating_add(FIRST_COORDINATE)
            }
            Some(Cause::Coordinate(_)) => FIRST_FALLEN - 1,
            Some(Cause::Fallen(index)) => index.saturating_add(FIRST_FALLEN),
        }
    }

    /// Number of the segment, modulo 256.
    #[must_use]
    pub const fn segment(self) -> u8 {
        self.number(&SEGMENT)
    }

    /// The class, or why there is none; the rows of a reason are 0.
    #[must_use]
    pub fn verdict(self) -> Verdict {
        match self.number(&VERDICT) {
            NOVEL => Verdict::Novel,
            AMBIGUOUS => Verdict::Ambiguous,
            class @ FIRST_CLASS.. => Verdict::Class(class.saturating_sub(FIRST_CLASS)),
            // Every frame without a verdict has a reason.
            UNDECIDED => Verdict::Undetermined(self.reason().unwrap_or(Reason::OtherModel)),
        }
    }

    /// Number of undetermined segments, modulo 8.
    #[must_use]
    pub const fn undetermined(self) -> u8 {
        self.number(&UNDETERMINED)
    }

    /// The cause of the alarm that stands.
    #[must_use]
    pub const fn alarm(self) -> Option<Cause> {
        match self.number(&ALARM) {
            NO_ALARM => None,
            UNKNOWN_CAUSE => Some(Cause::Unknown),
            index @ FIRST_FALLEN.. => Some(Cause::Fallen(index.saturating_sub(FIRST_FALLEN))),
            index @ FIRST_COORDINATE.. => Some(Cause::Coordinate(index.saturating_sub(FIRST_COORDINATE))),
            class => Some(Cause::Class(class.saturating_sub(FIRST_DEFECT))),
        }
    }

    /// By how many standard deviations the coordinate of the alarm has risen, in steps of 0.25 up to 63.75.
    #[must_use]
    pub fn deviations(self) -> f32 {
        DEVIATIONS.physical(self.bits)
    }

    /// Share of the samples of the segment that are usable rows.
    #[must_use]
    pub const fn usable_percent(self) -> u8 {
        self.number(&USABLE)
    }

    /// Whether no segment has had a verdict for too long.
    #[must_use]
    pub const fn is_silent(self) -> bool {
        self.number(&SILENT) > 0
    }

    /// Distance from the healthy class in its standard deviations, in steps of 0.25 up to 63.75.
    #[must_use]
    pub fn distance(self) -> f32 {
        DISTANCE.physical(self.bits)
    }
}

#[cfg(test)]
mod tests;
