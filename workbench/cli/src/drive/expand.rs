//! Entries of a drive file ↔ arguments of a command.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::Path;

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};

use super::schema::{Entry, FILES, OF_TRAINING, SECTIONS, Value, nearest};
use model::Error;

/// The place of a drive file: right after the command and its subcommand.
pub(super) fn place(command: &Command, arguments: &[OsString]) -> Option<usize> {
    let (mut own, mut at) = (command, 1);
    while let Some(next) = arguments.get(at).and_then(|word| own.find_subcommand(word)) {
        (own, at) = (next, at + 1);
    }
    let is_file = |word: &&OsString| Path::new(word).extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    arguments.get(at).filter(is_file).filter(|_| at > 1 && own.get_name() != "init").map(|_| at)
}

/// The matches of the innermost subcommand.
fn leaf<'a>(command: &'a Command, matches: &'a ArgMatches) -> (&'a Command, &'a ArgMatches) {
    match matches.subcommand().and_then(|(name, inner)| Some((command.find_subcommand(name)?, inner))) {
        Some((inner, matches)) => leaf(inner, matches),
        None => (command, matches),
    }
}

fn argument<'a>(command: &'a Command, key: &str) -> Option<&'a Arg> {
    let name = key.replace('_', "-");
    let is_positional = |arg: &&Arg| arg.is_positional() && arg.get_id() == key;
    command.get_arguments().find(|arg| arg.get_long() == Some(name.as_str()) || is_positional(arg))
}

/// Adds the entries that the command takes and the arguments do not have.
pub(super) fn with_entries(
    command: &Command,
    arguments: Vec<OsString>,
    path: &Path,
    entries: &[Entry],
) -> Result<Vec<OsString>, Error> {
    let lenient = command.clone().ignore_errors(true).try_get_matches_from(&arguments);
    let matches = lenient.map_err(|error| Error::Usage(error.to_string()))?;
    let (own, given) = leaf(command, &matches);
    let mut arguments = arguments;
    let mut positional = Vec::new();
    for Entry { key, value, line } in entries {
        if OF_TRAINING.contains(&key.as_str()) && own.get_name() != "train" {
            continue;
        }
        let Some(arg) = argument(own, key) else { continue };
        let is_given = |arg: &Arg| given.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
        let rival = own.get_arg_conflicts_with(arg).into_iter().any(is_given);
        if is_given(arg) || rival {
            continue;
        }
        let words = words(arg, key, value, &|value| beside(path, key, value));
        let place = || format!("line {line}");
        let words = words.map_err(|problem| Error::content(path, place(), format!("{key} {problem}")))?;
        if arg.is_positional() { &mut positional } else { &mut arguments }.extend(words);
    }
    if !positional.is_empty() {
        arguments.push("--".into());
        arguments.extend(positional);
    }
    Ok(arguments)
}

/// The words of an option, or those of a positional argument.
fn words(arg: &Arg, key: &str, value: &Value, each: &dyn Fn(&str) -> String) -> Result<Vec<OsString>, &'static str> {
    let name = key.replace('_', "-");
    let is_flag = matches!(arg.get_action(), ArgAction::SetTrue);
    let values = match value {
        Value::Flag(flag) if is_flag => return Ok(flag.then(|| format!("--{name}").into()).into_iter().collect()),
        Value::Flag(_) => return Err("takes no true or false"),
        _ if is_flag => return Err("is true or false"),
        Value::One(one) => std::slice::from_ref(one),
        Value::Many(many) => many,
    };
    let values: Vec<String> = values.iter().map(|value| each(value)).collect();
    if arg.is_positional() {
        return Ok(values.into_iter().map(OsString::from).collect());
    }
    let repeated = matches!(arg.get_action(), ArgAction::Append) && arg.get_value_delimiter().is_none();
    let words = if repeated { values } else { vec![values.join(",")] };
    Ok(words.into_iter().map(|word| OsString::from(format!("--{name}={word}"))).collect())
}

