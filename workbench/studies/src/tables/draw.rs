//! Traces and estimates of one repetition, computed once and shared by all tables.

use std::cell::RefCell;
use std::rc::Rc;

use nalgebra::DVector;
use rayon::prelude::*;

use super::ours;
use super::published::{TRACES_CHAPTER_3, TRACES_CHAPTER_4};
use super::recorded::{Recorded, Selection};
use crate::demo::{CLASSES, FirstInput};
use crate::literal::Judged;
use model::Error;
use model::core::features;
use model::identify::{Method, Structure, estimate};
use model::train::FeatureTable;
use rig::{Defect, Scenario, simulate, trace_seed};

/// Input, structure and method of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Model {
    /// Choice of u1.
    pub input: FirstInput,
    /// Structure vector; no constant term.
    pub order: Structure,
    /// Estimator.
    pub method: Method,
}

impl Model {
    /// The structure of the model.
    #[must_use]
    pub const fn structure(&self) -> Structure {
        self.order
    }
}

/// The part of an estimate that the tables need.
#[derive(Clone, Debug)]
pub struct Estimated {
    /// Class of the trace.
    pub class: usize,
    /// All raw features.
    pub features: DVector<f64>,
    /// Standard deviations of the parameters, computed by the estimate itself.
    pub deviations: Vec<f64>,
    /// Fit (Eq. 3.2) on the trace of the estimate, %.
    pub fit_percent: f64,
}

/// Estimates of training and validation traces.
#[derive(Clone, Debug)]
pub struct Estimates {
    /// Estimates of the training set.
    pub training: Vec<Estimated>,
    /// Estimates of the validation set.
    pub validation: Vec<Estimated>,
}

/// One draw of a training and a validation set.
#[derive(Debug)]
pub struct Draw {
    /// Training traces, ordered by class.
    pub training: Vec<Recorded>,
    /// Validation traces, ordered by class.
    pub validation: Vec<Recorded>,
    known: RefCell<Vec<(Model, Rc<Estimates>)>>,
    ours: RefCell<Vec<(Selection, Judged)>>,
}

impl Draw {
    /// Simulates the sets of two seeds. Chapter 3 needs more traces of the first two classes.
    ///
    /// # Errors
    /// Returns an error if the rig refuses the scenario.
    pub fn new((training, validation): (u32, u32), chapter_3: bool) -> Result<Self, Error> {
        let count = |class| {
            if chapter_3 && class < Selection::CHAPTER_3.classes { TRACES_CHAPTER_3 } else { TRACES_CHAPTER_4 }
        };
        let jobs: Vec<(usize, u32)> =
            (0..CLASSES.len()).flat_map(|class| (0..count(class)).map(move |k| (class, k))).collect();
        let simulated = |set: u32| -> Result<Vec<Recorded>, Error> {
            let each = |&(class, k): &(usize, u32)| {
                let kind = CLASSES[class];
                let scenario = Scenario::STANDARD.with_defect(Defect::full(kind));
                let signals = simulate(&scenario, trace_seed(set, kind, k)).map_err(Error::other)?;
                Ok(Recorded { id: format!("{}_{set}_{k:03}", kind.name()), class, signals })
            };
            jobs.par_iter().map(each).collect()
        };
        let (training, validation) = (simulated(training)?, simulated(validation)?);
        Ok(Self { training, validation, known: RefCell::default(), ours: RefCell::default() })
    }

    /// Estimates of all traces, computed at the first call.
    ///
    /// # Errors
    /// Returns an error if a trace cannot be estimated.
    pub fn estimates(&self, model: Model) -> Result<Rc<Estimates>, Error> {
        if let Some((_, known)) = self.known.borrow().iter().find(|(known, _)| *known == model) {
            return Ok(Rc::clone(known));
        }
        let set = |recorded: &[Recorded]| -> Result<Vec<Estimated>, Error> {
            // The results are collected first, so that the returned error is always that of the first bad trace.
            let all: Vec<_> = recorded.par_iter().map(|r| estimated(r, model)).collect();
            all.into_iter().collect()
        };
        let made = Rc::new(Estimates { training: set(&self.training)?, validation: set(&self.validation)? });
        self.known.borrow_mut().push((model, Rc::clone(&made)));
        Ok(made)
    }

    /// Decisions of our method on a selection, computed at the first call.
    ///
    /// # Errors
    /// Returns an error if our method fails.
    pub fn ours(&self, selection: Selection) -> Result<Judged, Error> {
        if let Some((_, known)) = self.ours.borrow().iter().find(|(known, _)| *known == selection) {
            return Ok(known.clone());
        }
        let made = ours::judge(&self.training, &self.validation, selection)?;
        self.ours.borrow_mut().push((selection, made.clone()));
        Ok(made)
    }
}

fn estimated(recorded: &Recorded, model: Model) -> Result<Estimated, Error> {
    let estimate = estimate(&recorded.labelled(model.input).trace, model.structure(), model.method)?;
    Ok(Estimated {
        class: recorded.class,
        features: features::vector(&estimate),
        deviations: estimate.deviations(),
        fit_percent: estimate.fit_percent,
    })
}

impl Estimates {
    /// Training and validation rows of a selection with the given features.
    #[must_use]
    pub fn tables(&self, selection: Selection, features: &[usize]) -> [FeatureTable; 2] {
        [&self.training, &self.validation].map(|set| {
            let picked = selection.pick(set, |e| e.class);
            let rows = picked.iter().map(|e| e.features.clone()).collect();
            let classes = picked.iter().map(|e| e.class).collect();
            FeatureTable::exact(rows, classes, selection.names()).select(features)
        })
    }

    /// Mean fit of the healthy validation traces of the selection, each with its own model, %.
    #[must_use]
    pub fn healthy_fit(&self, selection: Selection) -> f64 {
        let picked = selection.pick(&self.validation, |e| e.class);
        let fits: Vec<f64> = picked.iter().filter(|e| e.class == 0).map(|e| e.fit_percent).collect();
        fits.iter().sum::<f64>() / fits.len() as f64
    }
}

/// Names and indices of the selected features of a model: groups a, b, c or single names.
///
/// # Errors
/// Returns an error for a name that the model does not have.
pub fn choose(model: Model, asked: &[&str]) -> Result<(Vec<String>, Vec<usize>), Error> {
    let asked: Vec<String> = asked.iter().map(ToString::to_string).collect();
    let places = features::choose(model.structure(), &asked)?;
    let all = features::all_names(model.structure());
    Ok((places.iter().map(|&k| all[k].clone()).collect(), places))
}
