//! Map of a decision rule over a plane, with points of known class.

use std::collections::BTreeSet;

use serde_json::json;

use super::regions::shade;
use crate::ReportError;
use crate::page::palette::Class;
use crate::plot::drawing::figure::{Figure, text};
use crate::plot::drawing::numbers::{Range, usable};
use crate::plot::drawing::plotly::{Axis, Line, Marker, Mode, Scatter, Symbol};
use crate::plot::drawing::theme::INK;
use crate::plot::series::rounded;

const HEIGHT: u32 = 540;
const INNER: f64 = 440.0;
/// Points closer than this share of the width are drawn once, if there are many.
const PIXELS: f64 = 700.0;
const MANY: usize = 1500;

/// The points whose true class is this one.
#[derive(Debug, Clone, PartialEq)]
pub struct ScatterClass {
    /// Name, colour and marker.
    pub class: Class,
    /// Points the rule was trained on, drawn open.
    pub training: Vec<(f64, f64)>,
    /// Points not used in training, drawn filled.
    pub held_out: Vec<(f64, f64)>,
    /// Points of either kind that the detector calls novel; marked by a cross.
    pub novel: Vec<(f64, f64)>,
}

impl ScatterClass {
    fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.training.iter().chain(&self.held_out).chain(&self.novel).copied()
    }
}

/// The held-out points for which `decide` does not return their class.
#[derive(Debug, Default)]
struct Misses {
    wrong: Vec<(f64, f64)>,
    undetermined: Vec<(f64, f64)>,
}

/// Decision regions, with training points open, held-out points filled, misclassified held-out points ringed and novel
/// points crossed.
///
/// `decide(x, y)` returns an index into `classes`; any larger value means undetermined and stays blank. It is called
/// about 20 000 times, at the centres of the cells. A few far outliers do not widen the first view; a note counts them.
///
/// # Errors
/// [`ReportError::NoClasses`] without classes, [`ReportError::Empty`] without a finite point.
pub fn scatter_regions(
    title: &str,
    x_label: &str,
    y_label: &str,
    classes: &[ScatterClass],
    decide: impl Fn(f64, f64) -> usize,
) -> Result<String, ReportError> {
    plane(title, (x_label, y_label), classes, Some(&decide))
}

/// The points without decision regions: no rule is known in this plane.
///
/// # Errors
/// As [`scatter_regions`].
pub fn scatter(title: &str, x_label: &str, y_label: &str, classes: &[ScatterClass]) -> Result<String, ReportError> {
    plane(title, (x_label, y_label), classes, None)
}

fn plane(
    title: &str,
    labels: (&str, &str),
    classes: &[ScatterClass],
    decide: Option<&dyn Fn(f64, f64) -> usize>,
) -> Result<String, ReportError> {
    if classes.is_empty() {
        return Err(ReportError::NoClasses { title: title.to_owned() });
    }
    let points = || classes.iter().flat_map(ScatterClass::points);
    let finite = || points().filter(|&(x, y)| usable(x) && usable(y));
    let empty = || ReportError::Empty { title: title.to_owned() };
    let x = Range::robust(finite().map(|p| p.0)).ok_or_else(empty)?.padded(0.06);
    let y = Range::robust(finite().map(|p| p.1)).ok_or_else(empty)?.padded(0.06);
    let mut figure = Figure::new(title, HEIGHT);
    let names: Vec<Class> = classes.iter().map(|one| one.class.clone()).collect();
    if decide.is_some_and(|decide| shade(&mut figure, (x, y), &names, decide)) {
        figure.notes.push("Where the plane is blank, the rule decides for no class.".to_owned());
    }
    let misses = decide.map_or_else(Misses::default, |decide| misses(classes, decide));
    draw_points(&mut figure, classes, &misses, (x, y));
    figure.note_gaps(points().count() - finite().count());
    figure.note_outside(finite().filter(|&(px, py)| !x.contains(px) || !y.contains(py)).count());
    let title = |label: &str| json!({ "title": { "text": text(label) } });
    figure.axis("xaxis", Axis::new().range(x.axis()), &title(labels.0));
    figure.axis("yaxis", Axis::new().range(y.axis()), &title(labels.1));
    figure.legend(INNER, 8.0);
    Ok(figure.html())
}

fn misses(classes: &[ScatterClass], decide: impl Fn(f64, f64) -> usize) -> Misses {
    let mut misses = Misses::default();
    for (truth, one) in classes.iter().enumerate() {
        for &(x, y) in one.held_out.iter().filter(|&&(x, y)| usable(x) && usable(y)) {
            match decide(x, y) {
                decided if decided == truth => {}
                decided if decided < classes.len() => misses.wrong.push((x, y)),
                _ => misses.undetermined.push((x, y)),
            }
        }
    }
    misses
}

