//! The rate of samples in the lines before the rows: known, asked, or none.
//!
//! ```text
//! each line ─► rates that it may mean, divisors, length    (`line`, with the decimal mark of the rows)
//!           ─► the one rate on which all lines agree       known
//!           ─► several, or lines that contradict           asked: no rate, and a note with the readings
//! ```
//!
//! A rate is behind all divisors, unless its line or another one says so. A step of few digits is rounded: the usual
//! rate that its last digit allows is taken. A rate outside of those that drives are recorded with is never taken.

#[cfg(test)]
mod combinations;
#[cfg(test)]
mod files;
mod line;
mod number;
mod value;
mod words;

pub(super) use number::Mark;

use crate::table::text::cells::Line;
use crate::time::usual_rate::{between, is_plausible};
use line::{Rate, Says, says};
use model::outputs::trimmed;

/// Relative difference of rates that agree, and of a rate and a step that is rounded to it.
const SAME: f64 = 2e-3;
const ROUNDED: f64 = 0.02;

/// What the lines say.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::table) enum Told {
    /// Rows a second, the line that has them, and the note.
    Known {
        rate_hz: f64,
        line: usize,
        note: String,
    },
    /// Why no rate is taken, and how to give one.
    Asked(String),
    Nothing,
}

impl Told {
    /// By a step, s, in the header, of which nothing is said if it is plausible.
    pub(super) fn of_header(step_s: f64) -> Self {
        let rate_hz = 1.0 / step_s;
        if is_plausible(rate_hz) {
            return Self::Known { rate_hz, line: 0, note: String::new() };
        }
        Self::Asked(format!("{} rows a second by the header, which no drive is recorded with; {GIVE}", short(rate_hz)))
    }

    /// The step, s, if the rate is known; a note says so, or why it is asked.
    pub(in crate::table) fn step_s(self, notes: &mut Vec<String>) -> Option<f64> {
        match self {
            Self::Known { rate_hz, note, .. } => {
                notes.extend(Some(note).filter(|note| !note.is_empty()));
                Some(1.0 / rate_hz)
            }
            Self::Asked(why) => {
                notes.push(why);
                None
            }
            Self::Nothing => None,
        }
    }

    /// What is said if the first times of a column have another rate.
    pub(super) fn beside(&self, name: &str, times_s: &[f64]) -> Option<String> {
        /// Relative difference of rates that are taken for one, beside the rounding of the times.
        const ROUNDED: f64 = 0.02;
        let Self::Known { rate_hz, line, .. } = self else { return None };
        let span = times_s.last()? - times_s.first()?;
        let count = (times_s.len() - 1) as f64;
        let steps = || times_s.windows(2).map(|pair| pair[1] - pair[0]);
        let scatter = steps().fold(0.0, f64::max) - steps().fold(f64::INFINITY, f64::min);
        let rate = count / span;
        let differs = span > 0.0 && (rate / rate_hz - 1.0).abs() > ROUNDED + scatter / span;
        differs.then(|| {
            format!(
                "time {name} has {} rows a second, and line {line} {}; the time is taken, --time none and --rate-hz \
                 give another rate",
                short(rate),
                short(*rate_hz)
            )
        })
    }
}

/// The length of a recording, s, half a unit of its last digit, and the line that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lasts {
    pub(super) seconds: f64,
    half: f64,
    line: usize,
}

/// A line that says something.
struct Saying<'a> {
    line: usize,
    text: &'a str,
    says: Says,
    is_final: bool,
}

/// A rate, the line that has it, and whether divisors do not apply.
#[derive(Clone, Copy)]
struct Base {
    rate: Rate,
    line: usize,
    is_final: bool,
}

/// What lines before the rows and comments say of the rate, and of the length of the recording.
pub(super) fn told(lines: &[Line<'_>], comments: &[Line<'_>], mark: Mark) -> (Told, Option<Lasts>) {
    let all = || lines.iter().chain(comments);
    let of_file = all().find_map(|line| match says(line.text, mark) {
        Some((Says::Decimals(mark), _)) => Some(mark),
        _ => None,
    });
    let mark = of_file.unwrap_or(mark);
    let sayings: Vec<Saying<'_>> = all()
        .filter_map(|line| {
            let (says, is_final) = says(line.text, mark)?;
            Some(Saying { line: line.before + 1, text: line.text.trim(), says, is_final })
        })
        .collect();
    let lasts = sayings.iter().find_map(|own| match own.says {
        Says::Lasts(length) => Some(Lasts { seconds: length.value, half: length.half, line: own.line }),
        _ => None,
    });
    (decided(&sayings), lasts)
}

