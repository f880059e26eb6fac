//! Lines of orders of the shaft in a signal: the true rate, and the smallest line that stands out.
//!
//! ```text
//! A(o)  = |2/N Σ y_n e^(−j o θ_n)|,   y less its mean                     (1)  amplitude of order o
//! σ²    = mean of A²/2 over control orders, which no machine has          (2)
//! line  = σ √(−2 ln α) + 1.28 σ                                           (3)  stands out at rate α in 9 of 10 records
//! ```
//!
//! By (1) with the angle integrated from a velocity in rpm or rad/s at an assumed rate, the lines of the rotor (orders
//! 1, 2, 3 …) are sharp at the true rate only: the logger's rate follows from them.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::trace::median;

/// Orders between those of a rotor, and no bearing's.
const CONTROLS: [f64; 8] = [0.83, 0.91, 1.09, 1.17, 1.29, 2.31, 2.73, 3.37];
/// Orders of a rotor that are looked at.
const ROTOR: u32 = 12;
/// Part of the given rate in which the true one is searched, and the step.
const SEARCHED: f64 = 0.1;
const STEP: f64 = 2.5e-4;
/// Rates that are searched if none is given, the step as a part of each, and the traces and rows that tell them: each
/// second of so many.
const LOWEST_HZ: f64 = 50.0;
const HIGHEST_HZ: f64 = 50_000.0;
const WIDE_STEP: f64 = 1e-3;
const STARTS: usize = 3;
const START: usize = 8000;
const EVERY: usize = 2;
/// Multiples of a rate that are tried, and the part of the largest logarithm of a sharpness that is as sharp.
const MULTIPLES: u32 = 6;
const AS_SHARP: f64 = 0.9;
/// Least ratio of the lines at the best rate to those at the typical one.
const SHARP: f64 = 20.0;

/// (1).
#[must_use]
pub fn amplitude(y: &[f64], angle_rad: &[f64], order: f64) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
    let (mut re, mut im) = (0.0, 0.0);
    for (y, angle) in y.iter().zip(angle_rad) {
        let (sin, cos) = (order * angle).sin_cos();
        re += (y - mean) * cos;
        im += (y - mean) * sin;
    }
    2.0 * re.hypot(im) / y.len().max(1) as f64
}

/// (1) at these orders, from the first rows of a long record.
#[must_use]
pub fn spectrum(y: &[f64], angle_rad: &[f64], orders: &[f64]) -> Vec<f64> {
    const ROWS: usize = 20_000;
    let rows = y.len().min(angle_rad.len()).min(ROWS);
    orders.par_iter().map(|order| amplitude(&y[..rows], &angle_rad[..rows], *order)).collect()
}

/// σ of (2).
#[must_use]
pub fn floor(y: &[f64], angle_rad: &[f64]) -> f64 {
    let squares: f64 = CONTROLS.iter().map(|order| amplitude(y, angle_rad, *order).powi(2)).sum();
    (0.5 * squares / CONTROLS.len() as f64).sqrt()
}

/// (3) at a false-alarm rate.
#[must_use]
pub fn smallest_line(floor: f64, rate: f64) -> f64 {
    floor * ((-2.0 * rate.ln()).sqrt() + 1.28)
}

/// The rate at which the lines of the rotor are sharpest, by traces of a signal and of the velocity in rad/s, and how
/// much sharper they are than at other rates; `None` if no rate is.
#[must_use]
pub fn rate(traces: &[(&[f64], &[f64])], given_hz: f64) -> Option<(f64, f64)> {
    sharpest(traces, &beside(given_hz), 1).filter(|(_, sharpness)| *sharpness > SHARP)
}

/// The rates beside one.
fn beside(rate_hz: f64) -> Vec<f64> {
    let steps = (SEARCHED / STEP) as i32;
    (-steps..=steps).map(|k| rate_hz * (1.0 + STEP * f64::from(k))).collect()
}

