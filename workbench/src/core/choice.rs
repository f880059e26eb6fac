//! Rows and sums of the kind that a model tells at run time.
//!
//! Firmware names the kind in its detector's type; the workbench reads models of every kind. Each call goes to the
//! core's own type, so the arithmetic, and every bit, is the core's.

use bearing_watch::estimate::{
    AnyShape, Estimate, Instruments, MAX_SEGMENT_SAMPLES, Memory, Method, Regression, Regressor, Row, Rows,
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

/// The core's type that sums a model's rows. Each is its own type of detector, since what the core decides by the type
/// (whether rows fade) an enumeration cannot tell.
pub(super) enum Sums {
    Triangle,
    TwoLevel,
    Fading,
}

impl Sums {
    pub(super) fn of<const M: usize>(regression: &Regression<M>, sampling: &Sampling) -> Self {
        match regression.memory {
            Memory::Fading(_) => Self::Fading,
            Memory::Segment if sampling.segment_samples > MAX_SEGMENT_SAMPLES => Self::TwoLevel,
            Memory::Segment => Self::Triangle,
        }
    }
}
