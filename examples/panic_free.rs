//! Links only if no public function of the core can panic: the panic handler is `panic-never`, which has no body, so a
//! panic that can be reached is an undefined symbol. Every function is called by its full name with operands that the
//! compiler can't see through; `cargo xtask test` finds those that are forgotten here.
//!
//! Left out: `Debug` and, with the feature `defmt`, the logger. Without optimisation nothing can be told.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[allow(dead_code, reason = "its detector is spelt out here")]
#[path = "support/standard_rig/model.rs"]
mod model;
#[allow(dead_code, reason = "only arrays of numbers are wanted here")]
#[path = "support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "support/refined.rs"]
mod refined;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "support/shaft.rs"]
mod shaft;

use core::fmt::{self, Write};
use core::hint::black_box as opaque;

use bearing_watch::decide::{Discriminant, Features, Kind, Novelty, Projection};
use bearing_watch::estimate::{
    Accumulator, AnyShape, Fading, Forgetting, Memory, Method, Nominal, OrderTracking, Row, Rows, Shape, Solver,
    StateVariable, TrackedOrder, Triangle, TwoLevel, Watch, is_stable,
};
use bearing_watch::model::notes;
use bearing_watch::*;

use model::MODEL;
use numbers::Numbers;

fn run() {
    front_end();
    decimation();
    order_and_regression();
    macro_rules! sizes { ($($m:literal)+) => { $(triangle::<$m, { $m * ($m - 1) / 2 }>();)+ }; }
    sizes!(2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21);
    estimators();
    decision();
    names_and_bytes();
    detectors();
    watched();
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
    let mut chain = opaque(HalfBandDecimator::<2, 2, 4, 13>::new());
    for _ in 0..opaque(300) {
        opaque(HalfBandDecimator::push(&mut chain, opaque(&HalfBandTaps::SHARP), opaque(numbers.array())));
    }
    HalfBandDecimator::reset(opaque(&mut chain));
}

fn order_and_regression() {
    let [na, nb, nc, nkb, nkc] = opaque([2, 1, 2, 1, 2]);
    let order = Order::from_array(Order::to_array(opaque(Order::new(na, nb, nc, nkb, nkc))));
    opaque([Order::parameters(order), Order::columns(order, opaque(true)), Order::depth(order)]);
    opaque(Order::largest_delay(order));
    let guard = Guard::within(opaque([4.0; 3]));
    let plain = Regression::<7>::new(order, opaque(true));
    let regression = opaque(Regression { guard, ..plain });
    opaque((
        Regression::columns(&regression),
        Regression::capacity(&regression),
        Regression::parameters(&regression),
        Regression::form(&regression),
    ));
    opaque((Regression::target_scale(&regression), Regression::differences_share_scales(&regression)));
    opaque(Regression::accepts(&regression, &opaque(Sample { y: 0.5, u1: -0.25, u2: 0.75 })));
    for poles in 0..opaque(6) {
        opaque(is_stable(opaque(&[-0.1, 0.5, 0.1, 0.0, 0.0]).get(..poles).unwrap_or_default()));
    }
}

fn triangle<const M: usize, const P: usize>() {
    let mut numbers = Numbers(3);
    let mut triangle = opaque(Triangle::<M, P>::new(opaque(M)));
    Triangle::update(&mut triangle, &opaque(numbers.array()));
    let forgetting = opaque(Forgetting { lambda: 0.98, floor: 0.5 });
    Triangle::update_forgetting(&mut triangle, &opaque(numbers.array()), opaque(0.5), forgetting);
    opaque((Triangle::solve(&triangle), Triangle::inverse(&triangle), Triangle::residual_sum(&triangle)));
    Triangle::update_weighted(&mut triangle, &opaque(numbers.array()), opaque(0.5));
    opaque((Triangle::dependent_column(&triangle), Triangle::columns(&triangle)));
    Triangle::reset(opaque(&mut triangle));
}

