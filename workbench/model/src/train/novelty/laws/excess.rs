//! Whether rare segments are rarer by a law than they are.
//!
//! ```text
//! s_i: surprise of segment i by a law of the other segments;   s ~ Exp(1) if the law is right
//! t: the k-th largest s_i,   s_i − t ~ Exp(1/β) beyond it,   q = −ln(k/(n + 1))                     (1)  Weissman 1978
//! P(β | s): β = 1, the law itself, and larger ones;   L(β) = β^(−k) exp(−Σ (s_i − t)/β)            (2)
//! P(S ≥ s) = P(1) e^(−s) + Σ P(β) e^(−m(s)),   m = q s/t for s < t,  q + (s − t)/β beyond          (3)
//! ```
//!
//! Laws of distances assume contours of constant density that are ellipsoids. A skewed law, or one with other tails in
//! one coordinate than in another, has more rare segments than that. (1) is the estimator of a tail's index by Hill
//! (1975) for probabilities by the law, so that it needs no form of the true one. (3) averages over β as `super::law`
//! does over the tails. Segments of one run count once in (2): the likelihood has the power of the number of runs.

/// Part of the segments in the tail of (1), and the fewest of them.
const TAIL: f64 = 0.15;
const FEWEST: usize = 10;
/// Number of runs in the tail below which there is none.
const FEWEST_RUNS: usize = 5;
/// Number of segments below which there is no tail.
const LEAST_ROWS: usize = 40;
/// Prior probability of β = 1; the others share the rest.
const RIGHT: f64 = 0.5;
const RIGHT_IF_SKEWED: f64 = 0.05;
/// Other values of β: powers of this, up to 8.
const STEP: f64 = 1.3;
const STEPS: i32 = 8;
/// Excess up to which the tail follows (1), nats: no number of segments tells of rarer ones, and distances stay finite.
const FAR: f64 = 20.0;
/// The law stays as it is if it is more probable than this: a correction by chance would move the gates of right laws.
const TRUSTED: f64 = 0.7;

/// (3).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Excess {
    /// β and its probability; the first is 1.
    parts: Vec<(f64, f64)>,
    /// t, and q.
    from: f64,
    at: f64,
}

impl Excess {
    /// Returns the correction by the surprises of segments by laws of others, each with its run; `None` if there are
    /// too few, or if the law may be right. Of `skewed` segments a symmetric law is hardly right.
    pub(crate) fn of(surprises: &[(f64, usize)], skewed: bool) -> Option<Self> {
        let n = surprises.len();
        let k = ((TAIL * n as f64) as usize).max(FEWEST);
        if n < LEAST_ROWS || surprises.iter().any(|(s, _)| !s.is_finite()) {
            return None;
        }
        let mut sorted = surprises.to_vec();
        sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
        let from = sorted[k].0;
        let sum: f64 = sorted[..k].iter().map(|(s, _)| s - from).sum();
        let mut runs: Vec<usize> = sorted[..k].iter().map(|(_, run)| *run).collect();
        runs.sort_unstable();
        runs.dedup();
        if runs.len() < FEWEST_RUNS {
            return None;
        }
        let power = runs.len() as f64 / k as f64;
        let ln = |step: i32| {
            let beta = STEP.powi(step);
            let right = if skewed { RIGHT_IF_SKEWED } else { RIGHT };
            let before = if step == 0 { right } else { (1.0 - right) / f64::from(STEPS) };
            (before.ln() - power * (k as f64 * beta.ln() + sum / beta), beta)
        };
        let ln: Vec<(f64, f64)> = (0..=STEPS).map(ln).collect();
        let most = ln.iter().map(|(ln, _)| *ln).fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = ln.iter().map(|(ln, _)| (ln - most).exp()).sum();
        let parts: Vec<(f64, f64)> = ln.iter().map(|(ln, beta)| (*beta, (ln - most).exp() / total)).collect();
        let wrong = from > 0.0 && parts[0].1 < TRUSTED;
        wrong.then(|| Self { parts, from, at: -(k as f64 / (n as f64 + 1.0)).ln() })
    }

    /// Returns −ln of (3) for a surprise by the law.
    pub(crate) fn surprise(&self, s: f64) -> f64 {
        if s <= 0.0 {
            return s;
        }
        let beyond = s - self.from;
        let other = |beta: f64| match beyond {
            below if below < 0.0 => s * self.at / self.from,
            _ => self.at + beyond.min(FAR) / beta + (beyond - FAR).max(0.0),
        };
        // Relative to the most probable part, so that nothing underflows.
        let part = |(k, (beta, part)): (usize, &(f64, f64))| part.ln() - if k == 0 { s } else { other(*beta) };
        let all: Vec<f64> = self.parts.iter().enumerate().map(part).collect();
        let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        -most - all.iter().map(|ln| (ln - most).exp()).sum::<f64>().ln()
    }

    /// Returns the surprise by the law of a corrected one.
    pub(crate) fn by_law(&self, corrected: f64) -> f64 {
        if corrected <= 0.0 {
            return corrected;
        }
        let (mut low, mut high) = (0.0, 1.0);
        while self.surprise(high) < corrected {
            high *= 2.0;
        }
        // Halving to the rounding of a double.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.surprise(middle) < corrected { low = middle } else { high = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Exp1};

    use super::*;

    /// Surprises whose excess over ln 2 is `longer` times that of a right law; `alike` segments of a run are equal.
    fn drawn(longer: f64, alike: usize, seed: u64) -> Vec<(f64, usize)> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let from = std::f64::consts::LN_2;
        let value = |random: &mut ChaCha8Rng| -> f64 {
            let s: f64 = Exp1.sample(random);
            if s > from { from + longer * (s - from) } else { s }
        };
        (0..200 / alike).flat_map(|run| std::iter::repeat_n((value(&mut random), run), alike)).collect()
    }

    #[test]
    fn a_right_law_stays_and_a_wrong_one_is_corrected() {
        let corrected = |longer: f64, alike: usize| -> Vec<Excess> {
            (0..50).filter_map(|seed| Excess::of(&drawn(longer, alike, seed), false)).collect()
        };
        // A right law is less probable than 0.7 if its 30 excesses are a quarter too long, which one in ten is; equal
        // segments of a run are no further evidence.
        let [alone, alike] = [1, 4].map(|alike| corrected(1.0, alike).len());
        println!("{alone} and {alike} of 50 right laws are corrected");
        assert!(alone <= 10 && alike <= 10);
        let found = corrected(2.0, 1);
        assert!(found.len() >= 45, "{}", found.len());
        // One in a hundred has the surprise ln 2 + 2 ln 50; the standard deviation of one estimate is a fifth of it.
        let mean = found.iter().map(|own| own.by_law(100_f64.ln())).sum::<f64>() / found.len() as f64;
        let exact = 2_f64.ln() + 2.0 * 50_f64.ln();
        assert!((mean / exact - 1.0).abs() < 0.1, "{mean} for {exact}");
        let back = found[0].surprise(found[0].by_law(7.0));
        // The rounding of the exponential function.
        assert!((back - 7.0).abs() < 1e-9, "{back}");
    }

    #[test]
    fn few_segments_and_endless_surprises_are_not_judged() {
        assert_eq!(Excess::of(&drawn(3.0, 1, 1)[..LEAST_ROWS - 1], false), None);
        let mut endless = drawn(3.0, 1, 1);
        endless[3].0 = f64::INFINITY;
        assert_eq!(Excess::of(&endless, false), None);
    }
}
