//! The corridor: samples in, one [`Report`] a segment out.
//!
//! ```text
//! Sample ─► gate ─► block mean ─► Estimator ─┬─ segment full, or finish() ─► solve ─► Classifier ─► Report
//!   Motion ─► Shaft ─► friction, orders ──────┘  └─ else nothing
//! ```
//!
//! The cost of [`Detector::step`] is constant but for the sample that closes a segment, which adds one solve and one
//! classification. Where the interrupt has no time for them, [`Detector::collect`] hands out the closed segment's sums,
//! [`Model::conclude`] makes the report from them in the main loop, and [`Detector::adopt`] brings it back.
//! State: a few hundred bytes; the constants stay in the [`Model`].

use crate::decide::{Decision, Finding};
use crate::drive::BlockMean;
use crate::estimate::{
    Accumulator, Counts, Estimate, Estimator, Motion, NoShaft, Reason, Regression, Regressor, Rows, Segment,
    ShaftEstimate, ShaftSums, Shape, Triangle, Watch,
};
use crate::model::{Model, ModelError, NO_SHAFT};

/// One sample of the three signals, in the units the model was trained with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// Index of a class in [`Model::labels`]. The most plausible of the *trained* classes: posteriors are relative to
    /// each other, so a state unlike all of them (another load) still names one, unless it would be the healthy one.
    Class(u8),
    /// Nearest to healthy of all classes, but further off than healthy segments are: a small or unknown defect, or
    /// conditions not trained.
    Novel,
    /// No class is plausible enough to be worth naming.
    Ambiguous,
    /// No verdict, and why.
    Undetermined(Reason),
}

/// Verdict of one segment with everything it rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report<const M: usize, const P: usize, const C: usize, const K: usize = 0> {
    /// The class, or why there is none.
    pub verdict: Verdict,
    /// Likelihoods, posteriors, costs and distance from healthy; present where the verdict is not undetermined.
    pub decision: Option<Decision<C>>,
    /// Whether the estimate stands; if its model is stable too, it serves as auxiliary model and reference for what
    /// follows.
    pub accepted: bool,
    /// The estimate; zero parameters where it does not stand. Its counts say what the segment was denied.
    pub estimate: Estimate<M, P>,
    /// Friction and bearing orders, where the shaft is watched.
    pub shaft: Option<ShaftEstimate<K>>,
}

impl<const M: usize, const F: usize, const Z: usize, const C: usize, const K: usize> Model<M, F, Z, C, K> {
    /// The report of a detached segment: solve and classification, in whatever thread has the time.
    #[must_use]
    pub fn conclude<const P: usize, S: Shape>(&self, segment: Segment<M, P, S>) -> Report<M, P, C, K> {
        self.conclude_with_shaft(segment, None)
    }

    /// [`Model::conclude`] with what [`Detector::collect_with_motion`] handed out.
    #[must_use]
    pub fn conclude_with_shaft<const P: usize, S: Shape>(
        &self,
        segment: Segment<M, P, S>,
        shaft: Option<ShaftSums<K>>,
    ) -> Report<M, P, C, K> {
        let mut report = self.empty_report();
        report.shaft = self.conclude_shaft(shaft.as_ref());
        let solved = segment.solve_into(&self.regression, &mut report.estimate);
        self.judge(&mut report, segment.rows(), solved);
        report
    }

    /// The report of a whole segment of so many rows from its solved estimate, for who advances a
    /// [`Solver`](crate::estimate::Solver) by hand.
    #[must_use]
    pub fn report<const P: usize>(
        &self,
        rows: u32,
        counts: Counts,
        result: Result<Estimate<M, P>, Reason>,
    ) -> Report<M, P, C, K> {
        let mut report = self.empty_report();
        (report.estimate.rows, report.estimate.counts) = (rows, counts);
        let solved = result.map(|estimate| report.estimate = estimate);
        self.judge(&mut report, rows, solved);
        report
    }

    fn conclude_shaft(&self, sums: Option<&ShaftSums<K>>) -> Option<ShaftEstimate<K>> {
        // Known when compiling: what watches no shaft carries none of this.
        if K == 0 {
            return None;
        }
        self.shaft.as_ref().zip(sums).map(|(shaft, sums)| shaft.conclude(sums))
    }

    /// Completes the report of a whole segment that holds its estimate.
    fn judge<const P: usize>(&self, report: &mut Report<M, P, C, K>, rows: u32, solved: Result<(), Reason>) {
        self.classify(report, solved);
        // The model knows the spread of whole segments only.
        if rows < self.sampling.segment_samples / 2 && !matches!(report.verdict, Verdict::Undetermined(_)) {
            report.verdict = Verdict::Undetermined(Reason::TooFewRows);
            report.decision = None;
        }
        self.log(report);
    }

