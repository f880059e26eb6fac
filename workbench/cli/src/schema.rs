//! `bearing-watch schema`

use clap::ValueEnum;

use super::forms;
use super::further_forms;
use super::output;
use super::study_forms;
use model::Error;
use model::settings::schema::of_drive_file;

/// Print the JSON Schema of drive.toml, or of the JSON that a command prints
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  bearing-watch schema > drive.schema.json\n  bearing-watch schema train > train.schema.json\n\
\n\
An editor with a language server for TOML takes it by a first line in drive.toml: #:schema ./drive.schema.json"
)]
pub(super) struct Args {
    /// What is described
    #[arg(value_enum, default_value_t = Form::Drive)]
    form: Form,
}

/// What has a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Form {
    /// The keys of drive.toml
    Drive,
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

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let schema = match args.form {
        Form::Drive => of_drive_file(),
        Form::Train => forms::TRAIN.schema(),
        Form::Evaluate => forms::EVALUATE.schema(),
        Form::Replay => forms::REPLAY.schema(),
        Form::Identify => further_forms::IDENTIFY.schema(),
        Form::Structure => further_forms::STRUCTURE.schema(),
        Form::Validate => further_forms::VALIDATE.schema(),
        Form::GreyBox => further_forms::GREY_BOX.schema(),
        Form::Cogging => further_forms::COGGING.schema(),
        Form::Audit => further_forms::AUDIT.schema(),
        Form::Features => further_forms::FEATURES.schema(),
        Form::TrainFeatures => further_forms::TRAIN_FEATURES.schema(),
        Form::Listen => study_forms::LISTEN.schema(),
        Form::Error => forms::ERROR.schema(),
    };
    output::say(format!("{schema:#}"))
}
