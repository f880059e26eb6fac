//! Links only if no public function of the core can panic: the panic handler is `panic-never`, which has no body, so a
//! panic that can be reached is an undefined symbol. Every function is called by its full name with operands that the
//! compiler can't see through; `cargo xtask test` finds those that are forgotten here.
//!
//! Left out: `Debug` and, with the feature `defmt`, the logger. Without optimisation nothing can be told.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[path = "../../examples/support/classifier.rs"]
mod classifier;
#[path = "support/converter.rs"]
mod converter;
#[path = "support/drive_calls.rs"]
mod drive_calls;
#[path = "../../examples/support/flash.rs"]
mod flash;
#[path = "support/law.rs"]
mod law;
#[allow(dead_code, reason = "its samples are not wanted here")]
#[path = "../../examples/support/standard_rig/model.rs"]
mod model;
#[path = "support/monitor_calls.rs"]
mod monitor_calls;
#[allow(dead_code, reason = "only arrays of numbers are wanted here")]
#[path = "../../examples/support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "no bits are wanted here")]
#[path = "support/raw.rs"]
mod raw;
#[path = "support/recursive_calls.rs"]
mod recursive_calls;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "../../examples/support/refined.rs"]
mod refined;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "support/shaft.rs"]
mod shaft;
#[path = "support/stored_calls.rs"]
mod stored_calls;
#[path = "support/telemetry_calls.rs"]
mod telemetry_calls;
#[path = "support/watch_calls.rs"]
mod watch_calls;

use core::fmt::{self, Write};
use core::hint::black_box as opaque;

use bearing_watch::alarm::*;
use bearing_watch::drive::*;
use bearing_watch::model::*;
use bearing_watch::plan::*;
use bearing_watch::shaft::*;
use bearing_watch::*;

use classifier::classifier;
use numbers::Numbers;

fn run() {
    for kernel in [known_answer_test().err(), arithmetic_test().err()].into_iter().flatten() {
        opaque(ArithmeticFault::message(kernel));
        show(kernel);
    }
    front_end();
    drive_calls::front_end(|error| show(error));
    decimation();
    converter::run(|error| show(error));
    stored_calls::storage(|error| show(error));
    stored_calls::signatures(|error| show(error));
    watch_calls::run(|error| show(error));
    plans();
    constants();
    detector(&model::MODEL, |[current_a, velocity_ref_rad_s, load_torque_nm, ..]| model::Sample {
        current_a,
        velocity_ref_rad_s,
        load_torque_nm,
    });
    detector(&refined::MODEL, |[y, u1, u2, _]| refined::Sample { y, u1, u2 });
    detector(&shaft::MODEL, |values| motion(values).into());
    detector(&shaft::LOADLESS, |values| motion(values).into());
    detector(&shaft::WEIGHING, |values| motion(values).into());
    fading();
    largest();
}

fn front_end() {
    let angle = Angle::from_bits(opaque(0x2345_6789));
    let other = Angle::from_counts(opaque(1234), opaque(14));
    opaque(Angle::from_radians(opaque(1.5)));
    opaque(Angle::bits(Angle::negated(opaque(angle))));
    opaque(Angle::radians(Angle::plus(Angle::times(opaque(angle), opaque(6)), opaque(other))));
    opaque(Angle::since(opaque(angle), opaque(other)));
    if let Some(turn) = EncoderCounts::new(opaque(8000)) {
        let mut counter = opaque(TurnCounter::new(turn));
        counter = opaque(TurnCounter::after(turn, 5, TurnCounter::within(&mut counter, opaque(7))));
        opaque(EncoderCounts::angle(turn, TurnCounter::within(&mut counter, opaque(-5))));
    }
    let electrical = opaque(Angle::sin_cos(opaque(angle)));

    let stator = AlphaBeta::from_two(opaque(1.5), opaque(-0.25));
    for park in opaque([Park::Standard, Park::Thesis]) {
        let rotor = Park::forward(park, opaque(stator), electrical);
        let back = Park::inverse(park, opaque(rotor), electrical);
        opaque(Abc::clarke(AlphaBeta::inverse_clarke(opaque(back))));
        let frame = RotorFrame { pole_pairs: opaque(6), electrical_offset: opaque(other), park };
        opaque(RotorFrame::transform(&frame, opaque(stator), opaque(angle)));
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

bearing_watch::plan! {
    /// A plan with covariates.
    struct Explaining;
    struct ExplainingSample { current_a: "A", temperature_c: "°C" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(1, 0, 0, 0, 0),
            method: Method::LeastSquares,
            memory: Memory::Segment,
            y: current_a,
            u1: current_a,
            u2: current_a,
        }),
        averaged: temperature_c.mask(),
        features: 1,
        covariates: 2,
        coordinates: 1,
        classes: 1,
        ..Layout::EMPTY
    }
}

