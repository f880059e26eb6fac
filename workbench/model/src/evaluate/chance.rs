//! Comparison with chance by exchanging labels, and negative controls.
//!
//! ```text
//! p = (1 + number of exchanges whose statistic is at least the observed one)/(1 + number of exchanges)
//! ```
//!
//! Labels may be exchanged where nothing would change if they meant nothing. Traces of one run are alike, so that runs
//! of one label each exchange the labels of whole runs; if runs contain several labels, labels are exchanged within
//! each run. Without runs, traces exchange theirs.
//!
//! A negative control is a column of the labels that is unrelated to the bearing: session, day, operator. The statistic
//! is the part of the variance of the ranks of the verdicts' scores, over healthy traces, that the column's values
//! explain (η²). A small p means that the model answers to the session too, and that its rates are those of these
//! sessions.

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use super::judged::numbered;
use super::roc::ranks;
use super::{Judged, TraceVerdict};

/// Exchanges of the labels.
const EXCHANGES: usize = 9999;

/// How labels are exchanged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// Places of the labels of each group.
    groups: Vec<Vec<usize>>,
    /// Whether groups of one label each exchange theirs; otherwise labels are exchanged within groups.
    whole: bool,
}

impl Exchange {
    /// The exchange that suits these labels and the names of their groups.
    #[must_use]
    pub fn new(labels: &[usize], names: Option<&[String]>) -> Self {
        let (of, count) = names.map_or_else(|| ((0..labels.len()).collect(), labels.len()), numbered);
        let mut groups = vec![vec![]; count];
        of.iter().enumerate().for_each(|(place, group)| groups[*group].push(place));
        let whole = groups.iter().all(|places| places.iter().all(|&place| labels[place] == labels[places[0]]));
        Self { groups, whole }
    }

    /// What is exchanged.
    #[must_use]
    pub fn words(&self) -> &'static str {
        match (self.whole, self.groups.iter().all(|places| places.len() == 1)) {
            (true, true) => "of single traces",
            (true, false) => "of whole runs",
            (false, _) => "within runs",
        }
    }

    fn exchanged(&self, labels: &[usize], rng: &mut ChaCha8Rng) -> Vec<usize> {
        let mut out = labels.to_vec();
        if self.whole {
            let mut of_group: Vec<usize> = self.groups.iter().map(|places| labels[places[0]]).collect();
            of_group.shuffle(rng);
            for (places, label) in self.groups.iter().zip(of_group) {
                places.iter().for_each(|&place| out[place] = label);
            }
        } else {
            for places in &self.groups {
                let mut own: Vec<usize> = places.iter().map(|&place| labels[place]).collect();
                own.shuffle(rng);
                places.iter().zip(own).for_each(|(&place, label)| out[place] = label);
            }
        }
        out
    }

    /// p of a statistic that is larger the more the labels mean.
    pub(crate) fn p_value(&self, labels: &[usize], statistic: impl Fn(&[usize]) -> f64) -> f64 {
        // Sums in another order may differ by rounding.
        let observed = statistic(labels) - 1e-12;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let reached = (0..EXCHANGES).filter(|_| statistic(&self.exchanged(labels, &mut rng)) >= observed).count();
        (1 + reached) as f64 / (1 + EXCHANGES) as f64
    }
}

/// The balanced accuracy beside that of labels that mean nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Chance {
    /// Balanced accuracy of guesses: one divided by the number of classes.
    pub level: f64,
    /// Probability of the observed balanced accuracy or a better one if labels mean nothing.
    pub p: f64,
    /// What was exchanged.
    pub exchanged: &'static str,
}

