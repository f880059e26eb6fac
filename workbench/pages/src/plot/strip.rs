//! A strip of named intervals over time, such as true classes and decisions.

use super::drawing::figure::{Figure, text};
use super::drawing::numbers::Range;
use super::drawing::plotly::{Axis, HeatMap, Marker, Mode, Scatter, Symbol};
use super::drawing::stack::{Row, axis_name};
use super::drawing::theme::CLEAR;
use crate::page::palette::Class;

/// Height of one strip in pixels.
const HEIGHT: f64 = 26.0;

/// An interval with the index of its name, if it has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Start.
    pub start: f64,
    /// End.
    pub end: f64,
    /// Index into the names of the strip; `None` leaves it blank.
    pub name: Option<usize>,
}

/// Intervals in one row; later ones cover earlier ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Label above the strip.
    pub label: String,
    /// Names and colours.
    pub names: Vec<Class>,
    /// The intervals, in order.
    pub spans: Vec<Span>,
    /// Whether the legend shows the names.
    pub in_legend: bool,
}

impl Strip {
    /// Adds the strip as panel `row`.
    pub(super) fn draw(&self, figure: &mut Figure, row: usize, x: Range) -> Row {
        let axis = axis_name(row);
        let (edges, cells) = self.cells();
        if !cells.is_empty() {
            let name =
                |cell: &Option<usize>| cell.and_then(|k| self.names.get(k)).map_or("–".into(), |own| text(&own.name));
            let names: Vec<String> = cells.iter().map(name).collect();
            figure.add(
                HeatMap::new(edges.iter().map(|&edge| x.rounded(edge)).collect(), vec![0.0, 1.0], vec![cells])
                    .name(text(&self.label))
                    .text(vec![names])
                    .hover_template("%{text}")
                    .color_scale(scale(&self.names))
                    .zmin(-0.5)
                    .zmax(self.names.len().max(1) as f64 - 0.5)
                    .show_scale(false)
                    .y_axis(&axis),
            );
        }
        if self.in_legend {
            let used = |k: &usize| self.spans.iter().any(|span| span.name == Some(*k));
            for class in (0..self.names.len()).filter(used).map(|k| &self.names[k]) {
                figure.add(key(class, &axis));
            }
        }
        let axis = Axis::new().range(Range { lo: 0.0, hi: 1.0 }.axis()).show_tick_labels(false).show_grid(false);
        Row { label: self.label.clone(), height: HEIGHT, axis: axis.fixed_range(true) }
    }

    /// Edges of cells, and the name in each; neighbours of one name are one cell.
    fn cells(&self) -> (Vec<f64>, Vec<Option<usize>>) {
        let (mut edges, mut cells): (Vec<f64>, Vec<Option<usize>>) = (Vec::new(), Vec::new());
        let mut put = |start: f64, end: f64, name: Option<usize>| match (cells.last(), edges.last_mut()) {
            (Some(last), Some(edge)) if *last == name => *edge = end,
            (_, None) => {
                edges.extend([start, end]);
                cells.push(name);
            }
            _ => {
                edges.push(end);
                cells.push(name);
            }
        };
        let mut at: Option<f64> = None;
        for (span, next) in self.spans.iter().zip(self.spans.iter().skip(1).map(|s| s.start).chain([f64::INFINITY])) {
            if let Some(at) = at.filter(|&at| at < span.start) {
                put(at, span.start, None);
            }
            let end = if next > span.start { span.end.min(next) } else { span.end };
            put(at.map_or(span.start, |at| at.max(span.start)), end, span.name);
            at = Some(end);
        }
        (edges, cells)
    }
}

/// An entry of the legend without points.
pub(super) fn key(class: &Class, axis: &str) -> Scatter {
    Scatter::new(vec![f64::NAN], vec![f64::NAN])
        .name(text(&class.name))
        .mode(Mode::Markers)
        .marker(Marker::new().symbol(Symbol::Square).color(class.color.to_string()).size(11))
        .y_axis(axis)
}

/// One colour for each index, from edge to edge.
pub(super) fn scale(names: &[Class]) -> Vec<(f64, String)> {
    if names.is_empty() {
        return [0.0, 1.0].map(|at| (at, CLEAR.to_owned())).into();
    }
    let count = names.len() as f64;
    let color = |class: &Class| class.color.to_string();
    let both = |(k, class): (usize, &Class)| [k, k + 1].map(|edge| (edge as f64 / count, color(class)));
    names.iter().enumerate().flat_map(both).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_blank_and_overlaps_are_cut() {
        let span = |start, end, name| Span { start, end, name: Some(name) };
        let spans = vec![span(0.0, 2.0, 0), span(1.0, 3.0, 0), span(5.0, 6.0, 1)];
        let strip = Strip { label: "s".into(), names: Class::all(&["a", "b"]), spans, in_legend: true };
        assert_eq!(strip.cells(), (vec![0.0, 3.0, 5.0, 6.0], vec![Some(0), None, Some(1)]));
    }
}
