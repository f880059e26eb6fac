//! Stacked posteriors of the classified segments of a recording over time.
//!
//! ```text
//! 1 ┬
//!   │      ▒▒▒▒▒▒▓▓▓▓▓▓▓▓▓▓   P(class | segment), stacked in the order of the classes
//! 0 ┴
//! true     ▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓   true class, if known
//! decided  ▓▓▓▓▓▓╱╱╱╱▓▓▓▓▓▓   decision of the detector
//! ```

use crate::ReportError;
use crate::page::palette::{Class, Color, Marker};
use crate::plot::drawing::figure::{Figure, text};
use crate::plot::drawing::numbers::{Range, usable};
use crate::plot::drawing::plotly::{Axis, Line, LineShape, Mode, Scatter};
use crate::plot::drawing::stack::{Across, Row, axis_name, stack, vertical};
use crate::plot::series::rounded;
use crate::plot::strip::{Span, Strip};

const HEIGHT: f64 = 170.0;
/// Posteriors of one figure; of more segments the mean of neighbours is drawn.
const POSTERIORS: usize = 9000;

/// One classified time interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Start in seconds, or in the unit of the axis title.
    pub start: f64,
    /// End, after `start`.
    pub end: f64,
    /// Index of the true class, if known.
    pub truth: Option<usize>,
    /// Index of the decided class; `None` if undetermined, novel or ambiguous.
    pub decided: Option<usize>,
    /// One probability per class. If one is negative or not finite, the bar stays empty.
    pub posteriors: Vec<f64>,
}

/// Stacked posteriors over time above a strip of the true classes, if one is known, and a strip of the decisions.
///
/// Segments are drawn in the order given; if one overlaps the next, it is cut at the start of the next.
///
/// # Errors
/// [`ReportError::NoClasses`], [`ReportError::Empty`] without segments, and [`ReportError::Length`],
/// [`ReportError::ClassIndex`] or [`ReportError::Interval`] for an inconsistent segment.
pub fn posteriors(title: &str, x_label: &str, classes: &[Class], segments: &[Segment]) -> Result<String, ReportError> {
    validate(title, classes, segments)?;
    let empty = || ReportError::Empty { title: title.to_owned() };
    let x = Range::of(segments.iter().flat_map(|s| [s.start, s.end])).ok_or_else(empty)?.padded(0.0);
    let mut figure = Figure::new(title, 0);
    let every = (segments.len() * classes.len()).div_ceil(POSTERIORS);
    let (edges, shares) = steps(&joined(segments, every), classes.len());
    let unit = Range { lo: 0.0, hi: 1.0 };
    for (class, share) in classes.iter().zip(shares) {
        figure.add(
            Scatter::new(rounded(x, edges.iter().copied()), rounded(unit, share.into_iter()))
                .name(text(&class.name))
                .legend_group(text(&class.name))
                .mode(Mode::Lines)
                .line(Line::new().shape(LineShape::Hv).width(0.0).color(class.color.to_string()))
                .fill_color(class.color.to_string())
                .stack_group("posterior"),
        );
    }
    if every > 1 {
        figure.notes.push(format!("Mean posterior of {every} segments each."));
    }
    let mut rows = vec![Row { label: "posterior probability".into(), height: HEIGHT, axis: vertical(unit) }];
    let other = Class { name: "no class".into(), color: Color::rgb(0x7A, 0x7A, 0x7A), marker: Marker::Circle };
    let names = [classes, &[other]].concat();
    let strip = |label: &str, pick: &dyn Fn(&Segment) -> Option<usize>| {
        let span = |s: &Segment| Span { start: s.start, end: s.end, name: pick(s) };
        Strip {
            label: label.into(),
            names: names.clone(),
            spans: segments.iter().map(span).collect(),
            in_legend: false,
        }
    };
    if segments.iter().any(|s| s.truth.is_some()) {
        rows.push(strip("true class", &|s| s.truth).draw(&mut figure, rows.len(), x));
    }
    rows.push(strip("decision", &|s| s.decided.or(Some(classes.len()))).draw(&mut figure, rows.len(), x));
    if segments.iter().any(|s| s.decided.is_none()) {
        figure.add(crate::plot::strip::key(&names[classes.len()], &axis_name(rows.len() - 1)));
    }
    stack(&mut figure, Across { label: x_label, axis: Axis::new().range(x.axis()) }, rows, true);
    Ok(figure.html())
}