impl Chance {
    /// `None` with fewer than two trained classes among the traces.
    #[must_use]
    pub fn of(judged: &Judged<'_>) -> Option<Self> {
        let places: Vec<usize> =
            (0..judged.verdicts.len()).filter(|&k| judged.verdicts[k].class < judged.trained).collect();
        let labels: Vec<usize> = places.iter().map(|&k| judged.verdicts[k].class).collect();
        let groups = judged.groups.map(|names| places.iter().map(|&k| names[k].clone()).collect::<Vec<_>>());
        let decided: Vec<Vec<Option<usize>>> = places
            .iter()
            .map(|&k| judged.verdicts[k].findings(judged.per_segment))
            .map(|findings| findings.into_iter().map(|finding| finding.and_then(crate::core::Finding::class)).collect())
            .collect();
        let balanced = |labels: &[usize]| {
            let mut counts = vec![(0.0, 0.0); judged.trained];
            for (&label, decided) in labels.iter().zip(&decided) {
                counts[label].0 += decided.iter().filter(|class| **class == Some(label)).count() as f64;
                counts[label].1 += decided.len() as f64;
            }
            let recalls: Vec<f64> = counts.iter().filter(|count| count.1 > 0.0).map(|(k, n)| k / n).collect();
            recalls.iter().sum::<f64>() / recalls.len() as f64
        };
        let classes = (0..judged.trained).filter(|class| labels.contains(class)).count();
        if classes < 2 {
            return None;
        }
        let exchange = Exchange::new(&labels, groups.as_deref());
        let p = exchange.p_value(&labels, balanced);
        Some(Self { level: 1.0 / classes as f64, p, exchanged: exchange.words() })
    }

    /// JSON object with the keys `level`, `p`, `exchanged`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        json!({ "level": self.level, "p": self.p, "exchanged": self.exchanged })
    }
}

impl std::fmt::Display for Chance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let level = 100.0 * self.level;
        write!(f, "balanced accuracy of guesses {level:.1} %; p = {:.4} by labels exchanged {}", self.p, self.exchanged)
    }
}

/// A negative control: how much of the verdicts a column that is unrelated to the bearing explains.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// The column.
    pub column: String,
    /// Number of its values among the healthy traces.
    pub values: usize,
    /// Part of the variance of the ranked scores between the values, and its p; `None` with a single value, or with one
    /// for each run.
    pub found: Option<(f64, f64)>,
    /// What was exchanged.
    pub exchanged: &'static str,
}

impl Control {
    /// Judges the healthy traces, or all traces of a model without a healthy class; `cells` are those of the column.
    #[must_use]
    pub fn of(judged: &Judged<'_>, column: &str, cells: &[String]) -> Self {
        let is_used = |k: &usize| judged.healthy.is_none_or(|healthy| judged.verdicts[*k].class == healthy);
        let places: Vec<usize> = (0..judged.verdicts.len()).filter(is_used).collect();
        let pick = |all: &[String]| places.iter().map(|&k| all[k].clone()).collect::<Vec<_>>();
        let (labels, values) = numbered(&pick(cells));
        let groups = judged.groups.map(pick);
        let exchange = Exchange::new(&labels, groups.as_deref());
        let ranks = ranks(&places.iter().map(|&k| score(&judged.verdicts[k])).collect::<Vec<_>>());
        // If each run has a value of its own, every exchange explains as much.
        let found = (values > 1 && (values < exchange.groups.len() || !exchange.whole)).then(|| {
            let explained = |labels: &[usize]| explained(&ranks, labels, values);
            (explained(&labels), exchange.p_value(&labels, explained))
        });
        Self { column: column.into(), values, found, exchanged: exchange.words() }
    }

    /// JSON object with the keys `column`, `values`, `explained`, `p`, `exchanged`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let (explained, p) = self.found.unzip();
        let Self { column, values, exchanged, .. } = self;
        json!({ "column": column, "values": values, "explained": explained, "p": p, "exchanged": exchanged })
    }
}

impl std::fmt::Display for Control {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { column, values, exchanged, .. } = self;
        let Some((explained, p)) = self.found else {
            let reason = if *values > 1 { "every run has a value of its own" } else { "one value only" };
            return write!(f, "control {column}: {reason}, nothing to compare");
        };
        let part = 100.0 * explained;
        write!(f, "control {column}: its {values} values explain {part:.1} % of the scores; p = {p:.4} by values ")?;
        write!(f, "exchanged {exchanged}")?;
        if p < 0.05 { f.write_str(": the model answers to it too") } else { Ok(()) }
    }
}

/// Mean surprise of the segments of a trace; without a healthy class, how little its own class is believed.
fn score(verdict: &TraceVerdict) -> f64 {
    let decided = verdict.segments.iter().filter(|segment| segment.verdict.is_ok());
    let surprises: Vec<f64> = decided.map(|segment| f64::from(segment.surprise)).collect();
    if surprises.iter().any(|surprise| *surprise > 0.0) {
        return surprises.iter().sum::<f64>() / surprises.len() as f64;
    }
    1.0 - verdict.posteriors.get(verdict.class).map_or(0.0, |p| f64::from(*p))
}

