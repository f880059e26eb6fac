//! The complete chain on the standard rig: simulate, train, evaluate held-out traces with the embedded detector,
//! and compare with the source's method on the same traces.

use rayon::prelude::*;

use super::literal;
use super::recipes::{REFERENCE_ORDER, a_only, all_parameters, shaft};
use crate::campaign::run::motion;
use model::Error;
use model::core::Embedded;
use model::evaluate::{self, Confusion, TraceVerdict};
use model::statistics::mean_sd_percent;
use model::trace::Trace;
use model::trace::labels::LabelledTrace;
use model::train::{Recipe, Trained, train};
use rig::{Defect, DefectKind, RigTrace, Scenario, simulate, trace_seed};

/// Class names of the standard rig, healthy first.
pub const CLASSES: [DefectKind; 3] = [DefectKind::Healthy, DefectKind::Spall, DefectKind::Roughness];

/// Choice of the first input of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstInput {
    /// Velocity reference.
    Reference,
    /// Velocity reference − measured velocity.
    Error,
}

/// Size of the demonstration.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Number of draws of training and validation sets.
    pub repetitions: u32,
    /// Number of traces per class in training, and again in validation.
    pub traces: u32,
    /// Seed; repetition r trains on set `seed` + 2r and validates on set `seed` + 2r + 1.
    pub seed: u32,
}

impl Settings {
    /// Seeds of the training and the validation set of one repetition. The two differ, and no two repetitions share a
    /// seed.
    #[must_use]
    pub const fn sets(&self, repetition: u32) -> (u32, u32) {
        (self.seed + 2 * repetition, self.seed + 2 * repetition + 1)
    }
}

/// Results of one repetition.
#[derive(Clone, Debug)]
pub struct Repetition {
    /// Least squares, all parameters, no projection, linear discriminant; embedded detector.
    pub all_parameters: Confusion,
    /// Torque balance and bearing order, quadratic discriminant; embedded detector.
    pub shaft: Confusion,
    /// Least squares, a-parameters, PCA to two components, linear discriminant; embedded detector.
    pub a_only: Confusion,
    /// The source's method in double precision.
    pub literal: literal::Outcome,
}

/// One draw with all data that a report shows.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Training traces.
    pub training: Vec<LabelledTrace>,
    /// Validation traces.
    pub validation: Vec<LabelledTrace>,
    /// Model trained on all parameters.
    pub trained: Trained,
    /// The same model in the embedded detector.
    pub model: Embedded,
    /// Verdicts on the validation traces.
    pub verdicts: Vec<TraceVerdict>,
    /// Error counts of all methods.
    pub repetition: Repetition,
}

/// Names of [`CLASSES`].
#[must_use]
pub fn class_names() -> Vec<String> {
    CLASSES.iter().map(|kind| kind.name().to_string()).collect()
}

/// Simulates `count` traces per class of one scenario for set `set`; `done` is called once per trace.
///
/// # Errors
/// Returns an error if the rig refuses the scenario.
pub fn traces(
    scenario: &Scenario,
    input: FirstInput,
    (set, count): (u32, u32),
    done: impl Fn() + Sync,
) -> Result<Vec<LabelledTrace>, Error> {
    let jobs: Vec<(usize, u32)> = (0..CLASSES.len()).flat_map(|class| (0..count).map(move |k| (class, k))).collect();
    let each = |&(class, k): &(usize, u32)| {
        let kind = CLASSES[class];
        let recorded =
            simulate(&scenario.with_defect(Defect::full(kind)), trace_seed(set, kind, k)).map_err(Error::other)?;
        done();
        Ok(LabelledTrace { trace: trace(format!("{}_{set}_{k:03}", kind.name()), recorded, input), class })
    };
    jobs.par_iter().map(each).collect()
}

/// Converts a recording of the rig, with the channels of the shaft.
fn trace(id: String, recorded: RigTrace, input: FirstInput) -> Trace {
    let motion = motion(&recorded);
    let u1 = match input {
        FirstInput::Reference => recorded.velocity_ref_rad_s,
        FirstInput::Error => {
            let pairs = recorded.velocity_ref_rad_s.iter().zip(&recorded.velocity_rad_s);
            pairs.map(|(reference, measured)| reference - measured).collect()
        }
    };
    let interval_s = recorded.t_s.windows(2).next().map(|pair| pair[1] - pair[0]);
    Trace {
        id,
        interval_s,
        irregular_steps: 0,
        y: recorded.current_a,
        u1,
        u2: recorded.load_torque_nm,
        motion: Some(motion),
        ..Trace::default()
    }
}

