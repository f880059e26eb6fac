//! Rows against a clock: do they come at the rate of the model?
//!
//! ```text
//! ratio = (rows / ticks) / (rows of the model a tick)                                        (1)
//! ```
//!
//! A velocity that is computed from the angle of the same rows agrees with it at any rate, so that rows that come
//! twice, held or interpolated, or a timer at the wrong rate, show in no signal. The firmware has a clock of its own,
//! the millisecond tick. Cost: a division once a window, in the main loop.

/// Compares the number of rows with a clock.
///
/// ```
/// use bearing_watch::RateCheck;
/// // A model of 1 kHz, a tick of 1 ms, 2 % and ten seconds.
/// let mut rate = RateCheck::new(1000.0, 1000.0, 0.02, 10_000);
/// assert_eq!(rate.push(10, 500), None);
/// assert_eq!(rate.push(10_020, 10_500), Some(true));
/// assert_eq!(rate.push(30_020, 20_500), Some(false)); // twice as many rows
/// assert!((rate.ratio() - 2.0).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RateCheck {
    rows_a_tick: f32,
    tolerance: f32,
    window: u32,
    begin: Option<[u32; 2]>,
    ratio: f32,
}

impl RateCheck {
    /// For rows at `rows_hz` and a clock of `ticks_hz`. A window closes after `window` ticks or more; a tolerance of
    /// two per cent needs windows of a hundred times the delay with which a main loop may read the clock.
    #[must_use]
    pub const fn new(rows_hz: f32, ticks_hz: f32, tolerance: f32, window: u32) -> Self {
        Self { rows_a_tick: rows_hz / ticks_hz, tolerance, window, begin: None, ratio: f32::NAN }
    }

    /// For the rows of a model every `interval_s` and a clock of milliseconds: two per cent, of windows of ten seconds.
    #[must_use]
    pub const fn of_milliseconds(interval_s: f32) -> Self {
        Self::new(1.0 / interval_s, 1000.0, 0.02, 10_000)
    }

    /// Takes the number of rows so far and the clock, of one instant; both may wrap. The first window starts with the
    /// first row: before it, a drive checks its wiring or waits. Returns whether the rate is right with the call that
    /// closes a window: pass the opposite on to [`Monitor::refuse`](crate::Monitor::refuse).
    pub fn push(&mut self, rows: u32, ticks: u32) -> Option<bool> {
        if rows == 0 {
            self.begin = None;
            return None;
        }
        let [first_row, first_tick] = *self.begin.get_or_insert([rows, ticks]);
        let passed = ticks.wrapping_sub(first_tick);
        if passed < self.window.max(1) {
            return None;
        }
        self.begin = Some([rows, ticks]);
        self.ratio = rows.wrapping_sub(first_row) as f32 / (passed as f32 * self.rows_a_tick); // (1)
        // Written so that a ratio that is not a number is wrong.
        Some((self.ratio - 1.0).abs() <= self.tolerance)
    }

    /// The ratio (1) of the last window; NaN before.
    #[must_use]
    pub const fn ratio(&self) -> f32 {
        self.ratio
    }

    /// Starts a window anew, after a pause of the rows or the clock.
    pub const fn restart(&mut self) {
        self.begin = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_before_the_first_row_does_not_count() {
        let mut check = RateCheck::of_milliseconds(1e-3);
        let mut pushed = (0..100_u32).filter_map(|second| check.push(1000 * second.saturating_sub(35), 1000 * second));
        assert!(pushed.all(|right| right));
        assert!((check.ratio() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn wrong_rates_are_found_across_the_wrap_of_both_counters() {
        for (rows, right) in [(1000_u32, true), (1019, true), (1021, false), (981, true), (979, false), (2000, false)] {
            let mut rate = RateCheck::new(500.0, 1000.0, 0.02, 2000);
            let (mut row, mut tick) = (u32::MAX - 300, u32::MAX - 900);
            assert_eq!(rate.push(row, tick), None);
            for part in 1..=20 {
                (row, tick) = (row.wrapping_add(rows / 20), tick.wrapping_add(100));
                row = if part == 20 { row.wrapping_add(rows % 20) } else { row };
                assert_eq!(rate.push(row, tick), (part == 20).then_some(right), "{rows}");
            }
            assert!((rate.ratio() - rows as f32 / 1000.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_pause_is_left_out_and_constants_that_are_not_numbers_pass_nothing() {
        let mut rate = RateCheck::new(500.0, 1000.0, 0.02, 1000);
        assert_eq!(rate.push(7, 0), None);
        rate.restart();
        assert_eq!([rate.push(10, 100_000), rate.push(510, 101_000)], [None, Some(true)]);
        let mut wrong = RateCheck::new(f32::NAN, 0.0, 0.02, 0);
        assert_eq!([wrong.push(1, 0), wrong.push(2, 1)], [None, Some(false)]);
    }
}