    /// Completes the report that holds the estimate of any number of rows.
    fn classify<const P: usize>(&self, report: &mut Report<M, P, C, K>, solved: Result<(), Reason>) {
        report.accepted = solved.is_ok();
        match solved.and_then(|()| self.classifier.classify(&report.estimate, report.shaft.as_ref())) {
            Ok(decision) => {
                report.verdict = match self.classifier.finding(&decision) {
                    Finding::Class(class) => Verdict::Class(class),
                    Finding::Novel => Verdict::Novel,
                    Finding::Ambiguous => Verdict::Ambiguous,
                };
                report.decision = Some(decision);
            }
            Err(reason) => report.verdict = Verdict::Undetermined(reason),
        }
    }

    fn empty_report<const P: usize>(&self) -> Report<M, P, C, K> {
        let Regression { order, offset, .. } = self.regression;
        let counts = Counts { rejected: 0, saturated: 0, downweighted: 0, still: 0, stuck: [false; 3], refused: 0 };
        let estimate = Estimate::empty(order, offset, 0, counts);
        Report {
            verdict: Verdict::Undetermined(Reason::TooFewRows),
            decision: None,
            accepted: false,
            estimate,
            shaft: None,
        }
    }

    /// The feature `defmt` tells of every closed segment, never of a sample. Only on a chip: host programs have no logger
    /// to link with.
    fn log<const P: usize>(&self, report: &Report<M, P, C, K>) {
        #[cfg(all(feature = "defmt", target_os = "none"))]
        {
            let Estimate { rows, counts, .. } = &report.estimate;
            match report.verdict {
                Verdict::Class(class) => {
                    if counts.rejected + counts.saturated > 0 {
                        defmt::warn!(
                            "samples refused: {=u32} rejected, {=u32} saturated",
                            counts.rejected,
                            counts.saturated
                        );
                    }
                    defmt::info!(
                        "{=u32} rows, {}, class {=u8}, verdict: {=str}",
                        rows,
                        counts,
                        class,
                        self.label(class)
                    );
                }
                Verdict::Novel => defmt::warn!("{=u32} rows, {}, verdict: novel", rows, counts),
                Verdict::Ambiguous => defmt::info!("{=u32} rows, {}, verdict: ambiguous", rows, counts),
                Verdict::Undetermined(reason) => defmt::warn!("{=u32} rows, {}, no verdict: {}", rows, counts, reason),
            }
        }
        #[cfg(not(all(feature = "defmt", target_os = "none")))]
        let _nobody_listens = report;
    }
}

/// Running state beside the current loop. Capacities: `M` columns, `P` = M(M−1)/2, `L` delays, `F` features, `Z`
/// coordinates, `C` classes; `R` makes the rows,
/// `A` sums them; `W` watches the shaft with at most `K` bearing orders. Exported models bring a type alias with all of them set.
///
/// ```
/// # use bearing_watch::*;
/// # fn run<const M: usize, const P: usize, const L: usize, const F: usize, const Z: usize, const C: usize>(
/// #     mut detector: Detector<'_, M, P, L, F, Z, C>, model: &Model<M, F, Z, C>, current_a: f32, error_rad_s: f32, load_nm: f32) {
/// // in the sampling interrupt
/// if let Some(report) = detector.step(Sample { y: current_a, u1: error_rad_s, u2: load_nm }) {
///     match report.verdict {
///         Verdict::Class(class) => { let _name = model.label(class); }
///         Verdict::Novel | Verdict::Ambiguous => {}
///         Verdict::Undetermined(_reason) => {}
///     }
/// }
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Detector<
    'm,
    const M: usize,
    const P: usize,
    const L: usize,
    const F: usize,
    const Z: usize,
    const C: usize,
    R = Regressor<M, L>,
    A = Triangle<M, P>,
    W = NoShaft,
    const K: usize = 0,
> {
    model: &'m Model<M, F, Z, C, K>,
    block: BlockMean<3>,
    /// Whether a sample of the open block was refused.
    spoiled: bool,
    estimator: Estimator<'m, M, P, L, R, A>,
    shaft: W,
    /// Samples of the open segment, at the identification rate.
    samples: u32,
}

impl<
    'm,
    const M: usize,
    const P: usize,
    const L: usize,
    const F: usize,
    const Z: usize,
    const C: usize,
    R,
    A,
    W,
    const K: usize,
