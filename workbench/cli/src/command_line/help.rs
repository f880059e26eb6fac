//! The layout of the help: options below headings, and a short help with the options that matter most; and
//! `bearing-watch completions`, what shells show of the commands.
//!
//! `-h` fits a screen: of commands with many options it has those of [`SHORT`], each in one line, and one example;
//! `--help` has all options with their whole texts.

use std::io::Write as _;

use clap::{Arg, ArgAction, Command};
use clap_complete::Shell;

use model::Error;

/// Longest text of an option in the short help.
const LINE: usize = 64;

/// Longest text of a command in the list of commands.
const ABOUT: usize = 76;

/// The heading of options without another one.
const OTHERS: &str = "Options";

/// Options in the short help of the commands that have many; required ones are always there.
const SHORT: &[(&str, &[&str])] = &[
    ("train", &["u2", "angle", "bearing", "features", "healthy", "false_alarm", "rust", "c", "report", "json"]),
    ("features", &["u2", "angle", "bearing", "healthy", "json"]),
    ("train-features", &["features", "healthy", "false_alarm", "unit", "rust", "c", "json"]),
    ("evaluate", &["where", "group", "test_where", "per_segment", "out", "report", "json"]),
    ("simulate", &["rig", "count", "seed", "severity"]),
    ("identify", &["u2", "offset", "method", "out", "json"]),
    ("structure", &["u2", "offset", "method", "report", "json"]),
    ("validate", &["u2", "offset", "method", "lags", "report", "json"]),
    ("audit", &["labels", "where", "rate_hz", "current", "velocity", "angle", "load", "report", "json"]),
];

/// Options of every command that only `--help` has.
const RARE: &[&str] = &["save", "no_drive", "verbose"];

/// The headings of options that are no settings.
const HEADINGS: &[(&str, &[&str])] = &[
    ("Output", &["out", "report", "json", "rust", "c", "rows", "rank", "format", "view"]),
    ("Channels", &["reference", "voltage", "position", "force", "force_gain", "interval", "columns", "further"]),
    ("Alarm", &["run_a_trace"]),
    (
        "Estimation",
        &[
            "method",
            "passes",
            "noise_order",
            "instruments",
            "robust",
            "max",
            "min",
            "compare",
            "params",
            "params_of",
            "lags",
            "kt",
            "cutoff",
            "asymmetric",
            "rotary",
        ],
    ),
];

/// The program with the help of its commands.
pub(crate) fn of_program(command: Command) -> Command {
    // The version as one of the other options: by itself it has a heading of its own. Not in the short help, which with
    // all commands is as long as a screen.
    let version = Arg::new("version").short('V').long("version").action(ArgAction::Version).help("Print version");
    arranged(command.disable_version_flag(true).arg(version)).mut_arg("version", |own| own.hide_short_help(true))
}

fn arranged(command: Command) -> Command {
    let name = command.get_name().to_string();
    let short = SHORT.iter().find(|(own, _)| *own == name).map(|(_, ids)| *ids);
    let about = command.get_about().map(ToString::to_string).unwrap_or_default();
    let whole = command.get_long_about().map_or_else(|| about.clone(), ToString::to_string);
    let command = command.about(one_line(&about, ABOUT)).long_about(whole);
    let command = command.mut_args(|arg| option(arg, &name, short)).mut_subcommands(arranged);
    let Some(full) = command.get_after_help().map(ToString::to_string) else { return command };
    match example(&full) {
        Some(first) if first != full => command.after_help(first).after_long_help(full),
        _ => command,
    }
}