/// η²: the sum of squares between the labels as a part of the whole one.
fn explained(values: &[f64], labels: &[usize], count: usize) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let mut sums = vec![(0.0, 0.0); count];
    for (value, &label) in values.iter().zip(labels) {
        sums[label].0 += value - mean;
        sums[label].1 += 1.0;
    }
    let between: f64 = sums.iter().filter(|sum| sum.1 > 0.0).map(|(sum, n)| sum * sum / n).sum();
    let whole: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    if whole > 0.0 { between / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(numbers: &[usize]) -> Vec<String> {
        numbers.iter().map(ToString::to_string).collect()
    }

    /// Three of three heads among six: 1 of 20 arrangements is as good, in both directions together 2.
    #[test]
    fn p_is_the_share_of_arrangements() {
        let labels = [0, 0, 0, 1, 1, 1];
        let exchange = Exchange::new(&labels, None);
        let p = exchange.p_value(&labels, |own| explained(&[1.0, 2.0, 3.0, 7.0, 8.0, 9.0], own, 2));
        // Standard deviation of the share of 9999 draws: 0.003.
        assert!((p - 0.1).abs() < 0.012, "{p}");
    }

    #[test]
    fn whole_runs_exchange_their_label_and_mixed_ones_exchange_within() {
        let labels = [0, 0, 1, 1, 0, 0];
        let whole = Exchange::new(&labels, Some(&names(&[1, 1, 2, 2, 3, 3])));
        assert_eq!(whole.words(), "of whole runs");
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..20 {
            let own = whole.exchanged(&labels, &mut rng);
            assert!(own.chunks(2).all(|pair| pair[0] == pair[1]) && own.iter().sum::<usize>() == 2, "{own:?}");
        }
        let mixed = Exchange::new(&labels, Some(&names(&[1, 2, 1, 2, 3, 3])));
        assert_eq!(mixed.words(), "within runs");
        assert!((0..20).all(|_| mixed.exchanged(&labels, &mut rng)[4..] == [0, 0]));
        // Six traces in three runs of one label: even perfect separation has p = 1/3.
        let p = whole.p_value(&labels, |own| explained(&[1.0, 1.0, 9.0, 9.0, 1.0, 1.0], own, 2));
        assert!((p - 1.0 / 3.0).abs() < 0.02, "{p}");
    }

    #[test]
    fn what_no_exchange_reaches_has_a_p_above_zero() {
        // 1 of 184756 arrangements is as good.
        let labels: Vec<usize> = (0..20).map(|k| k / 10).collect();
        let p = Exchange::new(&labels, None).p_value(&labels, |own| own[..10].iter().map(|x| 1.0 - *x as f64).sum());
        assert!(p > 0.0 && p < 4e-4, "{p}");
    }

    #[test]
    fn a_value_for_each_run_is_not_compared() {
        let verdict = |k: usize| TraceVerdict {
            id: k.to_string(),
            class: 0,
            decided: Some(crate::core::Finding::Class(0)),
            posteriors: vec![0.9 - 0.1 * (k / 4) as f32],
            segments: vec![],
        };
        let (verdicts, classes): (Vec<_>, _) = ((0..12).map(verdict).collect(), vec!["healthy".to_string()]);
        let runs = names(&(0..12).map(|k| k / 2).collect::<Vec<_>>());
        let groups = Some(&runs[..]);
        let judged =
            Judged { verdicts: &verdicts, classes: &classes, trained: 1, healthy: Some(0), groups, per_segment: false };
        assert_eq!(Control::of(&judged, "run", &runs).found, None);
        // Two runs of each day: the scores are those of the days. 90 arrangements of three pairs, 6 of them the same.
        let days = names(&(0..12).map(|k| k / 4).collect::<Vec<_>>());
        let (explained, p) = Control::of(&judged, "day", &days).found.expect("three days");
        assert!((explained - 1.0).abs() < 1e-12 && (p - 6.0 / 90.0).abs() < 0.012, "{explained} {p}");
    }
}
