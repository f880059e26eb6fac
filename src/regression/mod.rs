//! Samples → rows of the regression.
//!
//! [`Rows`] makes them by least squares ([`Squares`]) or by instrumental variables ([`Instruments`]), as the plan says.

mod auxiliary;
mod constants;
mod delays;
mod instruments;
mod squares;

pub use constants::Regression;

use crate::factor::Row;
use crate::plan::{Array, Cells, Layout, Method, Plan, Presence, RegressionLayout, Signal, Signals};
use crate::unroll::unrolled;
use instruments::Instruments;
use squares::Squares;

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

/// The value of a signal in a sample.
#[inline(always)]
pub fn read(signal: Signal, sample: &impl Signals) -> f32 {
    let value = sample.value(signal.channel as usize);
    match signal.minus {
        Some(other) => value - sample.value(other as usize),
        None => value,
    }
}

/// What a solve needs to know of the rows.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame<P: Plan> {
    /// Values that are subtracted from the levels of y, u1, u2.
    pub origin: [f32; 3],
    /// δ-parameters whose prediction is subtracted from the target column; zeros if it contains Δy itself.
    pub base: Array<P::Parameters, f32>,
    /// Steady-state gain |A(1)| of the prefilter, by which an output error becomes the residual of a row; 1 by least
    /// squares.
    pub gain: f32,
}

/// The source of rows.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rows<P: Plan> {
    squares: Array<P::Squares, Squares<P>>,
    instruments: Array<P::Instruments, Instruments<P>>,
}

impl<P: Plan> Rows<P> {
    /// Nothing sampled yet.
    #[must_use]
    pub fn new(plan: P, constants: &Regression<P>) -> Self {
        let layout = plan.layout();
        Self {
            squares: P::Squares::part(layout.squares() == 1, || Squares::new(plan, constants)),
            instruments: P::Instruments::part(layout.instruments() == 1, || Instruments::new(plan, constants)),
        }
    }

    /// Takes an accepted sample; returns its row, or `None` while a lag is missing or a filter settles. `y_limit` is
    /// the largest plausible output.
    #[inline(always)]
    pub fn push(&mut self, plan: P, constants: &Regression<P>, inputs: Inputs, y_limit: f32) -> Option<Row<'_>> {
        match method(plan.layout())? {
            Method::LeastSquares => self.squares.part_mut()?.push(plan, constants, inputs),
            Method::Instruments => self.instruments.part_mut()?.push(plan, constants, inputs, y_limit),
        }
    }

    /// Forgets every lag, after a refused sample.
    pub fn flush(&mut self, plan: P) {
        if let Some(squares) = self.squares.part_mut() {
            squares.flush();
        }
        if let Some(instruments) = self.instruments.part_mut() {
            instruments.flush(plan);
        }
    }

    /// Starts a segment with the next sample.
    pub fn next_segment(&mut self, plan: P, constants: &Regression<P>) {
        if let Some(squares) = self.squares.part_mut() {
            squares.next_segment(plan, constants);
        }
        if let Some(instruments) = self.instruments.part_mut() {
            instruments.next_segment(plan, constants);
        }
    }

    /// Offers an estimate as auxiliary model for the next handover: δ-parameters, and the standard deviation of its
    /// residuals.
    pub fn offer(&mut self, plan: P, constants: &Regression<P>, delta: &[f32], deviation: f32) {
        if let Some(squares) = self.squares.part_mut() {
            squares.auxiliary.offer(squares::candidate(plan, constants, delta, deviation));
        }
        if let Some(instruments) = self.instruments.part_mut() {
            instruments.auxiliary.offer(instruments::candidate(plan, constants, delta, deviation));
        }
    }

    /// Whether the handover of the open segment is still ahead.
    #[must_use]
    pub fn awaits(&self) -> bool {
        let squares = self.squares.part().is_some_and(|squares| squares.auxiliary.awaits());
        squares || self.instruments.part().is_some_and(|instruments| instruments.auxiliary.awaits())
    }

    /// What a solve needs to know of the rows.
    #[inline(always)]
    #[must_use]
    pub fn frame(&self, plan: P) -> Frame<P> {
        match (self.squares.part(), self.instruments.part()) {
            (_, Some(instruments)) => instruments.frame(plan),
            (squares, None) => Frame {
                origin: squares.map_or([0.0; 3], |squares| squares.origin),
                base: Cells::filled(plan.layout().parameters(), 0.0),
                gain: 1.0,
            },
        }
    }

    /// Segments in a row whose model did not take over.
    #[must_use]
    pub fn refused(&self) -> u8 {
        let squares = self.squares.part().map_or(0, |squares| squares.auxiliary.refused);
        self.instruments.part().map_or(squares, |instruments| instruments.auxiliary.refused)
    }
}

/// Adds the products of values and gains to `start`, in this order.
#[inline(always)]
fn dot(start: f32, values: &[f32], gains: &[f32]) -> f32 {
    let (mut sum, mut values, mut gains) = (start, values, gains);
    unrolled!(let ([value, later @ ..], [gain, rest @ ..]) = (values, gains) => {
        sum += gain * value;
        (values, gains) = (later, rest);
    });
    sum
}

/// Moves values on by one place; `newest` comes first, and the last one is lost.
#[inline(always)]
fn carry_on(cells: &mut [f32], newest: f32) {
    let (mut cells, mut carried) = (cells, newest);
    unrolled!(let [cell, rest @ ..] = cells => {
        carried = core::mem::replace(cell, carried);
        cells = rest;
    });
}

#[inline(always)]
fn method(layout: Layout) -> Option<Method> {
    layout.regression.map(|regression| regression.method)
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
