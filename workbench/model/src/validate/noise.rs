//! Autoregressive model of the colour of residuals.
//!
//! ```text
//! L(q) v = ε,   L = 1 + l₁ q⁻¹ + … + l_p q⁻ᵖ,   var ε = λ²                                    (1)
//! var Σ w(t) v(t) = Σ_τ R_v(τ) Σ_t w(t) w(t−τ) = λ² Σ_t w̃(t)²,   L* w̃ = w                    (2)
//! ```
//!
//! L* is the filter L in reversed time; (2) is the sum over all lags of both autocorrelations, without truncation. L is
//! computed by the Levinson–Durbin recursion from the sample autocovariances, so 1/L is always stable; the order p is
//! that of least AIC.

/// Largest order.
const MAX_ORDER: usize = 30;

/// The noise model (1).
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    taps: Vec<f64>,
    variance: f64,
}

impl Noise {
    /// Model with the order of least AIC, at most 30 and at most a twentieth of the record length.
    #[must_use]
    pub fn of(v: &[f64]) -> Self {
        let n = v.len() as f64;
        let steps = levinson(v, MAX_ORDER.min(v.len() / 20));
        let criterion = |noise: &Self| n * noise.variance.ln() + 2.0 * noise.order() as f64;
        let best = steps.into_iter().min_by(|x, y| criterion(x).total_cmp(&criterion(y)));
        best.unwrap_or_else(|| Self::white(v))
    }

    /// Model of a given order, or of a lower order if the residuals are perfectly predictable with it.
    #[must_use]
    pub fn of_order(v: &[f64], order: usize) -> Self {
        levinson(v, order.min(v.len() / 4)).pop().unwrap_or_else(|| Self::white(v))
    }

    /// Model of order zero: white noise.
    #[must_use]
    pub fn white(v: &[f64]) -> Self {
        Self { taps: vec![1.0], variance: v.iter().map(|v| v * v).sum::<f64>() / v.len().max(1) as f64 }
    }

    /// The order p.
    #[must_use]
    pub fn order(&self) -> usize {
        self.taps.len() - 1
    }

    /// 1, l₁, …, l_p.
    #[must_use]
    pub fn taps(&self) -> &[f64] {
        &self.taps
    }

    /// λ².
    #[must_use]
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// L x, with zeros before the first sample.
    pub(crate) fn whiten(&self, x: &[f64]) -> Vec<f64> {
        let at = |t: usize| self.taps.iter().enumerate().take(t + 1).map(|(k, l)| l * x[t - k]).sum();
        (0..x.len()).map(at).collect()
    }

    /// L* x, with zeros after the last sample.
    pub(crate) fn whiten_backwards(&self, x: &[f64]) -> Vec<f64> {
        let at = |t: usize| self.taps.iter().zip(&x[t..]).map(|(l, x)| l * x).sum();
        (0..x.len()).map(at).collect()
    }

    /// w̃ of (2), times λ: the sum of its squares is the variance of Σ w v.
    #[must_use]
    pub fn color(&self, w: &[f64]) -> Vec<f64> {
        let mut colored = w.to_vec();
        if self.order() > 0 {
            for t in (0..w.len()).rev() {
                let later: f64 = self.taps[1..].iter().zip(&colored[t + 1..]).map(|(l, x)| l * x).sum();
                colored[t] -= later;
            }
        }
        let scale = self.variance.sqrt();
        colored.iter_mut().for_each(|x| *x *= scale);
        colored
    }
}

/// Models of orders 0, 1, … up to `max`.
fn levinson(v: &[f64], max: usize) -> Vec<Noise> {
    let n = v.len() as f64;
    let covariance = |lag: usize| v.iter().zip(&v[lag..]).map(|(x, y)| x * y).sum::<f64>() / n;
    let mut models = vec![Noise::white(v)];
    for p in 1..=max {
        let last = &models[p - 1];
        if last.variance <= 0.0 {
            break;
        }
        let forward: f64 = last.taps.iter().enumerate().map(|(k, l)| l * covariance(p - k)).sum();
        let reflection = -forward / last.variance;
        let at = |k: usize| last.taps.get(k).copied().unwrap_or(0.0);
        let taps = (0..=p).map(|k| at(k) + reflection * at(p - k)).collect();
        models.push(Noise { taps, variance: last.variance * (1.0 - reflection * reflection) });
    }
    models
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_order_by_hand() {
        // Autocovariances of (1, 2, 2, 1): 10/4 and 8/4, so l₁ = −0.8 and λ² = 2.5 (1 − 0.64).
        let noise = Noise::of_order(&[1.0, 2.0, 2.0, 1.0], 1);
        assert!((noise.taps[1] + 0.8).abs() < 1e-12 && (noise.variance - 0.9).abs() < 1e-12, "{noise:?}");
    }

    #[test]
    fn colouring_undoes_whitening() {
        let noise = Noise { taps: vec![1.0, -1.2, 0.5], variance: 1.0 };
        let w = [1.0, -2.0, 0.5, 3.0, 0.25];
        for (got, want) in noise.whiten_backwards(&noise.color(&w)).iter().zip(w) {
            assert!((got - want).abs() < 1e-12); // rounding of a few products
        }
    }
}
