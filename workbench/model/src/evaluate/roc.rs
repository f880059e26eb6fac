//! Scores of defect and healthy traces → the area under the ROC curve, within units and of all together.
//!
//! ```text
//! A   = P(x > y) + P(x = y)/2                          x of a defect, y healthy                              (1)
//! p_j = part of all y below x_j, q_k = part of all x above y_k, ties half;   A is the mean of either        (2)
//! P_i = Σ (p_j − A),  Q_i = Σ (q_k − A)                over the d_i defect and h_i healthy scores of unit i
//! S   = g₁/(g₁ − 1) Σ P_i²/d² + g₀/(g₀ − 1) Σ Q_i²/h² + 2 g/(g − 1) Σ P_i Q_i/(d h)                         (3)
//! A_w = mean of A_i over the g units with both,   S_w = variance of the A_i / g                              (4)
//! n*  = max(A (1 − A)/S · (z/t)²,  number of units)                                                          (5)
//! ```
//!
//! (1) is the statistic of Mann and Whitney. (3) is the variance of clustered data by Obuchowski (1997), for g₁ units
//! with a defect, g₀ with healthy scores and g of either; of units with one score it is that of DeLong (1988). The
//! interval is Wilson's with n* decisions, as that of a rate ([`Rate`]). A bootstrap over units, and (3) alone, have no
//! width if every unit separates its traces; then the number of units is left, which is the lesser of g₁ and g₀.
//!
//! Offsets between units lower the area of all together and leave (4) as it is. If units have one class each, the area
//! of all together contains their offsets, and (4) does not exist.

use std::collections::BTreeMap;

use super::Rate;

/// A score of a trace or segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scored {
    /// Place of its unit.
    pub unit: usize,
    /// Whether it is of the defect; otherwise it is healthy.
    pub defect: bool,
    /// Larger for a defect.
    pub score: f64,
}

/// Areas under the ROC curve of one score.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Areas {
    /// (4), if a unit has both.
    pub within: Option<Rate>,
    /// (1) of all together, if there are both.
    pub pooled: Option<Rate>,
    /// Number of units with both.
    pub units: usize,
    /// Places of the units with one of them only.
    pub of_one_class: Vec<usize>,
}

impl Areas {
    /// Of these scores.
    #[must_use]
    pub fn of(scored: &[Scored]) -> Self {
        let mut by_unit = BTreeMap::<usize, Vec<Scored>>::new();
        scored.iter().for_each(|one| by_unit.entry(one.unit).or_default().push(*one));
        let (both, single): (Vec<_>, Vec<_>) = by_unit.into_iter().partition(|(_, scored)| counts(scored).is_some());
        Self {
            within: within(&both.iter().filter_map(|(_, scored)| area(scored)).collect::<Vec<_>>()),
            pooled: pooled(scored),
            units: both.len(),
            of_one_class: single.into_iter().map(|(unit, _)| unit).collect(),
        }
    }
}

/// Number of scores of the defect and of healthy ones; `None` without both.
fn counts(scored: &[Scored]) -> Option<(f64, f64)> {
    let defects = scored.iter().filter(|one| one.defect).count();
    (0 < defects && defects < scored.len()).then(|| (defects as f64, (scored.len() - defects) as f64))
}

/// (2) of each score.
fn parts(scored: &[Scored], (defects, healthy): (f64, f64)) -> Vec<f64> {
    let scores = |of: Option<bool>| {
        let chosen = scored.iter().filter(|one| of.is_none_or(|defect| one.defect == defect));
        ranks(&chosen.map(|one| one.score).collect::<Vec<_>>())
    };
    let mut of_class = [false, true].map(|defect| scores(Some(defect)).into_iter());
    let part = |(one, rank): (&Scored, f64)| {
        // The rank among all less that among its class is the number of the other class below it, ties half.
        let below = rank - of_class[usize::from(one.defect)].next().unwrap_or(0.0);
        if one.defect { below / healthy } else { 1.0 - below / defects }
    };
    scored.iter().zip(scores(None)).map(part).collect()
}

/// (1).
fn area(scored: &[Scored]) -> Option<f64> {
    let of = counts(scored)?;
    let parts = parts(scored, of);
    Some(scored.iter().zip(parts).map(|(one, part)| if one.defect { part } else { 0.0 }).sum::<f64>() / of.0)
}

