//! One order: block phasors and their products.
//!
//! The numbers (1) … (6) are those of [`super::tracking`].

use super::blocks::LAGS;
use super::phasor::phasor;
use crate::plan::MAX_HARMONICS;
use crate::unroll::no_unroll;

/// Sums of one order over the blocks of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LineSums {
    /// R(h, 1 … 6) of (4).
    pub lags: [[[f32; 2]; LAGS]; MAX_HARMONICS],
    /// R(h, 0): Σ |b|², and products of passages through the same cell.
    pub power: [f32; MAX_HARMONICS],
    /// Σ W.
    pub weight: [f32; MAX_HARMONICS],
    /// V(0) with the products of passages through the same cell twice, then V(1 … 6).
    pub pairs: [f32; LAGS + 1],
}

impl LineSums {
    pub(super) const EMPTY: Self = Self {
        lags: [[[0.0; 2]; LAGS]; MAX_HARMONICS],
        power: [0.0; MAX_HARMONICS],
        weight: [0.0; MAX_HARMONICS],
        pairs: [0.0; LAGS + 1],
    };
}

/// Running state of one order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Line {
    /// b of the last blocks.
    history: [[[f32; 2]; LAGS]; MAX_HARMONICS],
    /// W of the first harmonic of the last blocks.
    weights: [f32; LAGS],
}

pub(super) const LINE: Line = Line { history: [[[0.0; 2]; LAGS]; MAX_HARMONICS], weights: [0.0; LAGS] };

/// The last blocks, with which a block is compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Last<'a> {
    /// Their cells.
    pub cells: &'a [i32; LAGS],
    /// How many there are.
    pub held: usize,
    /// Where the block is kept.
    pub index: usize,
    /// Whether the block there is of the same passage and grows by this one.
    pub continues: bool,
}

/// c of (2) of the harmonics of an order.
pub(super) type Harmonics = [[f32; 2]; MAX_HARMONICS];

/// Adds a sample of `y g` at this phase (2).
#[inline(always)]
pub(super) fn add([first, second, third]: &mut Harmonics, harmonics: u8, phase: u32, product: f32) {
    let (cos, sin) = phasor(phase);
    accumulate(first, product, cos, sin);
    if harmonics < 2 {
        return;
    }
    let twice = sin + sin; // (6)
    let (cos_2, sin_2) = (1.0 - twice * sin, twice * cos);
    accumulate(second, product, cos_2, sin_2);
    if harmonics < 3 {
        return;
    }
    let double = cos_2 + cos_2;
    accumulate(third, product, (double - 1.0) * cos, (double + 1.0) * sin);
}

impl Line {
    /// Closes a part of harmonic h, b and W, in this cell: its products with the last blocks.
    #[inline(always)]
    pub(super) fn close(
        &mut self,
        sums: &mut LineSums,
        h: usize,
        ([x, y], w): ([f32; 2], f32),
        (cell, last): (i32, Last<'_>),
    ) {
        let Some(history) = self.history.get_mut(h) else {
            return;
        };
        let (Some(lags), Some(power), Some(total)) =
            (sums.lags.get_mut(h), sums.power.get_mut(h), sums.weight.get_mut(h))
        else {
            return;
        };
        *power += x * x + y * y;
        *total += w;
        let own_weight = if h == 0 { w } else { 0.0 };
        let [square, pairs @ ..] = &mut sums.pairs;
        *square += own_weight * own_weight;
        let blocks = no_unroll(history.as_slice()).iter().zip(last.cells).zip(&self.weights);
        let filled = blocks.take(last.held);
        for ((&[hx, hy], &other), &other_weight) in filled {
            let (real, imaginary) = (x * hx + y * hy, y * hx - x * hy);
            let apart = cell.wrapping_sub(other);
            if apart == 0 {
                *power += 2.0 * real;
                *square += 2.0 * own_weight * other_weight;
                continue;
            }
            let d = (apart.unsigned_abs() as usize).wrapping_sub(1);
            if let (Some([rx, ry]), Some(pair)) = (lags.get_mut(d), pairs.get_mut(d)) {
                *rx += real; // (4)
                *ry += if apart < 0 { -imaginary } else { imaginary };
                *pair += own_weight * other_weight; // (5)
            }
        }
        if let Some([hx, hy]) = history.get_mut(last.index) {
            let [kept_x, kept_y] = if last.continues { [*hx, *hy] } else { [0.0; 2] };
            (*hx, *hy) = (kept_x + x, kept_y + y);
        }
        if h == 0
            && let Some(cell) = self.weights.get_mut(last.index)
        {
            *cell = if last.continues { *cell + w } else { w };
        }
    }
}

/// Adds a sample of (2).
#[inline(always)]
pub(super) fn accumulate([x, y]: &mut [f32; 2], product: f32, cos: f32, sin: f32) {
    *x += product * cos;
    *y -= product * sin;
}
