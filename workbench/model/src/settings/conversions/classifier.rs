//! From the settings to features, projection and discriminant, with priors and costs by the names of classes.

use bearing_watch::plan::Kind;

use crate::Error;
use crate::core::features;
use crate::identify::Structure;
use crate::near::among;
use crate::settings::sections::choices::{Discriminant, Projection};
use crate::settings::sections::model::{Model, VARIANCE};
use crate::settings::sections::settings::Settings;
use crate::trace::{Channels, Preparation};
use crate::train::{Keep, ProjectionKind, Recipe, ShaftPlan, Shrink, Shrinkage};

impl Settings {
    /// Returns the recipe with features, projection, discriminant, priors and costs.
    ///
    /// # Errors
    /// Settings that are out of range, do not go together, or name unknown classes.
    pub fn classifier(&self, recipe: Recipe, classes: &[String]) -> Result<Recipe, Error> {
        let model = &self.model;
        let size_spread = model.size_spread.unwrap_or(0.0);
        if !(0.0..=1.0).contains(&size_spread) {
            return Err(Error::Usage("--size-spread takes a number from 0 to 1, e.g. 0.25".into()));
        }
        let (discriminant, shrink) = model.discriminant()?;
        let automatic = recipe.shaft.is_some() && self.chooses_features();
        Ok(Recipe {
            automatic,
            features: model.features.clone(),
            rising: model.rising.clone(),
            identify: model.identify,
            projection: model.projection()?,
            discriminant,
            shrink,
            size_spread,
            priors: priors(&self.alarm.priors, classes)?,
            cost: costs(&self.alarm.cost, classes)?,
            ..recipe
        })
    }
}

impl Settings {
    /// Whether training chooses the features of a shaft: those that a user names, or mixes, are his choice.
    pub(crate) fn chooses_features(&self) -> bool {
        let model = &self.model;
        let mixed = model.projection.unwrap_or_default() != Projection::None;
        model.features.is_empty() && model.rising.is_empty() && !mixed
    }
}

impl Model {
    /// Returns an error if a setting is out of range whatever the classes are.
    ///
    /// # Errors
    /// It is.
    pub fn check(&self) -> Result<(), Error> {
        if self.variance.is_some_and(|variance| variance.is_nan() || variance <= 0.0 || variance > 1.0) {
            return Err(Error::Usage("--variance is a part of the whole: above 0, at most 1".into()));
        }
        Ok(())
    }

    fn projection(&self) -> Result<ProjectionKind, Error> {
        let keep = self.components.map_or(Keep::Variance(self.variance.unwrap_or(VARIANCE)), Keep::Components);
        Ok(match self.projection.unwrap_or_default() {
            Projection::None if self.components.is_some() => {
                return Err(Error::Usage("--components goes with --projection pca, pca-raw or fisher".into()));
            }
            Projection::None => ProjectionKind::None,
            Projection::Pca => ProjectionKind::Pca { keep, standardised: true },
            Projection::PcaRaw => ProjectionKind::Pca { keep, standardised: false },
            Projection::Fisher => ProjectionKind::Fisher { components: self.components },
        })
    }

    fn discriminant(&self) -> Result<(Kind, Shrink), Error> {
        let own = self.discriminant.unwrap_or_default();
        let kind = match own {
            Discriminant::Linear | Discriminant::Shrunk => Kind::Linear,
            Discriminant::Quadratic => Kind::Quadratic,
        };
        let shrink = match (&self.shrinkage[..], own) {
            (&[lambda, gamma], _) if [lambda, gamma].iter().all(|x| (0.0..=1.0).contains(x)) => {
                Shrink::To(Shrinkage { lambda, gamma })
            }
            ([_, ..], _) => {
                return Err(Error::Usage("--shrinkage takes two numbers from 0 to 1, e.g. 0,0.5".into()));
            }
            (_, Discriminant::Shrunk) => Shrink::Chosen,
            (_, Discriminant::Linear | Discriminant::Quadratic) => Shrink::Not,
        };
        Ok((kind, shrink))
    }

    /// Adds the columns that averages among features and covariates name and no other part uses.
    ///
    /// # Errors
    /// A root mean square of prepared samples.
    pub fn averaged(
        &self,
        (structure, shaft): (Structure, Option<&ShaftPlan>),
        columns: Channels,
        preparation: Preparation,
    ) -> Result<Channels, Error> {
        let mut names = self.features.iter().chain(&self.covariates);
        if preparation != Preparation::NONE && names.any(|name| name.starts_with(features::RMS)) {
            let problem =
                "a root mean square is that of the recorded samples: --block-mean and --decimate do not go with it";
            return Err(Error::Usage(problem.into()));
        }
        let (features, covariates) = (self.features.clone(), self.covariates.clone());
        let plain = Recipe { features, covariates, columns, ..Recipe::new(structure) };
        Ok(Recipe { shaft: shaft.cloned(), ..plain }.with_averaged_columns().columns)
    }
}

pub(crate) fn priors(asked: &[String], classes: &[String]) -> Result<Vec<f64>, Error> {
    if asked.is_empty() {
        return Ok(vec![]);
    }
    let mut priors = vec![f64::NAN; classes.len()];
    for item in asked {
        let (name, value) = item.split_once('=').unwrap_or((item, ""));
        let prior = &mut priors[class(classes, name, "--priors")?];
        if !prior.is_nan() {
            return Err(Error::Usage(format!("--priors names {name} twice")));
        }
        *prior = number(value, "--priors", item)?;
    }
    if let Some(k) = priors.iter().position(|p| p.is_nan()) {
        return Err(Error::Usage(format!("--priors says nothing of class {}", classes[k])));
    }
    Ok(priors)
}

pub(crate) fn costs(asked: &[String], classes: &[String]) -> Result<Vec<Vec<f64>>, Error> {
    if asked.is_empty() {
        return Ok(vec![]);
    }
    let n = classes.len();
    let mut costs: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|k| f64::from(u8::from(i != k))).collect()).collect();
    for item in asked {
        let (pair, value) = item.split_once('=').unwrap_or((item, ""));
        let (decided, truth) = pair.split_once(':').ok_or_else(|| {
            Error::Usage(format!("--cost \"{item}\": write DECIDED:TRUE=COST, e.g. healthy:spall=50"))
        })?;
        let (decided, truth) = (class(classes, decided, "--cost")?, class(classes, truth, "--cost")?);
        if decided == truth {
            return Err(Error::Usage(format!("--cost \"{item}\": a right decision costs nothing")));
        }
        costs[decided][truth] = number(value, "--cost", item)?;
    }
    Ok(costs)
}

fn class(classes: &[String], name: &str, option: &str) -> Result<usize, Error> {
    let near = || among(name, classes);
    let place = classes.iter().position(|class| class == name.trim());
    place.ok_or_else(|| Error::Usage(format!("{option}: unknown class {name}{}", near())))
}

fn number(text: &str, option: &str, item: &str) -> Result<f64, Error> {
    let value = text.trim().parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
    value.ok_or_else(|| Error::Usage(format!("{option} \"{item}\": after = comes a number that is not negative")))
}
