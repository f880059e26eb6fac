//! The source's method, for comparison with ours: iv4, the a-parameters, PCA to two components, linear discriminants.
//!
//! Thesis §2.1.2, §2.5–2.6, §3.4–3.6. It runs in double precision on the host: the embedded detector has no iv4. The
//! original program trains *two binary* classifiers, healthy against each defect, on one PCA of all classes; this
//! module also evaluates one decision among all classes. With na = 2 a projection to two components is an invertible
//! affine map, which cannot change a linear or quadratic discriminant.

use bearing_watch::plan::Kind;
use nalgebra::DVector;
use rayon::prelude::*;

use model::Error;
use model::core::features;
use model::evaluate::Confusion;
use model::identify::{Estimate, Structure, iv4};
use model::trace::labels::LabelledTrace;
use model::train::{AffineMap, FeatureTable, GaussianClasses, Keep, ProjectionKind, Recipe, discriminant, projection};

/// Results of the source's method on a validation set.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// One decision among all classes.
    pub all_classes: Confusion,
    /// Number of wrong decisions of the binary classifiers (healthy against each defect), over all of them.
    pub binary_wrong: usize,
    /// Number of decisions of the binary classifiers.
    pub binary_total: usize,
    /// Mean fit (Eq. 3.2) of the validation traces of the first class, percent.
    pub fit_percent: f64,
}

impl Outcome {
    /// Error rate over all binary classifiers together.
    #[must_use]
    pub fn binary_error(&self) -> f64 {
        self.binary_wrong as f64 / self.binary_total.max(1) as f64
    }
}

/// Counts of decisions on rows of known class: among all classes, and healthy against each defect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Judged {
    /// One decision among all classes.
    pub all_classes: Confusion,
    /// Healthy against class 1, 2, …; each binary classifier evaluates only rows of its own two classes.
    pub pairs: Vec<Confusion>,
    /// Number of rows that at least one of their binary classifiers decided wrongly.
    pub rows_wrong: usize,
}

impl Judged {
    /// All counts zero.
    #[must_use]
    pub fn new(classes: &[String]) -> Self {
        let pair = |defect: &String| Confusion::new(&[classes[0].clone(), defect.clone()]);
        Self { all_classes: Confusion::new(classes), pairs: classes.iter().skip(1).map(pair).collect(), rows_wrong: 0 }
    }

    /// Counts one row: `decided` is the class decided among all; `binary(k)` is the decision of the binary classifier
    /// of defect k, 0 for healthy and 1 for the defect; it is called only for the classifiers that evaluate this row.
    pub fn add(&mut self, truth: usize, decided: Option<usize>, binary: impl Fn(usize) -> Option<usize>) {
        self.all_classes.add(truth, decided);
        let mut wrong = false;
        for (confusion, defect) in self.pairs.iter_mut().zip(1..) {
            if truth == 0 || truth == defect {
                let (label, decided) = (usize::from(truth == defect), binary(defect));
                confusion.add(label, decided);
                wrong |= decided != Some(label);
            }
        }
        self.rows_wrong += usize::from(wrong);
    }

    /// Share of wrong decisions among all classes.
    #[must_use]
    pub fn all_error(&self) -> f64 {
        part(self.all_classes.wrong(), self.all_classes.total())
    }

    /// Share of wrong decisions of the binary classifier of one defect, counted from 1.
    #[must_use]
    pub fn pair_error(&self, defect: usize) -> f64 {
        self.pairs.get(defect.wrapping_sub(1)).map_or(f64::NAN, |pair| part(pair.wrong(), pair.total()))
    }

    /// Share of wrong decisions of all binary classifiers; each of them decides once on a healthy row.
    #[must_use]
    pub fn pooled_error(&self) -> f64 {
        part(self.binary_wrong(), self.binary_total())
    }

    /// Share of rows that at least one binary classifier decided wrongly; a healthy row counts once.
    #[must_use]
    pub fn row_error(&self) -> f64 {
        part(self.rows_wrong, self.all_classes.total())
    }

    fn binary_wrong(&self) -> usize {
        self.pairs.iter().map(Confusion::wrong).sum()
    }

    fn binary_total(&self) -> usize {
        self.pairs.iter().map(Confusion::total).sum()
    }
}

fn part(wrong: usize, total: usize) -> f64 {
    wrong as f64 / total.max(1) as f64
}

/// Gaussian classifiers on one projection of all classes; class 0 is healthy.
#[derive(Clone, Debug)]
pub struct Rule {
    /// Features → coordinates, trained on all classes together.
    pub projection: AffineMap,
    all: GaussianClasses,
    pairs: Vec<GaussianClasses>,
}

impl Rule {
    /// Trains on rows that contain the features `names`.
    ///
    /// # Errors
    /// Returns an error if the within-class covariance of the features is singular.
    pub fn train(table: &FeatureTable, names: &[String], kind: ProjectionKind, shared: Kind) -> Result<Self, Error> {
        let projection = projection::train(table, names, kind)?;
        let projected = table.map(&projection);
        let names: Vec<String> = (1..=projection.matrix.nrows()).map(|k| format!("z{k}")).collect();
        // Priors and costs as in the source: equal priors and uniform costs. The structure has no effect here.
        let recipe = Recipe { discriminant: shared, ..Recipe::new(Structure::new(1, 1, 1, 1, 1)) };
        let density = |rows: &FeatureTable| discriminant::train(rows, &names, &recipe);
        let pairs = (1..table.names.len()).map(|defect| density(&two_classes(&projected, defect)));
        Ok(Self { all: density(&projected)?, pairs: pairs.collect::<Result<_, _>>()?, projection })
    }

