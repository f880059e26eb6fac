//! `drive.toml`: what a drive is, said once.
//!
//! ```text
//! [data]      traces = ["runs"]  labels = "labels.csv"       files, relative to this one
//! [channels]  y = "iq_A"  u1 = "speed_ref_rpm-speed_rpm"
//! [model]     order = [2, 2, 0, 1, 1]
//! ```
//!
//! It is read, and written from settings.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};
use toml::de::{DeTable, DeValue};

use super::fields::{keys, section_of, sections};
use super::written_values::Problem;
use crate::Error;
use crate::near::did_you_mean;
use crate::settings::sections::data::Data;
use crate::settings::sections::settings::Settings;
use crate::settings::uses::Use;

/// A drive file.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveFile {
    /// Its settings.
    pub settings: Settings,
    /// Its text.
    pub text: String,
}

impl DriveFile {
    /// Reads a drive file.
    ///
    /// # Errors
    /// An unreadable file, and the errors of [`DriveFile::of`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::of(path, std::fs::read_to_string(path).map_err(Error::io(path))?)
    }

    /// Takes the text of a drive file at this path, to which its files are relative.
    ///
    /// # Errors
    /// A text that is no TOML, an unknown table or key, a value that does not fit, or settings that exclude each other.
    pub fn of(path: &Path, text: String) -> Result<Self, Error> {
        let mut settings = parse(path, &text)?;
        settings.refuse_rivals().map_err(|problem| Error::content(path, "content", problem.to_string()))?;
        settings.data.place_in(path.parent().unwrap_or(Path::new("")));
        Ok(Self { settings, text })
    }
}

impl Data {
    /// Makes relative files those of a folder.
    fn place_in(&mut self, folder: &Path) {
        let Self { traces, labels, front_end, .. } = self;
        let files: Vec<&mut PathBuf> = traces.iter_mut().chain(labels).chain(front_end).collect();
        files.into_iter().for_each(|file| *file = folder.join(&file));
    }
}

/// The line of a place in a text.
fn line(text: &str, at: usize) -> usize {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|byte| **byte == b'\n').count()
}

fn parse(path: &Path, text: &str) -> Result<Settings, Error> {
    let wrong = |at: usize, problem: String| Error::content(path, format!("line {}", line(text, at)), problem);
    let file = DeTable::parse(text)
        .map_err(|error| wrong(error.span().map_or(0, |span| span.start), error.message().replace('\n', " ")))?;
    let mut settings = Settings::default();
    for (name, content) in file.get_ref() {
        let (at, name) = (name.span().start, name.get_ref().as_ref());
        let DeValue::Table(content) = content.get_ref() else { return Err(wrong(at, misplaced(name))) };
        let Some(section) = sections().iter().find(|section| section.name == name) else {
            let near = did_you_mean(name, sections().iter().map(|section| section.name));
            return Err(wrong(at, format!("there is no table [{name}]{near}")));
        };
        for (key, value) in content {
            let (at, key) = (key.span().start, key.get_ref().as_ref());
            if !section.keys.contains(&key) {
                let other = section_of(key).map(|other| format!("{key} belongs under [{}]", other.name));
                return Err(wrong(at, other.unwrap_or_else(|| format!("there is no key {key}{}", nearest_key(key)))));
            }
            let kinds = || wrong(at, format!("{key} takes a text, a number or a list of them"));
            let value = value_of(value.get_ref()).ok_or_else(kinds)?;
            settings.set(key, value).map_err(|refused| match refused.problem {
                Problem::Kind("takes a text or a number" | "takes a number") => kinds(),
                _ => wrong(at, refused.to_string()),
            })?;
        }
    }
    Ok(settings)
}

/// "; did you mean …", if a key is near.
fn nearest_key(word: &str) -> String {
    did_you_mean(word, keys().map(|(_, key)| key))
}

/// What to say of a key outside of any table.
fn misplaced(key: &str) -> String {
    match section_of(key) {
        Some(section) => format!("{key} belongs under [{}]", section.name),
        None => format!("there is no table {key}, nor such a key{}", nearest_key(key)),
    }
}

/// A value of a drive file as the faces share it; `None` of a date.
fn value_of(value: &DeValue<'_>) -> Option<Value> {
    Some(match value {
        DeValue::Boolean(flag) => Value::Bool(*flag),
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(number) => {
            number.to_string().parse::<i64>().map_or_else(|_| number.to_string().into(), Value::from)
        }
        DeValue::Float(number) => Value::String(number.to_string()),
        DeValue::Array(list) => list.iter().map(|own| value_of(own.get_ref())).collect::<Option<Vec<_>>>()?.into(),
        DeValue::Table(table) => {
            let own = |(key, value): (&toml::Spanned<_>, &toml::Spanned<DeValue<'_>>)| {
                let key: &std::borrow::Cow<'_, str> = key.get_ref();
                Some((key.to_string(), value_of(value.get_ref())?))
            };
            Value::Object(table.iter().map(own).collect::<Option<Map<_, _>>>()?)
        }
        DeValue::Datetime(_) => return None,
    })
}

