//! Pulses of a spall that are added to the current of a healthy trace.
//!
//! ```text
//! i' = i + sgn(ω) Σ_h A_h cos(h (O θ + φ))                                                       (1)
//! ```

use std::f64::consts::{PI, TAU};

use crate::trace::MotionTrace;

/// Returns slip and phase of the pulses in the trace of this number: evenly over their ranges, in an order without a
/// pattern.
pub(crate) fn slip_and_phase(number: usize, most: f64) -> (f64, f64) {
    let part = |ratio: f64| (number as f64 + 0.5) * ratio % 1.0;
    (most * (2.0 * part(0.618_034) - 1.0), TAU * part(0.414_214))
}

/// Adds the pulses (1) of one order.
pub(crate) fn add(current_a: &mut [f64], motion: &MotionTrace, order: f64, phase: f64, amplitudes_a: [f64; 3]) {
    let (mut turned_rad, mut before) = (0.0, f64::NAN);
    for ((current, angle), velocity) in current_a.iter_mut().zip(&motion.angle_rad).zip(&motion.velocity_rad_s) {
        if angle.is_finite() {
            // Of a wrapped angle, the step of less than half a turn.
            let step = (angle - before + PI).rem_euclid(TAU) - PI;
            turned_rad += if step.is_finite() { step } else { 0.0 };
            before = *angle;
        }
        let place = order * turned_rad + phase;
        let pulses: f64 = [1.0, 2.0, 3.0].iter().zip(amplitudes_a).map(|(h, a)| a * (h * place).cos()).sum();
        *current += pulses * if *velocity < 0.0 { -1.0 } else { 1.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of x cos(h O θ) and of x sin(h O θ) over a whole number of turns.
    fn projected(x: &[f64], angle_rad: &[f64], order: f64) -> [f64; 2] {
        let of = |part: fn(f64) -> f64| {
            2.0 * x.iter().zip(angle_rad).map(|(x, angle)| x * part(order * angle)).sum::<f64>() / x.len() as f64
        };
        [of(f64::cos), of(f64::sin)]
    }

    #[test]
    fn pulses_have_their_harmonics_and_oppose_the_motion() {
        // Ten turns forward, wrapped; the angle of one sample is missing.
        let turned: Vec<f64> = (0..5000).map(|k| f64::from(k) * TAU / 500.0).collect();
        let mut motion = MotionTrace {
            angle_rad: turned.iter().map(|angle| angle.rem_euclid(TAU)).collect(),
            velocity_rad_s: vec![20.0; 5000],
            ..MotionTrace::default()
        };
        motion.angle_rad[700] = f64::NAN;
        let mut current_a = vec![0.0; 5000];
        add(&mut current_a, &motion, 3.5, 0.5 * PI, [0.4, 0.2, 0.1]);
        for (h, amplitude) in [(1.0, 0.4), (2.0, 0.2), (3.0, 0.1)] {
            let [x, y] = projected(&current_a, &turned, 3.5 * h);
            // cos(h (φ + π/2)): the phase turns by a quarter, a half and three quarters.
            let [want_x, want_y] = [amplitude * (h * 0.5 * PI).cos(), -amplitude * (h * 0.5 * PI).sin()];
            // One sample of 5000 is held at the angle before.
            assert!((x - want_x).abs() < 1e-3 && (y - want_y).abs() < 1e-3, "{h}: {x} {y}");
        }
        let mut back = MotionTrace { velocity_rad_s: vec![-20.0; 5000], ..motion };
        back.angle_rad[700] = 0.0;
        let mut reversed = vec![0.0; 5000];
        add(&mut reversed, &back, 3.5, 0.5 * PI, [0.4, 0.2, 0.1]);
        assert!((reversed[10] + current_a[10]).abs() < 1e-12);
    }
}
