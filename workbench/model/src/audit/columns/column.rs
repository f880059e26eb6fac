//! A column by itself: its step, and whether it is held, saturated or constant.

use super::codes::outside;
use super::held::{finite, held, least_difference, told};
use super::signs::Signs;
use crate::statistics::mean_sd;

/// Rows of one value that count as held, if the step is fine.
const HELD: usize = 8;
/// Rows at an extreme value that count as saturated.
const SATURATED: usize = 3;
/// The deviation in steps below which the quantisation is coarse, of a column that changes in this part of the rows: a
/// switch or a step of a command has few values too.
const COARSE: f64 = 4.0;
const CHANGING: f64 = 0.1;
/// Parts of the rows from which on a finding counts.
const PART: f64 = 0.005;

/// What was found in a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Mean, in the unit of the column.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    /// Least and largest value.
    pub range: [f64; 2],
    /// The smallest difference of two values.
    pub step: f64,
    /// Usual number of rows from one value to the next; above 1 the source is slower than the recording.
    pub every: usize,
    /// Part of the rows that differ from the one before.
    pub changing: f64,
    /// Part of the rows in runs of one value.
    pub held: f64,
    /// Part of the rows at the least or largest value, in runs.
    pub saturated: f64,
    /// Rows with values far outside of all others, as of an error code: the first one, and how many there are.
    pub outside: Option<(usize, usize)>,
    /// How its numbers are written, if they are signed ones without their sign; all else is of the decoded ones.
    pub signs: Option<Signs>,
    /// Part of the rows without a number; the others are those that all else is about.
    pub missing: f64,
}

impl Column {
    /// Of values of one trace; a missing one is NaN.
    #[must_use]
    pub fn of(x: &[f64]) -> Self {
        match Signs::of(x) {
            None => Self::of_signed(x),
            Some(signs) => {
                let decoded: Vec<f64> = x.iter().map(|x| signs.decoded(*x)).collect();
                Self { signs: Some(signs), ..Self::of_signed(&decoded) }
            }
        }
    }

    fn of_signed(x: &[f64]) -> Self {
        let measured = finite(x);
        let missing = (x.len() - measured.len()) as f64 / x.len().max(1) as f64;
        let mut sorted = measured.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        Self { missing, outside: outside(x, &sorted), ..Self::of_measured(&measured, &sorted) }
    }

    fn of_measured(x: &[f64], sorted: &[f64]) -> Self {
        let (mean, scatter) = mean_sd(x);
        let range = [sorted.first().copied().unwrap_or(f64::NAN), sorted.last().copied().unwrap_or(f64::NAN)];
        // The rounding of the mean of equal values is no deviation.
        let deviation = if range[0] < range[1] { scatter } else { 0.0 };
        let step = least_difference(sorted, deviation);
        let every = held(x).unwrap_or(1);
        let runs = || x.chunk_by(|one, other| one == other).map(|run| (run[0], run.len()));
        let part = |rows: usize| rows as f64 / x.len().max(1) as f64;
        let held = runs().filter(|(_, length)| *length >= HELD * every).map(|(_, length)| length).sum();
        let extreme = |value: f64| value == range[0] || value == range[1];
        let stuck = runs().filter(|(value, length)| *length >= SATURATED * every && extreme(*value));
        let saturated = part(stuck.map(|(_, length)| length).sum());
        // A coarse step holds a slow signal by itself.
        let is_fine = deviation > COARSE * COARSE * step;
        Self {
            mean,
            deviation,
            range,
            step,
            every,
            changing: part(runs().count().saturating_sub(1)),
            held: if is_fine { part(held) } else { 0.0 },
            saturated: if is_fine { saturated } else { 0.0 },
            outside: None,
            signs: None,
            missing: 0.0,
        }
    }

