//! JSON beside the schema that the program prints for it.

use serde_json::Value;

use super::common::succeed;

/// The schema of a form.
pub fn schema(form: &str) -> Value {
    let folder = tempfile::tempdir().expect("folder");
    serde_json::from_str(&succeed(folder.path(), &format!("schema {form}"))).expect("JSON")
}

/// What a JSON Schema of a flat object wants of it: keys and types.
pub fn fit(schema: &Value, value: &Value) {
    let (schema, value) = match schema["type"].as_str() {
        Some("array") => (&schema["items"], &value[0]),
        _ => (schema, value),
    };
    let own = value.as_object().expect("an object");
    for (key, inner) in own {
        let field = &schema["properties"][key];
        assert!(field.is_object(), "{key} is not described");
        if let Some(fixed) = field.get("const") {
            assert_eq!(fixed, inner, "{key}");
            continue;
        }
        let kinds: Vec<&str> = match &field["type"] {
            Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect(),
            kind => kind.as_str().into_iter().collect(),
        };
        let kind = match inner {
            Value::Null => "null",
            Value::Bool(_) => "boolean",
            Value::Number(number) if number.is_f64() => "number",
            Value::Number(_) => "integer",
            Value::String(_) => "string",
            Value::Array(_) => "array",
            Value::Object(_) => "object",
        };
        assert!(kinds.contains(&kind) || (kind == "integer" && kinds.contains(&"number")), "{key}: {inner}");
    }
    for key in schema["required"].as_array().expect("required keys").iter().filter_map(Value::as_str) {
        assert!(own.contains_key(key), "no {key}");
    }
}
