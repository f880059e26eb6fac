//! Linear plants with two inputs whose parameters are known in closed form, and records of them.
//!
//! ```text
//! x(t) = −Σ aₖ x(t−k) + Σ bₖ u1(t−k) + Σ cₖ u2(t−k) [+ d],   y = x + e,   e, d white
//! A(q) = Π (1 − p q⁻¹),   p = exp(−T/τ) or a pair of a resonance,   B(1)/A(1), C(1)/A(1) given
//! ```
//!
//! Open loop: u1 and u2 are coloured noise (first order). Closed loop: `u1 = Kp ε + ∫ Ki ε`, `ε = reference − y`, on
//! the *measured* output, so that u1 carries the noise; reference and u2 are coloured noise. Everything starts at rest.

use std::f64::consts::TAU;

use crate::Inputs;
use bearing_watch::plan::Structure;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A factor of A(q).
#[derive(Clone, Copy, Debug)]
pub enum Mode {
    /// One real pole: time constant, s.
    Lag(f64),
    /// A pair of poles: natural frequency in Hz and damping ratio.
    Resonance(f64, f64),
}

/// A plant, its surroundings and its sampling.
#[derive(Clone, Debug)]
pub struct Plant {
    /// For tables.
    pub name: &'static str,
    /// Sampling rate.
    pub rate_hz: f64,
    /// Factors of A(q).
    pub modes: &'static [Mode],
    /// Shares of the taps of u1 in its gain, adding up to one, and the gain.
    pub b: (&'static [f64], f64),
    /// The same for u2.
    pub c: (&'static [f64], f64),
    /// Delays of u1 and u2 in samples, ≥ 1.
    pub delays: [u8; 2],
    /// Kp and Ki (1/s) in closed loop.
    pub control: Option<[f64; 2]>,
    /// Time constants of the coloured noises behind u1 (or the reference) and u2, s.
    pub colour_s: [f64; 2],
    /// Whether they go through their low-pass once more, so that their differences are smooth too.
    pub smooth: bool,
}

impl Plant {
    /// Structure of the model that is exactly this plant.
    #[must_use]
    pub fn structure(&self) -> Structure {
        let count = |terms: usize| u8::try_from(terms).expect("few terms");
        let [nkb, nkc] = self.delays;
        Structure::new(count(self.denominator().len() - 1), count(self.b.0.len()), count(self.c.0.len()), nkb, nkc)
    }

    /// 1, a₁, ….
    #[must_use]
    pub fn denominator(&self) -> Vec<f64> {
        self.slowed(1.0)
    }

    /// The same with all times longer by a factor.
    fn slowed(&self, by: f64) -> Vec<f64> {
        self.modes.iter().fold(vec![1.0], |a, mode| match *mode {
            Mode::Lag(tau) => product(&a, &[1.0, -(-1.0 / (by * tau * self.rate_hz)).exp()]),
            Mode::Resonance(f, damping) => {
                let w = TAU * f / self.rate_hz / by;
                let radius = (-damping * w).exp();
                product(&a, &[1.0, -2.0 * radius * (w * (1.0 - damping * damping).sqrt()).cos(), radius * radius])
            }
        })
    }

    /// a₁…, b₁…, c₁….
    #[must_use]
    pub fn truth(&self) -> Vec<f64> {
        self.model(1.0, 1.0)
    }

    /// What a data sheet might say: all times a fifth too long, gains a fifth too small.
    #[must_use]
    pub fn nominal(&self) -> Vec<f64> {
        self.model(1.2, 0.8)
    }

    fn model(&self, slower: f64, stronger: f64) -> Vec<f64> {
        let a = self.slowed(slower);
        let unit: f64 = a.iter().sum::<f64>() * stronger;
        let taps = |(shares, gain): (&[f64], f64)| shares.iter().map(|share| share * gain * unit).collect::<Vec<_>>();
        [&a[1..], &taps(self.b), &taps(self.c)].concat()
    }

    /// A source of samples with output noise of this standard deviation.
    #[must_use]
    pub fn source(&self, noise: f64, seed: u64) -> Source {
        let [nkb, nkc] = self.delays.map(usize::from);
        let a = self.denominator();
        let truth = self.truth();
        let (b, c) = truth[a.len() - 1..].split_at(self.b.0.len());
        Source {
            b: b.to_vec(),
            c: c.to_vec(),
            past: [Past::new(a.len() - 1), Past::new(nkb + b.len() - 1), Past::new(nkc + c.len() - 1)],
            delays: [nkb, nkc],
            a: a[1..].to_vec(),
            control: self.control.map(|[kp, ki]| [kp, ki / self.rate_hz]),
            colour: self.colour_s.map(|tau| (-1.0 / (tau * self.rate_hz)).exp()),
            signals: [[0.0; 2]; 2],
            smooth: self.smooth,
            integral: 0.0,
            noise,
            disturbance: 0.0,
            held: false,
            generator: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Standard deviation of the noise at this ratio of the powers of x and e, dB.
    #[must_use]
    pub fn noise(&self, ratio_db: f64) -> f64 {
        // 400 time constants of 50 ms at 1 kHz: rms to a few per cent, 0.2 dB.
        let count = (20.0 * self.rate_hz) as usize;
        let power: f64 = self.source(0.0, 1).take(count).map(|sample| f64::from(sample.y).powi(2)).sum();
        (power / count as f64).sqrt() / 10_f64.powf(ratio_db / 20.0)
    }
}

fn product(x: &[f64], y: &[f64]) -> Vec<f64> {
    let mut z = vec![0.0; x.len() + y.len() - 1];
    for (i, x) in x.iter().enumerate() {
        y.iter().enumerate().for_each(|(j, y)| z[i + j] += x * y);
    }
    z
}

/// The last values of a signal, newest first.
#[derive(Clone, Debug)]
struct Past(Vec<f64>);

impl Past {
    fn new(depth: usize) -> Self {
        Self(vec![0.0; depth])
    }

    fn push(&mut self, newest: f64) {
        self.0.rotate_right(1);
        if let Some(cell) = self.0.first_mut() {
            *cell = newest;
        }
    }

    /// Σ terms(k) x(t − delay − k), where the newest value is x(t−1).
    fn dot(&self, terms: &[f64], delay: usize) -> f64 {
        terms.iter().zip(&self.0[delay - 1..]).map(|(term, x)| term * x).sum()
    }
}

/// Samples without end; single precision, as a drive hands them over.
#[derive(Clone, Debug)]
pub struct Source {
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    past: [Past; 3],
    delays: [usize; 2],
    /// Kp and Ki T.
    control: Option<[f64; 2]>,
    colour: [f64; 2],
    /// u1 or the reference, and u2: after one low-pass, and after two.
    signals: [[f64; 2]; 2],
    smooth: bool,
    integral: f64,
    noise: f64,
    disturbance: f64,
    /// Whether reference (or u1) and u2 rest.
    held: bool,
    generator: ChaCha8Rng,
}

impl Source {
    /// From here on reference (or u1) and u2 rest on their values, and the noise is another; or all is as it was.
    pub const fn hold(&mut self, held: bool, noise: f64) {
        (self.held, self.noise) = (held, noise);
    }

    /// With a disturbance of this standard deviation inside the plant: white equation error.
    #[must_use]
    pub const fn disturbed(mut self, deviation: f64) -> Self {
        self.disturbance = deviation;
        self
    }
}

impl Iterator for Source {
    type Item = Inputs;

    fn next(&mut self) -> Option<Inputs> {
        let [xs, u1s, u2s] = &self.past;
        let mut x = u1s.dot(&self.b, self.delays[0]) + u2s.dot(&self.c, self.delays[1]) - xs.dot(&self.a, 1);
        if self.disturbance > 0.0 {
            let d: f64 = StandardNormal.sample(&mut self.generator);
            x += self.disturbance * d;
        }
        let [n1, n2, e]: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(&mut self.generator));
        let y = x + self.noise * e;
        for (([once, twice], pole), white) in self.signals.iter_mut().zip(self.colour).zip([n1, n2]) {
            if self.held {
                break;
            }
            *once = pole * *once + (1.0 - pole * pole).sqrt() * white;
            *twice += (1.0 - pole) * (*once - *twice);
        }
        let [first, u2] = self.signals.map(|[once, twice]| if self.smooth { twice } else { once });
        let u1 = self.control.map_or(first, |[kp, ki]| {
            self.integral += ki * (first - y);
            kp * (first - y) + self.integral
        });
        self.past.iter_mut().zip([x, u1, u2]).for_each(|(past, newest)| past.push(newest));
        Some(Inputs { y: y as f32, u1: u1 as f32, u2: u2 as f32 })
    }
}

const MOTOR: Plant = Plant {
    name: "1 kHz na 1 open",
    rate_hz: 1000.0,
    modes: &[Mode::Lag(0.05)],
    b: (&[1.0], 1.0),
    c: (&[1.0], -0.8),
    delays: [1, 1],
    control: None,
    colour_s: [0.01, 0.005],
    smooth: false,
};

/// Open and closed loop at 1 kHz and 10 kHz, one to three poles; at 10 kHz few taps. The slowest pole is a motor's
/// mechanical time constant, the next ones its winding's, a filter's, or a shaft's resonance.
pub const PLANTS: [Plant; 12] = [
    MOTOR,
    Plant { name: "1 kHz na 2 open", modes: TWO, b: (&[0.6, 0.4], 1.0), ..MOTOR },
    Plant { name: "1 kHz na 3 open", modes: THREE, b: (&[0.6, 0.4], 1.0), ..MOTOR },
    Plant { name: "1 kHz na 1 closed", control: PI, ..MOTOR },
    Plant { name: "1 kHz na 2 closed", modes: TWO, b: (&[0.6, 0.4], 1.0), control: PI, ..MOTOR },
    Plant { name: "1 kHz na 3 closed", modes: THREE, b: (&[0.6, 0.4], 1.0), control: PI, ..MOTOR },
    Plant { name: "10 kHz na 1 open", rate_hz: 1e4, ..MOTOR },
    Plant { name: "10 kHz na 2 open", rate_hz: 1e4, modes: TWO, delays: [2, 1], ..MOTOR },
    Plant { name: "10 kHz na 3 open", rate_hz: 1e4, modes: THREE, delays: [2, 3], ..MOTOR },
    Plant { name: "10 kHz na 1 closed", rate_hz: 1e4, control: PI, ..MOTOR },
    Plant { name: "10 kHz na 2 closed", rate_hz: 1e4, modes: TWO, delays: [2, 1], control: PI, ..MOTOR },
    Plant { name: "10 kHz na 3 closed", rate_hz: 1e4, modes: THREE, delays: [2, 3], control: PI, ..MOTOR },
];

const TWO: &[Mode] = &[Mode::Lag(0.05), Mode::Lag(0.003)];
const THREE: &[Mode] = &[Mode::Lag(0.05), Mode::Resonance(120.0, 0.3)];
const PI: Option<[f64; 2]> = Some([2.0, 40.0]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_has_the_poles_and_gains_it_was_made_of() {
        for plant in PLANTS {
            let (structure, truth) = (plant.structure(), plant.truth());
            assert_eq!(truth.len(), structure.parameters());
            let sum = |from: u8, count: u8| truth[from as usize..][..count as usize].iter().sum::<f64>();
            let unit = 1.0 + sum(0, structure.na);
            let close = |x: f64, y: f64| (x - y).abs() < 1e-9; // 1 − Π of poles near one loses six digits
            assert!(close(sum(structure.na, structure.nb) / unit, plant.b.1), "{}", plant.name);
            assert!(close(sum(structure.na + structure.nb, structure.nc) / unit, plant.c.1), "{}", plant.name);
            let pole = (-1.0 / (0.05 * plant.rate_hz)).exp();
            let at_pole = plant.denominator().iter().fold(0.0, |sum, a| sum * pole + a);
            assert!(at_pole.abs() < 1e-12, "{}: {at_pole}", plant.name); // rounding
        }
    }

    #[test]
    fn noise_has_the_ratio_asked_for_and_reaches_u1_in_closed_loop_only() {
        for plant in PLANTS {
            let count = 100_000;
            let record = |noise| plant.source(noise, 7).take(count).collect::<Vec<_>>();
            let (clean, noisy) = (record(0.0), record(plant.noise(20.0)));
            let power = |of: &dyn Fn(usize) -> f32| (0..count).map(|t| f64::from(of(t)).powi(2)).sum::<f64>();
            let ratio = 10.0 * (power(&|t| clean[t].y) / power(&|t| noisy[t].y - clean[t].y)).log10();
            if plant.control.is_none() {
                // Output power of 10 s of a slow process is known to ten or twenty per cent.
                assert!((ratio - 20.0).abs() < 1.0, "{}: {ratio}", plant.name);
            }
            let moved = power(&|t| noisy[t].u1 - clean[t].u1);
            assert_eq!(moved > 0.0, plant.control.is_some(), "{}", plant.name);
        }
    }
}