    /// What is wrong, in words; the rate of the rows, if it is known.
    #[must_use]
    pub fn findings(&self, rate_hz: Option<f64>) -> Vec<String> {
        let percent = |part: f64| format!("{:.1} %", 100.0 * part);
        let mut found = Vec::new();
        if self.missing > 0.0 {
            found.push(format!("no number in {} of the rows", percent(self.missing.max(1e-3))));
        }
        if let Some((first, count)) = self.outside {
            let value = if self.range[1].abs() > self.range[0].abs() { self.range[1] } else { self.range[0] };
            let rows = if count == 1 { "row".to_string() } else { format!("{count} rows, the first") };
            let what = "far outside of all others: an error code? write nan there";
            found.push(format!("{value} in {rows} {}, {what}", first + 1));
        }
        if self.deviation == 0.0 {
            found.push("constant".into());
        } else if self.deviation < COARSE * self.step && self.changing > CHANGING {
            found.push(format!("coarse: steps of {:.4}, more than a quarter of the deviation", self.step));
        }
        if self.every > 1 {
            found.push(told(self.every, rate_hz));
        }
        if self.held > 0.5 {
            found.push(format!("changes in {} of the rows only", percent(self.changing)));
        } else if self.held > PART {
            found.push(format!("held in {} of the rows", percent(self.held)));
        }
        if self.saturated > PART {
            let [least, largest] = self.range;
            found.push(format!("saturated at {least} or {largest} in {} of the rows", percent(self.saturated)));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(rows: u32) -> Vec<f64> {
        (0..rows).map(|k| (0.037 * f64::from(k)).sin() + 0.01 * f64::from(k * 7 % 11)).collect()
    }

    #[test]
    fn plain_columns_have_no_findings() {
        assert_eq!(Column::of(&wave(2000)).findings(None), Vec::<String>::new());
    }

    #[test]
    fn held_slow_saturated_coarse_and_constant_columns_are_told() {
        let mut held = wave(2000);
        held[500..560].fill(0.2);
        assert!(
            Column::of(&held).findings(None)[0].contains("held in 3.0 %"),
            "{:?}",
            Column::of(&held).findings(None)
        );
        let slow: Vec<f64> = wave(2000).chunks(4).flat_map(|four| [four[0]; 4]).collect();
        assert_eq!(Column::of(&slow).findings(None), ["changes every 4 rows only"]);
        let cut: Vec<f64> = wave(2000).iter().map(|x| x.min(0.9)).collect();
        let found = Column::of(&cut).findings(None);
        assert!(found.iter().any(|text| text.contains("saturated at") && text.contains("or 0.9 in")), "{found:?}");
        let coarse: Vec<f64> = wave(2000).iter().map(|x| (x * 4.0).round() / 4.0).collect();
        assert!(Column::of(&coarse).findings(None)[0].starts_with("coarse: steps of 0.2500"));
        assert_eq!(Column::of(&[3.0; 100]).findings(None), ["constant"]);
        let mut lacking = wave(2000);
        lacking.iter_mut().step_by(100).for_each(|x| *x = f64::NAN);
        let found = Column::of(&lacking);
        assert_eq!((found.findings(None), found.missing), (vec!["no number in 1.0 % of the rows".to_string()], 0.01));
        assert!((found.mean - Column::of(&wave(2000)).mean).abs() < 0.01 && found.deviation > 0.5);
    }

    #[test]
    fn a_peak_of_a_single_row_is_not_saturated() {
        // 2 % of the rows are at an end of the range.
        let saw: Vec<f64> = (0..1000).map(|k| f64::from(k % 100)).collect();
        assert_eq!(Column::of(&saw).findings(None), Vec::<String>::new());
        // 2 of 100 rows at each end become 3 + 3: below 2, and above 96.
        let cut: Vec<f64> = saw.iter().map(|x| x.clamp(2.0, 97.0)).collect();
        assert!((Column::of(&cut).saturated - 0.06).abs() < 1e-12, "{:?}", Column::of(&cut));
    }

    #[test]
    fn error_codes_are_told_from_large_signals() {
        let mut x: Vec<f64> = (0..1000).map(|k| f64::from(k % 90)).collect();
        assert_eq!(Column::of(&x).outside, None);
        (x[700], x[900]) = (104_857.594, 104_857.594);
        assert_eq!(Column::of(&x).outside, Some((700, 2)));
        assert!(
            Column::of(&x).findings(None)[0].contains("104857.594 in 2 rows, the first 701"),
            "{:?}",
            Column::of(&x)
        );
        // A tenth of the rows is a state of the machine.
        x.iter_mut().step_by(10).for_each(|x| *x = 104_857.594);
        assert_eq!(Column::of(&x).outside, None);
    }
}