/// Both sources of rows, of a form known when running and when compiling, and every memory.
fn estimators() {
    let fading = Memory::Fading(Forgetting { lambda: 0.99, floor: 1.0 });
    let guard = Guard { stuck_samples: [9; 3], huber: 3.0, ..Guard::within([4.0; 3]) };
    let least = Regression { guard, ..MODEL.regression };
    estimator::<6, 15, 1, Regressor<6, 1>, Triangle<6, 15>>(&least);
    estimator::<6, 15, 1, Regressor<6, 1, model::Structure>, TwoLevel<6, 15>>(&least);
    estimator::<6, 15, 1, Regressor<6, 1>, Fading<6, 15>>(&Regression { memory: fading, still: 0.01, ..least });
    let instruments = refined::MODEL.regression;
    estimator::<11, 55, 1, Instruments<11, 1, refined::Structure>, Triangle<11, 55>>(&instruments);
    estimator::<11, 55, 1, Instruments<11, 1>, TwoLevel<11, 55>>(&instruments);
    estimator::<11, 55, 1, Instruments<11, 1>, Fading<11, 55>>(&Regression {
        memory: fading,
        still: 0.01,
        ..instruments
    });
    let nominal = Nominal { delta: [-0.1; 21], deviation: 0.1 };
    let any = Regression { nominal, method: Method::Instruments, ..Regression::new(Order::new(4, 4, 3, 7, 3), true) };
    estimator::<21, 210, 7, Instruments<21, 7>, Triangle<21, 210>>(&any);
}

fn estimator<const M: usize, const P: usize, const L: usize, R: Rows<M>, A: Accumulator<M, P>>(
    regression: &Regression<M>,
) {
    let regression = opaque(regression);
    opaque((<AnyShape as Shape>::fits(regression), <R::Shape as Shape>::of(regression)));
    opaque(Estimator::<M, P, L, R, A>::fits(regression));
    let mut estimator = opaque(Estimator::<M, P, L, R, A>::new(regression));
    let mut numbers = Numbers(5);
    let mut feed = |estimator: &mut Estimator<'_, M, P, L, R, A>| {
        for _ in 0..opaque(50) {
            let [y, u1, u2] = opaque(numbers.array());
            let sample = Sample { y, u1, u2 };
            Estimator::step(estimator, &sample);
            if Estimator::admit(estimator, &sample) {
                Estimator::take(estimator, &sample);
            } else {
                Estimator::skip(estimator);
            }
        }
    };
    feed(&mut estimator);
    told(Estimator::estimate(opaque(&estimator)));
    told(Estimator::close(opaque(&mut estimator)));
    opaque((Estimator::rows(&estimator), Estimator::counts(&estimator), Estimator::empty_estimate(&estimator)));
    feed(&mut estimator);
    let segment = opaque(Estimator::detach(&mut estimator));
    opaque((Segment::rows(&segment), Segment::counts(&segment)));
    let mut solver = opaque(Solver::new(regression, segment));
    opaque(Solver::segment(&solver).rows());
    // Once more than there are pieces.
    for _ in 0..opaque(M + 4) {
        if let Some(result) = opaque(Solver::advance(opaque(&mut solver))) {
            told(result);
        }
    }
    if let Ok(estimate) = Solver::finish(opaque(solver)) {
        opaque(Estimator::adopt(&mut estimator, &estimate));
    }
    Estimator::restart(opaque(&mut estimator));
    parts::<M, P, R, A>(regression);
}

/// What an estimator is made of.
fn parts<const M: usize, const P: usize, R: Rows<M>, A: Accumulator<M, P>>(regression: &Regression<M>) {
    opaque((<R as Rows<M>>::fits(regression), <A as Accumulator<M, P>>::fits(regression)));
    let mut source = opaque(<R as Rows<M>>::new(regression));
    let mut numbers = Numbers(6);
    for _ in 0..opaque(50) {
        let [y, u1, u2] = opaque(numbers.array());
        opaque(<R as Rows<M>>::push(&mut source, regression, &Sample { y, u1, u2 }));
    }
    let estimate = opaque(Estimate::<M, P>::empty(opaque(regression.order), opaque(true), 1, Counts::default()));
    <R as Rows<M>>::adopt(&mut source, regression, &estimate);
    <R as Rows<M>>::next_segment(opaque(&mut source), regression);
    opaque((<R as Rows<M>>::awaits(&source), <R as Rows<M>>::refused(&source), <R as Rows<M>>::gain(&source)));
    opaque((<R as Rows<M>>::origin(&source), <R as Rows<M>>::base(&source, regression)));
    <R as Rows<M>>::flush(opaque(&mut source), regression);

    let mut sums = opaque(<A as Accumulator<M, P>>::new(opaque(M)));
    let row = opaque(Row { cells: numbers.array(), weight: 0.5, motion: 1.0 });
    opaque(<A as Accumulator<M, P>>::add(&mut sums, regression, &row));
    opaque(<A as Accumulator<M, P>>::mass(&sums, regression, opaque(7)));
    opaque(<A as Accumulator<M, P>>::total(&sums, Triangle::residual_sum));
    <A as Accumulator<M, P>>::next_segment(opaque(&mut sums));
    <A as Accumulator<M, P>>::restart(opaque(&mut sums));
}

