//! The payload of a stored model → its layout and constants.
//!
//! Lengths are those of the plan; ranges are checked later, except for bytes that select one of a few variants.

use super::bytes::NEWER;
use super::{
    Background, Blocks, Channel, Classifier, Constants, Covariate, Covariates, Directions, Discriminant,
    EvidenceConstants, Feature, Field, Forgetting, KNOTS, Label, Lags, ModelError, Name, Novelty, Projection,
    Regression, Rise, Sampling, ShaftConstants, StateVariable, TERMS, TorqueBalance, TrackedOrder, Tracking,
};
use crate::plan::{
    Array, Cells, Kind, Layout, MAX_HARMONICS, Memory, Method, Plan, RegressionLayout, ShaftLayout, Signal, Structure,
};
use crate::signal::Park;

/// Stands for "none" in a byte.
pub(super) const NONE: u8 = u8::MAX;

/// What is left to be read.
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl Reader<'_> {
    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], ModelError> {
        let (head, rest) = self.0.split_first_chunk().ok_or(ModelError::Truncated)?;
        self.0 = rest;
        Ok(*head)
    }

    fn u8(&mut self) -> Result<u8, ModelError> {
        self.array().map(u8::from_le_bytes)
    }

    pub(super) fn u16(&mut self) -> Result<u16, ModelError> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, ModelError> {
        self.array().map(u32::from_le_bytes)
    }

    fn f32(&mut self) -> Result<f32, ModelError> {
        self.array().map(f32::from_le_bytes)
    }

    fn fill(&mut self, cells: &mut [f32]) -> Result<(), ModelError> {
        cells.iter_mut().try_for_each(|cell| self.f32().map(|x| *cell = x))
    }

    fn floats<C: Cells<f32>>(&mut self, length: usize) -> Result<C, ModelError> {
        let mut cells = C::filled(length, 0.0);
        self.fill(cells.cells_mut())?;
        Ok(cells)
    }

    /// A byte that is 0 … `most`.
    fn choice(&mut self, most: u8, field: Field) -> Result<u8, ModelError> {
        let byte = self.u8()?;
        if byte <= most { Ok(byte) } else { Err(ModelError::OutOfRange(field)) }
    }

    fn flag(&mut self, field: Field) -> Result<bool, ModelError> {
        self.choice(1, field).map(|byte| byte == 1)
    }

    fn name<const N: usize>(&mut self, field: Field) -> Result<Name<N>, ModelError> {
        Name::from_bytes(self.array()?).ok_or(ModelError::OutOfRange(field))
    }

    /// Three signals of one part; a channel that a signal does not have is `NONE`.
    fn signals(&mut self) -> Result<[Signal; 3], ModelError> {
        let [c0, m0, c1, m1, c2, m2] = self.array()?;
        let signal = |channel, minus: u8| Signal { channel, minus: (minus != NONE).then_some(minus) };
        Ok([signal(c0, m0), signal(c1, m1), signal(c2, m2)])
    }

    /// The layout.
    pub(super) fn layout(&mut self) -> Result<Layout, ModelError> {
        let mut layout = Layout { channels: self.u8()?, ..Layout::EMPTY };
        if self.flag(Field::Layout)? {
            let structure = Structure { offset: self.flag(Field::Layout)?, ..Structure::from_orders(self.array()?) };
            let method = if self.flag(Field::Layout)? { Method::Instruments } else { Method::LeastSquares };
            let memory = match self.u8()? {
                0 => Memory::Segment,
                2 => Memory::Fading,
                _ => return Err(ModelError::OutOfRange(Field::Layout)),
            };
            let [y, u1, u2] = self.signals()?;
            layout.regression = Some(RegressionLayout { structure, method, memory, y, u1, u2 });
        }
        if self.flag(Field::Layout)? {
            let [current, velocity, load] = self.signals()?;
            let measured = |signal: Signal| (signal.channel != NONE).then_some(signal);
            let (velocity, load) = (measured(velocity), measured(load));
            let (orders, steps) = (self.u8()?, self.u8()?);
            let (harmonics, decimation) = (steps & 0xF, (steps >> 4).wrapping_add(1));
            layout.shaft = Some(ShaftLayout { current, velocity, load, orders, harmonics, decimation });
        }
        layout.averaged = self.u16()?;
        [layout.features, layout.covariates, layout.coordinates, layout.rising] = self.array()?;
        [layout.directions, layout.classes] = self.array()?;
        layout.discriminant = if self.flag(Field::Layout)? { Kind::Quadratic } else { Kind::Linear };
        Ok(layout)
    }

    pub(crate) fn feature(&mut self) -> Result<Feature, ModelError> {
        let code = self.array()?;
        let refused = if Feature::is_newer(code) { NEWER } else { ModelError::OutOfRange(Field::Feature) };
        Feature::of_code(code).ok_or(refused)
    }
}

