//! Whether healthy segments depend on each other: those of one session are alike, or those that follow each other.
//!
//! ```text
//! F = Σ n_i (ȳ_i − ȳ)²/(k − 1) / [Σ (y_ij − ȳ_i)²/(N − k)]     k values of a column of the labels, N segments     (1)
//! r = Σ (y_j − ȳ)(y_{j+1} − ȳ)/Σ (y_j − ȳ)²,   r √N ~ N(0, 1)   if segments in their order are independent        (2)
//! ```
//!
//! y are the ranks of the values, so that a few segments that are far from all others do not count as dependence.
//!
//! A gate that takes such segments for independent has more false alarms than set. The segments of one value of the
//! column then count as a run, or so many neighbours that (2) has decayed to a twentieth.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal};

use crate::trace::labels::LabelledTrace;
use crate::train::FeatureTable;

/// Probability that any feature seems to depend if none does.
const LEVEL: f64 = 1e-3;
/// Decay of (2) within a run of neighbours.
const DECAYED: f64 = 0.05;

/// What healthy segments depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependence {
    /// The column of the labels; `None` if neighbours are alike.
    pub column: Option<String>,
    /// The feature that shows it best.
    pub feature: String,
    /// Share of its variance that is between runs, or (2).
    pub part: f64,
    /// Number of runs of healthy segments.
    pub runs: usize,
    /// The run of each trace.
    pub(crate) groups: Vec<String>,
}

impl Dependence {
    /// In words.
    #[must_use]
    pub fn line(&self) -> String {
        let Self { column, feature, part, runs, .. } = self;
        let percent = 100.0 * part;
        match column {
            Some(column) => format!(
                "healthy traces with the same {column} are alike ({percent:.0} % of the variance of {feature} is \
                 between the {runs} of them): the rate is that of the next {column}, as with --group {column}; --group \
                 none takes all traces for independent"
            ),
            None => format!(
                "healthy traces that follow each other are alike (correlation of {feature} {part:.2}): they count as \
                 {runs} runs; name the column of the labels that tells runs by --group, or --group none if all traces \
                 are independent"
            ),
        }
    }
}

/// A training set, as far as it is tested.
pub(crate) struct Set<'a> {
    /// All features of each segment.
    pub(crate) table: &'a FeatureTable,
    /// Their names.
    pub(crate) names: &'a [String],
    /// The trace of each segment.
    pub(crate) origins: &'a [usize],
    /// The traces.
    pub(crate) traces: &'a [LabelledTrace],
    /// The healthy class.
    pub(crate) healthy: usize,
}

/// Ranks of a feature of healthy segments in their order, with the trace of each.
type Values = Vec<(usize, f64)>;

/// Returns what healthy segments depend on, if it is significant; `features` are places among all.
pub(crate) fn of(own: &Set<'_>, features: &[usize], columns: &[(String, Vec<String>)]) -> Option<Dependence> {
    let Set { table, names, healthy, .. } = *own;
    let values = |&feature: &usize| -> Values {
        let of_row = |row: usize| (own.origins[row], table.rows[row][feature]);
        ranked(table.with(healthy, feature).map(of_row).collect())
    };
    let all: Vec<(usize, Values)> = features.iter().map(|feature| (*feature, values(feature))).collect();
    let level = LEVEL / (all.len() * (columns.len() + 1)).max(1) as f64;
    // Every class must have several runs, so that they can be held out.
    let told = columns.iter().filter(|(_, cells)| (0..table.names.len()).all(|class| several(own, cells, class)));
    let by_column = told.flat_map(|(column, cells)| {
        all.iter().filter_map(move |(feature, values)| {
            let (chance, part, runs) = between(values, cells)?;
            let (column, feature) = (Some(column.clone()), names[*feature].clone());
            Some((chance, Dependence { column, feature, part, runs, groups: cells.clone() }))
        })
    });
    let best = by_column.min_by(|(a, _), (b, _)| a.total_cmp(b));
    if let Some((_, found)) = best.filter(|(chance, _)| *chance < level) {
        return Some(found);
    }
    let in_order = |(feature, values): &(usize, Values)| {
        let (chance, correlation) = serial(values)?;
        Some((chance, correlation, *feature))
    };
    let best = all.iter().filter_map(in_order).min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, part, feature) = best.filter(|(chance, ..)| *chance < level)?;
    let traces: Vec<usize> = (0..own.traces.len()).filter(|&k| own.traces[k].class == healthy).collect();
    let length = (DECAYED.ln() / part.min(0.99).ln()).ceil().clamp(2.0, (traces.len() / 4).max(2) as f64) as usize;
    let mut groups: Vec<String> = own.traces.iter().map(|own| own.trace.id.clone()).collect();
    traces.iter().enumerate().for_each(|(place, &k)| groups[k] = format!("neighbours {}", place / length + 1));
    let runs = traces.len().div_ceil(length);
    Some(Dependence { column: None, feature: names[feature].clone(), part, runs, groups })
}

