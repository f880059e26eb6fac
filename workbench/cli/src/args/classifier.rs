//! Arguments of features, projection and discriminant.

use bearing_watch::plan::Kind;
use clap::{Args, ValueEnum};

use super::odds::{costs, priors};
use model::Error;
use model::core::features;
use model::identify::Structure;
use model::trace::{Channels, Preparation};
use model::train::{Keep, ProjectionKind, Recipe, ShaftPlan, Shrink, Shrinkage};

#[derive(Clone, Debug, Args)]
pub(crate) struct ClassifierArgs {
    /// a, b, c, offset, log_variance, friction, friction_scores, friction_logs, orders, or single ones such as a1,
    /// viscous_score, viscous_log or order_outer; mean_CHANNEL or rms_CHANNEL of any column; every parameter if not
    /// given
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) features: Vec<String>,
    /// Features that a defect only raises, e.g. viscous: the gate judges them upwards only, given the others, as it
    /// does with the scores of orders
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    rising: Vec<String>,
    /// Projection of the features
    #[arg(long, value_enum, default_value = "none")]
    projection: Projection,
    /// Components to keep (pca, pca-raw, fisher)
    #[arg(long, value_name = "N")]
    components: Option<usize>,
    /// Part of the variance to keep if --components is not given (pca, pca-raw)
    #[arg(long, value_name = "PART", default_value_t = 0.99)]
    variance: f64,
    /// Class covariances: shared, separate, or between the two
    #[arg(long, value_enum, default_value = "linear")]
    discriminant: DiscriminantKind,
    /// Fixed shrinkage of class covariances instead: towards the shared one, and of their correlations, each 0 to 1
    #[arg(long, value_name = "SHARED,DIAGONAL", value_delimiter = ',', num_args = 1, conflicts_with = "discriminant")]
    shrinkage: Vec<f64>,
    /// Relative deviation of a defect's size from that in training, e.g. 0.25: classes reach towards the healthy one,
    /// so that smaller defects keep their name; needs --healthy and separate covariances
    #[arg(long, value_name = "PART", default_value_t = 0.0)]
    size_spread: f64,
    /// Priors, e.g. healthy=0.98,spall=0.01,roughness=0.01; equal if not given
    #[arg(long, value_name = "CLASS=P", value_delimiter = ',')]
    priors: Vec<String>,
    /// Cost of deciding a class when another is true, e.g. healthy:spall=50; 1 if not given
    #[arg(long, value_name = "DECIDED:TRUE=COST", value_delimiter = ',')]
    cost: Vec<String>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Projection {
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
enum DiscriminantKind {
    /// One covariance for all classes
    Linear,
    /// A separate covariance for each class
    Quadratic,
    /// Between the two and a diagonal, by the best cross-validated log score
    Shrunk,
}

impl ClassifierArgs {
    /// Returns an error if a setting is out of range whatever the classes are.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.variance.is_nan() || self.variance <= 0.0 || self.variance > 1.0 {
            return Err(Error::Usage("--variance is a part of the whole: above 0, at most 1".into()));
        }
        Ok(())
    }

    /// Returns the recipe with these choices.
    pub(crate) fn apply(&self, recipe: Recipe, classes: &[String]) -> Result<Recipe, Error> {
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
        Ok(Recipe {
            features: self.features.clone(),
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
            priors: priors(&self.priors, classes)?,
            cost: costs(&self.cost, classes)?,
            ..recipe
        })
    }
}

/// Features and covariates, of which some may be averages of columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Averages<'a> {
    pub(crate) features: &'a [String],
    pub(crate) covariates: &'a [String],
}

impl Averages<'_> {
    /// Adds the columns that averages name and no other part uses.
    pub(crate) fn columns(
        self,
        (structure, shaft): (Structure, Option<&ShaftPlan>),
        columns: Channels,
        preparation: Preparation,
    ) -> Result<Channels, Error> {
        let mut names = self.features.iter().chain(self.covariates);
        if preparation != Preparation::NONE && names.any(|name| name.starts_with(features::RMS)) {
            let problem =
                "a root mean square is that of the recorded samples: --block-mean and --decimate do not go with it";
            return Err(Error::Usage(problem.into()));
        }
        let (features, covariates) = (self.features.to_vec(), self.covariates.to_vec());
        let plain = Recipe { features, covariates, columns, ..Recipe::new(structure) };
        Ok(Recipe { shaft: shaft.cloned(), ..plain }.with_averaged_columns().columns)
    }
}
