//! Blocks of the control orders → the noise at any order.
//!
//! Enters: phasors b and weights W of the control orders' blocks. Leaves: σ², the mean of |b|²/W at an order o.
//!
//! ```text
//! σ_c^½ = mean over blocks of (|b|²/W)^¼ / Γ(5/4)                                                     (1)
//! ln σ²(o) = m + s (ln o − x̄),   by least squares over the control orders c                           (2)
//! σ²(h o) = h^s σ²(o)                                                                                 (3)
//! Var ln σ²(o) = (v + min(max(s² − v, 0)/5, 0.12)) (¼ + (ln o − x̄)²/Σ (ln c − x̄)²)                    (4)
//! v = 1.26/n,   n: number of blocks;   s² = Σ (ln σ_c² − ln σ²(c))²/2
//! ```
//!
//! No bearing has an effect at a control order. The fourth root in (1) limits the influence of single strong
//! blocks. Behind the whitening filter the noise would be equal at all orders if the torque balance were complete;
//! torques that it does not contain add noise at low orders, about as a power of the order. In (4), 1.26 = 16
//! (Γ(3/2)/Γ(5/4)² − 1) is the variance of 4 ln σ^½ of one block. If the levels scatter more about the line than the
//! number of their blocks explains, as beside a resonance of the mechanics at nearly constant speed, the noise between
//! the control orders is uncertain, too. A fifth of this scatter counts, up to a deviation of σ² of a third: its
//! estimate from four levels has only two degrees of freedom, and strong defects raise it.

use core::f32::consts::LN_2;

use super::blocks::CONTROLS;
use crate::logarithm::ln_of_level;
use crate::plan::MAX_HARMONICS;

/// Γ(5/4), the mean of the fourth root of an exponential variable.
const ROOT_MEAN: f32 = 0.906_402_5;
/// 16 (Γ(3/2)/Γ(5/4)² − 1) of (4).
const BLOCK_VARIANCE: f32 = 1.259_2;
/// Part of s² − v in (4), and the most that counts.
const COUNTED: f32 = 0.2;
const MOST: f32 = 0.12;
const LN_3: f32 = 1.098_612_3;

/// Sums of (1), one for each control order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Noise {
    /// Σ (|b|²/W)^¼.
    roots: [f32; CONTROLS],
    /// Number of summands. They differ by one while the control orders close a block one after the other.
    counts: [u32; CONTROLS],
}

impl Noise {
    /// Takes a block of control order `k`; one without weight has no effect.
    pub(in crate::shaft) fn add(&mut self, k: usize, [x, y]: [f32; 2], weight: f32) {
        if let (Some(root), Some(count)) = (self.roots.get_mut(k), self.counts.get_mut(k))
            && weight > 0.0
        {
            *root += libm::sqrtf(libm::sqrtf((x * x + y * y) / weight));
            *count = count.saturating_add(1);
        }
    }

    /// Whether a control order had no block.
    pub(in crate::shaft) fn is_unknown(&self) -> bool {
        self.counts.contains(&0)
    }
}

/// The line (2): means of ln o and ln σ², and sums of squares and products about them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(in crate::shaft) struct NoiseLine {
    /// Smallest number of blocks of a control order.
    blocks: u32,
    mean: [f32; 2],
    /// Of ln o, of both, and of ln σ².
    square: f32,
    product: f32,
    squared_levels: f32,
    slope: f32,
    /// `h^s` of (3).
    harmonics: [f32; MAX_HARMONICS],
}

impl NoiseLine {
    /// No control order.
    pub(in crate::shaft) const NONE: Self = Self {
        blocks: u32::MAX,
        mean: [0.0; 2],
        square: 0.0,
        product: 0.0,
        squared_levels: 0.0,
        slope: 0.0,
        harmonics: [1.0; MAX_HARMONICS],
    };

    /// Of these control orders.
    #[inline(never)]
    pub(in crate::shaft) fn new(noise: &Noise, controls: &[i32; CONTROLS]) -> Self {
        let mut line = Self::NONE;
        let mut taken = 0.0;
        for ((root, count), order) in noise.roots.iter().zip(&noise.counts).zip(controls) {
            taken += 1.0;
            line.blocks = line.blocks.min(*count);
            let root = root / ((*count as f32).max(1.0) * ROOT_MEAN); // (1)
            line.take(1.0 / taken, ln_of_level(*order as f32 / 65_536.0), 4.0 * ln_of_level(root));
        }
        line.slope = if line.square > 0.0 { line.product / line.square } else { 0.0 };
        line.harmonics = [1.0, libm::expf(line.slope * LN_2), libm::expf(line.slope * LN_3)]; // (3)
        line
    }