> Detector<'m, M, P, L, F, Z, C, R, A, W, K>
where
    R: Rows<M>,
    A: Accumulator<M, P>,
    W: Watch<K>,
{
    /// Checks the model against the capacities, once.
    ///
    /// # Errors
    /// A [`ModelError`] naming what does not fit.
    pub fn new(model: &'m Model<M, F, Z, C, K>) -> Result<Self, ModelError> {
        model.validate()?;
        let regression = &model.regression;
        if regression.order.largest_delay() > L {
            return Err(ModelError::Capacity("delays"));
        }
        if !R::fits(regression) {
            return Err(ModelError::Value("method or structure, which this detector was not compiled for,"));
        }
        if !A::fits(regression) {
            return Err(ModelError::Value("memory, which this detector was not compiled for,"));
        }
        if model.sampling.segment_samples > A::LONGEST {
            return Err(ModelError::Value("segment length"));
        }
        if !W::fits(model.shaft.as_ref()) {
            return Err(ModelError::Value(NO_SHAFT));
        }
        Ok(Self {
            model,
            block: BlockMean::new(),
            spoiled: false,
            estimator: Estimator::new(regression),
            shaft: W::new(model.shaft.as_ref()),
            samples: 0,
        })
    }

    /// Takes one sample; the sample that closes a segment brings its report. A segment of which less than half was
    /// usable has no verdict.
    #[inline]
    pub fn step(&mut self, sample: Sample) -> Option<Report<M, P, C, K>> {
        if self.take(&sample) { Some(self.close()) } else { None }
    }

    /// Takes one sample, for the interrupt that has no time to solve; the sample that closes a segment brings the sums
    /// of it, for [`Model::conclude`]. Hand its report back to [`Detector::adopt`].
    #[inline]
    pub fn collect(&mut self, sample: Sample) -> Option<Segment<M, P, R::Shape>> {
        if !self.take(&sample) {
            return None;
        }
        self.samples = 0;
        Some(self.estimator.detach())
    }

    /// [`Detector::step`] for a model that watches the shaft: the same instant's sample and motion.
    #[inline]
    pub fn step_with_motion(&mut self, sample: Sample, motion: &Motion) -> Option<Report<M, P, C, K>> {
        self.shaft.step(self.model.shaft.as_ref(), motion);
        self.step(sample)
    }

    /// [`Detector::collect`] for a model that watches the shaft; both parts go to [`Model::conclude_with_shaft`].
    #[inline]
    pub fn collect_with_motion(
        &mut self,
        sample: Sample,
        motion: &Motion,
    ) -> Option<(Segment<M, P, R::Shape>, Option<ShaftSums<K>>)> {
        self.shaft.step(self.model.shaft.as_ref(), motion);
        let segment = self.collect(sample)?;
        let sums = self.shaft.sums();
        self.shaft.next_segment();
        Some((segment, sums))
    }

    /// Lets the estimate of a concluded segment take over at the handover. `false`, and nothing done, if that is past
    /// or the estimate does not stand.
    pub fn adopt(&mut self, report: &Report<M, P, C, K>) -> bool {
        report.accepted && self.estimator.adopt(&report.estimate)
    }

    /// Takes one sample; whether the segment is full.
    #[inline]
    fn take(&mut self, sample: &Sample) -> bool {
        let good = self.estimator.admit(sample);
        let block = self.model.sampling.block_mean;
        if block <= 1 {
            if good {
                self.estimator.take(sample);
            } else {
                self.estimator.skip();
            }
        } else {
            // A mean would hide one refused sample, so it spoils its block.
            self.spoiled |= !good;
            let Some([y, u1, u2]) = self.block.push([sample.y, sample.u1, sample.u2], block) else { return false };
            if core::mem::take(&mut self.spoiled) {
                self.estimator.skip();
            } else {
                self.estimator.take(&Sample { y, u1, u2 });
            }
        }
        self.samples = self.samples.saturating_add(1);
        self.samples >= self.model.sampling.segment_samples
    }

    #[cold]
    #[inline(never)]
    fn close(&mut self) -> Report<M, P, C, K> {
        self.samples = 0;
        let rows = self.estimator.rows();
        let mut report = self.model.empty_report();
        let solved = self.estimator.close_into(&mut report.estimate);
        report.shaft = self.model.conclude_shaft(self.shaft.sums().as_ref());
        self.shaft.next_segment();
        self.model.judge(&mut report, rows, solved);
        report
    }

    /// The report the open segment would give now, leaving it open. With fading memory that is the state of things.
    #[must_use]
    pub fn preview(&self) -> Report<M, P, C, K> {
        let mut report = self.model.empty_report();
        let solved = self.estimator.estimate_into(&mut report.estimate);
        report.shaft = self.model.conclude_shaft(self.shaft.sums().as_ref());
        self.model.classify(&mut report, solved);
        report
    }

    /// Samples at the identification rate in the open segment.
    #[must_use]
    pub const fn pending(&self) -> u32 {
        self.samples
    }

    /// Closes the open segment at the end of a trace, reports it, and starts afresh. The caller decides whether a part
    /// of a segment is enough: see [`Detector::pending`].
    pub fn finish(&mut self) -> Report<M, P, C, K> {
        let report = self.preview();
        self.model.log(&report);
        self.restart();
        report
    }

    /// Starts afresh without a report, for a stream that does not go on from the last sample: lags, sums and auxiliary
    /// model.
    pub fn restart(&mut self) {
        self.samples = 0;
        self.block.reset();
        self.spoiled = false;
        self.shaft = W::new(self.model.shaft.as_ref());
        self.estimator.restart();
    }
}
