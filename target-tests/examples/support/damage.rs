//! Damage to a good stream: pieces of any data, the same from a recipe on every machine.
//!
//! A recipe is a list of pieces, each of which is one number: its kind, its length, the channels that it spoils, and
//! the seed of its values. Pieces without damage lie between those with it, so that filters, runs and segments are met
//! in every state.

use bearing_watch::Angle;

/// Pieces of a recipe.
pub const PIECES: u32 = 24;
/// Most channels of a sample.
pub const CHANNELS: usize = 4;

/// Numbers of 32 bits that hardly depend on each other.
#[derive(Clone, Copy, Debug)]
pub struct Dice(pub u32);

impl Dice {
    /// The next number.
    pub const fn roll(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9);
        let mixed = (self.0 ^ self.0 >> 16).wrapping_mul(0x7feb_352d);
        let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x846c_a68b);
        mixed ^ mixed >> 16
    }

    /// A number below `end`.
    pub const fn below(&mut self, end: u32) -> u32 {
        self.roll() % end
    }

    /// A number in −1 … 1.
    pub fn unit(&mut self) -> f32 {
        (self.roll() >> 8) as f32 / 8_388_608.0 - 1.0
    }
}

/// A list of pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recipe([u32; PIECES as usize]);

impl Recipe {
    /// Without damage.
    pub const GOOD: Self = Self([0; PIECES as usize]);

    /// Any pieces.
    pub fn random(dice: &mut Dice) -> Self {
        Self(core::array::from_fn(|_| dice.roll()))
    }

    /// The same with one to four other pieces.
    #[must_use]
    pub fn changed(mut self, dice: &mut Dice) -> Self {
        for _ in 0..=dice.below(4) {
            let piece = dice.roll();
            if let Some(cell) = self.0.get_mut(dice.below(PIECES) as usize) {
                *cell = piece;
            }
        }
        self
    }

    /// The first piece, as a seed of choices that are not damage.
    pub const fn seed(&self) -> u32 {
        let [first, ..] = self.0;
        first
    }
}

/// What a piece does to the channels that it spoils, or to the angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Good,
    /// Subnormal numbers and zeros of both signs.
    Subnormal,
    /// Any bits.
    AnyBits,
    /// NaN and infinity, also as lost samples.
    NotFinite,
    /// The largest plausible values.
    Largest,
    /// Just beyond them.
    Saturated,
    /// Another level.
    Jump,
    /// The value at the start of the piece.
    Stuck,
    /// Values so small that their products are subnormal.
    Tiny,
    /// The other direction.
    Reversed,
    /// An angle that jumps by any part of a turn.
    Spin,
    /// An angle that stands still.
    Standstill,
}

/// The damage of a recipe, sample by sample.
#[derive(Clone, Debug)]
pub struct Damage {
    recipe: Recipe,
    place: usize,
    left: u32,
    kind: Kind,
    /// Spoilt channels as bits.
    mask: u32,
    dice: Dice,
    held: [f32; CHANNELS],
    level: f32,
    /// What the angle is turned by, and the angle that stands still.
    turned: Angle,
    still: Angle,
    backwards: bool,
}

impl Damage {
    /// At the first piece.
    pub const fn new(recipe: &Recipe) -> Self {
        Self {
            recipe: *recipe,
            place: 0,
            left: 0,
            kind: Kind::Good,
            mask: 0,
            dice: Dice(0),
            held: [0.0; CHANNELS],
            level: 0.0,
            turned: Angle::ZERO,
            still: Angle::ZERO,
            backwards: false,
        }
    }

    /// Starts the next piece if the present one is over. Returns the kind for this sample, `None` behind the last one.
    pub fn next(&mut self) -> Option<Kind> {
        if self.left == 0 {
            let piece = *self.recipe.0.get(self.place)?;
            self.place += 1;
            let mut dice = Dice(piece);
            // Damage is rare in some recipes, so that parts of the detector have results.
            let quiet = dice.below(4) < self.recipe.seed() % 4;
            self.kind = match dice.below(18) {
                _ if quiet => Kind::Good,
                0 => Kind::Subnormal,
                1 => Kind::AnyBits,
                2 => Kind::NotFinite,
                3 => Kind::Largest,
                4 => Kind::Saturated,
                5 => Kind::Jump,
                6 => Kind::Stuck,
                7 => Kind::Tiny,
                8 => Kind::Reversed,
                9 => Kind::Spin,
                10 => Kind::Standstill,
                _ => Kind::Good,
            };
            self.left = match dice.below(4) {
                0 => 1,
                1 => 1 + dice.below(12),
                _ => 1 + dice.below(64),
            };
            self.mask = match dice.below(3) {
                0 => u32::MAX,
                _ => dice.roll(),
            };
            self.level = dice.unit();
            self.backwards ^= self.kind == Kind::Reversed;
            // Marks the start of the piece.
            self.held = [f32::NAN; CHANNELS];
            self.dice = dice;
        }
        self.left -= 1;
        Some(self.kind)
    }

    /// The seed of the present piece.
    pub const fn seed(&self) -> u32 {
        self.mask
    }

    /// Spoils the values of a sample, whose plausible magnitudes are `limits`, and its angle.
    pub fn spoil(&mut self, kind: Kind, limits: &[f32], values: &mut [f32], angle: &mut Angle) {
        let cells = values.iter_mut().zip(limits).zip(&mut self.held).enumerate();
        for (k, ((value, limit), held)) in cells {
            if self.backwards && k != 0 {
                *value = -*value;
            }
            if (self.recipe.seed() >> 8 & 7) as usize == k {
                // A channel that never moves.
                *value = 0.5 * limit;
            }
            if self.mask >> k & 1 == 0 {
                continue;
            }
            let dice = &mut self.dice;
            *value = match kind {
                Kind::Subnormal => {
                    let bits = dice.roll() & 0x007f_ffff >> dice.below(24);
                    f32::from_bits(bits | dice.roll() & 0x8000_0000)
                }
                Kind::AnyBits => f32::from_bits(dice.roll()),
                Kind::NotFinite => match dice.below(3) {
                    0 => f32::NAN,
                    1 => f32::INFINITY,
                    _ => f32::NEG_INFINITY,
                },
                Kind::Largest => limit.copysign(dice.unit()),
                Kind::Saturated => (1.001 * limit).copysign(self.level),
                Kind::Jump => self.level * limit,
                Kind::Stuck => {
                    if held.is_nan() {
                        *held = *value;
                    }
                    *held
                }
                Kind::Tiny => *value * 1e-30,
                Kind::Good | Kind::Reversed | Kind::Spin | Kind::Standstill => *value,
            };
        }
        if kind == Kind::Spin {
            self.turned = Angle::from_bits(self.turned.bits().wrapping_add(self.dice.roll()));
        }
        let own = angle.bits();
        let own = if self.backwards { own.wrapping_neg() } else { own };
        *angle =
            if kind == Kind::Standstill { self.still } else { Angle::from_bits(own.wrapping_add(self.turned.bits())) };
        self.still = *angle;
    }
}
