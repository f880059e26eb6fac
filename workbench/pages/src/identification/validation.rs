//! The page of validated estimates.

use crate::conclusion::models;
use crate::page::table::table;
use crate::page::{linked, or_reason, paragraph};
use crate::plot::{self, CorrelationPanel, Lag, MapGroup, MapPoint, Panel, Series};
use crate::{Color, Page};
use model::identify::{Estimate, Structure, Terms};
use model::trace::Trace;
use model::validate::response::{self, Input, Uncertain};
use model::validate::roots::Root;
use model::validate::{Correlation, REGION_SIGMAS, Test, Validation};

/// Two-sided 95 % quantile of the standard normal distribution.
const NORMAL_95: f64 = 1.959_964;

/// A trace, its model, and the results of the tests of the model.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The trace from which the model was estimated.
    pub trace: Trace,
    /// The model.
    pub estimate: Estimate,
    /// Results of the tests.
    pub found: Validation,
}

/// The page: a table of all traces, and all plots of the first trace.
#[must_use]
pub fn page(lead: &str, outcomes: &[Outcome]) -> String {
    let first = &outcomes[0];
    let words = models::validated(outcomes.iter().map(|own| (own.trace.id.as_str(), &own.found)));
    let mut page = Page::new(format!("Model of {}", first.trace.id)).conclusion(words).lead(lead);
    if outcomes.len() > 1 {
        let short = |test: &Test| {
            format!("{}, {} of {}", if test.passed() { "pass" } else { "FAIL" }, test.outside, test.tested)
        };
        let row = |o: &Outcome| {
            let fits = [o.found.simulation_fit_percent, o.found.prediction_fit_percent].map(|f| format!("{f:.1}"));
            [vec![o.trace.id.clone(), short(&o.found.independence), short(&o.found.whiteness)], fits.to_vec()].concat()
        };
        let header =
            ["trace", "independence, lags outside", "whiteness, lags outside", "simulation fit %", "one-step fit %"];
        let rows: Vec<_> = outcomes.iter().map(row).collect();
        let html = table(&header, &rows) + &paragraph("What follows is the first trace.");
        page = page.section("All traces", &html);
    }
    for (heading, html) in sections(&first.trace, &first.estimate, &first.found) {
        page = page.section(heading, &html);
    }
    page.render()
}

/// Headings and bodies of the sections for one trace.
fn sections(trace: &Trace, estimate: &Estimate, found: &Validation) -> Vec<(&'static str, String)> {
    vec![
        ("Residual tests", tests(found)),
        ("Order: poles, zeros and cross-correlations", order_figure(found)),
        (
            "Whiteness",
            or_reason(correlations("Autocorrelation of the residuals", &[("residuals", &found.autocorrelation)])),
        ),
        ("Simulated against measured", simulated(trace, found)),
        ("Step responses", steps(trace, estimate)),
        ("Frequency responses", frequencies(trace, estimate)),
        ("Parameters", parameters(estimate)),
    ]
}

fn tests(found: &Validation) -> String {
    let row = |name: &str, test: &Test, verdict: &str| {
        vec![
            name.to_string(),
            verdict.to_string(),
            test.tested.to_string(),
            format!("{} ({})", test.outside, test.allowed),
            format!("{:.1} ({:.1})", test.largest, test.limit),
        ]
    };
    let verdict = |test: &Test, yes: &'static str, no: &'static str| match test.tested {
        0 => "nothing to test",
        _ if test.passed() => yes,
        _ => no,
    };
    let header = ["test", "verdict", "lags tested", "outside (allowed)", "largest, sd (allowed)"];
    let rows = [
        row("independence of past inputs", &found.independence, verdict(&found.independence, "pass", "FAIL")),
        row("whiteness", &found.whiteness, verdict(&found.whiteness, "pass", "FAIL")),
        row("feedback (future inputs)", &found.feedback, verdict(&found.feedback, "not seen", "seen")),
    ];
    table(&header, &rows)
        + &paragraph(&format!(
            "Simulation fit {:.1} %: the model runs on its inputs alone. One-step prediction fit {:.1} %: it starts \
             anew from every measured output, and so says less of a model.",
            found.simulation_fit_percent, found.prediction_fit_percent
        ))
        + &paragraph(
            "Independence must hold for any model; whiteness for least squares, which is biased without it. Feedback says \
             how the signals were made, not that the model is wrong. A true model exceeds the allowed figures in about 1 % \
             of records.",
        )
}

