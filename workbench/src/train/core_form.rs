//! A trained model in the core's single-precision form.

use bearing_watch::decide::{Classifier, Discriminant, Features, Kind, Novelty, Projection};
use bearing_watch::estimate::MAX_LONG_SEGMENT_SAMPLES;
use bearing_watch::estimate::{TrackedOrder, Tracking};
use bearing_watch::model::MAX_BYTES;
use bearing_watch::{Label, Model, ModelError, Regression, Sampling, ShaftModel};
use nalgebra::DMatrix;

use super::{Shrink, Shrinkage, Trained};
use crate::Error;
use crate::core::{Embedded, MAX_COLUMNS, MAX_ORDERS, with_room};

impl Trained {
    /// The core's form. Capacities beyond what is in use hold neutral values.
    ///
    /// # Errors
    /// What does not fit the capacities, or lies out of the range of single precision.
    pub fn to_core<const M: usize, const F: usize, const Z: usize, const C: usize, const K: usize>(
        &self,
    ) -> Result<Model<M, F, Z, C, K>, Error> {
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
            reject_cost: self.recipe.alarms.reject_cost as f32,
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

        let model = Model {
            sampling: Sampling {
                interval_s: self.interval_s as f32,
                block_mean: u16::try_from(self.block_mean)
                    .map_err(|_| Error::Usage("--block-mean is at most 65535".into()))?,
                segment_samples: samples(self.segment_samples)?,
            },
            regression: at_capacity(&self.regression),
            shaft: self.shaft.as_ref().map(orders_at_capacity),
            classifier: Classifier { features, projection, discriminant, novelty: self.novelty()? },
            evidence: self.watch.evidence,
            labels,
        };
        model.validate().map_err(refused)?;
        Ok(model)
    }

    pub(crate) fn novelty<const Z: usize>(&self) -> Result<Novelty<Z>, Error> {
        let mut novelty = Novelty::NONE;
        if let Some(gate) = &self.watch.gate {
            novelty.class = count(gate.class, self.classes.len(), "classes")?;
            narrow(&mut novelty.mean, gate.mean.as_slice());
            fill(&mut novelty.whitening, &gate.whitening);
            novelty.knots = gate.knots.map(|knot| knot.map(|x| x as f32));
            novelty.limit = gate.limit as f32;
        }
        Ok(novelty)
    }

    /// The binary form, with notes.
    ///
    /// # Errors
    /// As [`Trained::to_core`].
    pub fn to_bytes(&self, notes: &str) -> Result<Vec<u8>, Error> {
        with_room(|| {
            let model: Box<Model<MAX_COLUMNS, 100, 100, 8, MAX_ORDERS>> = Box::new(self.to_core()?);
            bytes(&model, notes)
        })
    }

    /// The model ready to run.
    ///
    /// # Errors
    /// As [`Trained::to_core`].
    pub fn embed(&self) -> Result<Embedded, Error> {
        Embedded::from_bytes(&self.to_bytes("")?).map_err(refused)
    }

    /// Whether covariances are shared, and how shrunk.
    #[must_use]
    pub fn kind_name(&self) -> String {
        let kind = match self.densities.kind {
            Kind::Linear => "linear",
            Kind::Quadratic => "quadratic",
        };
        let shrinkage = match (self.recipe.shrink, &self.choice) {
            (Shrink::To(shrinkage), _) => Some(shrinkage),
            (_, choice) => choice.as_ref().map(|choice| choice.shrinkage),
        };
        shrinkage.map_or_else(
            || kind.into(),
            |Shrinkage { lambda, gamma }| format!("{kind} (shrunk by λ = {lambda}, γ = {gamma})"),
        )
    }
}

pub(super) fn refused(error: ModelError) -> Error {
    Error::Training(format!("the trained model cannot be embedded: {error}"))
}

pub(super) fn samples(segment: usize) -> Result<u32, Error> {
    u32::try_from(segment)
        .map_err(|_| Error::Usage(format!("a segment has at most {MAX_LONG_SEGMENT_SAMPLES} samples")))
}

/// The binary form of a model.
pub(super) fn bytes<const M: usize, const F: usize, const Z: usize, const C: usize, const K: usize>(
    model: &Model<M, F, Z, C, K>,
    notes: &str,
) -> Result<Vec<u8>, Error> {
    let mut buffer = vec![0; MAX_BYTES];
    let length = model.to_bytes(notes, &mut buffer).map_err(refused)?;
    buffer.truncate(length);
    Ok(buffer)
}

/// The same constants with another number of places. What does not fit is left out, and the model then refused for its
/// columns.
fn at_capacity<const M: usize>(from: &Regression<MAX_COLUMNS>) -> Regression<M> {
    let Regression { order, offset, method, memory, ref scale, ref nominal, guard, settle, handover, still } = *from;
    let mut to = Regression { method, memory, guard, settle, handover, still, ..Regression::new(order, offset) };
    to.scale.iter_mut().zip(scale).for_each(|(cell, x)| *cell = *x);
    to.nominal.delta.iter_mut().zip(&nominal.delta).for_each(|(cell, x)| *cell = *x);
    to.nominal.deviation = nominal.deviation;
    to
}

/// Likewise; orders that do not fit make the count too large, and the model is refused for them.
fn orders_at_capacity<const K: usize>(from: &ShaftModel<MAX_ORDERS>) -> ShaftModel<K> {
    let ShaftModel { guard, current_delay, balance, tracking } = *from;
    let Tracking { orders, count, harmonics, still, block_samples } = tracking;
    let mut to = Tracking { orders: [TrackedOrder::NONE; K], count, harmonics, still, block_samples };
    to.orders.iter_mut().zip(orders).for_each(|(cell, order)| *cell = order);
    ShaftModel { guard, current_delay, balance, tracking: to }
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
