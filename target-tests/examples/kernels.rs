//! Hashes of every kernel's results: equal lines on host and target mean equal bits. Run by `cargo xtask test`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "support/streams.rs"]
mod streams;

use bearing_watch::drive::{AlphaBeta, BlockMean, RotorFrame};
use bearing_watch::model::{
    Channel, Classifier, Covariates, Discriminant, Feature, FeatureValue, Forgetting, Novelty, Projection, Regression,
};
use bearing_watch::plan::{Array, Cells, Fixed, Kind, Layout, Memory, Method, Plan, RegressionLayout, Structure};
use bearing_watch::recursive::{RecursiveEstimator, Triangle};
use bearing_watch::{Angle, Detector, Evidence, Model, Park};

use support::hash::Hash;
use support::numbers::Numbers;
use support::shaft::{self, Motion};
use support::{decimation, directed, raw, refined, squares};

type Three = Fixed<3>;
type Zero = Fixed<0>;
type Nine = Fixed<9>;
type TwentySeven = Fixed<27>;

bearing_watch::plan! {
    /// Five parameters and a constant, a linear discriminant.
    struct Six;
    /// Its sample.
    struct Sample { y: "A", u1: "rad/s", u2: "N·m" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(2, 1, 2, 1, 2).with_offset(),
            method: Method::LeastSquares,
            memory: Memory::Segment,
            y,
            u1,
            u2,
        }),
        features: 9,
        coordinates: 3,
        classes: 3,
        discriminant: Kind::Linear,
        ..Layout::EMPTY
    }
}

main!(run);

fn run() {
    say!("known answers {:?}", bearing_watch::known_answer_test());
    front_end();
    macro_rules! sizes { ($($m:literal)+) => { $(triangle::<$m, { $m * ($m - 1) / 2 }>();)+ }; }
    sizes!(2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21);
    estimator();
    streams::run(|number, outcomes| {
        let streams::Outcomes { plain, fading } = outcomes;
        let solved = [plain, fading].map(|outcome| outcome.solved);
        let (plain, fading) = (plain.bits, fading.bits);
        say!("stream {number} {plain:08x}, fading {fading:08x}, solved {solved:?}");
    });
    let mut hash = Hash::new();
    let mut numbers = Numbers(11);
    decisions(Six, &mut numbers, &mut hash);
    decisions(squares::Squares, &mut numbers, &mut hash);
    say!("decision {:08x}", hash.bits());
    runs();
    watched("4 orders", &shaft::MODEL);
    watched("1 order, no load", &shaft::LOADLESS);
    watched("1 order, a weight on an axis", &shaft::WEIGHING);
    let mut hash = Hash::new();
    decimation::bits(|output| hash.add(output));
    say!("decimation {:08x}", hash.bits());
    let mut hash = Hash::new();
    raw::bits(|output| hash.add(output));
    say!("raw samples {:08x}", hash.bits());
}

/// Evidence of runs of six segments in directions, of which all grow after forty runs.
fn runs() {
    let mut evidence = Evidence::new(&directed::MODEL);
    let (mut hash, mut numbers, mut growing) = (Hash::new(), Numbers(17), 0_u32);
    for run in 0..120_u8 {
        let size = 0.05 * f32::from(run.saturating_sub(40));
        for _ in 0..6 {
            let values = numbers.array().map(|value| value + size);
            evidence.observe(directed::decision(values).as_ref());
        }
        evidence.end_run();
        hash.add(&[evidence.score()]);
        for direction in 0..directed::DIRECTIONS as u8 {
            if let (Some(of), Some(growth)) = (evidence.contribution(direction), evidence.growth(direction)) {
                hash.add(&[of.deviations, of.score, f32::from_bits(of.since), growth.size.low, growth.slope.high]);
                let left = growth.left.map_or([0.0; 3], |left| [left.low, left.value, left.high]);
                hash.add(&left);
                growing += u32::from(growth.is_growing());
            }
        }
    }
    let raised = evidence.alarm().map_or(0, |alarm| alarm.segment);
    say!("evidence of runs {:08x}, alarm at segment {raised}, grows in {growing} of 600", hash.bits());
}

fn front_end() {
    let mut hash = Hash::new();
    let frame = RotorFrame { pole_pairs: 6, electrical_offset: Angle::from_bits(12_345), park: Park::Standard };
    let mut numbers = Numbers(1);
    let mut mean = BlockMean::new();
    for k in 0..20_000_u32 {
        let angle = Angle::from_bits(k.wrapping_mul(0x9E37_79B9));
        let sc = angle.sin_cos();
        let dq = frame.transform(AlphaBeta::from_two(numbers.draw(), numbers.draw()), angle);
        let back = Park::Thesis.inverse(dq, sc).inverse_clarke();
        hash.add(&[sc.sin, sc.cos, dq.d, dq.q, back.a, back.b, back.c, angle.radians()]);
        if let Some(mean) = mean.push([dq.d, dq.q], 7) {
            hash.add(&mean);
        }
    }
    say!("front end {:08x}", hash.bits());
}

