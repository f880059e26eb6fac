//! What covariates explain of the features of healthy segments.
//!
//! ```text
//! f = μ + Σ_k (a_k c_k + b_k c_k²) + e,   c = z − z̄,   var e = σ² + v,   v the variance of the feature's error    (1)
//! ```
//!
//! (1) is fitted to the healthy rows alone, each feature by itself, by least squares with the weights 1/(σ² + v); σ² is
//! the weighted mean of the squared residuals less v. Rows without the feature are left out. The least significant
//! coefficient is set to zero and the rest refitted until all are significant: two-sided t test at 1 % divided by the
//! number of all coefficients (Bonferroni). A linear term stays beside its square. If the runs of the rows are known
//! and count ([`Alarms::by_run`](crate::train::Alarms::by_run)), rows of one run have a common error: the covariance of
//! the coefficients is then that of clusters (Liang and Zeger 1986), with as many degrees of freedom as runs less the
//! coefficients.
//!
//! Rows of all classes are corrected by (1), as the core does
//! ([`Covariates`](bearing_watch::model::Covariates)): a feature is missing if a covariate that explains it is outside
//! the range of the healthy rows. Every fold of a cross-validation fits its own (1).

use bearing_watch::model::{Covariate, Covariates, Feature, FeatureValue};
use bearing_watch::plan::RunTime;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::Error;
use crate::core::features::Catalogue;
use crate::train::{Candidates, FeatureTable, Recipe};

/// Probability that any coefficient is called significant if the covariates explain nothing.
const LEVEL: f64 = 0.01;
/// Least part of the residual variance that does not come from the known errors.
const LEAST_PART: f64 = 1e-3;

/// A coefficient with its standard error; both 0 if it is not significant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficient {
    /// a or b of (1).
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// One covariate over the healthy rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Explaining {
    /// Name of the feature z.
    pub name: String,
    /// Mean z̄.
    pub centre: f64,
    /// Least and largest value.
    pub range: [f64; 2],
    /// Usual variance of its error.
    pub usual: f64,
    /// Numbers of healthy rows in the lowest and in the highest tenth of the range.
    pub at_ends: [usize; 2],
}

/// What the covariates explain.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained {
    /// The covariates.
    pub covariates: Vec<Explaining>,
    /// Names of the features.
    pub features: Vec<String>,
    /// a and b of each feature and covariate.
    pub map: Vec<Vec<[Coefficient; 2]>>,
    /// Part of each feature's variance, without its known errors, that the covariates explain.
    pub parts: Vec<f64>,
    /// Number of healthy rows.
    pub rows: usize,
}

/// Rows of one feature: value, variance of its error, departures of the covariates, and run.
type Rows = Vec<(f64, f64, Vec<f64>, usize)>;

/// A term of (1): covariate, and degree less one.
type Term = (usize, usize);

/// A fit of some terms: their coefficients, and σ².
struct Fit {
    coefficients: Vec<Coefficient>,
    variance: f64,
    degrees: f64,
}

