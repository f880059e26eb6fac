//! A phase current that stays below what the other two say: clipped, or without a half wave.
//!
//! ```text
//! r = −(i_y + i_z)        what phase x carries by the other two                                          (1)
//! clipped at L:  r > L + w in more than 0.5 % of the rows, and i_x = L ± w in 90 % of these             (2)
//! ```
//!
//! L is what 0.2 % of the rows of i_x exceed, and w six deviations of i_x − r where the current is small, at least a
//! twentieth of the deviation of r. Below L the gain must be right. Values that are equal are not needed: noise behind
//! the converter hides those.

use crate::statistics::mean_sd;

/// Part of the rows above L.
const ABOVE: f64 = 0.002;
/// Parts of the rows beyond L, and of those at the level.
const BEYOND: f64 = 0.005;
const AT_LEVEL: f64 = 0.9;
/// Deviations of the noise, and part of the current, of w.
const NOISE: f64 = 6.0;
const WIDTH: f64 = 0.05;
/// Error of the gain below a level.
const GAIN: f64 = 0.05;
/// Part of the largest current below which the level is that of no current at all.
const NO_CURRENT: f64 = 0.15;
/// Fewest rows with a small current.
const FEWEST: usize = 30;

/// A level that a phase does not exceed, signed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Level {
    pub(crate) level: f64,
    /// The largest current (1) with this sign, and the part of the rows beyond the level.
    pub(crate) largest: f64,
    pub(crate) beyond: f64,
}

impl Level {
    /// Whether a half wave is missing.
    pub(crate) fn is_half_wave(&self) -> bool {
        self.level.abs() < NO_CURRENT * self.largest.abs()
    }
}

/// The levels of a phase with the current (1): at most one of each sign.
pub(crate) fn levels(x: &[f64], r: &[f64]) -> Vec<Level> {
    let rows: Vec<(f64, f64)> = x.iter().zip(r).map(|(x, r)| (*x, *r)).filter(|(x, r)| (x + r).is_finite()).collect();
    let size = mean_sd(&rows.iter().map(|(_, r)| *r).collect::<Vec<_>>()).1;
    let small: Vec<f64> = rows.iter().filter(|(_, r)| r.abs() < 0.5 * size).map(|(x, r)| x - r).collect();
    if small.len() < FEWEST {
        return vec![];
    }
    // The half without current has as many small rows as the one with it: the middle half tells the noise.
    let mut sorted = small;
    sorted.sort_by(f64::total_cmp);
    let quarter = sorted.len() / 4;
    let offset = sorted[2 * quarter];
    let noise = (sorted[3 * quarter] - sorted[quarter]) / 1.35;
    let width = (NOISE * noise).max(WIDTH * size);
    let each = |sign: f64| {
        let mut own: Vec<f64> = rows.iter().map(|(x, _)| sign * (x - offset)).collect();
        own.sort_by(f64::total_cmp);
        let level = own[((1.0 - ABOVE) * (own.len() - 1) as f64) as usize];
        let beyond: Vec<f64> =
            rows.iter().filter(|(_, r)| sign * r > level + width).map(|(x, _)| sign * (x - offset)).collect();
        let at_level = beyond.iter().filter(|x| (*x - level).abs() < width).count();
        let part = beyond.len() as f64 / rows.len() as f64;
        let largest = rows.iter().fold(0.0_f64, |most, (_, r)| most.max(sign * r));
        let is_level = part > BEYOND && at_level as f64 >= AT_LEVEL * beyond.len() as f64;
        // Below the level, a clipped current is as large as the others say.
        let below = || rows.iter().filter(|(_, r)| (0.0..0.8 * level).contains(&(sign * r)));
        let products: f64 = below().map(|(x, r)| (x - offset) * r).sum();
        let gain = products / below().map(|(_, r)| r * r).sum::<f64>();
        let is_right = level < NO_CURRENT * largest || (gain - 1.0).abs() < GAIN;
        (is_level && is_right).then_some(Level { level: sign * level, largest: sign * largest, beyond: part })
    };
    [1.0, -1.0].into_iter().filter_map(each).collect()
}

/// What is wrong with a phase of this name, in words.
pub(crate) fn told(name: &str, levels: &[Level]) -> Option<String> {
    let half = levels.iter().find(|level| level.is_half_wave());
    if let Some(half) = half {
        let which = if half.largest < 0.0 { "negative" } else { "positive" };
        return Some(format!(
            "the current {name} has no {which} half waves, which the other two phases have: its half bridge or its sensor"
        ));
    }
    let all: Vec<String> = levels.iter().map(|level| format!("{:.3}", level.level)).collect();
    let most = levels.iter().map(|level| level.largest).max_by(|one, other| one.abs().total_cmp(&other.abs()))?;
    let part: f64 = levels.iter().map(|level| level.beyond).sum();
    let all = all.join(" and ");
    Some(format!(
        "the current {name} is clipped at {all} in {:.1} % of the rows: by the other two phases it reaches {most:.3}",
        100.0 * part
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three phases of a current that grows to 4 A, with noise.
    fn phases(change: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let noise = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 65_536.0 - 0.5;
        let of = |k: u32, third: f64| {
            f64::from(k) / 1000.0 * (f64::from(k) * 0.05 + third * std::f64::consts::TAU / 3.0).sin()
        };
        let x = (0..4000).map(|k| change(of(k, 0.0)) + 0.05 * noise(k)).collect();
        (x, (0..4000).map(|k| -(of(k, 1.0) + of(k, 2.0)) + 0.05 * noise(k + 7)).collect())
    }

    fn found(change: impl Fn(f64) -> f64) -> Option<String> {
        let (x, r) = phases(change);
        told("ia", &levels(&x, &r))
    }

    #[test]
    fn levels_and_half_waves_are_told_from_gains_and_offsets() {
        let changes: [fn(f64) -> f64; 4] = [|x| x, |x| 0.8 * x, |x| 1.3 * x, |x| x + 0.4];
        for change in changes {
            assert_eq!(found(change), None);
        }
        let both = found(|x| x.clamp(-2.4, 2.4)).expect("clipped");
        assert!(both.contains("clipped at 2.4") && both.contains(" and -2.4"), "{both}");
        let one = found(|x| x.min(3.0)).expect("clipped");
        assert!(one.contains("clipped at 3.0") && !one.contains("and"), "{one}");
        let half = found(|x| x.max(0.0)).expect("a half wave");
        assert!(half.contains("no negative half waves"), "{half}");
        assert!(found(|x| x.min(0.0)).is_some_and(|own| own.contains("no positive half waves")));
    }
}
