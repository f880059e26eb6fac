//! Traces of the actuator under one condition, in one repetition.
//!
//! The source prepared its recordings in two ways. At Moog every value was held for three rows of 1200 Hz, and a third
//! of the rows was kept behind an anti-alias filter; y is the quadrature current. At RIT 10 kHz were used as recorded;
//! y is the position, because the current that was computed with an integrated velocity fitted no model. Our method
//! takes the same rows at Moog, and at RIT the phase currents and resolver counts, through the core's front end.

use rayon::prelude::*;

use super::published::{Input, Published, TRACES_MOOG, TRACES_RIT};
use crate::ema::record::{cleaned, thinned};
use crate::ema::source::{Estimated, estimated, first_input};
use model::Error;
use model::identify::Method;
use model::trace::Trace;
use model::trace::labels::LabelledTrace;
use model::trace::prepare::decimate;
use rig::ema::{EmaCondition, EmaDefect, Race, simulate};
use rig::{DefectKind, trace_seed};

/// Rows of the control rate of the RIT rig per sample of our method.
const RIT_FACTOR: usize = 10;

/// Classes of a condition, healthy first. The degraded actuator of Moog has a spall of the inner race and lost
/// lubrication, that of RIT lost lubrication alone.
#[must_use]
pub const fn classes(condition: &EmaCondition) -> [DefectKind; 2] {
    if is_rit(condition) {
        [DefectKind::Healthy, DefectKind::Roughness]
    } else {
        [DefectKind::Healthy, DefectKind::SpallAndRoughness]
    }
}

/// Whether a condition is that of the RIT rig, whose rows are the samples of the controller.
const fn is_rit(condition: &EmaCondition) -> bool {
    condition.scenario.logging.every == 1
}

/// Number of traces per class and set.
#[must_use]
pub const fn traces(condition: &EmaCondition) -> u32 {
    if is_rit(condition) { TRACES_RIT } else { TRACES_MOOG }
}

/// A record as the source used it, and for our method.
#[derive(Clone, Debug)]
struct Recorded {
    y: Vec<f64>,
    /// u1 of each [`Input`].
    inputs: Vec<(Input, Vec<f64>)>,
    /// u2.
    load: Vec<f64>,
    interval_s: f64,
    ours: LabelledTrace,
}

impl Recorded {
    fn new(condition: &EmaCondition, (class, kind): (usize, DefectKind), (set, k): (u32, u32)) -> Result<Self, Error> {
        let seed = trace_seed(set, kind, k);
        let scenario = condition.scenario(seed).with_defect(EmaDefect::of(kind, 1.0, Race::Inner));
        let recorded = simulate(&scenario, seed).map_err(Error::other)?;
        let factor = scenario.logging.hold as usize;
        let each = |column: &[f64]| decimate(column, factor);
        let ours = if is_rit(condition) {
            cleaned::<RIT_FACTOR>(&scenario, &recorded)?
        } else {
            thinned(&scenario, &recorded, factor)
        };
        let id = format!("{}_{}_{set}_{k:03}", condition.name, kind.name());
        Ok(Self {
            y: each(if is_rit(condition) { &recorded.position_m } else { &recorded.current_a }),
            inputs: [Input::Position, Input::Error, Input::Velocity]
                .map(|input| (input, each(&first_input(&recorded, input))))
                .to_vec(),
            load: each(&recorded.load_torque_nm),
            interval_s: factor as f64 * scenario.row_interval_s(),
            ours: LabelledTrace { trace: ours.into_trace(id), class },
        })
    }

    fn trace(&self, input: Input) -> Trace {
        let u1 = self.inputs.iter().find(|(own, _)| *own == input).map(|(_, u1)| u1.clone()).unwrap_or_default();
        let (id, interval_s) = (self.ours.trace.id.clone(), Some(self.interval_s));
        Trace { id, interval_s, y: self.y.clone(), u1, u2: self.load.clone(), ..Trace::default() }
    }
}

/// A training and a validation set.
#[derive(Clone, Debug)]
pub struct Draw {
    condition: EmaCondition,
    sets: [Vec<Recorded>; 2],
}

impl Draw {
    /// Simulates both sets.
    ///
    /// # Errors
    /// Returns an error if the rig refuses the scenario.
    pub fn new(condition: &EmaCondition, (training, validation): (u32, u32)) -> Result<Self, Error> {
        let kinds = classes(condition).into_iter().enumerate();
        let jobs: Vec<_> = kinds.flat_map(|class| (0..traces(condition)).map(move |k| (class, k))).collect();
        let set = |set: u32| -> Result<Vec<Recorded>, Error> {
            jobs.par_iter().map(|&(class, k)| Recorded::new(condition, class, (set, k))).collect()
        };
        Ok(Self { condition: *condition, sets: [set(training)?, set(validation)?] })
    }

    /// The condition.
    #[must_use]
    pub const fn condition(&self) -> &EmaCondition {
        &self.condition
    }

    /// Names of the classes.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        ["healthy", "degraded"].map(String::from).to_vec()
    }

    /// Estimates of both sets.
    ///
    /// # Errors
    /// Returns an error if a trace cannot be estimated.
    pub fn estimates(&self, published: &Published, method: Method) -> Result<[Estimated; 2], Error> {
        let of = |set: &[Recorded]| {
            let traces: Vec<_> = set.iter().map(|own| (own.ours.class, own.trace(published.input))).collect();
            estimated(&traces, &self.names(), (published.order, method))
        };
        let [training, validation] = &self.sets;
        Ok([of(training)?, of(validation)?])
    }

    /// The training and the validation set for our method.
    #[must_use]
    pub fn ours(&self) -> [Vec<LabelledTrace>; 2] {
        [0, 1].map(|set: usize| self.sets[set].iter().map(|recorded| recorded.ours.clone()).collect())
    }
}