/// Fits (1) to the healthy rows; `None` without covariates.
///
/// # Errors
/// No healthy class; a covariate that is constant or depends on others; too few rows or runs.
pub(crate) fn fit(candidates: &Candidates, recipe: &Recipe) -> Result<Option<Explained>, Error> {
    let Some(table) = &candidates.covariates else { return Ok(None) };
    let Some(healthy) = recipe.alarms.healthy else {
        return Err(Error::Usage("--covariates needs --healthy: healthy traces tell what they explain".into()));
    };
    let complete = |row: &usize| table.variances[*row].iter().all(|variance| variance.is_finite());
    let rows: Vec<usize> = (0..table.rows.len()).filter(|&row| table.classes[row] == healthy).collect();
    let rows: Vec<usize> = rows.into_iter().filter(complete).collect();
    let each = |(k, name): (usize, &String)| explaining(table, &rows, (k, name));
    let covariates: Vec<Explaining> = recipe.covariates.iter().enumerate().map(each).collect::<Result<_, _>>()?;
    let runs = recipe.runs(candidates);
    let tests = candidates.features.len() * 2 * covariates.len();
    let (mut map, mut parts) = (vec![], vec![]);
    for (k, name) in candidates.features.iter().enumerate() {
        let own = rows.iter().filter(|&&row| candidates.table.variances[row][k].is_finite());
        let own: Rows = own
            .map(|&row| {
                let away = covariates.iter().zip(table.rows[row].iter()).map(|(own, z)| own.scaled(*z)).collect();
                let (value, variance) = (candidates.table.rows[row][k], candidates.table.variances[row][k]);
                (value, variance, away, runs.as_ref().map_or(row, |runs| runs[row]))
            })
            .collect();
        // A feature does not explain itself.
        let other = (0..covariates.len()).filter(|&v| covariates[v].name != *name);
        let terms: Vec<Term> = other.flat_map(|v| [(v, 0), (v, 1)]).collect();
        let (terms, fit, part) = significant(&own, terms, runs.is_some(), LEVEL / tests.max(1) as f64)
            .map_err(|problem| Error::Training(format!("covariates of feature {name}: {problem}")))?;
        let mut row = vec![[Coefficient::default(); 2]; covariates.len()];
        for ((v, degree), Coefficient { value, error }) in terms.into_iter().zip(fit.coefficients.into_iter().skip(1)) {
            let unit = covariates[v].unit().powi(degree as i32 + 1);
            row[v][degree] = Coefficient { value: value / unit, error: error / unit };
        }
        map.push(row);
        parts.push(part);
    }
    Ok(Some(Explained { covariates, features: candidates.features.clone(), map, parts, rows: rows.len() }))
}

/// Whether values differ, also in single precision.
pub(crate) fn varies(values: impl Iterator<Item = f64>) -> bool {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    high - low > 1e-6 * low.abs().max(high.abs())
}

fn explaining(table: &FeatureTable, rows: &[usize], (k, name): (usize, &String)) -> Result<Explaining, Error> {
    let values: Vec<f64> = rows.iter().map(|&row| table.rows[row][k]).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !varies(values.iter().copied()) {
        return Err(Error::Training(format!("covariate {name} is the same in all healthy traces; leave it out")));
    }
    let centre = values.iter().sum::<f64>() / values.len() as f64;
    let part = |z: &&f64| (**z - low) / (high - low);
    let at_ends = [values.iter().filter(|z| part(z) <= 0.1).count(), values.iter().filter(|z| part(z) >= 0.9).count()];
    Ok(Explaining { name: name.clone(), centre, range: [low, high], usual: table.usual[k], at_ends })
}

/// Removes terms until all are significant; returns the rest with their fit, and the part of the variance explained.
fn significant(rows: &Rows, mut terms: Vec<Term>, by_run: bool, level: f64) -> Result<(Vec<Term>, Fit, f64), String> {
    let alone = least_squares(rows, &[], false)?;
    loop {
        let fit = least_squares(rows, &terms, by_run)?;
        let law = StudentsT::new(0.0, 1.0, fit.degrees).map_err(|_| "no degrees of freedom".to_string())?;
        let chance = |own: &Coefficient| 2.0 * law.sf((own.value / own.error).abs());
        let removable = |place: &usize| {
            let (v, degree) = terms[*place];
            degree == 1 || !terms.contains(&(v, 1))
        };
        let of = |place: usize| (place, chance(&fit.coefficients[place + 1]));
        let weakest = (0..terms.len()).filter(removable).map(of).max_by(|a, b| a.1.total_cmp(&b.1));
        match weakest.filter(|(_, chance)| *chance > level) {
            Some((place, _)) => drop(terms.remove(place)),
            None => {
                let part = if terms.is_empty() { 0.0 } else { (1.0 - fit.variance / alone.variance).max(0.0) };
                return Ok((terms, fit, part));
            }
        }
    }
}