/// (4), (5).
fn within(areas: &[f64]) -> Option<Rate> {
    let count = areas.len() as f64;
    let mean = areas.iter().sum::<f64>() / count;
    let squares: f64 = areas.iter().map(|area| (area - mean).powi(2)).sum();
    (!areas.is_empty()).then(|| Rate::of_variance(mean, squares / (count - 1.0) / count, count))
}

/// (1), (3), (5).
fn pooled(scored: &[Scored]) -> Option<Rate> {
    let (defects, healthy) = counts(scored)?;
    let area = area(scored)?;
    // P_i and Q_i, where the unit has such scores.
    let mut sums = BTreeMap::<usize, [Option<f64>; 2]>::new();
    for (one, part) in scored.iter().zip(parts(scored, (defects, healthy))) {
        let sum = &mut sums.entry(one.unit).or_default()[usize::from(!one.defect)];
        *sum = Some(sum.unwrap_or(0.0) + part - area);
    }
    let corrected = |values: &[f64]| {
        let count = values.len() as f64;
        (count, count / (count - 1.0) * values.iter().sum::<f64>())
    };
    let of_class = |class: usize| {
        let squares = sums.values().filter_map(|sums| sums[class]).map(|sum| sum * sum);
        corrected(&squares.collect::<Vec<_>>())
    };
    let products = sums.values().map(|sums| sums[0].unwrap_or(0.0) * sums[1].unwrap_or(0.0));
    let (_, cross) = corrected(&products.collect::<Vec<_>>());
    let [(of_defect, p), (of_healthy, q)] = [of_class(0), of_class(1)];
    let variance = p / defects.powi(2) + q / healthy.powi(2) + 2.0 * cross / (defects * healthy);
    Some(Rate::of_variance(area, variance, of_defect.min(of_healthy)))
}

