//! What the healthy traces let a detector use.

use crate::train::estimates::Estimates;
use crate::train::{Axis, ShaftPlan};

/// A feature is used if so many of the healthy segments have it.
const PART: f64 = 0.5;

/// What the healthy traces let a detector use.
#[derive(Debug)]
pub(super) struct Situation {
    /// Names of the features that most healthy segments have, and that differ between them.
    usable: Vec<String>,
    /// Whether the load is measured, and not constant.
    pub(super) load: bool,
    /// Scores of the tracked orders that are usable.
    pub(super) orders: Vec<String>,
    /// What is left out and why, in words.
    pub(super) notes: Vec<String>,
}

impl Situation {
    pub(super) fn of(own: &Estimates<'_>) -> Self {
        let healthy = own.sound();
        let table = &own.estimated.candidates.table;
        let rows = table.classes.iter().filter(|class| **class == healthy).count();
        let names = own.catalogue.names();
        let differs = |feature: usize| {
            let values = || table.with(healthy, feature).map(|row| table.rows[row][feature]);
            let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            high - low > 1e-9 * high.abs().max(low.abs())
        };
        let is_usable =
            |feature: &usize| table.with(healthy, *feature).count() as f64 >= PART * rows as f64 && differs(*feature);
        let usable: Vec<String> = (0..names.len()).filter(is_usable).map(|k| names[k].clone()).collect();
        let measured = own.recipe.shaft.as_ref().is_some_and(|plan| plan.load);
        let varies = own.traces.iter().filter_map(|own| own.trace.motion.as_ref()).any(|motion| {
            let finite = || motion.load_nm.iter().copied().filter(|x| x.is_finite());
            finite().fold(f64::INFINITY, f64::min) < finite().fold(f64::NEG_INFINITY, f64::max)
        });
        let mut notes = vec![];
        let plan = own.recipe.shaft.as_ref();
        if let Some(Axis::Carries(weight)) = plan.map(|plan| plan.axis) {
            notes.push(weight.words());
        } else if !measured {
            notes.push("no load is measured: friction contains it".to_string());
        } else if !varies {
            notes.push("the load is constant: torque constant and friction with load are not told".to_string());
        }
        let tracked = own.recipe.shaft.iter().flat_map(ShaftPlan::names).map(|name| format!("order_{name}"));
        let orders = tracked.filter(|score| usable.contains(score)).collect();
        Self { usable, load: measured && varies, orders, notes }
    }

    /// Returns those of the features that are usable.
    pub(super) fn keep(&self, features: &[&str]) -> Vec<String> {
        features.iter().filter(|name| self.usable.iter().any(|own| own == *name)).map(ToString::to_string).collect()
    }

    /// Returns what follows temperature and load, and no defect: the gate judges other features given these.
    pub(super) fn around(&self) -> &'static [&'static str] {
        if self.load { &["inverse_kt", "load_friction"] } else { &[] }
    }
}
