//! The sizes of defects that the gate of a recipe finds, cross-validated.
//!
//! ```text
//! ln s₅₀ = ln s₁ + ln 2 (Σ_k (1 − p_k) − ½)                                                        (1)
//! ```
//!
//! p_k is the share of the records with a defect of size s_k that is found, sizes in steps of two. (1) is the mean
//! logarithm of the smallest size that is found (Spearman and Kärber): the size found in half of the records. It uses
//! all sizes, so that it scatters less than the size at which a curve passes one half.

use std::f64::consts::LN_2;

use rayon::prelude::*;
use statrs::distribution::{Binomial, DiscreteCDF};

use super::defects::Added;
use super::why::Detected;
use crate::Error;
use crate::train::classifier::fit::{self, Fitted};
use crate::train::estimates::{Estimates, Used};
use crate::train::novelty::{Gate, Rows, required_gate};
use crate::train::{Candidates, Explained, FeatureTable, Folds, Recipe, Validation};

/// Folds: more would take longer, and the gate of four fifths of the traces is nearly that of all.
const FOLDS: usize = 5;
/// A gate has more false alarms than set if so many or more have a probability below this.
const TOO_MANY: f64 = 0.001;

/// What the gate of a recipe finds.
pub(super) struct Power {
    /// Rate of healthy segments called novel.
    pub(super) rate: f64,
    /// Whether that is not clearly more than set.
    pub(super) keeps_rate: bool,
    /// By kind of defect.
    pub(super) detected: Vec<Detected>,
    /// Mean of (1) over the kinds.
    pub(super) log_size: f64,
    /// Whether the gates have not seen the segments that they judge.
    pub(super) held_out: bool,
}

/// A gate with the map to its coordinates.
struct Judge {
    fitted: Fitted,
    gate: Gate,
}

impl Judge {
    fn of(seen: &Candidates, recipe: &Recipe) -> Result<Self, Error> {
        let fitted = fit::fit(seen, recipe)?;
        let (table, names) = (&fitted.coordinates, &fitted.coordinate_names[..]);
        let coefficients = fitted.explained.as_ref().map_or(0, Explained::fitted);
        let rows = Rows { table, names, fitted: coefficients, rising: recipe.rising(names) };
        let gate = required_gate(rows, recipe.runs(seen).as_deref(), &recipe.alarms)?;
        Ok(Self { fitted, gate })
    }

    fn is_novel(&self, rows: &Candidates, row: usize) -> bool {
        let (value, variance) = self.fitted.coordinates_of(rows, row);
        self.gate.is_novel(&value, &variance)
    }
}

/// Whether the gate of a recipe can be trained.
pub(super) fn is_possible(own: &Estimates<'_>, recipe: &Recipe) -> bool {
    own.rows_of(recipe)
        .is_ok_and(|Used { candidates, chosen, .. }| Judge::of(&candidates.select(&chosen), recipe).is_ok())
}

/// Judges a recipe.
///
/// # Errors
/// A gate cannot be trained on all healthy segments.
pub(super) fn of(own: &Estimates<'_>, recipe: &Recipe, defects: &[Added]) -> Result<Power, Error> {
    let Used { candidates, chosen, explaining, origins, .. } = own.rows_of(recipe)?;
    let healthy = candidates.select(&chosen);
    let validation = Validation { folds: FOLDS, ..recipe.validation.clone() };
    let whole = Judge::of(&healthy, recipe)?;
    // Fewer rows may be too few for the rate: then the gate of all judges what it has seen, of every recipe alike.
    let folds = Folds::new(&healthy, &validation).ok();
    let held_out = folds.as_ref().and_then(|folds| {
        let judge = |fold: usize| Judge::of(&healthy.rows(&folds.split(fold).0), recipe).ok();
        (0..folds.count).into_par_iter().map(judge).collect::<Option<Vec<_>>>()
    });
    let judge = |row: usize| match (&held_out, &folds) {
        (Some(judges), Some(folds)) => &judges[folds.of_row[row]],
        _ => &whole,
    };
    let all = healthy.table.rows.len();
    let novel = (0..all).filter(|&row| judge(row).is_novel(&healthy, row)).count();
    // The judge of a record is that of its healthy twin.
    let twin = |trace: usize| origins.iter().position(|own| *own == trace);
    let of_kind = |added: &Added| {
        let share = |(table, of_row): &(FeatureTable, Vec<usize>)| {
            let covariates = (!explaining.is_empty()).then(|| table.select(&explaining));
            let groups = vec![0; table.rows.len()];
            let features = healthy.features.clone();
            let rows = Candidates { table: table.select(&chosen), features, groups, covariates };
            let judged = |row: usize| Some(judge(twin(of_row[row])?).is_novel(&rows, row));
            let judged: Vec<bool> = (0..of_row.len()).filter_map(judged).collect();
            judged.iter().filter(|novel| **novel).count() as f64 / judged.len().max(1) as f64
        };
        let found: Vec<f64> = added.tables.iter().map(share).collect();
        let missed: f64 = found.iter().map(|found| 1.0 - found).sum();
        let half_a = added.sizes.first().copied().unwrap_or(0.0) * (LN_2 * (missed - 0.5)).exp();
        Detected { kind: added.name.clone(), sizes_a: added.sizes.clone(), found, half_a }
    };
    let detected: Vec<Detected> = defects.iter().map(of_kind).collect();
    let weights: f64 = defects.iter().map(|own| own.weight).sum();
    let log_size = detected.iter().zip(defects).map(|(own, added)| added.weight * own.half_a.ln()).sum::<f64>();
    let least = Binomial::new(recipe.alarms.false_alarm, all as u64)
        .map_or(1.0, |law| if novel == 0 { 1.0 } else { law.sf(novel as u64 - 1) });
    let rate = novel as f64 / all.max(1) as f64;
    let keeps_rate = least > TOO_MANY;
    Ok(Power { rate, keeps_rate, detected, log_size: log_size / weights.max(1e-9), held_out: held_out.is_some() })
}