fn told<const M: usize, const P: usize>(result: Result<Estimate<M, P>, Reason>) {
    match opaque(result) {
        Ok(estimate) => {
            opaque((Estimate::parameters(&estimate), Estimate::raw(&estimate)));
            opaque(Estimate::covariance_matrix(&estimate));
            let _tried =
                opaque(Classifier::classify(opaque(&MODEL.classifier), &estimate, opaque(None::<&ShaftEstimate<0>>)));
        }
        Err(reason) => show(reason),
    }
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
    let estimate = Estimate::<6, 15>::empty(opaque(MODEL.regression.order), false, 0, Counts::default());
    let features =
        Features::extract(&features, &opaque(estimate), opaque(None::<&ShaftEstimate<0>>)).unwrap_or([0.0; 9]);
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
            reject_cost: 0.5,
        });
        opaque(Discriminant::decide(&discriminant, &opaque(z)));
        let likelihoods = Discriminant::log_likelihoods(&discriminant, &opaque(z));
        if let Some(decision) = Discriminant::decide_from(&discriminant, opaque(likelihoods)) {
            opaque(Decision::least_cost(&opaque(decision)));
        }
        watch(discriminant, &z);
    }
}

/// How far from healthy, and what many segments come to.
fn watch(discriminant: Discriminant<3, 4>, z: &[f32; 3]) {
    let mut numbers = Numbers(8);
    let novelty = opaque(Novelty::<3> {
        class: 0,
        mean: numbers.array(),
        whitening: core::array::from_fn(|_| numbers.array()),
        knots: core::array::from_fn(|_| numbers.array()),
        limit: 4.6,
    });
    opaque((Novelty::judge(&novelty, opaque(z)), Novelty::surprise(&novelty, opaque(3.0))));
    let features = Features::<9> { index: [8; 9], count: 9 };
    let projection = Projection::<9, 3> { matrix: [[1.0; 9]; 3], mean: [0.0; 9], count: 3 };
    let classifier = opaque(Classifier { features, projection, discriminant, novelty });
    let plan = opaque(EvidencePlan { bet: 0.2, limit: 10.0, cap: 5.0 });
    let mut evidence = opaque(Evidence::new(plan, &classifier));
    for _ in 0..opaque(9) {
        let decision = opaque(Classifier::decide(&classifier, opaque(z)));
        if let Some(decision) = &decision {
            opaque(Classifier::finding(&classifier, decision));
        }
        opaque(Evidence::observe(&mut evidence, decision.as_ref()));
    }
    opaque((Evidence::alarm(&evidence), Evidence::score(&evidence), Evidence::segments(&evidence)));
    opaque(Evidence::trend(&evidence));
    Evidence::reset(opaque(&mut evidence));
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

/// Whole detectors, of least squares and of instrumental variables.
fn detectors() {
    detector::<6, 15, 1, 5, 5, 3, Regressor<6, 1, model::Structure>, Triangle<6, 15>>(&MODEL);
    detector::<11, 55, 1, 9, 3, 3, Instruments<11, 1, refined::Structure>, Triangle<11, 55>>(&refined::MODEL);
    detector::<11, 55, 1, 9, 3, 3, Instruments<11, 1>, TwoLevel<11, 55>>(&refined::MODEL);
}

fn detector<
    const M: usize,
    const P: usize,
    const L: usize,
    const F: usize,
    const Z: usize,
    const C: usize,
    R: Rows<M>,
    A: Accumulator<M, P>,
>(
    model: &Model<M, F, Z, C>,
) {
    let model = opaque(model);
    let mut detector = match Detector::<M, P, L, F, Z, C, R, A>::new(model) {
        Ok(detector) => opaque(detector),
        Err(error) => return show(error),
    };
    let mut numbers = Numbers(9);
    for _ in 0..opaque(50) {
        let [y, u1, u2] = opaque(numbers.array());
        if let Some(report) = Detector::step(&mut detector, Sample { y, u1, u2 })
            && let Verdict::Undetermined(reason) = opaque(report).verdict
        {
            show(reason);
        }
        if let Some(segment) = opaque(Detector::collect(&mut detector, Sample { y, u1, u2 })) {
            let report = Model::conclude(model, opaque(segment));
            opaque(Detector::adopt(&mut detector, &report));
            opaque(Model::report(model, opaque(3), report.estimate.counts, Ok(report.estimate)));
        }
    }
    opaque((Detector::pending(&detector), Detector::preview(&detector)));
    opaque(Detector::finish(&mut detector));
    Detector::restart(opaque(&mut detector));
}

/// The shaft's side, alone and beside the regression.
fn watched() {
    let bearing = opaque(Bearing { balls: 9, ball_diameter: 3.0, pitch_diameter: 17.0, contact_angle_rad: 0.1745 });
    opaque([Bearing::outer(&bearing), Bearing::inner(&bearing), Bearing::ball(&bearing), Bearing::cage(&bearing)]);
    opaque(StateVariable::new(opaque(0.05), opaque(0.002)));
    opaque(TrackedOrder::order(&opaque(TrackedOrder::new(opaque(3.7), opaque([1.0; 3])))));

    let model = opaque(shaft::model::<4>(opaque(3), opaque(7)));
    let mut numbers = Numbers(10);
    let mut track = opaque(OrderTracking::<4>::new());
    for _ in 0..opaque(50) {
        OrderTracking::step(&mut track, &model.tracking, opaque(1 << 24), opaque(Some(numbers.next())));
    }
    opaque(OrderTracking::samples(&track));
    if let Err(reason) = opaque(OrderTracking::strengths(&track, &model.tracking)) {
        show(reason);
    }
    OrderTracking::next_segment(opaque(&mut track));

    watch_over::<NoShaft, 4>(None, &mut numbers);
    watch_over::<Shaft<4>, 4>(Some(&model), &mut numbers);

    let Model { sampling, regression, classifier, evidence, labels, .. } = MODEL;
    let features = opaque(Features::<5> { index: [0, 129, 137, 160, 192], count: 5 });
    let classifier = Classifier { features, ..classifier };
    let whole = opaque(Model { sampling, regression, shaft: Some(model), classifier, evidence, labels });
    let mut buffer = [0_u8; 1024];
    match Model::to_bytes(&whole, opaque(""), opaque(&mut buffer)) {
        Ok(length) => match Model::<6, 5, 5, 3, 4>::from_bytes(opaque(&buffer).get(..length).unwrap_or_default()) {
            Ok(model) => beside(opaque(&model)),
            Err(error) => show(error),
        },
        Err(error) => show(error),
    }
}

fn motion(numbers: &mut Numbers) -> Motion {
    let [current_a, velocity_rad_s, reference_rad_s, load_nm] = opaque(numbers.array());
    Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle: Angle::from_bits(opaque(12_345)) }
}

