//! Sets of traces that differ in what no bearing changes: a model would tell sessions, not defects.
//!
//! ```text
//! apart      all values of one class are below all of the other, and the gap between them is more than a part of them
//! chance     2 n₁! n₂!/(n₁ + n₂)!                                                            (1)
//! ```
//!
//! (1) is the probability that n₁ and n₂ exchangeable values are apart.

/// A property of the traces of two classes that are apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// The property.
    pub property: String,
    /// The two classes.
    pub classes: [String; 2],
    /// Mean of each.
    pub means: [f64; 2],
}

/// Largest (1) at which a property counts.
const RARE: f64 = 0.01;
/// Least gap, as a part of the size.
const PART: f64 = 2e-3;

/// Compares a property of the traces of each pair of classes; a value that is not finite is missing. `size` is that of
/// the signal of which the values are means; without one it is that of the values.
#[must_use]
pub fn apart(property: &str, (values, size): (&[f64], Option<f64>), classes: &[String]) -> Vec<Apart> {
    let mut names: Vec<&String> = vec![];
    classes.iter().for_each(|class| {
        if !names.contains(&class) {
            names.push(class);
        }
    });
    let of = |name: &String| -> Vec<f64> {
        values.iter().zip(classes).filter(|(x, class)| x.is_finite() && *class == name).map(|(x, _)| *x).collect()
    };
    let sets: Vec<Vec<f64>> = names.iter().map(|name| of(name)).collect();
    let mut found = vec![];
    for (k, one) in sets.iter().enumerate() {
        for (j, other) in sets.iter().enumerate().take(k) {
            if are_apart(one, other, size) || are_apart(other, one, size) {
                let mean = |set: &[f64]| set.iter().sum::<f64>() / set.len() as f64;
                let (classes, means) = ([names[j].clone(), names[k].clone()], [mean(other), mean(one)]);
                found.push(Apart { property: property.into(), classes, means });
            }
        }
    }
    found
}

/// Whether all of `low` are below all of `high`, surely and by a relevant difference.
fn are_apart(low: &[f64], high: &[f64], size: Option<f64>) -> bool {
    let most = low.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = high.iter().copied().fold(f64::INFINITY, f64::min);
    let scale = size.unwrap_or_else(|| most.abs().max(least.abs()));
    !low.is_empty() && !high.is_empty() && chance(low.len(), high.len()) < RARE && least - most > PART * scale
}

/// (1).
fn chance(one: usize, other: usize) -> f64 {
    2.0 * (1..=one).map(|k| k as f64 / (other + k) as f64).product::<f64>()
}

impl std::fmt::Display for Apart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { property, classes: [one, other], means: [low, high] } = self;
        write!(
            f,
            "classes {one} and {other} differ in {property} ({low:.4} and {high:.4}): a model could tell sessions, not \
             defects"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_of_two_sessions_are_found() {
        let classes: Vec<String> = (0..12).map(|k| if k < 5 { "a" } else { "b" }.to_string()).collect();
        let rate = |k: usize| if k < 5 { 1000.0 } else { 1020.0 };
        let values: Vec<f64> = (0..12).map(|k| rate(k) + k as f64 * 0.01).collect();
        let found = apart("rate", (&values, None), &classes);
        assert!(found.len() == 1 && found[0].classes == ["a", "b"], "{found:?}");
        // Overlap, a small difference, and too few traces are none.
        let mixed: Vec<f64> = (0..12).map(|k| rate((k * 5) % 12)).collect();
        assert!(apart("rate", (&mixed, None), &classes).is_empty());
        let near: Vec<f64> = (0..12).map(|k| 1000.0 + k as f64 * 0.01).collect();
        assert!(apart("rate", (&near, None), &classes).is_empty());
        assert!(apart("rate", (&values, Some(1e5)), &classes).is_empty());
        assert!(apart("rate", (&values[3..7], None), &classes[3..7]).is_empty());
        // 5 and 7: 2 · 5! 7!/12! = 1/396.
        assert!((chance(5, 7) - 1.0 / 396.0).abs() < 1e-12);
    }
}
