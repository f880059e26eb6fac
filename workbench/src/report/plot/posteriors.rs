//! Stacked posteriors of the classified segments of a recording over time.
//!
//! ```text
//! true     ▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓   true class, if known
//! 1 ┬
//!   │      ▒▒▒▒▒▒▓▓▓▓▓▓▓▓▓▓   P(class | segment), stacked in the order of the classes
//! 0 ┴
//! decided  ▓▓▓▓▓▓╱╱╱╱▓▓▓▓▓▓   decision of the detector; undetermined is hatched
//! ```

use super::super::ReportError;
use super::super::palette::Class;
use super::axis::{Axis, CHAR_WIDTH, Range, usable};
use super::frame::{Area, BOTTOM, Key, WIDTH, figure, frame, panel_head, x_ticks, x_title};
use super::svg::{Anchor, Svg, block, hatch, num};

const HEIGHT: f64 = 170.0;
const STRIP_HEIGHT: f64 = 26.0;
const STRIP_GAP: f64 = 11.0;

/// One classified time interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Start in seconds, or in the unit of the axis title.
    pub start: f64,
    /// End, after `start`.
    pub end: f64,
    /// Index of the true class, if known.
    pub truth: Option<usize>,
    /// Index of the decided class; `None` if undetermined.
    pub decided: Option<usize>,
    /// One probability per class. If one is negative or not finite, the bar stays empty.
    pub posteriors: Vec<f64>,
}

