//! Rows and sums whose kind a model tells at run time.
//!
//! Firmware names the kind in its detector's type; the workbench reads models of every kind. Each call goes to the
//! core's own type, so the arithmetic, and every bit, is the core's.

use bearing_watch::estimate::{
    Accumulator, AnyShape, Estimate, Fading, Instruments, MAX_LONG_SEGMENT_SAMPLES, MAX_SEGMENT_SAMPLES, Mass, Memory,
    Method, Regression, Regressor, Row, Rows, Triangle, TwoLevel,
};
use bearing_watch::{Sample, Sampling};

/// Rows of least squares or of instrumental variables.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum AnyRows<const M: usize, const L: usize> {
    Squares(Regressor<M, L>),
    Instruments(Instruments<M, L>),
}

/// The call on whichever kind it is.
macro_rules! rows {
    ($own:expr, $inner:ident => $call:expr) => {
        match $own {
            Self::Squares($inner) => $call,
            Self::Instruments($inner) => $call,
        }
    };
}

impl<const M: usize, const L: usize> Rows<M> for AnyRows<M, L> {
    type Shape = AnyShape;

    fn new(regression: &Regression<M>) -> Self {
        match regression.method {
            Method::LeastSquares => Self::Squares(Regressor::new(regression)),
            Method::Instruments => Self::Instruments(Instruments::new(regression)),
        }
    }

    fn fits(regression: &Regression<M>) -> bool {
        match regression.method {
            Method::LeastSquares => Regressor::<M, L>::fits(regression),
            Method::Instruments => Instruments::<M, L>::fits(regression),
        }
    }

    fn push(&mut self, regression: &Regression<M>, sample: &Sample) -> Option<Row<M>> {
        rows!(self, inner => inner.push(regression, sample))
    }

    fn flush(&mut self, regression: &Regression<M>) {
        rows!(self, inner => inner.flush(regression));
    }

    fn next_segment(&mut self, regression: &Regression<M>) {
        rows!(self, inner => inner.next_segment(regression));
    }

    fn adopt<const P: usize>(&mut self, regression: &Regression<M>, estimate: &Estimate<M, P>) {
        rows!(self, inner => inner.adopt(regression, estimate));
    }

    fn awaits(&self) -> bool {
        rows!(self, inner => Rows::<M>::awaits(inner))
    }

    fn origin(&self) -> [f32; 3] {
        rows!(self, inner => Rows::<M>::origin(inner))
    }

    fn gain(&self) -> f32 {
        rows!(self, inner => Rows::<M>::gain(inner))
    }

    fn base(&self, regression: &Regression<M>) -> [f32; M] {
        rows!(self, inner => inner.base(regression))
    }

    fn refused(&self) -> u8 {
        rows!(self, inner => Rows::<M>::refused(inner))
    }
}

/// One segment, in two levels where it is `LONG`, or fading memory.
///
/// Length is a matter of [`Sampling`], which sums never see, hence the parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum AnySums<const M: usize, const P: usize, const LONG: bool> {
    Segment(Triangle<M, P>),
    TwoLevel(TwoLevel<M, P>),
    Fading(Fading<M, P>),
}

/// Whether a model's segments need two levels.
pub(super) fn is_long(sampling: &Sampling) -> bool {
    sampling.segment_samples > MAX_SEGMENT_SAMPLES
}

impl<const M: usize, const P: usize, const LONG: bool> AnySums<M, P, LONG> {
    fn segment(columns: usize) -> Self {
        if LONG { Self::TwoLevel(Accumulator::<M, P>::new(columns)) } else { Self::Segment(Triangle::new(columns)) }
    }
}

/// The call on whichever kind it is.
macro_rules! sums {
    ($own:expr, $inner:ident => $call:expr) => {
        match $own {
            Self::Segment($inner) => $call,
            Self::TwoLevel($inner) => $call,
            Self::Fading($inner) => $call,
        }
    };
}

impl<const M: usize, const P: usize, const LONG: bool> Accumulator<M, P> for AnySums<M, P, LONG> {
    const LONGEST: u32 = if LONG { MAX_LONG_SEGMENT_SAMPLES } else { MAX_SEGMENT_SAMPLES };

    fn new(columns: usize) -> Self {
        Self::segment(columns)
    }

    fn fits(_regression: &Regression<M>) -> bool {
        true
    }

    fn add(&mut self, regression: &Regression<M>, row: &Row<M>) -> bool {
        // Only now is the regression known; empty sums of every kind are alike.
        if regression.memory != Memory::Segment && !matches!(self, Self::Fading(_)) {
            *self = Self::Fading(Accumulator::<M, P>::new(regression.columns()));
        }
        sums!(self, inner => inner.add(regression, row))
    }

    fn total<T>(&self, read: impl FnOnce(&Triangle<M, P>) -> T) -> T {
        sums!(self, inner => inner.total(read))
    }

    fn mass(&self, regression: &Regression<M>, rows: u32) -> Mass {
        sums!(self, inner => inner.mass(regression, rows))
    }

    fn next_segment(&mut self) {
        sums!(self, inner => Accumulator::<M, P>::next_segment(inner));
    }

    fn restart(&mut self) {
        sums!(self, inner => Accumulator::<M, P>::restart(inner));
    }
}
