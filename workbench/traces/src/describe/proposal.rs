//! The channels that `init` proposes by the names of columns.

use super::guess::{Guess, is_label};
use crate::turning::{Column, Turning};
use crate::units::{Quantity, Unit, stated};
use model::statistics::mean_sd;
use model::trace::bridged;

/// Deviation of a velocity, as a part of its mean, below which it is constant.
const CONSTANT: f64 = 0.01;

/// The likely channels, output and inputs.
pub(super) struct Proposal {
    /// The columns, and the channels that they become.
    pub(super) columns: Guess,
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
        let columns = Guess::of(names);
        let guess = columns.clone().converted();
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
            return Self { columns, guess, y, u1, by_reference, alone: false };
        }
        // By units: what moves is the output, what drives it the input. Otherwise the first column alone.
        let of_quantity = |wanted: &[Quantity]| {
            let fits = |name: &&String| Unit::of_column(name).is_some_and(|unit| wanted.contains(&unit.quantity));
            names.iter().rev().find(fits).cloned()
        };
        use Quantity::{Angle, AngularVelocity, Force, Length, Torque, Velocity, Voltage};
        let moves = of_quantity(&[Length, Angle, Velocity, AngularVelocity]);
        match (moves, of_quantity(&[Voltage, Force, Torque])) {
            (Some(y), Some(u1)) => Self { columns, guess, y: Some(y), u1: Some(u1), by_reference, alone: false },
            _ => {
                let is_signal = |name: &&String| !is_label(name) && !columns.phases.contains(name);
                let y = current.clone().or_else(|| names.iter().find(is_signal).cloned());
                Self { columns, guess, y, u1: None, by_reference, alone: true }
            }
        }
    }

    /// Whether files of which these are the shared columns go together with files of `own`.
    pub(super) fn stands_for(&self, own: &Self) -> bool {
        self.columns == own.columns && (self.alone == own.alone) && (!self.alone || self.y == own.y)
    }

    /// The units of angle and velocity of a trace with these columns.
    pub(super) fn turning(&self, names: &[String], columns: &[Vec<f64>], rate_hz: Option<f64>) -> Turning {
        let column = |name: &String| {
            let place = names.iter().position(|other| other == name)?;
            Some(Column { name: &names[place], values: columns.get(place)? })
        };
        let of = |channel: &Option<String>| channel.as_ref().and_then(column);
        Turning::of(of(&self.columns.angle), of(&self.columns.velocity), rate_hz)
    }

    /// What the names leave open: phases in the place of a current, and the unit of the current.
    pub(super) fn doubts(&self, behind_front_end: bool) -> Vec<String> {
        let Guess { current, phases, .. } = &self.columns;
        let of_current = |name: &String| {
            let unit = Unit::of_column(name).is_some_and(|unit| unit.quantity == Quantity::Current);
            (!unit).then(|| match stated(name) {
                Some(unit) => format!("the unit {unit} of {name} is not known: it is taken as A"),
                None => format!("the unit of {name} is not known: it is taken as A"),
            })
        };
        let phases = (current.is_none() && !phases.is_empty() && !behind_front_end).then(|| {
            let list = phases.join(", ");
            format!(
                "{list} are phase currents, of which none is the current: --front-end makes it of them and the angle"
            )
        });
        // The channels of an oscilloscope: c3, CH1 [V], Channel A, 2.
        let is_place = |name: &String| {
            let name = name.split(['[', '(']).next().unwrap_or_default().trim().to_lowercase();
            let rest = ["channel", "kanal", "voie", "ch", "c"].iter().find_map(|start| name.strip_prefix(start));
            let place = rest.unwrap_or(&name).trim_matches([' ', '_', '.']);
            !place.is_empty() && (place.parse::<u32>().is_ok() || rest.is_some() && place.chars().count() == 1)
        };
        let unnamed = self.y.as_ref().filter(|y| phases.is_none() && is_place(y));
        let unnamed = unnamed.map(|y| {
            format!("no name tells which column is which: {y} is described by itself; write y, u1, velocity or angle")
        });
        let of_load = |name: &String| {
            let unit = stated(name).filter(|unit| Unit::named(unit).is_none())?;
            Some(format!("the unit {unit} of {name} is not known: the load is taken as it is"))
        };
        let load = self.columns.load.as_ref().and_then(of_load);
        phases.into_iter().chain(unnamed).chain(current.as_ref().and_then(of_current)).chain(load).collect()
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
