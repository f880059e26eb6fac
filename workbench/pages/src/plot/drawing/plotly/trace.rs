//! Traces: points, bars and maps, each with its data and its look.

use serde::Serialize;

use super::mark::{Line, Marker};
use super::part;

/// A trace of any type, which the script reads from `type`.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Trace {
    Scatter(Box<Scatter>),
    Bar(Box<Bar>),
    HeatMap(Box<HeatMap>),
}

impl From<Scatter> for Trace {
    fn from(trace: Scatter) -> Self {
        Self::Scatter(Box::new(trace))
    }
}

impl From<Bar> for Trace {
    fn from(trace: Bar) -> Self {
        Self::Bar(Box::new(trace))
    }
}

impl From<HeatMap> for Trace {
    fn from(trace: HeatMap) -> Self {
        Self::HeatMap(Box::new(trace))
    }
}

/// What is drawn at the points of a trace.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    Lines,
    Markers,
    #[serde(rename = "lines+markers")]
    LinesMarkers,
    /// Nothing; its area can be filled.
    None,
}

/// The area of a trace that is filled.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Fill {
    /// Between the points and y = 0.
    ToZeroY,
    /// The shape whose outline the points are.
    ToSelf,
}

/// What the cursor shows; all that the trace has if it is not set.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HoverInfo {
    /// Nothing, and the cursor does not find the trace.
    Skip,
}

part! {
    /// Points, and lines between them.
    Scatter {
        text name "name": String,
        value show_legend "showlegend": bool,
        text legend_group "legendgroup": String,
        value mode "mode": Mode,
        value x "x": Vec<f64>,
        value y "y": Vec<f64>,
        value text "text": Vec<String>,
        value hover_text "hovertext": Vec<String>,
        value hover_info "hoverinfo": HoverInfo,
        text hover_template "hovertemplate": String,
        text x_axis "xaxis": String,
        text y_axis "yaxis": String,
        text stack_group "stackgroup": String,
        value marker "marker": Marker,
        value line "line": Line,
        value error_y "error_y": ErrorData,
        value fill "fill": Fill,
        text fill_color "fillcolor": String,
    }
}

impl Scatter {
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Self {
        Self::default().x(x).y(y)
    }
}

part! {
    /// Bars; their width is in units of the horizontal axis.
    Bar {
        value x "x": Vec<f64>,
        value y "y": Vec<f64>,
        text name "name": String,
        value show_legend "showlegend": bool,
        text legend_group "legendgroup": String,
        value width "width": f64,
        text y_axis "yaxis": String,
        value marker "marker": Marker,
    }
}

impl Bar {
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Self {
        Self::default().x(x).y(y)
    }
}

part! {
    /// Cells, each coloured by its number in `z`, row by row; a cell without a number stays blank. `x` and `y` are the
    /// centres of the cells, or their edges if there is one more.
    HeatMap {
        value color_scale "colorscale": Vec<(f64, String)>,
        value hover_info "hoverinfo": HoverInfo,
        text hover_template "hovertemplate": String,
        text name "name": String,
        value opacity "opacity": f64,
        value show_scale "showscale": bool,
        value text "text": Vec<Vec<String>>,
        value x "x": Vec<f64>,
        value y "y": Vec<f64>,
        text y_axis "yaxis": String,
        value z "z": Vec<Vec<Option<usize>>>,
        value zmax "zmax": f64,
        value zmin "zmin": f64,
    }
}

impl HeatMap {
    pub fn new(x: Vec<f64>, y: Vec<f64>, z: Vec<Vec<Option<usize>>>) -> Self {
        Self::default().x(x).y(y).z(z)
    }
}

part! {
    /// Error bars of the points, so far above and below each of them; widths are in pixels.
    ErrorData {
        value kind "type": ErrorType,
        value array "array": Vec<f64>,
        value symmetric "symmetric": bool,
        value array_minus "arrayminus": Vec<f64>,
        text color "color": String,
        value thickness "thickness": f64,
        value width "width": usize,
    }
}

/// How the lengths of error bars are given.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ErrorType {
    /// One by one.
    Data,
}

impl ErrorData {
    pub fn new(above: Vec<f64>, below: Vec<f64>) -> Self {
        Self::default().kind(ErrorType::Data).symmetric(false).array(above).array_minus(below)
    }
}
