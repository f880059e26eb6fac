//! How many samples of recordings are missing, and why, in words: of one, and of several in one line.

use std::fmt;

use super::gaps::{BREAK, LONGEST_GAP, MOST};
use super::record::Trace;

/// What is missing in several traces.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Number of traces, and of those that lack samples.
    traces: [usize; 2],
    sum: Missing,
    /// The trace that lacks the largest part.
    most: Option<(String, Missing)>,
}

impl Tally {
    /// Counts a trace.
    pub fn add(&mut self, id: &str, own: Missing) {
        self.traces[0] += 1;
        self.sum = self.sum.plus(own);
        if own.count() == 0 {
            return;
        }
        self.traces[1] += 1;
        if self.most.as_ref().is_none_or(|(_, before)| own.percent() > before.percent()) {
            self.most = Some((id.to_string(), own));
        }
    }

    /// All that is missing.
    #[must_use]
    pub const fn sum(&self) -> Missing {
        self.sum
    }

    /// As one line; `None` if nothing is missing.
    #[must_use]
    pub fn line(&self) -> Option<String> {
        let (id, own) = self.most.as_ref()?;
        Some(match self.traces {
            [_, 1] => format!("trace {id}: {own}"),
            [all, lacking] => format!("{lacking} of {all} traces: {}; most in {id}, {:.2} %", self.sum, own.percent()),
        })
    }
}

impl<'a> FromIterator<&'a Trace> for Tally {
    fn from_iter<I: IntoIterator<Item = &'a Trace>>(traces: I) -> Self {
        let mut tally = Self::default();
        traces.into_iter().for_each(|trace| tally.add(&trace.id, trace.missing));
        tally
    }
}

/// What is missing in traces, as one line; `None` if nothing is.
#[must_use]
pub fn told<'a>(traces: impl Iterator<Item = &'a Trace>) -> Option<String> {
    traces.collect::<Tally>().line()
}

/// Missing samples of a trace: NaN in at least one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Missing {
    /// Samples of the trace, with those that are left out at its ends.
    pub samples: usize,
    /// Samples for which the file has no row, by its times.
    pub dropped: usize,
    /// Samples whose row lacks a number of a used channel, or the time.
    pub empty: usize,
    /// Of these, rows before the first number and after the last one; they are left out.
    pub ends: usize,
    /// Pauses that are too long to be filled, each [`BREAK`] of the dropped samples.
    pub breaks: usize,
}

impl Missing {
    /// Number of missing samples.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.dropped + self.empty
    }

    /// Those of several traces.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            dropped: self.dropped + other.dropped,
            empty: self.empty + other.empty,
            ends: self.ends + other.ends,
            breaks: self.breaks + other.breaks,
        }
    }

    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        let Self { samples, dropped, empty, ends, breaks } = self;
        serde_json::json!({
            "samples": samples, "missing": self.count(), "dropped": dropped, "empty": empty, "ends": ends,
            "breaks": breaks
        })
    }

    /// Part of the samples, %.
    #[must_use]
    pub fn percent(&self) -> f64 {
        100.0 * self.count() as f64 / self.samples.max(1) as f64
    }
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, treated as missing", self.words())
    }
}

impl Missing {
    /// Whether samples between the first and the last one are missing.
    #[must_use]
    pub const fn is_within(&self) -> bool {
        self.count() > self.ends
    }

    /// How many are missing, and why.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { samples, dropped, empty, ends, breaks } = *self;
        let mut parts = Vec::new();
        if dropped > 0 {
            parts.push(format!("{dropped} by gaps in the time"));
        }
        if empty > 0 {
            parts.push(format!("{empty} without a number"));
        }
        if ends > 0 {
            parts.push(format!("{ends} of these at the ends and left out"));
        }
        if breaks > 0 {
            let (pauses, each) = if breaks == 1 { ("pause is a break", "") } else { ("pauses are breaks", " each") };
            parts.push(format!(
                "{breaks} {pauses} of the recording, longer than {LONGEST_GAP} rows or {MOST} times the others: {BREAK} \
                 missing samples{each}"
            ));
        }
        let (percent, count, parts) = (self.percent(), self.count(), parts.join(", "));
        format!("{percent:.2} % of rows missing ({count} of {samples}: {parts})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_trace_and_several_are_told_in_one_line() {
        let own = |dropped, empty| Missing { samples: 5000, dropped, empty, ..Missing::default() };
        let of_all = |all: &[(&str, Missing)]| {
            let mut tally = Tally::default();
            all.iter().for_each(|(id, own)| tally.add(id, *own));
            tally.line()
        };
        assert_eq!(of_all(&[("a", own(0, 0))]), None);
        let line = of_all(&[("a", own(0, 0)), ("b", own(50, 0))]).expect("one");
        assert_eq!(line, "trace b: 1.00 % of rows missing (50 of 5000: 50 by gaps in the time), treated as missing");
        let line = of_all(&[("a", own(0, 25)), ("b", own(50, 0))]).expect("two");
        assert_eq!(
            line,
            "2 of 2 traces: 0.75 % of rows missing (75 of 10000: 50 by gaps in the time, 25 without a number), treated \
             as missing; most in b, 1.00 %"
        );
        let broken = Missing { breaks: 1, ends: 3, ..own(100, 4) };
        assert!(
            broken.to_string().contains("3 of these at the ends and left out, 1 pause is a break of the recording")
        );
    }
}
