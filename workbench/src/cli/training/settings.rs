//! The settings of training, as options of the command line, and their conversion to a recipe.

use bearing_watch::Park;
use bearing_watch::plan::Kind;
use clap::ValueEnum;

use crate::Error;
use crate::cli::args::alarms::AlarmArgs;
use crate::cli::args::estimation::EstimationArgs;
use crate::cli::args::odds::{costs, priors};
use crate::cli::args::shaft::ShaftArgs;
use crate::cli::args::traces::{ChannelArgs, PreparationArgs, SelectionArgs, StructureArgs, ValidationArgs};
use crate::core::features;
use crate::trace::{Channels, Condition, FrontEndFile, Preparation};
use crate::train::{Keep, ProjectionKind, Recipe, ShaftPlan, Shrink, Shrinkage, Validation};

/// What a model is trained on, and how.
#[derive(Clone, Debug, clap::Args)]
pub(in crate::cli) struct Settings {
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
    /// a, b, c, offset, log_variance, friction, friction_scores, friction_logs, orders, or single ones such as a1,
    /// viscous_score, viscous_log or order_outer; mean_CHANNEL or rms_CHANNEL of any column; every parameter if not
    /// given
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) features: Vec<String>,
    /// Features that explain a part of the others in healthy traces, e.g. mean_temperature_c: that part is subtracted;
    /// outside the range of the healthy traces, what they explain is missing
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) covariates: Vec<String>,
    /// Features that a defect only raises, e.g. viscous: the gate judges them upwards only, given the others, as it
    /// does with the scores of orders
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) rising: Vec<String>,
    /// Projection of the features
    #[arg(long, value_enum, default_value = "none")]
    pub(super) projection: Projection,
    /// Components to keep (pca, pca-raw, fisher)
    #[arg(long, value_name = "N")]
    pub(super) components: Option<usize>,
    /// Part of the variance to keep if --components is not given (pca, pca-raw)
    #[arg(long, value_name = "PART", default_value_t = 0.99)]
    pub(super) variance: f64,
    /// Class covariances: shared, separate, or between the two
    #[arg(long, value_enum, default_value = "linear")]
    pub(super) discriminant: DiscriminantKind,
    /// Fixed shrinkage of class covariances instead: towards the shared one, and of their correlations, each 0 to 1
    #[arg(long, value_name = "SHARED,DIAGONAL", value_delimiter = ',', num_args = 1, conflicts_with = "discriminant")]
    pub(super) shrinkage: Vec<f64>,
    /// Relative deviation of a defect's size from that in training, e.g. 0.25: classes reach towards the healthy one,
    /// so that smaller defects keep their name; needs --healthy and separate covariances
    #[arg(long, value_name = "PART", default_value_t = 0.0)]
    pub(super) size_spread: f64,
    /// Priors, e.g. healthy=0.98,spall=0.01,roughness=0.01; equal if not given
    #[arg(long, value_name = "CLASS=P", value_delimiter = ',')]
    pub(super) priors: Vec<String>,
    /// Cost of deciding a class when another is true, e.g. healthy:spall=50; 1 if not given
    #[arg(long, value_name = "DECIDED:TRUE=COST", value_delimiter = ',')]
    pub(super) cost: Vec<String>,
    /// Sign convention of the quadrature current in the recordings; the model then refuses a front end that differs
    #[arg(long, value_enum)]
    pub(super) park: Option<ParkConvention>,
    #[command(flatten)]
    pub(super) validation: ValidationArgs,
    #[command(flatten)]
    pub(super) alarms: AlarmArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum Projection {
    /// Every feature, scaled
    None,
    /// Principal components of the standardised features
    Pca,
    /// Principal components of the centred features, as in the source
    PcaRaw,
    /// Fisher's directions: largest spread between classes relative to the spread within them
    Fisher,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum ParkConvention {
    /// With the angle on the magnet axis, positive q current produces positive torque
    Standard,
    /// The +sin row of the source's Eq. 5.1
    Thesis,
}

impl ParkConvention {
    const fn core(self) -> Park {
        match self {
            Self::Standard => Park::Standard,
            Self::Thesis => Park::Thesis,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum DiscriminantKind {
    /// One covariance for all classes
    Linear,
    /// A separate covariance for each class
    Quadratic,
    /// Between the two and a diagonal, by the best cross-validated log score
    Shrunk,
}

impl Settings {
    /// The sign convention of the recordings: that of the front end, if there is one.
    pub(super) fn park(&self, channels: &Channels) -> Result<Option<Park>, Error> {
        let asked = self.park.map(ParkConvention::core);
        match (asked, channels.front_end.as_ref().map(FrontEndFile::park)) {
            (Some(asked), Some(own)) if asked != own => {
                Err(Error::Usage("--park differs from the convention of --front-end".into()))
            }
            (asked, own) => Ok(own.or(asked)),
        }
    }

    /// Adds the columns that averages name and no other part uses.
    pub(super) fn with_averaged_columns(
        &self,
        columns: Channels,
        shaft: Option<&ShaftPlan>,
        preparation: Preparation,
    ) -> Result<Channels, Error> {
        let names = || self.features.iter().chain(&self.covariates);
        if preparation != Preparation::NONE && names().any(|name| name.starts_with(features::RMS)) {
            let problem =
                "a root mean square is that of the recorded samples: --block-mean and --decimate do not go with it";
            return Err(Error::Usage(problem.into()));
        }
        let (features, covariates) = (self.features.clone(), self.covariates.clone());
        let plain = Recipe { features, covariates, columns, ..Recipe::new(self.structure.structure()) };
        Ok(Recipe { shaft: shaft.cloned(), ..plain }.with_averaged_columns().columns)
    }

    pub(super) fn recipe(&self, classes: &[String], shaft: Option<ShaftPlan>) -> Result<Recipe, Error> {
        let keep = self.components.map_or(Keep::Variance(self.variance), Keep::Components);
        let projection = match self.projection {
            Projection::None if self.components.is_some() => {
                return Err(Error::Usage("--components goes with --projection pca, pca-raw or fisher".into()));
            }
            Projection::None => ProjectionKind::None,
            Projection::Pca => ProjectionKind::Pca { keep, standardised: true },
            Projection::PcaRaw => ProjectionKind::Pca { keep, standardised: false },
            Projection::Fisher => ProjectionKind::Fisher { components: self.components },
        };
        let structure = self.structure.structure();
        Ok(Recipe {
            columns: Channels::new("", "", ""),
            park: None,
            structure,
            shaft,
            estimation: self.estimation.estimation(structure, classes, self.alarms.healthy_class(classes)?)?,
            features: self.features.clone(),
            covariates: self.covariates.clone(),
            rising: self.rising.clone(),
            projection,
            discriminant: match self.discriminant {
                DiscriminantKind::Linear | DiscriminantKind::Shrunk => Kind::Linear,
                DiscriminantKind::Quadratic => Kind::Quadratic,
            },
            shrink: match (&self.shrinkage[..], self.discriminant) {
                (&[lambda, gamma], _) if [lambda, gamma].iter().all(|x| (0.0..=1.0).contains(x)) => {
                    Shrink::To(Shrinkage { lambda, gamma })
                }
                ([_, ..], _) => {
                    return Err(Error::Usage("--shrinkage takes two numbers from 0 to 1, e.g. 0,0.5".into()));
                }
                (_, DiscriminantKind::Shrunk) => Shrink::Chosen,
                (_, DiscriminantKind::Linear | DiscriminantKind::Quadratic) => Shrink::Not,
            },
            size_spread: if (0.0..=1.0).contains(&self.size_spread) {
                self.size_spread
            } else {
                return Err(Error::Usage("--size-spread takes a number from 0 to 1, e.g. 0.25".into()));
            },
            validation: Validation::default(),
            priors: priors(&self.priors, classes)?,
            cost: costs(&self.cost, classes)?,
            alarms: self.alarms.alarms(classes)?,
        })
    }
}
