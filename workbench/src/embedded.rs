//! The bridge to the core: a trained model in the core's single-precision form, and traces run through its
//! [`Detector`], the code that firmware runs.

use bearing_watch::decide::{Classifier, Discriminant, Features, Kind, Projection};
use bearing_watch::model::MAX_BYTES;
use bearing_watch::{Detector, Label, Model, ModelError, Reason, Regression, Report, Sample, Sampling, Verdict};
use nalgebra::DMatrix;

use crate::Error;
use crate::identify::Structure;
use crate::trace::Trace;
use crate::train::Trained;

/// What one segment of a trace gave, free of capacities.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Index of the decided class, or why there is none.
    pub verdict: Result<usize, String>,
    /// Posterior of each class; empty where there is no verdict.
    pub posteriors: Vec<f32>,
    /// Log-likelihood of each class; empty where there is no verdict.
    pub log_likelihoods: Vec<f32>,
    /// δ-parameters.
    pub delta: Vec<f32>,
    /// a₁…, b₁…, c₁…, constant.
    pub raw: Vec<f32>,
    /// Residual variance.
    pub variance: f32,
    /// Rows of the regression.
    pub rows: u32,
    /// Samples refused by the range guard.
    pub rejected: u32,
    /// Samples before the segment, as fed to the detector.
    pub start: usize,
    /// Samples of the segment, as fed to the detector.
    pub length: usize,
}

/// A model in the core's form, in the smallest capacity that holds it.
#[derive(Clone, Debug)]
pub struct Embedded {
    model: Sized,
    /// Class names.
    pub classes: Vec<String>,
}

/// Capacities that the workbench instantiates: columns, delays, features, coordinates, classes.
macro_rules! capacities {
    ($($name:ident: $m:literal $l:literal $f:literal $z:literal $c:literal;)+) => {
        #[derive(Clone, Debug)]
        enum Sized {
            $($name(Box<Model<$m, $f, $z, $c>>),)+
        }

        impl Sized {
            fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
                $(
                    match Model::<$m, $f, $z, $c>::from_bytes(bytes) {
                        // Delays are the detector's capacity, so ask it too.
                        Ok(model) if Detector::<$m, { $m * ($m - 1) / 2 }, $l, $f, $z, $c>::new(&model).is_ok() => {
                            return Ok(Self::$name(Box::new(model)));
                        }
                        Ok(_) | Err(ModelError::Capacity(_)) => {}
                        Err(error) => return Err(error),
                    }
                )+
                Err(ModelError::Capacity("columns, delays, features or classes"))
            }

            fn run(&self, trace: &Trace) -> Result<Vec<Segment>, ModelError> {
                match self {
                    $(Self::$name(model) => {
                        run(Detector::<$m, { $m * ($m - 1) / 2 }, $l, $f, $z, $c>::new(model)?, model, trace)
                    })+
                }
            }

            fn previews(&self, trace: &Trace, every: usize) -> Result<Vec<Segment>, ModelError> {
                match self {
                    $(Self::$name(model) => {
                        previews(Detector::<$m, { $m * ($m - 1) / 2 }, $l, $f, $z, $c>::new(model)?, model, trace, every)
                    })+
                }
            }

            fn rates(&self) -> Sampling {
                match self {
                    $(Self::$name(model) => model.sampling,)+
                }
            }

            fn structure(&self) -> Structure {
                match self {
                    $(Self::$name(model) => {
                        Structure { order: model.regression.order, offset: model.regression.offset }
                    })+
                }
            }

            fn decide(&self, log_likelihoods: &[f32]) -> Option<(usize, Vec<f32>)> {
                match self {
                    $(Self::$name(model) => {
                        let mut padded = [f32::NEG_INFINITY; $c];
                        padded.iter_mut().zip(log_likelihoods).for_each(|(cell, value)| *cell = *value);
                        let decision = model.classifier.discriminant.decide_from(padded)?;
                        Some((decision.class as usize, decision.posteriors[..log_likelihoods.len()].to_vec()))
                    })+
                }
            }

            fn decide_at(&self, coordinates: &[f32]) -> Option<usize> {
                match self {
                    $(Self::$name(model) => {
                        let mut z = [0.0; $z];
                        z.iter_mut().zip(coordinates).for_each(|(cell, value)| *cell = *value);
                        Some(model.classifier.discriminant.decide(&z)?.class as usize)
                    })+
                }
            }

            fn label_names(&self) -> Vec<String> {
                match self {
                    $(Self::$name(model) => {
                        let count = model.classifier.discriminant.classes;
                        (0..count).map(|k| model.label(k).to_string()).collect()
                    })+
                }
            }
        }
    };
}

