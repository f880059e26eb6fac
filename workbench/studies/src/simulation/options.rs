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
    /// Condition that differs from the standard rig; parts of an axis combine, on top of mix or of another condition
    #[serde(default, deserialize_with = "names::condition_list")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "names::schemas::conditions", extend("x-value" = "NAMES")))]
    pub condition: Vec<&'static str>,
    /// Turns of the motor per turn of an axis, 1 to 160 [default: 50]
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "RATIO")))]
    pub ratio: Option<f64>,
    /// Weight of an axis at the motor at nominal payload, N·m [default: 0.15, EMA rig 2]
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NM")))]
    pub weight: Option<f64>,
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
