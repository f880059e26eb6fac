//! Features over runs: how alike the segments of a run are, and whether runs drift.
//!
//! ```text
//! ICC = (B − W)/(B + (n₀ − 1) W),   n₀ = (N − Σ n_i²/N)/(g − 1)                 (1)
//! B, W: mean squares between and within the g runs of n_i values, N = Σ n_i
//! [ICC]: B/W divided by the 97.5 and 2.5 % quantiles of F(g − 1, N − g)          (2)  Searle 1971
//! drift = slope of the runs' means over their order / √W,  t with g − 2          (3)
//! ```
//!
//! ICC is 0 if the values of a run are no more alike than those of different runs, and 1 if all values of a run are
//! equal: then the number of runs counts, not that of segments.

use serde_json::{Value, json};
use statrs::distribution::{ContinuousCDF as _, FisherSnedecor, StudentsT};

use super::Rate;
use super::judged::numbered;

/// One feature over runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// Name of the feature.
    pub feature: String,
    /// Number of runs.
    pub runs: usize,
    /// (1) with (2).
    pub icc: Rate,
    /// (3): change from run to run in standard deviations within a run.
    pub drift: f64,
    /// Probability of such a drift, in either direction, if runs do not drift.
    pub p: f64,
}

/// Returns the stability of each feature that has values in at least three runs, some of several values. `rows` are the
/// values of all features of a segment, `None` for a missing one; `runs` names the run of each, in their order.
#[must_use]
pub fn stability(names: &[String], rows: &[Vec<Option<f64>>], runs: &[String]) -> Vec<Stability> {
    let (places, count) = numbered(runs);
    let one = |(feature, name): (usize, &String)| {
        let mut values = vec![vec![]; count];
        for (row, &run) in rows.iter().zip(&places) {
            values[run].extend(row.get(feature).copied().flatten());
        }
        values.retain(|own: &Vec<f64>| !own.is_empty());
        of(name, &values)
    };
    names.iter().enumerate().filter_map(one).collect()
}

fn of(name: &str, values: &[Vec<f64>]) -> Option<Stability> {
    let (g, n) = (values.len() as f64, values.iter().map(Vec::len).sum::<usize>() as f64);
    if values.len() < 3 || n <= g {
        return None;
    }
    let means: Vec<f64> = values.iter().map(|own| own.iter().sum::<f64>() / own.len() as f64).collect();
    let grand = values.iter().flatten().sum::<f64>() / n;
    let counts = || values.iter().map(|own| own.len() as f64);
    let between = counts().zip(&means).map(|(n, mean)| n * (mean - grand).powi(2)).sum::<f64>() / (g - 1.0);
    let squares = values.iter().zip(&means).flat_map(|(own, mean)| own.iter().map(move |x| (x - mean).powi(2)));
    let within = squares.sum::<f64>() / (n - g);
    if within.is_nan() || within <= 0.0 {
        return None;
    }
    let each = (n - counts().map(|n| n * n).sum::<f64>() / n) / (g - 1.0);
    let icc = |ratio: f64| ((ratio - 1.0) / (ratio + each - 1.0)).clamp(0.0, 1.0);
    let (ratio, law) = (between / within, FisherSnedecor::new(g - 1.0, n - g).ok()?);
    let [high, low] = [0.025, 0.975].map(|p| icc(ratio / law.inverse_cdf(p)));
    let icc = Rate { value: icc(ratio), low, high };

    let middle = (g - 1.0) / 2.0;
    let moment: f64 = (0..values.len()).map(|k| (k as f64 - middle).powi(2)).sum();
    let mean_of_means = means.iter().sum::<f64>() / g;
    let slope = means.iter().enumerate().map(|(k, mean)| (k as f64 - middle) * mean).sum::<f64>() / moment;
    let rest = means.iter().enumerate().map(|(k, mean)| (mean - mean_of_means - slope * (k as f64 - middle)).powi(2));
    let error = (rest.sum::<f64>() / (g - 2.0) / moment).sqrt();
    let student = StudentsT::new(0.0, 1.0, g - 2.0).ok()?;
    let p = if error > 0.0 { 2.0 * student.sf((slope / error).abs()) } else { f64::from(u8::from(slope == 0.0)) };
    Some(Stability { feature: name.into(), runs: values.len(), icc, drift: slope / within.sqrt(), p })
}

impl Stability {
    /// JSON object with the keys `feature`, `runs`, `icc`, `drift_per_run_sd`, `p`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Self { feature, runs, icc, drift, p } = self;
        json!({ "feature": feature, "runs": runs, "icc": icc.to_json(), "drift_per_run_sd": drift, "p": p })
    }
}

impl std::fmt::Display for Stability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { feature, icc: Rate { value, low, high }, drift, p, .. } = self;
        write!(f, "{feature:20} {value:.2} [{low:.2}, {high:.2}]  {drift:+8.2}  {p:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shrout and Fleiss 1979, table 2: six targets, four judges; ICC(1) = 0.17, F = 1.79, interval [−0.13, 0.72].
    #[test]
    fn icc_against_published_values() {
        let table: [[u8; 4]; 6] = [[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7]];
        let values: Vec<Vec<f64>> = table.iter().map(|row| row.iter().map(|x| f64::from(*x)).collect()).collect();
        let found = of("x", &values).expect("six runs");
        assert!((found.icc.value - 0.166).abs() < 5e-4, "{found:?}");
        assert!(found.icc.low == 0.0 && (found.icc.high - 0.7226).abs() < 5e-4, "{found:?}");
    }

    /// SciPy: linregress(range(4), [1, 2, 2, 4]) has the slope 0.9 and p = 0.0766.
    #[test]
    fn drift_is_the_slope_of_the_means() {
        let values = [1.0, 2.0, 2.0, 4.0].map(|mean: f64| vec![mean - 0.5, mean + 0.5]);
        let found = of("x", &values).expect("four runs");
        // W = 0.5.
        assert!((found.drift - 0.9 / 0.5_f64.sqrt()).abs() < 1e-9, "{found:?}");
        assert!((found.p - 0.0766).abs() < 5e-4, "{found:?}");
    }

    #[test]
    fn missing_values_and_few_runs_are_left_out() {
        let (names, runs) = (["a".to_string(), "b".into()], ["1", "1", "2", "2", "3"].map(String::from));
        let rows: Vec<Vec<Option<f64>>> =
            [1.0, 2.0, 1.5, 2.5, 1.2].iter().map(|x| vec![Some(*x), (*x < 2.0).then_some(*x)]).collect();
        let found = stability(&names, &rows, &runs);
        assert_eq!(found.iter().map(|one| one.feature.as_str()).collect::<Vec<_>>(), ["a"]);
    }
}