fn correlations(title: &str, panels: &[(&str, &Correlation)]) -> Result<String, crate::ReportError> {
    let lags = |one: &Correlation| {
        let each = one.lags.iter().zip(&one.value).zip(&one.bound);
        each.map(|((&lag, &value), &bound)| Lag { lag, value, bound }).collect()
    };
    let panel = |(label, one): &(&str, &Correlation)| CorrelationPanel { label: (*label).into(), lags: lags(one) };
    plot::correlations(title, "99 % band of a true model", &panels.iter().map(panel).collect::<Vec<_>>())
}

/// The figure for the choice of the order: the pole-zero map and both cross-correlations.
fn order_figure(found: &Validation) -> String {
    let map = &found.map;
    let group = |name: &str, index: usize, poles: bool, roots: &[Root]| {
        let point = |root: &Root| MapPoint { at: (root.at.re, root.at.im), outline: root.outline(REGION_SIGMAS) };
        MapGroup { name: name.into(), color: Color::of(index), poles, points: roots.iter().map(point).collect() }
    };
    let groups = [
        group("poles", 0, true, &map.poles),
        group("zeros from u1", 1, false, &map.zeros[0]),
        group("zeros from u2", 2, false, &map.zeros[1]),
    ];
    let of = |index: usize| &found.cross_correlation[index];
    or_reason(plot::pole_zero("Poles and zeros with 3σ regions", &groups))
        + &paragraph(&cancellation(found))
        + &roots_table(found)
        + &or_reason(correlations(
            "Cross-correlation of the residuals with each input; positive lags are past inputs",
            &[("with u1", of(0)), ("with u2", of(1))],
        ))
        + &paragraph(
            "The band is that of the estimated noise, its colour and the parameters that were estimated; at lags that the \
             fit itself brings to zero it has no width, and nothing is tested.",
        )
}

/// Text on overlapping confidence regions.
#[must_use]
pub fn cancellation(found: &Validation) -> String {
    let map = &found.map;
    let named = |pole: usize| place(&map.poles[pole]);
    if !map.removable.is_empty() {
        let upper = map.removable.iter().filter(|&&pole| map.poles[pole].at.im >= 0.0);
        let poles: Vec<String> = upper.map(|&pole| named(pole)).collect();
        return format!(
            "Near-cancellation from every input: the region of pole {} meets that of a zero of each input; try an order \
             with one a, b and c fewer.",
            poles.join(", ")
        );
    }
    if map.overlaps.is_empty() {
        return "No region of a pole meets that of a zero: nothing cancels.".into();
    }
    let pairs: Vec<String> = map
        .overlaps
        .iter()
        .filter(|pair| map.poles[pair.pole].at.im >= 0.0)
        .map(|pair| format!("pole {} from u{}", named(pair.pole), pair.input + 1))
        .collect();
    format!("Near-cancellation from one input only, which the other needs: {}.", pairs.join("; "))
}

fn place(root: &Root) -> String {
    let text = if root.is_real() {
        format!("{:.4}", root.at.re)
    } else {
        format!("{:.4} ± {:.4}i", root.at.re, root.at.im.abs())
    };
    text.replace('-', "−")
}

