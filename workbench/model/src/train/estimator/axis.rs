//! What is known of an axis behind the motor, and of the weight that it carries.

use bearing_watch::plan::{Load, Signal};
use serde_json::{Value, json};

/// What is known of an axis behind the motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Axis {
    /// Training looks for a weight, if the load is not measured.
    #[default]
    Find,
    /// It carries no weight.
    None,
    /// It carries one, by so many turns of the motor for one of the axis; of a trained plan, whether it changes.
    Turns(f64, bool),
    /// The weight in the healthy traces.
    Carries(Weight),
}

/// A weight on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    /// R, turns of the motor for one turn of the axis.
    pub turns: f64,
    /// Whether a user gave R.
    pub given: bool,
    /// The part of the current that it explains beside the motion, in the median record.
    pub explained: f64,
    /// Its amplitude in the median record, A.
    pub amplitude_a: f64,
    /// Whether it changes from one rest to the next within a record.
    pub changes: bool,
    /// Another R that explains far more.
    pub better: Option<f64>,
}

/// 2³².
const TURN: f64 = 4_294_967_296.0;

impl Axis {
    /// By the turns that a user gives: none for 0.
    #[must_use]
    pub const fn given(turns: Option<f64>) -> Self {
        match turns {
            None => Self::Find,
            Some(0.0) => Self::None,
            Some(turns) => Self::Turns(turns, false),
        }
    }

    /// That of a plan.
    #[must_use]
    pub fn of(load: Load) -> Self {
        match load {
            Load::Weight { axis_q32, changes } => Self::Turns(TURN / f64::from(axis_q32), changes),
            Load::Unknown | Load::Measured(_) => Self::None,
        }
    }

    /// The load of a plan with this signal, if it is measured.
    pub(crate) fn load(self, measured: Option<Signal>) -> Load {
        let (turns, changes) = match self {
            Self::Turns(turns, changes) | Self::Carries(Weight { turns, changes, .. }) => (turns, changes),
            Self::Find | Self::None => return Load::of(measured),
        };
        let axis_q32 = (TURN / turns).round() as u32;
        measured.map_or(Load::Weight { axis_q32, changes }, Load::Measured)
    }

    /// Whether a plan with it has a weight.
    pub(crate) fn weighs(self) -> bool {
        matches!(self, Self::Turns(..) | Self::Carries(_))
    }

    /// R, if the axis carries a weight.
    #[must_use]
    pub fn turns(self) -> Option<f64> {
        match self {
            Self::Turns(turns, _) | Self::Carries(Weight { turns, .. }) => Some(turns),
            Self::Find | Self::None => None,
        }
    }
}

impl Weight {
    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Self { turns, given, explained, amplitude_a, changes, better } = self;
        json!({
            "turns": turns, "given": given, "explained": explained, "amplitude_a": amplitude_a, "changes": changes,
            "better_turns": better,
        })
    }

    /// What the weight explains, in words.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { turns, given, explained, amplitude_a, changes, .. } = *self;
        let by = if given { "as given" } else { "by the period of the current over the angle" };
        format!(
            "no load is measured, but a weight on an axis of one turn in {turns:.1} of the motor ({by}) explains {:.0} % \
             of the current that the motion leaves, {amplitude_a:.2e} A: the detector estimates it {}",
            100.0 * explained,
            if changes { "anew behind each rest, since it changes there" } else { "in each segment" }
        )
    }

    /// Why the ratio that a user gave may be wrong.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        let Self { turns, explained, better, .. } = *self;
        better.map(|better| {
            format!(
                "a gear ratio of {turns} explains {:.0} % of the current that the motion leaves, one of {better:.2} far \
                 more; is gear_ratio right?",
                100.0 * explained
            )
        })
    }
}
