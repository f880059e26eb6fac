//! Evaluates a decision rule on a grid and covers the result with few rectangles.

use std::fmt::Write as _;

use super::axis::Axis;
use super::frame::Area;
use super::svg::Svg;

/// Edge of a cell in drawing units, finest first. With the coarsest, the size is small even if every cell differs.
const CELL_SIZES: [f64; 3] = [2.5, 5.0, 10.0];
/// If the result is larger than this, a coarser grid is used.
const MAX_BYTES: usize = 250_000;
/// Horizontal distance of the hatching lines in drawing units.
const HATCH_SPACING: f64 = 7.0;

/// Decisions at the centres of the cells, row by row from the top.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    columns: u32,
    cells: Vec<usize>,
}

/// Cells `column..column + width`, `row..row + height` with the same decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    column: u32,
    row: u32,
    width: u32,
    height: u32,
    class: usize,
}

impl Grid {
    fn new(columns: u32, rows: u32, decide: impl Fn(f64, f64) -> usize) -> Self {
        let centre = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
        let cells = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| decide(centre(column, columns), centre(row, rows)))
            .collect();
        Self { columns, cells }
    }

    fn rows(&self) -> impl Iterator<Item = (u32, &[usize])> {
        (0u32..).zip(self.cells.chunks(self.columns as usize))
    }

    /// Merges runs along a row, then equal runs of neighbouring rows.
    fn blocks(&self) -> Vec<Block> {
        let (mut done, mut open): (Vec<Block>, Vec<Block>) = (Vec::new(), Vec::new());
        for (row, cells) in self.rows() {
            let mut next = Vec::new();
            let mut column = 0;
            for run in cells.chunk_by(|a, b| a == b) {
                let width = u32::try_from(run.len()).unwrap_or(0);
                let new = Block { column, row, width, height: 1, class: run[0] };
                // Open blocks are ordered by column, because each row is processed from left to right.
                let above = open.binary_search_by_key(&column, |block| block.column).ok().map(|i| open[i]);
                next.push(match above {
                    Some(old) if (old.width, old.class) == (width, new.class) => {
                        Block { height: old.height + 1, ..old }
                    }
                    _ => new,
                });
                column += width;
            }
            done.extend(open.iter().filter(|old| !next.iter().any(|n| (n.column, n.row) == (old.column, old.row))));
            open = next;
        }
        done.extend(open);
        done
    }

    /// Hatching lines over the cells whose decision is none of `classes`, along the diagonals of the grid.
    fn hatching(&self, classes: usize, every: u32) -> String {
        let height = u32::try_from(self.cells.len()).unwrap_or(0) / self.columns;
        let free = |column: u32, row: u32| self.cells[(row * self.columns + column) as usize] >= classes;
        let mut d = String::new();
        for diagonal in (0..self.columns + height - 1).step_by(every as usize) {
            let first = diagonal.saturating_sub(height - 1);
            let columns: Vec<u32> = (first..=diagonal.min(self.columns - 1)).collect();
            for run in columns.chunk_by(|a, b| free(*a, diagonal - a) == free(*b, diagonal - b)) {
                if free(run[0], diagonal - run[0]) {
                    let _ = write!(d, "M{} {}l{2} -{2}", run[0], diagonal - run[0] + 1, run.len());
                }
            }
        }
        d
    }
}

/// Shades the area by `decide` in data units; `colors[class]` tints a region, any other class is hatched.
/// Returns whether at least one cell is hatched.
pub(super) fn shade(
    svg: &mut Svg,
    area: Area,
    axes: (&Axis, &Axis),
    colors: &[super::super::palette::Color],
    decide: impl Fn(f64, f64) -> usize,
) -> bool {
    let (width, height) = (area.right - area.left, area.bottom - area.top);
    let mut paths = Vec::new();
    let (mut columns, mut rows) = (1, 1);
    for size in CELL_SIZES {
        (columns, rows) = (count(width / size), count(height / size));
        let grid = Grid::new(columns, rows, |u, v| {
            decide(axes.0.value(area.left + u * width), axes.1.value(area.top + v * height))
        });
        paths = paths_of(&grid, colors.len(), count(HATCH_SPACING / size));
        if paths.iter().map(String::len).sum::<usize>() <= MAX_BYTES {
            break;
        }
    }
    let (scale_x, scale_y) = (width / f64::from(columns), height / f64::from(rows));
    let transform =
        format!("transform=\"translate({:.1} {:.1}) scale({scale_x:.5} {scale_y:.5})\"", area.left, area.top);
    for (color, d) in colors.iter().zip(&paths) {
        svg.path(&format!("class=\"region\" fill=\"{color}\" {transform}"), d);
    }
    let hatching = paths.last().map_or("", String::as_str);
    svg.path(&format!("class=\"hatch wide\" {transform}"), hatching);
    !hatching.is_empty()
}

