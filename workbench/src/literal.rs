//! The source's own method, kept beside ours: iv4, the a-parameters, PCA to two components, linear discriminants.
//!
//! Thesis §2.1.2, §2.5–2.6, §3.4–3.6. It runs in double precision on the host: the embedded detector has no iv4. The
//! original program makes *two binary* classifiers, healthy against each defect, on one PCA of all classes; a
//! decision among all classes is shown beside it. With na = 2 a projection to two components is an invertible affine
//! map, which cannot change a linear or quadratic discriminant.

use bearing_watch::decide::Kind;
use rayon::prelude::*;

use crate::Error;
use crate::evaluate::Confusion;
use crate::features;
use crate::identify::{Estimate, Order, Structure, iv4};
use crate::trace::labels::LabelledTrace;
use crate::train::{FeatureTable, GaussianClasses, Keep, ProjectionKind, Recipe, discriminant, projection};

/// What the literal method made of a validation set.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// One decision among all classes.
    pub all_classes: Confusion,
    /// Wrong decisions of the binary classifiers, healthy against each defect, pooled.
    pub binary_wrong: usize,
    /// Their decisions.
    pub binary_total: usize,
    /// Mean fit (Eq. 3.2) of the first class' validation traces, percent.
    pub fit_percent: f64,
}

impl Outcome {
    /// Pooled error of the binary classifiers.
    #[must_use]
    pub fn binary_error(&self) -> f64 {
        self.binary_wrong as f64 / self.binary_total.max(1) as f64
    }
}

/// Trains on one set and validates on another; class 0 is the healthy one.
///
/// # Errors
/// Where a trace cannot be estimated or the features are singular.
pub fn validate(
    training: &[LabelledTrace],
    validation: &[LabelledTrace],
    classes: &[String],
    order: Order,
) -> Result<Outcome, Error> {
    let structure = Structure { order, offset: false };
    let chosen = features::choose(structure, &["a".to_string()])?;
    let names: Vec<String> = chosen.iter().map(|&k| features::all_names(structure)[k].clone()).collect();
    let (raw, _) = table(training, classes, structure, &chosen)?;
    let keep = Keep::Components(2.min(chosen.len()));
    let map = projection::train(&raw, &names, ProjectionKind::Pca { keep, standardised: false })?;
    let (held_out, fit_percent) = table(validation, classes, structure, &chosen)?;
    let (raw, held_out) = (raw.map(&map), held_out.map(&map));

    let recipe = Recipe { discriminant: Kind::Linear, ..Recipe::new(structure) };
    let coordinates: Vec<String> = (1..=map.matrix.nrows()).map(|k| format!("z{k}")).collect();
    let all = discriminant::train(&raw, &coordinates, &recipe)?;
    let mut all_classes = Confusion::new(classes);
    for (row, &truth) in held_out.rows.iter().zip(&held_out.classes) {
        all_classes.add(truth, Some(most_likely(&all, row)));
    }
    let (mut binary_wrong, mut binary_total) = (0, 0);
    for defect in 1..classes.len() {
        let pair = discriminant::train(&two_classes(&raw, defect), &coordinates, &recipe)?;
        let test = two_classes(&held_out, defect);
        binary_total += test.rows.len();
        binary_wrong +=
            test.rows.iter().zip(&test.classes).filter(|(row, truth)| most_likely(&pair, row) != **truth).count();
    }
    Ok(Outcome { all_classes, binary_wrong, binary_total, fit_percent })
}

/// The class of largest likelihood: equal priors and uniform costs, as the source has them.
fn most_likely(densities: &GaussianClasses, z: &nalgebra::DVector<f64>) -> usize {
    let likelihoods = densities.log_likelihoods(z);
    (0..likelihoods.len()).max_by(|&i, &j| likelihoods[i].total_cmp(&likelihoods[j])).unwrap_or(0)
}

fn table(
    traces: &[LabelledTrace],
    classes: &[String],
    structure: Structure,
    chosen: &[usize],
) -> Result<(FeatureTable, f64), Error> {
    let estimates: Vec<Estimate> = traces.par_iter().map(|t| iv4(&t.trace, structure)).collect::<Result<_, _>>()?;
    let healthy: Vec<f64> =
        estimates.iter().zip(traces).filter(|(_, t)| t.class == 0).map(|(e, _)| e.fit_percent).collect();
    let fit = healthy.iter().sum::<f64>() / healthy.len().max(1) as f64;
    let classes_of = traces.iter().map(|t| t.class).collect();
    Ok((FeatureTable::new(&estimates, classes_of, classes.to_vec()).select(chosen), fit))
}

/// Rows of class 0 and of one other, relabelled 0 and 1.
fn two_classes(table: &FeatureTable, other: usize) -> FeatureTable {
    let rows = table.rows.iter().zip(&table.classes).filter(|(_, class)| **class == 0 || **class == other);
    let (rows, classes) = rows.map(|(row, &class)| (row.clone(), usize::from(class == other))).unzip();
    FeatureTable { rows, classes, names: vec![table.names[0].clone(), table.names[other].clone()] }
}