/// What is usually done at compile time.
fn plans() {
    let [na, nb, nc, nkb, nkc] = opaque([2, 1, 2, 1, 2]);
    let structure = opaque(Structure::with_offset(Structure::new(na, nb, nc, nkb, nkc)));
    opaque([Structure::terms(structure), Structure::parameters(structure), Structure::depth(structure)]);
    opaque(Structure::from_orders(Structure::orders(structure)));
    let signal = opaque(Signal::minus(Signal::channel(opaque(0)), Signal::channel(opaque(1))));
    let regression = RegressionLayout { y: signal, structure, ..largest_layout() };
    opaque(RegressionLayout::columns(&regression));
    let layout = opaque(Layout { regression: Some(regression), ..Layout::EMPTY });
    if let Err(error) = Layout::check(&layout) {
        opaque(LayoutError::message(error));
        show(error);
    }
    opaque([Layout::regressed(&layout), Layout::squares(&layout), Layout::instruments(&layout)]);
    opaque([Layout::columns(&layout), Layout::packed(&layout)]);
    opaque(Layout::moments(&layout));
    opaque([Layout::parameters(&layout), Layout::covariance(&layout), Layout::delays(&layout)]);
    opaque([Layout::filters(&layout), Layout::watched(&layout), Layout::orders(&layout), Layout::map(&layout)]);
    opaque([Layout::density(&layout), Layout::densities(&layout), Layout::means(&layout), Layout::costs(&layout)]);
    opaque((
        Layout::averages(&layout),
        Layout::covariate_map_len(&layout),
        Layout::laws(&layout),
        Signal::mask(signal),
        Load::measured(Load::of(opaque(Some(signal)))),
    ));
    let covariate = opaque(Covariate::BLANK);
    let departures = opaque([Covariate::departure(&covariate, opaque(FeatureValue::MISSING)); 2]);
    let covariates = opaque(Covariates::<Explaining> { list: [covariate; 2], map: [[0.5, 0.25]; 2] });
    opaque(Covariates::corrected(&covariates, opaque(FeatureValue::MISSING), opaque(0), &departures));
    opaque((Layout::needs_angle(&layout), Feature::exists(opaque(Feature::Parameter(3)), &layout)));
    sizes(<Fixed<3> as Size>::map(&opaque([1.0; 2 + 1]), |x| 2.0 * x));
    let part = <Present<1> as Presence>::part(true, || opaque(1.0));
    sizes(<Present<1> as Presence>::map_part(&part, |x| 2.0 * x));
}

fn sizes<A: Cells<f32>>(mut cells: A) {
    opaque((Cells::part(&cells).copied(), Cells::cells(&cells).len()));
    if let Some(cell) = Cells::part_mut(&mut cells) {
        *cell = 1.0;
    }
    Cells::cells_mut(&mut cells).fill(opaque(2.0));
    opaque((<A as Cells<f32>>::filled(opaque(3), 1.0), <A as Cells<f32>>::from_fn(opaque(3), |k| k as f32)));
}