/// The rate by a value of this name, such as `fs` or `dt`, in Hz or s if the name has no unit; `told` names it in
/// notes.
pub(in crate::table) fn of_value(name: &str, value: f64, told: &str) -> Told {
    let Some((Says::Rates(rates), _)) = says(&format!("{name}={value}"), Mark::Point) else { return Told::Nothing };
    let Some(Rate { hz: rate_hz, .. }) = rates.first().copied() else { return Told::Nothing };
    if !is_plausible(rate_hz) {
        let why = "rows a second, which no drive is recorded with";
        return Told::Asked(format!("{told} = {value}: {} {why}; {GIVE}", short(rate_hz)));
    }
    let note = format!("{rate_hz:.6} rows a second by {told}, if no column is the time; --rate-hz gives another rate");
    Told::Known { rate_hz, line: 0, note }
}

/// The step, s, by a cell such as `tInc = 4.0e-06`, if it has one reading; it need not be plausible.
pub(super) fn of_cell(cell: &str, mark: Mark) -> Option<f64> {
    let Some((Says::Rates(rates), _)) = says(cell, mark) else { return None };
    let [one] = rates[..] else { return None };
    (!one.is_guess).then(|| 1.0 / one.hz)
}

/// The rate on which all lines agree.
fn decided(sayings: &[Saying<'_>]) -> Told {
    let rates = |own: &Saying<'_>| match &own.says {
        Says::Rates(rates) => rates.iter().filter(|rate| is_plausible(rate.hz)).copied().collect(),
        _ => Vec::new(),
    };
    let lines: Vec<(&Saying<'_>, Vec<Rate>)> =
        sayings.iter().map(|own| (own, rates(own))).filter(|(_, rates)| !rates.is_empty()).collect();
    let is_unclear = |own: &&Saying<'_>| matches!(own.says, Says::Unclear(_)) && !own.is_final;
    if let Some(unclear) = sayings.iter().find(is_unclear) {
        return implausible(std::slice::from_ref(unclear));
    }
    let is_final = lines.iter().any(|(own, _)| own.is_final);
    let lines: Vec<_> = lines.into_iter().filter(|(own, _)| own.is_final == is_final).collect();
    if lines.is_empty() {
        return implausible(sayings);
    }
    let divisor = match divisor(sayings).filter(|_| !is_final) {
        Some(Err(why)) => return Told::Asked(why),
        other => other.and_then(Result::ok),
    };
    match agreed(&lines, divisor.map(|(count, _)| count)) {
        Ok(base) => known(base, divisor),
        Err(readings) => Told::Asked(asked(&lines, readings)),
    }
}

/// No line has a plausible rate: the first one that says a rate is told.
fn implausible(sayings: &[Saying<'_>]) -> Told {
    let why = |own: &Saying<'_>| match &own.says {
        Says::Rates(rates) => Some(match rates.first() {
            Some(rate) => format!("{} rows a second, which no drive is recorded with", short(rate.hz)),
            None => "no rate".into(),
        }),
        Says::Unclear(why) => Some((*why).to_string()),
        _ => None,
    };
    let first = sayings.iter().find_map(|own| Some((own, why(own)?)));
    match first {
        // A divisor alone gives no rate.
        Some((own, _)) if own.is_final => Told::Nothing,
        Some((own, why)) => Told::Asked(format!("line {}, {}: {why}; {GIVE}", own.line, quoted(own.text))),
        None => Told::Nothing,
    }
}

const GIVE: &str = "no rate is taken, give one with --rate-hz";

/// The divisor of all lines and its line; an error if they differ.
fn divisor(sayings: &[Saying<'_>]) -> Option<Result<(u32, usize), String>> {
    let mut all = sayings.iter().filter(|own| match own.says {
        Says::Divisor(count) => count > 1,
        Says::Unclear(_) => own.is_final,
        _ => false,
    });
    let first = all.next()?;
    let Says::Divisor(count) = first.says else {
        let text = quoted(first.text);
        return Some(Err(format!("line {}, {text}: it divides the rate by an unknown number; {GIVE}", first.line)));
    };
    match all.find(|own| own.says != first.says) {
        Some(other) => {
            Some(Err(format!("lines {} and {} divide the rate by different numbers; {GIVE}", first.line, other.line)))
        }
        None => Some(Ok((count, first.line))),
    }
}

/// The one rate of all lines, or those that they may mean.
fn agreed(lines: &[(&Saying<'_>, Vec<Rate>)], divisor: Option<u32>) -> Result<Base, Vec<f64>> {
    let same = |one: &Rate, other: &Rate| {
        let off = (one.hz / other.hz - 1.0).abs();
        off <= SAME || off <= ROUNDED && one.low.max(other.low) <= one.high.min(other.high)
    };
    let bases = lines
        .iter()
        .flat_map(|(own, rates)| rates.iter().map(|rate| Base { rate: *rate, line: own.line, is_final: own.is_final }));
    let of_all = |base: &Base| lines.iter().all(|(_, rates)| rates.iter().any(|rate| same(rate, &base.rate)));
    let mut left: Vec<Base> = bases.clone().filter(of_all).collect();
    // A unit that is guessed is settled by another line.
    if left.iter().any(|base| !base.rate.is_guess) {
        left.retain(|base| !base.rate.is_guess);
    }
    let exact = left.iter().copied().min_by(|one, other| width(&one.rate).total_cmp(&width(&other.rate)));
    if let Some(exact) = exact.filter(|exact| left.iter().all(|base| same(&base.rate, &exact.rate)))
        && !exact.rate.is_guess
    {
        return Ok(exact);
    }
    // One line has the rate before the divisor, another that behind it.
    let hertz = || bases.clone().map(|base| base.rate.hz);
    let (low, high) = hertz().fold((f64::INFINITY, 0.0_f64), |(low, high), hz| (low.min(hz), high.max(hz)));
    let is_end = |hz: f64| (hz / low - 1.0).abs() <= SAME || (hz / high - 1.0).abs() <= SAME;
    if divisor.is_some_and(|count| (high / low / f64::from(count) - 1.0).abs() <= SAME) && hertz().all(is_end) {
        let last = bases.clone().find(|base| base.rate.hz == low).filter(|base| !base.rate.is_guess);
        return last.map(|base| Base { is_final: true, ..base }).ok_or_else(|| vec![low, high]);
    }
    let all: Vec<f64> =
        if left.is_empty() { hertz().collect() } else { left.iter().map(|base| base.rate.hz).collect() };
    Err(all)
}

fn width(rate: &Rate) -> f64 {
    // Of a rate and a step as exact, the rate is none that is rounded.
    if rate.is_step { (rate.high - rate.low) / rate.hz } else { 0.0 }
}

/// The rate of a line behind the divisor.
fn known(base: Base, divisor: Option<(u32, usize)>) -> Told {
    let Base { rate, line, is_final } = base;
    let usual = if rate.is_step { between(rate.low, rate.high) } else { None };
    let before = usual.unwrap_or(rate.hz);
    let divisor = divisor.filter(|_| !is_final);
    let rate_hz = before / divisor.map_or(1.0, |(count, _)| f64::from(count));
    if !is_plausible(rate_hz) {
        let why = "rows a second by its divisor, which no drive is recorded with";
        return Told::Asked(format!("line {line}: {} {why}; {GIVE}", short(rate_hz)));
    }
    let by = match divisor {
        Some((count, of)) => format!("line {line}, {} divided by {count} in line {of}", short(before)),
        None => format!("line {line}"),
    };
    let is_rounded = usual.is_some_and(|usual| (usual / rate.hz - 1.0).abs() > 1e-9);
    let rounded = if is_rounded {
        format!(", whose rounded step allows {} to {}", short(rate.low), short(rate.high))
    } else {
        String::new()
    };
    let note = format!("{rate_hz:.6} rows a second by {by}{rounded}; --rate-hz gives another rate");
    Told::Known { rate_hz, line, note }
}

/// Why several rates are possible.
fn asked(lines: &[(&Saying<'_>, Vec<Rate>)], mut readings: Vec<f64>) -> String {
    readings.sort_by(f64::total_cmp);
    readings.dedup_by(|one, other| (*one / *other - 1.0).abs() <= SAME);
    let rates = readings.iter().map(|hz| short(*hz)).collect::<Vec<_>>().join(" or ");
    let places = lines.iter().map(|(own, _)| format!("line {}, {}", own.line, quoted(own.text)));
    let places = places.collect::<Vec<_>>().join(", and ");
    format!("{places}: {rates} rows a second; {GIVE}")
}

impl Lasts {
    /// Why this number of rows contradicts a rate; `None` if it does not.
    pub(super) fn contradicts(&self, rate_hz: f64, rows: usize) -> Option<String> {
        /// Part of the length that may be off.
        const OFF: f64 = 0.01;
        let (rows_s, rows) = (rows as f64 / rate_hz, rows as f64);
        let off = self.half + OFF * self.seconds + 2.0 / rate_hz;
        let differs = self.seconds > 0.0 && (rows_s - self.seconds).abs() > off;
        differs.then(|| {
            format!(
                "{} rows a second, or {} by {rows} rows in {} s of line {}; {GIVE}",
                short(rate_hz),
                short(rows / self.seconds),
                self.seconds,
                self.line
            )
        })
    }
}

/// A rate in few digits.
fn short(hz: f64) -> String {
    if hz >= 1.0 { trimmed(hz, 3) } else { format!("{hz:.3e}") }
}

/// A line in quotes, cut if it is long.
fn quoted(text: &str) -> String {
    const LONGEST: usize = 60;
    let cut: String = text.replace('\t', " ").chars().take(LONGEST).collect();
    format!("\"{cut}\"")
}
