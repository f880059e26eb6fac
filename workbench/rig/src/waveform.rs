//! Shapes of the velocity reference, with unit peak; sine and triangle rise through zero at t = 0.
//!
//! With the phase `x = frac(f t)` in periods:
//!
//! ```text
//! sine      sin 2πft                                              (1)
//! triangle  4x for x < ¼,  2 − 4x for x < ¾,  4x − 4 beyond       (2)
//! square    1 for x < ½, else −1                                  (3)
//! ```
//!
//! The square jumps between two samples, like a step command; neither its slope nor the voltage of the drive is
//! limited. At zero frequency the square is a constant 1, and the other shapes are 0.

use core::f64::consts::TAU;

/// Phase advance of the square in periods, so that rounding does not delay an edge at a sample to the next sample.
const EDGE_GUARD: f64 = 1e-9;

/// Shape of a periodic signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Waveform {
    /// Equation (1).
    Sine,
    /// Equation (2).
    Triangle,
    /// Equation (3).
    Square,
}

impl Waveform {
    /// All shapes.
    pub const ALL: [Self; 3] = [Self::Sine, Self::Triangle, Self::Square];

    /// Name on the command line and in labels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sine => "sine",
            Self::Triangle => "triangle",
            Self::Square => "square",
        }
    }

    /// Short description.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::Sine => "smooth",
            Self::Triangle => "constant acceleration",
            Self::Square => "steps between two velocities",
        }
    }

    /// The value from −1 to 1 at time `t_s`.
    #[must_use]
    pub fn at(self, frequency_hz: f64, t_s: f64) -> f64 {
        let periods = frequency_hz * t_s;
        match self {
            Self::Sine => libm::sin(TAU * frequency_hz * t_s), // (1)
            Self::Triangle => match fraction(periods) {
                x if x < 0.25 => 4.0 * x, // (2)
                x if x < 0.75 => 2.0 - 4.0 * x,
                x => 4.0 * x - 4.0,
            },
            Self::Square => {
                if fraction(periods + EDGE_GUARD) < 0.5 {
                    1.0 // (3)
                } else {
                    -1.0
                }
            }
        }
    }
}

fn fraction(x: f64) -> f64 {
    x - x.floor()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    /// Sample times of the standard rig from 1.2 s to 11.2 s, for a reference of 0.2 Hz.
    fn samples() -> impl Iterator<Item = f64> {
        (600..5600).map(|k| f64::from(k) * 0.002)
    }

    #[test]
    fn triangle_is_the_arcsine_of_a_sine() {
        for t in samples() {
            let closed = 2.0 / PI * (TAU * 0.2 * t).sin().asin();
            // asin loses half the digits at the peaks, because its slope is infinite there: √1e-16.
            assert!((Waveform::Triangle.at(0.2, t) - closed).abs() < 1e-7, "{t}");
        }
        assert_eq!(Waveform::Triangle.at(0.2, 1.25), 1.0);
        assert_eq!(Waveform::Triangle.at(0.25, 3.0), -1.0);
    }

    #[test]
    fn square_is_the_sign_of_a_sine_and_jumps_on_the_sample() {
        for t in samples() {
            let sine = (TAU * 0.2 * t).sin();
            // At the zeros (every 1250 samples) the sign of a rounded sine is undefined.
            if sine.abs() > 1e-6 {
                assert_eq!(Waveform::Square.at(0.2, t), sine.signum(), "{t}");
            }
        }
        // Half a period is 1250 samples, independent of the rounding of k · 0.002 · 0.2.
        for k in 0..20_000_u32 {
            let expected = if (k / 1250).is_multiple_of(2) { 1.0 } else { -1.0 };
            assert_eq!(Waveform::Square.at(0.2, f64::from(k) * 0.002), expected, "{k}");
        }
    }

    #[test]
    fn at_zero_frequency_only_the_square_is_on() {
        assert_eq!(Waveform::ALL.map(|shape| shape.at(0.0, 3.0)), [0.0, 0.0, 1.0]);
    }
}