/// The same where no rate is known, by the starts of some traces: of the rates of recordings of drives, and then of
/// those beside the sharpest one.
#[must_use]
pub fn rate_anywhere(traces: &[(&[f64], &[f64])]) -> Option<(f64, f64)> {
    let starts: Vec<(&[f64], &[f64])> = traces
        .iter()
        .take(STARTS)
        .map(|(y, velocity)| (&y[..y.len().min(START)], &velocity[..velocity.len().min(START)]))
        .collect();
    let steps = ((HIGHEST_HZ / LOWEST_HZ).ln() / WIDE_STEP) as i32;
    let rates: Vec<f64> = (0..=steps).map(|k| LOWEST_HZ * (WIDE_STEP * f64::from(k)).exp()).collect();
    let (near, _) = sharpest(&starts, &rates, EVERY)?;
    // At a multiple of the rate lines of the orders 1, 2 … are those of multiples: the lowest of equals is the rate.
    let at = |k: u32| sharpest(&starts, &beside(near / f64::from(k)), EVERY);
    let sharpest_of: Vec<(f64, f64)> = (1..=MULTIPLES).rev().filter_map(at).collect();
    let most = sharpest_of.iter().map(|(_, sharpness)| sharpness.ln()).fold(0.0, f64::max);
    let is_as_sharp = |sharpness: f64| sharpness > SHARP && sharpness.ln() > AS_SHARP * most;
    sharpest_of.into_iter().find(|(_, sharpness)| is_as_sharp(*sharpness))
}

/// The sharpest of these rates by one row in `every`, and how much sharper it is than the typical one.
fn sharpest(traces: &[(&[f64], &[f64])], rates: &[f64], every: usize) -> Option<(f64, f64)> {
    // The angle at a rate of one; that at another rate is in inverse proportion to it.
    let units: Vec<(Vec<f64>, Vec<f64>)> = traces
        .iter()
        .map(|(y, velocity)| {
            let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
            let rows = |x: Vec<f64>| x.into_iter().step_by(every).collect();
            (rows(y.iter().map(|y| y - mean).collect()), rows(angle(velocity, 1.0)))
        })
        .collect();
    let of_rate =
        |rate: &f64| units.iter().map(|(y, unit)| (rotor_power(y, unit, *rate) + f64::MIN_POSITIVE).ln()).sum();
    let likeness: Vec<f64> = rates.par_iter().map(of_rate).collect();
    let count = traces.len().max(1) as f64;
    let best = (0..rates.len()).max_by(|one, other| likeness[*one].total_cmp(&likeness[*other]))?;
    // Of a ratio of powers, per trace.
    let sharpness = ((likeness[best] - median(&likeness)) / count).exp();
    Some((rates[best], sharpness))
}

/// Power of the lines of the rotor of a signal without mean, by the angle at a rate of one.
fn rotor_power(y: &[f64], unit_rad: &[f64], rate_hz: f64) -> f64 {
    let mut sums = [[0.0; 2]; ROTOR as usize];
    for (y, angle) in y.iter().zip(unit_rad) {
        let (sin, cos) = (angle / rate_hz).sin_cos();
        // e^(jkθ) by repeated multiplication.
        let (mut re, mut im) = (1.0, 0.0);
        for sum in &mut sums {
            (re, im) = (re * cos - im * sin, re * sin + im * cos);
            sum[0] += y * re;
            sum[1] += y * im;
        }
    }
    sums.iter().map(|[re, im]| re * re + im * im).sum::<f64>() / (y.len().max(1) as f64).powi(2)
}

/// The angle, rad, by the trapezoidal rule.
#[must_use]
pub fn angle(velocity_rad_s: &[f64], rate_hz: f64) -> Vec<f64> {
    let (mut sum, mut last) = (0.0, velocity_rad_s.first().copied().unwrap_or(0.0));
    let each = |velocity: &f64| {
        sum += 0.5 * (last + velocity) / rate_hz;
        last = *velocity;
        sum
    };
    velocity_rad_s.iter().map(each).collect()
}

