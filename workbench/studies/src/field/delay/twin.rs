//! The alarm by directions in double precision, written apart from the core's.
//!
//! ```text
//! run        N ← N + ω,  Y ← Y + ω y,   ω = 1/(1 + v/W);   x = Y/N,   s² = P + W/N,   P as in (7)         (1)
//! reference  û = Q/Λ,  r = û + q/√Λ;   at first Λ = 1/U,  Q = c/U                                        (2)
//! score      a = δ s₀/s,  s₀² = P + W/n₀,   ζ = (x − r − ρ b′)/s,   z = WH(ζ; γ),   ℓ = min(a z − a²/2, cap)  (3)
//! sequence   T = max(S, ln min(n, n₀)) + ℓ  after each record,   S ← max(0, T)  at the end of the run    (4)
//! alarm      where T ≥ limit, at the end of a run or after n₀ records; names the largest T, an order with
//!            T ≥ limit/2 before friction                                                                 (5)
//! learning   at the end of a run, while m < M and T is below half of the limit: Λ ← Λ + h²/s²,  Q ← Q + h y/s²  (6)
//! offset     b = ρ b′ + (P/s) min(max(ζ, −4), 4),   P′ ← P (1 − P/s²);   y − h r = x − r − ρ b′ for any r      (7)
//! ```
//!
//! WH is the normal score of a value of skewness γ (Wilson and Hilferty 1931).

use model::train::Watch as Constants;
use model::train::directions::{BETS, Direction, Directions, MARGIN, MOST_RUNS};

/// Values of a smaller skewness are their own scores.
const NORMAL: f64 = 0.05;

/// Value and excess variance of each direction in a record; `None` where a coordinate is missing.
pub(super) type Record = Vec<Option<[f64; 2]>>;

/// State of the alarm.
#[derive(Clone, Debug)]
pub(super) struct Twin<'a> {
    constants: &'a Directions,
    limit: f64,
    cap: f64,
    states: Vec<State>,
    /// Records of the run.
    run: f64,
    learned: u16,
}

#[derive(Clone, Copy, Debug)]
struct State {
    /// N, Y.
    weight: f64,
    sum: f64,
    /// Λ, Q.
    precision: f64,
    weighted: f64,
    /// b′ = α − c r, and P′ of (7).
    offset: [f64; 2],
    variance: f64,
    /// S and T of each bet.
    kept: [f64; BETS.len()],
    now: [f64; BETS.len()],
}

impl<'a> Twin<'a> {
    /// Of a drive that is not yet known; `None` if training chose no directions.
    pub(super) fn new(constants: &'a Constants) -> Option<Self> {
        let directions = constants.directions.as_ref()?;
        let state = |direction: &Direction| {
            let precision = 1.0 / direction.levels.between;
            let none = [0.0; BETS.len()];
            State {
                weight: 0.0,
                sum: 0.0,
                precision,
                weighted: direction.levels.centre * precision,
                offset: [0.0; 2],
                variance: direction.levels.run,
                kept: none,
                now: none,
            }
        };
        Some(Self {
            constants: directions,
            limit: f64::from(constants.evidence.limit),
            cap: f64::from(constants.evidence.cap),
            states: directions.list.iter().map(state).collect(),
            run: 0.0,
            learned: 0,
        })
    }

    /// Takes the records of a run, and ends it; gives the direction that raises an alarm.
    pub(super) fn run(&mut self, records: &[Record]) -> Option<usize> {
        let mut raised = None;
        for (record, count) in records.iter().zip(1..) {
            let (highest, place) = self.observe(record);
            let looks = count == records.len() || self.run >= self.constants.usual;
            raised = raised.or((looks && highest >= self.limit).then_some(place));
        }
        self.end_run();
        raised
    }

