//! The layout and constants of a model → the payload of its binary form, in the order in which [`super::reader`] reads.

use super::reader::NONE;
use super::{
    Background, Blocks, Channel, Classifier, Constants, Covariate, Direction, Directions, Discriminant, Feature, Lags,
    ModelError, Regression, Rise, ShaftConstants, StateVariable,
};
use crate::plan::{Cells, Kind, Layout, Memory, Method, Plan, RegressionLayout, ShaftLayout, Signal};
use crate::signal::Park;

/// Where the bytes go.
pub(crate) trait Sink {
    fn take(&mut self, bytes: &[u8]) -> Result<(), ModelError>;
}

/// A buffer, and how much of it is written.
pub(crate) struct Buffer<'a> {
    pub(crate) free: &'a mut [u8],
    pub(crate) written: usize,
}

impl Sink for Buffer<'_> {
    fn take(&mut self, bytes: &[u8]) -> Result<(), ModelError> {
        let end = self.written.saturating_add(bytes.len());
        let cells = self.free.get_mut(self.written..end).ok_or(ModelError::BufferTooSmall)?;
        cells.iter_mut().zip(bytes).for_each(|(cell, byte)| *cell = *byte);
        self.written = end;
        Ok(())
    }
}

/// Writes numbers as bytes.
pub(crate) struct Writer<S>(pub(crate) S);

impl<S: Sink> Writer<S> {
    pub(super) fn bytes(&mut self, bytes: &[u8]) -> Result<(), ModelError> {
        self.0.take(bytes)
    }

    fn floats(&mut self, values: &[f32]) -> Result<(), ModelError> {
        values.iter().try_for_each(|x| self.bytes(&x.to_le_bytes()))
    }

    fn signal(&mut self, signal: Signal) -> Result<(), ModelError> {
        self.bytes(&[signal.channel, signal.minus.unwrap_or(NONE)])
    }

    pub(super) fn layout(&mut self, layout: &Layout) -> Result<(), ModelError> {
        self.bytes(&[layout.channels, u8::from(layout.regression.is_some())])?;
        if let Some(RegressionLayout { structure, method, memory, y, u1, u2 }) = layout.regression {
            self.bytes(&[u8::from(structure.offset)])?;
            self.bytes(&structure.orders())?;
            let memory = match memory {
                Memory::Segment => 0,
                Memory::Fading => 2,
            };
            self.bytes(&[u8::from(method == Method::Instruments), memory])?;
            [y, u1, u2].into_iter().try_for_each(|signal| self.signal(signal))?;
        }
        self.bytes(&[u8::from(layout.shaft.is_some())])?;
        if let Some(ShaftLayout { current, velocity, load, orders, harmonics, decimation }) = layout.shaft {
            self.signal(current)?;
            for measured in [velocity, load] {
                self.signal(measured.unwrap_or(Signal::channel(NONE)))?;
            }
            // The high half of the byte is the decimation less one, so that 0 is that of each sample.
            self.bytes(&[orders, harmonics & 0xF | decimation.wrapping_sub(1) << 4])?;
        }
        let quadratic = u8::from(layout.discriminant == Kind::Quadratic);
        self.bytes(&layout.averaged.to_le_bytes())?;
        let Layout { features, covariates, coordinates, rising, directions, classes, .. } = *layout;
        self.bytes(&[features, covariates, coordinates, rising, directions, classes, quadratic])
    }

    pub(crate) fn feature(&mut self, feature: Feature) -> Result<(), ModelError> {
        self.bytes(&feature.code())
    }
}

pub(super) fn write<P: Plan>(writer: &mut Writer<impl Sink>, constants: &Constants<P>) -> Result<(), ModelError> {
    let Constants { sampling, channels, regression, shaft, classifier, evidence, labels } = constants;
    let park = match sampling.park {
        None => 0,
        Some(Park::Standard) => 1,
        Some(Park::Thesis) => 2,
    };
    writer.floats(&[sampling.interval_s])?;
    writer.bytes(&[park])?;
    writer.bytes(&sampling.block_mean.to_le_bytes())?;
    writer.bytes(&sampling.segment_samples.to_le_bytes())?;
    for Channel { name, unit, limit, saturation, stuck_samples } in channels.cells() {
        writer.bytes(&name.to_bytes())?;
        writer.bytes(&unit.to_bytes())?;
        writer.floats(&[*limit, *saturation])?;
        writer.bytes(&stuck_samples.to_le_bytes())?;
    }
    regression.part().map_or(Ok(()), |regression| write_regression(writer, regression))?;
    shaft.part().map_or(Ok(()), |shaft| write_shaft(writer, shaft))?;
    write_classifier(writer, classifier)?;
    writer.floats(&[evidence.bet, evidence.limit, evidence.cap])?;
    writer.bytes(&evidence.segments_a_run.to_le_bytes())?;
    writer.floats(&[evidence.log_mean, evidence.defect_log_mean])?;
    labels.cells().iter().try_for_each(|label| writer.bytes(&label.to_bytes()))
}

