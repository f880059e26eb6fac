//! The keys of `drive.toml`, and its values with their lines.

use std::path::Path;

use toml::de::{DeTable, DeValue};

use model::Error;

/// A table of the file, its keys, and what it is for.
pub(super) struct Section {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    pub(super) keys: &'static [&'static str],
}

const fn section(name: &'static str, about: &'static str, keys: &'static [&'static str]) -> Section {
    Section { name, about, keys }
}

/// All tables, in the order in which they are written. A key with underscores is the option with dashes.
pub(super) const SECTIONS: [Section; 6] = [
    section(
        "data",
        "Recordings: files or folders, relative to this file",
        &["traces", "labels", "where", "classes", "time", "rate_hz", "front_end"],
    ),
    section(
        "channels",
        "Channels: columns, or formulas of columns such as \"a-b\", \"speed_rpm rad/s\", \"integrate(speed_rpm) rad\"",
        &["y", "u1", "u2", "current", "velocity", "velocity_ref", "angle", "load", "park"],
    ),
    section("bearing", "Bearing: events per turn of its defects", &["bearing", "orders", "harmonics", "slip"]),
    section(
        "model",
        "Model and features",
        &[
            "order",
            "offset",
            "method",
            "nominal",
            "segment",
            "block_mean",
            "decimate",
            "memory",
            "handover",
            "huber",
            "saturation",
            "stuck",
            "velocity_from",
            "current_delay",
            "balance_cutoff_hz",
            "features",
            "covariates",
            "rising",
            "projection",
            "components",
            "variance",
            "discriminant",
            "shrinkage",
            "size_spread",
        ],
    ),
    section(
        "validation",
        "Which records train, which are of one run or unit, and negative controls",
        &["train_where", "test_where", "group", "unit", "by", "controls", "control_classes", "folds", "fold_seed"],
    ),
    section(
        "alarm",
        "Healthy class, rates and costs",
        &[
            "healthy",
            "novelty",
            "false_alarm",
            "reject_cost",
            "alarm_interval_h",
            "alarm_interval_segments",
            "segments_a_run",
            "other_drive",
            "priors",
            "cost",
        ],
    ),
];

/// Keys whose values are files, relative to the drive file.
pub(super) const FILES: [&str; 3] = ["traces", "labels", "front_end"];
/// Keys of which the values that `train` knows are not those of other commands.
pub(super) const OF_TRAINING: [&str; 1] = ["method"];

/// A key with its values as an option takes them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) value: Value,
    pub(super) line: usize,
}

/// The value of an option.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A text, or a number as text.
    One(String),
    /// A list of them.
    Many(Vec<String>),
    /// Whether an option without a value is given.
    Flag(bool),
}

/// The line of a place in a text.
fn line(text: &str, at: usize) -> usize {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|byte| **byte == b'\n').count()
}

/// Reads the entries of a drive file.
///
/// # Errors
/// A text that is no TOML, an unknown table or key, or a value of another kind.
pub(super) fn entries(path: &Path, text: &str) -> Result<Vec<Entry>, Error> {
    let wrong = |at: usize, problem: String| Error::content(path, format!("line {}", line(text, at)), problem);
    let file = DeTable::parse(text)
        .map_err(|error| wrong(error.span().map_or(0, |span| span.start), error.message().replace('\n', " ")))?;
    let mut entries = Vec::new();
    for (name, content) in file.get_ref() {
        let at = name.span().start;
        let names = SECTIONS.iter().map(|section| section.name);
        let DeValue::Table(keys) = content.get_ref() else {
            let place = section_of(name.get_ref()).map_or_else(
                || {
                    format!(
                        "there is no table {name}, nor such a key{}",
                        nearest(name.get_ref(), all_keys()),
                        name = name.get_ref()
                    )
                },
                |section| format!("{} belongs under [{}]", name.get_ref(), section.name),
            );
            return Err(wrong(at, place));
        };
        let Some(section) = SECTIONS.iter().find(|section| section.name == *name.get_ref()) else {
            return Err(wrong(at, format!("there is no table [{}]{}", name.get_ref(), nearest(name.get_ref(), names))));
        };
        for (key, value) in keys {
            let at = key.span().start;
            if !section.keys.contains(&key.get_ref().as_ref()) {
                let problem = match section_of(key.get_ref()) {
                    Some(other) => format!("{} belongs under [{}]", key.get_ref(), other.name),
                    None => format!("there is no key {}{}", key.get_ref(), nearest(key.get_ref(), all_keys())),
                };
                return Err(wrong(at, problem));
            }
            let value = value_of(value.get_ref())
                .ok_or_else(|| wrong(at, format!("{} takes a text, a number or a list of them", key.get_ref())))?;
            entries.push(Entry { key: key.get_ref().to_string(), value, line: line(text, at) });
        }
    }
    Ok(entries)
}

