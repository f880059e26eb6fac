//! The forms of JSON that programs read most, key by key, for `bearing-watch schema`.
//!
//! Tests compare them with what the commands print.

use serde_json::{Map, Value, json};

use crate::command_line::output::VERSION;

/// A key: name, type, and meaning. The type is one of JSON Schema; `?` behind it allows null.
pub(crate) type Key = (&'static str, &'static str, &'static str);

/// A form of JSON.
#[derive(Debug)]
pub(crate) struct Form {
    pub(crate) name: &'static str,
    pub(crate) about: &'static str,
    /// Whether it is a list of such objects.
    pub(crate) list: bool,
    pub(crate) keys: &'static [Key],
    /// Keys that are only there with some options.
    pub(crate) optional: &'static [Key],
}

impl Form {
    /// Its JSON Schema.
    pub(crate) fn schema(&self) -> Value {
        let name = format!("bearing-watch/{}", self.name);
        let fixed = [
            ("format", json!({ "const": name, "description": "Name of this form" })),
            ("version", json!({ "const": VERSION, "description": "Version of this form" })),
        ];
        let fixed = fixed.map(|(key, value)| (key.to_string(), value));
        let of_key = |(key, kind, about): &Key| {
            let kinds = match (kind.strip_suffix('?'), kind.split_once('|')) {
                (Some(kind), _) => json!([kind, "null"]),
                (None, Some((one, other))) => json!([one, other]),
                (None, None) => json!(kind),
            };
            (key.to_string(), json!({ "type": kinds, "description": about }))
        };
        let properties: Map<String, Value> =
            fixed.into_iter().chain(self.keys.iter().chain(self.optional).map(of_key)).collect();
        let required: Vec<&str> = ["format", "version"].into_iter().chain(self.keys.iter().map(|key| key.0)).collect();
        let object = json!({ "type": "object", "properties": properties, "required": required });
        let mut schema = json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": name,
            "description": self.about,
        });
        let own = if self.list { json!({ "type": "array", "items": object }) } else { object };
        if let (Some(schema), Value::Object(own)) = (schema.as_object_mut(), own) {
            schema.extend(own);
        }
        schema
    }
}

/// What a command prints if it fails.
pub(crate) const ERROR: Form = Form {
    name: "error",
    about: "Why a command failed; its exit code is 2",
    list: false,
    keys: &[("error", "object", "kind (usage, file, content, trace, training or other) and message")],
    optional: &[],
};
