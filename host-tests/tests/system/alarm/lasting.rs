//! Hours between false alarms of the core's alarm by directions, where offsets of runs last, and where drives scatter
//! unequally. Values of records are drawn from the law; the constants of the directions are those of training.

#[path = "../../../../target-tests/examples/support/directed.rs"]
mod directed;
#[path = "../../../../target-tests/examples/support/law.rs"]
mod law;

use bearing_watch::model::{Direction, EvidenceConstants, FeatureValue};
use bearing_watch::{Decision, Evidence, Model};
use directed::{DIRECTIONS, Directed, MODEL};
use model::train::directions::{Levels, limit_and_cap};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Records of ten seconds of a run, and the hours that are set.
const RECORDS: usize = 12;
const RUN_HOURS: f64 = 12.0 * 10.0 / 3600.0;
const SET_HOURS: f64 = 1000.0;
/// Drives and runs of a training set.
const TRAINING: [usize; 2] = [16, 6];
/// Trained models, judged drives of each, and histories of a drive with their runs.
const JUDGED: [u64; 4] = [20, 6, 50, 1500];
/// Variances between drives and runs, and of records, in that of the mean of a run.
const LAW: [f64; 3] = [6.0, 0.7, 0.3 * RECORDS as f64];
/// Healthy runs before a defect, and sizes of defects in deviations of run means: about those of a spall of full size,
/// a half, a quarter and an eighth under all effects of the field.
const BEFORE: usize = 14;
const SIZES: [f64; 4] = [32.0, 16.0, 8.0, 4.0];
/// Runs within which a defect is to be alarmed.
const LONGEST: usize = 100;

/// How drives behave: the correlation of successive offsets, and the deviation of the logarithm of a drive's scatter.
#[derive(Clone, Copy)]
struct Case {
    correlation: f64,
    unequal: f64,
}

/// A drive in all directions, before its first run.
#[derive(Clone)]
struct Drive {
    means: [f64; DIRECTIONS],
    scatter: [f64; DIRECTIONS],
    offsets: Option<[f64; DIRECTIONS]>,
    case: Case,
}

fn normals(random: &mut ChaCha8Rng) -> [f64; DIRECTIONS] {
    std::array::from_fn(|_| StandardNormal.sample(random))
}

impl Drive {
    fn draw(case: Case, random: &mut ChaCha8Rng) -> Self {
        let means = normals(random).map(|z| LAW[0].sqrt() * z);
        let scatter = normals(random).map(|z| (case.unequal * z).exp());
        Self { means, scatter, offsets: None, case }
    }

    /// The values of the records of the next run.
    fn run(&mut self, random: &mut ChaCha8Rng) -> [[f64; DIRECTIONS]; RECORDS] {
        let (rho, next) = (self.case.correlation, normals(random));
        let lasting = |k: usize, last: [f64; DIRECTIONS]| rho * last[k] + (1.0 - rho * rho).sqrt() * next[k];
        let offsets = self.offsets.map_or(next, |last| std::array::from_fn(|k| lasting(k, last)));
        self.offsets = Some(offsets);
        std::array::from_fn(|_| {
            let own = normals(random);
            std::array::from_fn(|k| {
                self.means[k] + self.scatter[k] * (LAW[1].sqrt() * offsets[k] + LAW[2].sqrt() * own[k])
            })
        })
    }
}

/// The model of a training set, and the median of ρ.
fn trained(case: Case, random: &mut ChaCha8Rng) -> (Model<Directed>, f64) {
    let [drives, runs] = TRAINING;
    let mut samples = vec![vec![vec![Vec::new(); runs]; drives]; DIRECTIONS];
    for drive in 0..drives {
        let mut own = Drive::draw(case, random);
        for run in 0..runs {
            for record in own.run(random) {
                samples.iter_mut().zip(record).for_each(|(sample, y)| sample[drive][run].push([y, 0.0]));
            }
        }
    }
    let levels: Vec<Levels> = samples.iter().map(|sample| Levels::of(sample, 0).expect("enough runs")).collect();
    let mut constants = MODEL.constants().clone();
    let segments = SET_HOURS / RUN_HOURS * RECORDS as f64;
    let [limit, cap] = limit_and_cap(segments, DIRECTIONS, RECORDS as f64).map(|x| x as f32);
    constants.evidence = EvidenceConstants { limit, cap, ..constants.evidence };
    let directions = &mut constants.classifier.novelty.directions;
    directions.usual_segments = RECORDS as f32;
    for (k, (direction, own)) in directions.list.iter_mut().zip(&levels).enumerate() {
        *direction = Direction {
            coordinate: k as u8,
            centre: own.centre as f32,
            between: own.between as f32,
            run: own.run as f32,
            segment: own.record as f32,
            skewness: own.skewness as f32,
            correlation: own.correlation.expect("successive runs") as f32,
            ..Direction::UNIT
        };
    }
    let mut correlations: Vec<f64> = levels.iter().filter_map(|own| own.correlation).collect();
    correlations.sort_by(f64::total_cmp);
    (Directed::model(constants).expect("a good model"), correlations[DIRECTIONS / 2])
}

/// The core's alarm of one drive.
struct Watch<'a> {
    model: &'a Model<Directed>,
    evidence: Evidence<Directed>,
    decision: Decision<Directed>,
}

impl<'a> Watch<'a> {
    fn new(model: &'a Model<Directed>) -> Self {
        Self { model, evidence: Evidence::new(model), decision: directed::decision([0.0; DIRECTIONS]).expect("one") }
    }

