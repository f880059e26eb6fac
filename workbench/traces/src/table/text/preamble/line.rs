//! What one line before the rows says of the rate.
//!
//! ```text
//! Sampling Time [usec]:,100,100     key, its unit, and a value for each channel
//! fs = 12,5 kHz                     key, value and its unit
//! recorded every 4th sample         a sentence
//! ```

use super::number::{Mark, Number, readings};
use super::value::{MARKS, Value, begins_with_number, unit_of, values};
use super::words::{Kind, Scale, folded, is_final, kind, scale};
use crate::time::usual_rate::is_plausible;

/// Steps without a unit from which ms and us are as likely as s.
const UNIT_NEEDED_S: f64 = 0.01;
/// Rates below which the other reading of a mark is looked at: hardly a drive is recorded so slowly.
const SLOW_HZ: f64 = 100.0;

/// What a line says.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Says {
    /// Rates that it may mean.
    Rates(Vec<Rate>),
    /// It says a rate or a divisor that is not understood, and why.
    Unclear(&'static str),
    /// Only one of this number of samples is a row.
    Divisor(u32),
    /// The length of the recording, s.
    Lasts(Number),
    Decimals(Mark),
}

/// A rate, with those that the last digit of a step allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rate {
    pub(super) hz: f64,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Whether its unit is guessed.
    pub(super) is_guess: bool,
    /// Whether it is told by a step.
    pub(super) is_step: bool,
}

/// What a line says, and whether no divisor applies to it.
pub(super) fn says(line: &str, mark: Mark) -> Option<(Says, bool)> {
    let text = line.trim_matches(|c: char| c.is_whitespace() || matches!(c, '#' | '%' | ';' | '/' | '*' | '!'));
    let by_key = keyed(text).and_then(|(key, own, rest)| {
        let unit = scale_of_key(key);
        let says = match own {
            Kind::DecimalMark => decimals(rest),
            Kind::Divisor => divisor(rest, mark, unit),
            Kind::Skipped => skipped(rest),
            _ => quantity(own, values(rest, mark), unit, mark),
        }?;
        Some((says, is_final(&folded(key)) || matches!(own, Kind::Divisor | Kind::Skipped)))
    });
    by_key.or_else(|| Some((every(text, mark)?, false)))
}

/// The key of a line, what it says, and what is behind it.
fn keyed(text: &str) -> Option<(&str, Kind, &str)> {
    if let Some((cell, rest)) = text.strip_prefix('"').and_then(|text| text.split_once('"')) {
        return keyed(cell)
            .filter(|(_, _, value)| begins_with_number(value))
            .or_else(|| Some((cell, kind_of(cell)?, rest)));
    }
    let mut depth = 0;
    let is_mark = |c: char| {
        depth += i32::from(matches!(c, '[' | '(')) - i32::from(matches!(c, ']' | ')'));
        depth <= 0 && MARKS.contains(&c)
    };
    let by_mark = text.find(is_mark);
    let is_blank = |before: &str| before.ends_with(char::is_whitespace);
    let by_digit = text.char_indices().find(|(at, c)| c.is_ascii_digit() && is_blank(&text[..*at])).map(|(at, _)| at);
    let all = [by_mark.or(Some(text.len())), by_digit].into_iter().flatten().filter_map(|at| {
        let (key, rest) = text.split_at(at);
        Some((key, kind_of(key)?, rest))
    });
    let all: Vec<_> = all.collect();
    all.iter().find(|(_, _, rest)| begins_with_number(rest)).or(all.first()).copied()
}

fn kind_of(key: &str) -> Option<Kind> {
    let (name, _) = without_unit(key);
    kind(&folded(name))
}

fn scale_of_key(key: &str) -> Option<Scale> {
    without_unit(key).1
}

