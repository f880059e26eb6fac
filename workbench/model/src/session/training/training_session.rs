//! From settings and traces to a trained model.

use std::path::PathBuf;

use bearing_watch::model::MAX_BLOCK_MEAN;

use super::evidence::Orders;
use super::held_out::{Found, Held, evaluate};
use super::result::{Training, read_by};
use super::temperatures::{Temperatures, Traces, covariates};
use super::{chosen, description, precision};
use crate::Error;
use crate::session::doubts::{codes, contradictory, irregular, refuse_held, refuse_scale, refused};
use crate::session::judging::prepare;
use crate::session::log::Log;
use crate::session::notes::{Notes, content};
use crate::session::selection::{INDEPENDENT, Selection};
use crate::session::source::{Given, TemperatureColumn};
use crate::settings::{Reading, Settings};
use crate::trace::labels::LabelledTrace;
use crate::trace::{Channels, Preparation, trace_name};
use crate::train::{Automatic, Recipe, ShaftPlan, Trained};

/// Settings with labels and channels, whose traces are not read yet.
#[derive(Debug)]
pub struct Session {
    settings: Settings,
    selection: Selection,
    channels: Channels,
    plan: Option<ShaftPlan>,
    preparation: Preparation,
    drive: Option<String>,
    trial: bool,
}

impl Session {
    /// By settings, labels and a source of traces; the text of a drive file goes into the notes of the model.
    ///
    /// # Errors
    /// Settings that are missing, out of range, or do not go together.
    pub fn new(settings: Settings, mut given: Given, drive: Option<String>) -> Result<Self, Error> {
        let Reading { channels, shaft: plan, preparation, .. } = settings.reading(given.front_end.take())?;
        settings.check()?;
        let selection = Selection::new(&settings, given, channels.clone());
        Ok(Self { settings, selection, channels, plan, preparation, drive, trial: false })
    }

    /// The same for a trial, which takes the first recipe that can be trained: it tells in a fraction of the time
    /// whether training refuses.
    #[must_use]
    pub fn of_trial(self) -> Self {
        Self { trial: true, ..self }
    }

    /// Returns the files that are read; no output may replace them.
    #[must_use]
    pub fn inputs(&self) -> Vec<PathBuf> {
        self.selection.inputs()
    }

    /// Reads the traces and trains.
    ///
    /// # Errors
    /// Traces that cannot be read; labels or settings that do not fit them; a training set that does not support what
    /// the settings want.
    pub fn train(&self, log: &Log<'_>) -> Result<Training, Error> {
        log.warn(self.settings.bearing.bearing.note());
        let (named, used) = (self.temperature_columns()?, self.channels.names());
        let (mut temperatures, traces) = Temperatures::of(named, &used, |offered| self.traces(offered))?;
        let taken = temperatures.taken();
        let traces = traces.map_or_else(|| self.traces(&taken), Ok)?;
        log.warn(self.selection.left_out()?);
        log.warn(irregular(traces.training.iter().map(|t| &t.trace)));
        log.warn(refused(traces.training.iter().map(|t| &t.trace)));
        refuse_scale(traces.training.iter().map(|t| &t.trace))?;
        log.warn(contradictory(traces.training.iter().map(|t| &t.trace)));
        log.warn(codes(traces.training.iter().map(|t| &t.trace)));
        traces.training.iter().try_for_each(|t| refuse_held(&t.trace, &traces.recipe.columns))?;
        let mut training = self.trained(traces)?;
        let without = training.trained.automatic.as_ref().and_then(Automatic::without_covariates);
        if let Some(why) = without.filter(|_| !taken.is_empty()) {
            temperatures.refuse(&why);
            training = self.trained(self.traces(&[])?)?;
        }
        training.trained.automatic.iter_mut().for_each(|automatic| automatic.temperatures.clone_from(&temperatures.0));
        chosen::report(&training.trained, &self.settings);
        log.warn(training.doubt.clone());
        log.warn(description::of_host(training.host, &training.description));
        Ok(training)
    }

    /// Reads the traces of training with these temperatures as covariates.
    fn traces(&self, temperatures: &[String]) -> Result<Traces, Error> {
        let Self { settings, selection, channels, plan, preparation, .. } = self;
        let mut channels = channels.clone();
        channels.further.extend_from_slice(temperatures);
        let (classes, training) = selection.rows_of(&settings.validation.train_where, &channels)?;
        ::log::info!("training: {} traces of the classes {}", training.len(), classes.join(", "));
        let groups = selection.groups(&settings.validation, &training)?;
        let [runs, units] = [groups.runs, groups.units].map(Option::unwrap_or_default);
        let validation = settings.validation.folds(runs, units)?;
        let columns = settings.validation.group.is_none().then(|| selection.columns(&training)).transpose()?;
        let validation = crate::train::Validation { columns, doubted: true, ..validation };
        let park = settings.channels.park(&channels)?;
        let recipe = settings.recipe(&classes, plan.clone())?;
        let mut recipe = Recipe { validation, park, columns: channels, trial: self.trial, ..recipe };
        recipe.alarms.by_run = !recipe.validation.groups.is_empty();
        if !temperatures.is_empty() {
            (recipe.covariates, recipe.offered) = (covariates(temperatures), true);
        }
        let prepared = prepare(&training, *preparation)?;
        Ok(Traces { classes, training, prepared, recipe })
    }