/// `length` elements, each read by `element`.
fn list<T: Clone, C: Cells<T>>(
    reader: &mut Reader<'_>,
    length: usize,
    blank: T,
    mut element: impl FnMut(&mut Reader<'_>) -> Result<T, ModelError>,
) -> Result<C, ModelError> {
    let mut cells = C::filled(length, blank);
    for cell in cells.cells_mut() {
        *cell = element(reader)?;
    }
    Ok(cells)
}

pub(super) fn read<P: Plan>(reader: &mut Reader<'_>, plan: P) -> Result<Constants<P>, ModelError> {
    let layout = plan.layout();
    let sampling = Sampling {
        interval_s: reader.f32()?,
        park: match reader.choice(2, Field::SamplingInterval)? {
            0 => None,
            1 => Some(Park::Standard),
            _ => Some(Park::Thesis),
        },
        block_mean: reader.u16()?,
        segment_samples: reader.u32()?,
    };
    let blank = Channel { name: Name::EMPTY, unit: Name::EMPTY, limit: 0.0, saturation: 0.0, stuck_samples: 0 };
    let channels = list(reader, layout.channels as usize, blank, |reader| {
        Ok(Channel {
            name: reader.name(Field::ChannelName)?,
            unit: reader.name(Field::ChannelName)?,
            limit: reader.f32()?,
            saturation: reader.f32()?,
            stuck_samples: reader.u16()?,
        })
    })?;
    let regression = list(reader, layout.regressed(), Regression::new(plan), |reader| read_regression(reader, plan))?;
    let shaft = match layout.watched() {
        0 => Cells::from_fn(0, |_| blank_shaft(plan)),
        _ => list(reader, 1, blank_shaft(plan), |reader| read_shaft(reader, plan))?,
    };
    let classifier = read_classifier(reader, plan)?;
    let evidence = EvidenceConstants {
        bet: reader.f32()?,
        limit: reader.f32()?,
        cap: reader.f32()?,
        segments_a_run: reader.u32()?,
        log_mean: reader.f32()?,
        defect_log_mean: reader.f32()?,
    };
    let labels = list(reader, layout.classes as usize, Label::EMPTY, |reader| reader.name(Field::Label))?;
    Ok(Constants { sampling, channels, regression, shaft, classifier, evidence, labels })
}

fn read_regression<P: Plan>(reader: &mut Reader<'_>, plan: P) -> Result<Regression<P>, ModelError> {
    let layout = plan.layout();
    Ok(Regression {
        scale: reader.floats(layout.columns())?,
        nominal: reader.floats(layout.parameters())?,
        forgetting: Forgetting { lambda: reader.f32()?, floor: reader.f32()? },
        rest: reader.f32()?,
        settle: reader.u16()?,
        handover: reader.u16()?,
    })
}

fn blank_shaft<P: Plan>(plan: P) -> ShaftConstants<P> {
    let order = TrackedOrder::new(1.0, [0.0; MAX_HARMONICS]);
    ShaftConstants {
        lags: Lags::default(),
        balance: TorqueBalance {
            interval_s: 1.0,
            filter: StateVariable::new(0.1, 1.0),
            row_interval: 1,
            settle: 0,
            adapt_after_rows: 0,
            sign_velocity_rad_s: 1.0,
            stribeck_velocity_rad_s: 1.0,
            usual_velocity_rad_s: 1.0,
            usual_load_nm: 0.0,
            row_spread: 1.0,
            scale: [1.0; 8],
            nominal: [0.0; TERMS],
            prior: [1.0; TERMS],
            deviation: 1.0,
            largest_change_rad: 1.0,
        },
        tracking: Tracking { orders: Cells::filled(plan.layout().orders(), order), blocks: Blocks::EMPTY },
    }
}

fn read_shaft<P: Plan>(reader: &mut Reader<'_>, plan: P) -> Result<ShaftConstants<P>, ModelError> {
    let mut shaft = blank_shaft(plan);
    shaft.lags = Lags { current: reader.f32()?, velocity: reader.f32()?, load: reader.f32()? };
    let balance = &mut shaft.balance;
    balance.interval_s = reader.f32()?;
    balance.filter = StateVariable { gain: reader.f32()?, damping: reader.f32()?, rate_per_s: reader.f32()? };
    (balance.row_interval, balance.settle) = (reader.u8()?, reader.u16()?);
    (balance.sign_velocity_rad_s, balance.stribeck_velocity_rad_s) = (reader.f32()?, reader.f32()?);
    balance.usual_velocity_rad_s = reader.f32()?;
    balance.usual_load_nm = reader.f32()?;
    (balance.row_spread, balance.deviation) = (reader.f32()?, reader.f32()?);
    balance.adapt_after_rows = reader.u16()?;
    reader.fill(&mut balance.scale)?;
    reader.fill(&mut balance.nominal)?;
    reader.fill(&mut balance.prior)?;
    balance.largest_change_rad = reader.f32()?;
    for order in shaft.tracking.orders.cells_mut() {
        order.order_q16 = reader.u32()?.cast_signed();
        reader.fill(&mut order.weights)?;
        (order.slip_ratio, order.needed_score) = (reader.f32()?, reader.f32()?);
        (order.most_relative, order.most_a) = (reader.f32()?, reader.f32()?);
    }
    let blocks = &mut shaft.tracking.blocks;
    for control in &mut blocks.controls {
        *control = reader.u32()?.cast_signed();
    }
    blocks.cell_turns_log2 = reader.u8()?.cast_signed();
    (blocks.slip, blocks.slowest_rad_s) = (reader.f32()?, reader.f32()?);
    (blocks.pole, blocks.high_pass) = (reader.f32()?, reader.f32()?);
    Ok(shaft)
}

fn read_classifier<P: Plan>(reader: &mut Reader<'_>, plan: P) -> Result<Classifier<P>, ModelError> {
    let layout = plan.layout();
    let features = list(reader, layout.features as usize, Feature::LogVariance, |reader| reader.feature())?;
    let list = list(reader, layout.covariates as usize, Covariate::BLANK, |reader| {
        let feature = reader.feature()?;
        let (centre, low, high, usual) = (reader.f32()?, reader.f32()?, reader.f32()?, reader.f32()?);
        Ok(Covariate { feature, centre, low, high, usual })
    })?;
    let mut map: Array<P::CovariateMap, [f32; 2]> = Cells::filled(layout.covariate_map_len(), [0.0; 2]);
    reader.fill(map.cells_mut().as_flattened_mut())?;
    let covariates = Covariates { list, map };
    let (matrix, count) = (reader.floats(layout.map())?, layout.features as usize);
    let projection = Projection { matrix, mean: reader.floats(count)?, usual: reader.floats(count)? };
    let classes = layout.classes as usize;
    let discriminant = Discriminant {
        means: reader.floats(layout.means())?,
        factors: reader.floats(layout.densities())?,
        log_prior: reader.floats(classes)?,
        costs: reader.floats(layout.costs())?,
        reject_cost: reader.f32()?,
    };
    let class = reader.u8()?;
    let mut novelty = Novelty { class: (class != NONE).then_some(class), ..Novelty::none(plan) };
    if novelty.class.is_some() {
        novelty.mean = reader.floats(layout.coordinates as usize)?;
        novelty.factor = reader.floats(layout.density())?;
        let mut knots = [[0.0; 2]; KNOTS];
        reader.fill(knots.as_flattened_mut())?;
        (novelty.knots, novelty.limit) = (knots, reader.f32()?);
        if layout.rising > 0 {
            (novelty.freedom, novelty.acceptable) = (reader.f32()?, reader.f32()?);
            for rise in novelty.rises.cells_mut() {
                *rise = Rise { fall: reader.f32()?, reach: reader.f32()? };
            }
            reader.fill(novelty.laws.cells_mut().as_flattened_mut().as_flattened_mut())?;
        }
        if layout.directions > 0 {
            read_directions(reader, &mut novelty.directions)?;
        }
    }
    Ok(Classifier { features, covariates, projection, discriminant, novelty })
}

fn read_directions<P: Plan>(reader: &mut Reader<'_>, directions: &mut Directions<P>) -> Result<(), ModelError> {
    (directions.usual_segments, directions.margin) = (reader.f32()?, reader.f32()?);
    directions.most_runs = reader.u16()?;
    for direction in directions.list.cells_mut() {
        (direction.coordinate, direction.order) = (reader.u8()?, reader.flag(Field::Direction)?);
        for background in &mut direction.background {
            *background = Background { coordinate: reader.u8()?, weight: reader.f32()? };
        }
        (direction.centre, direction.between) = (reader.f32()?, reader.f32()?);
        (direction.run, direction.segment) = (reader.f32()?, reader.f32()?);
        (direction.skewness, direction.correlation) = (reader.f32()?, reader.f32()?);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