/// A key without its unit: [Hz], (Hz), / Hz, in Hz, _hz.
fn without_unit(key: &str) -> (&str, Option<Scale>) {
    /// Units at the end of a word of several, as in `sampleRateHz`.
    const ENDS: [&str; 9] = ["kHz", "KHz", "MHz", "Hz", "Us", "Ms", "Ns", "Usec", "Msec"];
    let key = key.trim().trim_end_matches([':', '=']).trim_end();
    if let Some((name, unit)) = key.split_once(['[', '(']) {
        let unit = unit.split([']', ')']).next().unwrap_or_default();
        return (name.trim_end(), scale(unit));
    }
    let last = key.rfind([' ', '_', '/']).map(|at| (&key[..at], scale(&key[at + 1..])));
    if let Some((name, Some(unit))) = last {
        let name = name.trim_end_matches([' ', '/', '_']);
        return (name.strip_suffix(" in").unwrap_or(name), Some(unit));
    }
    let end = ENDS.iter().find(|end| key.strip_suffix(**end).is_some_and(|name| name.ends_with(char::is_alphanumeric)));
    end.map_or((key, None), |end| (&key[..key.len() - end.len()], scale(end)))
}

fn decimals(rest: &str) -> Option<Says> {
    let value = rest.trim_end().trim_end_matches('"');
    let is = |words: [&str; 3]| words.iter().any(|word| value.to_lowercase().ends_with(word));
    match () {
        () if is([",", "comma", "komma"]) => Some(Says::Decimals(Mark::Comma)),
        () if is([".", "point", "punkt"]) => Some(Says::Decimals(Mark::Point)),
        () => None,
    }
}

/// What the values of a rate, a step or a length are.
fn quantity(own: Kind, values: Result<Vec<Value>, &'static str>, unit: Option<Scale>, mark: Mark) -> Option<Says> {
    let is_strong = matches!(own, Kind::Rate | Kind::Step | Kind::StepInSeconds);
    let values = match values {
        Ok(values) => values,
        Err(why) => return is_strong.then_some(Says::Unclear(why)),
    };
    let scale = |value: &Value| value.scale.or(unit);
    let first = values.first()?;
    match (own, scale(first)) {
        (Kind::Duration, Some(Scale::Seconds(factor))) => {
            let [one] = first.numbers[..] else { return None };
            return Some(Says::Lasts(Number { value: one.value * factor, half: one.half * factor }));
        }
        (Kind::Duration, _) | (Kind::ByUnit, None) => return None,
        (Kind::Period, None) => return counted(&first.numbers),
        _ => {}
    }
    let each = |value: &Value| {
        let likely = value.numbers.iter().map(|number| rates(own, *number, scale(value))).collect();
        likeliest(likely, mark != Mark::Unknown)
    };
    let all: Vec<Rate> = values.iter().flat_map(each).collect();
    let is_other = own == Kind::Period && !all.iter().any(|rate| is_plausible(rate.hz));
    (!is_other).then_some(Says::Rates(all))
}

/// A whole number of samples.
fn counted(numbers: &[Number]) -> Option<Says> {
    let [one] = numbers else { return None };
    let is_whole = one.value.fract() == 0.0 && (1.0..1e6).contains(&one.value);
    is_whole.then_some(Says::Divisor(one.value as u32))
}

/// The rates of a number: without a unit, a step may be of several.
fn rates(own: Kind, Number { value, half }: Number, unit: Option<Scale>) -> Vec<Rate> {
    let of_rate = |factor: f64| {
        let hz = value * factor;
        Rate { hz, low: hz, high: hz, is_guess: false, is_step: false }
    };
    let of_step = |factor: f64, is_guess: bool| {
        let (step, half) = (value * factor, half * factor);
        Rate { hz: 1.0 / step, low: 1.0 / (step + half), high: 1.0 / (step - half), is_guess, is_step: true }
    };
    match (own, unit) {
        (_, Some(Scale::Hertz(factor))) => vec![of_rate(factor)],
        (_, Some(Scale::Seconds(factor))) => vec![of_step(factor, false)],
        (Kind::Rate | Kind::ByUnit, None) => vec![of_rate(1.0)],
        (Kind::Step, None) if value >= UNIT_NEEDED_S => [1.0, 1e-3, 1e-6].map(|factor| of_step(factor, true)).to_vec(),
        _ => vec![of_step(1.0, false)],
    }
}

