//! Step and frequency response from each input, with standard deviations.
//!
//! ```text
//! G(ω) = B(e^−jω) / A(e^−jω),   ∂G/∂a_k = −G e^(−jωk) / A,   ∂G/∂b_k = e^(−jω(nk+k−1)) / A     (1)
//! A s = B 1(t),                A ∂s/∂a_k = −s(t−k),         A ∂s/∂b_k = 1(t−nk−k+1)          (2)
//! var g = (∂g/∂θ)ᵀ cov θ (∂g/∂θ)                                                              (3)
//! ```
//!
//! (1) and (2) are exact derivatives; (3) is the delta method, accurate if the bands are narrow compared with the
//! values. Magnitude bands are computed in decibels; converted to a ratio they stay positive.

use std::f64::consts::PI;

use nalgebra::{Complex, DVector};

use crate::identify::{Estimate, Terms, poles};

/// The input of a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// u1, through B/A.
    U1,
    /// u2, through C/A.
    U2,
}

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertain {
    /// The value at the estimate.
    pub value: f64,
    /// Standard deviation by (3).
    pub sd: f64,
}

impl Uncertain {
    /// Value ∓ k standard deviations.
    #[must_use]
    pub fn band(self, k: f64) -> (f64, f64) {
        (self.value - k * self.sd, self.value + k * self.sd)
    }
}

/// The frequency response at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frequency {
    /// ω, radians per sample.
    pub omega: f64,
    /// 20 log₁₀ |G|, dB.
    pub magnitude_db: Uncertain,
    /// Angle of G in (−180°, 180°].
    pub phase_deg: Uncertain,
}

/// The terms of one input: index of the first parameter, number of terms, delay.
fn terms(estimate: &Estimate, input: Input) -> (usize, usize, usize) {
    let order = estimate.structure;
    match input {
        Input::U1 => (order.na as usize, order.nb as usize, order.nkb as usize),
        Input::U2 => ((order.na + order.nb) as usize, order.nc as usize, order.nkc as usize),
    }
}

fn uncertain(estimate: &Estimate, value: f64, gradient: &DVector<f64>) -> Uncertain {
    Uncertain { value, sd: (&estimate.covariance * gradient).dot(gradient).max(0.0).sqrt() }
}

/// Response to a sine of ω radians per sample; `None` if the input has no terms, or at a pole or zero on the unit
/// circle.
#[must_use]
pub fn frequency(estimate: &Estimate, input: Input, omega: f64) -> Option<Frequency> {
    let (from, count, delay) = terms(estimate, input);
    let na = estimate.structure.na as usize;
    let theta = &estimate.theta;
    let late = |k: usize| Complex::from_polar(1.0, -omega * k as f64);
    let a = (1..=na).fold(Complex::new(1.0, 0.0), |sum, k| sum + late(k) * theta[k - 1]);
    let b = (0..count).fold(Complex::new(0.0, 0.0), |sum, k| sum + late(delay + k) * theta[from + k]);
    let g = b / a;
    if !g.norm().is_normal() {
        return None;
    }
    // ∂ ln G/∂θ: the real part is the derivative of ln |G|, the imaginary part that of the phase.
    let mut slopes = vec![Complex::new(0.0, 0.0); theta.len()];
    for k in 1..=na {
        slopes[k - 1] = -late(k) / a;
    }
    for k in 0..count {
        slopes[from + k] = late(delay + k) / b;
    }
    let decibels = 20.0 / std::f64::consts::LN_10;
    let degrees = 180.0 / PI;
    let part = |scale: f64, pick: fn(&Complex<f64>) -> f64| {
        DVector::from_iterator(theta.len(), slopes.iter().map(|s| scale * pick(s)))
    };
    Some(Frequency {
        omega,
        magnitude_db: uncertain(estimate, decibels * g.norm().ln(), &part(decibels, |s| s.re)),
        phase_deg: uncertain(estimate, degrees * g.arg(), &part(degrees, |s| s.im)),
    })
}

/// Response at `count` logarithmically spaced frequencies over `decades` decades, up to half the sampling rate.
#[must_use]
pub fn sweep(estimate: &Estimate, input: Input, decades: f64, count: u32) -> Vec<Frequency> {
    let omega = |k: u32| PI * 10f64.powf(-decades * (1.0 - f64::from(k) / f64::from(count.max(2) - 1)));
    (0..count).filter_map(|k| frequency(estimate, input, omega(k))).collect()
}

