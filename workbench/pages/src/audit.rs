//! The page of an audit: what was found, signals, spectra over the orders of the shaft, and the smallest lines.

use crate::conclusion::recordings;
use crate::page::table::table;
use crate::page::{counted, linked, or_reason, paragraph};
use crate::plot::{self, Panel, Series};
use crate::{Color, Marker, Page};
use model::audit::column::Column;
use model::audit::friction::Excited;
use model::audit::orders;

/// Orders of a spectrum: the last one and their number.
const LAST_ORDER: f64 = 12.0;
const ORDERS: u32 = 600;
/// Below the order of a cage there are reference and load, whose lines would make all others small.
const FIRST_ORDER: f64 = 0.3;
/// Panels of one figure, and figures with all the points that one has.
const PANELS: usize = 8;
const DENSE: usize = 4;
/// Traces that the table of findings names.
const NAMED: usize = 4;

/// A recording as the page shows it.
#[derive(Clone, Debug)]
pub struct Recording<'a> {
    /// Its name.
    pub id: &'a str,
    /// Names of its columns.
    pub names: &'a [String],
    /// Time of each row, if it was recorded.
    pub times_s: Option<&'a [f64]>,
    /// Rate, if no time was recorded.
    pub rate_hz: Option<f64>,
    /// The columns.
    pub values: Vec<&'a [f64]>,
    /// What the columns are like.
    pub columns: &'a [Column],
    /// Spectrum of the current.
    pub spectrum: Option<Spectrum>,
}

/// Amplitude over the orders of the shaft.
#[derive(Clone, Debug)]
pub struct Spectrum {
    points: Vec<(f64, f64)>,
    /// The smallest line that stands out.
    smallest: f64,
}

impl Spectrum {
    /// The spectrum of a signal over the angle of the shaft.
    #[must_use]
    pub fn of(y: &[f64], angle_rad: &[f64], smallest: f64) -> Self {
        let orders: Vec<f64> = (1..=ORDERS).map(|k| LAST_ORDER * f64::from(k) / f64::from(ORDERS)).collect();
        let amplitudes = orders::spectrum(y, angle_rad, &orders);
        Self { points: orders.into_iter().zip(amplitudes).collect(), smallest }
    }
}

/// Levels of lines in one trace, in the unit of the current.
#[derive(Clone, Copy, Debug)]
pub struct LineLevels<'a> {
    /// The trace.
    pub trace: &'a str,
    /// Standard deviation of a line of noise.
    pub floor: f64,
    /// The smallest line that stands out.
    pub smallest: f64,
    /// The line of order 1.
    pub first: f64,
}

/// Creates the page of some recordings, of `count` in all.
#[must_use]
pub fn page(
    count: usize,
    findings: &[(&str, &[String])],
    shown: &[Recording],
    (lines, terms): (&[LineLevels], &[Excited]),
) -> Page {
    let title = match shown {
        [one] if count == 1 => format!("Recording {}", one.id),
        _ => "bearing-watch: audit".into(),
    };
    let mut page = Page::new(title)
        .conclusion(recordings::words(count, findings))
        .lead(format!("{}.", counted(count, "recording")))
        .section("Found", &found(findings));
    if shown.iter().any(|one| one.spectrum.is_some()) {
        page = page.section("Spectrum over the orders of the shaft", &spectra(shown));
    }
    if lines.len() > 1 {
        page = page.section("Smallest line that stands out", &levels(lines));
    }
    if !terms.is_empty() {
        page = page.section("Smallest change of friction", &friction(terms));
    }
    let figures: usize = shown.iter().map(|one| one.names.len().div_ceil(PANELS)).sum();
    for one in shown {
        let signals = signals(one, figures.div_ceil(DENSE));
        page = page.section(format!("Signals of {}", one.id), &(signals + &columns(one)));
    }
    if shown.len() < count {
        page = page.section("Further recordings", &paragraph(&format!("{} are not drawn.", count - shown.len())));
    }
    page
}

fn found(findings: &[(&str, &[String])]) -> String {
    if findings.is_empty() {
        return paragraph("Nothing.");
    }
    let row = |(what, traces): &(&str, &[String])| {
        let named = traces.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = if traces.len() > NAMED { ", …" } else { "" };
        vec![(*what).to_owned(), traces.len().to_string(), named + more]
    };
    table(&["what", "traces", "which"], &findings.iter().map(row).collect::<Vec<_>>())
}

