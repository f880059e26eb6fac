//! Parsers of the names of classes, conditions, waveforms and races, with notes for the help.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use rig::ema::{EmaCondition, Race};
use rig::{Condition, DefectKind, Waveform};

/// Returns a parser for the name of one of `choices`: name, note for the help, value.
fn one_of<T>(choices: Vec<(&'static str, String, T)>) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    let values = choices.iter().map(|(name, about, _)| PossibleValue::new(*name).help(about.clone()));
    PossibleValuesParser::new(values).try_map(move |given| {
        let choice = choices.iter().find(|(name, _, _)| *name == given);
        choice.map(|(_, _, value)| *value).ok_or_else(|| format!("no such choice: {given}"))
    })
}

pub(super) fn classes() -> impl TypedValueParser<Value = DefectKind> {
    one_of(DefectKind::ALL.map(|kind| (kind.name(), kind.about().into(), kind)).to_vec())
}

/// Names of the conditions of both rigs.
pub(super) fn conditions() -> impl TypedValueParser<Value = &'static str> {
    let dc = Condition::all().map(|condition| (condition.name, condition.about.to_string(), condition.name));
    let ema = EmaCondition::ALL.into_iter().filter(|condition| Condition::named(condition.name).is_none());
    let ema = ema.map(|condition| (condition.name, format!("EMA: {}", condition.about), condition.name));
    one_of(dc.chain(ema).collect())
}

pub(super) fn waveforms() -> impl TypedValueParser<Value = Waveform> {
    one_of(Waveform::ALL.map(|shape| (shape.name(), shape.about().into(), shape)).to_vec())
}

pub(super) fn races() -> impl TypedValueParser<Value = Race> {
    one_of(Race::ALL.map(|race| (race.name(), race.about().into(), race)).to_vec())
}
