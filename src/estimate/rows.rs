//! What the two sources of rows, [`Regressor`](super::Regressor) and [`Instruments`](super::Instruments), have in
//! common.

use super::{Estimate, Method, Order, Regression};
use crate::detector::Sample;

/// One row for the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Row<const M: usize> {
    /// Scaled columns, target last.
    pub cells: [f32; M],
    /// Weight in 0 … 1: below one for an outlier.
    pub weight: f32,
    /// (Δu1)² + (Δu2)², scaled as the levels are: how much the inputs move, with instruments the prefiltered ones.
    pub motion: f32,
}

/// Samples → rows: the regressor of least squares, or that and the instruments.
pub trait Rows<const M: usize>: Clone + core::fmt::Debug + PartialEq {
    /// The structure, if it is known when compiling.
    type Shape: Shape;

    /// Nothing sampled yet.
    fn new(regression: &Regression<M>) -> Self;

    /// Whether this source makes the rows of that regression, and holds its delays.
    fn fits(regression: &Regression<M>) -> bool;

    /// Takes an accepted sample; gives its row, or nothing while a lag is missing or a filter settles.
    fn push(&mut self, regression: &Regression<M>, sample: &Sample) -> Option<Row<M>>;

    /// Forgets every lag.
    fn flush(&mut self, regression: &Regression<M>);

    /// A segment is closed; a new one starts with the next sample.
    fn next_segment(&mut self, regression: &Regression<M>);

    /// Lets an estimate take over as reference (and auxiliary model) at the next handover.
    fn adopt<const P: usize>(&mut self, regression: &Regression<M>, estimate: &Estimate<M, P>);

    /// Whether the handover of the open segment is still ahead.
    fn awaits(&self) -> bool;

    /// What the levels of y, u1, u2 are taken from.
    fn origin(&self) -> [f32; 3];

    /// Steady-state gain of the prefilter's denominator |A(1)|, by which output error becomes the row's residual; 1 by
    /// least squares.
    fn gain(&self) -> f32;

    /// The δ-parameters whose prediction error the target column holds; zeros where it holds Δy itself.
    fn base(&self, regression: &Regression<M>) -> [f32; M];

    /// Segments in a row whose model did not take over.
    fn refused(&self) -> u8;
}

/// What the rows look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Form {
    /// Terms and delays.
    pub order: Order,
    /// Whether there is a constant.
    pub offset: bool,
    /// Least squares or instrumental variables.
    pub method: Method,
}

impl Form {
    /// Parameters with their own column as instrument, and those with an instrument apart.
    #[inline(always)]
    pub(super) const fn split(self) -> (usize, usize) {
        let n = self.order.columns(self.offset) - 1;
        let outputs = match self.method {
            Method::LeastSquares => 0,
            Method::Instruments => self.order.na as usize,
        };
        (n - outputs, outputs)
    }
}

/// The form of the rows, if it is known when compiling: loops over terms are then straight-line code.
///
/// ```
/// use bearing_watch::estimate::{Form, Method, Order, Shape};
/// /// Two output terms, one of each input, no constant.
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// struct Mine;
/// impl Shape for Mine {
///     const FIXED: Option<Form> =
///         Some(Form { order: Order::new(2, 1, 1, 1, 1), offset: false, method: Method::LeastSquares });
/// }
/// type Estimator<'m> = bearing_watch::Estimator<'m, 5, 10, 1, bearing_watch::estimate::Regressor<5, 1, Mine>>;
/// ```
pub trait Shape: Clone + Copy + core::fmt::Debug + PartialEq {
    /// The form; nothing where the regression tells at run time.
    const FIXED: Option<Form>;

    /// The form to run with.
    #[inline(always)]
    #[must_use]
    fn of<const M: usize>(regression: &Regression<M>) -> Form {
        match Self::FIXED {
            Some(fixed) => fixed,
            None => regression.form(),
        }
    }

    /// Whether the regression has this form.
    #[must_use]
    fn fits<const M: usize>(regression: &Regression<M>) -> bool {
        Self::of(regression) == regression.form()
    }
}

/// Any form: what a program needs that learns the order when it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AnyShape;

impl Shape for AnyShape {
    const FIXED: Option<Form> = None;
}

/// Two signals as they were some samples ago.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Delays<const L: usize> {
    rings: [[f32; L]; 2],
    places: [u8; 2],
}

impl<const L: usize> Delays<L> {
    pub(super) const fn new() -> Self {
        Self { rings: [[0.0; L]; 2], places: [0; 2] }
    }

    #[inline]
    pub(super) fn push(&mut self, [u1, u2]: [f32; 2], [nkb, nkc]: [u8; 2]) -> [f32; 2] {
        let ([first, second], [place_1, place_2]) = (&mut self.rings, &mut self.places);
        [exchange(first, place_1, u1, nkb), exchange(second, place_2, u2, nkc)]
    }
}

#[inline]
fn exchange(ring: &mut [f32], place: &mut u8, newest: f32, delay: u8) -> f32 {
    let Some(cell) = ring.get_mut(*place as usize) else { return newest };
    if delay == 0 {
        return newest;
    }
    *place = if *place + 1 >= delay { 0 } else { *place + 1 };
    core::mem::replace(cell, newest)
}