capacities! {
    Small: 10 4 10 10 4;
    Medium: 20 8 20 20 8;
    Large: 100 32 100 100 8;
}

fn run<const M: usize, const P: usize, const L: usize, const F: usize, const Z: usize, const C: usize>(
    mut detector: Detector<'_, M, P, L, F, Z, C>,
    model: &Model<M, F, Z, C>,
    trace: &Trace,
) -> Result<Vec<Segment>, ModelError> {
    let classes = model.classifier.discriminant.classes as usize;
    let mut segments = Vec::new();
    let mut start = 0;
    for (k, sample) in samples(trace).enumerate() {
        if let Some(report) = detector.step(sample) {
            segments.push(Segment { start, length: k + 1 - start, ..segment(&report, classes) });
            start = k + 1;
        }
    }
    // What is left counts only where it is more than half a segment: the model knows the spread of whole ones.
    let (pending, whole) = (detector.pending(), model.sampling.segment_samples);
    if pending > whole / 2 || segments.is_empty() {
        let mut rest = Segment { start, length: trace.y.len() - start, ..segment(&detector.finish(), classes) };
        if pending <= whole / 2 {
            rest = rest.undetermined(format!("{pending} samples are no more than half a segment of {whole}"));
        }
        segments.push(rest);
    }
    Ok(segments)
}

fn previews<const M: usize, const P: usize, const L: usize, const F: usize, const Z: usize, const C: usize>(
    mut detector: Detector<'_, M, P, L, F, Z, C>,
    model: &Model<M, F, Z, C>,
    trace: &Trace,
    every: usize,
) -> Result<Vec<Segment>, ModelError> {
    let classes = model.classifier.discriminant.classes as usize;
    let mut previews = Vec::new();
    for (k, sample) in samples(trace).enumerate() {
        let closed = detector.step(sample);
        if (k + 1).is_multiple_of(every) {
            let report = closed.unwrap_or_else(|| detector.preview());
            previews.push(Segment { length: k + 1, ..segment(&report, classes) });
        }
        if closed.is_some() {
            break;
        }
    }
    Ok(previews)
}

fn samples(trace: &Trace) -> impl Iterator<Item = Sample> {
    let rows = trace.y.iter().zip(&trace.u1).zip(&trace.u2);
    rows.map(|((y, u1), u2)| Sample { y: *y as f32, u1: *u1 as f32, u2: *u2 as f32 })
}

fn segment<const M: usize, const P: usize, const C: usize>(report: &Report<M, P, C>, classes: usize) -> Segment {
    let n = report.estimate.parameters();
    let decided = |pick: fn(&bearing_watch::Decision<C>) -> [f32; C]| {
        report.decision.map_or_else(Vec::new, |decision| pick(&decision)[..classes].to_vec())
    };
    Segment {
        verdict: match report.verdict {
            Verdict::Class(class) => Ok(class as usize),
            Verdict::Undetermined(reason) => Err(explain(reason, report)),
        },
        posteriors: decided(|d| d.posteriors),
        log_likelihoods: decided(|d| d.log_likelihoods),
        delta: report.estimate.delta[..n].to_vec(),
        raw: report.estimate.raw()[..n].to_vec(),
        variance: report.estimate.variance,
        rows: report.estimate.rows,
        rejected: report.estimate.rejected,
        start: 0,
        length: 0,
    }
}