fn roots_table(found: &Validation) -> String {
    let map = &found.map;
    let lists = [("pole", &map.poles), ("zero from u1", &map.zeros[0]), ("zero from u2", &map.zeros[1])];
    let all = lists.into_iter().flat_map(|(name, roots)| roots.iter().map(move |root| (name, root)));
    let rows: Vec<Vec<String>> = all
        .filter(|(_, root)| root.at.im >= 0.0)
        .map(|(name, root)| {
            let sd = |k: usize| format!("{:.2e}", root.covariance[(k, k)].sqrt()).replace('-', "−");
            let pair = if root.is_real() { "–".into() } else { sd(1) };
            vec![name.into(), place(root), format!("{:.4}", root.at.norm()), sd(0), pair]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let close: Vec<String> = map
        .poles
        .iter()
        .chain(map.zeros.iter().flatten())
        .filter(|r| !r.separated && r.at.im >= 0.0)
        .map(place)
        .collect();
    let warning = match close.len() {
        0 => String::new(),
        _ => paragraph(&format!(
            "The regions of {} reach towards a neighbouring root: there the linearisation fails, and they are no more than \
             a warning.",
            close.join(", ")
        )),
    };
    table(&["", "place", "radius", "sd, real", "sd, imaginary"], &rows) + &warning
}

fn interval(trace: &Trace) -> (f64, &'static str) {
    trace.interval_s.map_or((1.0, "samples"), |step| (step, "s"))
}

fn simulated(trace: &Trace, found: &Validation) -> String {
    let (step, unit) = interval(trace);
    let points = |x: &[f64]| x.iter().enumerate().map(|(k, x)| (k as f64 * step, *x)).collect::<Vec<_>>();
    let error: Vec<f64> = trace.y.iter().zip(&found.simulated).map(|(y, s)| y - s).collect();
    let panels = [
        Panel::new(
            "output",
            vec![
                Series::new("measured", Color::of(6), points(&trace.y)),
                Series::new("simulated", Color::of(0), points(&found.simulated)),
            ],
        ),
        Panel::new("measured − simulated", vec![Series::new("error", Color::of(1), points(&error))]),
    ];
    let title = format!("Output from the inputs alone, fit {:.1} %", found.simulation_fit_percent);
    or_reason(plot::signals(&title, &format!("time / {unit}"), &panels))
}

fn banded(name: &str, color: Color, points: &[(f64, Uncertain)]) -> Series {
    let band = points.iter().map(|&(x, u)| (x, u.band(NORMAL_95).0, u.band(NORMAL_95).1)).collect::<Vec<_>>();
    Series::new(name, color, points.iter().map(|&(x, u)| (x, u.value))).with_band(band)
}

fn inputs(order: Structure) -> Vec<(Input, &'static str, Color)> {
    let all = [(order.nb, (Input::U1, "u1", Color::of(0))), (order.nc, (Input::U2, "u2", Color::of(1)))];
    all.into_iter().filter(|(terms, _)| *terms > 0).map(|(_, input)| input).collect()
}

fn steps(trace: &Trace, estimate: &Estimate) -> String {
    let (step, unit) = interval(trace);
    let samples = response::settling(estimate);
    let panels: Vec<Panel> = inputs(estimate.structure)
        .into_iter()
        .map(|(input, name, color)| {
            let response = response::step(estimate, input, samples);
            let points: Vec<_> = response.into_iter().enumerate().map(|(k, u)| (k as f64 * step, u)).collect();
            Panel::new(format!("output for a unit step of {name}"), vec![banded("estimate, 95 % band", color, &points)])
        })
        .collect();
    or_reason(plot::signals("Step response from each input", &format!("time / {unit}"), &panels))
}

fn frequencies(trace: &Trace, estimate: &Estimate) -> String {
    const DECADES: f64 = 3.0;
    let per_rad = trace.interval_s.map_or(1.0, |step| 1.0 / (std::f64::consts::TAU * step));
    let unit = if trace.interval_s.is_some() { "frequency / Hz" } else { "frequency / rad a sample" };
    let mut html = String::new();
    for (input, name, color) in inputs(estimate.structure) {
        let found = response::sweep(estimate, input, DECADES, 200);
        let magnitude: Vec<_> = found.iter().map(|f| (f.omega * per_rad, f.magnitude_db)).collect();
        let mut phase: Vec<_> = found.iter().map(|f| (f.omega * per_rad, f.phase_deg)).collect();
        for k in 1..phase.len() {
            // The phase is continuous from low frequency on, without jumps of 360°.
            let turns = ((phase[k].1.value - phase[k - 1].1.value) / 360.0).round();
            phase[k].1.value -= 360.0 * turns;
        }
        let panels = [
            Panel::new("magnitude / dB", vec![banded("estimate, 95 % band", color, &magnitude)]),
            Panel::new("phase / °", vec![banded("estimate, 95 % band", color, &phase)]),
        ];
        html += &or_reason(plot::sweeps(&format!("Frequency response from {name}"), unit, &panels));
    }
    linked(&html)
}

fn parameters(estimate: &Estimate) -> String {
    let names = estimate.structure.names();
    let row = |(k, name): (usize, String)| {
        let (value, sd) = (estimate.theta[k], estimate.covariance[(k, k)].sqrt());
        let text = |x: String| x.replace('-', "−");
        vec![name, text(format!("{value:.6}")), text(format!("{sd:.2e}")), format!("{:.1}", (value / sd).abs())]
    };
    let rows: Vec<Vec<String>> = names.into_iter().enumerate().map(row).collect();
    table(&["parameter", "estimate", "sd", "|estimate| / sd"], &rows)
}
