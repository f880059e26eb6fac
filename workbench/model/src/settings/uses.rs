//! Which settings a job takes: those of the others in a drive file are for other jobs.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::faces::fields::fields;
use super::faces::written_values::{Problem, from_value};
use super::sections::settings::Settings;
use crate::Error;
use crate::near::did_you_mean;

/// The settings that a job takes.
#[derive(Clone, Copy, Debug)]
pub struct Use {
    /// Name of the job, which is that of its command.
    pub name: &'static str,
    /// Keys, in groups.
    pub keys: &'static [&'static [&'static str]],
    /// Keys that it does not do without.
    pub required: &'static [&'static str],
}

/// Time of the rows, and the layout of text files.
pub const TIMES: &[&str] = &["time", "rate_hz", "skip", "units_row", "separator", "decimal"];
/// Traces, labels and their selection.
const SELECTION: &[&str] = &["traces", "labels", "where", "classes"];
/// The three signals.
pub const CHANNELS: &[&str] = &["front_end", "y", "u1", "u2"];
/// Which traces are alike.
const GROUPS: &[&str] = &["group", "unit"];
/// What is done to traces before.
pub const PREPARATION: &[&str] = &["block_mean", "decimate"];
const STRUCTURE: &[&str] = &["order", "offset", "park"];
const SHAFT: &[&str] = &[
    "current",
    "velocity",
    "velocity_ref",
    "angle",
    "load",
    "bearing",
    "orders",
    "harmonics",
    "slip",
    "velocity_from",
    "current_delay",
    "balance_cutoff_hz",
    "gear_ratio",
];
/// A bearing, and what loads it.
const LIFE: &[&str] =
    &["bearing", "load_rating_n", "rollers", "bearing_load_n", "bearing_load_per_nm", "torque_constant_nm_a"];
const ESTIMATION: &[&str] = &["method", "nominal", "segment", "memory", "handover", "saturation", "stuck"];
const CLASSIFIER: &[&str] = &[
    "features",
    "rising",
    "identify",
    "projection",
    "components",
    "variance",
    "discriminant",
    "shrinkage",
    "size_spread",
    "priors",
    "cost",
];
const ALARM: &[&str] = &[
    "healthy",
    "novelty",
    "false_alarm",
    "reject_cost",
    "alarm_interval_h",
    "alarm_interval_segments",
    "segments_a_run",
    "other_drive",
    "acceptable",
];

impl Use {
    /// Training from traces.
    pub const TRAIN: Self = Self {
        name: "train",
        keys: &[
            SELECTION,
            TIMES,
            CHANNELS,
            STRUCTURE,
            SHAFT,
            ESTIMATION,
            PREPARATION,
            &["covariates"],
            CLASSIFIER,
            ALARM,
            GROUPS,
            &["train_where", "test_where", "folds", "fold_seed"],
        ],
        required: &["labels"],
    };
    /// Evaluation of a model.
    pub const EVALUATE: Self = Self {
        name: "evaluate",
        keys: &[SELECTION, GROUPS, &["test_where", "by", "controls", "control_classes"]],
        required: &["labels"],
    };
    /// Replay of recordings through a model.
    pub const REPLAY: Self =
        Self { name: "replay", keys: &[&["traces", "labels", "group"], LIFE], required: &["traces"] };
    /// Features of traces as a part.
    pub const FEATURES: Self = Self {
        name: "features",
        keys: &[
            SELECTION,
            TIMES,
            CHANNELS,
            STRUCTURE,
            SHAFT,
            ESTIMATION,
            PREPARATION,
            GROUPS,
            &["features", "covariates", "train_where", "healthy"],
        ],
        required: &["labels", "y", "u1", "order"],
    };
    /// Training from parts.
    pub const TRAIN_FEATURES: Self = Self {
        name: "train-features",
        keys: &[CLASSIFIER, ALARM, GROUPS, &["covariates", "classes", "train_where"]],
        required: &[],
    };

    /// Its keys.
    pub fn keys(&self) -> impl Iterator<Item = &'static str> {
        self.keys.iter().flat_map(|group| group.iter().copied())
    }

    /// Whether it takes a key.
    #[must_use]
    pub fn takes(&self, key: &str) -> bool {
        self.keys().any(|own| own == key)
    }

    /// Returns an error if a setting that the job does not do without is not given.
    ///
    /// # Errors
    /// One is not.
    pub fn require(&self, settings: &Settings) -> Result<(), Error> {
        let missing = self.required.iter().filter(|key| !settings.has(key));
        let missing: Vec<String> = missing.map(|key| format!("--{}", key.replace('_', "-"))).collect();
        if missing.is_empty() {
            return Ok(());
        }
        Err(Error::Usage(format!("the following required arguments were not provided: {}", missing.join(" "))))
    }

    /// The settings among options of the job by name, and its further options.
    ///
    /// # Errors
    /// A value that does not fit, or settings that exclude each other.
    pub fn options(&self, options: Map<String, Value>) -> Result<(Settings, Further), Error> {
        let (mut own, mut rest) = (Settings::default(), Map::new());
        for (key, value) in options.into_iter().filter(|(_, value)| !value.is_null()) {
            if self.takes(&key) {
                own.set(&key, value).map_err(|refused| Error::Usage(refused.to_string()))?;
            } else {
                rest.insert(key, value);
            }
        }
        own.refuse_rivals()?;
        Ok((own, Further { job: self.name, known: self.keys().collect(), rest }))
    }
}

/// Options of a job that are no settings.
#[derive(Clone, Debug)]
pub struct Further {
    job: &'static str,
    known: Vec<&'static str>,
    rest: Map<String, Value>,
}

impl Further {
    /// Takes the fields of a struct.
    ///
    /// # Errors
    /// A value that does not fit, or one that is missing.
    pub fn take<T: DeserializeOwned>(&mut self) -> Result<T, Error> {
        let own = fields::<T>();
        self.known.extend(own);
        let taken = own.iter().filter_map(|key| self.rest.shift_remove_entry(*key)).collect();
        from_value(Value::Object(taken)).map_err(|problem| match problem {
            Problem::Field(key, inner) if matches!(*inner, Problem::Kind(_)) => Error::Usage(format!("{key} {inner}")),
            other => Error::Usage(other.to_string()),
        })
    }

    /// Returns an error if there is an option that nothing takes.
    ///
    /// # Errors
    /// There is one.
    pub fn end(&self) -> Result<(), Error> {
        self.rest.keys().next().map_or(Ok(()), |key| {
            let near = did_you_mean(key, self.known.iter().copied());
            Err(Error::Usage(format!("{} has no option {key}{near}", self.job)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::faces::fields::{keys, section_of};

    #[test]
    fn a_job_takes_known_keys_and_each_key_is_taken() {
        let jobs = [Use::TRAIN, Use::EVALUATE, Use::REPLAY, Use::FEATURES, Use::TRAIN_FEATURES];
        for job in jobs {
            let stranger = job.keys().chain(job.required.iter().copied()).find(|key| section_of(key).is_none());
            assert_eq!(stranger, None, "{}", job.name);
        }
        let untaken = keys().find(|(_, key)| !jobs.iter().any(|job| job.takes(key)));
        assert!(untaken.is_none(), "{untaken:?}");
    }
}
