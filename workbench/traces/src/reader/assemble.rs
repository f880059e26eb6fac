//! From the rows of a recording to the samples of a trace: what is missing is NaN, as in the drive.
//!
//! ```text
//! rows ─► leave out those without any number, or without the time
//!      ─► put missing samples where the times lack rows (model::trace::gaps), at least as many as were left out
//!      ─► channels ─► trace
//! ```
//!
//! A row that is empty and a row that is not there so give the same trace. Rows before the first number and after the
//! last one are left out, and counted. Without a time the rows are the samples.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::signal::{Elapsed, Signal, values_of};
use model::Error;
use model::trace::{Channels, Gap, Missing, MotionTrace, Trace, gaps, median, same_interval};

/// The word for no time column.
pub const NO_TIME: &str = "none";

pub(crate) const INTEGRAL: &str = "an integral needs the time; name its column with --time, or give --rate-hz";

/// The rows of one trace.
pub(crate) struct Rows {
    /// Columns by their places in the file.
    columns: BTreeMap<usize, Vec<f64>>,
    /// The time of each row, s.
    times_s: Option<Vec<f64>>,
    /// Steps of the time from one recorded row to the next, s, over which no sample is missing.
    steps_s: Vec<f64>,
    /// Steps over missing samples that are no multiple of the others.
    uneven: usize,
    /// What is known to be missing before the channels are.
    missing: Missing,
    /// Whether a channel may have no number at all.
    is_piece: bool,
}

/// A row that is kept, and how many missing samples come before it.
struct Kept {
    row: usize,
    before: usize,
}

impl Rows {
    /// The rows as they are.
    pub(crate) fn of(columns: BTreeMap<usize, Vec<f64>>, times_s: Option<Vec<f64>>) -> Self {
        let steps_s = times_s.iter().flat_map(|times| times.windows(2)).map(|pair| pair[1] - pair[0]).collect();
        Self { columns, times_s, steps_s, uneven: 0, missing: Missing::default(), is_piece: false }
    }

    /// The rows of a piece of a trace, in which a channel may be missing all the time.
    pub(crate) fn piece(self) -> Self {
        Self { is_piece: true, ..self }
    }

    /// With a missing sample for each row that is empty, lacks its time, or is not there; without a time nothing tells
    /// that rows are not there, and all stay.
    pub(crate) fn complete(mut self) -> Self {
        let Some(times) = &self.times_s else { return self };
        let count = rows_of(&self.columns, self.times_s.as_deref());
        let has_number = |row: usize| self.columns.values().any(|column| column[row].is_finite());
        let is_there = |row: &usize| self.columns.is_empty() || has_number(*row);
        let there: Vec<usize> = (0..count).filter(|row| times[*row].is_finite() && is_there(row)).collect();
        let times: Vec<f64> = there.iter().map(|row| times[*row]).collect();
        let gaps = gaps(&times);
        if there.len() == count && gaps.is_empty() {
            return self;
        }
        let mut by_time = vec![0; there.len()];
        gaps.iter().for_each(|gap| by_time[gap.row] = gap.missing);
        let mut kept = Vec::with_capacity(there.len());
        for (k, row) in there.iter().enumerate() {
            let empty = k.checked_sub(1).map_or(0, |before| row - there[before] - 1);
            self.missing.dropped += by_time[k].saturating_sub(empty);
            kept.push(Kept { row: *row, before: by_time[k].max(empty) });
        }
        self.missing.breaks = gaps.iter().filter(|gap| gap.is_break).count();
        self.missing.ends = count - there.last().map_or(0, |last| last + 1 - there[0]);
        (self.steps_s, self.uneven) = steps(&times, &kept, &gaps);
        self.columns.par_iter_mut().for_each(|(_, column)| *column = placed(column, &kept));
        self.times_s = self.times_s.map(|times| placed(&times, &kept));
        self
    }
}

/// Number of rows, also where signals need no column.
pub(crate) fn rows_of(columns: &BTreeMap<usize, Vec<f64>>, times: Option<&[f64]>) -> usize {
    columns.values().next().map(Vec::len).or(times.map(<[f64]>::len)).unwrap_or(0)
}

/// The steps over which nothing is missing, and the number of others, breaks left out, that are off a multiple of the
/// usual one by more than a tenth of it.
fn steps(times: &[f64], kept: &[Kept], gaps: &[Gap]) -> (Vec<f64>, usize) {
    let step = |k: usize| times[k] - times[k - 1];
    let whole: Vec<f64> = (1..kept.len()).filter(|k| kept[*k].before == 0).map(step).collect();
    let usual = median(&whole);
    let is_break = |k: usize| gaps.binary_search_by_key(&k, |gap| gap.row).is_ok_and(|place| gaps[place].is_break);
    let others = (1..kept.len()).filter(|k| kept[*k].before > 0 && !is_break(*k));
    let is_uneven = |k: &usize| (step(*k) - (kept[*k].before + 1) as f64 * usual).abs() > 0.1 * usual;
    (whole, others.filter(is_uneven).count())
}

