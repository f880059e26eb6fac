//! A trained model in the core's single-precision form.

use bearing_watch::Model;
use bearing_watch::model::{
    Classifier, Discriminant, Label, MAX_BYTES, MAX_SEGMENT_SAMPLES, Novelty, Projection, Sampling,
};
use bearing_watch::plan::{Kind, Layout, RunTime};
use nalgebra::{DMatrix, DVector};

use super::label::{alike, label};
use super::read::Read;
use crate::Error;
use crate::core::features::Catalogue;
use crate::core::{Embedded, plan};
use crate::error::refused;
use crate::train::novelty::Gate;
use crate::train::{AffineMap, Shrink, Shrinkage, Trained};

impl Trained {
    /// Returns the model in the core's form.
    ///
    /// # Errors
    /// A value that does not fit a model or is outside the range of single precision.
    pub fn to_core(&self) -> Result<Model<RunTime>, Error> {
        let Read { parts, features, covariates: explaining } = self.read();
        let densities = &self.densities;
        let sizes = [
            count(features.len(), "features")?,
            count(self.core_projection.matrix.nrows(), "coordinates")?,
            count(self.classes.len(), "classes")?,
        ];
        let covariates = count(explaining.list.len(), "covariates")?;
        let rises = self.watch.gate.as_ref().and_then(|gate| gate.rising.as_ref());
        let rising = count(rises.map_or(0, |rising| rising.laws.len()), "rising coordinates")?;
        let watched = self.watch.directions.as_ref().map_or(0, |directions| directions.list.len());
        let directions = count(watched, "directions")?;
        let layout = Layout { covariates, rising, directions, ..parts.layout(sizes, densities.kind) };
        let plan = plan(layout).map_err(refused)?;
        if let Some([one, other]) = alike(&self.classes) {
            let problem = format!("the classes {one} and {other} have one name in the model; rename one of them");
            return Err(Error::Training(problem));
        }
        let label = |name: &String| {
            let problem = || Error::Training(format!("class name {name} does not fit the model; choose another"));
            Label::new(&label(name)).ok_or_else(problem)
        };
        let log_prior: Vec<f64> = densities.priors.iter().map(|p| p.ln()).collect();
        let classifier = Classifier {
            features,
            covariates: explaining,
            projection: Projection {
                matrix: rows(&self.core_projection.matrix),
                mean: narrow(self.core_projection.mean.as_slice()),
                usual: narrow(self.core_usual.as_slice()),
            },
            discriminant: Discriminant {
                means: densities.means.iter().flat_map(|mean| narrow(mean.as_slice())).collect(),
                factors: densities.covariances.iter().flat_map(packed_factor).collect(),
                log_prior: narrow(&log_prior),
                costs: densities.cost.iter().flat_map(|row| narrow(row)).collect(),
                reject_cost: self.recipe.alarms.reject_cost as f32,
            },
            novelty: self.novelty(plan)?,
        };
        let labels = self.classes.iter().map(label).collect::<Result<_, _>>()?;
        let sampling = self.sampling()?;
        parts.model(plan, sampling, classifier, self.watch.evidence, labels).map_err(refused)
    }

    fn sampling(&self) -> Result<Sampling, Error> {
        Ok(Sampling {
            interval_s: self.interval_s as f32,
            park: self.recipe.park,
            block_mean: u16::try_from(self.block_mean)
                .map_err(|_| Error::Usage("--block-mean is at most 65535".into()))?,
            segment_samples: samples(self.segment_samples)?,
        })
    }

    pub(crate) fn novelty(&self, plan: RunTime) -> Result<Novelty<RunTime>, Error> {
        let mut novelty = Novelty::none(plan);
        if let Some(gate) = &self.watch.gate {
            novelty.class = Some(count(gate.class, "classes")?);
            novelty.mean = narrow(gate.mean.as_slice());
            novelty.factor = gate.factor();
            novelty.knots = gate.knots.map(|knot| knot.map(|x| x as f32));
            if let Some(rising) = &gate.rising {
                (novelty.laws, novelty.rises) = (rising.core(gate.limit), rising.rises(gate.limit));
                (novelty.freedom, novelty.acceptable) = (rising.freedom as f32, self.recipe.alarms.acceptable as f32);
            }
            novelty.limit = gate.limit as f32;
        }
        if let Some(directions) = &self.watch.directions {
            novelty.directions = directions.core()?;
        }
        Ok(novelty)
    }

