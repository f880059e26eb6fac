//! Every field of the settings by each of their faces: a drive file, the command line, and the options by which Python
//! calls.

use std::path::Path;

use model::settings::{DriveFile, Settings, Use, schema};
use serde_json::{Map, Value, json};

use crate::common::{run, succeed};

/// A field that is set: as a drive file has it, as words, and as the value of an option.
struct Set {
    toml: String,
    words: Vec<String>,
    value: Value,
}

/// Options that a training or a replay does not do without.
const BASE: [(&str, &str); 5] =
    [("traces", "t.csv"), ("labels", "l.csv"), ("y", "y"), ("u1", "u"), ("order", "1,1,0,1,1")];

/// Whether the schema of a field allows a kind.
fn is(field: &Value, kind: &str) -> bool {
    field["type"] == kind || field["type"].as_array().is_some_and(|kinds| kinds[0] == kind)
}

/// An example of a field by its schema alone, so that a new field needs nothing here.
fn example(key: &str, field: &Value) -> Set {
    let option = format!("--{}", key.replace('_', "-"));
    let of = |toml: &str, word: &str, value: Value| {
        let words =
            if field["x-positional"] == true { vec![word.to_string()] } else { vec![option.clone(), word.into()] };
        Set { toml: toml.into(), words, value }
    };
    if is(field, "boolean") {
        return Set { toml: "true".into(), words: vec![option], value: true.into() };
    }
    if let Some(choice) = field["oneOf"].as_array().map(|all| all[all.len() - 1]["const"].as_str().expect("a word")) {
        return of(&format!("\"{choice}\""), choice, choice.into());
    }
    if let Some(word) = field["examples"][0].as_str() {
        return of(&format!("\"{word}\""), word, word.into());
    }
    let (list, items) = (is(field, "array"), &field["items"]["type"]);
    match () {
        () if list && items == "integer" => of("[2, 1, 2, 1, 1]", "2,1,2,1,1", json!([2, 1, 2, 1, 1])),
        () if list && items == "number" => of("[0.25, 2]", "0.25,2", json!([0.25, 2.0])),
        // A name, a condition and a pair alike.
        () if list => of("[\"one=1\"]", "one=1", json!(["one=1"])),
        () if is(field, "number") => of("0.25", "0.25", json!(0.25)),
        () if is(field, "integer") => of("3", "3", json!(3)),
        () => of("\"name\"", "name", "name".into()),
    }
}

/// The settings by a drive file with the base.
fn by_file(own: &str, toml: &str) -> Settings {
    let mut text = String::new();
    for (section, fields) in schema::of_settings()["properties"].as_object().expect("sections") {
        text += &format!("[{section}]\n");
        for key in fields["properties"].as_object().expect("fields").keys() {
            let base = BASE.iter().find(|(key_of_base, _)| key_of_base == key).map(|(_, value)| format!("\"{value}\""));
            let value = if key == own { Some(toml.to_string()) } else { base };
            text += &value.map_or_else(String::new, |value| format!("{key} = {value}\n"));
        }
    }
    DriveFile::of(Path::new("d.toml"), text).unwrap_or_else(|error| panic!("{own}: {error}")).settings
}

/// The settings that the command line understands: it saves them before it looks for the labels.
fn by_words(folder: &Path, job: &Use, own: &str, set: &Set) -> Settings {
    let base = BASE.iter().filter(|(key, _)| *key != own && job.takes(key));
    let option = |(key, value): &(&str, &str)| match *key {
        "traces" => (*value).to_string(),
        key => format!("--{key} {value}"),
    };
    let base = base.map(option).collect::<Vec<_>>().join(" ");
    let words = set.words.join(" ");
    let output = run(folder, &format!("{} {words} {base} --model m.bwm --save saved.toml", job.name));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let text = std::fs::read_to_string(folder.join("saved.toml")).unwrap_or_else(|_| panic!("{own}: {said}"));
    std::fs::remove_file(folder.join("saved.toml")).expect("removable");
    DriveFile::of(Path::new("d.toml"), text).expect("a saved file").settings
}

/// The settings by options, as Python has them.
fn by_options(job: &Use, own: &str, value: Value) -> Settings {
    let base = BASE.iter().filter(|(key, _)| job.takes(key));
    let mut options: Map<String, Value> = base.map(|(key, value)| ((*key).to_string(), Value::from(*value))).collect();
    options.insert(own.into(), value);
    let (settings, further) = job.options(options).unwrap_or_else(|error| panic!("{own}: {error}"));
    further.end().unwrap_or_else(|error| panic!("{own}: {error}"));
    settings
}

