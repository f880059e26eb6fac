//! Healthy sets that are not what a gate assumes: training names them, and their gates keep the set rate.
//!
//! A record is a response of a first-order model,
//!
//! ```text
//! y(t) = −a y(t−1) + b u₁(t−1) + c u₂(t−1) + e(t),   [a b c]ᵀ = θ₀ + S L x,   x ∈ ℝ³               (1)
//! ```
//!
//! where x is drawn once a record and has mean 0 and variance 1 in each coordinate, L correlates the coordinates, and S
//! scales them. The noise e is so small that the error of an estimated parameter is a fiftieth of its spread.
//!
//! For each set and draw, a user trains with 150 records and the false-alarm rate; false alarms are counted on other
//! records of the same law, each of a new session, and detections on records that are shifted by four standard
//! deviations.

use model::core::Finding;
use model::identify::Structure;
use model::trace::Trace;
use model::trace::labels::LabelledTrace;
use model::train::{Alarms, Recipe, Trained, Validation, train};
use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rayon::prelude::*;

/// Records of a training set, judged records of each kind, and draws of each set.
const TRAINED: usize = 150;
const JUDGED: usize = 1000;
const DRAWS: std::ops::Range<u32> = 700..704;
/// Shift of the records to be detected, in standard deviations of a coordinate.
const SHIFT: f64 = 4.0;
/// Segments of a session.
const SESSION: usize = 5;
/// Samples of a record.
const SAMPLES: usize = 300;
/// θ₀ and the diagonal of S.
const MEAN: [f64; 3] = [-0.7, 1.0, 0.5];
const SPREAD: [f64; 3] = [0.003, 0.02, 0.02];
/// Standard deviation of e; that of the inputs is 1.
const NOISE: f64 = 0.001;
/// Shape of the skewed laws: exp(0.7 x) has the skewness 2.9.
const SHAPE: f64 = 0.7;
/// Part of the variance that the records of a session have in common.
const COMMON: f64 = 0.5;
/// Correlation of records that follow each other.
const SERIAL: f64 = 0.7;

/// The law of x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Law {
    /// Normal, independent.
    Normal,
    /// Normal, and one record in twenty is shifted by so many standard deviations.
    Contaminated(u8),
    /// A logarithmic normal law in each coordinate.
    Skewed,
    /// A multivariate t law of three degrees of freedom.
    HeavyTails,
    /// Half of the variance is that of sessions.
    Sessions,
    /// The same, and the law of sessions is skewed.
    SkewedSessions,
    /// Each record is correlated with the one before.
    Serial,
}

/// A healthy set: a law, and whether the sessions of its records are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct HealthySet {
    /// Its name.
    name: &'static str,
    /// The law of its records.
    law: Law,
    /// What training is told of the sessions.
    sessions: Known,
}

/// What training is told of the sessions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    /// The labels have no column of sessions.
    Not,
    /// The labels have a column `session`.
    Column,
    /// The user names the column.
    Group,
}

/// All sets.
const SETS: [HealthySet; 9] = [
    set("normal", Law::Normal, Known::Not),
    set("contaminated-4", Law::Contaminated(4), Known::Not),
    set("contaminated-8", Law::Contaminated(8), Known::Not),
    set("skewed", Law::Skewed, Known::Not),
    set("heavy-tails", Law::HeavyTails, Known::Not),
    set("sessions", Law::Sessions, Known::Column),
    set("sessions-unnamed", Law::Sessions, Known::Not),
    set("skewed-sessions", Law::SkewedSessions, Known::Group),
    set("serial", Law::Serial, Known::Not),
];

const fn set(name: &'static str, law: Law, sessions: Known) -> HealthySet {
    HealthySet { name, law, sessions }
}

/// Returns `count` records of a law, the first coordinate shifted by so many standard deviations; `together` records of
/// a session follow each other, or every record is of another session.
fn records(law: Law, (count, together): (usize, bool), shift: f64, seed: u64) -> Vec<LabelledTrace> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut source = Source { law, before: normal(&mut rng), session: Vector3::zeros() };
    (0..count)
        .map(|k| {
            let new = !together || k % SESSION == 0;
            let mut x = source.next(new, &mut rng);
            if let Law::Contaminated(size) = law
                && together
                && k % 20 == 7
            {
                x[0] += f64::from(size);
            }
            x[0] += shift;
            let trace = record(&x, &mut rng);
            LabelledTrace { trace: Trace { id: format!("r{k}"), ..trace }, class: 0 }
        })
        .collect()
}

struct Source {
    law: Law,
    before: Vector3<f64>,
    session: Vector3<f64>,
}

impl Source {
    /// The x of the next record.
    fn next(&mut self, new: bool, rng: &mut ChaCha8Rng) -> Vector3<f64> {
        let z = normal(rng);
        match self.law {
            Law::Normal | Law::Contaminated(_) => z,
            Law::Skewed => z.map(skewed),
            Law::HeavyTails => {
                // t = z √(3/χ²) of three degrees of freedom has the variance 3.
                let squared: f64 = ChiSquared::new(3.0).expect("positive").sample(rng);
                z / squared.sqrt()
            }
            Law::Sessions | Law::SkewedSessions => {
                if new {
                    self.session = normal(rng);
                    if self.law == Law::SkewedSessions {
                        self.session = self.session.map(skewed);
                    }
                }
                self.session * COMMON.sqrt() + z * (1.0 - COMMON).sqrt()
            }
            Law::Serial => {
                self.before = self.before * SERIAL + z * (1.0 - SERIAL * SERIAL).sqrt();
                self.before
            }
        }
    }
}

