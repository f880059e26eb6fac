//! The model as bytes, for drives that load it at run time, and for files.
//!
//! ```text
//! "BWMD"  version u16  flags u16  payload length u32  notes length u32  payload  notes  CRC-32 u32
//! ```
//!
//! Little-endian. The CRC (ISO-HDLC, that of zip and Ethernet) covers everything before it. It changes for every burst of
//! up to 32 bits, so each corrupted byte is found. The payload starts with the layout, and a plan reads only models of its
//! own layout. The notes are text for people and tools (preparation, training set); the firmware ignores them.

use super::{
    Balance, Channel, Classifier, Constants, Discriminant, EvidenceConstants, Feature, Field, Forgetting, KNOTS, Label,
    Model, ModelError, Name, Novelty, Projection, Regression, Sampling, ShaftConstants, StateVariable, TrackedOrder,
    Tracking,
};
use crate::drive::Park;
use crate::plan::{
    Cells, Kind, Layout, MAX_HARMONICS, Memory, Method, Plan, RegressionLayout, ShaftLayout, Signal, Structure,
};
use crate::reason::FrictionTerm;

const MAGIC: [u8; 4] = *b"BWMD";
const VERSION: u16 = 4;
const HEADER: usize = 16;
/// Stands for "none" in a byte.
const NONE: u8 = u8::MAX;
/// Largest length of payload and of notes; a length field beyond it is corruption.
pub const MAX_BYTES: usize = 1 << 20;

/// CRC-32/ISO-HDLC, bit by bit: 8 instructions a bit, no table in flash.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 & 0_u32.wrapping_sub(crc & 1));
        }
    }
    !crc
}

/// Number of bytes of the model that these bytes start with, so that a flash sector with an erased tail can be read.
///
/// # Errors
/// [`ModelError::NotAModel`], [`ModelError::Version`], or [`ModelError::Truncated`] if the header asks for more bytes.
pub fn stored_len(bytes: &[u8]) -> Result<usize, ModelError> {
    let (payload, notes) = header(bytes)?;
    let length = HEADER.saturating_add(payload).saturating_add(notes).saturating_add(4);
    if length <= bytes.len() { Ok(length) } else { Err(ModelError::Truncated) }
}

/// The notes of a stored model.
///
/// # Errors
/// As [`Model::from_bytes`], for what concerns the bytes as a whole.
pub fn notes(bytes: &[u8]) -> Result<&str, ModelError> {
    let (_, notes) = open(bytes)?;
    core::str::from_utf8(notes).map_err(|_| ModelError::OutOfRange(Field::Notes))
}

/// The layout of a stored model.
///
/// # Errors
/// As [`Model::from_bytes`], for what concerns the bytes as a whole and the layout.
pub fn layout(bytes: &[u8]) -> Result<Layout, ModelError> {
    let (payload, _) = open(bytes)?;
    Reader(payload).layout()
}

/// Lengths of payload and notes.
fn header(bytes: &[u8]) -> Result<(usize, usize), ModelError> {
    let mut header = Reader(bytes);
    if header.array::<4>().map_err(|_| ModelError::NotAModel)? != MAGIC {
        return Err(ModelError::NotAModel);
    }
    let found = header.u16()?;
    if found != VERSION {
        return Err(ModelError::Version { found, supported: VERSION });
    }
    // Reserved: a later build may give them a meaning that this one must not ignore.
    if header.u16()? != 0 {
        return Err(ModelError::OutOfRange(Field::Flags));
    }
    let (payload, notes) = (header.u32()? as usize, header.u32()? as usize);
    if payload > MAX_BYTES || notes > MAX_BYTES { Err(ModelError::Truncated) } else { Ok((payload, notes)) }
}

/// Checks the frame; returns payload and notes.
fn open(bytes: &[u8]) -> Result<(&[u8], &[u8]), ModelError> {
    let (payload, _) = header(bytes)?;
    if stored_len(bytes)? != bytes.len() {
        return Err(ModelError::Truncated);
    }
    let (content, check) = bytes.split_last_chunk().ok_or(ModelError::Truncated)?;
    if u32::from_le_bytes(*check) != crc32(content) {
        return Err(ModelError::Checksum);
    }
    let content = content.get(HEADER..).ok_or(ModelError::Truncated)?;
    content.split_at_checked(payload).ok_or(ModelError::Truncated)
}

