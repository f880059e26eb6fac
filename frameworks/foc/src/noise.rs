//! Random numbers.

/// A xorshift generator of 32 bits.
#[derive(Debug)]
pub struct Noise(u32);

impl Noise {
    /// Any seed; neighbouring ones differ at once.
    pub fn new(seed: u32) -> Self {
        let mut noise = Self(seed.wrapping_mul(0x9e37_79b9) | 1);
        (0..8).for_each(|_| _ = noise.uniform());
        noise
    }

    /// From 0 to 1.
    fn uniform(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, least: f32, most: f32) -> f32 {
        least + (most - least) * self.uniform()
    }

    /// About standard normal: the sum of three uniform numbers.
    pub fn normal(&mut self) -> f32 {
        2.0 * (self.uniform() + self.uniform() + self.uniform() - 1.5)
    }
}
