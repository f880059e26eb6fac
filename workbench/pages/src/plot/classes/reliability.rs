//! Reliability plot: observed shares of a class over its posteriors, in bins.
//!
//! ```text
//! above   share of the class in a bin with its 95 % interval, over the mean posterior; calibrated posteriors: y = x
//! below   number of rows in the bin, on a logarithmic scale
//! ```
//!
//! The classes are drawn side by side, because they would overlap near 0 and 1.

use serde_json::json;

use crate::ReportError;
use crate::page::palette::Class;
use crate::plot::drawing::figure::{Figure, text};
use crate::plot::drawing::numbers::{Range, usable};
use crate::plot::drawing::plotly::{Axis, AxisType, Bar, ErrorData, HoverInfo, Line, Marker, Mode, Scatter};
use crate::plot::drawing::stack::{Across, Row, stack, vertical};
use crate::plot::drawing::theme::SOFT;
use crate::plot::series::rounded;
use model::evaluate::Rate;

const HEIGHT: f64 = 340.0;
const COUNTS_HEIGHT: f64 = 130.0;
/// Total width of the bars of one bin, and of the points at one position, as posteriors.
const BARS: f64 = 0.07;
const POINTS: f64 = 0.03;

/// Rows whose posterior of a class is in one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliabilityBin {
    /// Centre of the bin.
    pub middle: f64,
    /// Mean posterior.
    pub posterior: f64,
    /// Share of rows that belong to the class.
    pub observed: Rate,
    /// Number of rows.
    pub count: usize,
}

/// The bins of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct ReliabilityClass {
    /// Name, colour and marker.
    pub class: Class,
    /// Bins with rows, in ascending order.
    pub bins: Vec<ReliabilityBin>,
}

/// Observed shares with intervals over the posteriors, and numbers of rows below.
///
/// # Errors
/// [`ReportError::NoClasses`] without classes, [`ReportError::Empty`] without a bin.
pub fn reliability(title: &str, rows: &str, classes: &[ReliabilityClass]) -> Result<String, ReportError> {
    if classes.is_empty() {
        return Err(ReportError::NoClasses { title: title.to_owned() });
    }
    let drawn: Vec<Vec<ReliabilityBin>> =
        classes.iter().map(|class| class.bins.iter().copied().filter(finite).collect()).collect();
    let most = drawn.iter().flatten().map(|bin| bin.count).max();
    let most = most.ok_or_else(|| ReportError::Empty { title: title.to_owned() })?;
    let mut figure = Figure::new(title, 0);
    figure.add(
        Scatter::new(vec![0.0, 1.0], vec![0.0, 1.0])
            .name("calibrated")
            .mode(Mode::Lines)
            .line(Line::new().color(SOFT).width(1.0))
            .hover_info(HoverInfo::Skip),
    );
    for (place, (class, bins)) in classes.iter().zip(&drawn).enumerate() {
        let beside = (place as f64 + 0.5) / classes.len() as f64 - 0.5;
        draw(&mut figure, &class.class, bins, (beside, classes.len()));
    }
    figure.note_gaps(classes.iter().flat_map(|class| &class.bins).filter(|bin| !finite(bin)).count());
    let unit = Range { lo: 0.0, hi: 1.0 };
    // A bar of one row must be visible above the axis; logarithms.
    let up = Range { lo: -0.25, hi: 1.25 * (most.max(2) as f64).log10() + 0.1 };
    let counts = Axis::new().type_(AxisType::Log).range(up.axis()).dtick(1.0);
    let rows = vec![
        Row {
            label: "share of the class, with its 95 % interval".into(),
            height: HEIGHT,
            axis: vertical(unit.padded(0.03)),
        },
        Row { label: format!("{rows} in the bin"), height: COUNTS_HEIGHT, axis: counts },
    ];
    let axis = Axis::new().range(unit.padded(0.05).axis());
    stack(&mut figure, Across { label: "posterior of the class, mean of the bin", axis }, rows, true);
    figure.set("barmode", json!("overlay"));
    figure.set("hovermode", json!("closest"));
    Ok(figure.html())
}

fn finite(bin: &ReliabilityBin) -> bool {
    let Rate { value, low, high } = bin.observed;
    [bin.posterior, value, low, high].into_iter().all(usable)
}

/// The shares and the counts of one class, `beside` those of the others.
fn draw(figure: &mut Figure, class: &Class, bins: &[ReliabilityBin], (beside, classes): (f64, usize)) {
    let (name, color) = (text(&class.name), class.color.to_string());
    let unit = Range { lo: 0.0, hi: 1.0 };
    let each = |pick: fn(&ReliabilityBin) -> f64| rounded(unit, bins.iter().map(pick));
    let above = each(|bin| bin.observed.high - bin.observed.value);
    let below = each(|bin| bin.observed.value - bin.observed.low);
    let bars = ErrorData::new(above, below).thickness(1.4).width(4);
    figure.add(
        Scatter::new(rounded(unit, bins.iter().map(|bin| bin.posterior + POINTS * beside)), each(|b| b.observed.value))
            .name(&name)
            .legend_group(&name)
            .mode(Mode::Markers)
            .marker(class.marker.filled(&color, 8))
            .error_y(bars.color(color.clone())),
    );
    let at = bins.iter().map(|bin| bin.middle + BARS * beside);
    figure.add(
        Bar::new(rounded(unit, at), bins.iter().map(|bin| bin.count as f64).collect())
            .name(&name)
            .legend_group(&name)
            .show_legend(false)
            .width(0.8 * BARS / classes as f64)
            .marker(Marker::new().color(color))
            .y_axis("y2"),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::named;

    fn class(bins: &[(f64, usize, usize)]) -> ReliabilityClass {
        let bin = |&(posterior, hits, count): &(f64, usize, usize)| ReliabilityBin {
            middle: posterior,
            posterior,
            observed: Rate::wilson(hits, count),
            count,
        };
        ReliabilityClass { class: Class::new(0, "<a>"), bins: bins.iter().map(bin).collect() }
    }

    #[test]
    fn every_bin_has_its_interval_and_its_count() {
        let html = reliability("t", "segments", &[class(&[(0.25, 25, 100), (0.97, 31, 32)])]).expect("bins");
        assert_eq!(check(&html), Ok(()));
        let [shares, counts] = &named(&html, "&lt;a&gt;")[..] else { panic!("{html}") };
        assert_eq!((&shares["x"][0], &shares["y"][0]), (&json!(0.25), &json!(0.25)));
        let wilson = Rate::wilson(25, 100);
        let high = shares["error_y"]["array"][0].as_f64().expect("a number");
        assert!((high - (wilson.high - 0.25)).abs() < 1e-5, "{high}");
        assert_eq!(counts["y"], json!([100.0, 32.0]));
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        assert!(matches!(reliability("t", "rows", &[]), Err(ReportError::NoClasses { .. })));
        assert!(matches!(reliability("t", "rows", &[class(&[])]), Err(ReportError::Empty { .. })));
        assert!(reliability("t", "rows", &[class(&[(f64::NAN, 1, 2)])]).is_err());
    }
}