fn watch_over<W: Watch<K>, const K: usize>(model: Option<&ShaftModel<K>>, numbers: &mut Numbers) {
    let model = opaque(model);
    opaque(<W as Watch<K>>::fits(model));
    let mut watch = opaque(<W as Watch<K>>::new(model));
    for _ in 0..opaque(300) {
        <W as Watch<K>>::step(&mut watch, model, &motion(numbers));
    }
    if let Some((model, sums)) = model.zip(opaque(<W as Watch<K>>::sums(&watch))) {
        let estimate = ShaftModel::conclude(model, &sums);
        opaque([Friction::torque_constant_nm_a(&estimate.friction), Friction::inertia_kg_m2(&estimate.friction)]);
        opaque([Friction::viscous_nm_s_rad(&estimate.friction), Friction::coulomb_nm(&estimate.friction)]);
        opaque(ShaftEstimate::<K>::empty(opaque(estimate.reason).unwrap_or(Reason::AtRest)));
    }
    <W as Watch<K>>::next_segment(opaque(&mut watch));
}

fn beside(model: &Model<6, 5, 5, 3, 4>) {
    type Watching<'m> = Detector<'m, 6, 15, 1, 5, 5, 3, Regressor<6, 1>, Triangle<6, 15>, Shaft<4>, 4>;
    let mut detector = match Watching::new(model) {
        Ok(detector) => opaque(detector),
        Err(error) => return show(error),
    };
    let mut numbers = Numbers(11);
    for _ in 0..opaque(300) {
        let motion = motion(&mut numbers);
        let sample = Sample { y: motion.current_a, u1: motion.reference_rad_s, u2: motion.load_nm };
        opaque(Detector::step_with_motion(&mut detector, sample, &motion));
        if let Some((segment, sums)) = opaque(Detector::collect_with_motion(&mut detector, sample, &motion)) {
            let report = opaque(Model::conclude_with_shaft(model, segment, sums));
            opaque(Detector::adopt(&mut detector, &report));
        }
    }
    opaque(Detector::finish(&mut detector));
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