fn all_keys() -> impl Iterator<Item = &'static str> {
    SECTIONS.iter().flat_map(|section| section.keys.iter().copied())
}

pub(super) fn section_of(key: &str) -> Option<&'static Section> {
    SECTIONS.iter().find(|section| section.keys.contains(&key))
}

/// "; did you mean …", if a known word is near.
pub(super) fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> String {
    let near = known.map(|other| (strsim::jaro_winkler(word, other), other));
    match near.max_by(|one, other| one.0.total_cmp(&other.0)) {
        Some((likeness, other)) if likeness > 0.75 => format!("; did you mean {other}?"),
        _ => String::new(),
    }
}

fn plain(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Integer(number) => Some(number.to_string()),
        DeValue::Float(number) => Some(number.to_string()),
        _ => None,
    }
}

fn value_of(value: &DeValue<'_>) -> Option<Value> {
    Some(match value {
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Array(list) => {
            Value::Many(list.iter().map(|element| plain(element.get_ref())).collect::<Option<_>>()?)
        }
        DeValue::Table(table) => {
            let pair = |(key, value): (&toml::Spanned<_>, &toml::Spanned<DeValue<'_>>)| {
                let key: &std::borrow::Cow<'_, str> = key.get_ref();
                Some(format!("{key}={}", plain(value.get_ref())?))
            };
            Value::Many(table.iter().map(pair).collect::<Option<_>>()?)
        }
        other => Value::One(plain(other)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(text: &str) -> String {
        entries(Path::new("d.toml"), text).expect_err(text).to_string()
    }

    #[test]
    fn values_are_texts_numbers_lists_and_tables() {
        let text = "[data]\nrate_hz = 1919\ntraces = [\"a\", \"b\"]\n[model]\noffset = true\n\n[bearing]\norders = { outer = 3.58 }\n";
        let found = entries(Path::new("d.toml"), text).expect("a good file");
        let entry = |key: &str, value: Value, line: usize| Entry { key: key.into(), value, line };
        assert!(found.contains(&entry("rate_hz", Value::One("1919".into()), 2)), "{found:?}");
        assert!(found.contains(&entry("traces", Value::Many(vec!["a".into(), "b".into()]), 3)));
        assert!(found.contains(&entry("offset", Value::Flag(true), 5)));
        assert!(found.contains(&entry("orders", Value::Many(vec!["outer=3.58".into()]), 8)));
    }

    #[test]
    fn problems_name_line_key_and_the_nearest_one() {
        assert_eq!(problem("[data]\nratehz = 3\n"), "d.toml, line 2: there is no key ratehz; did you mean rate_hz?");
        assert_eq!(problem("\n[chanels]\n"), "d.toml, line 2: there is no table [chanels]; did you mean channels?");
        assert_eq!(problem("[data]\ny = \"i\"\n"), "d.toml, line 2: y belongs under [channels]");
        assert_eq!(problem("y = \"i\"\n"), "d.toml, line 1: y belongs under [channels]");
        assert!(problem("[data]\nlabels = 1979-05-27\n").contains("line 2: labels takes a text, a number or a list"));
        assert!(problem("[data]\nlabels = \n").starts_with("d.toml, line 2: "));
    }

    #[test]
    fn keys_are_in_one_table_each() {
        let mut keys: Vec<&str> = all_keys().collect();
        keys.sort_unstable();
        assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "{keys:?}");
    }
}
