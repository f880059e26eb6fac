//! How the size of a defect grows: 0 at the onset, full size at the end of `runs`.

use rand::{Rng, RngExt};

/// A law of growth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// In proportion to time.
    Linear,
    /// In proportion to itself: to 20 to 55 times what it is soon after the onset.
    Exponential,
    /// By 8 to 15 chips of random size at random times.
    Steps,
    /// In proportion to time, with three pauses that take three tenths of it.
    Pauses,
    /// In proportion to time, after a first defect that grew until the bearing was replaced.
    Repaired,
}

impl Law {
    /// All laws.
    pub const ALL: [Self; 5] = [Self::Linear, Self::Exponential, Self::Steps, Self::Pauses, Self::Repaired];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Exponential => "exponential",
            Self::Steps => "steps",
            Self::Pauses => "pauses",
            Self::Repaired => "repaired",
        }
    }

    /// The sizes after so many runs, and the run of the onset, after a healthy time.
    pub(super) fn history(self, runs: f64, random: &mut impl Rng) -> (Vec<f64>, usize) {
        let mut sizes = vec![0.0; random.random_range(20..60)];
        if self == Self::Repaired {
            let first = runs * random.random_range(0.5..1.5);
            let replaced = random.random_range(0.4..0.9);
            sizes.extend(path(first, |part| part).into_iter().take_while(|size| *size < replaced));
            sizes.extend(vec![0.0; random.random_range(10..30)]);
        }
        let onset = sizes.len();
        sizes.extend(match self {
            Self::Linear | Self::Repaired => path(runs, |part| part),
            Self::Exponential => {
                let rate: f64 = random.random_range(3.0..4.0);
                path(runs, |part| (rate * part).exp_m1() / rate.exp_m1())
            }
            Self::Steps => {
                let chips = chips(random);
                path(runs, |part| chips.iter().filter(|chip| chip[0] <= part).map(|chip| chip[1]).sum())
            }
            Self::Pauses => {
                let begins: [f64; 3] = std::array::from_fn(|k| 0.15 + 0.25 * k as f64 + random.random_range(0.0..0.1));
                let paused = |part: f64| begins.iter().map(|begin| (part - begin).clamp(0.0, 0.1)).sum::<f64>();
                path(runs, |part| (part - paused(part)) / 0.7)
            }
        });
        (sizes, onset)
    }
}

/// Values at the runs, by the part of time that has passed.
fn path(runs: f64, of: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut sizes = vec![];
    let mut run = 0.0;
    while run <= runs {
        sizes.push(of(run / runs));
        run += 1.0;
    }
    sizes.push(1.0);
    sizes
}

/// Times and sizes of chips; both add up to 1.
fn chips(random: &mut impl Rng) -> Vec<[f64; 2]> {
    let count = random.random_range(8..=15);
    let mut exponential = || -random.random_range(f64::MIN_POSITIVE..1.0_f64).ln();
    let drawn: Vec<[f64; 2]> = (0..count).map(|_| [exponential(), exponential() + exponential()]).collect();
    let [times, sizes] = [0, 1].map(|k| drawn.iter().map(|chip| chip[k]).sum::<f64>());
    let mut passed = 0.0;
    let place = |[time, size]: &[f64; 2]| {
        passed += time / times;
        [passed.min(1.0), size / sizes]
    };
    drawn.iter().map(place).collect()
}
