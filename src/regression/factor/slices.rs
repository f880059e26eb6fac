//! Loops over slices that the steps of a solve share: one copy of their code for every size.

use core::cell::Cell;

use super::kernels::pairs;

/// `start − Σ r(j) x(j)`.
#[inline(never)]
pub(super) fn minus(start: f32, r: &[f32], x: &[f32]) -> f32 {
    r.iter().zip(x).fold(start, |value, (r, x)| value - r * x)
}

/// Multiplies the cells by `common` scale.
#[inline(never)]
pub(super) fn times(cells: &mut [f32], scale: &[f32], common: f32) {
    pairs(cells, scale).for_each(|(cell, scale)| *cell *= scale * common);
}

/// Adds `weight` x to the cells.
#[inline(never)]
pub(super) fn add(cells: &mut [f32], x: &[f32], weight: f32) {
    pairs(cells, x).for_each(|(cell, x)| *cell += weight * x);
}

/// Copies cells to a place before them.
#[inline(never)]
pub(super) fn to_front(cells: &mut [f32], to: usize, from: usize, count: usize) {
    if to == from {
        return;
    }
    let cells = Cell::from_mut(cells).as_slice_of_cells();
    let to = cells.get(to..to.wrapping_add(count)).unwrap_or(&[]);
    pairs(to, cells.get(from..).unwrap_or(&[])).for_each(|(to, from)| to.set(from.get()));
}

#[inline(never)]
pub(super) fn copy(cells: &mut [f32], from: &[f32]) {
    pairs(cells, from).for_each(|(cell, r)| *cell = *r);
}

#[inline(always)]
pub(super) fn put(cells: &mut [f32], index: usize, value: f32) {
    if let Some(cell) = cells.get_mut(index) {
        *cell = value;
    }
}
