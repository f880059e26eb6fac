//! Classes, conditions, waveforms and races by their names.

use serde::Deserialize;
use serde::de::{Deserializer, Error};

use rig::ema::{EmaCondition, Race};
use rig::{AxisPart, Condition, DefectKind, Waveform};

/// Name, note and value of each choice.
type Choices<T> = Vec<(&'static str, String, T)>;

fn classes() -> Choices<DefectKind> {
    DefectKind::ALL.map(|kind| (kind.name(), kind.about().into(), kind)).to_vec()
}

/// Names of the conditions of both rigs, and of the parts of an axis.
fn conditions() -> Choices<&'static str> {
    let dc = Condition::all().map(|condition| (condition.name, condition.about.to_string(), condition.name));
    let ema = EmaCondition::ALL.into_iter().filter(|condition| Condition::named(condition.name).is_none());
    let ema = ema.map(|condition| (condition.name, format!("EMA: {}", condition.about), condition.name));
    let parts = AxisPart::ALL.map(|part| (part.name(), format!("axis: {}", part.about()), part.name()));
    dc.chain(ema).chain(parts).collect()
}

fn waveforms() -> Choices<Waveform> {
    Waveform::ALL.map(|shape| (shape.name(), shape.about().into(), shape)).to_vec()
}

fn races() -> Choices<Race> {
    Race::ALL.map(|race| (race.name(), race.about().into(), race)).to_vec()
}

/// The choice of this name.
fn named<T, E: Error>(choices: Choices<T>, given: &str) -> Result<T, E> {
    let names: Vec<&str> = choices.iter().map(|(name, ..)| *name).collect();
    let problem = || E::custom(format!("no such choice: {given}; there are {}", names.join(", ")));
    choices.iter().position(|(name, ..)| *name == given).map_or_else(
        || Err(problem()),
        |place| choices.into_iter().nth(place).map(|(_, _, value)| value).ok_or_else(problem),
    )
}

/// One of some choices, or none.
fn one<'de, D: Deserializer<'de>, T>(deserializer: D, choices: Choices<T>) -> Result<Option<T>, D::Error> {
    Option::<String>::deserialize(deserializer)?.map(|given| named(choices, &given)).transpose()
}

pub(super) fn class_list<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<DefectKind>, D::Error> {
    Vec::<String>::deserialize(deserializer)?.iter().map(|given| named(classes(), given)).collect()
}

pub(super) fn condition_list<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<&'static str>, D::Error> {
    Vec::<String>::deserialize(deserializer)?.iter().map(|given| named(conditions(), given)).collect()
}

pub(super) fn waveform<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Waveform>, D::Error> {
    one(deserializer, waveforms())
}

pub(super) fn race<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Race>, D::Error> {
    one(deserializer, races())
}

/// The schemas of these choices.
#[cfg(feature = "schema")]
pub(super) mod schemas {
    use schemars::{Schema, SchemaGenerator, json_schema};
    use serde_json::{Value, json};

    use super::Choices;

    fn choices<T>(all: Choices<T>) -> Value {
        all.into_iter()
            .map(|(name, about, _)| json!({ "type": "string", "const": name, "description": about }))
            .collect()
    }

    pub(in super::super) fn classes(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "array", "items": { "oneOf": choices(super::classes()) } })
    }

    pub(in super::super) fn conditions(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "array", "items": { "oneOf": choices(super::conditions()) } })
    }

    pub(in super::super) fn waveform(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": choices(super::waveforms()) })
    }

    pub(in super::super) fn race(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": choices(super::races()) })
    }
}
