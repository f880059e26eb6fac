//! `bearing-watch schema`: the forms of JSON that programs read most, key by key.
//!
//! Tests compare them with what the commands print.

mod drive;
mod form;
mod identification;
mod training;

use clap::ValueEnum;

use crate::command_line::output;
use model::Error;
use model::settings::schema::of_drive_file;

/// Print the JSON Schema of drive.toml, or of the JSON that a command prints
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  bearing-watch schema > drive.schema.json\n  bearing-watch schema train > train.schema.json\n\
\n\
An editor with a language server for TOML takes it by a first line in drive.toml: #:schema ./drive.schema.json"
)]
pub(crate) struct Args {
    /// What is described
    #[arg(value_enum, default_value_t = Form::Drive)]
    form: Form,
}

/// What has a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Form {
    /// The keys of drive.toml
    Drive,
    /// What `init --json` prints
    Init,
    /// What `train --json` prints
    Train,
    /// What `evaluate --json` prints
    Evaluate,
    /// What `replay --json` prints
    Replay,
    /// What `identify --json` prints
    Identify,
    /// What `structure --json` prints
    Structure,
    /// What `validate --json` prints
    Validate,
    /// What `grey-box --json` prints
    GreyBox,
    /// What `cogging --json` prints
    Cogging,
    /// What `audit --json` prints
    Audit,
    /// What `features --json` prints
    Features,
    /// What `train-features --json` prints
    TrainFeatures,
    /// What `listen --json` prints on each line
    Listen,
    /// What every command prints with --json if it fails
    Error,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let schema = match args.form {
        Form::Drive => of_drive_file(),
        Form::Init => identification::INIT.schema(),
        Form::Train => training::TRAIN.schema(),
        Form::Evaluate => training::EVALUATE.schema(),
        Form::Replay => drive::REPLAY.schema(),
        Form::Identify => identification::IDENTIFY.schema(),
        Form::Structure => identification::STRUCTURE.schema(),
        Form::Validate => identification::VALIDATE.schema(),
        Form::GreyBox => identification::GREY_BOX.schema(),
        Form::Cogging => identification::COGGING.schema(),
        Form::Audit => identification::AUDIT.schema(),
        Form::Features => training::FEATURES.schema(),
        Form::TrainFeatures => training::TRAIN_FEATURES.schema(),
        Form::Listen => drive::LISTEN.schema(),
        Form::Error => form::ERROR.schema(),
    };
    output::say(format!("{schema:#}"))
}