impl<P: Plan> Model<P> {
    /// Reads a model from its binary form and checks it.
    ///
    /// # Errors
    /// A [`ModelError`]: not a model, another version, truncated, corrupted, for another plan, or with a value out of
    /// range.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        let (payload, _) = open(bytes)?;
        let mut reader = Reader(payload);
        let layout = reader.layout()?;
        layout.check().map_err(ModelError::Layout)?;
        let plan = P::of(layout).ok_or(ModelError::OtherPlan)?;
        let constants = read(&mut reader, plan)?;
        if !reader.0.is_empty() {
            return Err(ModelError::Truncated);
        }
        Self::new(plan, constants)
    }

    /// Reads the model that these bytes start with; what follows is ignored (the erased tail of a flash sector).
    ///
    /// # Errors
    /// As [`Model::from_bytes`].
    pub fn from_sector(bytes: &[u8]) -> Result<Self, ModelError> {
        Self::from_bytes(bytes.get(..stored_len(bytes)?).unwrap_or(bytes))
    }

    /// Writes the binary form with `notes` into `buffer`; returns its length.
    ///
    /// # Errors
    /// [`ModelError::BufferTooSmall`].
    pub fn to_bytes(&self, notes: &str, buffer: &mut [u8]) -> Result<usize, ModelError> {
        let mut writer = Writer { free: buffer, written: HEADER };
        writer.layout(&self.plan().layout())?;
        write(&mut writer, self.constants())?;
        let payload = writer.written.saturating_sub(HEADER);
        writer.bytes(notes.as_bytes())?;
        let end = writer.written;
        if payload > MAX_BYTES || notes.len() > MAX_BYTES {
            return Err(ModelError::BufferTooSmall);
        }
        let length = |n: usize| u32::try_from(n).map_err(|_| ModelError::BufferTooSmall);
        writer.written = 0;
        writer.bytes(&MAGIC)?;
        writer.bytes(&VERSION.to_le_bytes())?;
        writer.bytes(&0_u16.to_le_bytes())?;
        writer.bytes(&length(payload)?.to_le_bytes())?;
        writer.bytes(&length(notes.len())?.to_le_bytes())?;
        writer.written = end;
        let check = crc32(writer.free.get(..end).ok_or(ModelError::BufferTooSmall)?);
        writer.bytes(&check.to_le_bytes())?;
        Ok(writer.written)
    }
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], ModelError> {
        let (head, rest) = self.0.split_first_chunk().ok_or(ModelError::Truncated)?;
        self.0 = rest;
        Ok(*head)
    }

    fn u8(&mut self) -> Result<u8, ModelError> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, ModelError> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, ModelError> {
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

    fn signal(&mut self) -> Result<Signal, ModelError> {
        let (channel, minus) = (self.u8()?, self.u8()?);
        Ok(Signal { channel, minus: (minus != NONE).then_some(minus) })
    }

    fn layout(&mut self) -> Result<Layout, ModelError> {
        let mut layout = Layout { channels: self.u8()?, ..Layout::EMPTY };
        if self.flag(Field::Layout)? {
            let structure = Structure { offset: self.flag(Field::Layout)?, ..Structure::from_orders(self.array()?) };
            let method = if self.flag(Field::Layout)? { Method::Instruments } else { Method::LeastSquares };
            let memory = match self.choice(2, Field::Layout)? {
                0 => Memory::Segment,
                1 => Memory::LongSegment,
                _ => Memory::Fading,
            };
            let (y, u1, u2) = (self.signal()?, self.signal()?, self.signal()?);
            layout.regression = Some(RegressionLayout { structure, method, memory, y, u1, u2 });
        }
        if self.flag(Field::Layout)? {
            let (current, velocity, reference) = (self.signal()?, self.signal()?, self.signal()?);
            let load = if self.flag(Field::Layout)? { Some(self.signal()?) } else { None };
            let (orders, harmonics) = (self.u8()?, self.u8()?);
            layout.shaft = Some(ShaftLayout { current, velocity, reference, load, orders, harmonics });
        }
        [layout.features, layout.coordinates, layout.classes] = self.array()?;
        layout.discriminant = if self.flag(Field::Layout)? { Kind::Quadratic } else { Kind::Linear };
        Ok(layout)
    }

    fn feature(&mut self) -> Result<Feature, ModelError> {
        let [kind, place] = self.array()?;
        let term = || FrictionTerm::ALL.get(place as usize).copied().ok_or(ModelError::OutOfRange(Field::Feature));
        Ok(match kind {
            0 => Feature::Parameter(place),
            1 => Feature::LogVariance,
            2 => Feature::Friction(term()?),
            3 => Feature::FrictionScore(term()?),
            4 => Feature::LogFrictionVariance,
            5 => Feature::OrderProminence(place),
            6 => Feature::LogOrderAmplitude(place),
            _ => return Err(ModelError::OutOfRange(Field::Feature)),
        })
    }
}

struct Writer<'a> {
    free: &'a mut [u8],
    written: usize,
}

