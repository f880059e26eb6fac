//! Colours by the names of the style sheet, and the layout that all figures share.

use serde_json::{Value, json};

pub(in crate::plot) const INK: &str = "var(--ink)";
pub(in crate::plot) const SOFT: &str = "var(--soft)";
pub(in crate::plot) const RULE: &str = "var(--rule)";
const GRID: &str = "var(--grid)";
pub(in crate::plot) const PAPER: &str = "var(--paper)";
pub(in crate::plot) const CLEAR: &str = "rgba(0,0,0,0)";

/// Space above the first panel, for its label; around the figure.
pub(in crate::plot) const TOP: u32 = 30;
pub(in crate::plot) const BOTTOM: u32 = 46;
/// Height of the label of a panel, and of a lane of names of events above it.
pub(in crate::plot) const LABEL: u32 = 18;
pub(in crate::plot) const LANE: u32 = 15;

/// The layout before the axes of a figure are added.
pub(in crate::plot) fn layout() -> Value {
    json!({
        "template": { "layout": { "xaxis": axis(), "yaxis": axis() } },
        "font": {
            "family": "system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif", "size": 13, "color": INK
        },
        "paper_bgcolor": CLEAR,
        "plot_bgcolor": CLEAR,
        "margin": { "l": 56, "r": 38, "t": TOP, "b": BOTTOM },
        "hoverlabel": { "bgcolor": PAPER, "bordercolor": RULE, "font": { "color": INK, "size": 12 }, "namelength": -1 },
        "modebar": { "bgcolor": CLEAR, "color": SOFT, "activecolor": INK, "orientation": "v" },
        "hovermode": "closest",
    })
}

fn axis() -> Value {
    json!({
        "gridcolor": GRID,
        "linecolor": RULE,
        "zerolinecolor": RULE,
        "zeroline": false,
        "showline": true,
        "mirror": "all",
        "ticks": "",
        "automargin": true,
        "tickfont": { "color": SOFT },
        "title": { "font": { "color": SOFT, "size": 13 }, "standoff": 8 },
        "exponentformat": "power",
        "spikecolor": SOFT,
        "spikethickness": 1,
        "spikedash": "solid",
    })
}

/// The legend, this far above the plots as a share of their height.
pub(in crate::plot) fn legend(above: f64) -> Value {
    json!({
        "orientation": "h", "x": 0, "xanchor": "left", "y": 1.0 + above, "yanchor": "bottom", "bgcolor": CLEAR,
        "itemsizing": "constant", "groupclick": "togglegroup",
    })
}

/// Buttons and behaviour; the file of the download button has the name of the figure.
pub(in crate::plot) fn config(title: &str) -> Value {
    let plain = |c: char| if c.is_alphanumeric() { c } else { '-' };
    json!({
        "responsive": true,
        "displaylogo": false,
        "modeBarButtonsToRemove": ["select2d", "lasso2d"],
        "toImageButtonOptions": { "format": "svg", "filename": title.chars().map(plain).collect::<String>() },
    })
}
