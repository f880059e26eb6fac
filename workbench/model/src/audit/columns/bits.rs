//! Counts of a converter in which a bit never changes.
//!
//! A count that runs through its values changes each bit below the highest one that changes. One that stays between two
//! that change is stuck: a broken line of a parallel or serial link. Below the lowest bit that changes is the
//! resolution, above the highest one what the motion does not reach.

/// Fewest bits that change, so that flags and states are no counts.
const FEWEST: u32 = 6;
/// Part of the values that the changing bits can have, and that come.
const VISITED: f64 = 0.25;
/// Bits of the largest counts.
const MOST: u32 = 32;
/// Part of a step that a value may be off a count.
const OFF: f64 = 0.1;

/// Numbers, from 0, of the bits that are stuck in these counts, each with its value; empty if they are no counts.
#[must_use]
pub fn stuck(counts: &[u64]) -> Vec<(u32, bool)> {
    let (ones, zeros) = counts.iter().fold((0_u64, 0_u64), |(ones, zeros), count| (ones | count, zeros | !count));
    let changing = ones & zeros;
    if changing.count_ones() < FEWEST {
        return vec![];
    }
    let mut sorted = counts.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    // A short recording does not visit all values of many bits.
    let values = (changing.count_ones() as f64).exp2().min(counts.len() as f64);
    if (sorted.len() as f64) < VISITED * values {
        return vec![];
    }
    let within = changing.trailing_zeros()..changing.ilog2();
    within.filter(|bit| changing >> bit & 1 == 0).map(|bit| (bit, ones >> bit & 1 == 1)).collect()
}

/// The values of a column as counts from 0 on, if all of them are whole numbers.
#[must_use]
pub fn whole(x: &[f64]) -> Option<Vec<u64>> {
    let is_count = |x: &&f64| **x >= 0.0 && **x < f64::from(MOST).exp2() && x.fract() == 0.0;
    let finite = || x.iter().filter(|x| x.is_finite());
    finite().all(|x| is_count(&x)).then(|| finite().map(|x| *x as u64).collect())
}

/// An angle, rad, as counts of a converter whose number of counts a turn is a power of two; `step` is the smallest
/// difference of its values.
#[must_use]
pub fn of_angle(angle: &[f64], step: f64) -> Option<Vec<u64>> {
    let bits = (std::f64::consts::TAU / step).log2();
    if !(f64::from(FEWEST)..=24.0).contains(&bits) || (bits - bits.round()).abs() > OFF {
        return None;
    }
    let turn = bits.round().exp2();
    let place = |angle: f64| (angle / std::f64::consts::TAU).rem_euclid(1.0) * turn;
    let finite = || angle.iter().filter(|angle| angle.is_finite());
    // A zero of its own moves all counts alike, but not by whole ones.
    let is_count = |angle: &f64| (place(*angle) - place(*angle).round()).abs() < 2.0 * OFF;
    finite().all(is_count).then(|| finite().map(|angle| place(*angle).round() as u64 % turn as u64).collect())
}

/// What is wrong with the counts of a column, in words.
#[must_use]
pub fn told(counts: &[u64]) -> Option<String> {
    let all = stuck(counts);
    let each: Vec<String> = all.iter().map(|(bit, one)| format!("bit {bit} is always {}", u8::from(*one))).collect();
    (!each.is_empty()).then(|| format!("{} while those beside it change: a stuck line of the sensor", each.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A shaft that turns to and fro by some turns, in counts of 12 bits.
    fn counts() -> Vec<u64> {
        (0..5000).map(|k| ((3.0 + 2.7 * (f64::from(k) * 0.003).sin()) * 4096.0) as u64 % 4096).collect()
    }

    #[test]
    fn a_bit_that_never_changes_is_told_by_number_and_value() {
        assert_eq!(stuck(&counts()), vec![]);
        for bit in 1..11 {
            let high: Vec<u64> = counts().iter().map(|own| own | 1 << bit).collect();
            let low: Vec<u64> = counts().iter().map(|own| own & !(1 << bit)).collect();
            assert_eq!((stuck(&high), stuck(&low)), (vec![(bit, true)], vec![(bit, false)]), "{bit}");
        }
        let text = told(&counts().iter().map(|own| own | 32).collect::<Vec<_>>()).expect("stuck");
        assert!(text.starts_with("bit 5 is always 1 while"), "{text}");
    }

    #[test]
    fn resolution_range_and_flags_are_no_stuck_bits() {
        let coarse: Vec<u64> = counts().iter().map(|own| own & !7).collect();
        let quarter: Vec<u64> = counts().iter().map(|own| own / 4).collect();
        let flags: Vec<u64> = (0..5000).map(|k| [0, 1, 64, 1 << 9, 1 << 12, 3 << 14][k % 6]).collect();
        assert!([coarse, quarter, flags].iter().all(|own| stuck(own).is_empty()));
    }

    #[test]
    fn angles_in_radians_are_counts() {
        let stuck_bit: Vec<u64> = counts().iter().map(|own| own & !16).collect();
        // As a recording has it, to five decimals, and with turns.
        let angle: Vec<f64> = stuck_bit
            .iter()
            .zip(0..)
            .map(|(own, k)| ((*own as f64 / 4096.0 + f64::from(k / 1000)) * TAU * 1e5).round() / 1e5)
            .collect();
        let step = TAU / 4096.0;
        assert_eq!(stuck(&of_angle(&angle, step).expect("counts")), vec![(4, false)]);
        assert_eq!(of_angle(&angle, TAU / 2400.0), None, "no power of two");
        assert_eq!(of_angle(&[0.1, 0.2, 0.3003], step), None);
        assert_eq!((whole(&[1.0, f64::NAN, 7.0]), whole(&[1.5]), whole(&[-1.0])), (Some(vec![1, 7]), None, None));
    }
}