fn write_regression<P: Plan>(writer: &mut Writer<impl Sink>, regression: &Regression<P>) -> Result<(), ModelError> {
    let Regression { scale, nominal, forgetting, rest, settle, handover } = regression;
    writer.floats(scale.cells())?;
    writer.floats(nominal.cells())?;
    writer.floats(&[forgetting.lambda, forgetting.floor, *rest])?;
    writer.bytes(&settle.to_le_bytes())?;
    writer.bytes(&handover.to_le_bytes())
}

fn write_shaft<P: Plan>(writer: &mut Writer<impl Sink>, shaft: &ShaftConstants<P>) -> Result<(), ModelError> {
    let ShaftConstants { lags: Lags { current, velocity, load }, balance, tracking } = shaft;
    let StateVariable { gain, damping, rate_per_s } = balance.filter;
    writer.floats(&[*current, *velocity, *load, balance.interval_s, gain, damping, rate_per_s])?;
    writer.bytes(&[balance.row_interval])?;
    writer.bytes(&balance.settle.to_le_bytes())?;
    writer.floats(&[balance.sign_velocity_rad_s, balance.stribeck_velocity_rad_s])?;
    writer.floats(&[balance.usual_velocity_rad_s, balance.usual_load_nm])?;
    writer.floats(&[balance.row_spread, balance.deviation])?;
    writer.bytes(&balance.adapt_after_rows.to_le_bytes())?;
    writer.floats(&balance.scale)?;
    writer.floats(&balance.nominal)?;
    writer.floats(&balance.prior)?;
    writer.floats(&[balance.largest_change_rad])?;
    for order in tracking.orders.cells() {
        writer.bytes(&order.order_q16.to_le_bytes())?;
        writer.floats(&order.weights)?;
        writer.floats(&[order.slip_ratio, order.needed_score, order.most_relative, order.most_a])?;
    }
    let Blocks { controls, cell_turns_log2, slip, slowest_rad_s, pole, high_pass } = tracking.blocks;
    controls.into_iter().try_for_each(|order| writer.bytes(&order.to_le_bytes()))?;
    writer.bytes(&cell_turns_log2.to_le_bytes())?;
    writer.floats(&[slip, slowest_rad_s, pole, high_pass])
}

fn write_classifier<P: Plan>(writer: &mut Writer<impl Sink>, classifier: &Classifier<P>) -> Result<(), ModelError> {
    let Classifier { features, covariates, projection, discriminant, novelty } = classifier;
    features.cells().iter().try_for_each(|feature| writer.feature(*feature))?;
    for Covariate { feature, centre, low, high, usual } in covariates.list.cells() {
        writer.feature(*feature)?;
        writer.floats(&[*centre, *low, *high, *usual])?;
    }
    writer.floats(covariates.map.cells().as_flattened())?;
    writer.floats(projection.matrix.cells())?;
    writer.floats(projection.mean.cells())?;
    writer.floats(projection.usual.cells())?;
    let Discriminant { means, factors, log_prior, costs, reject_cost } = discriminant;
    let lists = [means.cells(), factors.cells(), log_prior.cells(), costs.cells()];
    lists.into_iter().try_for_each(|list| writer.floats(list))?;
    writer.floats(&[*reject_cost])?;
    writer.bytes(&[novelty.class.unwrap_or(NONE)])?;
    if novelty.class.is_some() {
        writer.floats(novelty.mean.cells())?;
        writer.floats(novelty.factor.cells())?;
        writer.floats(novelty.knots.as_flattened())?;
        writer.floats(&[novelty.limit])?;
        if !novelty.laws.cells().is_empty() {
            writer.floats(&[novelty.freedom, novelty.acceptable])?;
            novelty.rises.cells().iter().try_for_each(|Rise { fall, reach }| writer.floats(&[*fall, *reach]))?;
            writer.floats(novelty.laws.cells().as_flattened().as_flattened())?;
        }
        if !novelty.directions.list.cells().is_empty() {
            write_directions(writer, &novelty.directions)?;
        }
    }
    Ok(())
}

fn write_directions<P: Plan>(writer: &mut Writer<impl Sink>, directions: &Directions<P>) -> Result<(), ModelError> {
    writer.floats(&[directions.usual_segments, directions.margin])?;
    writer.bytes(&directions.most_runs.to_le_bytes())?;
    for direction in directions.list.cells() {
        let Direction { coordinate, order, background, centre, between, run, segment, skewness, correlation } =
            direction;
        writer.bytes(&[*coordinate, u8::from(*order)])?;
        for Background { coordinate, weight } in background {
            writer.bytes(&[*coordinate])?;
            writer.floats(&[*weight])?;
        }
        writer.floats(&[*centre, *between, *run, *segment, *skewness, *correlation])?;
    }
    Ok(())
}
