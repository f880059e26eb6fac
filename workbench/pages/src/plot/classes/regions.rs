//! Decision regions: the class that a rule decides in each cell of a plane.

use crate::page::palette::Class;
use crate::plot::drawing::figure::Figure;
use crate::plot::drawing::numbers::Range;
use crate::plot::drawing::plotly::{HeatMap, HoverInfo};
use crate::plot::strip::scale;

/// Cells along the two axes.
const CELLS: [u32; 2] = [180, 120];

/// Shades the plane by `decide`, which returns an index into `classes`; any other value leaves the cell blank. Returns
/// whether a cell is blank.
pub(in crate::plot) fn shade(
    figure: &mut Figure,
    (x, y): (Range, Range),
    classes: &[Class],
    decide: impl Fn(f64, f64) -> usize,
) -> bool {
    let centres = |range: Range, count: u32| -> Vec<f64> {
        (0..count).map(|k| range.lo + range.width() * (f64::from(k) + 0.5) / f64::from(count)).collect()
    };
    let (columns, rows) = (centres(x, CELLS[0]), centres(y, CELLS[1]));
    let decided = |px: f64, py: f64| Some(decide(px, py)).filter(|&class| class < classes.len());
    let cells: Vec<Vec<Option<usize>>> =
        rows.iter().map(|&py| columns.iter().map(|&px| decided(px, py)).collect()).collect();
    let blank = cells.iter().flatten().any(Option::is_none);
    let rounded = |range: Range, values: Vec<f64>| values.into_iter().map(|v| range.rounded(v)).collect();
    figure.add(
        HeatMap::new(rounded(x, columns), rounded(y, rows), cells)
            .color_scale(scale(classes))
            .zmin(-0.5)
            .zmax(classes.len() as f64 - 0.5)
            .opacity(0.2)
            .show_scale(false)
            .hover_info(HoverInfo::Skip),
    );
    blank
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::drawing::figure::drawn;

    #[test]
    fn cells_lie_where_the_rule_puts_them() {
        let mut figure = Figure::new("t", 100);
        let (x, y) = (Range { lo: 10.0, hi: 20.0 }, Range { lo: -1.0, hi: 1.0 });
        let classes = Class::all(&["a", "b"]);
        let decide = |x: f64, y: f64| if y > 0.0 { usize::from(x > 15.0) } else { 9 };
        assert!(shade(&mut figure, (x, y), &classes, decide));
        let map = &drawn(&figure.html())["data"][0];
        let at = |row: usize, column: usize| &map["z"][row][column];
        assert!(at(0, 0).is_null() && at(119, 89) == 0 && at(119, 90) == 1, "{}", at(119, 90));
        assert!(map["x"][89].as_f64() < Some(15.0) && map["y"][60].as_f64() > Some(0.0));
    }
}
