//! Novelty gate and evidence in the core's arithmetic: set false-alarm rates and alarms.

use bearing_watch::model::{Directions, EvidenceConstants, Feature, KNOTS, Novelty};
use bearing_watch::plan::Structure;
use bearing_watch::plan::{Layout, Memory, Method, Plan, RunTime};
use bearing_watch::{Cause, Evidence, Model};
use host_tests::plans::{constants, layout};
use model::train::FeatureTable;
use model::train::novelty::baseline::exact;
use model::train::novelty::law::DistanceLaw;
use model::train::novelty::{Gate, gate_of_runs, spread};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rayon::prelude::*;

/// Draws of healthy rows: a long check, and a short one.
const LONG: u64 = 120;
const SHORT: u64 = 12;
const HEALTHY: usize = 200;
const BOTH: [f64; 2] = [1e-2, 1e-3];

/// Rows of standard normal features, or of a multivariate t of so many degrees of freedom.
fn row(p: usize, degrees: Option<f64>, random: &mut ChaCha8Rng) -> DVector<f64> {
    let normal = DVector::from_fn(p, |_, _| -> f64 { StandardNormal.sample(random) });
    match degrees {
        None => normal,
        Some(v) => normal * (v / ChiSquared::new(v).expect("law").sample(random)).sqrt(),
    }
}

/// The gate of healthy rows.
pub(super) fn gate_of(healthy: &[DVector<f64>], rate: f64) -> Gate {
    let table = FeatureTable::exact(healthy.to_vec(), vec![0; healthy.len()], vec!["healthy".into()]);
    gate_of_runs(&table, None, rate).expect("a gate")
}

/// A plan whose only feature is the parameter of a regression.
pub(super) fn plan(coordinates: usize, classes: u8) -> RunTime {
    let plain = layout(Structure::new(1, 0, 0, 0, 0), Method::LeastSquares, Memory::Segment);
    RunTime::of(Layout { coordinates: coordinates as u8, classes, ..plain }).expect("a plan")
}

/// The core's form of a gate.
pub(super) fn core(gate: &Gate) -> Novelty<RunTime> {
    Novelty {
        class: Some(0),
        mean: gate.mean.iter().map(|x| *x as f32).collect(),
        factor: gate.factor(),
        knots: gate.knots.map(|knot| knot.map(|x| x as f32)),
        laws: gate.rising.as_ref().map_or_else(Vec::new, |rising| rising.core(gate.limit)),
        rises: gate.rising.as_ref().map_or_else(Vec::new, |rising| rising.rises(gate.limit)),
        acceptable: f32::INFINITY,
        freedom: gate.rising.as_ref().map_or(1.0, |rising| rising.freedom as f32),
        limit: gate.limit as f32,
        directions: Directions { list: vec![], usual_segments: 1.0, margin: 1.645, most_runs: 60 },
    }
}

/// Rates at which surprises reach the limits of the set rates, 1e-2 and 1e-3.
pub(super) fn beyond(surprises: impl Iterator<Item = f32>) -> [f64; 2] {
    let (mut counts, mut all) = ([0_usize; 2], 0_usize);
    for surprise in surprises {
        all += 1;
        for (count, rate) in counts.iter_mut().zip([1e-2_f32, 1e-3]) {
            *count += usize::from(surprise >= -rate.ln());
        }
    }
    counts.map(|count| count as f64 / all as f64)
}

/// True rates of single gates at the set rates, over training draws.
fn rates<const Z: usize>(draws: u64, degrees: Option<f64>, healthy: usize) -> Vec<[f64; 2]> {
    let one = |draw: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(1000 * Z as u64 + draw);
        // Features of different size that hang together.
        let mix =
            DMatrix::from_fn(Z, Z, |i, j| if j > i { 0.0 } else { 10_f64.powi(i as i32 - 2) / (1 + i - j) as f64 });
        let mut rows = |count: usize| -> Vec<DVector<f64>> {
            (0..count).map(|_| &mix * row(Z, degrees, &mut random) + DVector::repeat(Z, 3.0)).collect()
        };
        let healthy = rows(healthy);
        let gate = core(&gate_of(&healthy, 1e-3));
        let surprise = |z: DVector<f64>| gate.judge(&z.map(|x| x as f32).as_slice()[..Z], &[]).surprise;
        beyond(rows(TESTS).into_iter().map(surprise))
    };
    (0..draws).into_par_iter().map(one).collect()
}

