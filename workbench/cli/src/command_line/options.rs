//! Options of the command line from structs: names, help, choices and defaults are those of their schema.
//!
//! ```text
//! Taken<J>   the settings that a job takes    words ─► Settings (and a drive file under them)
//! Own<T>     all fields of a struct           words ─► T
//! ```

use std::marker::PhantomData;
use std::sync::Arc;

use clap::builder::{PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser as _};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use model::Error;
use model::settings::{DriveFile, Problem, Settings, Use, from_value, keys, schema};

/// A command's job: the settings that it takes.
pub(crate) trait Job: Clone + std::fmt::Debug + Send + Sync + 'static {
    /// The settings.
    const USE: Use;
    /// Help of settings that mean something else here.
    const HELP: &'static [(&'static str, &'static str)] = &[];
}

/// The settings of a command: those of the command line, over those of a drive file.
#[derive(Clone, Debug)]
pub(crate) struct Taken<J> {
    /// The settings.
    pub(crate) settings: Settings,
    /// The text of the drive file, if one is given.
    pub(crate) drive: Option<String>,
    job: PhantomData<J>,
}

impl<J: Job> Taken<J> {
    /// These settings, without a drive file.
    pub(crate) const fn of(settings: Settings) -> Self {
        Self { settings, drive: None, job: PhantomData }
    }

    /// Puts the settings over those of a drive file, and returns an error if one is missing.
    pub(crate) fn join(&mut self, drive: Option<&DriveFile>) -> Result<(), Error> {
        if let Some(drive) = drive {
            let own = std::mem::take(&mut self.settings);
            self.settings = own.over(drive.settings.clone());
            self.drive = Some(drive.text.clone());
        }
        J::USE.require(&self.settings)
    }

    /// The text of a drive file at this path with the settings that the command takes.
    pub(crate) fn text(&self, path: &std::path::Path) -> Result<String, Error> {
        self.settings.text(path, &J::USE)
    }

    /// Adds the drive file to a page.
    pub(crate) fn on_page(&self, page: String) -> String {
        let Some(text) = &self.drive else { return page };
        let text = pages::escape::escape(text);
        let section = format!("<section><h2>Drive file</h2><pre>{text}</pre></section>\n</main>");
        page.replacen("</main>", &section, 1)
    }
}

