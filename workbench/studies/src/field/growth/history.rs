//! Histories of drives, and what the core says in them.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use super::drive::{Drive, observe};
use super::laws::Law;
use crate::field::delay;
use model::core::Embedded;

/// Parts of the life at which the time left is asked for.
pub const PARTS: [f64; 3] = [0.25, 0.5, 0.75];

/// Size of the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Training, records a run, judged drives, and recorded runs of each, healthy and of each size.
    pub fleet: delay::Settings,
    /// Histories of each law and drive.
    pub histories: u32,
    /// Shortest and longest life, runs.
    pub life: [f64; 2],
}

impl Settings {
    /// 20 drives of training, 8 judged ones, and 40 histories of each law on each.
    pub const STANDARD: Self = Self {
        fleet: delay::Settings { drives: 8, healthy: 24, ..delay::Settings::STANDARD },
        histories: 40,
        life: [40.0, 250.0],
    };
}

/// Runs of a healthy history, and those at its start that are not judged.
const HEALTHY: usize = 352;
const FIRST: usize = 3;

/// What the core says at one of [`PARTS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Runs until the named size is reached.
    pub truth: f64,
    /// Time left with its interval; `None` if the core says that the drive does not grow.
    pub left: Option<[f64; 3]>,
}

impl Asked {
    /// Whether the interval contains the truth.
    #[must_use]
    pub fn covers(&self) -> Option<bool> {
        self.left.map(|[_, low, high]| low <= self.truth && self.truth <= high)
    }

    /// Half of the interval's width as part of the truth.
    #[must_use]
    pub fn width(&self) -> Option<f64> {
        self.left.map(|[_, low, high]| 0.5 * (high - low) / self.truth)
    }
}

/// A history with a defect that reaches the named size.
pub type Outcome = [Asked; PARTS.len()];

/// A healthy history: number of judged runs, and of those after which the drive is said to grow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Healthy {
    /// Judged runs.
    pub runs: usize,
    /// Runs after which the drive is said to grow.
    pub growing: usize,
}

fn seeds(settings: &Settings) -> Vec<u64> {
    (0..u64::from(settings.histories)).collect()
}

/// Histories of a law on all drives; those that do not reach the named size are left out.
pub(super) fn grown(model: &Embedded, drives: &[Drive], of: (Law, f64), settings: &Settings) -> Vec<Outcome> {
    let one = |(place, drive): (usize, &Drive)| {
        let seed = |history: u64| (place as u64) << 32 | (of.0 as u64) << 24 | history;
        let one = |history: u64| history_of(model, drive, of, (settings.life, seed(history)));
        seeds(settings).into_par_iter().filter_map(one).collect::<Vec<_>>()
    };
    drives.iter().enumerate().flat_map(one).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "the core's numbers")]
fn history_of(
    model: &Embedded,
    drive: &Drive,
    (law, named): (Law, f64),
    (life, seed): ([f64; 2], u64),
) -> Option<Outcome> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let runs = life[0] * (life[1] / life[0]).powf(random.random_range(0.0..1.0));
    let (sizes, onset) = law.history(runs, &mut random);
    let grows = |size: &f64| drive.shift(*size) >= named;
    let end = onset + sizes[onset..].iter().position(grows)?;
    let asked = PARTS.map(|part| onset + (part * (end - onset) as f64).round() as usize);
    let mut outcome = [Asked { truth: 0.0, left: None }; PARTS.len()];
    let mut evidence = model.evidence();
    for (run, size) in sizes[..end].iter().enumerate() {
        observe(&mut evidence, model, &drive.run(*size, &mut random));
        for (answer, _) in outcome.iter_mut().zip(asked).filter(|(_, asked)| *asked == run) {
            let growth = evidence.growth_to(drive.direction as u8, named as f32);
            let left = growth.and_then(|growth| growth.left);
            answer.truth = (end - run) as f64;
            answer.left = left.map(|left| [left.value, left.low, left.high].map(f64::from));
        }
    }
    outcome.iter().all(|answer| answer.truth > 0.0).then_some(outcome)
}

/// Healthy histories of all drives, whose offsets last with a coefficient.
pub(super) fn healthy(model: &Embedded, drives: &[Drive], of: (f64, f64), settings: &Settings) -> Vec<Healthy> {
    let one = |(place, drive): (usize, &Drive)| {
        let one = |history: u64| healthy_of(model, drive, of, (place as u64) << 32 | 255 << 24 | history);
        seeds(settings).into_par_iter().map(one).collect::<Vec<_>>()
    };
    drives.iter().enumerate().flat_map(one).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "the core's numbers")]
fn healthy_of(model: &Embedded, drive: &Drive, (lasting, named): (f64, f64), seed: u64) -> Healthy {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let law = Normal::standard();
    let mut normal = || law.inverse_cdf(random.random_range(1e-9..1.0));
    let (mut evidence, mut healthy) = (model.evidence(), Healthy::default());
    let mut offset = normal();
    for run in 0..HEALTHY {
        offset = lasting * offset + (1.0 - lasting * lasting).sqrt() * normal();
        observe(&mut evidence, model, drive.healthy(law.cdf(offset)));
        if run >= FIRST {
            let growth = evidence.growth_to(drive.direction as u8, named as f32);
            healthy.runs += 1;
            healthy.growing += usize::from(growth.is_some_and(|growth| growth.is_growing()));
        }
    }
    healthy
}
