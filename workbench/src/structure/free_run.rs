//! A model and inputs enter, the simulated output leaves, at the speed of the processor.
//!
//! ```text
//! x(t) = constant + Σ bₖ u1(t−nkb−k) + Σ cₖ u2(t−nkc−k)      no recursion: many samples at once      (1)
//! ŷ(t) = x(t) − Σ aₖ ŷ(t−k)                                   one after another, in registers         (2)
//! ```
//!
//! Starts as [`crate::identify::simulate`] does: from zero, or with a constant term from the first t₀ measured
//! outputs; unstable poles are reflected into the unit circle. Whether there are any is asked of the Schur–Cohn
//! recursion first; eigenvalues are computed only where it does not settle the question.

use crate::identify::{Order, Structure, poles, reflect_unstable};
use crate::trace::Trace;

/// Distance of the reflection coefficients from one within which rounding could decide.
const SURE: f64 = 1e-9;

/// A model that can be simulated.
#[derive(Clone, Debug)]
pub(super) struct FreeRun {
    /// a₁ …, stable.
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    delays: [usize; 2],
    constant: f64,
    /// Measured outputs that it starts from.
    known: usize,
    /// Whether the estimate itself was stable.
    pub stable: bool,
}

impl FreeRun {
    pub(super) fn new(structure: Structure, theta: &[f64]) -> Self {
        let Order { na, nb, nc, nkb, nkc } = structure.order;
        let (a, rest) = theta.split_at(na.into());
        let (b, rest) = rest.split_at(nb.into());
        let (c, rest) = rest.split_at(nc.into());
        let mut model = Self {
            a: a.to_vec(),
            b: b.to_vec(),
            c: c.to_vec(),
            delays: [nkb.into(), nkc.into()],
            constant: rest.first().copied().unwrap_or(0.0),
            known: if structure.offset { structure.order.depth() } else { 0 },
            stable: true,
        };
        if !surely_stable(a) {
            let monic = [&[1.0], a].concat();
            // A double pole on the circle is found this far off it.
            model.stable = poles(&monic).iter().all(|pole| pole.norm() <= 1.0 + 1e-6);
            model.a.copy_from_slice(&reflect_unstable(&monic)[1..]);
        }
        model
    }

    /// The simulated output of a trace, into `output`.
    pub(super) fn simulate(&self, trace: &Trace, output: &mut Vec<f64>) {
        let n = trace.y.len();
        output.clear();
        output.resize(n, self.constant);
        let known = self.known.min(n);
        add_filtered(&self.b, self.delays[0], &trace.u1, output);
        add_filtered(&self.c, self.delays[1], &trace.u2, output);
        output[..known].copy_from_slice(&trace.y[..known]);
        recur(&self.a, known, output);
    }
}

/// (2) in place, from sample `start` on.
fn recur(a: &[f64], start: usize, x: &mut [f64]) {
    match *a {
        [] => {}
        [a1] => recur_by([a1], start, x),
        [a1, a2] => recur_by([a1, a2], start, x),
        [a1, a2, a3] => recur_by([a1, a2, a3], start, x),
        [a1, a2, a3, a4] => recur_by([a1, a2, a3, a4], start, x),
        _ => {
            for t in start..x.len() {
                let past: f64 = a.iter().zip(x[..t].iter().rev()).map(|(a, x)| a * x).sum();
                x[t] -= past;
            }
        }
    }
}

fn recur_by<const N: usize>(a: [f64; N], start: usize, x: &mut [f64]) {
    let mut past: [f64; N] = std::array::from_fn(|k| if k < start { x[start - 1 - k] } else { 0.0 });
    for value in &mut x[start..] {
        let mut now = *value;
        // Oldest first: only the last product waits for the sample just before.
        for k in (0..N).rev() {
            now -= a[k] * past[k];
        }
        past.copy_within(..N - 1, 1);
        past[0] = now;
        *value = now;
    }
}

/// `output(t) += Σ tapsₖ x(t − delay − k)`, zeros before the record.
pub(super) fn add_filtered(taps: &[f64], delay: usize, x: &[f64], output: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has the instructions, as just asked.
        return unsafe { add_avx2(taps, delay, x, output) };
    }
    add(taps, delay, x, output);
}

/// The same operations in the same order, so the same bits, four at a time.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn add_avx2(taps: &[f64], delay: usize, x: &[f64], output: &mut [f64]) {
    add(taps, delay, x, output);
}