    fn trained(&self, traces: Traces) -> Result<Training, Error> {
        let Traces { classes, training, prepared, recipe } = traces;
        let held_out = self.held_out((&classes, &training), &recipe)?;
        let mut trained = crate::train::train(&prepared, &classes, &recipe)?;
        let doubt = precision::doubt(&trained, &prepared);
        precision::agree(&trained, &prepared)?;
        // On the traces as the shaft was trained, before block means move into the detector.
        let orders = Orders::of(&trained, &prepared)?;
        let host = embed_block_mean(&mut trained, self.preparation, &training);
        let channels = read_by(&trained, recipe.columns);
        let description = description::lines(&trained, &channels, host);
        let ids = training.iter().map(|t| trace_name(&t.trace.id).into_owned()).collect();
        let units = &trained.recipe.validation.units;
        let column = self.settings.validation.group.as_ref().filter(|column| *column != INDEPENDENT);
        let notes = Notes::new(&channels, host, &trained, (ids, units), self.drive.clone()).with_group(column);
        let notes = notes.with_contents(training.iter().map(|t| content(&t.trace)).collect());
        let bytes = trained.to_bytes(&notes.to_text())?;
        Ok(Training { trained, bytes, channels, training, prepared, description, host, orders, held_out, notes, doubt })
    }

    /// The columns that are temperatures, if training may take them as covariates: it chooses the features of a shaft,
    /// and no covariates are given.
    fn temperature_columns(&self) -> Result<Vec<TemperatureColumn>, Error> {
        let Self { settings, selection, plan, .. } = self;
        let wanted = plan.is_some() && settings.chooses_features() && settings.model.covariates.is_empty();
        let by = &settings.validation;
        // Held-out traces must have them too.
        let held_out = (!by.test_where.is_empty()).then_some(&by.test_where[..]);
        let all: Vec<_> = std::iter::once(&by.train_where[..]).chain(held_out).collect();
        if wanted { selection.temperatures(&all) } else { Ok(vec![]) }
    }

    /// Evaluates the model on the traces that the settings hold out, if they do; otherwise cross-validates it.
    ///
    /// # Errors
    /// Held-out traces that do not fit; a ranking that cannot be made.
    pub fn found(&self, own: &Training, rank: bool, log: &Log<'_>) -> Result<Found, Error> {
        let trained = &own.trained;
        let held_out = own.held_out.as_ref().map(|held_out| evaluate(held_out, own, log)).transpose()?;
        Ok(Found {
            cross_validated: held_out.is_none().then(|| trained.cross_validated()),
            false_alarms: if held_out.is_none() { trained.false_alarms() } else { None },
            forward: if held_out.is_none() { trained.forward() } else { vec![] },
            ranking: rank.then(|| trained.rank()).transpose()?,
            held_out,
        })
    }

    /// Reads the traces of `test_where`; those of training, and units of theirs, are refused.
    fn held_out(
        &self,
        (classes, training): (&[String], &[LabelledTrace]),
        recipe: &Recipe,
    ) -> Result<Option<Held>, Error> {
        let Self { settings, selection, .. } = self;
        if settings.validation.test_where.is_empty() {
            return Ok(None);
        }
        let (names, mut traces) = selection.rows_of(&settings.validation.test_where, &recipe.columns)?;
        for held_out in &mut traces {
            let name = &names[held_out.class];
            held_out.class = classes.iter().position(|class| class == name).ok_or_else(|| {
                Error::Usage(format!("--test-where selects class {name}, which has no training traces"))
            })?;
        }
        if let Some(both) = traces.iter().find(|t| training.iter().any(|s| s.trace.id == t.trace.id)) {
            let id = &both.trace.id;
            return Err(Error::Usage(format!(
                "trace {id} is in both --train-where and --test-where; make them disjoint"
            )));
        }
        let groups = selection.groups(&settings.validation, &traces)?;
        groups.refuse_known(&recipe.validation.units)?;
        Ok(Some((traces, groups)))
    }
}

/// Moves the block means into the detector if no decimation follows them; returns the preparation that remains on the
/// host.
fn embed_block_mean(trained: &mut Trained, preparation: Preparation, training: &[LabelledTrace]) -> Preparation {
    if preparation.decimate > 1 || preparation.block_mean > usize::from(MAX_BLOCK_MEAN) {
        return preparation;
    }
    trained.block_mean = preparation.block_mean;
    trained.interval_s = training.iter().find_map(|t| t.trace.interval_s).unwrap_or(0.0);
    Preparation::NONE
}
