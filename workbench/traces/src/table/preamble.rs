//! The rate of samples in the lines before a header.

use super::about::About;
use super::cells::Line;
use crate::units::{Quantity, Unit};

/// Names of a rate, and of the time from row to row, in lower case and without marks.
const RATES: [&str; 11] = [
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "fs",
    "rate",
    "ratehz",
    "frequencyofsamples",
    "abtastrate",
    "abtastfrequenz",
    "messrate",
];
const STEPS: [&str; 16] = [
    "sampleinterval",
    "samplinginterval",
    "sampletime",
    "samplingtime",
    "timestep",
    "increment",
    "deltax",
    "xincr",
    "xinc",
    "tinc",
    "hresolution",
    "deltat",
    "samplingperiod",
    "sampleperiod",
    "abtastzeit",
    "dt",
];

/// Seconds from row to row by these lines; a note says where from.
pub(super) fn step_s(lines: &[Line<'_>], comments: &[Line<'_>], about: &mut About) -> Option<f64> {
    let told = lines.iter().chain(comments).find_map(|line| Some((of_line(line.text)?, line)))?;
    let (step_s, line) = told;
    let rate = 1.0 / step_s;
    about.notes.push(format!("{rate:.6} rows a second by line {}; --rate-hz gives another rate", line.before + 1));
    Some(step_s)
}

/// The step, s, of a value of this name, such as `fs` or `dt`.
pub(super) fn of_value(name: &str, value: f64) -> Option<f64> {
    of_line(&format!("{name}={value}"))
}

/// By a line such as `Sample Rate,2000`, `# fs = 20 kHz`, `Delta_X\t0.001`.
pub(super) fn of_line(line: &str) -> Option<f64> {
    let line = line.trim_start_matches(['#', '%', ';']).trim();
    let at = line.find([',', ';', '\t', '=', ':'])?;
    let (name, rest) = line.split_at(at);
    let (name, of_name) = match name.split_once(['[', '(']) {
        Some((name, unit)) => (name, Some(unit.trim_end_matches([']', ')', ' ']))),
        None => (name, None),
    };
    let name: String = name.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase();
    let mut parts = rest.split([',', ';', '\t', '=', ':', ' ', '"']).filter(|part| !part.is_empty());
    let first = parts.next()?;
    let digits = first.trim_end_matches(|c: char| c.is_alphabetic());
    let value = digits.parse::<f64>().ok().filter(|value| *value > 0.0 && value.is_finite())?;
    let unit = Some(&first[digits.len()..]).filter(|unit| !unit.is_empty()).or(parts.next()).or(of_name).unwrap_or("");
    if RATES.contains(&name.as_str()) {
        let factor = match unit.to_lowercase().as_str() {
            "khz" | "ks/s" | "ksps" => 1e3,
            "mhz" | "ms/s" | "msps" => 1e6,
            _ => 1.0,
        };
        return Some(1.0 / (value * factor));
    }
    let seconds = Unit::named(unit).filter(|unit| unit.quantity == Quantity::Time);
    let factor = seconds.and_then(|unit| unit.to(&Unit::named("s")?)).map_or(1.0, |(factor, _)| factor);
    STEPS.contains(&name.as_str()).then_some(value * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_steps_are_found_in_any_notation() {
        for (line, step) in [
            ("Sample Rate,2000", Some(1.0 / 2000.0)),
            (";Sample rate,100000", Some(1e-5)),
            ("# fs = 20 kHz", Some(5e-5)),
            ("Sampling frequency [Hz]: 12500", Some(8e-5)),
            ("Delta_X\t0.001", Some(0.001)),
            ("\"Sample Interval\",2.5e-06,s", Some(2.5e-6)),
            ("Sampling time;250 us", Some(2.5e-4)),
            ("Period,1SEC", None),
            ("Motor Spec,L-CAHU-01R,1750", None),
            ("Rated speed,3000", None),
            ("Sample Rate,unknown", None),
        ] {
            let found = of_line(line);
            let near = found.zip(step).map_or(found == step, |(found, step)| (found / step - 1.0).abs() < 1e-12);
            assert!(near, "{line}: {found:?}");
        }
    }
}