/// The reason with what it means in this model.
fn explain<const M: usize, const P: usize, const C: usize>(reason: Reason, report: &Report<M, P, C>) -> String {
    let estimate = &report.estimate;
    match reason {
        Reason::TooFewRows if estimate.rejected > 0 => {
            format!("{reason}: {} samples lie outside the model's limits", estimate.rejected)
        }
        Reason::NotExcited(place) => {
            let names = Structure { order: estimate.order, offset: estimate.offset }.names();
            names.get(place as usize).map_or(reason.to_string(), |name| {
                format!("the signals do not excite parameter {name} (constant, or depending on the ones before)")
            })
        }
        _ => reason.to_string(),
    }
}

impl Segment {
    fn undetermined(self, reason: String) -> Self {
        Self { verdict: Err(reason), posteriors: vec![], log_likelihoods: vec![], ..self }
    }
}

impl Embedded {
    /// Reads a binary model into the smallest capacity that holds it.
    ///
    /// # Errors
    /// Whatever the core refuses the bytes for.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        let model = Sized::from_bytes(bytes)?;
        Ok(Self { classes: model.label_names(), model })
    }

    /// Runs one trace through the detector; a partial last segment counts where it is more than half a segment.
    ///
    /// # Errors
    /// Where the detector refuses the model.
    pub fn run(&self, trace: &Trace) -> Result<Vec<Segment>, ModelError> {
        self.model.run(trace)
    }

    /// Order and constant of the regression.
    #[must_use]
    pub fn structure(&self) -> Structure {
        self.model.structure()
    }

    /// What the first segment would say if it ended after each multiple of `every` samples.
    ///
    /// # Errors
    /// Where the detector refuses the model.
    pub fn previews(&self, trace: &Trace, every: usize) -> Result<Vec<Segment>, ModelError> {
        self.model.previews(trace, every)
    }

    /// Rates and segment length.
    #[must_use]
    pub fn sampling(&self) -> Sampling {
        self.model.rates()
    }

    /// Verdict over several independent segments: their log-likelihoods add up. Nothing where no segment has one.
    #[must_use]
    pub fn combine(&self, segments: &[Segment]) -> Option<(usize, Vec<f32>)> {
        let mut sums = vec![0.0; self.classes.len()];
        let determined = segments.iter().filter(|s| s.verdict.is_ok());
        for segment in determined.clone() {
            sums.iter_mut().zip(&segment.log_likelihoods).for_each(|(sum, value)| *sum += value);
        }
        determined.count().checked_sub(1)?;
        self.model.decide(&sums)
    }

    /// The class decided at projected coordinates, for plots of decision regions.
    #[must_use]
    pub fn decide_at(&self, coordinates: &[f32]) -> Option<usize> {
        self.model.decide_at(coordinates)
    }
}

