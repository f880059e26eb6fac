//! The response of the residual's filter at the speed of a block.
//!
//! Enters: the angle of an order's harmonic from sample to sample, and the poles of the filter. Leaves: a [`Response`].
//!
//! ```text
//! H(θ) = (1 − z)/((1 − α z) (1 − (1 − γ) z)),   z = e^{−jθ}                                           (1)
//! s = sin θ/2,  c = cos θ/2:
//! H* = 2 s ((2 − γ) s − j γ c) (1 − α + 2 α s² + 2 j α s c)/(D₁ D₂),   |H|² = 4 s²/(D₁ D₂)            (2)
//! D₁ = (1 − α)² + 4 α s²,   D₂ = γ² + 4 (1 − γ) s²                                                    (3)
//! ```
//!
//! (1) is the filter of [`super::residual`] from ρ to y. By the half angle nothing cancels where θ is small. Without a
//! high-pass, γ = 0, its factors are 1. Where each second sample is taken, θ is that of two samples, and H has the
//! factor ½ + ¾ c − ¼ c³ of the half-band filter ((2) of [`delays`](crate::shaft::delays)).

use super::blocks::Blocks;
use super::phasor::phasor;

/// H* and |H|² of (2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Response {
    conjugate: [f32; 2],
    pub power: f32,
}

impl Response {
    /// At a turn of θ a step, counts of 2⁻³² turn; `halved` if a step is two samples.
    #[inline(never)]
    pub(super) fn at(blocks: &Blocks, turned: u32, halved: bool) -> Self {
        let (c, s) = phasor((turned.cast_signed() >> 1).cast_unsigned());
        let Self { conjugate: [re, im], power } = Self::of_filter(blocks, c, s);
        let gain = if halved { 0.5 + c * (0.75 - 0.25 * c * c) } else { 1.0 };
        Self { conjugate: [gain * re, gain * im], power: gain * gain * power }
    }

    #[inline(always)]
    fn of_filter(blocks: &Blocks, c: f32, s: f32) -> Self {
        let Blocks { pole, high_pass, .. } = *blocks;
        let (square, product) = (2.0 * s * s, 2.0 * s * c);
        let (low_x, low_y) = (1.0 - pole + pole * square, pole * product);
        let low = (1.0 - pole) * (1.0 - pole) + 2.0 * pole * square; // (3)
        if high_pass > 0.0 {
            let (high_x, high_y) = ((2.0 - high_pass) * square, -high_pass * product);
            let one = 1.0 / (low * (high_pass * high_pass + 2.0 * (1.0 - high_pass) * square));
            let conjugate = [(high_x * low_x - high_y * low_y) * one, (high_x * low_y + high_y * low_x) * one];
            return Self { conjugate, power: 2.0 * square * one };
        }
        let one = 1.0 / low;
        Self { conjugate: [low_x * one, low_y * one], power: one }
    }

    /// H* b.
    #[inline(always)]
    pub(super) fn correct(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [re, im] = self.conjugate;
        [re * x - im * y, re * y + im * x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The filter itself, on a phasor of this angle a sample, in double precision after its transient.
    #[test]
    fn response_is_that_of_the_filter() {
        for (pole, high_pass) in [(0.0, 0.0), (0.5, 0.0), (0.9, 0.0), (0.5, 0.05), (0.0, 0.02), (0.97, 0.01)] {
            let blocks = Blocks { pole, high_pass, ..Blocks::EMPTY };
            for turns in [0.004_f64, -0.004, 0.03, -0.11, 0.3, 0.49] {
                let theta = core::f64::consts::TAU * turns;
                let (mut low, mut slow, mut now) = ([0.0; 2], [0.0; 2], [0.0; 2]);
                let (alpha, gamma) = (f64::from(pole), f64::from(high_pass));
                let last = 3000;
                for k in 0..=last {
                    let phase = theta * f64::from(k);
                    for (part, input) in [phase.cos(), phase.sin()].into_iter().enumerate() {
                        low[part] = input + alpha * low[part];
                        now[part] = low[part] - slow[part];
                        slow[part] += gamma * now[part];
                    }
                }
                let (cos, sin) = ((theta * f64::from(last)).cos(), (theta * f64::from(last)).sin());
                let h = [now[0] * cos + now[1] * sin, now[1] * cos - now[0] * sin];
                let response = Response::at(&blocks, ((turns * 4_294_967_296.0) as i32).cast_unsigned(), false);
                let size = h[0].hypot(h[1]);
                let [re, im] = response.conjugate.map(f64::from);
                let error = (re - h[0]).hypot(im + h[1]) / size;
                // The phasor is within 2.1e-5; a pole of 0.97 multiplies the error of a small angle.
                assert!(error < 2e-4, "{pole} {high_pass} {turns}: {error}");
                assert!((f64::from(response.power).sqrt() / size - 1.0).abs() < 2e-4, "{pole} {high_pass} {turns}");
                // A step of two samples: the half-band filter at half the phase.
                let halved = Response::at(&blocks, ((turns * 4_294_967_296.0) as i32).cast_unsigned(), true);
                let gain = 0.5 + (9.0 * (0.5 * theta).cos() - (1.5 * theta).cos()) / 16.0;
                let ratio = (f64::from(halved.power) / f64::from(response.power)).sqrt();
                assert!((ratio - gain).abs() < 1e-4, "{pole} {high_pass} {turns}: {ratio} {gain}");
            }
        }
    }

    #[test]
    fn a_block_without_speed_is_finite() {
        for high_pass in [0.0, 0.02] {
            let Response { conjugate: [re, im], power } =
                Response::at(&Blocks { pole: 0.9, high_pass, ..Blocks::EMPTY }, 0, false);
            assert!(re.is_finite() && im == 0.0 && power.is_finite(), "{high_pass}");
        }
    }
}
