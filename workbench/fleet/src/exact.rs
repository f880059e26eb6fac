//! Sums of floating-point numbers without rounding: the result does not depend on the order of the terms.
//!
//! ```text
//! sum = Σ_k chunk_k 2^(32k − 1074),   a term is added to the two chunks of its 53 bits                    (1)
//! ```
//!
//! (1) is the small superaccumulator of Neal (2015, Fast exact summation using small and large superaccumulators). A
//! chunk takes 2⁹ terms before its carry moves on, so that a term costs a few nanoseconds. A product is added with
//! its rounding error, by Dekker's splitting (1971).

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Most chunks: from the least subnormal number to the largest one, and carries of 2⁶⁴ terms.
const CHUNKS: usize = 70;
/// Terms between carries: a term adds at most 2⁵² to a chunk.
const TERMS: u32 = 1 << 9;
/// Exponent of the least bit.
const LEAST: i32 = -1074;
/// 2²⁷ + 1, which splits 53 bits.
const SPLIT: f64 = 134_217_729.0;
/// Largest magnitude of which products are exact: their errors neither overflow nor underflow near it.
pub(super) const LARGEST: f64 = 1e140;
/// Bits that a number in single precision does not have.
const DOUBLE_ONLY: u64 = (1 << 29) - 1;

/// A sum (1), of which only the chunks in use are stored.
#[derive(Clone, Default)]
pub struct Exact {
    /// k of the first chunk.
    first: usize,
    chunks: Vec<i64>,
    /// Terms since the last carry.
    terms: u32,
}

/// The unique form of a sum: sign, k of the first digit, and digits of 32 bits without zeros at the ends.
#[derive(PartialEq, Eq, Serialize, Deserialize)]
struct Digits {
    negative: bool,
    first: u8,
    digits: Vec<u32>,
}

impl std::fmt::Debug for Exact {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Exact({:e})", self.value())
    }
}

impl PartialEq for Exact {
    fn eq(&self, other: &Self) -> bool {
        self.digits() == other.digits()
    }
}

impl Eq for Exact {}

impl Exact {
    /// Adds a finite number.
    pub fn add(&mut self, x: f64) {
        let bits = x.to_bits();
        let exponent = ((bits >> 52) & 0x7ff) as usize;
        let mantissa = (bits & ((1 << 52) - 1)) | (u64::from(exponent != 0) << 52);
        if mantissa == 0 {
            return;
        }
        let place = exponent.saturating_sub(1);
        let (chunk, shift) = (place / 32, place % 32);
        let low = ((mantissa << shift) & 0xffff_ffff) as i64;
        let high = (mantissa >> (32 - shift)) as i64;
        let at = match chunk.checked_sub(self.first) {
            Some(at) if at + 1 < self.chunks.len() => at,
            _ => self.cover(chunk, chunk + 2),
        };
        let sign = if x.is_sign_negative() { -1 } else { 1 };
        self.chunks[at] += sign * low;
        self.chunks[at + 1] += sign * high;
        self.terms += 1;
        if self.terms >= TERMS {
            self.carry();
        }
    }

    /// Extends the stored chunks; returns the place of chunk `from`.
    fn cover(&mut self, from: usize, to: usize) -> usize {
        if self.chunks.is_empty() {
            self.first = from;
        }
        if from < self.first {
            let missing = self.first - from;
            self.chunks.splice(..0, std::iter::repeat_n(0, missing));
            self.first = from;
        }
        if self.first + self.chunks.len() < to {
            self.chunks.resize(to - self.first, 0);
        }
        from - self.first
    }

