//! The corridor: samples in, one [`Report`] a segment out.
//!
//! ```text
//! Sample ─► block mean ─► Estimator ─┬─ segment full, or finish() ─► Classifier ─► Report
//!                                    └─ else nothing
//! ```
//!
//! The cost of [`Detector::step`] is constant but for the sample that closes a segment, which adds one solve and one
//! classification. State: a few hundred bytes; the constants stay in the [`Model`].

use crate::decide::Decision;
use crate::drive::BlockMean;
use crate::estimate::{Estimate, Estimator, Reason};
use crate::model::{Model, ModelError};

/// One sample of the three signals, in the units the model was trained with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Output of the model, as a rule the quadrature current.
    pub y: f32,
    /// First input: the controlled variable's reference, or reference − measured.
    pub u1: f32,
    /// Second input: the load, or another measured signal.
    pub u2: f32,
}

/// What a segment says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Index of a class in [`Model::labels`]. The most plausible of the *trained* classes: posteriors are relative to
    /// each other, so a state unlike all of them (standstill, another load) still names one.
    Class(u8),
    /// No verdict, and why.
    Undetermined(Reason),
}

/// Verdict of one segment with everything it rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<const M: usize, const P: usize, const C: usize> {
    /// The class, or why there is none.
    pub verdict: Verdict,
    /// Likelihoods, posteriors and costs; present where the verdict is a class.
    pub decision: Option<Decision<C>>,
    /// The estimate; zero parameters where the verdict comes from the estimator's [`Reason`].
    pub estimate: Estimate<M, P>,
}

/// Running state beside the current loop. Capacities: `M` columns, `P` = M(M−1)/2, `L` delays, `F` features, `Z`
/// coordinates, `C` classes. Exported models bring a type alias with all of them set.
///
/// ```
/// # use bearing_watch::*;
/// # fn run<const M: usize, const P: usize, const L: usize, const F: usize, const Z: usize, const C: usize>(
/// #     mut detector: Detector<'_, M, P, L, F, Z, C>, model: &Model<M, F, Z, C>, current_a: f32, error_rad_s: f32, load_nm: f32) {
/// // in the sampling interrupt
/// if let Some(report) = detector.step(Sample { y: current_a, u1: error_rad_s, u2: load_nm }) {
///     match report.verdict {
///         Verdict::Class(class) => { let _name = model.label(class); }
///         Verdict::Undetermined(_reason) => {}
///     }
/// }
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Detector<'m, const M: usize, const P: usize, const L: usize, const F: usize, const Z: usize, const C: usize>
{
    model: &'m Model<M, F, Z, C>,
    block: BlockMean<3>,
    estimator: Estimator<'m, M, P, L>,
    /// Samples of the open segment, at the identification rate.
    samples: u32,
}

impl<'m, const M: usize, const P: usize, const L: usize, const F: usize, const Z: usize, const C: usize>
    Detector<'m, M, P, L, F, Z, C>
{
    /// Checks the model against the capacities, once.
    ///
    /// # Errors
    /// A [`ModelError`] naming what does not fit.
    pub fn new(model: &'m Model<M, F, Z, C>) -> Result<Self, ModelError> {
        model.validate()?;
        if model.regression.order.largest_delay() > L {
            return Err(ModelError::Capacity("delays"));
        }
        Ok(Self { model, block: BlockMean::new(), estimator: Estimator::new(&model.regression), samples: 0 })
    }

    /// Takes one sample; the sample that closes a segment brings its report. A segment of which less than half was
    /// usable has no verdict.
    #[inline]
    pub fn step(&mut self, sample: Sample) -> Option<Report<M, P, C>> {
        let block = self.model.sampling.block_mean;
        // A mean would hide one wild sample; so it spoils its block instead, which the estimator then rejects.
        let wild = block > 1 && !self.model.regression.accepts(&sample);
        let y = if wild { f32::NAN } else { sample.y };
        let [y, u1, u2] = self.block.push([y, sample.u1, sample.u2], block)?;
        self.estimator.step(&Sample { y, u1, u2 });
        self.samples = self.samples.saturating_add(1);
        if self.samples < self.model.sampling.segment_samples {
            return None;
        }
        let mut report = self.preview();
        // The model knows the spread of whole segments only.
        if report.estimate.rows < self.model.sampling.segment_samples / 2 {
            report.verdict = Verdict::Undetermined(Reason::TooFewRows);
            report.decision = None;
        }
        self.samples = 0;
        self.estimator.next_segment();
        Some(report)
    }

    /// The report the open segment would give now, leaving it open.
    #[must_use]
    pub fn preview(&self) -> Report<M, P, C> {
        let undetermined =
            |reason, estimate| Report { verdict: Verdict::Undetermined(reason), decision: None, estimate };
        match self.estimator.estimate() {
            Err(reason) => undetermined(reason, self.estimator.empty_estimate()),
            Ok(estimate) => match self.model.classifier.classify(&estimate) {
                Err(reason) => undetermined(reason, estimate),
                Ok(decision) => Report { verdict: Verdict::Class(decision.class), decision: Some(decision), estimate },
            },
        }
    }

    /// Samples at the identification rate in the open segment.
    #[must_use]
    pub const fn pending(&self) -> u32 {
        self.samples
    }

    /// Closes the open segment at the end of a trace, reports it, and starts afresh. The caller decides whether a part
    /// of a segment is enough: see [`Detector::pending`].
    pub fn finish(&mut self) -> Report<M, P, C> {
        let report = self.preview();
        self.restart();
        report
    }

    /// Starts afresh without a report, for a stream that does not go on from the last sample.
    pub fn restart(&mut self) {
        self.samples = 0;
        self.block.reset();
        self.estimator.restart();
    }
}
