//! How many samples of a recording are missing, and why, in words.

use std::fmt;

use super::gaps::{BREAK, LONGEST_GAP, MOST};

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
