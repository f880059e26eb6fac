//! What does not fit, in words.

use serde_json::Value;

/// Why a value does not fit its field.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// It is of another kind: a verb and its object.
    #[error("{0}")]
    Kind(&'static str),
    /// It is out of range, or no such word.
    #[error("{0}")]
    Value(String),
    /// The field of a table with a value that does not fit.
    #[error("{0}: {1}")]
    Field(String, Box<Self>),
}

impl Problem {
    /// The problem without the names of tables.
    pub(super) fn plain(self) -> Self {
        if let Self::Field(_, inner) = self { inner.plain() } else { self }
    }
}

/// A field with a value that does not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The field.
    pub key: String,
    /// The value, as text.
    pub value: String,
    /// Why.
    pub problem: Problem,
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { key, value, problem } = self;
        match problem {
            Problem::Kind(_) => write!(f, "{key} {problem}"),
            Problem::Value(_) | Problem::Field(..) => write!(f, "invalid value '{value}' for {key}: {problem}"),
        }
    }
}

/// A value as a user would write it on one line.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(shown).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}
