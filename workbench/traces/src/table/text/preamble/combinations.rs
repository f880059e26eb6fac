//! Rates in many layouts and spellings: each is right, or asked with a note.

use super::Mark;
use crate::table::text::layout::Layout;
use model::trace::TextForm;

const RATES: [f64; 8] = [2000.0, 8000.0, 8192.0, 10_000.0, 12_500.0, 19_200.0, 25_600.0, 51_200.0];

/// How a file writes its rows and the lines before them.
struct Style {
    separator: char,
    mark: Mark,
    /// What is before a key, and between it and its value.
    start: &'static str,
    between: &'static str,
}

const STYLES: [Style; 12] = [
    Style { separator: ';', mark: Mark::Comma, start: "", between: ";" },
    Style { separator: ';', mark: Mark::Comma, start: "", between: ": " },
    Style { separator: ';', mark: Mark::Point, start: "", between: ";" },
    Style { separator: '\t', mark: Mark::Comma, start: "", between: "\t" },
    Style { separator: '\t', mark: Mark::Point, start: "# ", between: " = " },
    Style { separator: ',', mark: Mark::Point, start: "", between: "," },
    Style { separator: ',', mark: Mark::Point, start: "", between: ":," },
    Style { separator: ',', mark: Mark::Point, start: "% ", between: ": " },
    Style { separator: '|', mark: Mark::Point, start: "", between: "|" },
    Style { separator: ';', mark: Mark::Unknown, start: "", between: ";" },
    Style { separator: ',', mark: Mark::Unknown, start: "", between: "," },
    Style { separator: '\t', mark: Mark::Unknown, start: "", between: "\t" },
];

/// Names of rates and of steps.
const NAMES: [[&str; 15]; 2] = [
    [
        "Sample rate",
        "Abtastrate",
        "Sampling frequency",
        "SampleRate",
        "fs",
        "Messfrequenz",
        "Fréquence d'échantillonnage",
        "サンプリング周波数",
        "sampling_rate",
        "Abtastfrequenz",
        "Scan rate",
        "Acquisition rate",
        "Messrate",
        "Recording frequency",
        "Frecuencia de muestreo",
    ],
    [
        "Sample interval",
        "Abtastintervall",
        "Sampling time",
        "Delta_X",
        "dt",
        "Abtastzeit",
        "Période d'échantillonnage",
        "サンプリング周期",
        "sampling_period",
        "Zykluszeit",
        "Sample time",
        "Recording interval",
        "Cycle time",
        "XINCR",
        "Sampling Period",
    ],
];

/// Digits with a mark before the decimals.
fn decimals(value: f64, places: usize, mark: char) -> String {
    format!("{value:.places$}").replace('.', &mark.to_string())
}

/// The same without zeros at the end.
fn few(value: f64, mark: char) -> String {
    let all = decimals(value, 7, mark);
    all.trim_end_matches('0').trim_end_matches(mark).into()
}

fn grouped(value: f64, group: char) -> String {
    let digits = format!("{value:.0}");
    match digits.len().checked_sub(3) {
        Some(at) if at > 0 => format!("{}{group}{}", &digits[..at], &digits[at..]),
        _ => digits,
    }
}

fn scientific(value: f64, mark: char) -> String {
    let (digits, exponent) =
        format!("{value:.6e}").split_once('e').map(|(a, b)| (a.to_string(), b.to_string())).expect("an exponent");
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{}E{sign}{exponent}", digits.replace('.', &mark.to_string()))
}

/// How a rate may be written: whether it is a step, its number and its unit.
fn spellings(rate: f64, mark: char) -> Vec<(bool, String, &'static str)> {
    let group = if mark == ',' { '.' } else { ',' };
    let (khz, step) = (rate / 1e3, 1.0 / rate);
    vec![
        (false, format!("{rate}"), "Hz"),
        (false, format!("{rate}"), "samples/s"),
        (false, grouped(rate, group), "Hz"),
        (false, grouped(rate, '\u{202f}'), "Hz"),
        (false, grouped(rate, '\u{a0}'), "1/s"),
        (false, grouped(rate, ' '), "Hz"),
        (false, grouped(rate, '\''), "S/s"),
        (false, few(khz, mark), "kHz"),
        (false, few(khz, mark), "kS/s"),
        (false, decimals(khz, 3, mark), "kHz"),
        (false, few(khz / 1e3, mark), "MHz"),
        (false, scientific(rate, mark), "Hz"),
        (true, few(step * 1e6, mark), "us"),
        (true, few(step * 1e6, mark), "µs"),
        (true, decimals(step * 1e6, 3, mark), "usec"),
        (true, few(step * 1e3, mark), "ms"),
        (true, decimals(step, 9, mark), "s"),
        (true, scientific(step, mark), "s"),
        (true, format!("{:.0}", step * 1e9), "ns"),
    ]
}

/// A file of this style with these lines before its header.
fn file(style: &Style, lines: &[String]) -> String {
    let Style { separator, mark, start, .. } = style;
    let own = |value: f64| match mark {
        Mark::Comma => decimals(value, 4, ','),
        Mark::Point => decimals(value, 4, '.'),
        Mark::Unknown => format!("{:.0}", 1e3 * value),
    };
    let row = |k: usize| {
        let k = k as f64;
        let cells = [own(0.5 + 0.01 * k.sin()), own(32.0 - 0.1 * k.cos()), own(0.03 * k)];
        cells.join(&separator.to_string()) + "\n"
    };
    let names = ["iq_A", "omega_rad_s", "theta_rad"].join(&separator.to_string());
    let lines: String = lines.iter().map(|line| format!("{start}{line}\n")).collect();
    format!("{start}Recorder X1\n{lines}{names}\n{}", (0..14).map(row).collect::<String>())
}