/// Trains a recipe and counts the decisions of the embedded detector on the validation set.
///
/// # Errors
/// Returns an error if training or embedding fails.
pub fn validate(
    recipe: &Recipe,
    training: &[LabelledTrace],
    validation: &[LabelledTrace],
) -> Result<(Trained, Embedded, Vec<TraceVerdict>, Confusion), Error> {
    let classes = class_names();
    let trained = train(training, &classes, recipe)?;
    let model = trained.embed()?;
    let verdicts = evaluate::run(&model, validation, || ())?;
    let confusion = evaluate::count(&classes, &verdicts, None, false);
    Ok((trained, model, verdicts, confusion))
}

/// Runs one repetition; `done` is called once per simulated trace.
///
/// # Errors
/// Returns an error if a step of the chain fails.
pub fn draw(settings: &Settings, repetition: u32, done: impl Fn() + Sync) -> Result<Draw, Error> {
    let (train_set, validation_set) = settings.sets(repetition);
    let set = |set| traces(&Scenario::STANDARD, FirstInput::Reference, (set, settings.traces), &done);
    let (training, validation) = (set(train_set)?, set(validation_set)?);
    let (trained, model, verdicts, confusion) = validate(&all_parameters(), &training, &validation)?;
    let (_, _, _, shaft) = validate(&shaft(), &training, &validation)?;
    let (_, _, _, a_only) = validate(&a_only(), &training, &validation)?;
    let literal = literal::validate(&training, &validation, &class_names(), REFERENCE_ORDER)?;
    let repetition = Repetition { all_parameters: confusion, shaft, a_only, literal };
    Ok(Draw { training, validation, trained, model, verdicts, repetition })
}

/// A method with its error rate over the repetitions.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the method.
    pub name: &'static str,
    /// Published error, %.
    pub published: &'static str,
    /// Mean error, %.
    pub mean: f64,
    /// Standard deviation, %; `None` for a single draw.
    pub sd: Option<f64>,
}

impl Row {
    /// Mean and standard deviation as text.
    #[must_use]
    pub fn error(&self) -> String {
        match self.sd {
            Some(sd) => format!("{:.1} ± {sd:.1}", self.mean),
            None => format!("{:.1}", self.mean),
        }
    }
}

/// Error of each method over the repetitions.
#[must_use]
pub fn rows(repetitions: &[Repetition]) -> Vec<Row> {
    let row = |name, published, error: fn(&Repetition) -> f64| {
        let (mean, sd) = mean_sd_percent(&repetitions.iter().map(error).collect::<Vec<_>>());
        Row { name, published, mean, sd: (repetitions.len() > 1).then_some(sd) }
    };
    vec![
        row("embedded: LS, all of a b c, LDA", "–", |r| r.all_parameters.error_rate().value),
        row("embedded: torque balance and bearing order, QDA", "–", |r| r.shaft.error_rate().value),
        row("embedded: LS, a only, PCA 2, LDA", "–", |r| r.a_only.error_rate().value),
        row("source: iv4, a only, PCA 2, LDA of 3 classes", "–", |r| r.literal.all_classes.error_rate().value),
        row("source: the same, two binary LDAs", "28.3 (Table 4.1)", |r| r.literal.binary_error()),
    ]
}

#[cfg(test)]
mod tests {
    use bearing_watch::plan::Method;

    use super::*;
    use model::train::Estimation;

    #[test]
    fn segments_of_a_trace_or_run_are_of_one_group() {
        let simulated = traces(&Scenario::STANDARD, FirstInput::Reference, (905, 2), || ()).expect("simulates");
        for method in [Method::LeastSquares, Method::Instruments] {
            let mut recipe = all_parameters();
            recipe.estimation = Estimation { method, segment: Some(1000), ..Estimation::default() };
            let trained = train(&simulated, &class_names(), &recipe).expect("regular");
            // Six traces of five segments each.
            assert_eq!(trained.candidates.groups, (0..30).map(|row| row / 5).collect::<Vec<_>>(), "{method:?}");
            recipe.validation.groups = ["x", "y", "x", "y", "x", "y"].map(String::from).to_vec();
            let trained = train(&simulated, &class_names(), &recipe).expect("regular");
            assert_eq!(trained.candidates.groups, (0..30).map(|row| row / 5 % 2).collect::<Vec<_>>(), "{method:?}");
            recipe.validation.groups.pop();
            assert!(train(&simulated, &class_names(), &recipe).is_err());
        }
    }
}