/// The rates of the likeliest reading that has a plausible one, if the mark of decimals is known and no other reading
/// is as likely; else those of all.
fn likeliest(readings: Vec<Vec<Rate>>, is_known: bool) -> Vec<Rate> {
    let plausible = |rates: &&Vec<Rate>| rates.iter().any(|rate| is_plausible(rate.hz));
    let first = readings.iter().find(plausible);
    let is_slow = |rates: &Vec<Rate>| rates.iter().all(|rate| rate.hz < SLOW_HZ);
    match first {
        Some(first) if is_known && !is_slow(first) => first.clone(),
        _ => readings.concat(),
    }
}

/// The divisor behind its key: 4, 4x, 1:4, every 4th; a rate is that behind the divisor.
fn divisor(rest: &str, mark: Mark, unit: Option<Scale>) -> Option<Says> {
    let text = rest.trim_start_matches(|c: char| MARKS.contains(&c) || c.is_whitespace() || c == '"');
    if let Ok(values) = values(rest, mark)
        && !values.is_empty()
        && values.iter().all(|value| value.scale.or(unit).is_some())
    {
        return quantity(Kind::Rate, Ok(values), unit, mark);
    }
    let cell = text.split([';', '\t', '|', '"']).next().unwrap_or_default().trim().to_lowercase();
    let is = |words: &[&str]| words.contains(&cell.as_str());
    if is(&["", "on", "yes", "ein", "an", "ja", "true", "enabled", "aktiv"]) {
        return None;
    }
    if is(&["off", "no", "none", "aus", "nein", "keine", "false", "disabled", "inaktiv", "0"]) {
        return Some(Says::Divisor(1));
    }
    let ratio = cell.trim_start_matches(['x', '÷', '/']).split_once([':', '/']);
    let whole = match ratio.map(|(one, other)| (one.trim(), other.trim())) {
        Some(("1", other)) => other.to_string(),
        Some((one, "1")) => one.to_string(),
        _ => cell.chars().skip_while(|c| !c.is_ascii_digit()).collect(),
    };
    let (numbers, behind) = readings(&whole, mark);
    // Behind the number: x, th, samples.
    let is_count = behind.is_empty() || behind.starts_with([' ', '.', ',', 'x', 't', 'n', 'r', 's']);
    let says = if is_count { counted(&numbers) } else { None };
    says.or(Some(Says::Unclear("its divisor is not understood")))
}

/// Samples that are left out: of so many one is a row, or of one more.
fn skipped(rest: &str) -> Option<Says> {
    let digits: String = rest.chars().filter(char::is_ascii_digit).collect();
    match digits.as_str() {
        "" | "0" => None,
        _ => Some(Says::Unclear("its divisor is not understood")),
    }
}

