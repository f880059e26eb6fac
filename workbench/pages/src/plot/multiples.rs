//! Small multiples: rates with intervals over the size of a defect, one panel for each condition.

use serde_json::json;

use super::drawing::figure::{Figure, text};
use super::drawing::numbers::Range;
use super::drawing::plotly::{Axis, HoverInfo, Line, Mode, Scatter};
use super::drawing::theme::{BOTTOM, SOFT, TOP};
use super::series::rounded;
use crate::ReportError;
use crate::page::palette::{Color, Marker};
use model::evaluate::Rate;

const COLUMNS: usize = 4;
const PANEL_HEIGHT: f64 = 84.0;
/// Between two rows: tick labels and the name of the lower panel; between two columns, as a share of the width.
const GAP: f64 = 44.0;
const ASIDE: f64 = 0.035;
const LEGEND: u32 = 34;
/// Left of the panels, for tick labels and the title of the vertical axes.
const LEFT: u32 = 58;

/// One kind of defect: its name, and its rates over the size (1 is full size).
#[derive(Debug, Clone, PartialEq)]
pub struct SizeSeries {
    /// Name in the legend.
    pub name: String,
    /// Size and rate.
    pub rates: Vec<(f64, Rate)>,
}

/// Panels with their titles and series, which all have the same names; `y_label` is the title of all vertical axes.
///
/// # Errors
/// [`ReportError::Empty`] without a rate.
pub fn multiples(title: &str, y_label: &str, panels: &[(String, Vec<SizeSeries>)]) -> Result<String, ReportError> {
    let sizes = panels.iter().flat_map(|(_, all)| all).flat_map(|own| &own.rates).map(|(size, _)| size.log2());
    let sizes = Range::of(sizes).ok_or_else(|| ReportError::Empty { title: title.to_owned() })?;
    let x = Range { lo: sizes.lo - 0.5, hi: sizes.hi.max(0.0) + 0.5 };
    let rows = panels.len().div_ceil(COLUMNS);
    let inner = PANEL_HEIGHT * rows as f64 + GAP * (rows - 1) as f64;
    let width = (1.0 - ASIDE * (COLUMNS - 1) as f64) / COLUMNS as f64;
    let mut figure = Figure::new(title, 0);
    for (place, (name, all)) in panels.iter().enumerate() {
        let number = if place == 0 { String::new() } else { (place + 1).to_string() };
        let left = (width + ASIDE) * (place % COLUMNS) as f64;
        let top = 1.0 - (PANEL_HEIGHT + GAP) * (place / COLUMNS) as f64 / inner;
        for (k, series) in all.iter().enumerate() {
            draw(&mut figure, series, k, (&number, x));
        }
        let (values, names) = ticks(sizes);
        let across = Axis::new().range(x.axis()).domain([left, left + width]).anchor(format!("y{number}"));
        let across = across.tick_values(values).tick_text(names).tick_angle(0.0);
        // A title below the last panel of each column.
        let title = if place + COLUMNS < panels.len() { "" } else { "size of the defect" };
        let further = json!({ "matches": if place == 0 { None } else { Some("x") }, "title": { "text": title } });
        figure.axis(format!("xaxis{number}"), across, &further);
        let up = Axis::new().range(Range { lo: -4.0, hi: 104.0 }.axis()).tick_values(vec![0.0, 50.0, 100.0]);
        let bottom = (top - PANEL_HEIGHT / inner).max(0.0);
        let up = up.domain([bottom, top]).anchor(format!("x{number}")).show_tick_labels(place % COLUMNS == 0);
        figure.axis(format!("yaxis{number}"), up, &json!({}));
        figure.push(
            "annotations",
            json!({ "text": text(name), "x": left, "xref": "paper", "xanchor": "left", "y": top, "yref": "paper",
                    "yanchor": "bottom", "showarrow": false, "font": { "size": 11, "color": SOFT } }),
        );
    }
    figure.push(
        "annotations",
        json!({ "text": text(y_label), "x": 0, "xref": "paper", "xanchor": "right", "xshift": -34, "y": 0.5,
                "yref": "paper", "textangle": -90, "showarrow": false, "font": { "size": 13, "color": SOFT } }),
    );
    figure.legend(inner, 22.0);
    figure.set("margin", json!({ "l": LEFT, "r": 38, "t": TOP + LEGEND, "b": BOTTOM }));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand pixels")]
    figure.height(inner as u32 + TOP + LEGEND + BOTTOM);
    Ok(figure.html())
}

