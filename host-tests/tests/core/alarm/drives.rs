//! Gates and alarms of drives with sessions, by the core in single precision, on simulated features.
//!
//! ```text
//! z = u + v + e,   u ~ N(0, U) of the drive, v ~ N(0, V) of the session, e ~ N(0, I − U − V) of the segment      (1)
//! ```
//!
//! One model for other drives: trained on sessions of 20 drives, judged on drives that it has not seen. One model a
//! drive: trained on sessions of the drive, judged on its later sessions.

use bearing_watch::model::{EvidenceConstants, Feature};
use bearing_watch::plan::RunTime;
use bearing_watch::{Evidence, Model};
use host_tests::plans::constants;
use model::train::FeatureTable;
use model::train::novelty::baseline::exact;
use model::train::novelty::{Gate, alarm, gate_of_runs};
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::novelty::{beyond, core, plan};

const COORDINATES: usize = 2;
/// Parts of the variance.
const OF_DRIVE: f64 = 0.4;
const OF_SESSION: f64 = 0.3;

fn normal(variance: f64, random: &mut ChaCha8Rng) -> DVector<f64> {
    DVector::from_fn(COORDINATES, |_, _| -> f64 { StandardNormal.sample(random) }) * variance.sqrt()
}

/// Segments of sessions of drives (1), and the number of the group of each: its drive, or its session.
fn training(
    (drives, sessions, segments): (usize, usize, usize),
    by_drive: bool,
    random: &mut ChaCha8Rng,
) -> (FeatureTable, Vec<usize>) {
    let (mut rows, mut groups) = (vec![], vec![]);
    for drive in 0..drives {
        let own = if by_drive { normal(OF_DRIVE, random) } else { DVector::zeros(COORDINATES) };
        for session in 0..sessions {
            let mean = &own + normal(OF_SESSION, random);
            for _ in 0..segments {
                rows.push(&mean + normal(1.0 - OF_DRIVE - OF_SESSION, random));
                groups.push(if by_drive { drive } else { session });
            }
        }
    }
    let classes = vec![0; rows.len()];
    (FeatureTable::exact(rows, classes, vec!["healthy".into()]), groups)
}

/// Rate of novel segments in sessions of a drive, at 1e-2 and 1e-3.
fn rates(gate: &Gate, drive: &DVector<f64>, (sessions, segments): (usize, usize), random: &mut ChaCha8Rng) -> [f64; 2] {
    let (novelty, mut surprises) = (core(gate), vec![]);
    for _ in 0..sessions {
        let mean = drive + normal(OF_SESSION, random);
        for _ in 0..segments {
            let z = (&mean + normal(1.0 - OF_DRIVE - OF_SESSION, random)).map(|x| x as f32);
            surprises.push(novelty.judge(z.as_slice(), &[]).surprise);
        }
    }
    beyond(surprises.into_iter())
}

/// Mean and standard error over draws.
fn mean(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt())
}

/// Rates of gates of so many training sets, each judged on so many drives or later sessions.
fn check_rates(sets: u64, judged_on: usize, rates_set: &[f64]) {
    // 20 drives of 10 sessions of 5 segments each; 20 sessions of 5 segments of one drive.
    for (name, by_drive, size) in [("other drives", true, (20, 10, 5)), ("the same drive", false, (1, 20, 5))] {
        let one = |draw: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(5_000 + draw);
            let (table, groups) = training(size, by_drive, &mut random);
            let gate = gate_of_runs(&table, Some(&groups), 1e-3).expect("enough groups");
            let judged = |_: usize| {
                let drive = normal(if by_drive { OF_DRIVE } else { 0.0 }, &mut random);
                rates(&gate, &drive, (10, 5), &mut random)
            };
            // Many drives, or later sessions: a single drive may be far out for good.
            let each: Vec<[f64; 2]> = (0..judged_on).map(judged).collect();
            [0, 1].map(|k| each.iter().map(|rates| rates[k]).sum::<f64>() / judged_on as f64)
        };
        let found: Vec<[f64; 2]> = (0..sets).into_par_iter().map(one).collect();
        for (k, set) in rates_set.iter().enumerate() {
            let (rate, error) = mean(found.iter().map(|rates| rates[k]));
            println!("{name}: set {set}, false alarms {rate:.5} ± {error:.5} of {sets} training sets");
            // 4 million segments; the standard error over training sets is printed, about 10 % of the rarer rate. The
            // upper limit of the part between runs makes gates of one drive's 20 sessions up to twice as rare.
            let least = if by_drive { 1.5 } else { 3.0 };
            assert!((set / least..set * 1.5).contains(&rate), "{name}: {rate} for {set}");
        }
    }
}

#[test]
fn sessions_of_other_drives_and_of_the_same_drive_have_the_set_rates_short() {
    // The standard error over 40 training sets is about 10 % of one in a hundred.
    check_rates(40, 100, &[1e-2]);
}

#[test]
#[ignore = "minutes of statistics"]
fn sessions_of_other_drives_and_of_the_same_drive_have_the_set_rates_long() {
    check_rates(200, 400, &[1e-2, 1e-3]);
}

/// Segment of 10 s, sessions of 30 segments.
const SEGMENT_S: f64 = 10.0;
const SEGMENTS: usize = 30;
const SET_H: f64 = 1000.0;

