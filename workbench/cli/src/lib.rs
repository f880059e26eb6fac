//! The command line: `bearing-watch COMMAND`.

mod args;
mod audit;
pub mod call;
mod campaign;
mod convert;
mod demo;
mod description;
mod drive;
mod evaluate;
mod evidence;
mod features;
mod features_sum;
mod grey_box;
mod identify;
mod listen;
mod model_file;
mod output;
mod piecewise;
mod replay;
mod serve;
mod simulate;
mod simulate_features;
mod simulated_fleet;
mod structure;
mod tables;
mod train;
mod train_features;
mod training;
mod validate;
mod view;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use model::Error;

/// Bearing-fault detection for motor drives: simulate, identify, train, evaluate, and export to firmware.
#[derive(Debug, Parser)]
#[command(name = "bearing-watch", version, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Also write the settings of this command as a drive file, which takes their place next time
    #[arg(long, global = true, value_name = "DRIVE_TOML")]
    save: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Args),
    Init(drive::init::Args),
    Audit(audit::Args),
    Simulate(simulate::Args),
    Identify(identify::Args),
    Structure(structure::Args),
    GreyBox(grey_box::Args),
    Validate(validate::Args),
    Piecewise(piecewise::Args),
    Train(Box<train::Args>),
    Features(Box<features::Args>),
    FeaturesSum(features_sum::Args),
    TrainFeatures(Box<train_features::Args>),
    #[command(hide = true)]
    SimulateFeatures(simulate_features::Args),
    Evaluate(evaluate::Args),
    Replay(replay::Args),
    View(view::Args),
    Listen(listen::Args),
    Convert(convert::ConvertArgs),
    Resample(convert::ResampleArgs),
    Campaign(campaign::Args),
    Tables(tables::Args),
}

/// Runs the command line of this process. Returns 0 on success; on bad input it prints one line with the problem and
/// its place, and returns 2.
#[must_use]
pub fn run() -> ExitCode {
    let mut commands = Cli::command();
    commands.build();
    let given = match drive::arguments(&commands, std::env::args_os().collect()) {
        Ok(given) => given,
        Err(error) => return refuse(&error),
    };
    let parsed = commands.try_get_matches_from_mut(given);
    let parsed = parsed.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)));
    let (Cli { command, save }, matches) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return usage(&error),
    };
    if let Some(Err(error)) = save.map(|path| drive::save(&path, &commands, &matches)) {
        return refuse(&error);
    }
    let outcome = match command {
        Command::Demo(args) => demo::run(&args),
        Command::Init(args) => drive::init::run(&args),
        Command::Audit(args) => match audit::run(&args) {
            Ok(true) => return ExitCode::FAILURE,
            other => other.map(|_| ()),
        },
        Command::Simulate(args) => simulate::run(&args),
        Command::Identify(args) => identify::run(&args),
        Command::Structure(args) => structure::run(&args),
        Command::GreyBox(args) => grey_box::run(&args),
        Command::Validate(args) => validate::run(&args),
        Command::Piecewise(args) => piecewise::run(&args),
        Command::Train(args) => train::run(&args),
        Command::Features(args) => features::run(&args),
        Command::FeaturesSum(args) => features_sum::run(&args),
        Command::TrainFeatures(args) => train_features::run(&args),
        Command::SimulateFeatures(args) => simulate_features::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::View(args) => view::run(&args),
        Command::Listen(args) => listen::run(&args),
        Command::Convert(args) => convert::convert(&args),
        Command::Resample(args) => convert::resample(&args),
        Command::Campaign(args) => campaign::run(&args),
        Command::Tables(args) => tables::run(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => refuse(&error),
    }
}

fn refuse(error: &Error) -> ExitCode {
    eprintln!("error: {}", error.to_string().replace('\n', " "));
    ExitCode::from(2)
}

/// Prints help and version unchanged, and an error in the arguments as one line.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    eprintln!("{} (more by --help)", usage_line(error));
    ExitCode::from(2)
}

/// An error in the arguments as one line.
fn usage_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let said = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let said: Vec<&str> = said.filter(|line| !line.is_empty()).collect();
    // If the command is missing, clap returns the whole help instead of an error.
    if text.starts_with("error:") { said.join(" ") } else { "error: a command is missing".into() }
}