#[inline(always)]
fn add(taps: &[f64], delay: usize, x: &[f64], output: &mut [f64]) {
    let mut lag = delay;
    for taps in taps.chunks(4) {
        match *taps {
            [t0, t1, t2, t3] => add_by([t0, t1, t2, t3], lag, x, output),
            [t0, t1, t2] => add_by([t0, t1, t2], lag, x, output),
            [t0, t1] => add_by([t0, t1], lag, x, output),
            [t0] => add_by([t0], lag, x, output),
            _ => {}
        }
        lag += taps.len();
    }
}

#[inline(always)]
fn add_by<const N: usize>(taps: [f64; N], lag: usize, x: &[f64], output: &mut [f64]) {
    let n = output.len().min(x.len());
    let full = (lag + N - 1).min(n);
    for t in lag.min(n)..full {
        output[t] += taps.iter().take(t + 1 - lag).enumerate().map(|(k, tap)| tap * x[t - lag - k]).sum::<f64>();
    }
    let rows = n - full;
    let output = &mut output[full..n];
    let shifted: [&[f64]; N] = std::array::from_fn(|k| &x[(full.max(lag + k) - lag - k)..][..rows]);
    for (i, out) in output.iter_mut().enumerate() {
        let mut sum = *out;
        for k in 0..N {
            sum += taps[k] * shifted[k][i];
        }
        *out = sum;
    }
}

/// Schur–Cohn: every reflection coefficient of `1 + a₁ z⁻¹ + …` clearly below one.
fn surely_stable(a: &[f64]) -> bool {
    let mut held = [0.0; 32];
    let Some(now) = held.get_mut(..a.len()) else { return false };
    now.copy_from_slice(a);
    for order in (1..=a.len()).rev() {
        let k = now[order - 1];
        let rest = 1.0 - k * k;
        if !(k.abs() < 1.0 - SURE && rest > 0.0) {
            return false;
        }
        let below = order - 1;
        for i in 0..below.div_ceil(2) {
            let (low, high) = (now[i], now[below - 1 - i]);
            now[i] = (low - k * high) / rest;
            now[below - 1 - i] = (high - k * low) / rest;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::simulate;

    fn trace(n: usize) -> Trace {
        let wave = |step: f64| (0..n).map(|t| (step * (t * t) as f64).sin()).collect::<Vec<f64>>();
        Trace {
            id: "t".into(),
            interval_s: None,
            irregular_steps: 0,
            y: wave(0.3),
            u1: wave(0.7),
            u2: wave(1.1),
            motion: None,
        }
    }

    /// The plain loop of `identify` gives the same to rounding: every number of terms and delay, a constant term,
    /// records of any length, and unstable poles.
    #[test]
    fn agrees_with_the_plain_simulation() {
        for (order, offset) in [
            (Order::new(1, 1, 1, 1, 1), false),
            (Order::new(2, 4, 3, 1, 5), true),
            (Order::new(3, 5, 1, 0, 2), false),
            (Order::new(4, 2, 6, 3, 0), true),
            (Order::new(6, 1, 9, 2, 2), true),
            (Order::new(0, 2, 0, 1, 0), false),
        ] {
            let structure = Structure { order, offset };
            for (n, gain) in [(1, 0.2), (4, 0.2), (60, 0.2), (60, 1.7)] {
                let trace = trace(n);
                let theta: Vec<f64> = (0..structure.parameters()).map(|k| gain * (k as f64 + 1.0).cos()).collect();
                let want = simulate(&trace, structure, &theta);
                let mut got = vec![];
                FreeRun::new(structure, &theta).simulate(&trace, &mut got);
                assert_eq!(got.len(), want.len());
                let size = want.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
                for (g, w) in got.iter().zip(&want) {
                    assert!((g - w).abs() < 1e-11 * size, "{order:?} {n} {gain}: {g} {w}"); // 60 recursions of rounding
                }
            }
        }
    }

    #[test]
    fn stability_is_that_of_the_poles() {
        // Poles 0.9 and −0.8; 0.9e^{±j}; 1.1 and 0.5; 1 and 0.5.
        assert!(surely_stable(&[-0.1, -0.72]));
        assert!(surely_stable(&[-1.8 * 1.0_f64.cos(), 0.81]));
        assert!(!surely_stable(&[-1.6, 0.55]));
        assert!(!surely_stable(&[-1.5, 0.5]), "on the circle the eigenvalues decide");
        let structure = Structure { order: Order::new(2, 1, 1, 1, 1), offset: false };
        assert!(!FreeRun::new(structure, &[-1.6, 0.55, 1.0, 1.0]).stable);
        assert!(FreeRun::new(structure, &[-1.5, 0.5, 1.0, 1.0]).stable);
    }
}