fn spectra(shown: &[Recording]) -> String {
    let own = || shown.iter().filter_map(|one| Some((one.id, one.spectrum.as_ref()?)));
    let line = |(k, (id, spectrum)): (usize, (&str, &Spectrum))| {
        Series::new(id, Color::of(k), spectrum.points.iter().copied())
    };
    let mut series: Vec<Series> = own().enumerate().map(line).collect();
    if let Some(smallest) = own().map(|(_, spectrum)| spectrum.smallest).max_by(f64::total_cmp) {
        let name = if series.len() > 1 { "smallest line, largest of the traces" } else { "smallest line" };
        series.push(Series::new(name, Color::of(6), [(0.0, smallest), (LAST_ORDER, smallest)]).dashed());
    }
    let of_bearings = series.iter().flat_map(|one| &one.points).filter(|(order, _)| *order >= FIRST_ORDER);
    let view = [0.0, of_bearings.map(|(_, amplitude)| *amplitude).fold(0.0, f64::max)];
    let (x, y) = ("order of the shaft", "amplitude / unit of the current");
    or_reason(plot::lines_within(view, "Amplitude of the current", x, y, &series))
        + &paragraph("A line above the dashed one stands out of the noise at the chosen rate of false alarms.")
}

fn levels(lines: &[LineLevels]) -> String {
    let over = |name: &str, k: usize, pick: fn(&LineLevels) -> f64| {
        let points = lines.iter().enumerate().map(|(place, line)| (place as f64 + 1.0, pick(line)));
        Series::new(name, Color::of(k), points).marked(Marker::of(k))
    };
    let series = [
        over("floor", 0, |line| line.floor),
        over("smallest line", 1, |line| line.smallest),
        over("line of order 1", 2, |line| line.first),
    ];
    let (first, last) = (lines[0].trace, lines[lines.len() - 1].trace);
    let label = format!("trace, from {first} to {last}");
    or_reason(plot::lines("Lines of the current", &label, "amplitude / unit of the current", &series))
}

fn friction(terms: &[Excited]) -> String {
    let row = |one: &Excited| {
        let Excited { term, determined: [determined, traces], usual, own, by_noise, by_spread } = one;
        let spread = by_spread.map_or_else(|| "–".into(), |(change, n)| format!("{}, {n} traces", one.part(change)));
        let numbers = [format!("{own:.3}"), format!("{usual:.4}"), one.part(*by_noise), spread];
        let numbers = numbers.map(|text| text.replace('-', "−").replace(' ', "\u{a0}"));
        [vec![(*term).to_owned(), format!("{determined}/{traces}")], numbers.to_vec()].concat()
    };
    let header = ["term", "traces", "own part", "usual", "smallest change by noise", "by the spread of healthy traces"];
    table(&header, &terms.iter().map(row).collect::<Vec<_>>())
}

/// The columns, one of so many figures that share the points of one.
fn signals(one: &Recording, figures: usize) -> String {
    let (label, step) = match (one.times_s, one.rate_hz) {
        (Some(_), _) => ("time / s", 1.0),
        (None, Some(rate)) => ("time / s", 1.0 / rate),
        (None, None) => ("row", 1.0),
    };
    let at = |k: usize| one.times_s.map_or(k as f64 * step, |times| times.get(k).copied().unwrap_or(f64::NAN));
    let panel = |(k, (name, values)): (usize, (&String, &&[f64]))| {
        let points = values.iter().enumerate().map(|(row, value)| (at(row), *value));
        Panel::new(name, vec![Series::new(name, Color::of(k), points)])
    };
    let panels: Vec<Panel> = one.names.iter().zip(&one.values).enumerate().map(panel).collect();
    let figure = |panels: &[Panel]| or_reason(plot::signals_of_many("Signals", label, panels, figures));
    linked(&panels.chunks(PANELS).map(figure).collect::<String>())
}

fn columns(one: &Recording) -> String {
    let row = |(name, column): (&String, &Column)| {
        let Column { mean, deviation, range: [least, largest], step, .. } = column;
        let numbers = [*mean, *deviation, *least, *largest].map(|x| format!("{x:.5}").replace('-', "−"));
        [vec![name.clone()], numbers.to_vec(), vec![format!("{step:.2e}").replace('-', "−")]].concat()
    };
    let rows: Vec<Vec<String>> = one.names.iter().zip(one.columns).map(row).collect();
    table(&["column", "mean", "deviation", "least", "largest", "step"], &rows)
}