    /// Adds a product of numbers of at most 1e140.
    pub fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        self.add(product);
        // A product of two numbers in single precision has at most 48 bits.
        if (a.to_bits() | b.to_bits()) & DOUBLE_ONLY != 0 {
            self.add(product_error(a, b, product));
        }
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &Self) {
        if other.chunks.is_empty() {
            return;
        }
        // Without carries, chunks are of at most 2⁶² each.
        let at = self.cover(other.first, other.first + other.chunks.len());
        self.chunks[at..].iter_mut().zip(&other.chunks).for_each(|(own, more)| *own += more);
        self.carry();
    }

    /// Sets the sum to zero and keeps its storage.
    pub fn reset(&mut self) {
        self.chunks.fill(0);
        self.terms = 0;
    }

    /// Moves carries on, so that all chunks but the last are from 0 to 2³² − 1.
    fn carry(&mut self) {
        let carried = carry(&mut self.chunks);
        if carried != 0 {
            self.chunks.push(carried);
        }
        self.terms = 0;
    }

    /// Returns whether the sum is negative, and its digits from chunk `first` on, zeros at the ends included.
    fn magnitude(&self) -> (bool, [i64; CHUNKS], usize) {
        let (mut digits, length) = ([0; CHUNKS], self.chunks.len());
        digits[..length].copy_from_slice(&self.chunks);
        let own = &mut digits[..length + 2];
        carry(own);
        let negative = own.last().is_some_and(|last| *last < 0);
        if negative {
            own.iter_mut().for_each(|digit| *digit = -*digit);
            carry(own);
        }
        (negative, digits, length + 2)
    }

    fn digits(&self) -> Digits {
        let (negative, digits, length) = self.magnitude();
        let digits = &digits[..length];
        let from = digits.iter().position(|digit| *digit != 0);
        let (Some(from), Some(to)) = (from, digits.iter().rposition(|digit| *digit != 0)) else {
            return Digits { negative: false, first: 0, digits: vec![] };
        };
        let digits = digits[from..=to].iter().map(|digit| *digit as u32).collect();
        Digits { negative, first: (self.first + from) as u8, digits }
    }

    /// Returns the sum as an unevaluated sum of two numbers, accurate to 96 bits and more.
    #[must_use]
    pub fn pair(&self) -> Double {
        let (negative, digits, length) = self.magnitude();
        let Some(top) = digits[..length].iter().rposition(|digit| *digit != 0) else { return Double::default() };
        let from = top.saturating_sub(3);
        let bits = digits[from..=top].iter().rev().fold(0_u128, |bits, digit| (bits << 32) | *digit as u128);
        let high = bits as f64;
        // The conversion of 2¹²⁸, to which `bits` may be rounded, is the largest number instead.
        let low = match (high as u128).cmp(&bits) {
            std::cmp::Ordering::Greater => -((high as u128 - bits) as f64),
            _ => (bits - high as u128) as f64,
        };
        let sign = if negative { -1.0 } else { 1.0 };
        // In two steps, of which each is a normal number.
        let exponent = 32 * (self.first + from) as i32 + LEAST;
        let scale = |x: f64| sign * x * 2_f64.powi(exponent / 2) * 2_f64.powi(exponent - exponent / 2);
        Double { high: scale(high), low: scale(low) }
    }

    /// Returns the sum, correctly rounded.
    #[must_use]
    pub fn value(&self) -> f64 {
        let Double { high, low } = self.pair();
        high + low
    }
}

/// Moves carries to the next chunk; the last one takes them, and what exceeds 32 bits of it is returned.
fn carry(chunks: &mut [i64]) -> i64 {
    let Some((last, others)) = chunks.split_last_mut() else { return 0 };
    let mut carried = 0;
    for chunk in others {
        let sum = *chunk + carried;
        carried = sum >> 32;
        *chunk = sum & 0xffff_ffff;
    }
    *last += carried;
    let beyond = *last >> 32;
    if beyond == 0 || beyond == -1 {
        return 0;
    }
    *last &= 0xffff_ffff;
    beyond
}

/// The rounding error of a product (Dekker 1971).
fn product_error(a: f64, b: f64, product: f64) -> f64 {
    let split = |x: f64| {
        let wide = SPLIT * x;
        let high = wide - (wide - x);
        (high, x - high)
    };
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    ((ah * bh - product) + ah * bl + al * bh) + al * bl
}

/// An unevaluated sum of two numbers, the second one below the last bit of the first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Double {
    /// The rounded sum.
    pub high: f64,
    /// What it lacks.
    pub low: f64,
}

impl Double {
    fn of_sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let from_b = high - a;
        Self { high, low: (a - (high - from_b)) + (b - from_b) }
    }

    fn minus(self, other: Self) -> Self {
        let Self { high, low } = Self::of_sum(self.high, -other.high);
        Self::of_sum(high, low + self.low - other.low)
    }

    fn times(self, other: Self) -> Self {
        let high = self.high * other.high;
        let low = product_error(self.high, other.high, high) + self.high * other.low + self.low * other.high;
        Self::of_sum(high, low)
    }

    fn over(self, divisor: f64) -> Self {
        let high = self.high / divisor;
        let product = high * divisor;
        let rest = ((self.high - product) - product_error(high, divisor, product)) + self.low;
        Self::of_sum(high, rest / divisor)
    }

    /// Returns self/n.
    #[must_use]
    pub fn mean(self, n: f64) -> f64 {
        let mean = self.over(n);
        mean.high + mean.low
    }

    /// Returns Σxy − Σx Σy/n, of which this is Σxy, rounded once in effect: the two terms may agree in 40 bits.
    #[must_use]
    pub fn centred(self, x: Self, y: Self, n: f64) -> f64 {
        let rest = self.minus(x.times(y).over(n));
        rest.high + rest.low
    }
}

