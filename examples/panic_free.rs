//! Links only if no public function of the core can panic: the panic handler is `panic-never`, which has no body, so a
//! panic that can be reached is an undefined symbol. Every function is called by its full name with operands that the
//! compiler can't see through; `cargo xtask test` finds those that are forgotten here.
//!
//! Left out: `Debug` and, with the feature `defmt`, the logger. Without optimisation nothing can be told.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[path = "support/standard_rig/model.rs"]
mod model;
#[allow(dead_code, reason = "only arrays of numbers are wanted here")]
#[path = "support/numbers.rs"]
mod numbers;

use core::fmt::{self, Write};
use core::hint::black_box as opaque;

use bearing_watch::decide::{Discriminant, Features, Kind, Projection};
use bearing_watch::estimate::{Forgetting, Regressor, Triangle};
use bearing_watch::model::notes;
use bearing_watch::*;

use model::{MODEL, Monitor};
use numbers::Numbers;

fn run() {
    front_end();
    decimation();
    order_and_regressor();
    macro_rules! sizes { ($($m:literal)+) => { $(triangle::<$m, { $m * ($m - 1) / 2 }>();)+ }; }
    sizes!(2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21);
    estimator();
    decision();
    names_and_bytes();
    detector();
}

fn front_end() {
    let angle = Angle::from_bits(opaque(0x2345_6789));
    let other = Angle::from_counts(opaque(1234), opaque(14));
    opaque(Angle::from_radians(opaque(1.5)));
    opaque(Angle::bits(Angle::negated(opaque(angle))));
    opaque(Angle::radians(Angle::plus(Angle::times(opaque(angle), opaque(6)), opaque(other))));
    opaque(Angle::since(opaque(angle), opaque(other)));
    let electrical = opaque(Angle::sin_cos(opaque(angle)));

    let stator = AlphaBeta::from_two(opaque(1.5), opaque(-0.25));
    for park in opaque([Park::Standard, Park::Thesis]) {
        let rotor = Park::forward(park, opaque(stator), electrical);
        let back = Park::inverse(park, opaque(rotor), electrical);
        opaque(Abc::clarke(AlphaBeta::inverse_clarke(opaque(back))));
        let front = FrontEnd { pole_pairs: opaque(6), electrical_offset: opaque(other), park };
        opaque(FrontEnd::transform(&front, opaque(stator), opaque(angle)));
    }
}

fn decimation() {
    let mut numbers = Numbers(1);
    let mut mean = opaque(BlockMean::<3>::new());
    opaque(BlockMean::push(&mut mean, opaque(numbers.array()), opaque(7)));
    BlockMean::reset(opaque(&mut mean));
    let mut fir = opaque(FirDecimator::<2, 9, 4, 3>::new());
    for _ in 0..opaque(10) {
        opaque(FirDecimator::push(&mut fir, &opaque(numbers.array()), opaque(numbers.array())));
    }
    FirDecimator::reset(opaque(&mut fir));
}

fn order_and_regressor() {
    let [na, nb, nc, nkb, nkc] = opaque([2, 1, 2, 1, 2]);
    let order = Order::from_array(Order::to_array(opaque(Order::new(na, nb, nc, nkb, nkc))));
    opaque([Order::parameters(order), Order::columns(order, opaque(true)), Order::depth(order)]);
    opaque(Order::largest_delay(order));

    let regression = opaque(Regression::<7> { order, offset: opaque(true), scale: [1.0; 7], limit: [4.0; 3] });
    opaque((Regression::columns(&regression), Regression::target_scale(&regression)));
    opaque(Regression::differences_share_scales(&regression));
    let sample = opaque(Sample { y: 0.5, u1: -0.25, u2: 0.75 });
    opaque(Regression::accepts(&regression, &sample));
    let mut regressor = opaque(Regressor::<7, 4>::new(&regression));
    Regressor::recentre(&mut regressor, &sample);
    opaque(Regressor::origin(&regressor));
    for _ in 0..opaque(5) {
        opaque(Regressor::push(&mut regressor, &regression, &sample));
    }
    Regressor::flush(opaque(&mut regressor));
}

fn triangle<const M: usize, const P: usize>() {
    let mut numbers = Numbers(3);
    let mut triangle = opaque(Triangle::<M, P>::new(opaque(M)));
    Triangle::update(&mut triangle, &opaque(numbers.array()));
    let forgetting = opaque(Forgetting { lambda: 0.98, floor: 0.5 });
    Triangle::update_forgetting(&mut triangle, &opaque(numbers.array()), forgetting);
    opaque((Triangle::solve(&triangle), Triangle::inverse(&triangle), Triangle::residual_sum(&triangle)));
    opaque(Triangle::dependent_column(&triangle));
    Triangle::reset(opaque(&mut triangle));
}

