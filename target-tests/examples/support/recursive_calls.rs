//! Calls of the recursive estimator for the example `panic_free`.

use core::hint::black_box as opaque;

use bearing_watch::Model;
use bearing_watch::model::Forgetting;
use bearing_watch::plan::{Cells, Plan};
use bearing_watch::recursive::{ClosedSegment, RecursiveEstimator, Triangle, is_stable};

/// Every public function of an estimator alone.
pub fn run<P: Plan>(model: &Model<P>, mut sample: impl FnMut() -> P::Sample) {
    let constants = opaque(model.constants());
    let [regression, ..] = constants.regression.cells() else { return };
    let mut estimator = opaque(RecursiveEstimator::new(model.plan(), &constants.channels, regression));
    for _ in 0..opaque(50) {
        RecursiveEstimator::step(&mut estimator, &opaque(sample()));
    }
    opaque((RecursiveEstimator::rows(&estimator), RecursiveEstimator::counts(&estimator)));
    opaque(RecursiveEstimator::estimate(&estimator));
    let mut closed = opaque(RecursiveEstimator::detach(&mut estimator));
    if let Some(estimate) = ClosedSegment::advance(&mut closed, regression) {
        opaque(RecursiveEstimator::adopt(&mut estimator, opaque(estimate)));
    }
    opaque(ClosedSegment::finish(closed, regression));
    opaque(RecursiveEstimator::close(&mut estimator));
    RecursiveEstimator::next_segment(&mut estimator);
    RecursiveEstimator::restart(&mut estimator);
    opaque(is_stable(opaque(&[-0.1, 0.5, 0.1])));
    triangle();
}

fn triangle() {
    let mut triangle = opaque(Triangle::<[f32; 4], [f32; 6]>::new(4));
    Triangle::update(&mut triangle, &opaque([1.0, 0.5, 0.25, 2.0]));
    let forgetting = opaque(Forgetting { lambda: 0.999, floor: 10.0 });
    Triangle::update_forgetting(&mut triangle, &opaque([1.0, 0.5, 0.25, 2.0]), forgetting);
    opaque((Triangle::columns(&triangle), Triangle::is_finite(&triangle), Triangle::parts(&triangle)));
    opaque(Triangle::parts_mut(&mut triangle));
    Triangle::reset(&mut triangle);
}