/// Least squares of a constant and these terms.
fn least_squares(rows: &Rows, terms: &[Term], by_run: bool) -> Result<Fit, String> {
    let p = terms.len() + 1;
    let mut runs: Vec<usize> = rows.iter().map(|(.., run)| *run).collect();
    runs.sort_unstable();
    runs.dedup();
    let (counted, what) = if by_run { (runs.len(), "runs") } else { (rows.len(), "segments") };
    if counted < p + 2 {
        return Err(format!(
            "{counted} healthy {what} are too few for {} coefficients; give at least {}",
            p - 1,
            p + 2
        ));
    }
    let design = DMatrix::from_fn(rows.len(), p, |row, place| match place.checked_sub(1).map(|k| terms[k]) {
        None => 1.0,
        Some((v, degree)) => rows[row].2[v].powi(degree as i32 + 1),
    });
    let values = DVector::from_iterator(rows.len(), rows.iter().map(|(value, ..)| *value));
    let scale = rows.len() as f64 / (rows.len() - p) as f64;
    let (mut weights, mut variance) = (DVector::repeat(rows.len(), 1.0), f64::NAN);
    let (mut inverse, mut found, mut residual) = (DMatrix::zeros(p, p), DVector::zeros(p), values.clone());
    // A fixed point; without errors the second pass repeats the first.
    for _ in 0..20 {
        let weighted = DMatrix::from_fn(rows.len(), p, |row, k| weights[row] * design[(row, k)]);
        let normal = design.transpose() * &weighted;
        let regular = normal.clone().cholesky().filter(|factor| {
            let (factor, n) = (factor.l(), &normal);
            (0..p).all(|k| factor[(k, k)].powi(2) > 1e-9 * n[(k, k)])
        });
        let factor = regular.ok_or("the covariates depend on each other; leave one out")?;
        inverse = factor.inverse();
        found = &inverse * (weighted.transpose() * &values);
        residual = &values - &design * &found;
        let squares = residual.iter().zip(rows).zip(weights.iter());
        let (mut sum, mut total, mut plain) = (0.0, 0.0, 0.0);
        for ((r, (_, v, ..)), w) in squares {
            sum += w * w * (r * r * scale - v);
            total += w * w;
            plain += w * w * r * r * scale;
        }
        variance = (sum / total).max(LEAST_PART * plain / total).max(f64::MIN_POSITIVE);
        weights = DVector::from_iterator(rows.len(), rows.iter().map(|(_, v, ..)| 1.0 / (variance + v)));
    }
    let weighted = DMatrix::from_fn(rows.len(), p, |row, k| weights[row] * design[(row, k)]);
    let own = (design.transpose() * &weighted).cholesky().map(|factor| factor.inverse()).unwrap_or(inverse);
    let covariance = if by_run {
        let mut middle = DMatrix::zeros(p, p);
        for run in &runs {
            let places = (0..rows.len()).filter(|&row| rows[row].3 == *run);
            let score: DVector<f64> =
                places.fold(DVector::zeros(p), |sum, row| sum + weighted.row(row).transpose() * residual[row]);
            middle += &score * score.transpose();
        }
        let count = runs.len() as f64;
        &own * middle * &own * (count / (count - p as f64))
    } else {
        own
    };
    let coefficient = |k: usize| Coefficient { value: found[k], error: covariance[(k, k)].max(0.0).sqrt() };
    let coefficients = (0..p).map(coefficient).collect();
    Ok(Fit { coefficients, variance, degrees: (counted - p) as f64 })
}

impl Explaining {
    /// Half of the range; departures in this unit keep the columns alike.
    fn unit(&self) -> f64 {
        0.5 * (self.range[1] - self.range[0])
    }

    fn scaled(&self, z: f64) -> f64 {
        (z - self.centre) / self.unit()
    }

    /// The covariate as the core has it.
    fn core(&self, feature: Feature) -> Covariate {
        let [low, high] = self.range.map(|x| x as f32);
        Covariate { feature, centre: self.centre as f32, low, high, usual: self.usual as f32 }
    }
}

impl Explained {
    /// Number of coefficients that were fitted to the feature with the most of them.
    #[must_use]
    pub fn fitted(&self) -> usize {
        let of_row = |row: &Vec<[Coefficient; 2]>| row.iter().flatten().filter(|own| own.error > 0.0).count();
        self.map.iter().map(of_row).max().unwrap_or(0)
    }