/// Turns, both directions counted.
#[must_use]
pub fn turns(angle_rad: &[f64]) -> f64 {
    angle_rad.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step < 0.5 * TAU).sum::<f64>() / TAU
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// A signal with lines at the orders 1 and 5 in noise, and the velocity, rpm rounded, at this rate.
    fn record(rate_hz: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let (mut angle, mut y, mut velocity) = (0.3, Vec::new(), Vec::new());
        for k in 0..9000 {
            let speed = 84.0 + 0.4 * (f64::from(k) * 0.002).sin();
            let noise: f64 = StandardNormal.sample(&mut random);
            y.push(20.0 + 0.5 * f64::sin(angle) + 0.3 * f64::cos(5.0 * angle + 1.0) + noise);
            velocity.push((speed * 60.0 / TAU).round() * TAU / 60.0);
            angle += speed / rate_hz;
        }
        (y, velocity)
    }

    #[test]
    fn the_true_rate_is_found_beside_the_given_one() {
        let records: Vec<_> = (0..4).map(|seed| record(1919.0, seed)).collect();
        let traces: Vec<_> = records.iter().map(|(y, v)| (y.as_slice(), v.as_slice())).collect();
        let (found, sharpness) = rate(&traces, 2000.0).expect("lines");
        // 4.7 s resolve 1/4.7 Hz of 67 Hz, 0.3 %; the rounding of the speed is 0.06 %.
        assert!((found / 1919.0 - 1.0).abs() < 1.5e-3, "{found}");
        assert!(sharpness > SHARP);
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(9);
        let noise: Vec<f64> = (0..9000).map(|_| StandardNormal.sample(&mut random)).collect();
        assert!(rate(&[(noise.as_slice(), records[0].1.as_slice())], 2000.0).is_none());
    }

    #[test]
    fn the_true_rate_is_found_where_none_is_given() {
        for rate_hz in [480.0, 1919.0, 3000.0] {
            let records: Vec<(Vec<f64>, Vec<f64>)> = (1..=4).map(|seed| record(rate_hz, seed)).collect();
            let traces: Vec<(&[f64], &[f64])> = records.iter().map(|(y, w)| (y.as_slice(), w.as_slice())).collect();
            let (found, _) = rate_anywhere(&traces).expect("lines");
            assert!((found / rate_hz - 1.0).abs() < 1e-3, "{rate_hz}: {found}"); // the step of the search
        }
    }

    #[test]
    fn a_line_above_the_smallest_one_stands_out() {
        let (y, velocity) = record(1919.0, 7);
        let angle = angle(&velocity, 1919.0);
        let floor = floor(&y, &angle);
        // White noise: √(2/N) for each part of (1).
        assert!((0.5..2.0).contains(&(floor / (2.0_f64 / 9000.0).sqrt())), "{floor}");
        assert!(amplitude(&y, &angle, 5.0) > smallest_line(floor, 0.01));
        assert!((turns(&angle) - 9000.0 / 1919.0 * 84.0 / TAU).abs() < 1.0);
    }

    #[test]
    fn an_amplitude_is_that_of_the_wave() {
        // Five whole turns: the sums of the other products are zero.
        let angle: Vec<f64> = (0..1000).map(|k| 5.0 * TAU * f64::from(k) / 1000.0).collect();
        let y: Vec<f64> = angle.iter().map(|angle| 4.0 + 0.7 * (3.0 * angle + 1.0).cos()).collect();
        assert!((amplitude(&y, &angle, 3.0) - 0.7).abs() < 1e-12 && amplitude(&y, &angle, 4.0) < 1e-12); // rounding
        // √(−2 ln 0.01) = 3.034854.
        assert!((smallest_line(2.0, 0.01) - 2.0 * (3.034_854 + 1.28)).abs() < 1e-5);
        // The third step is a wrap.
        assert!((turns(&[0.0, 3.0, 6.0, 9.0 - TAU, 12.0 - TAU]) - 9.0 / TAU).abs() < 1e-12);
    }
}