#[test]
fn each_field_is_set_by_each_face() {
    let folder = tempfile::tempdir().expect("folder");
    let sections = schema::of_settings()["properties"].as_object().expect("sections");
    let mut count = 0;
    for (section, fields) in sections {
        for (key, field) in fields["properties"].as_object().expect("fields") {
            let set = example(key, field);
            let job = [Use::TRAIN, Use::EVALUATE, Use::REPLAY].into_iter().find(|job| job.takes(key));
            let job = job.unwrap_or_else(|| panic!("no command takes {key} of [{section}]"));
            let (options, words) = (by_options(&job, key, set.value.clone()), by_words(folder.path(), &job, key, &set));
            assert_eq!(options, words, "{key} by Python and by the command line");
            // A command that does not take the base leaves it out.
            let mut file = by_file(key, &set.toml);
            if !job.takes("order") {
                (file.channels, file.model) = <_>::default();
            }
            assert_eq!(file, options, "{key} by a drive file and by Python");
            assert!(file.has(key), "{key} is not set");
            count += 1;
        }
    }
    assert!(count > 60, "{count} fields");
}

#[test]
fn the_schema_describes_each_field() {
    let folder = tempfile::tempdir().expect("folder");
    let schema: Value = serde_json::from_str(&succeed(folder.path(), "schema")).expect("JSON");
    assert_eq!(schema["additionalProperties"], false);
    for (section, fields) in schema["properties"].as_object().expect("sections") {
        assert!(fields["description"].as_str().is_some_and(|text| text.len() > 10), "{section}");
        assert_eq!(fields["additionalProperties"], false, "{section}");
        for (key, field) in fields["properties"].as_object().expect("fields") {
            assert!(field["description"].as_str().is_some_and(|text| text.len() > 5), "{key}: {field}");
            assert!(
                field["type"].is_string() || field["type"].is_array() || field["oneOf"].is_array(),
                "{key}: {field}"
            );
            assert!(field.as_object().is_some_and(|own| own.keys().all(|name| !name.starts_with("x-"))), "{field}");
        }
    }
    assert_eq!(schema["properties"]["data"]["properties"]["where"]["type"][0], "array");
    assert_eq!(schema["properties"]["model"]["properties"]["folds"], Value::Null);
    assert_eq!(schema["properties"]["validation"]["properties"]["folds"]["default"], 10);
}

/// The kinds that a schema allows a value.
fn fits(field: &Value, value: &toml::Value) -> bool {
    let kind = match value {
        toml::Value::String(_) => "string",
        toml::Value::Integer(_) => "integer",
        toml::Value::Float(_) => "number",
        toml::Value::Boolean(_) => "boolean",
        toml::Value::Array(_) => "array",
        toml::Value::Table(_) => "object",
        toml::Value::Datetime(_) => "date",
    };
    let kinds: Vec<&str> = match &field["type"] {
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect(),
        own => own.as_str().into_iter().collect(),
    };
    let words = field["oneOf"].as_array().into_iter().flatten();
    let is_word = words.into_iter().any(|own| own["const"].as_str() == value.as_str());
    is_word || kinds.contains(&kind) || (kind == "integer" && kinds.contains(&"number"))
}

#[test]
fn drive_files_fit_the_schema() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 3 --seed 4 --out runs");
    succeed(dir, "init runs --out written.toml");
    let saved = "--y y --u1 u --order 1,1,0,1,1 --bearing 9,3,17,0.17 --priors a=0.5,b=0.5 --other-drive --memory 0.99";
    run(dir, &format!("train --labels absent.csv {saved} --model m.bwm --save saved.toml"));
    let schema = schema::of_drive_file();
    for name in ["written.toml", "saved.toml"] {
        let text = std::fs::read_to_string(dir.join(name)).expect("a drive file");
        let file: toml::Table = text.parse().expect("TOML");
        for (section, fields) in &file {
            for (key, value) in fields.as_table().expect("a table") {
                let field = &schema["properties"][section]["properties"][key];
                assert!(fits(field, value), "{name}: {key} = {value} against {field}");
            }
        }
        DriveFile::of(&dir.join(name), text).expect("a drive file");
    }
}