impl Serialize for Exact {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.digits().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Exact {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Digits { negative, first, digits } = Digits::deserialize(deserializer)?;
        let first = usize::from(first);
        if first + digits.len() > CHUNKS - 2 {
            return Err(serde::de::Error::custom("a sum with too many digits"));
        }
        let sign = if negative { -1 } else { 1 };
        let mut own = Self { first, chunks: digits.iter().map(|digit| sign * i64::from(*digit)).collect(), terms: 0 };
        own.carry();
        Ok(own)
    }
}

#[cfg(test)]
mod tests {
    use rand::seq::SliceRandom;
    use rand::{RngExt as _, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn sum(terms: &[f64]) -> Exact {
        let mut sum = Exact::default();
        terms.iter().for_each(|x| sum.add(*x));
        sum
    }

    #[test]
    fn terms_that_cancel_leave_the_small_one() {
        assert_eq!(sum(&[1e300, 3.5, -1e300, 1e-300, -3.5]).value(), 1e-300);
        assert_eq!(sum(&[f64::MAX, f64::MAX, -f64::MAX, -f64::MAX, -5e-324]).value(), -5e-324);
        assert_eq!(sum(&[]).value(), 0.0);
        let many = vec![0.1; 100_000];
        // 0.1 is 0.1000000000000000055511…: one hundred thousand of them are 10000.000000000000555, rounded.
        assert_eq!(sum(&many).value(), 10_000.0);
        assert_eq!(
            sum(&[-0.1; 3]).pair(),
            Double { high: -0.300_000_000_000_000_04, low: 2.775_557_561_562_891_4e-17 }
        );
    }

    #[test]
    fn any_order_and_any_tree_has_the_same_chunks() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let terms: Vec<f64> =
            (0..3000).map(|_| (rng.random::<f64>() - 0.4) * 10_f64.powi(rng.random_range(-40..40))).collect();
        let whole = sum(&terms);
        for _ in 0..20 {
            let mut mixed = terms.clone();
            mixed.shuffle(&mut rng);
            let mut merged = Exact::default();
            let mut rest = &mixed[..];
            while !rest.is_empty() {
                let (own, others) = rest.split_at(rng.random_range(1..=rest.len()));
                merged.merge(&sum(own));
                rest = others;
            }
            assert_eq!(merged, whole);
            let packed = postcard::to_stdvec(&merged).expect("bytes");
            assert_eq!(postcard::from_bytes::<Exact>(&packed).expect("a sum"), whole);
        }
    }

    #[test]
    fn products_are_exact_in_both_precisions() {
        let (a, b) = (1.0 / 3.0, 1.0 + f64::EPSILON);
        let mut sum = Exact::default();
        sum.add_product(a, b);
        sum.add(-(a * b));
        // a b = a + a ε, and a ε = 2⁻⁵²/3.
        let error = (a - a * b) + a * f64::EPSILON;
        assert_eq!(sum.value(), error);
        let single = f64::from(0.1_f32);
        let mut square = Exact::default();
        square.add_product(single, single);
        assert_eq!(square.pair(), Double { high: single * single, low: 0.0 });
    }

    #[test]
    fn a_spread_far_below_the_mean_is_found() {
        // Values 1e7 + {0, 1, 2}: scatter 2.
        let (mut x, mut xx) = (Exact::default(), Exact::default());
        for value in [1e7, 1e7 + 1.0, 1e7 + 2.0] {
            x.add(value);
            xx.add_product(value, value);
        }
        assert_eq!(xx.pair().centred(x.pair(), x.pair(), 3.0), 2.0);
        assert_eq!(x.pair().mean(3.0), 1e7 + 1.0);
    }

    #[test]
    fn thousands_of_terms_of_the_largest_digits_are_summed() {
        // The exponent puts 52 bits into one chunk. A product of two numbers is rounded once, as the sum is.
        let term = 4.0_f64.next_down();
        assert_eq!(sum(&vec![term; 5000]).value(), term * 5000.0);
        assert_eq!(sum(&vec![-term; 5000]).value(), term * -5000.0);
    }

    #[test]
    fn a_product_of_a_short_and_a_long_number_is_exact() {
        let mut sum = Exact::default();
        sum.add_product(3.0, 1.0 + f64::EPSILON);
        sum.add(-3.0);
        assert_eq!(sum.value(), 3.0 * f64::EPSILON);
        sum.reset();
        sum.add(1.0);
        assert_eq!(sum.value(), 1.0, "nothing is left of the sum before");
    }
}
