//! One order: filtered excitation, block phasors, and their products.
//!
//! The numbers (1) … (6) are those of [`super::tracking`].

use super::blocks::{Blocks, LAGS};
use super::phasor::phasor;
use super::residual::{Filter, Residual};
use crate::plan::MAX_HARMONICS;

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

/// The filter (2) of one harmonic's excitation, real and imaginary part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Template {
    real: Filter,
    imaginary: Filter,
}

impl Template {
    const EMPTY: Self = Self { real: Filter::EMPTY, imaginary: Filter::EMPTY };

    /// Takes the excitation, and adds the sample to a block's b and W.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        blocks: &Blocks,
        residual: Residual,
        (cos, sin): (f32, f32),
        ([x, y], w): (&mut [f32; 2], &mut f32),
    ) {
        let Residual { white, excitation } = residual;
        let (tx, ty) = (self.real.step(blocks, excitation * cos), self.imaginary.step(blocks, excitation * sin)); // (2)
        *x += white * tx; // (3)
        *y -= white * ty;
        *w += tx * tx + ty * ty;
    }
}

/// Running state of one order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Line {
    templates: [Template; MAX_HARMONICS],
    /// b of (3).
    pub(super) block: [[f32; 2]; MAX_HARMONICS],
    /// W of (3).
    pub(super) weight: [f32; MAX_HARMONICS],
    /// b of the last blocks.
    history: [[[f32; 2]; LAGS]; MAX_HARMONICS],
    /// W of the first harmonic of the last blocks.
    weights: [f32; LAGS],
    pub(super) sums: LineSums,
}

pub(super) const LINE: Line = Line {
    templates: [Template::EMPTY; MAX_HARMONICS],
    block: [[0.0; 2]; MAX_HARMONICS],
    weight: [0.0; MAX_HARMONICS],
    history: [[[0.0; 2]; LAGS]; MAX_HARMONICS],
    weights: [0.0; LAGS],
    sums: LineSums::EMPTY,
};

impl Line {
    #[inline(always)]
    pub(super) fn add(&mut self, harmonics: u8, phase: u32, blocks: &Blocks, residual: Residual) {
        let (cos, sin) = phasor(phase);
        let [first, second, third] = &mut self.templates;
        let [b1, b2, b3] = &mut self.block;
        let [w1, w2, w3] = &mut self.weight;
        first.add(blocks, residual, (cos, sin), (b1, w1));
        if harmonics < 2 {
            return;
        }
        let twice = sin + sin; // (6)
        let (cos_2, sin_2) = (1.0 - twice * sin, twice * cos);
        second.add(blocks, residual, (cos_2, sin_2), (b2, w2));
        if harmonics < 3 {
            return;
        }
        let double = cos_2 + cos_2;
        third.add(blocks, residual, ((double - 1.0) * cos, (double + 1.0) * sin), (b3, w3));
    }

    /// Closes the block of harmonic h: its products with the `held` last blocks, the newest before `place`.
    #[inline(always)]
    pub(super) fn close(&mut self, h: usize, cell: i32, cells: &[i32; LAGS], (held, place): (usize, usize)) {
        let (Some(block), Some(weight), Some(history)) =
            (self.block.get_mut(h), self.weight.get_mut(h), self.history.get_mut(h))
        else {
            return;
        };
        let ([x, y], w) = (core::mem::take(block), core::mem::take(weight));
        let sums = &mut self.sums;
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
        let filled = history.iter().zip(cells).zip(&self.weights).take(held);
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
        if let Some(cell) = history.get_mut(place) {
            *cell = [x, y];
        }
        if h == 0
            && let Some(cell) = self.weights.get_mut(place)
        {
            *cell = w;
        }
    }
}
