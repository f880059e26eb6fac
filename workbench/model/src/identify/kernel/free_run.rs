//! Simulates the output of a model from its inputs, with vectorised loops.
//!
//! ```text
//! x(t) = constant + Σ bₖ u1(t−nkb−k) + Σ cₖ u2(t−nkc−k)      no recursion: several samples at once   (1)
//! ŷ(t) = x(t) − Σ aₖ ŷ(t−k)                                   sample by sample, in registers          (2)
//! ```
//!
//! The simulation starts from zero, or, with a constant term, from the first t₀ measured outputs. Unstable poles are
//! reflected into the unit circle.

use super::filter::{add_filtered, recur};
use crate::identify::Structure;
use crate::identify::poles::{reflect_unstable, stable, surely_stable};
use crate::trace::Trace;

/// A model prepared for simulation.
#[derive(Clone, Debug)]
pub(crate) struct FreeRun {
    /// a₁ …, after reflection of unstable poles.
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    delays: [usize; 2],
    constant: f64,
    /// Number of measured outputs that the simulation starts from.
    known: usize,
    /// Whether the given model was stable.
    pub stable: bool,
}

impl FreeRun {
    pub(crate) fn new(structure: Structure, theta: &[f64]) -> Self {
        let Structure { na, nb, nc, nkb, nkc, .. } = structure;
        let (a, rest) = theta.split_at(na.into());
        let (b, rest) = rest.split_at(nb.into());
        let (c, rest) = rest.split_at(nc.into());
        let mut model = Self {
            a: a.to_vec(),
            b: b.to_vec(),
            c: c.to_vec(),
            delays: [nkb.into(), nkc.into()],
            constant: rest.first().copied().unwrap_or(0.0),
            known: if structure.offset { structure.depth() } else { 0 },
            stable: true,
        };
        if !surely_stable(a) {
            let monic = [&[1.0], a].concat();
            model.stable = stable(&monic);
            model.a.copy_from_slice(&reflect_unstable(&monic)[1..]);
        }
        model
    }

    /// Writes the simulated output of a trace to `output`.
    pub(crate) fn simulate(&self, trace: &Trace, output: &mut Vec<f64>) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::Terms;

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
            ..Trace::default()
        }
    }

    /// The definition, computed sample by sample.
    fn plain(trace: &Trace, structure: Structure, theta: &[f64]) -> Vec<f64> {
        let ([a, b, c], constant) = structure.polynomials(theta);
        let a = reflect_unstable(&a);
        let known = if structure.offset { structure.depth().min(trace.y.len()) } else { 0 };
        let mut output = trace.y[..known].to_vec();
        for t in known..trace.y.len() {
            let sum = |terms: &[f64], x: &[f64]| -> f64 {
                terms.iter().enumerate().take(t + 1).map(|(k, term)| term * x[t - k]).sum()
            };
            let past: f64 = a.iter().enumerate().skip(1).take(t).map(|(k, a)| a * output[t - k]).sum();
            output.push(constant + sum(&b, &trace.u1) + sum(&c, &trace.u2) - past);
        }
        output
    }

    /// The direct loop returns the same values within rounding, for all numbers of terms and delays, with a constant
    /// term, for records of any length, and with unstable poles.
    #[test]
    fn agrees_with_the_plain_simulation() {
        for (order, offset) in [
            (Structure::new(1, 1, 1, 1, 1), false),
            (Structure::new(2, 4, 3, 1, 5), true),
            (Structure::new(3, 5, 1, 0, 2), false),
            (Structure::new(4, 2, 6, 3, 0), true),
            (Structure::new(6, 1, 9, 2, 2), true),
            (Structure::new(0, 2, 0, 1, 0), false),
        ] {
            let structure = Structure { offset, ..order };
            for (n, gain) in [(1, 0.2), (4, 0.2), (60, 0.2), (60, 1.7)] {
                let trace = trace(n);
                let theta: Vec<f64> = (0..structure.parameters()).map(|k| gain * (k as f64 + 1.0).cos()).collect();
                let want = plain(&trace, structure, &theta);
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
    fn a_model_knows_whether_it_was_stable() {
        let structure = Structure::new(2, 1, 1, 1, 1);
        assert!(!FreeRun::new(structure, &[-1.6, 0.55, 1.0, 1.0]).stable);
        assert!(FreeRun::new(structure, &[-1.5, 0.5, 1.0, 1.0]).stable);
    }
}
