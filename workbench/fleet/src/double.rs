//! Sums in twice the precision of `f64`, so that the order of the terms does not reach the constants of a model.
//!
//! ```text
//! sum = high + low,   |low| ≤ ulp(high)/2                                                                  (1)
//! ```
//!
//! A term is added with its rounding error (Knuth's two-sum), a product with that of the multiplication (Dekker 1971):
//! (1) keeps about 106 bits. What another order of the terms changes in it is far below the last bit of a constant in
//! single precision, also where this is a small difference of large sums.

/// 2²⁷ + 1, which splits 53 bits.
const SPLIT: f64 = 134_217_729.0;
/// Largest magnitude of which products are exact: their errors neither overflow nor underflow near it.
pub(super) const LARGEST: f64 = 1e140;
/// Bits that a number in single precision does not have.
const DOUBLE_ONLY: u64 = (1 << 29) - 1;

/// A sum (1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Double {
    /// The rounded sum.
    high: f64,
    /// What it lacks.
    low: f64,
}

impl Double {
    fn of_sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let from_b = high - a;
        Self { high, low: (a - (high - from_b)) + (b - from_b) }
    }

    /// Adds a finite number.
    pub fn add(&mut self, x: f64) {
        let Self { high, low } = Self::of_sum(self.high, x);
        *self = Self::of_sum(high, low + self.low);
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
    pub fn merge(&mut self, other: Self) {
        let (high, low) = (Self::of_sum(self.high, other.high), Self::of_sum(self.low, other.low));
        let first = Self::of_sum(high.high, high.low + low.high);
        *self = Self::of_sum(first.high, first.low + low.low);
    }

    /// Returns the sum, rounded.
    #[must_use]
    pub const fn value(self) -> f64 {
        self.high + self.low
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
        self.over(n).value()
    }

    /// Returns Σxy − Σx Σy/n, of which this is Σxy, rounded once in effect: the two terms may agree in 40 bits.
    #[must_use]
    pub fn centred(mut self, x: Self, y: Self, n: f64) -> f64 {
        let Self { high, low } = x.times(y).over(n);
        self.merge(Self { high: -high, low: -low });
        self.value()
    }
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

#[cfg(test)]
mod tests {
    use rand::seq::SliceRandom;
    use rand::{RngExt as _, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn sum(terms: &[f64]) -> Double {
        let mut sum = Double::default();
        terms.iter().for_each(|x| sum.add(*x));
        sum
    }

    #[test]
    fn terms_that_cancel_leave_the_small_one() {
        assert_eq!(sum(&[1e20, 3.5, -1e20, -3.5, 1e-6]).value(), 1e-6);
        assert_eq!(sum(&[]).value(), 0.0);
        // 0.1 is 0.1000000000000000055511…: one hundred thousand of them are 10000.000000000000555, rounded.
        assert_eq!(sum(&vec![0.1; 100_000]).value(), 10_000.0);
        assert_eq!(sum(&[-0.1; 3]), Double { high: -0.300_000_000_000_000_04, low: 2.775_557_561_562_891_4e-17 });
    }

    #[test]
    fn any_order_and_any_tree_has_the_same_value() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let terms: Vec<f64> =
            (0..3000).map(|_| (rng.random::<f64>() - 0.4) * 10_f64.powi(rng.random_range(-12..12))).collect();
        let whole = sum(&terms);
        for _ in 0..20 {
            let mut mixed = terms.clone();
            mixed.shuffle(&mut rng);
            let mut merged = Double::default();
            let mut rest = &mixed[..];
            while !rest.is_empty() {
                let (own, others) = rest.split_at(rng.random_range(1..=rest.len()));
                merged.merge(sum(own));
                rest = others;
            }
            assert_eq!(merged.value(), whole.value());
        }
    }

    #[test]
    fn products_are_exact_in_both_precisions() {
        let (a, b) = (1.0 / 3.0, 1.0 + f64::EPSILON);
        let mut sum = Double::default();
        sum.add_product(a, b);
        sum.add(-(a * b));
        // a b = a + a ε, and a ε = 2⁻⁵²/3.
        let error = (a - a * b) + a * f64::EPSILON;
        assert_eq!(sum.value(), error);
        let single = f64::from(0.1_f32);
        let mut square = Double::default();
        square.add_product(single, single);
        assert_eq!(square, Double { high: single * single, low: 0.0 });
        // Of a short and a long number.
        let mut mixed = Double::default();
        mixed.add_product(3.0, 1.0 + f64::EPSILON);
        mixed.add(-3.0);
        assert_eq!(mixed.value(), 3.0 * f64::EPSILON);
    }

    #[test]
    fn a_spread_far_below_the_mean_is_found() {
        // Values 1e7 + {0, 1, 2}: scatter 2.
        let (mut x, mut xx) = (Double::default(), Double::default());
        for value in [1e7, 1e7 + 1.0, 1e7 + 2.0] {
            x.add(value);
            xx.add_product(value, value);
        }
        assert_eq!(xx.centred(x, x, 3.0), 2.0);
        assert_eq!(x.mean(3.0), 1e7 + 1.0);
    }
}