/// One path per class and a last path for the hatching, in cell coordinates.
fn paths_of(grid: &Grid, classes: usize, every: u32) -> Vec<String> {
    let mut paths = vec![String::new(); classes];
    for block in grid.blocks() {
        if let Some(d) = paths.get_mut(block.class) {
            let Block { column, row, width, height, .. } = block;
            let _ = write!(d, "M{column} {row}h{width}v{height}h-{width}z");
        }
    }
    paths.push(grid.hatching(classes, every));
    paths
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few hundred cells; casts saturate")]
fn count(value: f64) -> u32 {
    (value.round() as u32).max(1)
}

#[cfg(test)]
mod tests {
    use super::super::axis::Range;
    use super::*;

    fn rule(x: f64, y: f64) -> usize {
        if x * x + y * y < 0.4 { 0 } else { usize::from(x > y) + 1 }
    }

    #[test]
    fn blocks_cover_every_cell_once_as_decided() {
        let (columns, rows) = (61, 47);
        let grid = Grid::new(columns, rows, rule);
        let mut seen = vec![None; (columns * rows) as usize];
        for block in grid.blocks() {
            for row in block.row..block.row + block.height {
                for column in block.column..block.column + block.width {
                    let cell = &mut seen[(row * columns + column) as usize];
                    assert_eq!(cell.replace(block.class), None, "cell {column} {row} covered twice");
                }
            }
        }
        for (i, cell) in (0u32..).zip(seen) {
            let (u, v) = (f64::from(i % columns) + 0.5, f64::from(i / columns) + 0.5);
            assert_eq!(cell, Some(rule(u / f64::from(columns), v / f64::from(rows))));
        }
    }

    #[test]
    fn regions_lie_where_the_rule_puts_them_in_data_units() {
        let area = Area { left: 0.0, top: 0.0, right: 100.0, bottom: 50.0 };
        let x = Axis::horizontal(Range { lo: 10.0, hi: 20.0 }, area.left, area.right);
        let y = Axis::vertical(Range { lo: -1.0, hi: 1.0 }, area.top, area.bottom);
        let mut svg = Svg::new();
        let color = super::super::super::palette::Color::of(0);
        // The upper left quarter: 20 of 40 columns, 10 of 20 rows from the top.
        let hatched = shade(&mut svg, area, (&x, &y), &[color], |x, y| usize::from(x > 15.0 || y < 0.0));
        assert!(hatched && svg.finish("", 100.0, 50.0).contains("d=\"M0 0h20v10h-20z\""));
    }

    #[test]
    fn half_planes_need_two_blocks() {
        assert_eq!(Grid::new(50, 40, |x, _| usize::from(x > 0.5)).blocks().len(), 2);
    }

    #[test]
    fn hatching_covers_only_the_undecided() {
        assert_eq!(Grid::new(4, 3, |_, _| 0).hatching(1, 1), "");
        assert_eq!(Grid::new(2, 2, |_, _| 1).hatching(1, 1), "M0 1l1 -1M0 2l2 -2M1 2l1 -1");
    }

    #[test]
    fn a_rule_that_flickers_stays_small() {
        let area = Area { left: 60.0, top: 10.0, right: 740.0, bottom: 450.0 };
        let x = Axis::horizontal(Range { lo: 0.0, hi: 1.0 }, area.left, area.right);
        let y = Axis::vertical(Range { lo: 0.0, hi: 1.0 }, area.top, area.bottom);
        let mut svg = Svg::new();
        let colors = [0, 1].map(super::super::super::palette::Color::of);
        shade(&mut svg, area, (&x, &y), &colors, |x, y| {
            usize::from(((x * 7919.0).sin() * (y * 104_729.0).sin()) > 0.0)
        });
        assert!(svg.finish("", 760.0, 500.0).len() < 300_000);
    }
}