/// The arguments of a command with these options.
pub(super) fn of_options(command: &Command, options: &[(String, Value)]) -> Result<Vec<OsString>, Error> {
    // Before the options, since those of a drive file follow.
    let (mut arguments, mut positional) = (Vec::new(), vec![OsString::from(command.get_name())]);
    for (key, value) in options {
        let Some(arg) = argument(command, key) else {
            let known: Vec<String> = command.get_arguments().map(key_of).collect();
            let near = nearest(key, known.iter().map(String::as_str));
            return Err(Error::Usage(format!("{} has no option {key}{near}", command.get_name())));
        };
        let is_file = arg.is_positional();
        let each = |value: &str| if is_file && value.starts_with('-') { format!("./{value}") } else { value.into() };
        let words = words(arg, key, value, &each);
        let words = words.map_err(|problem| Error::Usage(format!("{key} {problem}")))?;
        if is_file { &mut positional } else { &mut arguments }.extend(words);
    }
    positional.extend(arguments);
    Ok(positional)
}

fn key_of(arg: &Arg) -> String {
    arg.get_long().unwrap_or(arg.get_id().as_str()).replace('-', "_")
}

/// A file is relative to the drive file.
fn beside(path: &Path, key: &str, value: &str) -> String {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        Some(folder) if FILES.contains(&key) => folder.join(value).to_string_lossy().into_owned(),
        _ => value.to_string(),
    }
}

/// The options of a command line as a drive file at this path.
pub(super) fn text(path: &Path, command: &Command, matches: &ArgMatches) -> String {
    let (own, matches) = leaf(command, matches);
    let mut text = String::new();
    for section in &SECTIONS {
        let mut lines = String::new();
        for key in section.keys {
            let Some(arg) = argument(own, key) else { continue };
            let id = arg.get_id().as_str();
            if matches.value_source(id) != Some(ValueSource::CommandLine)
                || (OF_TRAINING.contains(key) && own.get_name() != "train")
            {
                continue;
            }
            if matches!(arg.get_action(), ArgAction::SetTrue) {
                let _never_fails = writeln!(lines, "{key} = true");
                continue;
            }
            let raw = matches.get_raw(id).into_iter().flatten();
            let values: Vec<String> = raw.map(|value| from_here(path, key, &value.to_string_lossy())).collect();
            let several = matches!(arg.get_action(), ArgAction::Append) || values.len() > 1;
            let list = || format!("[{}]", values.iter().map(|v| literal(v)).collect::<Vec<_>>().join(", "));
            let value = if several { list() } else { literal(values.first().map_or("", String::as_str)) };
            let _never_fails = writeln!(lines, "{key} = {value}");
        }
        if !lines.is_empty() {
            let gap = if text.is_empty() { "" } else { "\n" };
            let _never_fails = write!(text, "{gap}# {}\n[{}]\n{lines}", section.about, section.name);
        }
    }
    text
}

/// A file as it is from the folder of the drive file.
pub(super) fn from_here(path: &Path, key: &str, value: &str) -> String {
    if !FILES.contains(&key) {
        return value.to_string();
    }
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (own, value) = (whole(path), whole(Path::new(value)));
    let folder = own.parent().unwrap_or(Path::new("/"));
    let inside = value
        .strip_prefix(folder)
        .ok()
        .map(|inside| if inside.as_os_str().is_empty() { Path::new(".") } else { inside });
    inside.unwrap_or(&value).to_string_lossy().into_owned()
}

/// A number, or a text in quotes.
pub(super) fn literal(value: &str) -> String {
    let is_number =
        value.parse::<i64>().is_ok() || (value.parse::<f64>().is_ok_and(f64::is_finite) && value.contains('.'));
    if is_number
        && !value.starts_with(['+', '.'])
        && !value.ends_with('.')
        && !value.starts_with('0') | value.starts_with("0.") | (value == "0")
    {
        value.to_string()
    } else {
        toml::Value::String(value.to_string()).to_string()
    }
}