    /// Whether a run raises an alarm, with its first direction raised so far.
    fn alarms(&mut self, records: &[[f64; DIRECTIONS]], raised: f64) -> bool {
        let list = &self.model.constants().classifier.novelty.directions.list;
        for record in records {
            let mut values = [FeatureValue::MISSING; DIRECTIONS];
            for (k, (cell, direction)) in values.iter_mut().zip(list).enumerate() {
                let raised = if k == 0 { raised } else { 0.0 };
                *cell = FeatureValue { value: (record[k] + raised) as f32 - direction.centre, variance: 0.0 };
            }
            self.decision.set_directed(&values);
            self.evidence.observe(Some(&self.decision));
        }
        self.evidence.end_run().is_some()
    }
}

/// What the drives of one model say.
#[derive(Default)]
struct Found {
    correlations: Vec<f64>,
    /// Hours between false alarms of each drive.
    hours: Vec<f64>,
    /// Runs until the alarm, by size; more than [`LONGEST`] without one.
    delays: [Vec<usize>; SIZES.len()],
}

fn judge(case: Case, seed: u64) -> Found {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (model, correlation) = trained(case, &mut random);
    let [_, drives, histories, runs] = JUDGED;
    let mut found = Found { correlations: vec![correlation], ..Found::default() };
    for _ in 0..drives {
        let drive = Drive::draw(case, &mut random);
        let (mut alarms, mut all) = (0_u32, 0_u32);
        for _ in 0..histories {
            let (mut drive, mut watch) = (drive.clone(), Watch::new(&model));
            for _ in 0..runs {
                all += 1;
                if watch.alarms(&drive.run(&mut random), 0.0) {
                    alarms += 1;
                    break;
                }
            }
        }
        found.hours.push(f64::from(all) * RUN_HOURS / f64::from(alarms.max(1)));
        for (size, delays) in SIZES.iter().zip(&mut found.delays) {
            let (mut drive, mut watch) = (drive.clone(), Watch::new(&model));
            let quiet = (0..BEFORE).all(|_| !watch.alarms(&drive.run(&mut random), 0.0));
            let until = (1..=LONGEST).find(|_| watch.alarms(&drive.run(&mut random), *size));
            delays.extend(quiet.then(|| until.unwrap_or(LONGEST + 1)));
        }
    }
    found
}

fn all(case: Case, models: u64) -> Found {
    let each: Vec<Found> = (0..models).into_par_iter().map(|seed| judge(case, seed)).collect();
    each.into_iter().fold(Found::default(), |mut all, mut own| {
        all.correlations.append(&mut own.correlations);
        all.hours.append(&mut own.hours);
        all.delays.iter_mut().zip(&mut own.delays).for_each(|(all, own)| all.append(own));
        all
    })
}

impl Found {
    fn below(&self) -> usize {
        self.hours.iter().filter(|hours| **hours < SET_HOURS).count()
    }

    /// Median and 90 % of the runs until the alarm.
    fn delay(&self, size: usize) -> [usize; 2] {
        let mut sorted = self.delays[size].clone();
        sorted.sort_unstable();
        [sorted[sorted.len() / 2], sorted[sorted.len() * 9 / 10]]
    }

    fn row(&self, name: &str) -> String {
        let mut sorted = self.hours.clone();
        sorted.sort_by(f64::total_cmp);
        let mut correlations = self.correlations.clone();
        correlations.sort_by(f64::total_cmp);
        let runs = |runs: usize| if runs > LONGEST { "–".to_string() } else { runs.to_string() };
        let delays: Vec<String> = (0..SIZES.len()).map(|k| self.delay(k).map(runs).join(" / ")).collect();
        format!(
            "{name:<34} {:.2}  {:>3} of {} ({:.1} %)  {:>6.0}  {:>6.0}  {}",
            correlations[correlations.len() / 2],
            self.below(),
            sorted.len(),
            100.0 * self.below() as f64 / sorted.len() as f64,
            sorted[0],
            sorted[sorted.len() / 2],
            delays.iter().map(|delay| format!("{delay:>8}")).collect::<String>()
        )
    }
}

const CASES: [(&str, Case); 5] = [
    ("correlation 0", Case { correlation: 0.0, unequal: 0.0 }),
    ("correlation 0.5", Case { correlation: 0.5, unequal: 0.0 }),
    ("correlation 0.8", Case { correlation: 0.8, unequal: 0.0 }),
    ("scatter of drives differs by 10 %", Case { correlation: 0.0, unequal: 0.1 }),
    ("scatter of drives differs by 20 %", Case { correlation: 0.0, unequal: 0.2 }),
];

/// Two thirds of an hour of histories a drive would be too few for a rate of 5 %: only gross errors are seen here.
#[test]
fn lasting_offsets_keep_the_hours_and_large_defects_their_delays() {
    let found = all(CASES[2].1, 4);
    println!("{}", found.row(CASES[2].0));
    // 24 drives at 5 %: more than five are seen once in 1000 times; without ρ it is all of them.
    assert!(found.below() <= 5, "{}", found.below());
    assert!((0..3).all(|size| found.delay(size)[0] <= [2, 3, 6][size]), "delays");
}

#[test]
#[ignore = "minutes of statistics"]
fn lasting_offsets_of_the_documents() {
    println!("<!-- generated: cargo xtask docs lasting -->\n```text");
    let [row, least, below, worst, median] = ["", "ρ ≤", "drives below 1000 h", "worst", "median"];
    println!(
        "{row:<34} {least}  {below:<19} {worst:>6}  {median:>6}  runs until the alarm, median / 90 %, 32, 16, 8, 4 \
         deviations"
    );
    for (name, case) in CASES {
        let found = all(case, JUDGED[0]);
        println!("{}", found.row(name));
    }
    println!("```\n<!-- end -->");
}
