//! Least-squares estimates of any structure from one factorisation of the traces; each costs a small triangularisation.
//!
//! ```text
//! X_wide = Q R                      all lags of y, u1, u2, the constant and the target, rows T … N−1      (1)
//! X_t₀   = [X_wide; rows t₀ … T−1]  R of X_wide updated by those rows                             (2)
//! ```
//!
//! T is the depth of the widest structure. The columns of a structure are a subset of those of X_t₀; its factor is the
//! triangularised subset of the columns of (2), so that its sums start at its own t₀ as in [`crate::identify`]. A lag
//! in (2) that reaches before the record is set to zero; no structure with that t₀ uses it. Several traces are stacked:
//! one θ for all.

use crate::identify::Structure;
use crate::identify::kernel::triangle::{DEPENDENT, Triangle, block_rows, solve_staircase};
use crate::trace::Trace;

/// The factors (2) for every t₀ down to that of the shallowest structure.
#[derive(Debug)]
pub(super) struct Shared {
    layout: Layout,
    shallowest: usize,
    /// Indexed by t₀ − `shallowest`.
    triangles: Vec<Triangle>,
    /// Number of samples of each trace.
    lengths: Vec<usize>,
}

/// A least-squares solution.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    pub theta: Vec<f64>,
    pub residual_sum: f64,
    pub rows: usize,
}

/// The lag of each column of the widest regressor.
#[derive(Clone, Debug)]
struct Layout {
    na: usize,
    /// First lag and number of columns of u1 and u2.
    u: [(usize, usize); 2],
    offset: bool,
}

impl Layout {
    fn of(structures: &[Structure]) -> Self {
        let na = structures.iter().map(|s| usize::from(s.na)).max().unwrap_or(0);
        let range = |terms: fn(Structure) -> (u8, u8)| {
            let used = structures.iter().map(|s| terms(*s)).filter(|(n, _)| *n > 0);
            let first = used.clone().map(|(_, delay)| usize::from(delay)).min().unwrap_or(0);
            let end = used.map(|(n, delay)| usize::from(n) + usize::from(delay)).max().unwrap_or(0);
            (first, end.saturating_sub(first))
        };
        let u = [range(|o| (o.nb, o.nkb)), range(|o| (o.nc, o.nkc))];
        Self { na, u, offset: structures.iter().any(|s| s.offset) }
    }

    /// Number of columns, including the target.
    fn columns(&self) -> usize {
        self.na + self.u[0].1 + self.u[1].1 + usize::from(self.offset) + 1
    }

    /// Signal (0 for y, 1 for u1, 2 for u2) and lag of each column except the constant and the target.
    fn lags(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let inputs = self.u.iter().enumerate().flat_map(|(k, &(first, n))| (first..first + n).map(move |l| (k + 1, l)));
        (1..=self.na).map(|lag| (0, lag)).chain(inputs)
    }

    /// Columns of a structure, the target last.
    fn choose(&self, structure: Structure, chosen: &mut Vec<usize>) {
        let Structure { na, nb, nc, nkb, nkc, .. } = structure;
        chosen.clear();
        chosen.extend(0..usize::from(na));
        let mut start = self.na;
        for ((first, columns), (terms, delay)) in self.u.into_iter().zip([(nb, nkb), (nc, nkc)]) {
            let begin = start + usize::from(delay).saturating_sub(first);
            chosen.extend(begin..begin + usize::from(terms));
            start += columns;
        }
        chosen.extend(structure.offset.then_some(start));
        chosen.push(self.columns() - 1);
    }

    /// Rows t … t+height−1 of a trace, column-major; values before the record are zero.
    fn fill(&self, trace: &Trace, t: usize, height: usize, block: &mut [f64]) {
        let mut columns = block.chunks_exact_mut(height);
        let signals = [&trace.y, &trace.u1, &trace.u2];
        for ((signal, lag), column) in self.lags().zip(&mut columns) {
            let missing = lag.saturating_sub(t).min(height);
            column[..missing].fill(0.0);
            if missing < height {
                column[missing..].copy_from_slice(&signals[signal][t + missing - lag..][..height - missing]);
            }
        }
        if self.offset
            && let Some(column) = columns.next()
        {
            column.fill(1.0);
        }
        if let Some(target) = columns.next() {
            target.copy_from_slice(&trace.y[t..][..height]);
        }
    }
}

impl Shared {
    /// Factors the widest regressor of these structures; each trace must have more samples than their depth.
    pub(super) fn new(traces: &[Trace], structures: &[Structure]) -> Self {
        let layout = Layout::of(structures);
        let depths = structures.iter().map(|s| s.depth());
        let deepest = depths.clone().max().unwrap_or(0);
        let shallowest = depths.min().unwrap_or(0);
        let columns = layout.columns();
        let mut triangle = Triangle::new(columns, columns);
        let rows = block_rows(columns);
        let mut block = vec![0.0; columns * rows];
        for trace in traces {
            for t in (deepest..trace.y.len()).step_by(rows) {
                let height = rows.min(trace.y.len() - t);
                layout.fill(trace, t, height, &mut block);
                triangle.absorb(&mut block, height);
            }
        }
        let mut triangles = vec![triangle.clone()];
        for t in (shallowest..deepest).rev() {
            for trace in traces {
                layout.fill(trace, t, 1, &mut block);
                triangle.absorb(&mut block, 1);
            }
            triangles.push(triangle.clone());
        }
        triangles.reverse();
        Self { layout, shallowest, triangles, lengths: traces.iter().map(|t| t.y.len()).collect() }
    }

    /// Least-squares estimate of one of the structures.
    ///
    /// # Errors
    /// The first parameter whose column depends linearly on the columns before it.
    pub(super) fn solve(&self, structure: Structure, scratch: &mut Scratch) -> Result<Solution, usize> {
        let t0 = structure.depth();
        let triangle = &self.triangles[t0 - self.shallowest];
        let Scratch { chosen, heights, columns } = scratch;
        self.layout.choose(structure, chosen);
        let stride = self.layout.columns();
        heights.clear();
        heights.extend(chosen.iter().map(|column| column + 1));
        columns.clear();
        for &column in chosen.iter() {
            columns.extend_from_slice(triangle.column(column));
        }
        let residual_sum = solve_staircase(columns, stride, heights, DEPENDENT)?;
        let n = chosen.len() - 1;
        let mut theta = columns[n * stride..][..n].to_vec();
        // The columns hold +y; the model has −y.
        for a in &mut theta[..usize::from(structure.na)] {
            *a = -*a;
        }
        let rows = self.lengths.iter().map(|length| length - t0).sum();
        Ok(Solution { theta, residual_sum, rows })
    }
}

/// Working memory of [`Shared::solve`], one per thread.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    chosen: Vec<usize>,
    heights: Vec<usize>,
    columns: Vec<f64>,
}