/// Ranks instead of values; equal values have the mean of their ranks.
fn ranked(values: Vec<(usize, f64)>) -> Values {
    let mut sorted: Vec<f64> = values.iter().map(|(_, value)| *value).collect();
    sorted.sort_by(f64::total_cmp);
    let rank = |value: f64| {
        let below = sorted.partition_point(|other| *other < value);
        let not_above = sorted.partition_point(|other| *other <= value);
        0.5 * (below + not_above) as f64
    };
    values.into_iter().map(|(trace, value)| (trace, rank(value))).collect()
}

/// Whether the traces of a class have several values of a column.
fn several(own: &Set<'_>, cells: &[String], class: usize) -> bool {
    let mut of_class = own.traces.iter().zip(cells).filter(|(own, _)| own.class == class).map(|(_, cell)| cell);
    let first = of_class.next();
    of_class.any(|cell| Some(cell) != first)
}

/// The probability of (1) without dependence, the share of the variance between runs, and their number.
fn between(values: &Values, cells: &[String]) -> Option<(f64, f64, usize)> {
    let mut runs: BTreeMap<&String, Vec<f64>> = BTreeMap::new();
    values.iter().for_each(|(trace, value)| runs.entry(&cells[*trace]).or_default().push(*value));
    let (n, k) = (values.len() as f64, runs.len() as f64);
    if runs.len() < 2 || n < 2.0 * k {
        return None;
    }
    let mean = values.iter().map(|(_, value)| value).sum::<f64>() / n;
    let (mut among, mut within) = (0.0, 0.0);
    for own in runs.values() {
        let middle = own.iter().sum::<f64>() / own.len() as f64;
        among += own.len() as f64 * (middle - mean).powi(2);
        within += own.iter().map(|value| (value - middle).powi(2)).sum::<f64>();
    }
    let (among, within) = (among / (k - 1.0), within / (n - k));
    let chance = FisherSnedecor::new(k - 1.0, n - k).ok()?.sf(among / within);
    let variance = ((among - within) / (n / k)).max(0.0);
    Some((chance, variance / (variance + within), runs.len()))
}

/// The probability of (2) without dependence, and (2).
fn serial(values: &Values) -> Option<(f64, f64)> {
    let n = values.len() as f64;
    if n < 20.0 {
        return None;
    }
    let mean = values.iter().map(|(_, value)| value).sum::<f64>() / n;
    let away: Vec<f64> = values.iter().map(|(_, value)| value - mean).collect();
    let square: f64 = away.iter().map(|x| x * x).sum();
    let r = away.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / square;
    (square > 0.0).then(|| (Normal::standard().sf(r * n.sqrt()), r))
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::trace::Trace;

    /// Tests 120 healthy segments of two features, of which the first is `drawn` by noise and number.
    fn found(mut drawn: impl FnMut(f64, usize) -> f64, seed: u64) -> Option<Dependence> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let rows: Vec<DVector<f64>> = (0..120)
            .map(|k| {
                let [a, b]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
                DVector::from_vec(vec![drawn(a, k), b])
            })
            .collect();
        let table = FeatureTable::exact(rows, vec![0; 120], vec!["healthy".into()]);
        let trace = |k: usize| Trace { id: k.to_string(), ..Trace::default() };
        let traces: Vec<LabelledTrace> = (0..120).map(|k| LabelledTrace { trace: trace(k), class: 0 }).collect();
        let (names, origins) = (["a", "b"].map(String::from), (0..120).collect::<Vec<_>>());
        // Not in the order of the segments, so that neighbours are not alike.
        let cells = (0..120).map(|k| (k % 12).to_string()).collect();
        let set = Set { table: &table, names: &names, origins: &origins, traces: &traces, healthy: 0 };
        of(&set, &[0, 1], &[("session".into(), cells)])
    }

    #[test]
    fn sessions_and_neighbours_are_told_and_outliers_are_neither() {
        let session = |k: usize| (f64::from(k as u32 % 12) - 5.5) / 3.5;
        let mut before = 0.0;
        for seed in 1..=20 {
            let own = found(|x, k| x + session(k), seed).expect("half of the variance is between sessions");
            assert_eq!((own.column.as_deref(), own.feature.as_str(), own.runs), (Some("session"), "a", 12));
            assert!((0.25..0.75).contains(&own.part), "{}", own.part);
            let own = found(
                |x, _| {
                    before = 0.7 * before + x;
                    before
                },
                seed,
            );
            let own = own.expect("neighbours are alike");
            assert_eq!((own.column, own.feature.as_str()), (None, "a"));
            // 0.7 ± 0.2 decays to a twentieth within 5 to 28 neighbours.
            assert!((4..=30).contains(&own.runs), "{}", own.runs);
            // Six neighbours are far from all others.
            assert_eq!(found(|x, k| if k < 6 { x + 20.0 } else { x }, seed), None);
            // One in a thousand in the mean.
            assert_eq!(found(|x, _| x, seed), None);
        }
    }
}