/// Rows of normal features of different size that hang together, with errors of up to their deviation of known
/// variance, 30 % of them missing, but never all.
fn partial<const Z: usize>(count: usize, random: &mut ChaCha8Rng) -> FeatureTable {
    let mut table = FeatureTable::exact(vec![], vec![0; count], vec!["healthy".into()]);
    let size = |i: usize| 10_f64.powi(i as i32 - 2);
    while table.rows.len() < count {
        let common: f64 = StandardNormal.sample(random);
        let variance = DVector::from_fn(Z, |i, _| {
            let error = size(i) * random.random::<f64>();
            if random.random::<f64>() < 0.3 { f64::INFINITY } else { error * error }
        });
        let value = DVector::from_fn(Z, |i, _| {
            let [own, error]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(random));
            let value = 3.0 + size(i) * (0.8 * common + 0.6 * own);
            if variance[i].is_finite() { value + variance[i].sqrt() * error } else { 0.0 }
        });
        if variance.iter().any(|v| v.is_finite()) {
            table.rows.push(value);
            table.variances.push(variance);
        }
    }
    table
}

/// The same for gates of rows with errors and missing values.
fn partial_rates<const Z: usize>(draws: u64, healthy: usize) -> Vec<[f64; 2]> {
    let one = |draw: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(70_000 + 1000 * Z as u64 + draw);
        let gate = core(&gate_of_runs(&partial::<Z>(healthy, &mut random), None, 1e-3).expect("a gate"));
        let tests = partial::<Z>(TESTS, &mut random);
        let surprise = |(value, variance): (&DVector<f64>, &DVector<f64>)| {
            let [z, v] = [value, variance].map(|of| of.map(|x| x as f32));
            gate.judge(z.as_slice(), v.as_slice()).surprise
        };
        beyond(tests.rows.iter().zip(&tests.variances).map(surprise))
    };
    (0..draws).into_par_iter().map(one).collect()
}

/// Mean over draws within a factor 1.5 of the set rate; the spread of single gates is printed.
fn check(name: &str, sets: &[f64], found: &[[f64; 2]]) {
    for (k, set) in [1e-2, 1e-3].into_iter().enumerate() {
        let mut single: Vec<f64> = found.iter().map(|rates| rates[k]).collect();
        single.sort_by(f64::total_cmp);
        let mean = single.iter().sum::<f64>() / single.len() as f64;
        let (low, high) = (single[single.len() / 20], single[single.len() - 1 - single.len() / 20]);
        println!("{name}: set {set}, mean {mean:.5}, 5–95 % of single gates {low:.5}–{high:.5}");
        assert!(!sets.contains(&set) || (set / 1.5..set * 1.5).contains(&mean), "{name}: set {set}, found {mean}");
    }
}

// 120 × 8000 rows: about 1000 alarms at the rarer rate, 3 %; single gates scatter by up to their mean, so 120 of them
// bring 9 %.
const TESTS: usize = 8_000;

#[test]
fn set_rates_hold_in_the_mean_short() {
    // A gate's rate of one in a hundred scatters by a third, 12 of them by a tenth; the rarer one takes more gates.
    check("3 coordinates", &BOTH[..1], &rates::<3>(SHORT, None, HEALTHY));
    check("6 coordinates, t with 8 degrees of freedom", &BOTH[..1], &rates::<6>(SHORT, Some(8.0), HEALTHY));
    check("4 coordinates, 30 % missing", &BOTH[..1], &partial_rates::<4>(SHORT, HEALTHY));
}

