//! Times of a column → seconds from the first one, to the last digit of a double.

use crate::table::columns::is_missing;
use crate::time::clock::iso_nanoseconds;

/// Rank of points of time among the columns that may be the time of rows: the smallest is the best.
pub const POINTS: u8 = 0;
/// Rank of texts with dates.
pub const TEXTS: u8 = 1;
/// Rank of times of the day.
pub const OF_DAY: u8 = 2;
/// Rank of spans of time.
pub const SPANS: u8 = 3;
/// Rank of dates in milliseconds.
pub const DATES: u8 = 4;
/// Rows at which columns of texts are looked at.
pub(super) const HEAD: usize = 64;

/// Seconds from the first value; pieces of a column come one after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct FromFirst {
    first: Option<i128>,
}

impl FromFirst {
    /// The seconds of times that are whole numbers of units, so many a second; NaN for missing ones.
    pub fn seconds(&mut self, times: impl Iterator<Item = Option<i128>>, a_second: f64) -> Vec<f64> {
        let second = |time: Option<i128>| {
            time.map_or(f64::NAN, |time| (time - *self.first.get_or_insert(time)) as f64 / a_second)
        };
        times.map(second).collect()
    }

    /// The seconds of texts that are dates with times.
    ///
    /// # Errors
    /// The row of a text that is none, and what to say of it.
    pub(super) fn of_texts(&mut self, texts: &[String]) -> Result<Vec<f64>, (usize, String)> {
        let time = |(row, text): (usize, &String)| match iso_nanoseconds(text) {
            None if is_missing(text.trim()) => Ok(None),
            None => Err((row, format!("\"{text}\" is no date with a time, as other rows have"))),
            time => Ok(time),
        };
        let times = texts.iter().enumerate().map(time).collect::<Result<Vec<_>, _>>()?;
        Ok(self.seconds(times.into_iter(), 1e9))
    }
}

/// Whether the first of these texts that are not empty are all dates with times.
pub(super) fn are_dates(head: &[String]) -> bool {
    let mut cells = head.iter().filter(|cell| !cell.is_empty()).peekable();
    cells.peek().is_some() && cells.all(|cell| iso_nanoseconds(cell).is_some())
}