/// The usable points; of many on the same pixel one is drawn.
fn place(points: &[(f64, f64)], (x, y): (Range, Range)) -> Vec<(f64, f64)> {
    let mut taken = BTreeSet::new();
    let pixel = |range: Range, value: f64| ((value - range.lo) / range.width() * PIXELS).round() as i64;
    let usable = points.iter().copied().filter(|&(px, py)| usable(px) && usable(py));
    usable.filter(|&(px, py)| points.len() <= MANY || taken.insert((pixel(x, px), pixel(y, py)))).collect()
}

fn draw_points(figure: &mut Figure, classes: &[ScatterClass], misses: &Misses, ranges: (Range, Range)) {
    let (mut training, mut held_out) = (Vec::new(), Vec::new());
    for ScatterClass { class, training: own, held_out: others, .. } in classes {
        let color = class.color.to_string();
        let line = Line::new().width(0.8).color("var(--paper)");
        training.push((own, format!("{}, training", class.name), class.marker.open(&color, 8).opacity(0.75)));
        held_out.push((others, format!("{}, held out", class.name), class.marker.filled(&color, 9).line(line)));
    }
    let ring = |symbol: Symbol, size: usize| {
        Marker::new().symbol(symbol).size(size).color(INK).line(Line::new().width(1.6).color(INK))
    };
    let novel: Vec<(f64, f64)> = classes.iter().flat_map(|one| one.novel.iter().copied()).collect();
    let marks = [
        (&misses.wrong, "misclassified", ring(Symbol::CircleOpen, 15)),
        (&misses.undetermined, "held out, undetermined", ring(Symbol::SquareOpen, 15)),
        (&novel, "novel", ring(Symbol::XThinOpen, 9)),
    ];
    let marks = marks.map(|(points, name, marker)| (points, format!("{name} ({})", points.len()), marker));
    for (points, name, marker) in training.into_iter().chain(held_out).chain(marks) {
        let placed = place(points, ranges);
        if placed.is_empty() {
            continue;
        }
        let along = |range: Range, pick: fn(&(f64, f64)) -> f64| rounded(range, placed.iter().map(pick));
        figure.add(
            Scatter::new(along(ranges.0, |p| p.0), along(ranges.1, |p| p.1))
                .name(text(&name))
                .mode(Mode::Markers)
                .marker(marker),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::named;

    fn class(index: usize, training: &[(f64, f64)], held_out: &[(f64, f64)]) -> ScatterClass {
        ScatterClass {
            class: Class::new(index, format!("<{index}>")),
            training: training.into(),
            held_out: held_out.into(),
            novel: vec![],
        }
    }

    #[test]
    fn misses_follow_the_rule_and_novel_points_are_marked() {
        let mut classes =
            [class(0, &[], &[(-1.0, 0.0), (1.0, 0.0), (9.0, 0.0)]), class(1, &[], &[(1.0, 0.0), (-1.0, f64::NAN)])];
        classes[1].novel = vec![(1.0, 0.0)];
        let decide = |x: f64, _: f64| if x > 5.0 { usize::MAX } else { usize::from(x > 0.0) };
        let html = scatter_regions("t", "x", "y", &classes, decide).expect("finite points");
        assert_eq!(check(&html), Ok(()));
        let at = |name: &str| named(&html, name)[0]["x"].clone();
        assert_eq!(at("misclassified (1)"), json!([1.0]));
        assert_eq!(at("held out, undetermined (1)"), json!([9.0]));
        assert_eq!(at("novel (1)"), json!([1.0]));
        assert_eq!(at("&lt;1&gt;, held out"), json!([1.0]));
        assert!(html.contains("decides for no class") && html.contains("1 point is not finite"));
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let decide = |_, _| 0;
        assert_eq!(scatter_regions("t", "x", "y", &[], decide), Err(ReportError::NoClasses { title: "t".into() }));
        let empty = Err(ReportError::Empty { title: "t".into() });
        assert_eq!(scatter_regions("t", "x", "y", &[class(0, &[(f64::NAN, 1.0)], &[])], decide), empty);
    }

    #[test]
    fn outliers_and_duplicates_do_not_inflate() {
        let mut points: Vec<(f64, f64)> = (0..3000).map(|i| (f64::from(i % 10), f64::from(i % 7))).collect();
        points.push((1e9, 0.0));
        let html = scatter_regions("t", "x", "y", &[class(0, &points, &[])], |_, _| 0).expect("finite points");
        let drawn = named(&html, "&lt;0&gt;, training")[0]["x"].as_array().map(Vec::len);
        assert!(html.contains("1 point lies outside") && drawn == Some(71), "{drawn:?}");
    }
}
