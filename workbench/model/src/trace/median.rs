//! The median of a list.

use std::borrow::Cow;

use rayon::prelude::*;

/// Lists from this length are likely to be worth a guess.
const LONG: usize = 1 << 14;
/// Values of a long list from which its median is guessed.
const FEW: usize = 1 << 10;

/// The median, of an even number of values the larger of the middle two; NaN of an empty list.
#[must_use]
pub fn median<'a>(values: impl Into<Cow<'a, [f64]>>) -> f64 {
    let mut values = values.into();
    let middle = values.len() / 2;
    if values.len() >= LONG {
        // Most of the steps of a time column are equal, so that one of them is often the median.
        let few: Vec<f64> = values.iter().copied().step_by(values.len() / FEW).collect();
        let guess = selected(few);
        let count = |[less, equal, more]: [usize; 3], value: &f64| {
            [
                less + usize::from(*value < guess),
                equal + usize::from(*value == guess),
                more + usize::from(*value > guess),
            ]
        };
        let counts = values.par_chunks(LONG).map(|part| part.iter().fold([0; 3], count));
        let [less, equal, more] = counts.reduce(|| [0; 3], |a, b| std::array::from_fn(|k| a[k] + b[k]));
        // Comparisons leave out NaN, and whether a zero is negative, which the order of a selection does not.
        if guess != 0.0 && less + equal + more == values.len() && (less..less + equal).contains(&middle) {
            return guess;
        }
    }
    selected(std::mem::take(values.to_mut()))
}

fn selected(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { f64::NAN } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_list_has_the_median_of_a_sorted_one() {
        for (rows, different) in [(0, 1), (1, 1), (4, 9), (5, 9), (LONG, 1), (LONG + 1, 3), (100_000, 90_000)] {
            let mut state = 1_u64;
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 33) % different
            };
            let values: Vec<f64> = (0..rows).map(|_| next() as f64 * 0.1 - 0.25).collect();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let expected = sorted.get(rows / 2).copied().unwrap_or(f64::NAN);
            assert_eq!(median(&values).to_bits(), expected.to_bits(), "{rows} {different}");
            assert_eq!(median(values).to_bits(), expected.to_bits());
        }
    }
}