fn constants() {
    let channel = opaque(Channel::within(opaque("current_a"), opaque("A"), opaque(4.0)));
    opaque(Name::<16>::constant(opaque("spall")));
    if let Some(name) = opaque(Name::<16>::new(opaque("healthy"))) {
        opaque(Name::as_str(&name));
        opaque(Name::<16>::from_bytes(opaque(Name::to_bytes(name))));
    }
    opaque(channel);
    let bearing = opaque(Bearing { balls: 9, ball_diameter: 3.0, pitch_diameter: 17.0, contact_angle_rad: 0.1745 });
    opaque([Bearing::outer(&bearing), Bearing::inner(&bearing), Bearing::ball(&bearing), Bearing::cage(&bearing)]);
    opaque(StateVariable::new(opaque(0.05), opaque(0.002)));
    opaque(TrackedOrder::order(&opaque(TrackedOrder::new(opaque(3.7), opaque([1.0; 3])))));
    opaque((FrictionTerm::name(opaque(FrictionTerm::Drag)), FrictionTerm::needs_load(opaque(FrictionTerm::Drag))));
    opaque(q16(opaque(3.7)));
    opaque(Implausible::message(opaque(Implausible::LoadSign)));
    show(opaque(Implausible::Scale));
    opaque(Field::name(opaque(Field::SamplingInterval)));
    for error in opaque([ModelError::OtherPlan, ModelError::Channel { index: 1 }]) {
        opaque(ModelError::message(&error));
        show(error);
    }
}

fn motion([current_a, velocity_rad_s, reference_rad_s, load_nm]: [f32; 4]) -> shaft::Motion {
    shaft::Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle: Angle::from_bits(opaque(12_345)) }
}

/// A whole detector with all that belongs to it.
fn detector<P: Plan>(model: &Model<P>, sample: impl Fn([f32; 4]) -> P::Sample) {
    let model = opaque(model);
    about(model);
    let mut detector = opaque(Detector::new(model));
    let mut evidence = opaque(Evidence::new(model));
    let mut numbers = Numbers(9);
    for _ in 0..opaque(50) {
        let sample = opaque(sample(numbers.array()));
        opaque((Signals::value(&sample, opaque(1)), Signals::angle(&sample)));
        let sample: P::Sample = Signals::of(opaque(&numbers.array::<4>()), Angle::from_bits(opaque(9)));
        if let Some(report) = opaque(Detector::step(&mut detector, &sample)) {
            opaque(Evidence::observe(&mut evidence, report.decision.as_ref()));
            opaque(Evidence::observe_outcome(&mut evidence, Report::outcome(&report)));
            opaque(Evidence::end_run(&mut evidence));
            told(model, &report);
            saved(model, &mut evidence);
            telemetry_calls::encode(model, &report, &evidence, |error| show(error));
            telemetry_calls::on_can(model, &report, &evidence);
        }
        telemetry_calls::record(model, &sample, |error| show(error));
    }
    monitor_calls::exchange(model, || sample(numbers.array()));
    recursive_calls::run(model, || sample(numbers.array()));
    opaque((Detector::pending(&detector), Detector::counts(&detector), Detector::preview(&detector)));
    told(model, &opaque(Detector::finish(&mut detector)));
    Detector::discard(opaque(&mut detector));
    Detector::restart(opaque(&mut detector));
    opaque((Evidence::alarm(&evidence), Evidence::score(&evidence), Evidence::segments(&evidence)));
    opaque(Evidence::silence(&evidence));
    Evidence::limit_silence(&mut evidence, SilenceLimits { segments: opaque(3), hours: opaque(1.0) });
    opaque(Evidence::deny(&mut evidence));
    Evidence::reset(opaque(&mut evidence));
    monitor_calls::run(model, &mut detector, || sample(numbers.array()));
}

