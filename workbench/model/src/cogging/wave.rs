//! A wave `a cos kθ + b sin kθ` with the covariance of a and b.

use nalgebra::{Matrix2, Vector2};

/// 97.5 % quantile of the normal distribution.
const NORMAL: f64 = 1.959_964;

/// One wave of the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// a and b.
    pub value: Vector2<f64>,
    /// Their covariance.
    pub covariance: Matrix2<f64>,
}

impl Wave {
    /// √(a² + b²).
    #[must_use]
    pub fn amplitude(&self) -> f64 {
        self.value.norm()
    }

    /// φ of `A cos(kθ − φ)`, from −π to π.
    #[must_use]
    pub fn phase_rad(&self) -> f64 {
        self.value.y.atan2(self.value.x)
    }

    /// Half of the 95 % interval of the amplitude.
    #[must_use]
    pub fn amplitude_interval(&self) -> f64 {
        NORMAL * self.deviation_along(self.value)
    }

    /// Half of the 95 % interval of the phase; a small amplitude has none.
    #[must_use]
    pub fn phase_interval_rad(&self) -> f64 {
        let across = Vector2::new(-self.value.y, self.value.x);
        NORMAL * self.deviation_along(across) / self.amplitude()
    }

    /// Mean standard deviation of a and b.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        (0.5 * self.covariance.trace()).sqrt()
    }

    /// The square of the distance from zero in its deviations: χ² with two degrees of freedom if there is no wave.
    #[must_use]
    pub fn significance(&self) -> f64 {
        self.covariance.try_inverse().map_or(0.0, |inverse| self.value.dot(&(inverse * self.value)))
    }

    /// The wave times a factor.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self { value: self.value * factor, covariance: self.covariance * (factor * factor) }
    }

    fn deviation_along(&self, direction: Vector2<f64>) -> f64 {
        let unit = direction.try_normalize(0.0).unwrap_or_else(Vector2::x);
        (unit.dot(&(self.covariance * unit))).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitude_and_phase_have_the_deviations_along_and_across() {
        let wave = Wave { value: Vector2::new(0.0, 2.0), covariance: Matrix2::new(0.04, 0.0, 0.0, 0.01) };
        assert!(
            (wave.amplitude() - 2.0).abs() < 1e-15 && (wave.phase_rad() - 0.5 * std::f64::consts::PI).abs() < 1e-15
        );
        // Rounding only: deviations of 0.1 along and 0.2 across.
        assert!((wave.amplitude_interval() - 0.1 * NORMAL).abs() < 1e-12);
        assert!((wave.phase_interval_rad() - 0.1 * NORMAL).abs() < 1e-12);
        assert!((wave.significance() - 400.0).abs() < 1e-9);
        assert!((wave.times(3.0).amplitude_interval() - 0.3 * NORMAL).abs() < 1e-12);
    }
}