#[test]
#[ignore = "minutes of statistics"]
fn set_rates_hold_in_the_mean_long() {
    check("1 coordinate", &BOTH, &rates::<1>(LONG, None, HEALTHY));
    check("3 coordinates", &BOTH, &rates::<3>(LONG, None, HEALTHY));
    check("6 coordinates", &BOTH, &rates::<6>(LONG, None, HEALTHY));
    check("2 coordinates, 30 % missing", &BOTH, &partial_rates::<2>(LONG, HEALTHY));
    check("4 coordinates, 30 % missing", &BOTH, &partial_rates::<4>(LONG, HEALTHY));
    check("6 coordinates, t with 8 degrees of freedom", &BOTH, &rates::<6>(LONG, Some(8.0), HEALTHY));
    // One coordinate tells less of the tail: 200 rows hold the rate of one in a hundred; one in a thousand takes more.
    check("3 coordinates, t with 8 degrees of freedom", &BOTH, &rates::<3>(LONG, Some(8.0), HEALTHY));
    check("1 coordinate, t with 8 degrees of freedom", &BOTH[..1], &rates::<1>(LONG, Some(8.0), HEALTHY));
    check("1 coordinate of 1000 rows, t with 8 degrees of freedom", &BOTH, &rates::<1>(LONG, Some(8.0), 1000));
}

#[test]
fn the_law_of_gaussian_features_is_exceeded_by_heavier_tails() {
    // Were the law of Gaussian features kept, the rarer rate would be exceeded several times over.
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let gaussian = DistanceLaw::gaussian(6, HEALTHY);
    // A t of 8 degrees has covariance 8/6.
    let mut far = || gaussian.surprise(row(6, Some(8.0), &mut random).norm_squared() * 6.0 / 8.0) >= 1000_f64.ln();
    let exceeded = (0..100_000).filter(|_| far()).count() as f64 / 1e5;
    println!("by the law of Gaussian features {exceeded} instead of 0.001");
    assert!(exceeded > 3e-3, "{exceeded}");
}

#[test]
fn surprise_follows_the_law_in_single_precision() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    for n in [12, 30, 200] {
        let healthy: Vec<_> = (0..n).map(|_| row(3, None, &mut random)).collect();
        let gate = gate_of(&healthy, 0.01);
        let novelty = core(&gate);
        for step in 1..=250 {
            let surprise = 0.1 * f64::from(step);
            let found = f64::from(novelty.surprise(gate.law.squared_at(surprise) as f32));
            assert!((found - surprise).abs() < 0.02 * surprise.max(1.0), "{n}: {found} for {surprise}");
        }
        assert!((f64::from(novelty.surprise(gate.law.squared_at(gate.limit) as f32)) - gate.limit).abs() < 1e-4);
    }
}

/// A healthy class at 0 of deviation 1, defects at 2 and −2; one alarm in so many segments by so many scores.
fn model(classes: u8, segments: f64, scores: f64) -> Model<RunTime> {
    let plan = plan(1, classes);
    let mut constants = constants(plan, 100, &[1.0], &[Feature::Parameter(0)], None);
    constants.classifier.discriminant.means = [0.0, 2.0, -2.0][..classes.into()].to_vec();
    constants.classifier.novelty = chi_squared(plan);
    constants.evidence = evidence(segments, scores);
    Model::new(plan, constants).expect("a good model")
}

/// The healthy class N(0, 1), known.
fn chi_squared(plan: RunTime) -> Novelty<RunTime> {
    let law = DistanceLaw::gaussian(1, 1_000_000);
    let mut novelty = Novelty { class: Some(0), factor: vec![1.0], limit: 4.6, ..Novelty::none(plan) };
    for (k, knot) in novelty.knots.iter_mut().enumerate() {
        let surprise = 25.0 * (k as f64 / (KNOTS - 1) as f64).powi(2);
        *knot = [law.squared_at(surprise) as f32, surprise as f32];
    }
    novelty
}