impl Trained {
    /// The core's form. Capacities beyond what is in use hold neutral values.
    ///
    /// # Errors
    /// What does not fit the capacities, or lies out of the range of single precision.
    pub fn to_core<const M: usize, const F: usize, const Z: usize, const C: usize>(
        &self,
    ) -> Result<Model<M, F, Z, C>, Error> {
        let densities = &self.densities;
        let mut labels = [Label::EMPTY; C];
        for (label, name) in labels.iter_mut().zip(&self.classes) {
            *label = Label::new(name)
                .ok_or_else(|| Error::Training(format!("class name {name} is longer than 16 bytes; shorten it")))?;
        }
        let mut discriminant = Discriminant {
            kind: densities.kind,
            classes: count(self.classes.len(), C, "classes")?,
            mean: [[0.0; Z]; C],
            whitening: [[[0.0; Z]; Z]; C],
            log_normaliser: [f32::NEG_INFINITY; C],
            log_prior: [f32::NEG_INFINITY; C],
            cost: [[0.0; C]; C],
        };
        for (row, mean) in discriminant.mean.iter_mut().zip(&densities.means) {
            row.iter_mut().zip(mean.iter()).for_each(|(cell, x)| *cell = *x as f32);
        }
        for (rows, u) in discriminant.whitening.iter_mut().zip(&densities.whitening) {
            fill(rows, u);
        }
        narrow(&mut discriminant.log_normaliser, &densities.log_normaliser);
        narrow(&mut discriminant.log_prior, &densities.priors.iter().map(|p| p.ln()).collect::<Vec<_>>());
        for (row, cost) in discriminant.cost.iter_mut().zip(&densities.cost) {
            narrow(row, cost);
        }

        let used = &self.core_features;
        let mut features = Features { index: [0; F], count: count(used.len(), F, "features")? };
        for (cell, &index) in features.index.iter_mut().zip(used) {
            *cell = count(index, 255, "features")?;
        }
        let z = count(self.core_projection.matrix.nrows(), Z, "coordinates")?;
        let mut projection = Projection { matrix: [[0.0; F]; Z], mean: [0.0; F], count: z };
        fill(&mut projection.matrix, &self.core_projection.matrix);
        narrow(&mut projection.mean, self.core_projection.mean.as_slice());

        let structure = self.recipe.structure;
        let mut scale = [1.0; M];
        narrow(&mut scale, &self.scale);
        let model = Model {
            sampling: Sampling {
                interval_s: self.interval_s as f32,
                block_mean: u16::try_from(self.block_mean)
                    .map_err(|_| Error::Usage("--block-mean is at most 65535".into()))?,
                segment_samples: u32::try_from(self.segment_samples)
                    .map_err(|_| Error::Usage("a segment has at most 100000 samples".into()))?,
            },
            regression: Regression {
                order: structure.order,
                offset: structure.offset,
                scale,
                limit: self.limit.map(|x| x as f32),
            },
            classifier: Classifier { features, projection, discriminant },
            labels,
        };
        model.validate().map_err(|e| Error::Training(format!("the trained model cannot be embedded: {e}")))?;
        Ok(model)
    }

    /// The binary form, with notes.
    ///
    /// # Errors
    /// As [`Trained::to_core`].
    pub fn to_bytes(&self, notes: &str) -> Result<Vec<u8>, Error> {
        let model: Box<Model<100, 100, 100, 8>> = Box::new(self.to_core()?);
        let mut buffer = vec![0; MAX_BYTES];
        let length = model
            .to_bytes(notes, &mut buffer)
            .map_err(|e| Error::Training(format!("the trained model cannot be embedded: {e}")))?;
        buffer.truncate(length);
        Ok(buffer)
    }

    /// The model ready to run.
    ///
    /// # Errors
    /// As [`Trained::to_core`].
    pub fn embed(&self) -> Result<Embedded, Error> {
        let bytes = self.to_bytes("")?;
        Embedded::from_bytes(&bytes).map_err(|e| Error::Training(format!("the trained model cannot be embedded: {e}")))
    }

    /// Whether covariances are shared, as a word.
    #[must_use]
    pub fn kind_name(&self) -> &'static str {
        match self.densities.kind {
            Kind::Linear => "linear",
            Kind::Quadratic => "quadratic",
        }
    }
}

fn count(value: usize, capacity: usize, what: &str) -> Result<u8, Error> {
    match u8::try_from(value) {
        Ok(count) if value <= capacity => Ok(count),
        _ => Err(Error::Training(format!("{value} {what} are more than the detector's {capacity}"))),
    }
}

fn narrow(cells: &mut [f32], values: &[f64]) {
    cells.iter_mut().zip(values).for_each(|(cell, value)| *cell = *value as f32);
}

fn fill<const COLUMNS: usize>(rows: &mut [[f32; COLUMNS]], matrix: &DMatrix<f64>) {
    for (cells, row) in rows.iter_mut().zip(matrix.row_iter()) {
        cells.iter_mut().zip(row.iter()).for_each(|(cell, value)| *cell = *value as f32);
    }
}