fn option(arg: Arg, command: &str, short: Option<&[&str]>) -> Arg {
    let id = arg.get_id().to_string();
    let heading = match arg.get_help_heading() {
        Some(own) => own.to_string(),
        None if id == "model" => if command.starts_with("train") { "Output" } else { "Model" }.to_string(),
        None if arg.is_positional() => "Recordings".to_string(),
        None => {
            HEADINGS.iter().find(|(_, ids)| ids.contains(&id.as_str())).map_or(OTHERS, |(name, _)| name).to_string()
        }
    };
    let is_short = arg.is_required_set() || arg.is_positional() || short.is_none_or(|ids| ids.contains(&id.as_str()));
    let hidden = RARE.contains(&id.as_str()) || !(is_short || arg.is_global_set());
    let text = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let arg = arg.help_heading(heading).hide_short_help(hidden);
    match one_line(&text, LINE) {
        line if line == text => arg,
        line => arg.help(line).long_help(text),
    }
}

/// The start of a text with at most so many characters, of whole clauses if possible.
fn one_line(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.into();
    }
    let fits = |part: &&str| part.chars().count() <= most && part.chars().count() > 8;
    let sentence = text.match_indices(". ").map(|(at, _)| &text[..at]).find(|part| !part.ends_with("e.g"));
    let clause = ["; ", ": ", " ("].iter().filter_map(|end| text.split_once(end)).map(|(part, _)| part);
    if let Some(part) = sentence.into_iter().chain(clause).find(fits) {
        return part.into();
    }
    let at = text.match_indices(' ').map(|(at, _)| at).take_while(|at| text[..*at].chars().count() < most).last();
    format!("{} …", text[..at.unwrap_or(text.len())].trim_end_matches(','))
}

/// The first example of the text behind the options.
fn example(text: &str) -> Option<String> {
    let from = text.find("Example")?;
    let (heading, rest) = text[from..].split_once('\n')?;
    Some(format!("{}\n{}", heading.replace("Examples", "Example"), rest.lines().next()?))
}

/// The name of the program.
const PROGRAM: &str = "bearing-watch";

/// Print completions of commands and options for a shell
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch completions bash > ~/.local/share/bash-completion/completions/bearing-watch"
)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

pub(crate) fn completions(args: &CompletionsArgs, mut commands: Command) -> Result<(), Error> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut commands, PROGRAM, &mut text);
    // In the script for bash, clap_complete 4.6 has two spellings of a program's name with a hyphen.
    let text = String::from_utf8_lossy(&text).replace("bearing__subcmd__watch", "bearing__watch");
    match std::io::stdout().write_all(text.as_bytes()) {
        // A closed pipe is not an error.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output")(error)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_with_a_clause() {
        let one_line = |text| one_line(text, 64);
        assert_eq!(one_line("Print JSON"), "Print JSON");
        let rate = "Rate of healthy segments called novel; 0.01 if not given. With a group it is that of the next run";
        assert_eq!(one_line(rate), "Rate of healthy segments called novel; 0.01 if not given");
        let bearing = "Balls, ball and pitch diameter, e.g. 9,3,17,10: tracks outer, inner, ball and cage of all";
        assert_eq!(one_line(bearing), "Balls, ball and pitch diameter, e.g. 9,3,17,10");
        let names = "alpha, beta, gamma, delta, epsilon, zeta, eta, theta, iota, kappa, lambda, mu, nu, xi, omicron";
        assert!(one_line(names).ends_with("theta, iota …"), "{}", one_line(names));
    }

    #[test]
    fn the_first_example_is_short() {
        let text = "Ends with 1.\n\nExamples:\n  a b\n  c d\n\nMore.";
        assert_eq!(example(text).as_deref(), Some("Example:\n  a b"));
        assert_eq!(example("No such thing"), None);
    }

    #[test]
    fn the_lists_name_options_that_exist() {
        let commands = <crate::Cli as clap::CommandFactory>::command();
        for (name, ids) in SHORT {
            let command = commands.find_subcommand(name).unwrap_or_else(|| panic!("no command {name}"));
            for id in *ids {
                assert!(command.get_arguments().any(|arg| arg.get_id() == *id), "{name} has no {id}");
            }
        }
    }
}