    /// Takes a point x = ln o, y = ln σ², which is this part of all points so far.
    fn take(&mut self, part: f32, x: f32, y: f32) {
        let [mean_x, mean_y] = &mut self.mean;
        let (far, far_level) = (x - *mean_x, y - *mean_y);
        *mean_x += part * far;
        *mean_y += part * far_level;
        self.square += far * (x - *mean_x);
        self.product += far * (y - *mean_y);
        self.squared_levels += far_level * (y - *mean_y);
    }

    /// (2) and a ninth of (4).
    #[inline(never)]
    pub(in crate::shaft) fn at(&self, order: f32) -> (f32, f32) {
        let [x, y] = self.mean;
        let far = ln_of_level(order) - x;
        let line = if self.square > 0.0 { far * far / self.square } else { 0.0 };
        let of_blocks = BLOCK_VARIANCE / self.blocks.max(1) as f32;
        let scatter = (self.squared_levels - self.slope * self.product) / (CONTROLS - 2) as f32;
        let excess = COUNTED * (scatter - of_blocks);
        let excess = if excess < MOST { excess } else { MOST };
        let of_level = if excess > 0.0 { of_blocks + excess } else { of_blocks };
        let variance = of_level * (1.0 / CONTROLS as f32 + line);
        (libm::expf(y + self.slope * far), variance / 9.0)
    }

    /// σ² at the harmonic h + 1 over that at the order itself (3).
    pub(in crate::shaft) fn ratio(&self, h: usize) -> f32 {
        self.harmonics.get(h).copied().unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaft::orders::q16;

    fn line(levels: [f32; CONTROLS], orders: [f32; CONTROLS]) -> NoiseLine {
        let mut noise = Noise::default();
        for (k, level) in levels.into_iter().enumerate() {
            // Blocks of power `level` ROOT_MEAN⁴ W, so that (1) gives `level`.
            let size = ROOT_MEAN * ROOT_MEAN * libm::sqrtf(3.0 * level);
            noise.add(k, [0.0, size], 3.0);
            noise.add(k, [-size, 0.0], 3.0);
            noise.add(k, [1.0, 1.0], 0.0);
        }
        assert!(!noise.is_unknown() && Noise::default().is_unknown());
        NoiseLine::new(&noise, &orders.map(q16))
    }

    #[test]
    fn a_power_of_the_order_is_found() {
        // σ² = 8 o⁻²; control orders are rounded to 2⁻¹⁶.
        let orders = [2.0, 4.0, 8.0, 16.0];
        let line = line(orders.map(|o| 8.0 / (o * o)), orders);
        for order in [0.5, 3.0, 11.0] {
            assert!((line.at(order).0 * order * order / 8.0 - 1.0).abs() < 1e-5, "{order}");
        }
        // Two blocks each; ln o is 1.5 ln 2 from its mean at the ends, and Σ = 5 ln² 2.
        for (order, variance) in [(2.0, 0.25 + 2.25 / 5.0), (libm::sqrtf(32.0), 0.25)] {
            let expected = 1.2592 / 2.0 * variance / 9.0;
            assert!((line.at(order).1 / expected - 1.0).abs() < 1e-3, "{order}: {}", line.at(order).1);
        }
        for h in 0..MAX_HARMONICS {
            let of_harmonic = line.at(3.0 * (h + 1) as f32).0;
            assert!((line.at(3.0).0 * line.ratio(h) / of_harmonic - 1.0).abs() < 1e-5, "{h}");
        }
    }

    #[test]
    fn levels_off_the_line_make_the_noise_less_certain() {
        // ln o is ∓1.5 and ∓0.5 ln 2 from its mean, and ln σ² ∓a/2: of their Σ = a² the line of slope
        // a/(5 ln 2) explains a fifth.
        for level in [1.5, 4.0, 8.0] {
            let line = line([1.0, level, 1.0, level], [2.0, 4.0, 8.0, 16.0]);
            let (a, of_blocks) = (libm::logf(level), 1.2592 / 2.0);
            for (order, place) in [(libm::sqrtf(32.0), 0.25), (2.0, 0.25 + 2.25 / 5.0)] {
                let excess = (0.2 * (0.8 * a * a / 2.0 - of_blocks)).clamp(0.0, 0.12);
                let expected = (of_blocks + excess) * place / 9.0;
                assert!((line.at(order).1 / expected - 1.0).abs() < 1e-3, "{order}: {} {expected}", line.at(order).1);
            }
        }
    }

    #[test]
    fn equal_orders_give_the_mean_of_the_logarithms() {
        let line = line([1.0, 4.0, 1.0, 4.0], [3.0; CONTROLS]);
        assert!((line.at(7.0).0 - 2.0).abs() < 1e-5, "{}", line.at(7.0).0);
    }

    #[test]
    fn silence_is_finite() {
        let line = line([0.0; CONTROLS], [2.0, 3.0, 4.0, 5.0]);
        assert!(line.at(3.0).0.is_finite() && line.at(0.0).0.is_finite());
    }
}
