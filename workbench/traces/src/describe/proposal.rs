//! The channels that `init` proposes by the names of columns.

use super::guess::Guess;
use crate::units::{Quantity, Unit};
use model::statistics::mean_sd;
use model::trace::bridged;

/// Deviation of a velocity, as a part of its mean, below which it is constant.
const CONSTANT: f64 = 0.01;

/// The likely channels, output and inputs.
pub(super) struct Proposal {
    pub(super) guess: Guess,
    pub(super) y: Option<String>,
    pub(super) u1: Option<String>,
    /// Whether the current is the output: the reference of the velocity drives it.
    pub(super) by_reference: bool,
    /// Whether the output has no input.
    pub(super) alone: bool,
}

impl Proposal {
    /// By the names of the columns.
    pub(super) fn of(names: &[String]) -> Self {
        let guess = Guess::of(names);
        let Guess { current, velocity, velocity_ref, current_ref, .. } = &guess;
        // Without a reference of the velocity, the current drives the velocity.
        let by_reference = velocity_ref.is_some() && velocity.is_some() || current.is_none() || velocity.is_none();
        let input = match (velocity_ref, velocity) {
            (Some(reference), Some(velocity)) => Some(format!("{reference}-{velocity}")),
            (reference, velocity) => reference.clone().or_else(|| velocity.clone()),
        };
        let of_current = current_ref.clone().or_else(|| current.clone());
        let (y, u1) = if by_reference { (current.clone(), input) } else { (velocity.clone(), of_current) };
        if y.is_some() && u1.is_some() {
            return Self { guess, y, u1, by_reference, alone: false };
        }
        // By units: what moves is the output, what drives it the input. Otherwise the first column alone.
        let of_quantity = |wanted: &[Quantity]| {
            let fits = |name: &&String| Unit::of_column(name).is_some_and(|unit| wanted.contains(&unit.quantity));
            names.iter().rev().find(fits).cloned()
        };
        use Quantity::{Angle, AngularVelocity, Force, Length, Torque, Velocity, Voltage};
        let moves = of_quantity(&[Length, Angle, Velocity, AngularVelocity]);
        match (moves, of_quantity(&[Voltage, Force, Torque])) {
            (Some(y), Some(u1)) => Self { guess, y: Some(y), u1: Some(u1), by_reference, alone: false },
            _ => {
                let first = current.clone().or_else(|| names.first().cloned());
                Self { guess, y: first.clone(), u1: first, by_reference, alone: true }
            }
        }
    }

    /// Whether files of which these are the shared columns go together with files of `own`.
    pub(super) fn stands_for(&self, own: &Self) -> bool {
        self.guess == own.guess && (self.alone == own.alone) && (!self.alone || self.y == own.y)
    }

    /// Whether the velocity of a trace with these columns is constant.
    pub(super) fn is_constant(&self, names: &[String], columns: &[Vec<f64>]) -> bool {
        let own = |name: &&String| self.guess.velocity.as_ref().is_some_and(|velocity| velocity.contains(*name));
        let column = names.iter().position(|name| own(&name)).and_then(|place| columns.get(place));
        column.is_some_and(|column| {
            let (mean, deviation) = mean_sd(&bridged(column));
            deviation < CONSTANT * mean.abs()
        })
    }
}
