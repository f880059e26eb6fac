//! Training as the command and programs that call the workbench share it: traces and settings in, the bytes of a model
//! out.

mod held_out;
mod settings;
pub(super) mod words;

use bearing_watch::model::MAX_BLOCK_MEAN;

use super::args::classifier::Averages;
use super::args::traces::{Given, Groups, Selection, warn_irregular, warn_refused};
use super::description;
use super::evidence::Orders;
use super::model_file::{Notes, prepare};
use super::output;
use model::Error;
use model::evaluate::{self, TraceVerdict};
use model::trace::labels::LabelledTrace;
use model::trace::{Channels, Preparation, stem};
use model::train::c_header::c_header;
use model::train::commissioning_source::commissioning_source;
use model::train::front_end_source::front_end_source;
use model::train::{Recipe, ShaftPlan, Trained, VelocitySource, export};

pub(super) use held_out::{Found, HeldOut};
pub(super) use settings::Settings;

/// A trained model with the traces that it was trained on.
#[derive(Debug)]
pub struct Training {
    /// The model.
    pub trained: Trained,
    /// The model file.
    pub bytes: Vec<u8>,
    /// The columns that it reads.
    pub channels: Channels,
    /// The training traces as recorded.
    pub training: Vec<LabelledTrace>,
    /// The training traces as the model was trained on them.
    pub prepared: Vec<LabelledTrace>,
    /// Comment lines for exported sources.
    description: Vec<String>,
    /// What remains to be done before the detector.
    host: Preparation,
    pub(super) orders: Option<Orders>,
    /// Traces that the settings hold out.
    held_out: Option<(Vec<LabelledTrace>, Groups)>,
}

/// Settings whose labels and channels are read, and whose traces are not.
#[derive(Debug)]
pub(super) struct Session {
    settings: Settings,
    pub(super) selection: Selection,
    channels: Channels,
    plan: Option<ShaftPlan>,
    preparation: Preparation,
}

impl Settings {
    /// Reads labels and channels; what is given in memory takes the place of files.
    pub(super) fn session(&self, given: Given) -> Result<Session, Error> {
        self.channels.require(self.structure.structure())?;
        let mut channels = self.channels.channels()?;
        let (shaft_channels, plan) = self.shaft.shaft(&channels.y)?.unzip();
        channels.shaft = shaft_channels;
        let preparation = self.preparation.preparation()?;
        let averages = Averages { features: &self.classifier.features, covariates: &self.covariates };
        channels = averages.columns((self.structure.structure(), plan.as_ref()), channels, preparation)?;
        self.classifier.check()?;
        let selection = self.selection.read(&channels, given)?;
        Ok(Session { settings: self.clone(), selection, channels, plan, preparation })
    }
}

impl Session {
    /// Reads the traces and trains.
    pub(super) fn train(&self) -> Result<Training, Error> {
        let Self { settings, selection, channels, plan, preparation } = self;
        let (classes, training) = selection.rows(&settings.train_where)?;
        warn_irregular(training.iter().map(|t| &t.trace));
        warn_refused(training.iter().map(|t| &t.trace));
        let validation = settings.validation.validation(selection, &training)?;
        let held_out = self.held_out((&classes, &training), &validation.units)?;
        let park = settings.park.of(channels)?;
        let recipe = settings.recipe(&classes, plan.clone())?;
        let mut recipe = Recipe { validation, park, columns: channels.clone(), ..recipe };
        recipe.alarms.by_run = !recipe.validation.groups.is_empty();
        let prepared = prepare(&training, *preparation)?;
        let mut trained = model::train::train(&prepared, &classes, &recipe)?;
        // On the traces as the shaft was trained, before block means move into the detector.
        let orders = Orders::of(&trained, &prepared)?;
        let host = embed_block_mean(&mut trained, *preparation, &training);
        let channels = read_by(&trained, channels.clone());
        let description = description::lines(&trained, &channels, host);
        if host != Preparation::NONE {
            output::warn(format!("the detector does not decimate: {}", description[3]));
        }
        let ids = training.iter().map(|t| stem(&t.trace.id).to_string()).collect();
        let notes = Notes::new(&channels, host, &trained, (ids, &trained.recipe.validation.units));
        let bytes = trained.to_bytes(&notes.to_text())?;
        Ok(Training { trained, bytes, channels, training, prepared, description, host, orders, held_out })
    }
}

impl Training {
    /// Verdicts of the embedded detector on the training traces.
    ///
    /// # Errors
    /// The core rejects the model.
    pub fn seen(&self) -> Result<Vec<TraceVerdict>, Error> {
        evaluate::run(&self.trained.embed()?, &prepare(&self.training, self.host)?, || {})
    }

    /// The model as Rust source, with the front end that its recordings passed and the constants of a commissioning
    /// with so many segments.
    ///
    /// # Errors
    /// A model that the core does not accept, or one that cannot be commissioned.
    pub fn rust_source(&self, commissioning: Option<u32>) -> Result<String, Error> {
        rust_source(&self.trained, (&self.description, &self.channels), commissioning)
    }

    /// The model as a C header.
    ///
    /// # Errors
    /// A model that the core does not accept.
    pub fn c_header(&self) -> Result<String, Error> {
        c_header(&self.trained.to_core()?, &self.description, Some(&self.channels))
    }

    /// Warns of what is uncertain about the model.
    pub(super) fn warn(&self) {
        let trained = &self.trained;
        let rotor = description::rotor_warnings(trained);
        trained.left_out.summary().iter().chain(&trained.watch.warning).chain(&rotor).for_each(output::warn);
    }
}

/// A model as Rust source, as [`Training::rust_source`].
pub(super) fn rust_source(
    trained: &Trained,
    (description, channels): (&[String], &Channels),
    commissioning: Option<u32>,
) -> Result<String, Error> {
    let mut source = export::rust_source(trained, description)?;
    if let Some(front_end) = &channels.front_end {
        source = format!("{source}\n{}", front_end_source(&trained.to_core()?, channels, front_end)?);
    }
    if let Some(segments) = commissioning {
        source = format!("{source}\n{}", commissioning_source(trained, segments)?);
    }
    Ok(source)
}

/// The channels that the model reads: without the reference, and without the velocity if it is taken from the angle.
pub(super) fn read_by(trained: &Trained, mut channels: Channels) -> Channels {
    if let (Some(shaft), Some(plan)) = (&mut channels.shaft, &trained.recipe.shaft) {
        shaft.reference = None;
        if plan.velocity == VelocitySource::Angle {
            shaft.velocity = None;
        }
    }
    channels
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
