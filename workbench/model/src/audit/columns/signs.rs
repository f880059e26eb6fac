//! Signed numbers of `b` bits that are written without their sign, known by the jump where they change it.
//!
//! ```text
//! two's complement     …, 2, 1, 65 535, 65 534, …      x − 2^b from 2^(b−1) on
//! sign and magnitude   …, 2, 1, 32 769, 32 770, …      2^(b−1) − x from 2^(b−1) on
//! ```
//!
//! Decoded so, neighbours of different sign are as near as others are; of a signal of many values it is enough that
//! they are within its range, since friction turns round in one row. A count that goes round, and one that passes the
//! middle of its range, jump in the decoded values in its place.

use std::collections::HashSet;

use super::held::finite;

/// Bits of the types that drives and loggers have.
const BITS: [u8; 9] = [8, 10, 12, 14, 16, 18, 20, 24, 32];
/// Fewest rows that are looked at, and fewest different negative values: a single one is a code. So many of both signs
/// are a signal and no states.
const FEWEST: usize = 100;
const DIFFERENT: usize = 3;
const MANY: usize = 16;
/// Part of the steps that are larger than the usual largest one, and how much larger those over 0 may be, and more.
const LARGEST: f64 = 0.01;
const TIMES: f64 = 10.0;
const MORE: f64 = 2.0;
/// Part of the range within which neighbours of different sign are.
const NEAR: f64 = 0.25;

/// How signed numbers are written as unsigned ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Signs {
    /// Two's complement of so many bits.
    Complement(u8),
    /// The highest of so many bits is the sign, the others are the magnitude.
    Magnitude(u8),
}

impl Signs {
    /// How these values are written, if they are such; a missing one is NaN.
    #[must_use]
    pub fn of(x: &[f64]) -> Option<Self> {
        let is_count = |x: &f64| x.is_nan() || *x >= 0.0 && x.fract() == 0.0;
        // Most columns have a number with digits behind the point in one of their first rows.
        if x.len() < FEWEST || !x.iter().all(is_count) {
            return None;
        }
        let known = finite(x);
        let largest = known.iter().copied().fold(0.0, f64::max);
        let bits = BITS.into_iter().find(|bits| largest < range(*bits))?;
        if largest < 0.5 * range(bits) || !known.iter().any(|x| *x < 0.5 * range(bits)) {
            return None;
        }
        [Self::Complement(bits), Self::Magnitude(bits)].into_iter().find(|own| own.fits(&known))
    }

    /// Whether the decoded neighbours of different sign are as near as others are.
    fn fits(self, x: &[f64]) -> bool {
        let decoded: Vec<f64> = x.iter().map(|x| self.decoded(*x)).collect();
        let half = 0.5 * range(self.bits());
        let steps = || x.windows(2).zip(decoded.windows(2)).map(|(x, y)| ((x[0] < half) != (x[1] < half), y[1] - y[0]));
        let of = |over: bool| steps().filter(move |(own, _)| *own == over).map(|(_, step)| step.abs());
        let furthest = of(true).fold(0.0, f64::max);
        // Most counts that have no lost sign are known by this alone.
        if furthest > NEAR * range(self.bits()) {
            return false;
        }
        let different = |is_negative: bool| {
            let own = decoded.iter().filter(|x| (**x < 0.0) == is_negative).map(|x| x.to_bits());
            own.collect::<HashSet<u64>>().len()
        };
        let (negative, positive) = (different(true), different(false));
        let mut usual: Vec<f64> = of(false).collect();
        usual.sort_by(f64::total_cmp);
        let largest =
            usual.get(((1.0 - LARGEST) * usual.len() as f64) as usize).or(usual.last()).copied().unwrap_or(0.0);
        let (low, high) = decoded.iter().fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
        let within = if negative.min(positive) >= MANY { high - low } else { 0.0 };
        negative >= DIFFERENT && furthest <= (TIMES * largest + MORE).max(within)
    }

    /// The number that a value stands for.
    #[must_use]
    pub fn decoded(self, x: f64) -> f64 {
        let half = 0.5 * range(self.bits());
        match self {
            _ if x.is_nan() || x < half => x,
            Self::Complement(_) => x - 2.0 * half,
            Self::Magnitude(_) => half - x,
        }
    }

    const fn bits(self) -> u8 {
        match self {
            Self::Complement(bits) | Self::Magnitude(bits) => bits,
        }
    }

    /// How a channel decodes a column: `signed16`, `magnitude16`.
    #[must_use]
    pub fn word(self) -> String {
        match self {
            Self::Complement(bits) => format!("signed{bits}"),
            Self::Magnitude(bits) => format!("magnitude{bits}"),
        }
    }

