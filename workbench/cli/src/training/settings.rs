//! The settings of training, as options of the command line, and their conversion to a recipe.

use crate::args::alarms::AlarmArgs;
use crate::args::classifier::ClassifierArgs;
use crate::args::estimation::EstimationArgs;
use crate::args::park::ParkArgs;
use crate::args::shaft::ShaftArgs;
use crate::args::traces::{ChannelArgs, PreparationArgs, SelectionArgs, StructureArgs, ValidationArgs};
use model::Error;
use model::trace::{Channels, Condition};
use model::train::{Recipe, ShaftPlan};

/// What a model is trained on, and how.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Settings {
    #[command(flatten)]
    pub(super) selection: SelectionArgs,
    #[command(flatten)]
    pub(super) channels: ChannelArgs,
    #[command(flatten)]
    pub(super) structure: StructureArgs,
    #[command(flatten)]
    pub(super) estimation: EstimationArgs,
    #[command(flatten)]
    pub(super) shaft: ShaftArgs,
    #[command(flatten)]
    pub(super) preparation: PreparationArgs,
    /// Train on the rows with this, e.g. 'run<=4'; may be repeated, all must hold
    #[arg(long, value_name = "CONDITION")]
    pub(super) train_where: Vec<Condition>,
    /// Then evaluate on the rows with this, e.g. 'run>4'
    #[arg(long, value_name = "CONDITION")]
    pub(super) test_where: Vec<Condition>,
    /// Features that explain a part of the others in healthy traces, e.g. mean_temperature_c: that part is subtracted;
    /// outside the range of the healthy traces, what they explain is missing
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) covariates: Vec<String>,
    #[command(flatten)]
    pub(super) classifier: ClassifierArgs,
    #[command(flatten)]
    pub(super) park: ParkArgs,
    #[command(flatten)]
    pub(super) validation: ValidationArgs,
    #[command(flatten)]
    pub(super) alarms: AlarmArgs,
}

impl Settings {
    pub(super) fn recipe(&self, classes: &[String], shaft: Option<ShaftPlan>) -> Result<Recipe, Error> {
        let structure = self.structure.structure();
        let plain = Recipe {
            columns: Channels::new("", "", ""),
            shaft,
            estimation: self.estimation.estimation(structure, classes, self.alarms.healthy_class(classes)?)?,
            covariates: self.covariates.clone(),
            alarms: self.alarms.alarms(classes)?,
            ..Recipe::new(structure)
        };
        self.classifier.apply(plain, classes)
    }
}
