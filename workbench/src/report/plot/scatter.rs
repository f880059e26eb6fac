//! Map of a decision rule over a plane, with points of known class.

use std::collections::BTreeSet;

use super::super::ReportError;
use super::super::palette::{Class, Color};
use super::axis::{Axis, Range, usable};
use super::frame::{Area, BOTTOM, Key, RING, WIDTH, figure, gap_note, grid, panel_head, ring_class, x_title};
use super::regions::shade;
use super::svg::{Svg, markers, num};

const HEIGHT: f64 = 460.0;

/// The points whose true class is this one.
#[derive(Debug, Clone, PartialEq)]
pub struct ScatterClass {
    /// Name, colour and marker.
    pub class: Class,
    /// Points the rule was trained on, drawn open.
    pub training: Vec<(f64, f64)>,
    /// Points not used in training, drawn filled.
    pub held_out: Vec<(f64, f64)>,
}

impl ScatterClass {
    fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.training.iter().chain(&self.held_out).copied()
    }
}

/// The held-out points for which `decide` does not return their class.
#[derive(Debug, Default)]
struct Misses {
    wrong: Vec<(f64, f64)>,
    undetermined: Vec<(f64, f64)>,
}

/// Decision regions, with training points open, held-out points filled and misclassified held-out points ringed.
///
/// `decide(x, y)` returns an index into `classes`; any larger value means undetermined, which is hatched. It is
/// called about 50 000 times, at the centres of the cells. A few far outliers do not widen the axes; they are drawn on
/// the edge and counted in a note.
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
    if classes.is_empty() {
        return Err(ReportError::NoClasses { title: title.to_owned() });
    }
    let points = || classes.iter().flat_map(ScatterClass::points);
    let finite = || points().filter(|&(x, y)| usable(x) && usable(y));
    let empty = || ReportError::Empty { title: title.to_owned() };
    let x_range = Range::robust(finite().map(|p| p.0)).ok_or_else(empty)?.padded(0.06);
    let y_range = Range::robust(finite().map(|p| p.1)).ok_or_else(empty)?.padded(0.06);
    let area = Area::new(0.0, HEIGHT);
    let y = Axis::vertical(y_range, area.top, area.bottom);
    let area = Area::new(y.label_width(), HEIGHT);
    let x = Axis::horizontal(x_range, area.left, area.right);

    let mut svg = Svg::new();
    let colors: Vec<Color> = classes.iter().map(|one| one.class.color).collect();
    let hatched = shade(&mut svg, area, (&x, &y), &colors, &decide);
    grid(&mut svg, area, &x, &y, true);
    let misses = misses(classes, decide);
    draw_points(&mut svg, classes, &misses, |points| place(points, &x, &y));

    let head = panel_head(&y.title(y_label), &keys(classes, &misses, hatched));
    let drawing = svg.finish(title, WIDTH, area.bottom + BOTTOM);
    let mut notes = gap_note(points().count() - finite().count());
    match finite().filter(|&(px, py)| !x_range.contains(px) || !y_range.contains(py)).count() {
        0 => {}
        1 => notes.push("1 point lies outside the axes and is drawn on the edge.".to_owned()),
        n => notes.push(format!("{n} points lie outside the axes and are drawn on the edge.")),
    }
    Ok(figure(title, &format!("{head}{drawing}{}", x_title(&x.title(x_label))), &notes))
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

/// Positions in drawing units; points on the same pixel are drawn once, points outside are drawn on the edge.
fn place(points: &[(f64, f64)], x: &Axis, y: &Axis) -> Vec<(f64, f64)> {
    let mut taken = BTreeSet::new();
    let inside = |axis: &Axis, value: f64| axis.at(value.clamp(axis.range.lo, axis.range.hi));
    points
        .iter()
        .filter(|&&(px, py)| usable(px) && usable(py))
        .map(|&(px, py)| (inside(x, px), inside(y, py)))
        .filter(|&(px, py)| taken.insert((num(px.round()), num(py.round()))))
        .collect()
}

fn draw_points(
    svg: &mut Svg,
    classes: &[ScatterClass],
    misses: &Misses,
    place: impl Fn(&[(f64, f64)]) -> Vec<(f64, f64)>,
) {
    for ScatterClass { class, training, .. } in classes {
        svg.path(&format!("class=\"open\" stroke=\"{}\"", class.color), &markers(class.marker, place(training)));
    }
    for ScatterClass { class, held_out, .. } in classes {
        svg.path(&format!("class=\"dot\" fill=\"{}\"", class.color), &markers(class.marker, place(held_out)));
    }
    for (points, dashed) in [(&misses.wrong, false), (&misses.undetermined, true)] {
        let rings: String = place(points).iter().map(|&(x, y)| format!("M{} {}{RING}", num(x), num(y))).collect();
        svg.path(ring_class(dashed), &rings);
    }
}

fn keys(classes: &[ScatterClass], misses: &Misses, hatched: bool) -> Vec<(Key, String)> {
    let mut keys: Vec<(Key, String)> =
        classes.iter().map(|one| (Key::Region(one.class.color, one.class.marker), one.class.name.clone())).collect();
    let (training, held_out) =
        (classes.iter().any(|one| !one.training.is_empty()), classes.iter().any(|one| !one.held_out.is_empty()));
    if training {
        keys.push((Key::Open, "training".to_owned()));
    }
    if held_out {
        keys.push((Key::Filled, "held out".to_owned()));
        keys.push((Key::Ring { dashed: false }, format!("misclassified ({})", misses.wrong.len())));
    }
    if !misses.undetermined.is_empty() {
        keys.push((Key::Ring { dashed: true }, format!("held out, undetermined ({})", misses.undetermined.len())));
    }
    if hatched {
        keys.push((Key::Hatch, "undetermined".to_owned()));
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::super::super::well_formed::check;
    use super::*;

    fn class(index: usize, training: &[(f64, f64)], held_out: &[(f64, f64)]) -> ScatterClass {
        ScatterClass {
            class: Class::new(index, format!("<{index}>")),
            training: training.into(),
            held_out: held_out.into(),
        }
    }

    #[test]
    fn misses_follow_the_rule() {
        let classes =
            [class(0, &[], &[(-1.0, 0.0), (1.0, 0.0), (9.0, 0.0)]), class(1, &[], &[(1.0, 0.0), (-1.0, f64::NAN)])];
        let decide = |x: f64, _: f64| if x > 5.0 { usize::MAX } else { usize::from(x > 0.0) };
        let misses = misses(&classes, decide);
        assert_eq!((misses.wrong, misses.undetermined), (vec![(1.0, 0.0)], vec![(9.0, 0.0)]));
        let html = scatter_regions("t", "x", "y", &classes, decide).expect("finite points");
        assert_eq!(check(&html), Ok(()));
        assert!(
            html.contains("misclassified (1)") && html.contains("class=\"hatch wide\"") && html.contains("&lt;0&gt;")
        );
    }

    #[test]
    fn degenerate_points_give_a_valid_plot() {
        for points in [&[(2.0, 3.0)][..], &[(1.0, 1.0); 7], &[(f64::NAN, 0.0), (0.0, 0.0)], &[(0.0, 1.0), (0.0, 2.0)]] {
            let html = scatter_regions("t", "x", "y", &[class(0, points, &[])], |_, _| 0).expect("finite point");
            assert_eq!(check(&html), Ok(()), "{points:?}");
        }
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
        assert!(html.contains("1 point lies outside") && html.len() < 15_000, "{} bytes", html.len());
    }
}
