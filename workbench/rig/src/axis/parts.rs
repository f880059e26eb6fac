//! The parts of an axis by name, as conditions that combine: on top of MIX, or on top of another condition.
//!
//! An axis has no load sensor, unless the other condition has a sensor with errors; beside its weight only a small load
//! is left, ± 0.005 N·m on the DC-motor rig and the fluctuation on the actuator.

use super::super::Scenario;
use super::super::ema::{EmaLoad, EmaScenario};
use super::super::field::{Duty, LoadMeasurement, Mechanics};
use super::{Axis, Brake, Gear, Gravity, Motion};

/// A part of an axis, or a kind of its motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AxisPart {
    /// Weight, counterbalance, inertia that varies with the position.
    Gravity,
    /// Friction, orders of mesh, backlash.
    Gear,
    /// Two inertias with spring and damping.
    Belt,
    /// Holding brake.
    Brake,
    /// Payload that changes within a record.
    PayloadSteps,
    /// The same cycle again and again.
    Cycle,
    /// Other moves in each cycle.
    AnyCycle,
}

/// Load beside the weight on the DC-motor rig, about the amplitude of the standard load of 0.15 N·m.
const LOAD_FACTOR: f64 = 1.0 / 30.0;

impl AxisPart {
    /// All parts.
    pub const ALL: [Self; 7] =
        [Self::Gravity, Self::Gear, Self::Belt, Self::Brake, Self::PayloadSteps, Self::Cycle, Self::AnyCycle];

    /// Name on the command line, in labels and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gravity => "gravity",
            Self::Gear => "gear",
            Self::Belt => "belt",
            Self::Brake => "brake",
            Self::PayloadSteps => "payload-steps",
            Self::Cycle => "cycle",
            Self::AnyCycle => "any-cycle",
        }
    }

    /// Short description.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::Gravity => "weight, counterbalance and inertia by position, payload ± 30 % from record to record",
            Self::Gear => "gear friction by direction and load, mesh orders or two-per-turn, backlash",
            Self::Belt => "elastic belt: two inertias with spring and damping",
            Self::Brake => "holding brake that closes at rest",
            Self::PayloadSteps => "weight whose payload changes at every second rest",
            Self::Cycle => "cycle of five moves and rests, the same again and again, sometimes interrupted",
            Self::AnyCycle => "cycles of five moves and rests, others each time",
        }
    }

    /// The part with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|part| part.name() == name)
    }
}

/// Ratio, and weight at the motor, if others than those of the conditions are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisOptions {
    /// Turns of the motor per turn of the axis.
    pub ratio: Option<f64>,
    /// Weight at the motor at nominal payload.
    pub weight_nm: Option<f64>,
}

fn axis(parts: &[AxisPart], options: AxisOptions, linear: bool) -> Axis {
    let has = |part| parts.contains(&part);
    let weight = if linear { Gravity::LINEAR } else { Gravity::ROTARY };
    let gear = has(AxisPart::Gear).then_some(if linear { Gear::LINEAR } else { Gear::ROTARY });
    let transmission = (has(AxisPart::Belt) || has(AxisPart::Gear)).then(|| Mechanics {
        backlash_deg: if has(AxisPart::Gear) { [0.5, 1.5] } else { [0.0; 2] },
        resonance_hz: match (has(AxisPart::Belt), linear) {
            (false, _) => Mechanics::GEAR.resonance_hz,
            (true, true) => [40.0, 60.0],
            (true, false) => [12.0, 20.0],
        },
        ..Mechanics::GEAR
    });
    Axis {
        ratio: options.ratio.unwrap_or(Axis::LEVEL.ratio),
        gravity: weighs(parts).then(|| Gravity { weight_nm: options.weight_nm.unwrap_or(weight.weight_nm), ..weight }),
        gear,
        transmission,
        brake: has(AxisPart::Brake).then_some(if linear { Brake::LINEAR } else { Brake::ROTARY }),
        payload_steps: has(AxisPart::PayloadSteps),
    }
}

/// Whether an axis with these parts has a weight.
#[must_use]
pub fn weighs(parts: &[AxisPart]) -> bool {
    parts.contains(&AxisPart::Gravity) || parts.contains(&AxisPart::PayloadSteps)
}

/// The motion that these parts set.
#[must_use]
pub fn motion(parts: &[AxisPart]) -> Option<Motion> {
    if parts.contains(&AxisPart::Cycle) {
        return Some(Motion::Same);
    }
    parts.contains(&AxisPart::AnyCycle).then_some(Motion::Any)
}

impl Scenario {
    /// This scenario on an axis with these parts, without a load sensor if the load was exact. A brake without cycles
    /// needs rests: it brings trapezoids with it, unless the duty is another one already.
    #[must_use]
    pub fn on_axis(self, parts: &[AxisPart], options: AxisOptions) -> Self {
        let mut changed = self.with_axis(axis(parts, options, false));
        changed.duty = match motion(parts) {
            Some(motion) => Duty::Cycle(motion),
            None if parts.contains(&AxisPart::Brake) && self.duty == Duty::Waveform => Duty::Trapezoids,
            None => self.duty,
        };
        changed
    }

    /// This scenario on this axis: a small load beside the weight, and no load sensor if the load was exact.
    #[must_use]
    pub fn with_axis(self, axis: Axis) -> Self {
        let mut changed = Self { axis: Some(axis), ..self };
        changed.load_amplitude_nm *= LOAD_FACTOR;
        changed.load_fluctuation_nm *= LOAD_FACTOR;
        if changed.field.load == LoadMeasurement::Exact {
            changed.field.load = LoadMeasurement::Absent;
        }
        changed
    }
}

impl EmaScenario {
    /// This scenario on an axis with these parts, without a load but its fluctuation. A brake without cycles needs
    /// rests: it brings the same cycle with it.
    #[must_use]
    pub fn on_axis(self, parts: &[AxisPart], options: AxisOptions) -> Self {
        let rests = parts.contains(&AxisPart::Brake).then_some(Motion::Same);
        Self {
            axis: Some(axis(parts, options, true)),
            cycle: motion(parts).or(rests),
            load: EmaLoad::Constant { force_n: 0.0 },
            ..self
        }
    }
}
