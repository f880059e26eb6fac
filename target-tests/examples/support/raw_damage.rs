//! Damage to raw samples: counts, position and numbers of any bits.

use bearing_watch::Angle;
use bearing_watch::drive::{PhaseCounts, Position, RawSample};

use super::damage::{CHANNELS, Damage, Dice, Kind, Recipe};

/// Plausible magnitudes of sine, cosine and two further channels.
const LIMITS: [f32; CHANNELS] = [1.2, 1.2, 100.0, 100.0];

/// The damage of a recipe to raw samples.
#[derive(Clone, Debug)]
pub struct RawDamage {
    damage: Damage,
    dice: Dice,
    /// Sampling instants that were missed so far.
    missed: u32,
    held: [u16; 3],
}

impl RawDamage {
    /// At the first piece.
    pub const fn new(recipe: &Recipe) -> Self {
        Self { damage: Damage::new(recipe), dice: Dice(recipe.seed()), missed: 0, held: [0; 3] }
    }

    /// The damaged sample; `None` behind the last piece.
    pub fn spoil<const FURTHER: usize>(&mut self, mut raw: RawSample<FURTHER>) -> Option<RawSample<FURTHER>> {
        let kind = self.damage.next()?;
        if kind == Kind::NotFinite && self.dice.below(8) == 0 {
            self.missed = self.missed.wrapping_add(self.dice.roll() >> self.dice.below(32));
        }
        raw.number = raw.number.wrapping_add(self.missed);
        self.spoil_counts(kind, &mut raw.currents);
        self.spoil_position(kind, &mut raw.position, &mut raw.further);
        Some(raw)
    }

    fn spoil_counts(&mut self, kind: Kind, currents: &mut PhaseCounts) {
        let counts: &mut [u16] = match currents {
            PhaseCounts::Three(counts) => counts,
            PhaseCounts::Quadrature(_) => &mut [],
            PhaseCounts::Two(counts) => counts,
        };
        let seed = self.damage.seed();
        for (k, (count, held)) in counts.iter_mut().zip(&mut self.held).enumerate() {
            let hit = seed >> k & 1 == 0;
            *count = match kind {
                Kind::AnyBits if hit => (self.dice.roll() >> 16) as u16,
                Kind::Saturated | Kind::Largest if hit => {
                    [0, 15, 16, 4079, 4080].get((seed >> 8) as usize % 6).copied().unwrap_or(u16::MAX)
                }
                // An open phase, or a wrong gain.
                Kind::Jump if hit => 2048,
                Kind::Subnormal | Kind::Tiny if hit => count.wrapping_mul(2).wrapping_sub(2048),
                Kind::Stuck | Kind::Standstill if hit => *held,
                _ => *count,
            };
            *held = *count;
        }
    }

    fn spoil_position<const FURTHER: usize>(
        &mut self,
        kind: Kind,
        position: &mut Position,
        further: &mut [f32; FURTHER],
    ) {
        let mut values = [0.0; CHANNELS];
        let mut angle = Angle::ZERO;
        match position {
            Position::Resolver { sin, cos } => [values[0], values[1]] = [*sin, *cos],
            Position::Absolute(own) => angle = *own,
            Position::Missing => {}
        }
        values.iter_mut().skip(2).zip(further.iter()).for_each(|(cell, value)| *cell = *value);
        self.damage.spoil(kind, &LIMITS, &mut values, &mut angle);
        let missing = kind == Kind::NotFinite && self.dice.below(2) == 0;
        match position {
            _ if missing => *position = Position::Missing,
            Position::Resolver { sin, cos } => [*sin, *cos, ..] = values,
            Position::Absolute(own) if kind == Kind::AnyBits => *own = Angle::from_bits(self.dice.roll()),
            Position::Absolute(own) => *own = angle,
            Position::Missing => {}
        }
        further.iter_mut().zip(values.iter().skip(2)).for_each(|(cell, value)| *cell = *value);
    }
}