/// The model of one drive in service, and the offset of this drive.
fn service(by_drive: bool, random: &mut ChaCha8Rng) -> (Model<RunTime>, DVector<f64>) {
    let size = if by_drive { (20, 10, 5) } else { (1, 20, SEGMENTS) };
    let (table, groups) = training(size, by_drive, random);
    let gate = gate_of_runs(&table, Some(&groups), 0.01).expect("enough groups");
    let interval = SET_H * 3600.0 / SEGMENT_S;
    let evidence = alarm::constants(&gate, 1, interval, (SEGMENTS as u32, by_drive)).expect("an alarm");
    let plan = plan(COORDINATES, 1);
    let mut constants = constants(plan, 100, &[1.0], &[Feature::Parameter(0)], None);
    constants.classifier.projection.matrix = vec![1.0; COORDINATES];
    constants.classifier.discriminant.means = vec![0.0; COORDINATES];
    constants.classifier.discriminant.factors = vec![1.0, 0.0, 1.0];
    constants.classifier.novelty = core(&gate);
    constants.evidence = evidence;
    (Model::new(plan, constants).expect("a good model"), normal(if by_drive { OF_DRIVE } else { 0.0 }, random))
}

/// The same model with segments that count as independent, and a surprise that counts as exact.
fn independent(model: &Model<RunTime>) -> Model<RunTime> {
    let mut constants = model.constants().clone();
    let EvidenceConstants { bet, limit, .. } = constants.evidence;
    let cap = 0.5 * limit;
    let log_mean = exact(bet.into(), cap.into()) as f32;
    constants.evidence = EvidenceConstants { bet, limit, cap, log_mean, ..EvidenceConstants::NONE };
    Model::new(model.plan(), constants).expect("a good model")
}

/// Hours of one drive, at most so many, and its first alarm, if there is one; its features are `shift` off.
fn first_alarm(model: &Model<RunTime>, drive: &DVector<f64>, (shift, most_h): (f64, f64), seed: u64) -> (f64, bool) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut evidence, classifier) = (Evidence::new(model), &model.constants().classifier);
    let mut segments = 0_u64;
    let hours = |segments: u64| segments as f64 * SEGMENT_S / 3600.0;
    while hours(segments) < most_h {
        let mean = drive + normal(OF_SESSION, &mut random) + DVector::repeat(COORDINATES, shift);
        for _ in 0..SEGMENTS {
            segments += 1;
            let z = (&mean + normal(1.0 - OF_DRIVE - OF_SESSION, &mut random)).map(|x| x as f32);
            if evidence.observe(classifier.decide_at(model.plan(), z.as_slice(), &[]).as_ref()).is_some() {
                return (hours(segments), true);
            }
        }
        evidence.end_run();
    }
    (hours(segments), false)
}

/// Hours of all drives, and of each that alarmed.
fn summed(each: impl Iterator<Item = (f64, bool)>) -> (f64, Vec<f64>) {
    each.fold((0.0, vec![]), |(sum, mut alarms), (hours, alarm)| {
        alarms.extend(alarm.then_some(hours));
        (sum + hours, alarms)
    })
}

/// Alarms of so many drives that are healthy for so many hours.
fn check_alarms(drives: u64, hours_each: f64) {
    for (name, by_drive) in [("other drives", true), ("the same drive", false)] {
        let one = |draw: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(90_000 + draw);
            let (model, drive) = service(by_drive, &mut random);
            let seed = 200_000 + draw;
            let healthy = first_alarm(&model, &drive, (0.0, hours_each), seed);
            let log_mean = f64::from(model.constants().evidence.log_mean);
            (
                healthy,
                first_alarm(&independent(&model), &drive, (0.0, hours_each), seed),
                first_alarm(&model, &drive, (6.0, hours_each), seed),
                log_mean,
            )
        };
        let each: Vec<_> = (0..drives).into_par_iter().map(one).collect();
        let (hours, alarms) = summed(each.iter().map(|drive| drive.0));
        let (short, many) = summed(each.iter().map(|drive| drive.1));
        let (_, found) = summed(each.iter().map(|drive| drive.2));
        let latest = found.iter().copied().fold(0.0, f64::max);
        let log_mean = each.iter().map(|drive| drive.3).sum::<f64>() / drives as f64;
        println!("{name}, set {SET_H} h, ln μ {log_mean:.2}: {} first alarms in {hours:.0} h by runs", alarms.len());
        println!("  segments independent: {} first alarms in {short:.0} h", many.len());
        println!("  6 deviations off: {} of {drives} found, within {latest:.2} h", found.len());
        println!("  first alarms by runs at {alarms:.1?} h");
        // 5 % of the drives may alarm more often than set: of 100, 5 and two deviations of 2.2.
        let early = alarms.iter().filter(|at| **at < 0.1 * SET_H).count();
        assert!(early * 10 <= each.len(), "{name}: {alarms:?}");
        if hours > 10.0 * SET_H {
            // One alarm at least: an evidence that never alarms would pass otherwise.
            assert!(!alarms.is_empty() && hours / alarms.len() as f64 > SET_H, "{name}: {alarms:?} in {hours} h");
        }
        let mean_h = short / many.len() as f64;
        assert!(mean_h < 0.1 * SET_H, "{name}: the assumption of independent segments would do");
        // Two or three sessions of 5 min.
        assert!(found.len() == each.len() && latest < 0.3, "{name}: {} within {latest}", found.len());
    }
}

#[test]
fn false_alarms_of_drives_with_sessions_are_as_rare_as_set_short() {
    check_alarms(20, 100.0);
}

#[test]
#[ignore = "minutes of statistics"]
fn false_alarms_of_drives_with_sessions_are_as_rare_as_set_long() {
    check_alarms(100, 1000.0);
}
