//! The commands, each with what it takes.

use std::path::Path;
use std::process::ExitCode;

use clap::Subcommand;

use crate::drive::{dbc, demo, listen, replay, signing};
use crate::identification::{grey_box, identify, structure, validate};
use crate::recordings::{audit, convert, init, simulate};
use crate::training::{confirm, evaluate, fleet, train};
use crate::{schema, view};

use crate::command_line::help;
use crate::command_line::options::{Job, Taken};
use model::Error;
use model::settings::DriveFile;

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Init(Box<init::Args>),
    Audit(Box<audit::Args>),
    Simulate(simulate::Args),
    Identify(Box<identify::Args>),
    Structure(Box<structure::Args>),
    GreyBox(Box<grey_box::Args>),
    Validate(Box<validate::Args>),
    Train(Box<train::Args>),
    Features(Box<fleet::FeaturesArgs>),
    TrainFeatures(Box<fleet::TrainArgs>),
    Evaluate(Box<evaluate::Args>),
    Replay(Box<replay::Args>),
    Confirm(confirm::Args),
    View(view::Args),
    Listen(listen::Args),
    DemoDrive(demo::Args),
    Dbc(dbc::Args),
    Convert(Box<convert::Args>),
    Sign(signing::Args),
    Schema(schema::Args),
    Completions(help::CompletionsArgs),
}

/// The settings that a command takes.
trait Settled {
    /// Puts them over those of a drive file, and returns an error if one is missing.
    fn join(&mut self, drive: Option<&DriveFile>) -> Result<(), Error>;

    /// The text of a drive file at this path with them.
    fn text(&self, path: &Path) -> Result<String, Error>;
}

impl<J: Job> Settled for Taken<J> {
    fn join(&mut self, drive: Option<&DriveFile>) -> Result<(), Error> {
        self.join(drive)
    }

    fn text(&self, path: &Path) -> Result<String, Error> {
        self.text(path)
    }
}

impl Settled for grey_box::Args {
    fn join(&mut self, drive: Option<&DriveFile>) -> Result<(), Error> {
        self.join(drive)
    }

    fn text(&self, path: &Path) -> Result<String, Error> {
        self.text(path)
    }
}

impl Command {
    /// Puts its settings over those of a drive file, and returns an error if one is missing.
    pub(crate) fn join(&mut self, drive: Option<&DriveFile>) -> Result<(), Error> {
        self.settled().map_or(Ok(()), |own| own.join(drive))
    }

    /// The text of a drive file at this path with its settings.
    pub(crate) fn text(&mut self, path: &Path) -> Result<String, Error> {
        self.settled().map_or(Ok(String::new()), |own| own.text(path))
    }

    /// Its settings; `None` if it takes none.
    fn settled(&mut self) -> Option<&mut dyn Settled> {
        Some(match self {
            Self::Init(args) => &mut args.taken,
            Self::Audit(args) => &mut args.taken,
            Self::Identify(args) => &mut args.fit.taken,
            Self::Structure(args) => &mut args.taken,
            Self::GreyBox(args) => &mut **args,
            Self::Validate(args) => &mut args.fit.taken,
            Self::Train(args) => &mut args.taken,
            Self::Features(args) => &mut args.taken,
            Self::TrainFeatures(args) => &mut args.taken,
            Self::Evaluate(args) => &mut args.taken,
            Self::Replay(args) => &mut args.taken,
            Self::Convert(args) => &mut args.taken,
            Self::Simulate(_)
            | Self::Confirm(_)
            | Self::View(_)
            | Self::Listen(_)
            | Self::DemoDrive(_)
            | Self::Dbc(_)
            | Self::Sign(_)
            | Self::Schema(_)
            | Self::Completions(_) => return None,
        })
    }

    /// Runs it; an audit that finds something is a failure. `described` makes the description of all commands.
    pub(crate) fn run(&self, described: fn() -> clap::Command) -> Result<ExitCode, Error> {
        match self {
            Self::Init(args) => return init::run(args),
            Self::Audit(args) => {
                let found = audit::run(args)?;
                return Ok(if found { ExitCode::FAILURE } else { ExitCode::SUCCESS });
            }
            Self::Simulate(args) => simulate::run(args),
            Self::Identify(args) => identify::run(args),
            Self::Structure(args) => structure::run(args),
            Self::GreyBox(args) => grey_box::run(args),
            Self::Validate(args) => validate::run(args),
            Self::Train(args) => train::run(args),
            Self::Features(args) => fleet::compute(args),
            Self::TrainFeatures(args) => fleet::train(args),
            Self::Evaluate(args) => evaluate::run(args),
            Self::Replay(args) => replay::run(args),
            Self::Confirm(args) => confirm::run(args),
            Self::View(args) => view::run(args),
            Self::Listen(args) => listen::run(args),
            Self::DemoDrive(_) => demo::run(),
            Self::Dbc(args) => dbc::run(args),
            Self::Convert(args) => convert::run(args),
            Self::Sign(args) => signing::run(args),
            Self::Schema(args) => schema::run(args),
            Self::Completions(args) => help::completions(args, described()),
        }
        .map(|()| ExitCode::SUCCESS)
    }
}
