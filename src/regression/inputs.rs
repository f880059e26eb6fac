//! What a regression takes from a sample, what a solve must know of its rows, and sums over lags.

use crate::plan::{Array, Cells, Plan, RegressionLayout, Signal, Signals};
use crate::signal::read;
use crate::unroll::unrolled;

/// Output and both inputs of the regression at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Inputs {
    /// Output.
    pub y: f32,
    /// First input.
    pub u1: f32,
    /// Second input.
    pub u2: f32,
}

impl Inputs {
    /// The signals that a regression takes from a sample; an input without terms is 0.
    #[inline(always)]
    #[must_use]
    pub fn of(layout: &RegressionLayout, sample: &impl Signals) -> Self {
        let input = |terms: u8, signal: Signal| if terms > 0 { read(signal, sample) } else { 0.0 };
        let structure = layout.structure;
        Self { y: read(layout.y, sample), u1: input(structure.nb, layout.u1), u2: input(structure.nc, layout.u2) }
    }
}

/// What a solve needs to know of the rows.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reference<P: Plan> {
    /// Values that are subtracted from the levels of y, u1, u2.
    pub origin: [f32; 3],
    /// δ-parameters whose prediction is subtracted from the target column; zeros if it contains Δy itself.
    pub base: Array<P::Parameters, f32>,
    /// Steady-state gain |A(1)| of the prefilter, by which an output error becomes the residual of a row; 1 by least
    /// squares.
    pub gain: f32,
}

impl<P: Plan> Reference<P> {
    /// By least squares, of levels from zero.
    #[inline(always)]
    #[must_use]
    pub(crate) fn of_zeros(plan: P) -> Self {
        Self { origin: [0.0; 3], base: Cells::filled(plan.layout().parameters(), 0.0), gain: 1.0 }
    }
}

/// Adds the products of values and gains to `start`, in this order.
#[inline(always)]
pub(super) fn dot(start: f32, values: &[f32], gains: &[f32]) -> f32 {
    let (mut sum, mut values, mut gains) = (start, values, gains);
    unrolled!(let ([value, later @ ..], [gain, rest @ ..]) = (values, gains) => {
        sum += gain * value;
        (values, gains) = (later, rest);
    });
    sum
}

/// Moves values on by one place; `newest` comes first, and the last one is lost.
#[inline(always)]
pub(super) fn carry_on(cells: &mut [f32], newest: f32) {
    let (mut cells, mut carried) = (cells, newest);
    unrolled!(let [cell, rest @ ..] = cells => {
        carried = core::mem::replace(cell, carried);
        cells = rest;
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Memory, Method, RunTimeSample, Structure, testing};
    use std::vec;

    #[test]
    fn an_input_without_terms_is_zero() {
        let sample = RunTimeSample { values: vec![1.0, 2.0, 3.0], ..RunTimeSample::default() };
        for (nb, nc, expected) in [(1, 1, [1.0, 2.0, 3.0]), (0, 1, [1.0, 0.0, 2.0]), (1, 0, [1.0, 2.0, 0.0])] {
            let structure = Structure::new(1, nb, nc, 1, 1);
            let layout = testing::regression(structure, Method::LeastSquares, Memory::Segment).regression.unwrap();
            let Inputs { y, u1, u2 } = Inputs::of(&layout, &sample);
            assert_eq!([y, u1, u2], expected, "{nb} {nc}");
        }
    }

    #[test]
    fn a_signal_may_be_the_difference_of_two_channels() {
        let sample = RunTimeSample { values: vec![1.0, 5.0], ..RunTimeSample::default() };
        assert_eq!(read(Signal::channel(1).minus(Signal::channel(0)), &sample), 4.0);
    }
}
