//! Arguments of the novelty gate, the reject option and the alarm.

use clap::{Args, ValueEnum};

use model::Error;
use model::train::{AlarmInterval, Alarms};

/// Names of the healthy class if none is given.
const USUAL: [&str; 2] = ["healthy", "normal"];

/// Whether a model has a novelty gate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Novelty {
    /// If there is a healthy class, and its traces support the rate
    Gate,
    /// No gate and no alarm: the nearest class is the verdict
    None,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct AlarmArgs {
    /// Whether verdicts can be novel
    #[arg(long, value_enum, default_value = "gate")]
    novelty: Novelty,
    /// The healthy class, for novelty gate and alarm; if not given, the class named healthy or normal, or the only
    /// class
    #[arg(long, value_name = "CLASS")]
    healthy: Option<String>,
    /// Rate of healthy segments called novel; 0.01 if not given. With --group it is that of the next run (value of the
    /// column), otherwise segments count as independent
    #[arg(long, value_name = "RATE")]
    false_alarm: Option<f64>,
    /// Cost of no decision: if every class has a larger expected cost, the verdict is ambiguous
    #[arg(long, value_name = "COST", default_value_t = f64::INFINITY, hide_default_value = true)]
    reject_cost: f64,
    /// Mean hours between false alarms; 1000 if not given
    #[arg(long, value_name = "HOURS", conflicts_with = "alarm_interval_segments")]
    alarm_interval_h: Option<f64>,
    /// Mean segments between false alarms
    #[arg(long, value_name = "SEGMENTS")]
    alarm_interval_segments: Option<f64>,
    /// Number of segments after which a run (from power-up to power-up, a session) ends for the alarm if the firmware
    /// does not end it before; 1 if segments are independent. If not given, that of the longest healthy run of
    /// --group, otherwise 1
    #[arg(long, value_name = "SEGMENTS", value_parser = clap::value_parser!(u32).range(1..))]
    segments_a_run: Option<u32>,
    /// The groups of --group are drives, and the model is for another drive, which differs from them for good: gate and
    /// alarm are those of the next drive
    #[arg(long, requires = "group")]
    other_drive: bool,
}

/// The class of this name, or without one the class with a usual name.
pub(crate) fn healthy_class(given: Option<&str>, classes: &[String]) -> Result<Option<usize>, Error> {
    let place = |name: &str| classes.iter().position(|class| class == name.trim());
    let Some(name) = given else { return Ok(USUAL.iter().find_map(|name| place(name))) };
    let unknown = || Error::Usage(format!("--healthy: unknown class {name}; there are {}", classes.join(", ")));
    place(name).map(Some).ok_or_else(unknown)
}

impl AlarmArgs {
    /// The healthy class, if it is named or has a usual name.
    pub(crate) fn healthy_class(&self, classes: &[String]) -> Result<Option<usize>, Error> {
        healthy_class(self.healthy.as_deref(), classes)
    }

    pub(crate) fn alarms(&self, classes: &[String]) -> Result<Alarms, Error> {
        let healthy = self.healthy_class(classes)?;
        let only = (classes.len() == 1).then_some(0);
        let interval = match (self.alarm_interval_h, self.alarm_interval_segments) {
            (Some(hours), _) => AlarmInterval::Hours(hours),
            (None, Some(segments)) => AlarmInterval::Segments(segments),
            (None, None) => AlarmInterval::Usual,
        };
        if self.novelty == Novelty::None {
            return match (only, self.false_alarm, interval) {
                (None, None, AlarmInterval::Usual) => Ok(Alarms { reject_cost: self.reject_cost, ..Alarms::default() }),
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
        Ok(Alarms {
            healthy: healthy.or(only),
            false_alarm: self.false_alarm.unwrap_or(0.01),
            required: asked || only.is_some(),
            by_run: false,
            reject_cost: self.reject_cost,
            interval,
            segments_a_run: self.segments_a_run,
            other_drive: self.other_drive,
        })
    }
}
