//! Numbers to feed kernels with, the same on every machine.

/// Numbers in −1 … 1 by a congruential generator.
pub struct Numbers(pub u32);

impl Numbers {
    /// Draws a number.
    pub fn draw(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }

    /// Draws `N` numbers.
    pub fn array<const N: usize>(&mut self) -> [f32; N] {
        core::array::from_fn(|_| self.draw())
    }
}
