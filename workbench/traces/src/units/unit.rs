//! A unit: what is measured in it, and how it converts.

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Angle; base unit rad.
    Angle,
    /// Angular velocity; rad/s.
    AngularVelocity,
    /// Length; m.
    Length,
    /// Velocity; m/s.
    Velocity,
    /// Current; A.
    Current,
    /// Voltage; V.
    Voltage,
    /// Torque; N·m.
    Torque,
    /// Force; N.
    Force,
    /// Temperature; K.
    Temperature,
    /// Time; s.
    Time,
    /// Another one, such as an acceleration or a power.
    Other,
}

/// A unit: a value times `factor`, plus `offset`, is in the base unit of its quantity.
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    /// What is measured in it.
    pub quantity: Quantity,
    factor: f64,
    offset: f64,
}

pub(super) const TURN: f64 = std::f64::consts::TAU;
pub(super) const DEGREE: f64 = TURN / 360.0;

/// Relative difference of factors that are equal but for rounding.
const ROUNDING: f64 = 1e-12;

use Quantity::{Angle, AngularVelocity, Length, Velocity};

impl PartialEq for Unit {
    fn eq(&self, other: &Self) -> bool {
        let is_near = |one: f64, other: f64| (one - other).abs() <= ROUNDING * one.abs().max(other.abs());
        self.quantity == other.quantity && is_near(self.factor, other.factor) && is_near(self.offset, other.offset)
    }
}

impl Unit {
    /// Of a quantity, with its factor and offset.
    pub(super) const fn new(quantity: Quantity, factor: f64, offset: f64) -> Self {
        Self { quantity, factor, offset }
    }

    /// Factor and offset to the base unit of its quantity.
    #[must_use]
    pub const fn to_base(&self) -> (f64, f64) {
        (self.factor, self.offset)
    }

    /// Factor and offset from this unit to another one; `None` if they measure different quantities.
    #[must_use]
    pub fn to(&self, other: &Self) -> Option<(f64, f64)> {
        let same = self.quantity == other.quantity;
        same.then(|| (self.factor / other.factor, (self.offset - other.offset) / other.factor))
    }

    /// The unit of the integral over time in seconds, if the integral is another quantity.
    #[must_use]
    pub fn integral(&self) -> Option<Self> {
        let quantity = match self.quantity {
            AngularVelocity => Angle,
            Velocity => Length,
            _ => return None,
        };
        Some(Self { quantity, ..*self })
    }
}
