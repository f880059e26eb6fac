//! One whole order of what turns with the rotor.

/// The line `a cos kθ + b sin kθ`. All fields are plain numbers, so that a drive can store them as it likes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RotorLine {
    /// k, periods a turn.
    pub order: u16,
    /// a.
    pub cosine_a: f32,
    /// b.
    pub sine_a: f32,
    /// Standard deviation of a, and of b.
    pub deviation_a: f32,
}

impl RotorLine {
    /// The amplitude √(a² + b²).
    #[must_use]
    pub fn amplitude_a(&self) -> f32 {
        libm::sqrtf(self.power())
    }

    /// The phase φ of `A cos(kθ − φ)`, from −π to π.
    #[must_use]
    pub fn phase_rad(&self) -> f32 {
        libm::atan2f(self.sine_a, self.cosine_a)
    }

    /// a² + b².
    pub(super) fn power(&self) -> f32 {
        self.cosine_a * self.cosine_a + self.sine_a * self.sine_a
    }
}
