//! Segments without a verdict → whether the diagnosis is lost, and why.
//!
//! A fault that prevents verdicts adds nothing to the evidence and would never be noticed. Enters: each segment without
//! a verdict, with the reason. Leaves: a [`Silence`] when the number of such segments in a row, or their duration,
//! reaches its limit ([`SilenceLimits`]); it ends with the next verdict. Its reason is the most frequent one.

use crate::reason::{Reason, ReasonCode};

/// When missing verdicts are a [`Silence`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SilenceLimits {
    /// Number of segments in a row without a verdict; 0 for no limit.
    pub segments: u32,
    /// Hours that these segments take by the sampling interval of the model; 0 for no limit. A model without a sampling
    /// interval knows no hours.
    pub hours: f32,
}

impl SilenceLimits {
    /// 10 000 segments or 24 hours, whichever are over first.
    pub const USUAL: Self = Self { segments: 10_000, hours: 24.0 };
    /// Never a silence.
    pub const NONE: Self = Self { segments: 0, hours: 0.0 };
}

/// No segment has had a verdict for too long.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Silence {
    /// Number of segments since the last verdict.
    pub segments: u32,
    /// The most frequent kind of reason among them, as the last segment with it had it; `None` if no reason was given.
    pub reason: Option<Reason>,
    /// Number of segments with a reason of this kind.
    pub with_reason: u32,
}

/// Segments since the last verdict, and their reasons.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Silent {
    limits: SilenceLimits,
    /// Duration of a segment; 0 if it is not known.
    segment_s: f32,
    segments: u32,
    /// By kind of reason: number of segments, and the last one's reason.
    reasons: [Option<(Reason, u32)>; Reason::KINDS],
}

impl Silent {
    pub(super) const NONE: Self =
        Self { limits: SilenceLimits::USUAL, segment_s: 0.0, segments: 0, reasons: [None; Reason::KINDS] };

    pub(super) const fn of_segments(self, segment_s: f32) -> Self {
        Self { segment_s, ..self }
    }

    pub(super) const fn segment_s(&self) -> f32 {
        self.segment_s
    }

    pub(super) const fn limit(&mut self, limits: SilenceLimits) {
        self.limits = limits;
    }

    pub(super) const fn limits(&self) -> SilenceLimits {
        self.limits
    }

    /// A segment had a verdict.
    pub(super) const fn end(&mut self) {
        // Short: nothing is written while segments have verdicts.
        if self.segments > 0 {
            self.segments = 0;
            self.reasons = [None; Reason::KINDS];
        }
    }

    /// A segment had no verdict.
    #[cold]
    pub(super) fn add(&mut self, reason: Option<Reason>) {
        self.segments = self.segments.saturating_add(1);
        let Some(reason) = reason else { return };
        if let Some(cell) = self.reasons.get_mut(usize::from(reason.code().kind)) {
            let count = cell.map_or(0, |(_, count)| count);
            *cell = Some((reason, count.saturating_add(1)));
        }
    }

    pub(super) fn silence(&self) -> Option<Silence> {
        let SilenceLimits { segments, hours } = self.limits;
        let passed_h = self.segments as f32 * self.segment_s / 3600.0;
        let over = (segments > 0 && self.segments >= segments) || (hours > 0.0 && passed_h >= hours);
        over.then(|| {
            let (reason, with_reason) = self.most().unzip();
            Silence { segments: self.segments, reason, with_reason: with_reason.unwrap_or(0) }
        })
    }

    /// The most frequent reason; of equally frequent ones the first kind.
    fn most(&self) -> Option<(Reason, u32)> {
        let mut most: Option<(Reason, u32)> = None;
        for (reason, count) in self.reasons.iter().flatten() {
            if most.is_none_or(|(_, other)| *count > other) {
                most = Some((*reason, *count));
            }
        }
        most
    }

    /// Segments, and the most frequent reason with its number, as words: others are forgotten at power-off.
    pub(super) fn words(&self) -> [u32; 3] {
        let (reason, count) = self.most().unzip();
        let code = reason.map(Reason::code);
        let word = code.map_or(0, |code| u32::from(code.kind) | u32::from(code.index) << 8);
        [self.segments, word, count.unwrap_or(0)]
    }

    /// Takes the words; `None` if they are none that so many undetermined segments can leave.
    pub(super) fn restore(&mut self, [segments, word, count]: [u32; 3], undetermined: u32) -> Option<()> {
        let [kind, index, 0, 0] = word.to_le_bytes() else { return None };
        let counted = segments <= undetermined && count <= segments && (kind == 0) == (count == 0);
        if !counted || (kind == 0 && index != 0) {
            return None;
        }
        (self.segments, self.reasons) = (segments, [None; Reason::KINDS]);
        if kind > 0 {
            let reason = ReasonCode { kind, index, rows: 0 }.reason()?;
            *self.reasons.get_mut(usize::from(kind))? = Some((reason, count));
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(reasons: &[Option<Reason>], limits: SilenceLimits, segment_s: f32) -> Silent {
        let mut silent = Silent::NONE.of_segments(segment_s);
        silent.limit(limits);
        reasons.iter().for_each(|reason| silent.add(*reason));
        silent
    }

    #[test]
    fn the_most_frequent_reason_is_told_and_a_verdict_ends_it() {
        let stuck = |channel| Some(Reason::Stuck { channel });
        let reasons = [Some(Reason::AtRest), stuck(0), None, stuck(2), Some(Reason::OtherModel)];
        let limits = SilenceLimits { segments: 5, hours: 0.0 };
        assert_eq!(after(&reasons[..4], limits, 0.0).silence(), None);
        let mut silent = after(&reasons, limits, 0.0);
        let expected = Silence { segments: 5, reason: stuck(2), with_reason: 2 };
        assert_eq!(silent.silence(), Some(expected));
        silent.end();
        assert_eq!(silent.silence(), None);
        (0..5).for_each(|_| silent.add(None));
        assert_eq!(silent.silence(), Some(Silence { segments: 5, reason: None, with_reason: 0 }));
    }

    #[test]
    fn hours_are_those_of_the_segments() {
        let hour = [Some(Reason::AtRest); 3];
        let limits = SilenceLimits { segments: 0, hours: 1.0 };
        for (segment_s, silence) in [(1199.0, false), (1200.0, true), (0.0, false), (f32::NAN, false)] {
            assert_eq!(after(&hour, limits, segment_s).silence().is_some(), silence, "{segment_s}");
        }
        assert_eq!(after(&hour, SilenceLimits::NONE, 1e9).silence(), None);
    }

    #[test]
    fn words_come_back_and_others_are_refused() {
        let limits = SilenceLimits { segments: 3, hours: 0.0 };
        for reasons in [&[][..], &[None], &[Some(Reason::Stuck { channel: 7 }); 4]] {
            let silent = after(reasons, limits, 0.0);
            let mut other = after(&[], limits, 0.0);
            assert_eq!(other.restore(silent.words(), 4), Some(()));
            assert_eq!(other, silent);
        }
        let mut silent = after(&[], limits, 0.0);
        let nan = f32::NAN.to_bits();
        for bad in [[5, 0, 0], [2, 3, 3], [2, 0, 1], [2, 3, 0], [2, 11, 1], [2, 0x100, 0], [2, nan, 1], [nan, 0, 0]] {
            assert_eq!(silent.restore(bad, 4), None, "{bad:?}");
        }
    }
}