/// By a sentence such as `recorded every 4th sample`, or `every 125 us`.
fn every(text: &str, mark: Mark) -> Option<Says> {
    const EVERY: [&str; 9] = ["every", "each", "jede", "jeder", "jeden", "jedes", "alle", "chaque", "les"];
    const SAMPLES: [&str; 11] =
        ["sampl", "row", "wert", "punkt", "point", "mess", "zyk", "cycle", "period", "takt", "valeur"];
    let lower = text.to_lowercase();
    let (at, word) = EVERY.iter().find_map(|word| {
        let at = lower.find(&format!("{word} "))?;
        lower[..at].ends_with(|c: char| !c.is_alphanumeric()).then_some((at, word)).or((at == 0).then_some((0, word)))
    })?;
    let (numbers, behind) = readings(&lower[at + word.len()..], mark);
    let behind = behind.trim_start();
    if numbers.is_empty() {
        return None;
    }
    if let Some((Scale::Seconds(factor), _)) = unit_of(behind) {
        return quantity(Kind::Step, Ok(vec![Value { numbers, scale: Some(Scale::Seconds(factor)) }]), None, mark);
    }
    let ordinal =
        ["th", "nd", "rd", "st", "te", "ten", "ter", ".", "e", "ème"].iter().find(|end| behind.starts_with(**end));
    let noun = ordinal.map_or(behind, |end| &behind[end.len()..]).trim_start();
    SAMPLES.iter().any(|stem| noun.starts_with(stem)).then(|| counted(&numbers)).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates_of(line: &str, mark: Mark) -> Vec<f64> {
        match says(line, mark) {
            Some((Says::Rates(all), _)) => all.iter().map(|rate| rate.hz).filter(|rate| is_plausible(*rate)).collect(),
            _ => vec![],
        }
    }

    #[test]
    fn rates_and_steps_are_read_in_any_notation() {
        use Mark::{Comma, Point, Unknown};
        let cases: [(&str, Mark, &[f64]); 63] = [
            ("Sample Rate,2000", Unknown, &[2000.0]),
            (";Sample rate,100000", Unknown, &[1e5]),
            ("# fs = 20 kHz", Unknown, &[2e4]),
            ("Sampling frequency [Hz]: 12500", Unknown, &[12_500.0]),
            ("Delta_X\t0.001", Point, &[1000.0]),
            ("\"Sample Interval\",2.5e-06,s", Unknown, &[4e5]),
            ("Sampling time;250 us", Unknown, &[4000.0]),
            ("Sampling Time [usec]:,100", Unknown, &[1e4]),
            ("Abtastrate;12,5 kHz", Comma, &[12_500.0]),
            ("Abtastrate;51,2 kHz", Comma, &[51_200.0]),
            ("Delta_X\t1,250000E-4\t1,250000E-4", Comma, &[8000.0]),
            ("Abtastrate [Hz];8.000", Comma, &[8000.0]),
            ("\"Sample rate\",\"10,000\"", Point, &[10_000.0]),
            ("Sample rate,10,000", Point, &[10_000.0]),
            ("Sample rate: 10 000 Hz", Point, &[10_000.0]),
            ("Abtastrate: 10'000 Hz", Point, &[10_000.0]),
            ("Fréquence d'échantillonnage;51\u{202f}200 Hz", Comma, &[51_200.0]),
            ("サンプリング周波数,20,kHz", Unknown, &[2e4]),
            ("サンプリング周期,50,us", Unknown, &[2e4]),
            ("Sample rate;2000;2000;2000", Unknown, &[2000.0]),
            ("Sample rate: 8000 Hz, 16 bit", Unknown, &[8000.0]),
            ("Sample rate 2000 Hz", Unknown, &[2000.0]),
            ("sample_rate_hz=25600", Unknown, &[25_600.0]),
            ("sampleRateKHz: 25.6", Point, &[25_600.0]),
            ("dt_us\t125", Unknown, &[8000.0]),
            ("Sample rate (kHz)=19.2", Point, &[19_200.0]),
            ("Abtastrate in kHz;19,2", Comma, &[19_200.0]),
            ("Rate 2.5 kS/s, filter on", Point, &[2500.0]),
            ("Zykluszeit;125 µs", Comma, &[8000.0]),
            ("Control cycle time: 125 us", Comma, &[8000.0]),
            ("Sampling: 10 kSa/s", Unknown, &[1e4]),
            ("dt = 1/8000 s", Unknown, &[8000.0]),
            ("recorded every 125 us", Unknown, &[8000.0]),
            ("Sampling rate (samples/s):;8000", Unknown, &[8000.0]),
            ("Fs: 8000 Samples per second", Unknown, &[8000.0]),
            ("\"Sample rate: 8000 Hz\"", Unknown, &[8000.0]),
            ("fs = 12,5 kHz", Point, &[12_500.0]),
            ("fs = 1.250.000", Unknown, &[1.25e6]),
            ("fs = 1.250,5", Point, &[1250.5]),
            ("fs = 1,250.5", Unknown, &[1250.5]),
            ("fs = 10\u{202f}000,5", Comma, &[10_000.5]),
            ("fs = 51\u{a0}200", Point, &[51_200.0]),
            ("fs = 2e4Hz", Unknown, &[2e4]),
            ("dt = 1,250E-4 s", Unknown, &[8000.0]),
            ("Sample rate: 2000 2000 2000", Unknown, &[2000.0]),
            ("Sample rate;2000 Hz;;2000 Hz", Unknown, &[2000.0]),
            ("Sample rate;2000;Hz;Channels;3", Unknown, &[2000.0]),
            // Two readings.
            ("fs = 8.000", Point, &[8.0, 8000.0]),
            ("Abtastrate;8.000", Unknown, &[8.0, 8000.0]),
            ("Abtastrate;50,000 Hz", Comma, &[50.0, 50_000.0]),
            ("Sampling time;0.1", Point, &[10.0, 1e4]),
            // None.
            ("Motor Spec,L-CAHU-01R,1750", Unknown, &[]),
            ("Period,1SEC", Unknown, &[]),
            ("Rated speed,3000", Unknown, &[]),
            ("Sample Rate,unknown", Unknown, &[]),
            ("fs = 1.2.3", Unknown, &[]),
            ("fs = 1,25,5", Unknown, &[]),
            ("Sample rate,12,5,kHz", Unknown, &[]),
            ("Sample rate: 17:18:18", Unknown, &[]),
            ("Sample rate;2000;8000", Unknown, &[]),
            ("Sample rate;8 kFoo", Unknown, &[]),
            ("Sample rate: 8000 Hz / 4", Unknown, &[]),
            ("Sample rate: ~8000 Hz", Unknown, &[]),
        ];
        for (line, mark, expected) in cases {
            let all = rates_of(line, mark);
            let near = |(one, other): (&f64, &f64)| (one / other - 1.0).abs() < 1e-9;
            assert!(all.len() == expected.len() && all.iter().zip(expected).all(near), "{line}: {all:?}");
        }
    }

    #[test]
    fn divisors_lengths_and_marks_are_read() {
        for (line, expected) in [
            ("Downsampling;4", Some(Says::Divisor(4))),
            ("Decimation factor: 4x", Some(Says::Divisor(4))),
            ("Teiler\t1:8", Some(Says::Divisor(8))),
            ("record every n-th,10", Some(Says::Divisor(10))),
            ("# every 4th sample", Some(Says::Divisor(4))),
            ("Aufzeichnung: jeder 4. Wert", Some(Says::Divisor(4))),
            ("Decimation: every 4th", Some(Says::Divisor(4))),
            ("Period,8", Some(Says::Divisor(8))),
            ("Downsampling;off", Some(Says::Divisor(1))),
            ("Decimation;two", Some(Says::Unclear("its divisor is not understood"))),
            ("Downsampling;On", None),
            ("Skip samples;3", Some(Says::Unclear("its divisor is not understood"))),
            ("Skip samples;0", None),
            ("Messdauer;2,5 s", Some(Says::Lasts(Number { value: 2.5, half: 0.05 }))),
            ("Duration,5", None),
            ("Decimal_Separator\t,", Some(Says::Decimals(Mark::Comma))),
            ("Decimal_Separator\t.", Some(Says::Decimals(Mark::Point))),
        ] {
            assert_eq!(says(line, Mark::Comma).map(|(says, _)| says), expected, "{line}");
        }
        assert!(matches!(says("Sample rate after decimation;2 kHz", Mark::Comma), Some((Says::Rates(_), true))));
    }
}