fn validate(title: &str, classes: &[Class], segments: &[Segment]) -> Result<(), ReportError> {
    let title = || title.to_owned();
    if classes.is_empty() {
        return Err(ReportError::NoClasses { title: title() });
    }
    for (row, segment) in segments.iter().enumerate() {
        if !usable(segment.start) || !usable(segment.end) || segment.end <= segment.start {
            return Err(ReportError::Interval { title: title(), row });
        }
        let (found, expected) = (segment.posteriors.len(), classes.len());
        if found != expected {
            return Err(ReportError::Length { title: title(), row, found, expected });
        }
        if let Some(class) = [segment.truth, segment.decided].into_iter().flatten().find(|&c| c >= expected) {
            return Err(ReportError::ClassIndex { title: title(), row, class, classes: expected });
        }
    }
    Ok(())
}

/// Groups of `every` neighbours with the mean of their posteriors.
fn joined(segments: &[Segment], every: usize) -> Vec<Segment> {
    if every <= 1 {
        return segments.to_vec();
    }
    let mean = |group: &[Segment]| {
        let mut sum = group[0].clone();
        for other in &group[1..] {
            sum.posteriors.iter_mut().zip(&other.posteriors).for_each(|(sum, p)| *sum += p);
        }
        sum.posteriors.iter_mut().for_each(|p| *p /= group.len() as f64);
        sum.end = group[group.len() - 1].end;
        sum
    };
    segments.chunks(every).map(mean).collect()
}

/// Edges of the steps, and the share of each class from each edge on; NaN where there is no segment.
fn steps(segments: &[Segment], classes: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let (mut edges, mut shares) = (Vec::new(), vec![Vec::new(); classes]);
    let mut push = |edge: f64, own: Option<&Segment>| {
        edges.push(edge);
        for (class, share) in shares.iter_mut().enumerate() {
            // Where nothing is known the area has no height.
            share.push(own.map_or(0.0, |own| own.posteriors[class]));
        }
    };
    let valid = |s: &&Segment| s.posteriors.iter().all(|p| p.is_finite() && *p >= 0.0);
    for (k, segment) in segments.iter().enumerate() {
        push(segment.start, Some(segment).filter(valid));
        if segments.get(k + 1).is_none_or(|next| next.start > segment.end) {
            // The last value, then nothing.
            push(segment.end, Some(segment).filter(valid));
            push(segment.end, None);
        }
    }
    (edges, shares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::named;

    fn segment(start: f64, end: f64, posteriors: &[f64]) -> Segment {
        Segment { start, end, truth: Some(0), decided: Some(1), posteriors: posteriors.into() }
    }

    fn plot(segments: &[Segment]) -> Result<String, ReportError> {
        posteriors("t", "time / s", &Class::all(&["<good>", "bad"]), segments)
    }

    #[test]
    fn gaps_and_invalid_posteriors_have_no_height() {
        let invalid = segment(1.0, 2.0, &[f64::NAN, 0.5]);
        let undecided = Segment { decided: None, ..segment(4.0, 5.0, &[0.5, 0.5]) };
        let html = plot(&[segment(0.0, 1.0, &[0.9, 0.1]), invalid, undecided]).expect("consistent");
        assert_eq!(check(&html), Ok(()));
        let good = &named(&html, "&lt;good&gt;")[0];
        assert_eq!(good["x"], serde_json::json!([0.0, 1.0, 2.0, 2.0, 4.0, 5.0, 5.0]));
        assert_eq!(good["y"], serde_json::json!([0.9, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0]));
        assert!(html.contains("no class"));
    }

    #[test]
    fn inconsistent_segments_are_errors() {
        assert!(matches!(plot(&[]), Err(ReportError::Empty { .. })));
        assert!(matches!(plot(&[segment(1.0, 1.0, &[1.0, 0.0])]), Err(ReportError::Interval { row: 0, .. })));
        assert!(matches!(plot(&[segment(0.0, 1.0, &[1.0])]), Err(ReportError::Length { found: 1, .. })));
        let bad = Segment { truth: Some(2), ..segment(0.0, 1.0, &[1.0, 0.0]) };
        assert!(matches!(plot(&[bad]), Err(ReportError::ClassIndex { class: 2, .. })));
        assert!(matches!(posteriors("t", "x", &[], &[]), Err(ReportError::NoClasses { .. })));
    }

    #[test]
    fn many_segments_are_averaged() {
        let many: Vec<Segment> = (0..20_000)
            .map(|i| segment(f64::from(i), f64::from(i) + 1.0, &[f64::from(i % 2), f64::from((i + 1) % 2)]))
            .collect();
        let html = plot(&many).expect("consistent");
        assert!(html.len() < 200_000 && html.contains("Mean posterior of 5"), "{} bytes", html.len());
    }
}