/// The line of a rate, its unit behind the value, in the key, or in the next cell.
fn line(style: &Style, name: &str, (number, unit): (&str, &str), place: usize) -> String {
    let cell = |text: String| {
        let is_cell = style.separator == ',' && style.between.ends_with(',');
        if is_cell && text.contains(',') { format!("\"{text}\"") } else { text }
    };
    match place {
        0 => format!("{name}{}{}", style.between, cell(format!("{number} {unit}"))),
        1 => format!("{name} [{unit}]{}{}", style.between, cell(number.into())),
        _ => format!("{name}{}{}{}{unit}", style.between, cell(number.into()), style.separator),
    }
}

#[derive(Debug, Default)]
struct Counts {
    right: usize,
    asked: usize,
    wrong: Vec<String>,
    /// Asked although only one reading is possible.
    needless: Vec<String>,
}

impl Counts {
    fn add(&mut self, style: &Style, lines: &[String], (rate, number): (f64, &str)) {
        let layout = Layout::of(&file(style, lines), &TextForm::default());
        let about = layout.about;
        // One mark before three digits, and no row with a decimal mark.
        let marks = number.chars().filter(|c| matches!(c, '.' | ',')).count();
        let places = number.rsplit(['.', ',']).next().unwrap_or_default();
        let is_open = style.mark == Mark::Unknown && marks == 1 && places.len() == 3;
        match about.step_s {
            Some(step) if (1.0 / step / rate - 1.0).abs() < 1e-4 => self.right += 1,
            Some(step) => self.wrong.push(format!("{lines:?}: {}", 1.0 / step)),
            None if about.notes.iter().any(|note| note.contains("--rate-hz")) => {
                self.asked += 1;
                if !is_open {
                    self.needless.push(format!("{:?} {lines:?}: {:?}", style.mark, about.notes));
                }
            }
            None => self.wrong.push(format!("{lines:?}: no rate and no note, {:?}", layout.names)),
        }
    }

    fn check(&self, what: &str) {
        let all = self.right + self.asked + self.wrong.len();
        println!("{what}: {all} files, right {}, asked {}, wrong {}", self.right, self.asked, self.wrong.len());
        assert!(self.wrong.is_empty(), "{} wrong: {:#?}", self.wrong.len(), &self.wrong[..self.wrong.len().min(12)]);
        assert!(self.needless.is_empty(), "{:#?}", &self.needless[..self.needless.len().min(12)]);
        assert!(all > 1000 && self.right * 100 >= all * 85, "{} of {all} right", self.right);
    }
}

#[test]
fn rates_of_any_layout_and_spelling_are_right_or_asked() {
    let (mut counts, mut turn) = (Counts::default(), 0);
    for style in &STYLES {
        let mark = if style.mark == Mark::Comma { ',' } else { '.' };
        for rate in RATES {
            for (is_step, number, unit) in spellings(rate, mark) {
                turn += 1;
                let name = NAMES[usize::from(is_step)][turn % NAMES[0].len()];
                // A unit in the next cell is behind a value in a cell.
                let places = if style.between.ends_with(style.separator) { 3 } else { 2 };
                counts.add(style, &[line(style, name, (&number, unit), turn % places)], (rate, &number));
            }
        }
    }
    counts.check("one line");
}

/// A line that divides, in several languages, and a second line that agrees or contradicts.
#[test]
fn divided_repeated_and_contradicted_rates_are_right_or_asked() {
    let divisors = [
        "Downsampling",
        "Decimation factor",
        "Divider",
        "Teiler",
        "Unterabtastung",
        "Record every n-th",
        "Vorteiler",
        "間引き",
        "Sous-échantillonnage",
        "Period",
    ];
    let (mut counts, mut turn) = (Counts::default(), 0);
    for style in STYLES.iter().filter(|style| style.mark != Mark::Unknown) {
        let mark = if style.mark == Mark::Comma { ',' } else { '.' };
        for rate in RATES.into_iter().step_by(2) {
            for (is_step, number, unit) in spellings(rate, mark) {
                turn += 1;
                let of_kind = |is_step: bool| NAMES[usize::from(is_step)][turn % NAMES[0].len()];
                let base = line(style, of_kind(is_step), (&number, unit), 0);
                let divisor = [2, 4, 5, 8, 10][turn % 5];
                let by = format!("{}{}{divisor}", divisors[turn % divisors.len()], style.between);
                let divided = rate / f64::from(divisor);
                counts.add(style, &[base.clone(), by.clone()], (divided, &number));
                let (step, hertz) = (few(1e6 / rate, mark), few(rate, mark));
                let other = if is_step { (hertz.as_str(), "Hz") } else { (step.as_str(), "us") };
                let same = line(style, of_kind(!is_step), other, 0);
                counts.add(style, &[same.clone(), base.clone()], (rate, &number));
                let final_rate = few(divided, mark);
                let last = line(style, "Effective sample rate", (&final_rate, "Hz"), 0);
                counts.add(style, &[base.clone(), by, last], (divided, &number));
                let against = line(style, "Sample rate", (&few(1.5 * rate, mark), "Hz"), 0);
                let layout = Layout::of(&file(style, &[base, against]), &TextForm::default());
                let is_told = layout.about.notes.iter().any(|note| note.contains(" or ") && note.contains("--rate-hz"));
                assert!(layout.about.step_s.is_none() && is_told, "{:?}", layout.about);
            }
        }
    }
    counts.check("several lines");
}