impl Writer<'_> {
    fn bytes(&mut self, bytes: &[u8]) -> Result<(), ModelError> {
        let end = self.written.saturating_add(bytes.len());
        let cells = self.free.get_mut(self.written..end).ok_or(ModelError::BufferTooSmall)?;
        cells.iter_mut().zip(bytes).for_each(|(cell, byte)| *cell = *byte);
        self.written = end;
        Ok(())
    }

    fn floats(&mut self, values: &[f32]) -> Result<(), ModelError> {
        values.iter().try_for_each(|x| self.bytes(&x.to_le_bytes()))
    }

    fn signal(&mut self, signal: Signal) -> Result<(), ModelError> {
        self.bytes(&[signal.channel, signal.minus.unwrap_or(NONE)])
    }

    fn layout(&mut self, layout: &Layout) -> Result<(), ModelError> {
        self.bytes(&[layout.channels, u8::from(layout.regression.is_some())])?;
        if let Some(RegressionLayout { structure, method, memory, y, u1, u2 }) = layout.regression {
            self.bytes(&[u8::from(structure.offset)])?;
            self.bytes(&structure.orders())?;
            let memory = match memory {
                Memory::Segment => 0,
                Memory::LongSegment => 1,
                Memory::Fading => 2,
            };
            self.bytes(&[u8::from(method == Method::Instruments), memory])?;
            [y, u1, u2].into_iter().try_for_each(|signal| self.signal(signal))?;
        }
        self.bytes(&[u8::from(layout.shaft.is_some())])?;
        if let Some(ShaftLayout { current, velocity, reference, load, orders, harmonics }) = layout.shaft {
            [current, velocity, reference].into_iter().try_for_each(|signal| self.signal(signal))?;
            self.bytes(&[u8::from(load.is_some())])?;
            load.map_or(Ok(()), |load| self.signal(load))?;
            self.bytes(&[orders, harmonics])?;
        }
        let quadratic = u8::from(layout.discriminant == Kind::Quadratic);
        self.bytes(&[layout.features, layout.coordinates, layout.classes, quadratic])
    }

    fn feature(&mut self, feature: Feature) -> Result<(), ModelError> {
        let place = |term: FrictionTerm| {
            let places = (0_u8..).zip(FrictionTerm::ALL);
            places.into_iter().find(|(_, other)| *other == term).map_or(0, |(place, _)| place)
        };
        self.bytes(&match feature {
            Feature::Parameter(place) => [0, place],
            Feature::LogVariance => [1, 0],
            Feature::Friction(term) => [2, place(term)],
            Feature::FrictionScore(term) => [3, place(term)],
            Feature::LogFrictionVariance => [4, 0],
            Feature::OrderProminence(place) => [5, place],
            Feature::LogOrderAmplitude(place) => [6, place],
        })
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

fn read<P: Plan>(reader: &mut Reader<'_>, plan: P) -> Result<Constants<P>, ModelError> {
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
    let evidence = EvidenceConstants { bet: reader.f32()?, limit: reader.f32()?, cap: reader.f32()? };
    let labels = list(reader, layout.classes as usize, Label::EMPTY, |reader| reader.name(Field::Label))?;
    Ok(Constants { sampling, channels, regression, shaft, classifier, evidence, labels })
}

fn read_regression<P: Plan>(reader: &mut Reader<'_>, plan: P) -> Result<Regression<P>, ModelError> {
    let layout = plan.layout();
    Ok(Regression {
        scale: reader.floats(layout.columns())?,
        nominal: reader.floats(layout.parameters())?,
        deviation: reader.f32()?,
        forgetting: Forgetting { lambda: reader.f32()?, floor: reader.f32()? },
        huber: reader.f32()?,
        rest: reader.f32()?,
        settle: reader.u16()?,
        handover: reader.u16()?,
    })
}

fn blank_shaft<P: Plan>(plan: P) -> ShaftConstants<P> {
    let order = TrackedOrder::new(1.0, [0.0; MAX_HARMONICS]);
    ShaftConstants {
        current_delay: 0.0,
        balance: Balance {
            interval_s: 1.0,
            filter: StateVariable::new(0.1, 1.0),
            row_interval: 1,
            settle: 0,
            sign_velocity_rad_s: 1.0,
            usual_velocity_rad_s: 1.0,
            scale: [1.0; 4],
            nominal: [0.0; 5],
        },
        tracking: Tracking { orders: Cells::filled(plan.layout().orders(), order), slowest_turn: 0, block_samples: 2 },
    }
}

fn read_shaft<P: Plan>(reader: &mut Reader<'_>, plan: P) -> Result<ShaftConstants<P>, ModelError> {
    let mut shaft = blank_shaft(plan);
    shaft.current_delay = reader.f32()?;
    let balance = &mut shaft.balance;
    balance.interval_s = reader.f32()?;
    balance.filter = StateVariable { gain: reader.f32()?, damping: reader.f32()?, rate_per_s: reader.f32()? };
    (balance.row_interval, balance.settle) = (reader.u8()?, reader.u16()?);
    (balance.sign_velocity_rad_s, balance.usual_velocity_rad_s) = (reader.f32()?, reader.f32()?);
    reader.fill(&mut balance.scale)?;
    reader.fill(&mut balance.nominal)?;
    for order in shaft.tracking.orders.cells_mut() {
        order.order_q16 = reader.u32()?.cast_signed();
        reader.fill(&mut order.weights)?;
    }
    (shaft.tracking.slowest_turn, shaft.tracking.block_samples) = (reader.u32()?, reader.u16()?);
    Ok(shaft)
}

fn read_classifier<P: Plan>(reader: &mut Reader<'_>, plan: P) -> Result<Classifier<P>, ModelError> {
    let layout = plan.layout();
    let features = list(reader, layout.features as usize, Feature::LogVariance, |reader| reader.feature())?;
    let projection =
        Projection { matrix: reader.floats(layout.map())?, mean: reader.floats(layout.features as usize)? };
    let classes = layout.classes as usize;
    let discriminant = Discriminant {
        means: reader.floats(layout.means())?,
        whitening: reader.floats(layout.densities())?,
        log_normaliser: reader.floats(classes)?,
        log_prior: reader.floats(classes)?,
        costs: reader.floats(layout.costs())?,
        reject_cost: reader.f32()?,
    };
    let class = reader.u8()?;
    let mut novelty = Novelty { class: (class != NONE).then_some(class), ..Novelty::none(plan) };
    if novelty.class.is_some() {
        novelty.mean = reader.floats(layout.coordinates as usize)?;
        novelty.whitening = reader.floats(layout.whitening())?;
        let mut knots = [[0.0; 2]; KNOTS];
        reader.fill(knots.as_flattened_mut())?;
        (novelty.knots, novelty.limit) = (knots, reader.f32()?);
    }
    Ok(Classifier { features, projection, discriminant, novelty })
}

fn write<P: Plan>(writer: &mut Writer<'_>, constants: &Constants<P>) -> Result<(), ModelError> {
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
    labels.cells().iter().try_for_each(|label| writer.bytes(&label.to_bytes()))
}

fn write_regression<P: Plan>(writer: &mut Writer<'_>, regression: &Regression<P>) -> Result<(), ModelError> {
    let Regression { scale, nominal, deviation, forgetting, huber, rest, settle, handover } = regression;
    writer.floats(scale.cells())?;
    writer.floats(nominal.cells())?;
    writer.floats(&[*deviation, forgetting.lambda, forgetting.floor, *huber, *rest])?;
    writer.bytes(&settle.to_le_bytes())?;
    writer.bytes(&handover.to_le_bytes())
}

fn write_shaft<P: Plan>(writer: &mut Writer<'_>, shaft: &ShaftConstants<P>) -> Result<(), ModelError> {
    let ShaftConstants { current_delay, balance, tracking } = shaft;
    let StateVariable { gain, damping, rate_per_s } = balance.filter;
    writer.floats(&[*current_delay, balance.interval_s, gain, damping, rate_per_s])?;
    writer.bytes(&[balance.row_interval])?;
    writer.bytes(&balance.settle.to_le_bytes())?;
    writer.floats(&[balance.sign_velocity_rad_s, balance.usual_velocity_rad_s])?;
    writer.floats(&balance.scale)?;
    writer.floats(&balance.nominal)?;
    for order in tracking.orders.cells() {
        writer.bytes(&order.order_q16.to_le_bytes())?;
        writer.floats(&order.weights)?;
    }
    writer.bytes(&tracking.slowest_turn.to_le_bytes())?;
    writer.bytes(&tracking.block_samples.to_le_bytes())
}

fn write_classifier<P: Plan>(writer: &mut Writer<'_>, classifier: &Classifier<P>) -> Result<(), ModelError> {
    let Classifier { features, projection, discriminant, novelty } = classifier;
    features.cells().iter().try_for_each(|feature| writer.feature(*feature))?;
    writer.floats(projection.matrix.cells())?;
    writer.floats(projection.mean.cells())?;
    let Discriminant { means, whitening, log_normaliser, log_prior, costs, reject_cost } = discriminant;
    let lists = [means.cells(), whitening.cells(), log_normaliser.cells(), log_prior.cells(), costs.cells()];
    lists.into_iter().try_for_each(|list| writer.floats(list))?;
    writer.floats(&[*reject_cost])?;
    writer.bytes(&[novelty.class.unwrap_or(NONE)])?;
    if novelty.class.is_some() {
        writer.floats(novelty.mean.cells())?;
        writer.floats(novelty.whitening.cells())?;
        writer.floats(novelty.knots.as_flattened())?;
        writer.floats(&[novelty.limit])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crc_check_value() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }
}
