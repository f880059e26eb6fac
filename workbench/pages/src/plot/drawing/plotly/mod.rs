//! The parts of plotly's figures that the plots use, as its script reads them.
//!
//! ```text
//! Scatter, Bar, HeatMap ──► Trace ──► "data"        Marker, Line: how a trace looks
//! Axis                            ──► "layout"
//! ```
//!
//! Attributes have the names and meanings of plotly's reference. An attribute that is not set is absent; the script
//! then takes its default or that of the template. Numbers that are not finite become `null`, which the script draws as
//! a gap.

mod axis;
mod mark;
mod trace;

pub use axis::{Axis, AxisType};
pub use mark::{DashType, Line, LineShape, Marker, Symbol};
pub use trace::{Bar, ErrorData, Fill, HeatMap, HoverInfo, Mode, Scatter, Trace};

/// Defines a part of a figure and the setter of each of its attributes: the name in plotly's reference, and either
/// `text`, which the setter takes from any string, or `value`, which it takes as it is.
macro_rules! part {
    ($(#[$of_part:meta])* $part:ident { $($kind:ident $field:ident $name:literal: $type:ty,)* }) => {
        $(#[$of_part])*
        #[derive(Debug, Clone, Default, serde::Serialize)]
        pub struct $part {
            $(#[serde(rename = $name, skip_serializing_if = "Option::is_none")] $field: Option<$type>,)*
        }

        impl $part {
            $(part!(@setter $kind $field: $type);)*
        }
    };
    (@setter text $field:ident: $type:ty) => {
        pub fn $field(self, text: impl Into<$type>) -> Self {
            Self { $field: Some(text.into()), ..self }
        }
    };
    (@setter value $field:ident: $type:ty) => {
        pub fn $field(self, value: $type) -> Self {
            Self { $field: Some(value), ..self }
        }
    };
}
use part;

#[cfg(test)]
mod tests {
    use serde_json::{json, to_value};

    use super::*;
    use crate::page::palette;

    #[test]
    fn a_trace_has_its_type_and_what_was_set() {
        let trace = Trace::from(Scatter::new(vec![1.0, f64::NAN], vec![2.0, f64::INFINITY]).name("a").y_axis("y2"));
        let expected = json!({ "type": "scatter", "x": [1.0, null], "y": [2.0, null], "name": "a", "yaxis": "y2" });
        assert_eq!(to_value(trace).expect("JSON"), expected);
        let map = Trace::from(HeatMap::new(vec![0.0, 1.0], vec![0.0], vec![vec![Some(3), None]]));
        let expected = json!({ "type": "heatmap", "x": [0.0, 1.0], "y": [0.0], "z": [[3, null]] });
        assert_eq!(to_value(map).expect("JSON"), expected);
    }

    #[test]
    fn names_of_values_are_those_of_the_reference() {
        let symbols = [Symbol::TriangleUpOpen, Symbol::StarDiamond, Symbol::XThinOpen, Symbol::LineNsOpen];
        let expected = json!(["triangle-up-open", "star-diamond", "x-thin-open", "line-ns-open"]);
        assert_eq!(to_value(symbols).expect("JSON"), expected);
        let modes = json!(["lines", "markers", "lines+markers", "none"]);
        assert_eq!(to_value([Mode::Lines, Mode::Markers, Mode::LinesMarkers, Mode::None]).expect("JSON"), modes);
        assert_eq!(to_value([Fill::ToZeroY, Fill::ToSelf]).expect("JSON"), json!(["tozeroy", "toself"]));
        let errors = json!({ "type": "data", "array": [0.5], "arrayminus": [0.25], "symmetric": false });
        assert_eq!(to_value(ErrorData::new(vec![0.5], vec![0.25])).expect("JSON"), errors);
    }

    #[test]
    fn every_shape_has_an_outline() {
        for index in 0..7 {
            let name = |marker: Marker| to_value(marker).expect("JSON")["symbol"].as_str().map(str::to_owned);
            let shape = palette::Marker::of(index);
            let (filled, open) = (name(shape.filled("#000", 8)), name(shape.open("#000", 8)));
            assert_eq!(open, filled.map(|own| own + "-open"));
        }
    }
}