fn triangle<const M: usize, const P: usize>() {
    let mut hash = Hash::new();
    let mut numbers = Numbers(3);
    let mut plain = Triangle::<[f32; M], [f32; P]>::new(M);
    let mut forgetting = plain.clone();
    for _ in 0..200 {
        let row: [f32; M] = numbers.array();
        plain.update(&row);
        forgetting.update_forgetting(&row, Forgetting { lambda: 0.98, floor: 0.5 });
    }
    for triangle in [&plain, &forgetting] {
        let (d, r) = triangle.parts();
        hash.add(d);
        hash.add(r);
    }
    say!("triangle {M:2} {:08x}", hash.bits());
}

fn estimator() {
    let regression = Regression { scale: [1.0, 4.0, 0.5, 1.0, 2.0, 1.0, 8.0], ..Regression::new(Six) };
    let channels = [("y", "A"), ("u1", "rad/s"), ("u2", "N·m")].map(|(name, unit)| Channel::within(name, unit, 4.0));
    let mut estimator = RecursiveEstimator::new(Six, &channels, &regression);
    let (mut numbers, mut y) = (Numbers(7), [0.0_f32; 2]);
    for k in 0..3000 {
        let [u1, u2, e] = numbers.array();
        let next = 1.5 * y[0] - 0.7 * y[1] + 0.5 * u1 - 0.25 * u2 + 0.1 * e + 0.02;
        y = [next, y[0]];
        let measured = if k % 701 == 700 { f32::NAN } else { next };
        estimator.step(&Sample { y: measured, u1, u2 });
    }
    let estimate = estimator.estimate();
    if let Some(reason) = estimate.reason {
        return say!("estimator: {reason}");
    }
    let mut hash = Hash::new();
    hash.add(estimate.delta());
    hash.add(&estimate.raw());
    hash.add(estimate.packed_covariance());
    hash.add(&[estimate.variance]);
    for feature in [Feature::Parameter(5), Feature::Parameter(0), Feature::LogVariance, Feature::Parameter(2)] {
        hash.add(&[feature.value(Six, (Some(&estimate), None, &[])).unwrap_or(FeatureValue::MISSING).value]);
    }
    say!("estimator {:08x}, {} rows, {} rejected", hash.bits(), estimate.rows, estimator.counts().rejected);
}

/// Whole segments of a detector that watches the shaft.
fn watched<P: Plan>(name: &str, model: &Model<P>)
where
    P::Sample: From<Motion>,
{
    let (mut hash, mut rows, mut rejected) = (Hash::new(), 0, 0);
    let mut plant = shaft::Plant::new(15);
    let mut detector = Detector::new(model);
    for _ in 0..3 {
        let report = loop {
            if let Some(report) = detector.step(&plant.motion().into()) {
                break report;
            }
        };
        report.estimate().into_iter().for_each(|estimate| hash.add_estimate(estimate));
        let Some(shaft) = report.shaft() else { return };
        if let Some(reason) = shaft.friction_reason.or(shaft.orders_reason) {
            say!("shaft: {reason}");
        }
        hash.add_shaft(shaft);
        report.decision.iter().for_each(|decision| hash.add(decision.log_likelihoods()));
        (rows, rejected) = (rows + shaft.friction.rows, rejected + report.counts.rejected);
    }
    say!("shaft of {name} {:08x}, {rows} rows, {rejected} rejected", hash.bits());
}

/// Decisions of random classifiers of nine features, three coordinates and three classes.
fn decisions<P>(plan: P, numbers: &mut Numbers, hash: &mut Hash)
where
    P: Plan<
            Features = Nine,
            Covariates = Zero,
            CovariateMap = Zero,
            Coordinates = Three,
            Map = TwentySeven,
            Classes = Three,
            Means = Nine,
            Costs = Nine,
        >,
{
    for _ in 0..100 {
        let projection = Projection::<P> { matrix: numbers.array(), mean: numbers.array(), usual: numbers.array() };
        let means = numbers.array();
        // Of each factor the pivots are the first, fourth and sixth number.
        let mut factors: Array<P::Densities, f32> = Cells::from_fn(plan.layout().densities(), |_| numbers.draw());
        for factor in factors.cells_mut().chunks_mut(6) {
            let cells = factor.iter_mut().enumerate();
            cells.filter(|(k, _)| [0, 3, 5].contains(k)).for_each(|(_, pivot)| *pivot += 1.5);
        }
        let discriminant = Discriminant {
            means,
            factors,
            log_prior: [-1.098_612_3; 3],
            costs: [0.0, 50.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0],
            reject_cost: f32::INFINITY,
        };
        let classifier = Classifier {
            features: refined::FEATURES,
            covariates: Covariates { list: [], map: [] },
            projection,
            discriminant,
            novelty: Novelty::none(plan),
        };
        let features: [f32; 9] = numbers.array();
        let errors: [f32; 9] = numbers.array();
        // A feature in four is missing.
        let variance = |error: f32| if error > 0.5 { f32::INFINITY } else { error.max(0.0) };
        let features: [FeatureValue; 9] = core::array::from_fn(|k| {
            let own = |values: &[f32; 9]| values.get(k).copied().unwrap_or(0.0);
            FeatureValue { value: own(&features), variance: variance(own(&errors)) }
        });
        let z = [0, 1, 2].map(|k| classifier.projection.coordinate(&features, k));
        if let Some(decision) = classifier.decide_at(plan, &z.map(|z| z.value), &z.map(|z| z.variance)) {
            hash.add(decision.log_likelihoods());
            hash.add(decision.posteriors());
            hash.add(decision.expected_costs());
            hash.add(&[f32::from(decision.class)]);
        }
    }
}
