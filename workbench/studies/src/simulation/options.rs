//! What is simulated.

use serde::Deserialize;

use super::names;
use rig::ema::Race;
use rig::{DefectKind, Waveform};

/// Which traces are simulated.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Simulation {
    /// Which rig
    #[serde(default)]
    pub rig: Rig,
    /// Class of each trace: the defect, or healthy; several separated by commas
    #[serde(deserialize_with = "names::class_list")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "names::schemas::classes", extend("x-value" = "NAMES")))]
    pub class: Vec<DefectKind>,
    /// Traces of each class
    #[serde(default = "twenty")]
    pub count: u32,
    /// Seed; sets of different seeds never share a trace
    #[serde(default = "one")]
    pub seed: u32,
    /// Size of the defect, 1 for full size
    #[serde(default = "full")]
    pub severity: f64,
    /// Condition that differs from the standard rig
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(schema_with = "names::schemas::condition", extend("x-value" = "NAME")))]
    pub condition: Option<names::ConditionName>,
    /// Shape of the velocity reference [default: sine, or that of the condition]
    #[serde(default, deserialize_with = "names::waveform")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "names::schemas::waveform", extend("x-value" = "SHAPE")))]
    pub waveform: Option<Waveform>,
    /// Resolution of the recorded angle, bits of a turn [default: exact, or that of the condition]
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "BITS")))]
    pub angle_bits: Option<u32>,
    /// Race with the spall, EMA rig only [default: inner]
    #[serde(default, deserialize_with = "names::race")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "names::schemas::race", extend("x-value" = "RACE")))]
    pub race: Option<Race>,
    /// Record every Nth control interval (1/12 000 s; of the RIT rig 1/10 000 s) for the same time, without holding
    /// values; EMA rig only [default: that of the condition]
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N")))]
    pub log_every: Option<u32>,
    /// Short for --condition mix
    #[serde(default)]
    pub mix: bool,
}

/// A simulated rig.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Rig {
    /// PM DC motor under velocity control (thesis Fig. 3.1)
    #[default]
    Dc,
    /// Electromechanical actuator under position control (thesis chapter 5)
    Ema,
}

const fn twenty() -> u32 {
    20
}

const fn one() -> u32 {
    1
}

const fn full() -> f64 {
    1.0
}

impl Simulation {
    /// Name of the condition.
    #[must_use]
    pub fn condition_name(&self) -> &'static str {
        if self.mix { "mix" } else { self.condition.map_or("standard", |own| own.0) }
    }
}
