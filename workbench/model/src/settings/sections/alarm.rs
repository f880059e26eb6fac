//! `[alarm]`: the healthy class, rates and costs; and its conversion to the gate and the alarm of a recipe.

use std::num::NonZeroU32;

use serde::{Deserialize, Serialize};

use super::choices::Novelty;
use super::merge::merges;
use crate::Error;
use crate::near::among;
use crate::trace::composed;
use crate::train::{ACCEPTABLE, AlarmInterval, Alarms};

/// Names of the healthy class if none is given.
pub const HEALTHY_NAMES: [&str; 2] = ["healthy", "normal"];
/// Rate of healthy segments called novel.
const FALSE_ALARM: f64 = 0.01;

/// The healthy class, rates and costs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Alarm {
    /// The healthy class, for novelty gate and alarm; if not given, the class named healthy or normal, or the only
    /// class
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CLASS")))]
    pub healthy: Option<String>,
    /// Whether verdicts can be novel
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("default" = Novelty::default())))]
    pub novelty: Option<Novelty>,
    /// Rate of healthy segments called novel; 0.01 if not given. With a group it is that of the next run (value of the
    /// column), otherwise segments count as independent
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "RATE")))]
    pub false_alarm: Option<f64>,
    /// Cost of no decision: if every class has a larger expected cost, the verdict is ambiguous
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "COST")))]
    pub reject_cost: Option<f64>,
    /// Mean hours between false alarms; 1000 if not given
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "HOURS")))]
    pub alarm_interval_h: Option<f64>,
    /// Mean segments between false alarms
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "SEGMENTS")))]
    pub alarm_interval_segments: Option<f64>,
    /// Number of segments after which a run (from power-up to power-up, a session) ends for the alarm if the firmware
    /// does not end it before; 1 if segments are independent. If not given, that of the longest healthy run of the
    /// group, otherwise 1
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "SEGMENTS")))]
    pub segments_a_run: Option<NonZeroU32>,
    /// The groups are drives, and the model is for another drive, which differs from them for good: gate and alarm are
    /// those of the next drive
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub other_drive: bool,
    /// A segment is called healthy if the smallest defect that it would have shown is at most so many times the usual
    /// one of the training records; 2 if not given
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "TIMES")))]
    pub acceptable: Option<f64>,
    /// Priors, e.g. healthy=0.98,spall=0.01,roughness=0.01; equal if not given
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CLASS=P", "x-pairs" = true)))]
    pub priors: Vec<String>,
    /// Cost of deciding a class when another is true, e.g. healthy:spall=50; 1 if not given
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "DECIDED:TRUE=COST", "x-pairs" = true)))]
    pub cost: Vec<String>,
}

merges!(Alarm {
    healthy,
    novelty,
    false_alarm,
    reject_cost,
    alarm_interval_h,
    alarm_interval_segments,
    segments_a_run,
    other_drive,
    acceptable,
    priors,
    cost
});

/// The class of this name, or without one the class with a usual name.
///
/// # Errors
/// There is no class of this name.
pub fn healthy_class(given: Option<&str>, classes: &[String]) -> Result<Option<usize>, Error> {
    let place = |name: &str| classes.iter().position(|class| *class == composed(name.trim()));
    let Some(name) = given else { return Ok(HEALTHY_NAMES.iter().find_map(|name| place(name))) };
    let near = || among(name, classes);
    let unknown = || Error::Usage(format!("--healthy: unknown class {name}{}", near()));
    place(name).map(Some).ok_or_else(unknown)
}

impl Alarm {
    /// The healthy class, if it is named or has a usual name.
    ///
    /// # Errors
    /// There is no class of this name.
    pub fn healthy_class(&self, classes: &[String]) -> Result<Option<usize>, Error> {
        healthy_class(self.healthy.as_deref(), classes)
    }

    /// Gate, reject option and alarm of a recipe.
    ///
    /// # Errors
    /// An unknown class; settings of the gate that do not go together.
    pub fn alarms(&self, classes: &[String]) -> Result<Alarms, Error> {
        let healthy = self.healthy_class(classes)?;
        let only = (classes.len() == 1).then_some(0);
        let reject_cost = self.reject_cost.unwrap_or(f64::INFINITY);
        let interval = match (self.alarm_interval_h, self.alarm_interval_segments) {
            (Some(hours), _) => AlarmInterval::Hours(hours),
            (None, Some(segments)) => AlarmInterval::Segments(segments),
            (None, None) => AlarmInterval::Usual,
        };
        if self.novelty == Some(Novelty::None) {
            return match (only, self.false_alarm, interval) {
                (None, None, AlarmInterval::Usual) => Ok(Alarms { reject_cost, ..Alarms::default() }),
                (Some(_), ..) => {
                    Err(Error::Usage("a model of one class needs its gate; leave out --novelty none".into()))
                }
                _ => Err(Error::Usage("--novelty none has no rate of false alarms; leave out one of them".into())),
            };
        }
        let asked = self.healthy.is_some() || self.false_alarm.is_some() || interval != AlarmInterval::Usual;
        if asked && healthy.or(only).is_none() {
            return Err(Error::Usage("a false-alarm rate needs a healthy class; name it by --healthy".into()));
        }
        let acceptable = self.acceptable.unwrap_or(ACCEPTABLE);
        if acceptable <= 1.0 || acceptable.is_nan() {
            return Err(Error::Usage(format!(
                "--acceptable {acceptable}: a multiple above 1 of the usual smallest defect"
            )));
        }
        Ok(Alarms {
            healthy: healthy.or(only),
            false_alarm: self.false_alarm.unwrap_or(FALSE_ALARM),
            required: asked || only.is_some(),
            by_run: false,
            reject_cost,
            interval,
            segments_a_run: self.segments_a_run.map(NonZeroU32::get),
            other_drive: self.other_drive,
            acceptable,
        })
    }
}
