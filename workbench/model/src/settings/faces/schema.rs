//! The JSON Schema of the settings: of a drive file, and for the faces that make something of it.
//!
//! Further properties beside those of the standard are for the command line: `x-value` is the name of an option's
//! value, `x-positional` is a list without a name, and `x-file` is a file.

use std::sync::OnceLock;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

use super::fields::{section_of, sections};
use crate::settings::sections::settings::Settings;

/// The schema of a drive file, without the properties for the command line.
#[must_use]
pub fn of_drive_file() -> Value {
    let mut schema = of_settings().clone();
    schema["title"] = "drive.toml of bearing-watch".into();
    schema["description"] = "What a drive is: its recordings, channels, bearing, model and alarm".into();
    plain(&mut schema);
    schema
}

/// The schema of the settings.
pub fn of_settings() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| {
        let mut schema = of::<Settings>();
        for section in sections() {
            schema["properties"][section.name]["description"] = section.about.into();
        }
        schema
    })
}

/// The schema of a field.
#[must_use]
pub fn of_field(key: &str) -> Option<&'static Value> {
    let section = section_of(key)?;
    of_settings().get("properties")?.get(section.name)?.get("properties")?.get(key)
}

/// The schema of a struct, with each part in its place.
#[must_use]
pub fn of<T: JsonSchema>() -> Value {
    let inline = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let mut schema = inline.into_generator().into_root_schema_for::<T>().to_value();
    tidy(&mut schema);
    schema
}

/// Takes out what a user does not write: null, and defaults of what is not given; and says what else may be written.
fn tidy(schema: &mut Value) {
    let Some(own) = schema.as_object_mut() else { return };
    if own.get("default").is_some_and(|value| matches!(value, Value::Null | Value::Object(_) | Value::Bool(false))) {
        own.remove("default");
    }
    if let Some(Value::String(text)) = own.get_mut("description") {
        *text = text.split('\n').map(str::trim).collect::<Vec<_>>().join(" ");
    }
    without_null(own);
    for (key, inner) in own.iter_mut() {
        match (key.as_str(), inner) {
            ("properties", Value::Object(fields)) => fields.values_mut().for_each(tidy),
            ("oneOf", Value::Array(all)) => all.iter_mut().for_each(tidy),
            ("items", inner) => tidy(inner),
            _ => {}
        }
    }
    if own.get("type") == Some(&json!("array")) {
        let also = if own.get("x-pairs") == Some(&json!(true)) { "object" } else { "number" };
        own.insert("type".into(), json!(["array", "string", also]));
    }
}

/// The schema of a field that may be left out, without its null.
fn without_null(own: &mut Map<String, Value>) {
    let null = json!("null");
    if let Some(Value::Array(kinds)) = own.get_mut("type") {
        kinds.retain(|kind| *kind != null);
        if let [only] = &kinds[..] {
            let only = only.clone();
            own.insert("type".into(), only);
        }
    }
    let Some(Value::Array(all)) = own.remove("anyOf") else { return };
    let given = all.into_iter().find(|one| one.get("type") != Some(&null));
    if let Some(Value::Object(given)) = given {
        let lacking = given.into_iter().filter(|(key, _)| !own.contains_key(key)).collect::<Vec<_>>();
        own.extend(lacking);
    }
}

/// Takes out the properties for the command line.
fn plain(schema: &mut Value) {
    match schema {
        Value::Object(own) => {
            own.retain(|key, _| !key.starts_with("x-"));
            own.values_mut().for_each(plain);
        }
        Value::Array(all) => all.iter_mut().for_each(plain),
        _ => {}
    }
}