/// Places and names of the sizes 1, 1/2, 1/8, 1/32 …
fn ticks(sizes: Range) -> (Vec<f64>, Vec<String>) {
    let places = std::iter::successors(Some(0.0), |at: &f64| Some(if *at > -0.5 { -1.0 } else { at - 2.0 }));
    let places: Vec<f64> = places.take_while(|at| *at >= sizes.lo - 1e-9).collect();
    let name = |at: &f64| if *at < 0.0 { format!("1/{:.0}", (-at).exp2()) } else { "1".into() };
    let names = places.iter().map(name).collect();
    (places, names)
}

fn draw(figure: &mut Figure, series: &SizeSeries, k: usize, (number, x): (&str, Range)) {
    let percent = Range { lo: 0.0, hi: 100.0 };
    let color = Color::of(k).to_string();
    // Beside each other, so that intervals do not overlap.
    let at = |size: f64| size.log2() + 0.12 * k as f64;
    // All intervals are one line with gaps: a picture with a path for each of them is several times as large.
    let gap = f64::NAN;
    let ends = series.rates.iter().flat_map(|(size, rate)| [(at(*size), rate.low), (at(*size), rate.high), (gap, gap)]);
    let (places, ends): (Vec<f64>, Vec<f64>) = ends.unzip();
    figure.add(
        Scatter::new(rounded(x, places.into_iter()), rounded(percent, ends.into_iter().map(|end| 100.0 * end)))
            .legend_group(text(&series.name))
            .show_legend(false)
            .hover_info(HoverInfo::Skip)
            .mode(Mode::Lines)
            .line(Line::new().color(color.clone()).width(1.2))
            .x_axis(format!("x{number}"))
            .y_axis(format!("y{number}")),
    );
    let interval = |(_, rate): &(f64, Rate)| format!("{:.1} to {:.1}", 100.0 * rate.low, 100.0 * rate.high);
    figure.add(
        Scatter::new(
            rounded(x, series.rates.iter().map(|(size, _)| at(*size))),
            rounded(percent, series.rates.iter().map(|(_, rate)| 100.0 * rate.value)),
        )
        .name(text(&series.name))
        .text(series.rates.iter().map(interval).collect())
        .legend_group(text(&series.name))
        .show_legend(number.is_empty())
        .mode(Mode::LinesMarkers)
        .line(Line::new().color(color.clone()).width(1.5))
        .marker(Marker::of(k).filled(&color, 6))
        .x_axis(format!("x{number}"))
        .y_axis(format!("y{number}")),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::{drawn, named};

    #[test]
    fn every_panel_has_its_axes_and_its_series() {
        let series = |name: &str| SizeSeries {
            name: name.into(),
            rates: [1.0, 0.25].map(|size| (size, Rate::wilson((20.0 * size) as usize, 60))).to_vec(),
        };
        let panels: Vec<_> =
            ["a<b", "c", "d", "e", "f", "g"].map(|n| (n.into(), vec![series("x"), series("y")])).into();
        let html = multiples("t", "found / %", &panels).expect("rates");
        assert_eq!(check(&html), Ok(()));
        let (own, layout) = (named(&html, "y"), &drawn(&html)["layout"]);
        assert_eq!((own.len(), &own[5]["xaxis"]), (6, &json!("x6")));
        assert_eq!(layout["xaxis6"]["ticktext"], json!(["1", "1/2"]));
        assert_eq!(layout["annotations"][0]["text"], "a&lt;b");
        assert!(multiples("none", "found / %", &[]).is_err());
    }
}