    /// The features of all rows without what the covariates explain.
    pub(crate) fn corrected(&self, candidates: &Candidates) -> FeatureTable {
        let mut table = candidates.table.clone();
        for row in 0..table.rows.len() {
            (table.rows[row], table.variances[row]) = self.corrected_row(candidates, row);
        }
        table
    }

    /// The features of one row, by the rules of the core.
    pub(crate) fn corrected_row(&self, candidates: &Candidates, row: usize) -> (DVector<f64>, DVector<f64>) {
        let (mut value, mut variance) = (candidates.table.rows[row].clone(), candidates.table.variances[row].clone());
        let Some(table) = &candidates.covariates else { return (value, variance) };
        for (v, own) in self.covariates.iter().enumerate() {
            let (z, error) = (table.rows[row][v], table.variances[row][v]);
            // The core's own test; the values stay in double precision.
            let place = FeatureValue { value: z as f32, variance: (error + own.usual) as f32 };
            let inside = !own.core(Feature::LogVariance).departure(place).is_missing();
            for (k, coefficients) in self.map.iter().enumerate() {
                let [a, b] = coefficients[v].map(|own| own.value);
                if a == 0.0 && b == 0.0 {
                    continue;
                }
                let c = z - own.centre;
                value[k] -= (a + b * c) * c;
                variance[k] += if inside { (a + 2.0 * b * c).powi(2) * error } else { f64::INFINITY };
            }
        }
        for k in 0..value.len() {
            value[k] = if variance[k].is_finite() { value[k] } else { 0.0 };
        }
        (value, variance)
    }

    /// The covariates of the core, whose features are those of δ at the places `used`; the explained features are the
    /// `chosen` raw ones.
    pub(crate) fn core(&self, catalogue: &Catalogue, chosen: &[usize], used: &[usize]) -> Covariates<RunTime> {
        let names = catalogue.names();
        let list = self.covariates.iter().filter_map(|own| {
            let place = names.iter().position(|name| *name == own.name)?;
            Some(own.core(catalogue.core_feature(place)))
        });
        let zero = catalogue.delta_from_raw(&DVector::zeros(names.len()));
        let column = |v: usize, degree: usize| {
            let mut raw = DVector::zeros(names.len());
            chosen.iter().zip(&self.map).for_each(|(&place, row)| raw[place] = row[v][degree].value);
            let delta = catalogue.delta_from_raw(&raw) - &zero;
            used.iter().map(|&place| delta[place] as f32).collect::<Vec<f32>>()
        };
        let columns: Vec<[Vec<f32>; 2]> = (0..self.covariates.len()).map(|v| [column(v, 0), column(v, 1)]).collect();
        let map = (0..used.len()).flat_map(|k| columns.iter().map(move |[a, b]| [a[k], b[k]])).collect();
        Covariates { list: list.collect(), map }
    }

    /// One line for each covariate and each feature that they explain.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let range = |own: &Explaining| {
            let ([low, high], [first, last]) = (own.range, own.at_ends);
            format!(
                "covariate {}: healthy range {low:.4} to {high:.4}, mean {:.4}; {first} and {last} of {} healthy \
                 segments in its lowest and highest tenth",
                own.name, own.centre, self.rows
            )
        };
        let feature = |(k, name): (usize, &String)| {
            let by = self.covariates.iter().zip(&self.map[k]);
            let terms = by.flat_map(|(own, [a, b])| {
                let one = format!("({} − {:.4})", own.name, own.centre);
                [(a, one.clone()), (b, one + "²")]
            });
            let terms = terms.filter(|(own, _)| own.error > 0.0);
            let terms: Vec<String> =
                terms.map(|(own, what)| format!("{:.3e} ± {:.1e} · {what}", own.value, own.error)).collect();
            match terms.is_empty() {
                true => format!("{name}: not explained by the covariates"),
                false => format!("{name}: {}; {:.0} % of its variance", terms.join(" + "), 100.0 * self.parts[k]),
            }
        };
        self.covariates.iter().map(range).chain(self.features.iter().enumerate().map(feature)).collect()
    }
}

#[cfg(test)]
mod tests;