    /// The one with this word.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        let bits = |number: &str| number.parse().ok().filter(|bits| BITS.contains(bits));
        let complement = || word.strip_prefix("signed").and_then(bits).map(Self::Complement);
        complement().or_else(|| word.strip_prefix("magnitude").and_then(bits).map(Self::Magnitude))
    }

    /// What is said of a column of this name.
    #[must_use]
    pub fn told(self, name: &str) -> String {
        let how = match self {
            Self::Complement(bits) => {
                format!("numbers of {bits} bits without their sign (−1 is {})", range(bits) - 1.0)
            }
            Self::Magnitude(bits) => {
                format!("numbers whose sign is the highest of {bits} bits (−1 is {})", 0.5 * range(bits) + 1.0)
            }
        };
        format!("column {name}: signed {how}: take {}({name})", self.word())
    }
}

/// Number of values of a type.
fn range(bits: u8) -> f64 {
    f64::from(bits).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(size: f64) -> Vec<f64> {
        (0..2000).map(|k| (size * (0.037 * f64::from(k)).sin()).round() + f64::from(k * 7 % 5)).collect()
    }

    fn magnitude(x: f64, bits: u8) -> f64 {
        if x < 0.0 { 0.5 * range(bits) - x } else { x }
    }

    #[test]
    fn signed_numbers_are_known_by_the_jump_where_they_change_their_sign() {
        for (bits, size) in [(8, 60.0), (12, 200.0), (12, 1900.0), (14, 4000.0), (16, 300.0), (16, 30_000.0), (24, 9e5)]
        {
            let (signed, complement) = (wave(size), Signs::Complement(bits));
            let x: Vec<f64> = signed.iter().map(|x| x.rem_euclid(range(bits))).collect();
            assert_eq!(Signs::of(&x), Some(complement), "{bits} bits, {size}");
            assert!(x.iter().zip(&signed).all(|(x, own)| complement.decoded(*x) == *own));
            let x: Vec<f64> = signed.iter().map(|x| magnitude(*x, bits)).collect();
            assert_eq!(Signs::of(&x), Some(Signs::Magnitude(bits)), "{bits} bits, {size}");
            assert!(x.iter().zip(&signed).all(|(x, own)| Signs::Magnitude(bits).decoded(*x) == *own));
        }
        // A noise around 0, one change of the sign, and missing values.
        let noise: Vec<f64> = (0..500).map(|k| f64::from((k * 37 % 11) - 5).rem_euclid(65_536.0)).collect();
        let once: Vec<f64> = (0..500).map(|k| f64::from(3 * k - 700).rem_euclid(65_536.0)).collect();
        let mut lacking = once.clone();
        lacking.iter_mut().step_by(7).for_each(|x| *x = f64::NAN);
        // Friction turns round in one row.
        let friction: Vec<f64> = wave(300.0).iter().map(|x| (x + 900.0 * x.signum()).rem_euclid(65_536.0)).collect();
        for x in [noise, once, lacking, friction] {
            assert_eq!(Signs::of(&x), Some(Signs::Complement(16)));
        }
    }

    #[test]
    fn other_counts_are_none() {
        let round: Vec<f64> = (0..2000).map(|k| f64::from(k * 997 % 65_536)).collect();
        let middle: Vec<f64> = wave(300.0).iter().map(|x| x + 2048.0).collect();
        let positive: Vec<f64> = wave(300.0).iter().map(|x| x.abs()).collect();
        let mut code = wave(9000.0).iter().map(|x| x + 9100.0).collect::<Vec<_>>();
        code.iter_mut().step_by(50).for_each(|x| *x = 65_535.0);
        let random: Vec<f64> = (0..2000_u64).map(|k| (k.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 48) as f64).collect();
        let states: Vec<f64> = (0..2000).map(|k| [0.0, 255.0, 3.0, 128.0][k / 200 % 4]).collect();
        let tenths: Vec<f64> = wave(300.0).iter().map(|x| x.rem_euclid(65_536.0) + 0.5).collect();
        for (k, x) in [round, middle, positive, code, random, states, tenths, wave(300.0)].iter().enumerate() {
            assert_eq!(Signs::of(x), None, "{k}");
        }
    }

    #[test]
    fn words_name_the_type() {
        for own in [Signs::Complement(16), Signs::Magnitude(12), Signs::Complement(24)] {
            assert_eq!(Signs::of_word(&own.word()), Some(own));
        }
        assert!(["signed", "signed15", "magnitude", "signed1e1", "abs16"].iter().all(|w| Signs::of_word(w).is_none()));
        let told = Signs::Magnitude(16).told("speed");
        assert!(told.contains("the highest of 16 bits (−1 is 32769): take magnitude16(speed)"), "{told}");
    }
}
