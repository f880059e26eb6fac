//! The rows of a plan: by least squares ([`Squares`]) or by instrumental variables ([`Instruments`]).

use super::constants::Regression;
use super::factor::Row;
use super::inputs::{Inputs, Reference};
use super::instruments::{self, Instruments};
use super::squares::Squares;
use crate::plan::{Array, Cells, Layout, Method, Plan, Presence};

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
            squares: P::Squares::part(layout.squares() == 1, || Squares::new(plan)),
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
            squares.next_segment();
        }
        if let Some(instruments) = self.instruments.part_mut() {
            instruments.next_segment(plan, constants);
        }
    }

    /// Offers an estimate as auxiliary model for the next handover: δ-parameters. Least squares has no use for it.
    pub fn offer(&mut self, plan: P, delta: &[f32]) {
        if let Some(instruments) = self.instruments.part_mut() {
            instruments.auxiliary.offer(instruments::parameters(plan, delta));
        }
    }

    /// Whether the handover of the open segment is still ahead.
    #[must_use]
    pub fn awaits(&self) -> bool {
        self.instruments.part().is_some_and(|instruments| instruments.auxiliary.awaits())
    }

    /// What a solve needs to know of the rows.
    #[inline(always)]
    #[must_use]
    pub fn frame(&self, plan: P) -> Reference<P> {
        match (self.squares.part(), self.instruments.part()) {
            (_, Some(instruments)) => instruments.frame(plan),
            (squares, None) => {
                let origin = squares.map_or([0.0; 3], |squares| squares.origin);
                Reference { origin, ..Reference::of_zeros(plan) }
            }
        }
    }

    /// Segments in a row whose model did not take over; 0 by least squares.
    #[must_use]
    pub fn refused(&self) -> u8 {
        self.instruments.part().map_or(0, |instruments| instruments.auxiliary.refused)
    }
}

#[inline(always)]
fn method(layout: Layout) -> Option<Method> {
    layout.regression.map(|regression| regression.method)
}