/// Response to a unit step at t = 0, sample by sample; empty if the input has no terms.
#[must_use]
pub fn step(estimate: &Estimate, input: Input, samples: usize) -> Vec<Uncertain> {
    let (from, count, delay) = terms(estimate, input);
    if count == 0 {
        return vec![];
    }
    let na = estimate.structure.na as usize;
    let theta = &estimate.theta;
    let mut response: Vec<f64> = Vec::with_capacity(samples);
    let mut slopes: Vec<DVector<f64>> = Vec::with_capacity(samples);
    for t in 0..samples {
        let mut slope = DVector::zeros(theta.len());
        let mut value = 0.0;
        for k in (1..=na).take_while(|&k| k <= t) {
            value -= theta[k - 1] * response[t - k];
            slope[k - 1] -= response[t - k];
            slope -= &slopes[t - k] * theta[k - 1];
        }
        for k in (0..count).take_while(|&k| delay + k <= t) {
            value += theta[from + k];
            slope[from + k] += 1.0;
        }
        response.push(value);
        slopes.push(slope);
    }
    response.iter().zip(&slopes).map(|(&value, slope)| uncertain(estimate, value, slope)).collect()
}

/// Number of samples after which the slowest pole has decayed to 1 %, between 20 and 1000; 50 for an unstable model.
#[must_use]
pub fn settling(estimate: &Estimate) -> usize {
    let ([a, _, _], _) = estimate.structure.polynomials(estimate.theta.as_slice());
    let slowest = poles(&a).iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    if slowest >= 1.0 {
        return 50;
    }
    let decayed = (0.01_f64.ln() / slowest.max(1e-3).ln()).ceil();
    let depth = estimate.structure.depth();
    (20..=1000).find(|&n| n as f64 >= decayed + depth as f64).unwrap_or(1000)
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::identify::Structure;

    fn first_order() -> Estimate {
        Estimate::given(
            Structure::new(1, 1, 0, 1, 1),
            DVector::from_vec(vec![-0.5, 2.0]),
            DMatrix::from_diagonal(&DVector::from_vec(vec![1e-4, 4e-4])),
        )
    }

    #[test]
    fn steady_state_of_a_first_order_system() {
        // b/(1 + a) = 4; ∂/∂a = −b/(1 + a)² = −8, ∂/∂b = 2, so sd² = 64·1e-4 + 4·4e-4 = 8e-3.
        let last = step(&first_order(), Input::U1, 60).pop().expect("samples");
        assert!((last.value - 4.0).abs() < 1e-12 && (last.sd - 8e-3_f64.sqrt()).abs() < 1e-9, "{last:?}"); // 0.5^60
        let low = frequency(&first_order(), Input::U1, 1e-9).expect("a response");
        let decibels = 20.0 * 4.0_f64.log10();
        let sd = 20.0 / std::f64::consts::LN_10 * 8e-3_f64.sqrt() / 4.0;
        assert!((low.magnitude_db.value - decibels).abs() < 1e-6 && (low.magnitude_db.sd - sd).abs() < 1e-6, "{low:?}");
        assert!(step(&first_order(), Input::U2, 5).is_empty() && frequency(&first_order(), Input::U2, 1.0).is_none());
    }

    #[test]
    fn gradients_are_those_of_the_response() {
        let base = first_order();
        let at =
            |theta: DVector<f64>| frequency(&Estimate { theta, ..base.clone() }, Input::U1, 0.7).expect("response");
        let (middle, h) = (at(base.theta.clone()), 1e-6);
        let moved = [at(DVector::from_vec(vec![-0.5 + h, 2.0])), at(DVector::from_vec(vec![-0.5, 2.0 + h]))];
        let sd = |pick: fn(&Frequency) -> f64| {
            let slope = moved.iter().map(|m| (pick(m) - pick(&middle)) / h).collect::<Vec<_>>();
            (slope[0].powi(2) * 1e-4 + slope[1].powi(2) * 4e-4).sqrt()
        };
        // One-sided differences with a step of 1e-6 are accurate to five digits.
        assert!((sd(|f| f.phase_deg.value) / middle.phase_deg.sd - 1.0).abs() < 1e-4);
        assert!((sd(|f| f.magnitude_db.value) / middle.magnitude_db.sd - 1.0).abs() < 1e-4);
    }
}
