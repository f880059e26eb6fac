//! Features of segments in the order of their runs, one panel a feature.

use serde_json::json;

use super::drawing::figure::{Figure, text};
use super::drawing::numbers::{Range, usable};
use super::drawing::plotly::{Axis, Line, Marker, Mode, Scatter, Symbol};
use super::drawing::stack::{Across, Row, axis_name, stack, vertical};
use super::drawing::theme::{INK, RULE};
use super::series::rounded;
use crate::ReportError;
use crate::page::palette::Class;

const HEIGHT: f64 = 110.0;
/// Values of one figure, so that a page stays small; runs whose names fit under the axis.
const VALUES: usize = 15_000;
const NAMED_RUNS: usize = 24;

/// One segment or trace.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPoint {
    /// Name of its trace, shown under the cursor.
    pub trace: String,
    /// Its run, if runs are known. Neighbours of one run stand together.
    pub run: Option<String>,
    /// Index of its class.
    pub class: usize,
    /// Whether the detector calls it novel.
    pub novel: bool,
    /// Its features; NaN where one is missing.
    pub values: Vec<f64>,
}

/// The features of all points, in their order, coloured by class, with novel points marked and lines between runs.
///
/// # Errors
/// [`ReportError::Empty`] without a finite value, [`ReportError::Length`] for a point without one value per feature.
pub fn features_over_runs(
    title: &str,
    features: &[String],
    classes: &[Class],
    points: &[RunPoint],
) -> Result<String, ReportError> {
    let expected = features.len();
    if let Some((row, bad)) = points.iter().enumerate().find(|(_, point)| point.values.len() != expected) {
        return Err(ReportError::Length { title: title.to_owned(), row, found: bad.values.len(), expected });
    }
    if points.iter().flat_map(|point| &point.values).all(|value| !usable(*value)) {
        return Err(ReportError::Empty { title: title.to_owned() });
    }
    let mut figure = Figure::new(title, 0);
    let every = (points.len() * expected).div_ceil(VALUES).max(1);
    let x = Range { lo: 0.4, hi: points.len() as f64 + 0.6 };
    let mut rows = Vec::new();
    for (feature, name) in features.iter().enumerate() {
        let y = Range::of(points.iter().map(|point| point.values[feature])).unwrap_or(Range { lo: 0.0, hi: 1.0 });
        draw(&mut figure, (feature, y.padded(0.08)), classes, points, every);
        rows.push(Row { label: name.clone(), height: HEIGHT, axis: vertical(y.padded(0.08)) });
    }
    if every > 1 {
        figure.notes.push(format!("Of the points that are not novel, every {every}th is drawn."));
    }
    let runs = runs(points);
    let mut axis = Axis::new().range(x.axis()).show_grid(false);
    for (start, _, _) in runs.iter().skip(1) {
        figure.push(
            "shapes",
            json!({ "type": "line", "x0": start - 0.5, "x1": start - 0.5, "xref": "x", "y0": 0, "y1": 1, "yref": "paper",
                    "layer": "below", "line": { "color": RULE, "width": 1 } }),
        );
    }
    let mut label = "segment";
    if (2..=NAMED_RUNS).contains(&runs.len()) {
        label = "run";
        let middles = runs.iter().map(|(start, end, _)| 0.5 * (start + end)).collect();
        axis = axis.tick_values(middles).tick_text(runs.iter().map(|(_, _, name)| text(name)).collect());
    }
    stack(&mut figure, Across { label, axis }, rows, true);
    Ok(figure.html())
}

/// First and last place of each run, and its name.
fn runs(points: &[RunPoint]) -> Vec<(f64, f64, String)> {
    let mut runs: Vec<(f64, f64, String)> = Vec::new();
    for (k, point) in points.iter().enumerate() {
        let (at, Some(name)) = (k as f64 + 1.0, &point.run) else { continue };
        match runs.last_mut() {
            Some((_, end, last)) if last == name => *end = at,
            _ => runs.push((at, at, name.clone())),
        }
    }
    runs
}

fn draw(figure: &mut Figure, (feature, y): (usize, Range), classes: &[Class], points: &[RunPoint], every: usize) {
    let axis = axis_name(feature);
    let numbered = || points.iter().enumerate().filter(|(_, point)| usable(point.values[feature]));
    let mut add = |name: &str, marker: Marker, own: Vec<(usize, &RunPoint)>| {
        if own.is_empty() {
            return;
        }
        let at = own.iter().map(|(k, _)| *k as f64 + 1.0).collect();
        let trace = Scatter::new(at, rounded(y, own.iter().map(|(_, point)| point.values[feature])))
            .name(text(name))
            .legend_group(text(name))
            .show_legend(feature == 0)
            .mode(Mode::Markers)
            .marker(marker)
            .y_axis(&axis);
        // The names stand once, in the first panel; its cursor crosses all.
        figure.add(if feature == 0 {
            let names = own.iter().map(|(_, point)| match &point.run {
                Some(run) => text(&format!("{}, run {run}", point.trace)),
                None => text(&point.trace),
            });
            trace.hover_text(names.collect()).hover_template("%{y} (%{hovertext})")
        } else {
            trace
        });
    };
    for (k, class) in classes.iter().enumerate() {
        let own = numbered().filter(|(_, point)| point.class == k).step_by(every).collect();
        add(&class.name, class.marker.filled(&class.color.to_string(), 7), own);
    }
    let novel = Marker::new().symbol(Symbol::XThinOpen).size(8).color(INK).line(Line::new().width(1.4).color(INK));
    add("novel", novel, numbered().filter(|(_, point)| point.novel).collect());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::{drawn, named};

    #[test]
    fn points_stand_in_the_order_of_their_runs() {
        let point = |trace: &str, run: &str, class, novel, values: [f64; 2]| RunPoint {
            trace: trace.into(),
            run: Some(run.into()),
            class,
            novel,
            values: values.into(),
        };
        let points = [
            point("a", "1", 0, false, [1.0, 5.0]),
            point("b", "1", 0, true, [2.0, f64::NAN]),
            point("<c>", "2", 1, false, [3.0, 7.0]),
        ];
        let features = ["a1".to_string(), "b1".to_string()];
        let html = features_over_runs("t", &features, &Class::all(&["good", "bad"]), &points).expect("finite");
        assert_eq!(check(&html), Ok(()));
        let good = named(&html, "good");
        assert_eq!((&good[0]["x"], &good[1]["x"]), (&json!([1.0, 2.0]), &json!([1.0])));
        assert_eq!(named(&html, "novel")[0]["y"], json!([2.0]));
        let layout = &drawn(&html)["layout"];
        assert_eq!(layout["xaxis"]["tickvals"], json!([1.5, 3.0]));
        assert_eq!(layout["shapes"].as_array().map(Vec::len), Some(1));
        assert!(features_over_runs("t", &features, &[], &[]).is_err());
    }
}