/// A column with its kept rows, and NaN where samples are missing.
fn placed(column: &[f64], kept: &[Kept]) -> Vec<f64> {
    let mut own = Vec::with_capacity(kept.iter().map(|kept| kept.before + 1).sum());
    for Kept { row, before } in kept {
        own.resize(own.len() + before, f64::NAN);
        own.push(column[*row]);
    }
    own
}

/// The time from one row to another: by their times, or by the interval.
pub(crate) fn elapsed(times_s: Option<&[f64]>, interval_s: f64) -> impl Fn(usize, usize) -> f64 {
    move |from, to| times_s.map_or((to - from) as f64 * interval_s, |times| times[to] - times[from])
}

/// Makes a trace of signals by columns at their places.
pub(crate) fn assemble(id: String, channels: &Channels, signals: &[Signal], rows: Rows) -> Result<Trace, Error> {
    let count = rows_of(&rows.columns, rows.times_s.as_deref());
    let Rows { columns, times_s, steps_s, uneven, missing, is_piece } = rows;
    let mut trace = Trace { id, ..Trace::default() };
    if times_s.is_some() {
        trace.interval_s = Some(median(&steps_s)).filter(|step| *step > 0.0);
        let usual = trace.interval_s.unwrap_or(0.0);
        let is_irregular = |step: &&f64| (**step - usual).abs() > 0.1 * usual;
        trace.irregular_steps = uneven + steps_s.par_iter().filter(is_irregular).count();
    }
    trace.interval_s = interval(&trace, channels.rate_hz)?;
    if trace.interval_s.is_none() && signals.iter().any(Signal::integrates) {
        return Err(Error::trace(&trace.id, INTEGRAL));
    }
    let elapsed: Elapsed<'_> = &elapsed(times_s.as_deref(), trace.interval_s.unwrap_or(0.0));
    let values = values_of(signals, columns, count, elapsed);
    trace.missing = counted(missing, &values);
    let is_empty = |own: &Vec<f64>| !is_piece && !own.iter().any(|x| x.is_finite());
    if let Some(k) = values.iter().position(is_empty) {
        let channel = channels.in_order().get(k).copied().unwrap_or_default();
        let problem = format!("channel {channel} has no number in any row; leave the trace out, or record it again");
        return Err(Error::trace(&trace.id, problem));
    }
    Ok(filled(trace, channels, values))
}

/// The interval by the time or by the rate, which must agree.
fn interval(trace: &Trace, rate_hz: Option<f64>) -> Result<Option<f64>, Error> {
    let given = rate_hz.map(|rate| 1.0 / rate);
    if let (Some(given), Some(found)) = (given, trace.interval_s)
        && !same_interval(given, found)
    {
        let problem = format!(
            "the time column has {:.5} rows a second, not {}; leave out the rate, or the time with --time {NO_TIME}",
            1.0 / found,
            1.0 / given
        );
        return Err(Error::trace(&trace.id, problem));
    }
    Ok(trace.interval_s.or(given))
}

/// Adds the samples that lack a channel.
fn counted(missing: Missing, values: &[Vec<f64>]) -> Missing {
    let count = values.first().map_or(0, Vec::len);
    let has_all = values.par_iter().all(|own| own.iter().fold(true, |all, x| all & x.is_finite()));
    let lacks = |row: &usize| values.iter().any(|own| !own[*row].is_finite());
    let lacking = if has_all { 0 } else { (0..count).filter(lacks).count() };
    let Missing { dropped, ends, .. } = missing;
    Missing { samples: count + ends, empty: lacking - dropped + ends, ..missing }
}

/// Puts the values, in the order of the channels, into the trace.
fn filled(mut trace: Trace, channels: &Channels, values: Vec<Vec<f64>>) -> Trace {
    let rows = values.first().map_or(0, Vec::len);
    let mut values = values.into_iter();
    let mut next = || values.next().unwrap_or_default();
    (trace.y, trace.u1, trace.u2) = (next(), next(), next());
    trace.further = channels.further.iter().map(|_| next()).collect();
    if let Some(shaft) = &channels.shaft {
        let (current_a, angle_rad) = (next(), next());
        let mut one = |is_measured: bool| if is_measured { next() } else { vec![0.0; rows] };
        let (velocity_rad_s, load_nm) = (one(shaft.velocity.is_some()), one(shaft.load.is_some()));
        let reference_rad_s = if shaft.reference.is_some() { next() } else { vec![] };
        trace.motion = Some(MotionTrace { current_a, angle_rad, velocity_rad_s, load_nm, reference_rad_s });
    }
    trace
}

#[cfg(test)]
mod tests;
