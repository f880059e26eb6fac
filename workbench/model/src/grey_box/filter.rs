//! Low-pass filters for grey-box estimation: Butterworth and Chebyshev cascades, run forward and backward, or forward
//! with a derivative.
//!
//! ```text
//! H(s) = Π |p|² / (s² − 2 Re(p) s + |p|²),   s = (1/tan πf) (z − 1)/(z + 1)                  (1)
//! Butterworth: p = −sin φ + j cos φ,   Chebyshev: p = −sinh μ sin φ + j cosh μ cos φ         (2)
//! φ = π(2k − 1)/(2n),   μ = asinh(1/ε)/n,   ε² = 10^(ripple/10) − 1
//! ```
//!
//! Every section has gain one at zero frequency, so the ripple of a Chebyshev filter lies above one.

use std::f64::consts::PI;

/// One second-order section.
#[derive(Clone, Copy, Debug)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// Low-pass filter of even order.
#[derive(Clone, Debug)]
pub struct LowPass {
    sections: Vec<Section>,
    /// Cut-off, cycles per sample.
    cutoff: f64,
}

impl LowPass {
    /// Butterworth filter; `cutoff` in cycles per sample, below one half.
    #[must_use]
    pub fn butterworth(pairs: usize, cutoff: f64) -> Self {
        Self::new(pairs, cutoff, 1.0, 1.0)
    }

    /// Chebyshev filter of the first kind.
    pub(crate) fn chebyshev(pairs: usize, ripple_db: f64, cutoff: f64) -> Self {
        let epsilon = (10f64.powf(ripple_db / 10.0) - 1.0).sqrt();
        let mu = (1.0 / epsilon).asinh() / (2 * pairs) as f64;
        Self::new(pairs, cutoff, mu.sinh(), mu.cosh())
    }

    fn new(pairs: usize, cutoff: f64, real: f64, imaginary: f64) -> Self {
        let c = 1.0 / (PI * cutoff).tan();
        let section = |k: usize| {
            let phi = PI * (2 * k - 1) as f64 / (4 * pairs) as f64; // n = 2 · pairs
            let (re, im) = (-real * phi.sin(), imaginary * phi.cos()); // (2)
            let square = re * re + im * im;
            let a0 = c * c - 2.0 * re * c + square;
            let gain = square / a0;
            Section {
                b: [gain, 2.0 * gain, gain],
                a: [2.0 * (square - c * c) / a0, (c * c + 2.0 * re * c + square) / a0],
            }
        };
        Self { sections: (1..=pairs).map(section).collect(), cutoff }
    }

    /// Filters forward; the initial state is the steady state for the first sample.
    #[must_use]
    pub fn forward(&self, x: &[f64]) -> Vec<f64> {
        self.sections.iter().fold(x.to_vec(), |x, section| section.run(&x))
    }

    /// Derivative per sample of the low-passed signal, by the bilinear rule `2 (z − 1)/(z + 1)`; for one section.
    pub(crate) fn derivative(&self, x: &[f64]) -> Vec<f64> {
        let slope = |section: &Section| Section { b: [2.0 * section.b[0], 0.0, -2.0 * section.b[0]], a: section.a };
        let (first, rest) = self.sections.split_at(1);
        let start = first.iter().fold(x.to_vec(), |x, section| slope(section).run(&x));
        rest.iter().fold(start, |x, section| section.run(&x))
    }

    /// Filters forward and backward: zero phase, squared gain. The ends are extended by point reflection.
    pub(crate) fn zero_phase(&self, x: &[f64]) -> Vec<f64> {
        if x.len() < 2 {
            return x.to_vec();
        }
        let pad = ((6.0 / self.cutoff).ceil() as usize).min(x.len() - 1);
        let last = x.len() - 1;
        let before = (1..=pad).rev().map(|k| 2.0 * x[0] - x[k]);
        let after = (1..=pad).map(|k| 2.0 * x[last] - x[last - k]);
        let extended: Vec<f64> = before.chain(x.iter().copied()).chain(after).collect();
        let mut back = self.forward(&extended);
        back.reverse();
        let mut both = self.forward(&back);
        both.reverse();
        both[pad..=pad + last].to_vec()
    }
}

impl Section {
    fn run(&self, x: &[f64]) -> Vec<f64> {
        let Self { b: [b0, b1, b2], a: [a1, a2] } = *self;
        let first = x.first().copied().unwrap_or(0.0);
        // State in which a constant input of the first sample's value yields its steady output.
        let steady = first * (b0 + b1 + b2) / (1.0 + a1 + a2);
        let mut s2 = b2 * first - a2 * steady;
        let mut s1 = b1 * first - a1 * steady + s2;
        x.iter()
            .map(|&x| {
                let y = b0 * x + s1;
                s1 = b1 * x - a1 * y + s2;
                s2 = b2 * x - a2 * y;
                y
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(filter: impl Fn(&[f64]) -> Vec<f64>, frequency: f64) -> f64 {
        let tone: Vec<f64> = (0..8000).map(|k| (2.0 * PI * frequency * f64::from(k)).sin()).collect();
        let out = &filter(&tone)[2000..6000];
        (out.iter().map(|y| y * y).sum::<f64>() / 2000.0).sqrt()
    }

    #[test]
    fn gains_are_those_of_the_prototypes() {
        let butterworth = LowPass::butterworth(2, 0.05);
        // The bilinear map with prewarping has −3 dB exactly at the cut-off; 4000 samples contain whole periods.
        assert!((gain(|x| butterworth.forward(x), 0.05) - 0.5f64.sqrt()).abs() < 1e-6);
        assert!((gain(|x| butterworth.zero_phase(x), 0.05) - 0.5).abs() < 1e-6);
        let twice = ((PI * 0.1).tan() / (PI * 0.05).tan()).powi(8);
        assert!((gain(|x| butterworth.forward(x), 0.1) - 1.0 / (1.0 + twice).sqrt()).abs() < 1e-6);
        // At its band edge an even Chebyshev filter with gain one at zero frequency has gain one again.
        let chebyshev = LowPass::chebyshev(4, 0.05, 0.04);
        assert!((gain(|x| chebyshev.forward(x), 0.04) - 1.0).abs() < 1e-6);
        assert!(gain(|x| chebyshev.zero_phase(x), 0.06) < 1e-3, "60 dB at half as much again");
    }

    #[test]
    fn derivative_of_a_ramp_and_ends_of_a_line() {
        let filter = LowPass::butterworth(1, 0.02);
        let ramp: Vec<f64> = (0..1000).map(|k| 3.0 * f64::from(k) + 7.0).collect();
        let slope = filter.derivative(&ramp);
        assert!((slope[999] - 3.0).abs() < 1e-9, "{}", slope[999]); // e⁻⁸⁸ of the initial transient remains
        let constant = filter.derivative(&[5.0; 10]);
        assert!(constant.iter().all(|d| d.abs() < 1e-12), "at rest from the first sample");
        for (smooth, x) in filter.zero_phase(&ramp).iter().zip(&ramp) {
            assert!((smooth - x).abs() < 1e-3, "{smooth} for {x}"); // end effect decays over six cut-off periods
        }
    }
}
