//! An axis of a figure.

use serde::Serialize;

use super::part;

/// The scale of an axis; linear if it is not set.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisType {
    /// Ranges are logarithms to base 10.
    Log,
}

part! {
    /// A horizontal or vertical axis.
    Axis {
        value type_ "type": AxisType,
        value range "range": [f64; 2],
        value fixed_range "fixedrange": bool,
        value n_ticks "nticks": usize,
        text scale_anchor "scaleanchor": String,
        value dtick "dtick": f64,
        value tick_values "tickvals": Vec<f64>,
        value tick_text "ticktext": Vec<String>,
        value show_tick_labels "showticklabels": bool,
        value tick_angle "tickangle": f64,
        value show_grid "showgrid": bool,
        value zero_line "zeroline": bool,
        text anchor "anchor": String,
        value domain "domain": [f64; 2],
    }
}

impl Axis {
    pub fn new() -> Self {
        Self::default()
    }
}
