//! What was seen and what is asked, for a program that shows it: the columns of the first recording, and each question
//! with the text of the drive file in which the answer takes the place of the question mark.

use serde_json::{Value, json};

use super::found::Found;
use super::guess::Guess;
use super::names::{AXIS, Told};
use super::{Described, made};
use crate::reader::Series;
use crate::units::{Quantity, Unit};

/// Number of parts of a recording of which the course of a column has the lowest and the highest value.
const COURSE: usize = 120;

/// A column of the first recording.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    /// Its name.
    name: String,
    /// What its name says that is measured, and the unit.
    unit: Option<Unit>,
    /// Rows without a number.
    missing: usize,
    /// Lowest and highest value of each part of the recording that has one.
    course: Vec<[f64; 2]>,
}

impl Column {
    fn of(name: &str, values: &[f64]) -> Self {
        let parts = values.chunks(values.len().div_ceil(COURSE).max(1));
        let range = |part: &[f64]| {
            let known = part.iter().filter(|x| x.is_finite());
            let [low, high] =
                known.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]);
            (low <= high).then_some([low, high])
        };
        Self {
            name: name.to_string(),
            unit: Unit::of_column(name),
            missing: values.iter().filter(|x| !x.is_finite()).count(),
            course: parts.filter_map(range).collect(),
        }
    }
}

/// The columns of a recording.
pub(super) fn columns(names: &[String], recording: Option<&Series>) -> Vec<Column> {
    let values = recording.map(|one| one.columns.as_slice()).unwrap_or_default();
    names.iter().zip(values).map(|(name, values)| Column::of(name, values)).collect()
}

/// What the user has to say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Question {
    /// The question.
    pub text: String,
    /// Texts of the drive file in which the answer takes the place of `?`.
    pub marks: Vec<String>,
    /// The key of the drive file whose value is the answer, if it has none yet.
    pub key: Option<&'static str>,
    /// The answers; empty if it is a number or a text.
    pub answers: Vec<String>,
}

/// What is asked.
pub(super) fn questions(found: &Found) -> Vec<Question> {
    let texts = |all: &[&str]| all.iter().map(ToString::to_string).collect();
    let axes = found.axes.iter().filter(|axes| axes.is_question()).map(|axes| Question {
        text: axes.said.clone(),
        marks: axes.marks(),
        answers: axes.moving.clone(),
        ..Question::default()
    });
    let motors = (!found.motors.is_empty()).then(|| Question {
        text: "The files are of several motors: which one has the bearing?".into(),
        marks: vec![format!("{AXIS}=?")],
        answers: found.motors.clone(),
        ..Question::default()
    });
    let channels = [&found.turning.angle, &found.turning.velocity].into_iter().flatten();
    let units = channels.filter(|channel| channel.is_question()).flat_map(|channel| {
        let said = channel.said.clone().unwrap_or_default();
        channel.marks().into_iter().map(move |(mark, answers)| {
            let text = if answers.is_empty() { said.clone() } else { format!("{mark}: which unit?") };
            Question { text, marks: vec![mark], answers: texts(answers), ..Question::default() }
        })
    });
    let rate = found.rate_hz.is_none().then(|| Question {
        text: "The files have no time: how many rows a second have they?".into(),
        key: Some("rate_hz"),
        ..Question::default()
    });
    let classes = (found.made == Some(Told::Nothing)).then(|| Question {
        text: made(Told::Nothing),
        key: Some("labels"),
        ..Question::default()
    });
    axes.chain(motors).chain(units).chain(rate).chain(classes).collect()
}

/// The channel that a column is taken as.
fn role(guess: &Guess, name: &str) -> Option<&'static str> {
    let Guess { current, velocity, velocity_ref, current_ref, angle, load, phases } = guess;
    let one = [
        ("current", current),
        ("velocity", velocity),
        ("velocity_ref", velocity_ref),
        ("current_ref", current_ref),
        ("angle", angle),
        ("load", load),
    ];
    let one = one.into_iter().find(|(_, own)| own.as_deref() == Some(name)).map(|(role, _)| role);
    one.or_else(|| phases.iter().any(|phase| phase == name).then_some("phase"))
}

/// The name of a quantity.
fn quantity(unit: &Unit) -> &'static str {
    match unit.quantity {
        Quantity::Angle => "angle",
        Quantity::AngularVelocity => "angular velocity",
        Quantity::Length => "length",
        Quantity::Velocity => "velocity",
        Quantity::Current => "current",
        Quantity::Voltage => "voltage",
        Quantity::Torque => "torque",
        Quantity::Force => "force",
        Quantity::Temperature => "temperature",
        Quantity::Time => "time",
        Quantity::Other => "other",
    }
}

/// The labels, and the columns of the first recording, as JSON.
pub(super) fn recordings(found: &Found) -> Value {
    let channel = |column: &Column| {
        json!({
            "name": column.name,
            "role": role(&found.proposal.columns, &column.name),
            "quantity": column.unit.as_ref().map(quantity),
            "unit": column.unit.as_ref().map(Unit::name).filter(|name| !name.is_empty()),
            "missing": column.missing,
            "course": column.course,
        })
    };
    json!({
        "labels": found.labels.0,
        "classes": found.labels.2,
        "files": found.files,
        "rows": found.rows,
        "rate_hz": found.rate_hz,
        "columns": found.columns.iter().map(channel).collect::<Vec<_>>(),
    })
}

impl Described {
    /// The report, for `init --json`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let questions = self
            .questions
            .iter()
            .map(|own| json!({ "question": own.text, "marks": own.marks, "key": own.key, "answers": own.answers }));
        let mut value = json!({ "drive_file": self.file, "told": self.told, "refused": self.refused });
        let further = json!({ "questions": questions.collect::<Vec<_>>() });
        for part in [self.recordings.clone(), further] {
            value.as_object_mut().into_iter().zip(part.as_object()).for_each(|(all, own)| all.extend(own.clone()));
        }
        value
    }
}