    /// Returns the model in binary form, with notes.
    ///
    /// # Errors
    /// As [`Trained::to_core`].
    pub fn to_bytes(&self, notes: &str) -> Result<Vec<u8>, Error> {
        let mut buffer = vec![0; MAX_BYTES];
        let length = self.to_core()?.to_bytes(notes, &mut buffer).map_err(refused)?;
        buffer.truncate(length);
        Ok(buffer)
    }

    /// Returns the model ready to run.
    ///
    /// # Errors
    /// As [`Trained::to_core`].
    pub fn embed(&self) -> Result<Embedded, Error> {
        Embedded::new(self.to_core()?).map_err(refused)
    }

    /// Describes whether covariances are shared, how they are shrunk, and how far the sizes of defects are spread.
    #[must_use]
    pub fn kind_name(&self) -> String {
        let kind = match self.densities.kind {
            Kind::Linear => "linear",
            Kind::Quadratic => "quadratic",
        };
        let shrinkage = match (self.recipe.shrink, &self.choice) {
            (Shrink::To(shrinkage), _) => Some(shrinkage),
            (_, choice) => choice.as_ref().map(|choice| choice.shrinkage),
        };
        let shrunk = shrinkage.map(|Shrinkage { lambda, gamma }| format!("shrunk by λ = {lambda}, γ = {gamma}"));
        let spread = self.recipe.size_spread;
        let spread = (spread > 0.0).then(|| format!("sizes of defects spread by {spread}"));
        let how: Vec<String> = shrunk.into_iter().chain(spread).collect();
        if how.is_empty() { kind.into() } else { format!("{kind} ({})", how.join("; ")) }
    }
}

impl Gate {
    /// Returns the factor of the covariance, as the core stores it.
    #[must_use]
    pub fn factor(&self) -> Vec<f32> {
        packed_factor(&self.covariance)
    }
}

pub(crate) fn samples(segment: usize) -> Result<u32, Error> {
    u32::try_from(segment).map_err(|_| Error::Usage(format!("a segment has at most {MAX_SEGMENT_SAMPLES} samples")))
}

fn count(value: usize, what: &str) -> Result<u8, Error> {
    u8::try_from(value).map_err(|_| Error::Training(format!("{value} {what} are more than the 255 of a detector")))
}

fn narrow(values: &[f64]) -> Vec<f32> {
    values.iter().map(|x| *x as f32).collect()
}

/// Returns the elements of a matrix by rows.
fn rows(matrix: &DMatrix<f64>) -> Vec<f32> {
    matrix.row_iter().flat_map(|row| row.iter().map(|x| *x as f32).collect::<Vec<_>>()).collect()
}

/// Returns D and R of Σ = RᵀDR as the core stores them; zeros if Σ is not positive definite.
fn packed_factor(covariance: &DMatrix<f64>) -> Vec<f32> {
    let n = covariance.nrows();
    let factor = covariance.clone().cholesky().map_or_else(|| DMatrix::zeros(n, n), |factor| factor.l());
    let element = |i: usize, j: usize| if i == j { factor[(i, i)].powi(2) } else { factor[(j, i)] / factor[(i, i)] };
    let places = (0..n).flat_map(|i| (i..n).map(move |j| (i, j)));
    places.map(|(i, j)| element(i, j) as f32).collect()
}

/// Returns the map from the core's δ-features: z = W (raw − m) = W T_S (δ − δ_m), with δ_m the training mean of δ, and
/// the places of the δ-features that it uses. `raw` and `usual` are the means and usual errors of all features.
#[must_use]
pub fn compose(
    (mut raw, usual): (DVector<f64>, &DVector<f64>),
    chosen: &[usize],
    catalogue: &Catalogue,
    projection: &AffineMap,
) -> (Vec<usize>, AffineMap, DVector<f64>) {
    let map = catalogue.raw_from_delta().select_rows(chosen);
    let used: Vec<usize> = (0..map.ncols()).filter(|&k| map.column(k).amax() > 0.0).collect();
    // Both centres are the same point: of the chosen features the projection's centre, of the others any.
    chosen.iter().zip(projection.mean.iter()).for_each(|(&place, mean)| raw[place] = *mean);
    let mean = catalogue.delta_from_raw(&raw);
    let matrix = &projection.matrix * map.select_columns(&used);
    let centre = DVector::from_iterator(used.len(), used.iter().map(|&k| mean[k]));
    // The map from raw features leaves those with errors as they are.
    let usual = DVector::from_iterator(used.len(), used.iter().map(|&k| usual[k]));
    (used, AffineMap { matrix, mean: centre }, usual)
}