fn estimator() {
    let mut numbers = Numbers(5);
    let mut estimator = opaque(Estimator::<6, 15, 4>::new(opaque(&MODEL.regression)));
    for _ in 0..opaque(50) {
        let [y, u1, u2] = opaque(numbers.array());
        Estimator::step(&mut estimator, &Sample { y, u1, u2 });
    }
    match Estimator::estimate(opaque(&estimator)) {
        Ok(estimate) => {
            opaque((Estimate::parameters(&estimate), Estimate::raw(&estimate)));
            opaque(Estimate::covariance_matrix(&estimate));
            let _tried = opaque(Classifier::classify(opaque(&MODEL.classifier), &estimate));
        }
        Err(reason) => show(reason),
    }
    opaque(Estimator::empty_estimate(&estimator));
    Estimator::next_segment(opaque(&mut estimator));
    Estimator::restart(opaque(&mut estimator));
}

fn decision() {
    let mut numbers = Numbers(7);
    let projection = opaque(Projection::<9, 3> {
        matrix: core::array::from_fn(|_| numbers.array()),
        mean: numbers.array(),
        count: 3,
    });
    opaque(Projection::to_matrices(&projection));
    let features = opaque(Features::<9> { index: [8; 9], count: 9 });
    let estimator = opaque(Estimator::<6, 15, 4>::new(opaque(&MODEL.regression)));
    let features = Features::extract(&features, &opaque(Estimator::empty_estimate(&estimator)));
    let z = Projection::project(&projection, &opaque(features));
    for kind in [Kind::Linear, Kind::Quadratic] {
        let discriminant = opaque(Discriminant::<3, 4> {
            kind,
            classes: 3,
            mean: core::array::from_fn(|_| numbers.array()),
            whitening: core::array::from_fn(|_| core::array::from_fn(|_| numbers.array())),
            log_normaliser: numbers.array(),
            log_prior: numbers.array(),
            cost: [[1.0; 4]; 4],
        });
        opaque(Discriminant::decide(&discriminant, &opaque(z)));
        let likelihoods = Discriminant::log_likelihoods(&discriminant, &opaque(z));
        opaque(Discriminant::decide_from(&discriminant, opaque(likelihoods)));
    }
}

fn names_and_bytes() {
    if let Some(label) = opaque(Label::new(opaque("healthy"))) {
        opaque(Label::as_str(&label));
        opaque(Label::from_bytes(opaque(Label::to_bytes(label))));
    }
    opaque(Model::label(opaque(&MODEL), opaque(200)));
    let mut buffer = [0_u8; 1024];
    let written = match Model::to_bytes(opaque(&MODEL), opaque("notes"), opaque(&mut buffer)) {
        Ok(length) => opaque(length),
        Err(error) => return show(error),
    };
    let bytes = opaque(&buffer).get(..written).unwrap_or_default();
    if let Err(error) = opaque(notes(bytes)) {
        show(error);
    }
    match Model::<8, 6, 5, 4>::from_bytes(bytes) {
        Ok(model) => opaque(Model::validate(opaque(&model))).unwrap_or_else(show),
        Err(error) => show(error),
    }
}

fn detector() {
    let mut numbers = Numbers(9);
    let created: Result<Monitor, ModelError> = Detector::new(opaque(&MODEL));
    let mut monitor = match created {
        Ok(monitor) => opaque(monitor),
        Err(error) => return show(error),
    };
    for _ in 0..opaque(50) {
        let [y, u1, u2] = opaque(numbers.array());
        if let Some(report) = Detector::step(&mut monitor, Sample { y, u1, u2 })
            && let Verdict::Undetermined(reason) = opaque(report).verdict
        {
            show(reason);
        }
    }
    opaque((Detector::pending(&monitor), Detector::preview(&monitor)));
    opaque(Detector::finish(&mut monitor));
    Detector::restart(opaque(&mut monitor));
}

/// The errors' texts.
fn show(error: impl fmt::Display) {
    struct Sink;
    impl Write for Sink {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            opaque(text);
            Ok(())
        }
    }
    let _full = opaque(write!(Sink, "{}", opaque(error)));
}

#[cfg(not(target_os = "none"))]
fn main() {
    run();
}

#[cfg(target_os = "none")]
mod target {
    use cortex_m_semihosting::debug;
    #[cfg(feature = "defmt")]
    use defmt_semihosting as _;
    #[cfg(not(any(debug_assertions, feature = "defmt")))]
    use panic_never as _;

    #[cfg(any(debug_assertions, feature = "defmt"))]
    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        debug::exit(debug::EXIT_FAILURE);
        halt()
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        super::run();
        debug::exit(debug::EXIT_SUCCESS);
        halt()
    }

    fn halt() -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }
}