impl Settings {
    /// The text of a drive file at this path: each table of which the job takes something, with what it is for.
    ///
    /// # Errors
    /// A number that TOML does not have.
    pub fn text(&self, path: &Path, job: &Use) -> Result<String, Error> {
        let mut own = self.clone();
        let data = &mut own.data;
        let files = data.traces.iter_mut().chain(&mut data.labels).chain(&mut data.front_end);
        files.for_each(|file| *file = from_here(path, file));
        let all = toml::Table::try_from(own).map_err(|problem| Error::content(path, "content", problem.to_string()))?;
        let mut text = String::new();
        for section in sections() {
            let values = all.get(section.name).and_then(toml::Value::as_table);
            let keys = section.keys.iter().filter(|key| job.takes(key));
            let given = keys.filter_map(|key| Some((key, values?.get(*key)?)));
            let lines: String = given.map(|(key, value)| format!("{key} = {value}\n")).collect();
            if !lines.is_empty() {
                let gap = if text.is_empty() { "" } else { "\n" };
                let _never_fails = write!(text, "{gap}# {}\n[{}]\n{lines}", section.about, section.name);
            }
        }
        Ok(text)
    }
}

/// A file as it is from the folder of the drive file.
#[must_use]
pub fn from_here(path: &Path, file: &Path) -> PathBuf {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (own, file) = (whole(path), whole(file));
    let folder = own.parent().unwrap_or(Path::new("/"));
    match file.strip_prefix(folder) {
        Ok(inside) if inside.as_os_str().is_empty() => PathBuf::from("."),
        Ok(inside) => inside.to_path_buf(),
        Err(_) => file,
    }
}

/// A text in quotes, as a drive file has it.
#[must_use]
pub fn literal(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<DriveFile, Error> {
        DriveFile::of(Path::new("folder/d.toml"), text.into())
    }

    fn problem(text: &str) -> String {
        DriveFile::of(Path::new("d.toml"), text.into()).expect_err(text).to_string()
    }

    #[test]
    fn values_are_texts_numbers_lists_and_tables() {
        let text = "[data]\nrate_hz = 1919\ntraces = [\"a\", \"/b\"]\n[model]\noffset = true\nfeatures = \"a, b\"\n\
                    order = [2, 1, 0, 1, 1]\n[bearing]\norders = { outer = 3.58 }\nslip = \"1e-3\"\n";
        let Settings { data, model, bearing, .. } = of(text).expect("a good file").settings;
        assert_eq!(data.rate_hz, Some(1919.0));
        assert_eq!(data.traces, [PathBuf::from("folder/a"), PathBuf::from("/b")]);
        assert!(model.offset && model.features == ["a", "b"]);
        assert_eq!(model.order.map(|order| order.0.terms()), Some(3));
        assert_eq!((bearing.orders, bearing.slip), (vec!["outer=3.58".to_string()], Some(1e-3)));
    }

    #[test]
    fn problems_name_line_key_and_the_nearest_one() {
        assert_eq!(problem("[data]\nratehz = 3\n"), "d.toml, line 2: there is no key ratehz; did you mean rate_hz?");
        assert_eq!(problem("\n[chanels]\n"), "d.toml, line 2: there is no table [chanels]; did you mean channels?");
        assert_eq!(problem("[data]\ny = \"i\"\n"), "d.toml, line 2: y belongs under [channels]");
        assert_eq!(problem("y = \"i\"\n"), "d.toml, line 1: y belongs under [channels]");
        assert_eq!(
            problem("rat_hz = 1\n"),
            "d.toml, line 1: there is no table rat_hz, nor such a key; did you mean rate_hz?"
        );
        assert!(problem("[data]\nlabels = 1979-05-27\n").contains("line 2: labels takes a text, a number or a list"));
        assert!(problem("[data]\nlabels = \n").starts_with("d.toml, line 2: "));
        assert_eq!(problem("[model]\noffset = 3\n"), "d.toml, line 2: offset is true or false");
        let found = problem("[model]\n\nmemory = \"x\"\n");
        assert_eq!(found, "d.toml, line 3: invalid value 'x' for memory: invalid float literal");
        assert!(problem("[model]\nshrinkage = [0, 1]\ndiscriminant = \"linear\"\n").contains("cannot be used with"));
    }
}