    /// The highest score, and the direction that an alarm names.
    fn observe(&mut self, record: &Record) -> (f64, usize) {
        self.run += 1.0;
        let usual = self.constants.usual;
        let floor = self.run.min(usual).ln();
        let (mut highest, mut named) = (f64::NEG_INFINITY, (0, (false, f64::NEG_INFINITY, 0.0)));
        for (place, (state, (direction, value))) in
            self.states.iter_mut().zip(self.constants.list.iter().zip(record)).enumerate()
        {
            if let Some([y, v]) = value {
                let weight = 1.0 / (1.0 + v / direction.levels.record);
                (state.weight, state.sum) = (state.weight + weight, state.sum + weight * y);
            }
            let ratios = state.ratios(direction, usual);
            for (k, ratio) in ratios.into_iter().enumerate() {
                state.now[k] = state.kept[k].max(floor) + ratio.min(self.cap);
            }
            let top = state.now.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            highest = highest.max(top);
            // Scores at the cap are equal, but for rounding.
            let rounded = (top * 1e4).round();
            let rank = (direction.order && top >= 0.5 * self.limit, rounded, state.deviations(direction));
            if rank > named.1 {
                named = (place, rank);
            }
        }
        (highest, named.0)
    }

    fn end_run(&mut self) {
        let highest = self.states.iter().flat_map(|state| state.now).fold(0.0, f64::max);
        let learns = self.learned < MOST_RUNS && highest < 0.5 * self.limit;
        for (state, direction) in self.states.iter_mut().zip(&self.constants.list) {
            state.end_run(direction, learns);
            (state.weight, state.sum, state.kept) = (0.0, 0.0, state.now.map(|now| now.max(0.0)));
        }
        self.learned += u16::from(learns);
        self.run = 0.0;
    }
}

impl State {
    fn reference(&self) -> f64 {
        self.weighted / self.precision + MARGIN / self.precision.sqrt()
    }

    /// y and h of (7), and P of (1).
    fn news(&self, direction: &Direction) -> ([f64; 2], f64) {
        let rho = direction.levels.correlation.unwrap_or(0.0);
        let [a, c] = self.offset.map(|of| rho * of);
        let variance = rho * rho * self.variance + (1.0 - rho * rho) * direction.levels.run;
        ([self.sum / self.weight - a, 1.0 - c], variance)
    }

    fn end_run(&mut self, direction: &Direction, learns: bool) {
        if self.weight <= 0.0 {
            return;
        }
        let ([y, h], of_offset) = self.news(direction);
        let variance = of_offset + direction.levels.record / self.weight;
        let rest = (y - h * self.reference()).clamp(-4.0 * variance.sqrt(), 4.0 * variance.sqrt());
        let rho = direction.levels.correlation.unwrap_or(0.0);
        let gain = of_offset / variance;
        self.offset = [rho * self.offset[0] + gain * (rest + h * self.reference()), rho * self.offset[1] + gain * h];
        self.variance = of_offset * (1.0 - gain);
        if learns {
            self.precision += h * h / variance;
            self.weighted += h * y / variance;
        }
    }

    /// (x − û)/s, which decides between directions of the same score.
    fn deviations(&self, direction: &Direction) -> f64 {
        if self.weight <= 0.0 {
            return 0.0;
        }
        let variance = direction.levels.run + direction.levels.record / self.weight;
        (self.sum / self.weight - self.weighted / self.precision) / variance.sqrt()
    }

    /// (3) of each bet without the cap.
    fn ratios(&self, direction: &Direction, usual: f64) -> [f64; BETS.len()] {
        if self.weight <= 0.0 {
            return [0.0; BETS.len()];
        }
        let levels = &direction.levels;
        let (news, of_offset) = self.news(direction);
        let variance = of_offset + levels.record / self.weight;
        let z = normal_score((news[0] - news[1] * self.reference()) / variance.sqrt(), levels.skewness);
        let scale = ((of_offset + levels.record / usual) / variance).sqrt();
        BETS.map(|bet| bet * scale * z - (bet * scale).powi(2) / 2.0)
    }
}

fn normal_score(t: f64, skewness: f64) -> f64 {
    if skewness < NORMAL {
        return t;
    }
    6.0 / skewness * ((1.0 + skewness * t / 2.0).max(0.0).cbrt() - 1.0) + skewness / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_of_skewed_values_are_normal() {
        // No skewness: t itself; little of it changes little. An exponential distribution has γ = 2: its mean and one
        // deviation beyond it have the normal scores of 1 − 1/e and 1 − 1/e².
        assert!(normal_score(1.7, 0.01) == 1.7 && (normal_score(1.7, 0.06) - 1.7).abs() < 0.03);
        assert!((normal_score(0.0, 2.0) - 0.337).abs() < 0.02);
        assert!((normal_score(1.0, 2.0) - 1.102).abs() < 0.05);
    }
}
