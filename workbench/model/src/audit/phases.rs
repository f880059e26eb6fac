//! The phase whose current sensor has an offset, also where the current loop hides it.
//!
//! The sum of three measured currents is the sum of the offsets of their sensors, whatever the drive does. A current loop
//! makes the measured currents follow their references, so that none of their means tells the phase: the true currents
//! have the opposite offset, which shakes the shaft once an electrical turn.
//!
//! ```text
//! i_q = p₀ ω̇ + p₁ ω + p₂ sgn ω + p₃ + α cos ε + β sin ε                                                  (1)
//! ε = n θ + φ,   the direction of the measured vector at torques of one sign                             (2)
//! ```
//!
//! (α, β) is the offset in the frame of the stator: of an offset o in one phase 2 o/3 along it. n and φ follow from the
//! direction of the vector against the angle. All columns of (1) pass the same means of neighbouring rows.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use crate::statistics::mean_sd;

/// Largest number of pole pairs, and coherence of vector and angle.
const PAIRS: i32 = 30;
const COHERENT: f64 = 0.5;
/// Part of the expected offset vector, its deviations, and its angle from the phase: half way to the next one is 60°.
const LEAST: f64 = 0.4;
const DEVIATIONS: f64 = 4.0;
const BESIDE: f64 = 40.0 * PI / 180.0;
/// Parts of an electrical turn in the means of neighbouring rows.
const PARTS: f64 = 16.0;
/// Fewest rows.
const FEWEST: usize = 500;

/// The phase, 0 to 2, whose sensor has the offset `sum_a` of the three currents; `None` if it is not known. Without an
/// angle, rad, a loop that hides the offset hides the phase.
pub(super) fn of_offset(phases: [&[f64]; 3], sum_a: f64, motion: Option<(&[f64], f64)>) -> Option<usize> {
    let [a, b, c] = phases.map(|phase| mean_sd(&finite(phase)).0);
    let expected = 2.0 / 3.0 * sum_a;
    nearest((2.0 * a - b - c) / 3.0, (b - c) / 3.0_f64.sqrt(), expected).or_else(|| {
        let (angle, rate_hz) = motion?;
        let ([alpha, beta], deviation) = vector(phases, angle, rate_hz)?;
        nearest(alpha, beta, expected).filter(|_| alpha.hypot(beta) > DEVIATIONS * deviation)
    })
}

fn finite(x: &[f64]) -> Vec<f64> {
    x.iter().copied().filter(|x| x.is_finite()).collect()
}

/// The phase along which a vector of this size points.
fn nearest(alpha: f64, beta: f64, expected: f64) -> Option<usize> {
    if alpha.hypot(beta) < LEAST * expected.abs() {
        return None;
    }
    let direction = (beta * expected.signum()).atan2(alpha * expected.signum());
    (0..3).find(|phase| wrapped(direction - *phase as f64 * TAU / 3.0).abs() < BESIDE)
}

fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// (α, β) of (1), and its standard deviation.
fn vector(phases: [&[f64]; 3], angle: &[f64], rate_hz: f64) -> Option<([f64; 2], f64)> {
    let rows = angle.len().min(phases[0].len());
    let all_finite = phases.iter().all(|phase| phase[..rows].iter().all(|x| x.is_finite()));
    if rows < FEWEST || !all_finite || !angle[..rows].iter().all(|x| x.is_finite()) {
        return None;
    }
    let clarke = |k: usize| {
        let [a, b, c] = [0, 1, 2].map(|phase| phases[phase][k]);
        ((2.0 * a - b - c) / 3.0, (b - c) / 3.0_f64.sqrt())
    };
    let vectors: Vec<(f64, f64)> = (0..rows).map(clarke).collect();
    let turned: Vec<f64> = unwrapped(&angle[..rows]);
    let (pairs, phi) = frame(&vectors, &turned)?;
    let epsilon: Vec<f64> = turned.iter().map(|angle| pairs * angle + phi).collect();
    let current: Vec<f64> = vectors.iter().zip(&epsilon).map(|((a, b), e)| a * e.cos() + b * e.sin()).collect();
    let speeds: Vec<f64> = turned.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let speed = speeds.iter().sum::<f64>() / speeds.len() as f64;
    let near = (TAU / (PARTS * pairs.abs() * speed)).round().clamp(1.0, 0.02 * rows as f64) as usize;
    fitted(&current, &turned, &epsilon, (near, rate_hz))
}

fn unwrapped(angle: &[f64]) -> Vec<f64> {
    let mut turned = angle[0];
    let rest = angle.windows(2).map(|pair| {
        turned += wrapped(pair[1] - pair[0]);
        turned
    });
    std::iter::once(angle[0]).chain(rest).collect()
}