/// The state of the alarm as bytes.
fn saved<P: Plan>(model: &Model<P>, evidence: &mut Evidence<P>) {
    let mut buffer = opaque([0; 512]);
    opaque((Model::id(model), Evidence::saved_len(model)));
    let length = match Evidence::save(evidence, model, &mut buffer) {
        Ok(length) => opaque(length),
        Err(error) => return show(error),
    };
    let bytes = opaque(&buffer).get(..length).unwrap_or_default();
    if let Err(error) = Evidence::restore(evidence, model, bytes) {
        opaque(StateError::message(&error));
        show(error);
    }
}

/// What a model says of itself, and its bytes.
fn about<P: Plan>(model: &Model<P>) {
    let (plan, constants) = (Model::plan(model), Model::constants(model));
    let layout = opaque(plan.layout());
    opaque(<P as Plan>::of(layout).is_some());
    opaque((Model::label(model, opaque(200)), <P as Plan>::channels()));
    opaque(Model::verdict_name(model, opaque(Verdict::Novel)));
    if let Err(error) = Model::check_interval(model, opaque(0.001)) {
        show(error);
    }
    let frame = RotorFrame { pole_pairs: opaque(6), electrical_offset: Angle::ZERO, park: opaque(Park::Thesis) };
    if let Err(error) = Model::check_rotor_frame(model, &frame) {
        show(error);
    }
    if let Err(error) = opaque(Model::new(plan, opaque(constants.clone()))) {
        show(error);
    }
    opaque(Regression::new(plan));
    let mut buffer = [0_u8; 2048];
    let written = match Model::to_bytes(model, opaque("notes"), opaque(&mut buffer)) {
        Ok(length) => opaque(length),
        Err(error) => return show(error),
    };
    let bytes = opaque(&buffer).get(..written).unwrap_or_default();
    stored(bytes);
    opaque((Model::<P>::from_bytes(bytes).is_ok(), Model::<P>::from_sector(opaque(&buffer)).is_ok()));
    let classifier = &constants.classifier;
    let (numbers, features) = (opaque([0.5_f32; 9]), layout.features as usize);
    let values = opaque([FeatureValue { value: 0.5, variance: 0.1 }; 9]);
    opaque(FeatureValue::is_missing(opaque(FeatureValue::MISSING)));
    opaque(Projection::excess(&classifier.projection, opaque(FeatureValue::MISSING), opaque(0)));
    opaque(Projection::coordinate(&classifier.projection, values.get(..features).unwrap_or_default(), opaque(0)));
    let discriminant = &classifier.discriminant;
    opaque(Discriminant::log_likelihood(discriminant, opaque(Kind::Quadratic), &numbers, &numbers, opaque(1)));
    opaque((Novelty::none(plan), Novelty::judge(&classifier.novelty, &numbers, &numbers)));
    opaque(Novelty::surprise(&classifier.novelty, opaque(3.0)));
    opaque(Novelty::excludes(&classifier.novelty, opaque(1), opaque(3.0), opaque([1, 2])));
    let decisions = (
        Classifier::decide(classifier, plan, &numbers, 1.0),
        Classifier::decide_at(classifier, plan, &numbers, &numbers),
    );
    if let (Some(mut decision), Some(_)) = opaque(decisions) {
        opaque(Classifier::verdict(classifier, &decision));
        opaque(Discriminant::decide(&classifier.discriminant, &numbers, &mut decision));
    }
}

fn stored(bytes: &[u8]) {
    opaque((notes(bytes).is_ok(), stored_len(bytes).is_ok(), layout(bytes).is_ok()));
}