/// The rank of each value, from 0; equal values share the mean of their ranks.
pub(super) fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&one, &other| values[one].total_cmp(&values[other]));
    let mut out = vec![0.0; values.len()];
    let mut from = 0;
    for alike in order.chunk_by(|&one, &other| values[one].total_cmp(&values[other]).is_eq()) {
        let rank = from as f64 + (alike.len() - 1) as f64 / 2.0;
        alike.iter().for_each(|&place| out[place] = rank);
        from += alike.len();
    }
    out
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn scored(unit: usize, healthy: &[f64], defect: &[f64]) -> Vec<Scored> {
        let of = |defect: bool| move |score: &f64| Scored { unit, defect, score: *score };
        healthy.iter().map(of(false)).chain(defect.iter().map(of(true))).collect()
    }

    #[test]
    fn equal_values_share_their_rank() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 0.0]), [2.5, 1.0, 2.5, 0.0]);
    }

    /// Of 3 · 3 pairs, 2 above none, 3 above one and equal to one, 5 above all three: (0 + 1.5 + 3)/9.
    #[test]
    fn ties_count_half() {
        let all = scored(0, &[2.5, 3.0, 4.0], &[2.0, 3.0, 5.0]);
        let parts = parts(&all, (3.0, 3.0));
        assert_eq!(parts.iter().map(|part| (6.0 * part).round() as i32).collect::<Vec<_>>(), [4, 3, 2, 0, 3, 6]);
        let areas = Areas::of(&all);
        assert!((areas.pooled.expect("both").value - 0.5).abs() < 1e-12, "{areas:?}");
        // One unit says little of others: it counts as one decision.
        assert_eq!(areas.within, Some(Rate::wilson_of(0.5, 1.0)));
    }

    /// Two units whose levels differ by more than the defect: each separates all of its pairs, and of all together the
    /// four pairs across the units that are the wrong way round, of 16, are lost.
    #[test]
    fn an_offset_between_units_is_no_loss_within_them() {
        let all = [scored(0, &[1.0, 2.0], &[3.0, 4.0]), scored(1, &[11.0, 12.0], &[13.0, 14.0])].concat();
        let areas = Areas::of(&all);
        let (within, pooled) = (areas.within.expect("both"), areas.pooled.expect("both"));
        assert_eq!((within, areas.units), (Rate::wilson(2, 2), 2));
        assert!((pooled.value - 0.75).abs() < 1e-12, "{pooled:?}");
    }

    /// Areas 1, 1, 1 and 0.5: mean 0.875 and variance 0.0625/4 of the mean.
    #[test]
    fn the_interval_within_units_has_the_spread_of_their_areas() {
        let apart = |unit| scored(unit, &[1.0], &[2.0]);
        let areas = Areas::of(&[apart(0), apart(1), apart(2), scored(3, &[1.0], &[1.0])].concat());
        assert_eq!(areas.within, Some(Rate::of_variance(0.875, 0.0625 / 4.0, 4.0)));
        // n* = 0.875 · 0.125/0.015625 · (z/t)² = 2.655 is below the number of units.
        assert_eq!(areas.within, Some(Rate::wilson_of(3.5, 4.0)));
        let twelve = (0..12).flat_map(|unit| scored(unit, &[1.0, 3.0], &[2.0, if unit < 6 { 4.0 } else { 0.0 }]));
        let areas = Areas::of(&twelve.collect::<Vec<_>>()).within.expect("both");
        // Six of 0.75 and six of 0.25: variance 0.75/11/12, t of 11 degrees 2.200985.
        let count = 0.25 / (0.75 / 11.0 / 12.0) * (1.959_963_984_54_f64 / 2.200_985_160).powi(2);
        let Rate { low, high, .. } = Rate::wilson_of(0.5 * count, count);
        assert!((areas.low - low).abs() < 1e-8 && (areas.high - high).abs() < 1e-8, "{areas:?}");
    }

    #[test]
    fn units_of_one_class_are_named_and_only_count_together() {
        let all = [scored(4, &[1.0, 2.0], &[]), scored(7, &[], &[3.0]), scored(5, &[1.0], &[0.0, 4.0])].concat();
        let areas = Areas::of(&all);
        assert_eq!((areas.units, areas.of_one_class.as_slice()), (1, &[4, 7][..]));
        // (0 + 3 + 3)/9 of all pairs.
        assert!((areas.pooled.expect("both").value - 6.0 / 9.0).abs() < 1e-12, "{areas:?}");
        let apart = [scored(4, &[1.0, 2.0], &[]), scored(7, &[], &[3.0])].concat();
        assert_eq!(Areas::of(&apart).within, None);
        assert_eq!(Areas::of(&scored(4, &[1.0, 2.0], &[])).pooled, None);
    }

    /// DeLong, DeLong and Clarke-Pearson 1988, by hand: x = 1, 3, 5 and y = 0, 2, 4 have p = 1/3, 2/3, 1 and
    /// q = 1, 2/3, 1/3; each class has the variance 1/9 and three values: S = 2 · (1/9)/3.
    #[test]
    fn scores_of_single_units_have_the_variance_of_delong() {
        let scored_one = |k: usize, defect: bool, score: f64| Scored { unit: k, defect, score };
        let all: Vec<Scored> = (0..6).map(|k| scored_one(k, k % 2 == 1, k as f64)).collect();
        let area: f64 = 2.0 / 3.0;
        assert_eq!(Areas::of(&all).pooled, Some(Rate::of_variance(area, 2.0 / 27.0, 3.0)));
    }

    /// Units of one class each, whose levels differ: intervals that count units contain the area as often as they say,
    /// those of independent scores do not.
    #[test]
    fn the_interval_of_all_together_counts_units() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut uniform = |width: f64| width * (rng.random::<f64>() + rng.random::<f64>() - 1.0);
        let mut draw = |units: usize| {
            let of_unit = |unit: usize| {
                let level = uniform(1.0) + 0.3 * (unit % 2) as f64;
                let scores: Vec<f64> = (0..8).map(|_| level + uniform(1.0)).collect();
                if unit.is_multiple_of(2) { scored(unit, &scores, &[]) } else { scored(unit, &[], &scores) }
            };
            (0..units).flat_map(of_unit).collect::<Vec<_>>()
        };
        let truth = area(&draw(4000)).expect("both");
        let (mut covered, mut apart, draws) = (0, 0, 400);
        for _ in 0..draws {
            let all = draw(24);
            let holds = |rate_of: Option<Rate>| rate_of.is_some_and(|rate| (rate.low..=rate.high).contains(&truth));
            covered += usize::from(holds(pooled(&all)));
            let single = all.iter().enumerate().map(|(unit, one)| Scored { unit, ..*one });
            apart += usize::from(holds(pooled(&single.collect::<Vec<_>>())));
        }
        // Standard deviation of the share at 95 %: 1.1 %. Too wide an interval fails too.
        let share = |count: usize| count as f64 / f64::from(draws);
        assert!((0.92..0.985).contains(&share(covered)), "{}", share(covered));
        assert!(share(apart) < 0.8, "{}", share(apart));
    }
}