    /// Decides on rows with the same features.
    #[must_use]
    pub fn judge(&self, table: &FeatureTable) -> Judged {
        let mut judged = Judged::new(&table.names);
        for (row, &truth) in table.rows.iter().zip(&table.classes) {
            let z = self.projection.apply(row);
            judged.add(truth, Some(self.decide(&z)), |defect| Some(most_likely(&self.pairs[defect - 1], &z)));
        }
        judged
    }

    /// The class decided among all classes, from projected coordinates.
    #[must_use]
    pub fn decide(&self, z: &DVector<f64>) -> usize {
        most_likely(&self.all, z)
    }
}

/// Trains on one set and validates on another; class 0 is healthy.
///
/// # Errors
/// Returns an error if a trace cannot be estimated or the features are singular.
pub fn validate(
    training: &[LabelledTrace],
    validation: &[LabelledTrace],
    classes: &[String],
    order: Structure,
) -> Result<Outcome, Error> {
    let structure = order;
    let chosen = features::choose(structure, &["a".to_string()])?;
    let names: Vec<String> = chosen.iter().map(|&k| features::all_names(structure)[k].clone()).collect();
    let (raw, _) = table(training, classes, structure, &chosen)?;
    let (held_out, fit_percent) = table(validation, classes, structure, &chosen)?;
    let judged = Rule::train(&raw, &names, principal(chosen.len()), Kind::Linear)?.judge(&held_out);
    let (binary_wrong, binary_total) = (judged.binary_wrong(), judged.binary_total());
    Ok(Outcome { all_classes: judged.all_classes, binary_wrong, binary_total, fit_percent })
}

/// The source's projection for this number of features: centred, not standardised, two components.
#[must_use]
pub fn principal(features: usize) -> ProjectionKind {
    ProjectionKind::Pca { keep: Keep::Components(2.min(features)), standardised: false }
}

/// The class of largest likelihood: equal priors and uniform costs, as in the source.
fn most_likely(densities: &GaussianClasses, z: &DVector<f64>) -> usize {
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
    Ok((
        FeatureTable::exact(estimates.iter().map(features::vector).collect(), classes_of, classes.to_vec())
            .select(chosen),
        fit,
    ))
}

/// Rows of class 0 and of one other, relabelled 0 and 1.
fn two_classes(table: &FeatureTable, other: usize) -> FeatureTable {
    let rows = table.rows.iter().zip(&table.classes).filter(|(_, class)| **class == 0 || **class == other);
    let (rows, classes) = rows.map(|(row, &class)| (row.clone(), usize::from(class == other))).unzip();
    FeatureTable::exact(rows, classes, vec![table.names[0].clone(), table.names[other].clone()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(x: f64, y: f64) -> DVector<f64> {
        DVector::from_vec(vec![x, y])
    }

    /// Healthy rows around the origin, one defect along x, one along y.
    fn table() -> FeatureTable {
        let spread = [(-1.0, 0.3), (1.0, -0.2), (0.1, 1.1), (-0.1, -0.9), (0.4, 0.2)];
        let around = |cx: f64, cy: f64| spread.iter().map(move |(x, y)| row(cx + x, cy + y));
        let rows = around(0.0, 0.0).chain(around(9.0, 0.0)).chain(around(0.0, 9.0)).collect();
        let names = ["healthy", "spall", "roughness"].map(String::from).to_vec();
        FeatureTable::exact(rows, [[0; 5], [1; 5], [2; 5]].concat(), names)
    }

    #[test]
    fn a_rotation_of_two_features_changes_no_decision() {
        let names = ["a1", "a2"].map(String::from);
        // One healthy row lies among the spall rows, so that one decision is wrong.
        let mut near = table();
        near.rows[0] = row(8.5, 0.4);
        for kind in [Kind::Linear, Kind::Quadratic] {
            let rotated = Rule::train(&near, &names, principal(2), kind).expect("regular").judge(&near);
            let plain = Rule::train(&near, &names, ProjectionKind::None, kind).expect("regular").judge(&near);
            assert_eq!(rotated, plain);
            assert!(rotated.all_classes.wrong() > 0);
        }
    }

    #[test]
    fn binary_classifiers_see_only_their_two_classes() {
        let mut judged = Judged::new(&table().names);
        judged.add(0, Some(0), |defect| Some(usize::from(defect == 2))); // one of two decisions wrong
        judged.add(0, Some(1), |_| Some(1)); // both decisions wrong, one row
        judged.add(1, Some(1), |defect| Some(usize::from(defect == 1)));
        judged.add(2, Some(2), |_| None); // undetermined counts as wrong
        assert_eq!(judged.pairs.iter().map(Confusion::total).collect::<Vec<_>>(), [3, 3]);
        assert_eq!(judged.rows_wrong, 3);
        assert!((judged.pooled_error() - 4.0 / 6.0).abs() < 1e-15 && (judged.row_error() - 0.75).abs() < 1e-15);
        assert!((judged.pair_error(1) - 1.0 / 3.0).abs() < 1e-15 && judged.pair_error(3).is_nan());
    }
}