/// n and φ of (2): the torque has either sign, so that the vector's direction is known by half a turn.
fn frame(vectors: &[(f64, f64)], turned: &[f64]) -> Option<(f64, f64)> {
    let power: f64 = vectors.iter().map(|(a, b)| a * a + b * b).sum();
    let coherence = |pairs: i32| {
        let each = vectors.iter().zip(turned).map(|((a, b), angle)| {
            // The square of the vector, turned back by 2 n θ.
            let (sin, cos) = (2.0 * f64::from(pairs) * angle).sin_cos();
            let (re, im) = (a * a - b * b, 2.0 * a * b);
            (re * cos + im * sin, im * cos - re * sin)
        });
        let (re, im) = each.fold((0.0, 0.0), |(x, y), (re, im)| (x + re, y + im));
        (re.hypot(im) / power, f64::from(pairs), 0.5 * im.atan2(re))
    };
    let all = (-PAIRS..=PAIRS).filter(|pairs| *pairs != 0).map(coherence);
    let (coherent, pairs, phi) = all.max_by(|one, other| one.0.total_cmp(&other.0))?;
    (coherent > COHERENT).then_some((pairs, phi))
}

/// Least squares of (1).
fn fitted(current: &[f64], turned: &[f64], epsilon: &[f64], (near, rate_hz): (usize, f64)) -> Option<([f64; 2], f64)> {
    // Means over `near` rows, twice; differences of them are exactly those of the angle.
    let mean = |x: &[f64]| -> Vec<f64> { x.windows(near).map(|x| x.iter().sum::<f64>() / near as f64).collect() };
    let slope =
        |x: &[f64]| -> Vec<f64> { x.windows(near + 1).map(|x| (x[near] - x[0]) * rate_hz / near as f64).collect() };
    let middles: Vec<f64> = turned.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let speed = mean(&slope(&middles));
    let acceleration = slope(&slope(turned));
    let smooth = |x: Vec<f64>| mean(&mean(&x));
    let pairs = |x: &[f64]| x.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect::<Vec<f64>>();
    let current = smooth(pairs(current));
    let cosine = smooth(pairs(&epsilon.iter().map(|e| e.cos()).collect::<Vec<_>>()));
    let sine = smooth(pairs(&epsilon.iter().map(|e| e.sin()).collect::<Vec<_>>()));
    let rows = [acceleration.len(), speed.len(), current.len()].into_iter().min()?;
    let usual = mean_sd(&speed).1.max(f64::MIN_POSITIVE);
    let columns = |row: usize, column: usize| match column {
        0 => acceleration[row],
        1 => speed[row],
        2 => (speed[row] / (0.05 * usual)).clamp(-1.0, 1.0),
        3 => 1.0,
        4 => cosine[row],
        _ => sine[row],
    };
    let design = DMatrix::from_fn(rows, 6, columns);
    let target = DVector::from_iterator(rows, current[..rows].iter().copied());
    let inverse = (design.transpose() * &design).cholesky()?.inverse();
    let found = &inverse * design.transpose() * &target;
    let left = (&target - &design * &found).norm_squared() / rows as f64;
    // Neighbouring rows have the same residual.
    let spread = left * 2.0 * near as f64;
    let deviation = (spread * inverse[(4, 4)].max(inverse[(5, 5)])).sqrt();
    Some(([found[4], found[5]], deviation))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shaft whose velocity loop and ideal current loop see an offset in one phase, at 5 kHz; `hidden` by the loop, or
    /// behind it.
    fn recorded(phase: usize, hidden: bool) -> ([Vec<f64>; 3], Vec<f64>) {
        let (step_s, inertia, pairs, offset) = (2e-4, 3e-3, 3.0, 0.5);
        let (mut speed, mut angle, mut integral) = (0.0_f64, 0.3_f64, 0.0_f64);
        let (mut phases, mut angles) = ([vec![], vec![], vec![]], vec![]);
        for k in 0..20_000_u32 {
            let wanted = 60.0 * (f64::from(k) * step_s * 2.0).sin();
            integral += 2.0 * (wanted - speed) * step_s;
            let current = 0.1 * (wanted - speed) + integral;
            let axis = |phase: usize| phase as f64 * TAU / 3.0;
            // i_q along −sin, as of the usual Park transform.
            let quadrature = |phase: usize| -(pairs * angle - axis(phase)).sin();
            let truly = current - if hidden { 2.0 / 3.0 * offset * quadrature(phase) } else { 0.0 };
            for (own, column) in phases.iter_mut().enumerate() {
                // A loop that sees the offset leaves a third of it in each measured current.
                let shift = if hidden { offset / 3.0 } else { offset * f64::from(u8::from(phase == own)) };
                let noise = f64::from(k.wrapping_mul(2_654_435_761).wrapping_add(own as u32 * 977) >> 16) / 65_536.0;
                column.push(current * quadrature(own) + shift + 0.02 * (noise - 0.5));
            }
            angles.push(angle.rem_euclid(TAU));
            speed += (truly - 0.01 * speed - 0.2 * (speed / 0.5).clamp(-1.0, 1.0)) / inertia * step_s;
            angle += speed * step_s;
        }
        (phases, angles)
    }

    #[test]
    fn the_phase_is_named_whether_the_loop_hides_it_or_not() {
        for phase in 0..3 {
            for hidden in [false, true] {
                let ([a, b, c], angle) = recorded(phase, hidden);
                let found = of_offset([&a, &b, &c], 0.5, Some((&angle, 5000.0)));
                assert_eq!(found, Some(phase), "{hidden}: {:?}", vector([&a, &b, &c], &angle, 5000.0));
                // Without an angle, a loop that hides the offset hides its phase.
                assert_eq!(of_offset([&a, &b, &c], 0.5, None).is_some(), !hidden);
            }
        }
    }
}