fn normal(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(rng))
}

/// exp(SHAPE x), with mean 0 and variance 1.
fn skewed(x: f64) -> f64 {
    let variance = (SHAPE * SHAPE).exp();
    ((SHAPE * x).exp() - variance.sqrt()) / (variance * (variance - 1.0)).sqrt()
}

/// The record (1).
fn record(x: &Vector3<f64>, rng: &mut ChaCha8Rng) -> Trace {
    let correlation = Matrix3::new(1.0, 0.0, 0.0, 0.6, 0.8, 0.0, -0.3, 0.5, 0.66_f64.sqrt());
    let mut theta = Vector3::from(MEAN) + (correlation * x).component_mul(&Vector3::from(SPREAD));
    // A model with a nearer to −1 is not stable; heavy tails reach so far.
    theta[0] = theta[0].clamp(-0.95, 0.95);
    let mut draw = || -> f64 { StandardNormal.sample(rng) };
    let (u1, u2): (Vec<f64>, Vec<f64>) = (0..SAMPLES).map(|_| (draw(), draw())).unzip();
    let mut y = vec![0.0; SAMPLES];
    for t in 1..SAMPLES {
        y[t] = -theta[0] * y[t - 1] + theta[1] * u1[t - 1] + theta[2] * u2[t - 1] + NOISE * draw();
    }
    Trace { y, u1, u2, ..Trace::default() }
}

/// The shares of the judged records that are novel or without a verdict, healthy and shifted, and what training doubts.
fn judged(set: HealthySet, draw: u32) -> ([f64; 2], Option<String>) {
    // Training and judged records have different seeds.
    let seed = |kind: u64| u64::from(draw) * 4 + kind;
    let training = records(set.law, (TRAINED, true), 0.0, seed(1));
    let trained = train(&training, &["healthy".into()], &recipe(set, training.len())).expect("no set is refused");
    let embedded = trained.embed().expect("the core accepts the model");
    let judge = |(shift, kind): (f64, u64)| {
        let found = |record: &LabelledTrace| embedded.combine(&embedded.run(&record.trace)).map(|(finding, _)| finding);
        let all = records(set.law, (JUDGED, false), shift, seed(kind));
        all.iter().filter(|record| found(record).is_none_or(|own| own == Finding::Novel)).count() as f64 / JUDGED as f64
    };
    ([(0.0, 2), (SHIFT, 3)].map(judge), words(&trained))
}

/// The recipe of a user who names signals, the healthy class and the rate.
fn recipe(set: HealthySet, count: usize) -> Recipe {
    let sessions: Vec<String> = (0..count).map(|k| (k / SESSION).to_string()).collect();
    let by_run = set.sessions == Known::Group;
    let columns = match set.sessions {
        Known::Not => Some(vec![]),
        Known::Column => Some(vec![("session".into(), sessions.clone())]),
        Known::Group => None,
    };
    let groups = if by_run { sessions } else { vec![] };
    let alarms = Alarms { healthy: Some(0), false_alarm: 0.01, by_run, required: true, ..Alarms::default() };
    let validation = Validation { groups, columns, doubted: true, ..Validation::default() };
    Recipe { alarms, validation, ..Recipe::new(Structure::new(1, 1, 1, 1, 1)) }
}

/// What training doubts.
fn words(trained: &Trained) -> Option<String> {
    let mut lines: Vec<String> = trained.doubted.iter().flat_map(|doubted| doubted.lines()).collect();
    lines.extend(trained.dependence.iter().map(model::train::Dependence::line));
    lines.extend(trained.watch.warning.clone());
    (!lines.is_empty()).then(|| lines.join("; "))
}

#[test]
fn wrong_sets_keep_the_rate_and_are_named() {
    for set in SETS {
        let draws: Vec<([f64; 2], Option<String>)> = DRAWS.into_par_iter().map(|draw| judged(set, draw)).collect();
        let mean = |k: usize| draws.iter().map(|draw| draw.0[k]).sum::<f64>() / draws.len() as f64;
        let ([rate, detected], doubted) = ([0, 1].map(mean), draws.iter().filter(|draw| draw.1.is_some()).count());
        println!("{}: {rate} {detected} {doubted}", set.name);
        // The mean of four gates set to 1 %: a gate of 150 records varies by two thirds of its rate, one of 30
        // sessions or of heavy tails by more.
        assert!((0.001..0.025).contains(&rate), "{}: {rate}", set.name);
        let named = if set.name == "normal" { 0..=1 } else { 3..=4 };
        assert!(named.contains(&doubted), "{}: {doubted} of 4", set.name);
        match set.name {
            // Four deviations in three coordinates at 1 %: 80 % if mean and covariance are known.
            "normal" => assert!((0.6..0.85).contains(&detected), "{detected}"),
            // At least 80 % of what the normal set finds at most.
            "contaminated-8" => assert!(detected > 0.8 * 0.85, "{detected}"),
            // At four deviations one row in twenty is the tail of one skewed law: the gate says that it is further out.
            "contaminated-4" => {
                let told = draws.iter().find_map(|draw| draw.1.clone()).expect("a doubt");
                assert!(told.contains("further out") || told.contains("another population"), "{told}");
            }
            _ => {}
        }
    }
}