fn told<P: Plan>(model: &Model<P>, report: &Report<P>) {
    match opaque(report.verdict) {
        Verdict::Undetermined(reason) => show(reason),
        verdict => {
            opaque(verdict);
        }
    }
    opaque((ChannelSet::contains(report.counts.stuck, opaque(3)), ChannelSet::is_empty(report.counts.stuck)));
    let (estimate, shaft) = opaque((Report::estimate(report), Report::shaft(report)));
    let averages = opaque(Report::averages(report));
    for average in averages {
        opaque((Average::channel(average), Average::mean(average).ok(), Average::rms(average).ok()));
    }
    let feature = opaque(Feature::ChannelMean(3));
    let balance = Model::constants(model).shaft.cells().first().map(|own| &own.balance);
    if let Err(reason) = Feature::value(feature, Model::plan(model), (estimate, shaft.zip(balance), averages)) {
        show(reason);
    }
    if let Some(estimate) = estimate {
        opaque((Estimate::delta(estimate), Estimate::raw(estimate), Estimate::packed_covariance(estimate)));
        opaque((Estimate::covariance(estimate, opaque(1), opaque(0)), Estimate::deviation(estimate, opaque(9))));
    }
    if let Some(shaft) = shaft {
        let friction = &shaft.friction;
        opaque((Friction::parameter(friction, opaque(FrictionTerm::Offset)), ShaftEstimate::orders(shaft)));
        opaque([Friction::inertia_kg_m2(friction), Friction::viscous_nm_s_rad(friction)]);
        opaque((
            Friction::coulomb_nm(friction),
            Friction::torque_constant_nm_a(friction),
            Friction::weight_a(friction),
        ));
        if let Some(balance) = balance {
            opaque(TorqueBalance::without_prior(balance, friction, opaque(FrictionTerm::Drag)));
            opaque(TorqueBalance::part_of_rows(balance, friction, opaque(FrictionTerm::Drag)));
        }
    }
    opaque(Report::smallest(report));
    opaque(Projection::only(&Model::constants(model).classifier.projection, opaque(1)));
    let mut doubted = report.clone();
    Report::withdraw(opaque(&mut doubted));
    if let Some(decision) = &report.decision {
        opaque((Decision::log_likelihoods(decision), Decision::posteriors(decision)));
        opaque((Decision::expected_costs(decision), Decision::least_cost(decision)));
        opaque((Decision::missing(decision), Decision::missing_count(decision), Decision::outside(decision)));
        opaque((Decision::beyond(decision), Decision::directed(decision)));
        let mut combined = Decision::clone(decision);
        Decision::set_beyond(&mut combined, opaque(&[true, false]));
        Decision::set_directed(&mut combined, opaque(&[FeatureValue::MISSING]));
        opaque(combined);
    }
}

const fn largest_layout() -> RegressionLayout {
    RegressionLayout {
        structure: Structure::new(4, 4, 3, 7, 3).with_offset(),
        method: Method::Instruments,
        memory: Memory::Segment,
        y: Signal::channel(0),
        u1: Signal::channel(1),
        u2: Signal::channel(2),
    }
}

/// A detector of one more regression.
macro_rules! regression {
    ($name:ident $layout:expr) => {
        fn $name() {
            bearing_watch::plan! {
                struct Own;
                struct Sample { y: "A", u1: "rad/s", u2: "N·m" }
                layout: Layout {
                    regression: Some($layout),
                    features: 9,
                    coordinates: 3,
                    classes: 3,
                    discriminant: Kind::Quadratic,
                    ..Layout::EMPTY
                }
            }
            let constants = Constants {
                sampling: Sampling { interval_s: 0.001, park: None, block_mean: 3, segment_samples: opaque(40) },
                channels: refined::CHANNELS,
                regression: [Regression { rest: 0.01, ..Regression::new(Own) }],
                shaft: [],
                classifier: classifier!(refined::FEATURES),
                evidence: EvidenceConstants::NONE,
                labels: refined::LABELS,
            };
            if let Err(error) = Own::model(opaque(constants.clone())) {
                show(error);
            }
            match Model::new(Own, opaque(constants)) {
                Ok(model) => detector(&model, |[y, u1, u2, _]| Sample { y, u1, u2 }),
                Err(error) => show(error),
            }
        }
    };
}

regression!(fading RegressionLayout {
    structure: Structure::new(2, 3, 3, 1, 1),
    method: Method::LeastSquares,
    memory: Memory::Fading,
    ..largest_layout()
});
regression!(largest largest_layout());

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