impl<J: Job> Args for Taken<J> {
    fn augment_args(command: Command) -> Command {
        let taken = keys().filter(|(_, key)| J::USE.takes(key));
        taken.fold(command, |command, (section, key)| {
            let field = schema::of_field(key).unwrap_or(&Value::Null);
            let arg = argument(key, field).required(J::USE.required.contains(&key));
            let arg = arg.value_parser(Checked::of(field, move |text| {
                let one = Settings::of(key, text.into()).unwrap_or(Ok(Settings::default()));
                one.map(|_| ()).map_err(|refused| refused.problem)
            }));
            let own = J::HELP.iter().find(|(own, _)| *own == key);
            let arg = if let Some((_, help)) = own { arg.help(*help) } else { arg };
            command.arg(arg.help_heading(format!("{} ([{}] of drive.toml)", heading(section.name), section.name)))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<J: Job> FromArgMatches for Taken<J> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut settings = Settings::default();
        for (_, key) in keys().filter(|(_, key)| J::USE.takes(key)) {
            let field = schema::of_field(key).unwrap_or(&Value::Null);
            if let Some(value) = given(matches, key, field) {
                settings.set(key, value).map_err(|refused| wrong(ErrorKind::ValueValidation, &refused.to_string()))?;
            }
        }
        settings.refuse_rivals().map_err(|problem| wrong(ErrorKind::ArgumentConflict, &problem.to_string()))?;
        Ok(Self::of(settings))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Options that are all fields of a struct.
#[derive(Clone, Debug)]
pub(crate) struct Own<T>(pub(crate) T);

impl<T: JsonSchema + DeserializeOwned> Args for Own<T> {
    fn augment_args(command: Command) -> Command {
        let schema = schema::of::<T>();
        let required = |key: &str| schema["required"].as_array().is_some_and(|all| all.iter().any(|own| own == key));
        let fields = schema["properties"].as_object().into_iter().flatten();
        fields.fold(command, |command, (key, field)| {
            let kind = field["type"].clone();
            let number = move |text: &str| match kind.as_str() {
                Some("integer") => from_value::<u64>(text.into()).map(|_| ()),
                Some("number") => from_value::<f64>(text.into()).map(|_| ()),
                _ => Ok(()),
            };
            command.arg(argument(key, field).required(required(key)).value_parser(Checked::of(field, number)))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<T: JsonSchema + DeserializeOwned> FromArgMatches for Own<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let schema = schema::of::<T>();
        let fields = schema["properties"].as_object().into_iter().flatten();
        let words: Map<String, Value> =
            fields.filter_map(|(key, field)| Some((key.clone(), given(matches, key, field)?))).collect();
        let own = from_value(Value::Object(words)).map_err(|problem| {
            let text = match problem {
                Problem::Field(key, inner) => format!("--{}: {inner}", key.replace('_', "-")),
                other => other.to_string(),
            };
            wrong(ErrorKind::ValueValidation, &text)
        })?;
        Ok(Self(own))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn wrong(kind: ErrorKind, text: &str) -> clap::Error {
    clap::Error::raw(kind, format!("{text}\n"))
}

/// The heading of the options of a section.
fn heading(section: &str) -> String {
    if section == "data" {
        return "Recordings".into();
    }
    let (first, rest) = section.split_at(1.min(section.len()));
    first.to_uppercase() + rest
}

/// Whether a field is of this kind.
fn is(field: &Value, kind: &str) -> bool {
    match &field["type"] {
        Value::Array(kinds) => kinds.first().is_some_and(|own| own == kind),
        own => own == kind,
    }
}

/// The choices of a field, or of the elements of a list.
fn choices(field: &Value) -> Option<Vec<PossibleValue>> {
    let all = field["oneOf"].as_array().or_else(|| field["items"]["oneOf"].as_array())?;
    let one = |own: &Value| {
        let choice = PossibleValue::new(own["const"].as_str()?.to_string());
        Some(match own["description"].as_str() {
            Some(about) => choice.help(about.to_string()),
            None => choice,
        })
    };
    all.iter().map(one).collect()
}

/// The option of a field, without its parser.
fn argument(key: &str, field: &Value) -> Arg {
    let arg = Arg::new(key.to_string()).help(field["description"].as_str().unwrap_or_default().to_string());
    let arg = if field["x-positional"] == true { arg } else { arg.long(key.replace('_', "-")) };
    if is(field, "boolean") {
        return arg.action(ArgAction::SetTrue);
    }
    let arg = if field["x-file"] == true { arg.value_hint(clap::ValueHint::AnyPath) } else { arg };
    let name = field["x-value"].as_str().map_or_else(|| key.to_uppercase(), String::from);
    let arg = arg.value_name(name).action(if is(field, "array") { ArgAction::Append } else { ArgAction::Set });
    let arg = if is(field, "array") && choices(field).is_some() { arg.value_delimiter(',') } else { arg };
    let arg = if is(field, "number") { arg.allow_negative_numbers(true) } else { arg };
    let arg = if field["x-positional"] == true { arg.num_args(1..) } else { arg };
    // For the help alone: what is not given is not set.
    match &field["default"] {
        Value::String(word) => arg.default_value(word.clone()),
        Value::Number(number) => {
            let whole = number.as_f64().filter(|x| x.fract() == 0.0).map(|x| format!("{x:.0}"));
            arg.default_value(whole.unwrap_or_else(|| number.to_string()))
        }
        _ => arg,
    }
}

/// The words of a field on the command line.
fn given(matches: &ArgMatches, key: &str, field: &Value) -> Option<Value> {
    if matches.value_source(key) != Some(ValueSource::CommandLine) {
        return None;
    }
    if is(field, "boolean") {
        return matches.get_flag(key).then_some(Value::Bool(true));
    }
    // One word of a list is a text that may have commas.
    let mut words: Vec<Value> = matches.get_many::<String>(key)?.map(|word| Value::from(word.as_str())).collect();
    if words.len() > 1 { Some(Value::Array(words)) } else { words.pop() }
}

/// Why a word does not fit, if it does not.
type Check = Arc<dyn Fn(&str) -> Result<(), Problem> + Send + Sync>;

/// Parses a word as text, and checks it.
#[derive(Clone)]
struct Checked(Check);

impl Checked {
    /// The parser of a field: one of its choices, or what fits; a flag has none.
    fn of(
        field: &Value,
        check: impl Fn(&str) -> Result<(), Problem> + Send + Sync + 'static,
    ) -> clap::builder::ValueParser {
        if is(field, "boolean") {
            return clap::value_parser!(bool);
        }
        match choices(field) {
            Some(choices) => PossibleValuesParser::new(choices).into(),
            None => Self(Arc::new(check)).parser(),
        }
    }

    fn parser(self) -> clap::builder::ValueParser {
        StringValueParser::new()
            .try_map(move |text| match (self.0)(&text) {
                Ok(()) => Ok(text),
                Err(problem) => Err(problem),
            })
            .into()
    }
}
