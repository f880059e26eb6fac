//! Panels above each other over one horizontal axis.

use serde_json::json;

use super::figure::{Figure, text};
use super::numbers::Range;
use super::plotly::Axis;
use super::theme::{BOTTOM, LANE, SOFT, TOP};

/// Between two panels, for the label of the lower one; height of the legend.
const GAP: f64 = 30.0;
const LEGEND: u32 = 34;

/// One panel: label above it, height in pixels, vertical axis.
pub(in crate::plot) struct Row {
    pub(in crate::plot) label: String,
    pub(in crate::plot) height: f64,
    pub(in crate::plot) axis: Axis,
}

/// The horizontal axis that all panels share.
pub(in crate::plot) struct Across<'a> {
    pub(in crate::plot) label: &'a str,
    pub(in crate::plot) axis: Axis,
}

/// Name of the vertical axis of panel `row`, as traces name it: `y`, `y2`.
pub(in crate::plot) fn axis_name(row: usize) -> String {
    if row == 0 { "y".into() } else { format!("y{}", row + 1) }
}

/// Adds the axes of the panels to a figure, with their labels, and sets its height.
pub(in crate::plot) fn stack(figure: &mut Figure, across: Across, rows: Vec<Row>, legend: bool) {
    stack_below(figure, across, rows, (legend, 0));
}

/// The same below so many lanes of names of events.
pub(in crate::plot) fn stack_below(figure: &mut Figure, across: Across, rows: Vec<Row>, (legend, lanes): (bool, u32)) {
    let count = rows.len();
    let inner = rows.iter().map(|row| row.height).sum::<f64>() + GAP * count.saturating_sub(1) as f64;
    let bottom_axis = axis_name(count.saturating_sub(1));
    figure.axis(
        "xaxis",
        across.axis.anchor(&bottom_axis),
        &json!({
            "title": { "text": text(across.label) }, "showspikes": true, "spikemode": "across", "spikesnap": "cursor"
        }),
    );
    let mut top = 1.0;
    for (k, row) in rows.into_iter().enumerate() {
        let end = (top - row.height / inner).max(0.0);
        figure.axis(format!("yaxis{}", &axis_name(k)[1..]), row.axis.domain([end, top]).anchor("x"), &json!({}));
        figure.push("annotations", label(&row.label, top));
        top = end - GAP / inner;
    }
    let names = LANE * lanes;
    let above = names + if legend { LEGEND } else { 0 };
    if legend {
        figure.legend(inner, 22.0 + f64::from(names));
    }
    figure.set("margin", json!({ "l": 56, "r": 38, "t": TOP + above, "b": BOTTOM }));
    // One cursor through all panels, with the values of all of them.
    figure.set("hovermode", json!("x unified"));
    figure.set("hoversubplots", json!("axis"));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand pixels")]
    figure.height(inner as u32 + TOP + BOTTOM + above);
}

/// The label of a panel, above its left end.
fn label(own: &str, top: f64) -> serde_json::Value {
    json!({
        "text": text(own), "x": 0, "xref": "paper", "xanchor": "left", "y": top, "yref": "paper", "yanchor": "bottom",
        "showarrow": false, "font": { "color": SOFT, "size": 12.5 }
    })
}

/// A vertical axis with this range; values increase upwards.
pub(in crate::plot) fn vertical(range: Range) -> Axis {
    Axis::new().range(range.axis()).n_ticks(6)
}