fn evidence(segments: f64, scores: f64) -> EvidenceConstants {
    let limit = (segments * scores).ln() as f32;
    let (bet, cap) = (0.2, 0.5 * limit);
    let log_mean = exact(bet, cap.into()) as f32;
    EvidenceConstants { bet: bet as f32, limit, cap, log_mean, ..EvidenceConstants::NONE }
}

/// Mean segments to the first alarm while healthy.
fn run_length(runs: u64, alarm_after: impl Fn(&mut ChaCha8Rng) -> u64 + Sync) -> f64 {
    let each = |run| alarm_after(&mut ChaCha8Rng::seed_from_u64(run));
    (0..runs).into_par_iter().map(each).sum::<u64>() as f64 / runs as f64
}

#[test]
fn false_alarms_are_at_least_as_rare_as_set() {
    for set in [100.0, 1000.0] {
        let healthy_only = model(1, set, 1.0);
        let uniform = run_length(400, |random| {
            let (mut evidence, classifier) = (Evidence::new(&healthy_only), &healthy_only.constants().classifier);
            let mut length = 1;
            let decision = |p: f32| classifier.decide(healthy_only.plan(), &[0.0], -p.ln());
            while evidence.observe(decision(1.0 - random.random::<f32>()).as_ref()).is_none() {
                length += 1;
            }
            length
        });
        let three = model(3, set, 3.0);
        let classes = run_length(400, |random| {
            let (mut evidence, classifier) = (Evidence::new(&three), &three.constants().classifier);
            let mut length = 1;
            let z = |random: &mut ChaCha8Rng| -> f32 { StandardNormal.sample(random) };
            while evidence.observe(classifier.decide_at(three.plan(), &[z(random)], &[]).as_ref()).is_none() {
                length += 1;
            }
            length
        });
        println!("set {set}: {uniform:.0} segments with uniform p, {classes:.0} with three classes");
        // 400 runs of exponential length: a deviation of 5 %.
        for found in [uniform, classes] {
            assert!((set..30.0 * set).contains(&found), "set {set}, found {found}");
        }
    }
}

#[test]
fn a_defect_alarms_within_three_segments_by_name_and_stays_until_reset() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    // One in 360 000 segments: 1000 hours of 10 s.
    let model = model(3, 360_000.0, 3.0);
    for (centre, cause) in [(9.0, Cause::Class(1)), (-9.0, Cause::Class(2))] {
        let mut evidence = Evidence::new(&model);
        let mut observe = |evidence: &mut Evidence<RunTime>, centre: f32| {
            let noise: f32 = StandardNormal.sample(&mut random);
            evidence.observe(model.constants().classifier.decide_at(model.plan(), &[centre + noise], &[]).as_ref())
        };
        for _ in 0..50 {
            assert_eq!(observe(&mut evidence, 0.0), None);
        }
        let alarms: Vec<_> = (0..3).map(|_| observe(&mut evidence, centre)).collect();
        let alarm = alarms[2].expect("within three segments");
        assert!(alarms[0].is_none(), "one segment alone is no alarm");
        assert_eq!(alarm.cause, cause);
        for _ in 0..50 {
            assert_eq!(observe(&mut evidence, 0.0), Some(alarm));
        }
        evidence.reset();
        assert_eq!((evidence.alarm(), evidence.score()), (None, 0.0));
        assert_eq!(observe(&mut evidence, 0.0), None);
    }
}

#[test]
fn how_many_healthy_segments_a_rate_needs() {
    for p in [1, 3, 6] {
        let needed = [1e-2, 1e-3].map(|rate| spread::rows_needed(p, rate));
        println!("{p} coordinates: {} segments at 1e-2, {} at 1e-3", needed[0], needed[1]);
        let rates = spread::gate_rates(p, 20, 1e-2, 400);
        println!("  of 20 segments at 1e-2: 5–95 % of single gates {:.4}–{:.4}", rates[20], rates[379]);
        assert!(needed[0] < needed[1] && needed[1] < 400, "{p}: {needed:?}");
    }
}