/// Stacked posteriors over time between a strip of the true classes and a strip of the decisions.
///
/// Segments are drawn in the order given; if one overlaps the next, it is cut at the start of the next.
///
/// # Errors
/// [`ReportError::NoClasses`], [`ReportError::Empty`] without segments, and [`ReportError::Length`],
/// [`ReportError::ClassIndex`] or [`ReportError::Interval`] for an inconsistent segment.
pub fn posteriors(title: &str, x_label: &str, classes: &[Class], segments: &[Segment]) -> Result<String, ReportError> {
    validate(title, classes, segments)?;
    let empty = || ReportError::Empty { title: title.to_owned() };
    let time = Range::of(segments.iter().flat_map(|s| [s.start, s.end])).ok_or_else(empty)?.padded(0.0);
    let strip = STRIP_HEIGHT + STRIP_GAP;
    let area = Area::new(7.0 * CHAR_WIDTH, HEIGHT);
    let area = Area { top: area.top + strip, bottom: area.bottom + strip, ..area };
    let x = Axis::horizontal(time, area.left, area.right);
    let y = Axis::vertical(Range { lo: 0.0, hi: 1.0 }, area.top, area.bottom);
    let spans = spans(segments, &x);

    let mut svg = Svg::new();
    draw_strip(&mut svg, "true", area.top - strip, area.left, classes, runs(segments, &spans, |s| s.truth), false);
    draw_bars(&mut svg, classes, segments, &spans, &y);
    for &tick in &y.ticks {
        svg.text("class=\"tick\"", Anchor::End, area.left - 8.0, y.at(tick), &y.label(tick));
    }
    frame(&mut svg, area);
    let below = area.bottom + STRIP_GAP;
    draw_strip(&mut svg, "decided", below, area.left, classes, runs(segments, &spans, |s| s.decided), true);
    x_ticks(&mut svg, &x, below + STRIP_HEIGHT);

    let mut keys: Vec<_> = classes.iter().map(|class| (Key::Area(class.color), class.name.clone())).collect();
    if segments.iter().any(|s| s.decided.is_none()) {
        keys.push((Key::Hatch, "undetermined".to_owned()));
    }
    let drawing = svg.finish(title, WIDTH, below + STRIP_HEIGHT + BOTTOM);
    let body = format!("{}{drawing}{}", panel_head("posterior probability", &keys), x_title(&x.title(x_label)));
    Ok(figure(title, &body, &[]))
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

/// Start and end of every segment in drawing units, cut at the start of the next segment.
fn spans(segments: &[Segment], x: &Axis) -> Vec<(f64, f64)> {
    let next = segments.iter().skip(1).map(|s| s.start).chain([f64::INFINITY]);
    segments
        .iter()
        .zip(next)
        .map(|(s, next)| (x.at(s.start), x.at(if next > s.start { s.end.min(next) } else { s.end })))
        .collect()
}

/// Merges adjacent segments with the same label, so that the size of a strip depends on its number of changes.
fn runs(
    segments: &[Segment],
    spans: &[(f64, f64)],
    label: impl Fn(&Segment) -> Option<usize>,
) -> Vec<(f64, f64, Option<usize>)> {
    let mut runs: Vec<(f64, f64, Option<usize>)> = Vec::new();
    for (segment, &(start, end)) in segments.iter().zip(spans) {
        match runs.last_mut() {
            Some(last) if last.2 == label(segment) && (start - last.1).abs() < 0.5 => last.1 = end,
            _ => runs.push((start, end, label(segment))),
        }
    }
    runs
}

/// A strip of class colours; an interval that is wide enough contains the class name. Intervals without a class are
/// hatched or left blank.
fn draw_strip(
    svg: &mut Svg,
    name: &str,
    top: f64,
    left: f64,
    classes: &[Class],
    runs: Vec<(f64, f64, Option<usize>)>,
    hatched: bool,
) {
    let bottom = top + STRIP_HEIGHT;
    let middle = 0.5 * (top + bottom);
    svg.text("class=\"tick\"", Anchor::End, left - 8.0, middle, name);
    let mut paths = vec![String::new(); classes.len()];
    let mut hatching = String::new();
    for &(start, end, class) in &runs {
        match class {
            Some(class) => paths[class].push_str(&block(start, top, end, bottom)),
            None if hatched => hatching.push_str(&hatch(start, top, end, bottom)),
            None => {}
        }
    }
    for (class, d) in classes.iter().zip(&paths) {
        svg.path(&format!("class=\"area\" fill=\"{}\"", class.color), d);
    }
    svg.path("class=\"hatch\"", &hatching);
    for (start, end, class) in runs {
        let Some(class) = class.and_then(|class| classes.get(class)) else { continue };
        // The characters of a name are narrower than those of tick labels.
        let width = 0.9 * CHAR_WIDTH * f64::from(u16::try_from(class.name.chars().count()).unwrap_or(u16::MAX));
        let room = end - start - CHAR_WIDTH;
        // Names of class "roomy" are hidden on a phone, because the text is larger relative to the drawing there.
        let class_name = match room {
            room if room > width => "on",
            room if room > 0.7 * width => "on roomy",
            _ => continue,
        };
        let attributes = format!("class=\"{class_name}\" fill=\"{}\"", class.color.text_on());
        svg.text(&attributes, Anchor::Middle, 0.5 * (start + end), middle, &class.name);
    }
}

/// Draws a stack of bars, one path per class. Segments within the same pixel are averaged.
fn draw_bars(svg: &mut Svg, classes: &[Class], segments: &[Segment], spans: &[(f64, f64)], y: &Axis) {
    let bars = bars(segments, spans);
    let mut floor = vec![0.0; bars.len()];
    for (index, class) in classes.iter().enumerate() {
        let mut d = String::new();
        for (bar, floor) in bars.iter().zip(&mut floor) {
            // A total above 1 would exceed the frame.
            let top = (*floor + bar.posteriors[index]).min(1.0);
            if num(y.at(top)) != num(y.at(*floor)) {
                d.push_str(&block(bar.start, y.at(*floor), bar.end, y.at(top)));
            }
            *floor = top;
        }
        svg.path(&format!("class=\"area\" fill=\"{}\"", class.color), &d);
    }
    // Fine gaps separate wide bars; narrow bars have none, because the gaps would cover most of the drawing.
    let gaps = bars.iter().filter(|bar| bar.end - bar.start > 6.0);
    let gaps: String = gaps.map(|bar| format!("M{} {}V{}", num(bar.end), num(y.at(0.0)), num(y.at(1.0)))).collect();
    svg.path("class=\"gap\"", &gaps);
    let undetermined = runs(segments, spans, |s| s.decided).into_iter().filter(|run| run.2.is_none());
    let over: Vec<(f64, f64)> = undetermined.map(|(start, end, _)| (start, end)).collect();
    let hatching: String = over.iter().map(|&(start, end)| hatch(start, y.at(1.0), end, y.at(0.0))).collect();
    svg.path("class=\"hatch over\"", &hatching);
}

struct Bar {
    start: f64,
    end: f64,
    posteriors: Vec<f64>,
    count: f64,
}

fn bars(segments: &[Segment], spans: &[(f64, f64)]) -> Vec<Bar> {
    let mut bars: Vec<Bar> = Vec::new();
    let valid = |segment: &Segment| segment.posteriors.iter().all(|p| usable(*p) && *p >= 0.0);
    for (segment, &(start, end)) in segments.iter().zip(spans).filter(|(segment, _)| valid(segment)) {
        match bars.last_mut() {
            Some(bar) if end >= bar.start && end - bar.start < 1.0 => {
                bar.end = bar.end.max(end);
                bar.count += 1.0;
                for (mean, p) in bar.posteriors.iter_mut().zip(&segment.posteriors) {
                    *mean += (p - *mean) / bar.count;
                }
            }
            _ => bars.push(Bar { start, end, posteriors: segment.posteriors.clone(), count: 1.0 }),
        }
    }
    bars
}

#[cfg(test)]
mod tests {
    use super::super::super::well_formed::check;
    use super::*;

    fn segment(start: f64, end: f64, posteriors: &[f64]) -> Segment {
        Segment { start, end, truth: Some(0), decided: None, posteriors: posteriors.into() }
    }

    fn plot(segments: &[Segment]) -> Result<String, ReportError> {
        posteriors("t", "time / s", &Class::all(&["a<b", "c"]), segments)
    }

    #[test]
    fn odd_probabilities_give_a_valid_plot() {
        for values in [[0.2, 0.8], [f64::NAN, 1.0], [-1.0, 2.0], [7.0, 7.0], [0.0, 0.0]] {
            let html = plot(&[segment(0.0, 1.0, &values), segment(0.5, 2.0, &values)]).expect("consistent");
            assert_eq!(check(&html), Ok(()), "{values:?}");
            assert!(html.contains("a&lt;b") && html.contains("hatch"));
        }
    }

    #[test]
    fn inconsistent_segments_are_named() {
        let good = segment(0.0, 1.0, &[0.5, 0.5]);
        let row_1 = |bad: Segment| plot(&[good.clone(), bad]).map(|_| ());
        let title = "t".to_owned();
        let interval = Err(ReportError::Interval { title: title.clone(), row: 1 });
        assert_eq!(row_1(segment(1.0, 1.0, &[0.5, 0.5])), interval);
        assert_eq!(row_1(segment(1.0, f64::NAN, &[0.5, 0.5])), interval);
        let length = ReportError::Length { title: title.clone(), row: 1, found: 1, expected: 2 };
        assert_eq!(row_1(segment(1.0, 2.0, &[1.0])), Err(length));
        let index = ReportError::ClassIndex { title: title.clone(), row: 1, class: 2, classes: 2 };
        assert_eq!(row_1(Segment { decided: Some(2), ..segment(1.0, 2.0, &[0.5, 0.5]) }), Err(index));
        assert_eq!(plot(&[]), Err(ReportError::Empty { title: title.clone() }));
        assert_eq!(posteriors("t", "x", &[], &[good]), Err(ReportError::NoClasses { title }));
    }

    #[test]
    fn overlapping_segments_are_cut_and_narrow_ones_averaged() {
        let many: Vec<Segment> = (0..20_000)
            .map(|i| segment(f64::from(i), f64::from(i) + 3.0, &[f64::from(i % 2), f64::from((i + 1) % 2)]))
            .collect();
        let html = plot(&many).expect("consistent");
        assert!(html.len() < 60_000, "{} bytes", html.len());
        let x = Axis::horizontal(Range { lo: 0.0, hi: 20_003.0 }, 0.0, 700.0);
        assert!(bars(&many, &spans(&many, &x)).iter().any(|bar| (bar.posteriors[0] - 0.5).abs() < 0.1));
    }
}
