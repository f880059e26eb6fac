//! The model as bytes, for drives that load it at run time, and for files.
//!
//! ```text
//! "BWMD"  version u16  flags u16  payload length u32  notes length u32  payload  notes  CRC-32 u32
//! ```
//!
//! Little-endian. The CRC (ISO-HDLC, the one of zip and Ethernet) covers everything before it, and every burst of up
//! to 32 bits changes it, so each corrupted byte is found. The payload holds only what is in use, so a detector of
//! any sufficient capacity reads it. The notes are text for people and tools (channels, training set); the firmware
//! ignores them.

use super::{Label, Model, ModelError, Sampling};
use crate::decide::novelty::NO_CLASS;
use crate::decide::{Classifier, Discriminant, EvidencePlan, Features, Kind, Novelty, Projection};
use crate::estimate::{Forgetting, Guard, Memory, Method, Order, Regression};

const MAGIC: [u8; 4] = *b"BWMD";
pub(super) const VERSION: u16 = 3;
const HEADER: usize = 16;
/// No payload and no notes are longer than this; a length field beyond it is corruption.
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

/// The notes of a model file.
///
/// # Errors
/// As [`Model::from_bytes`], for what concerns the file as a whole.
pub fn notes(bytes: &[u8]) -> Result<&str, ModelError> {
    let (_, notes) = open(bytes)?;
    core::str::from_utf8(notes).map_err(|_| ModelError::Value("notes"))
}

/// Checks the frame; gives payload and notes.
fn open(bytes: &[u8]) -> Result<(&[u8], &[u8]), ModelError> {
    let mut header = Reader(bytes);
    if header.array::<4>().map_err(|_| ModelError::Magic)? != MAGIC {
        return Err(ModelError::Magic);
    }
    let version = header.u16()?;
    if version != VERSION {
        return Err(ModelError::Version(version));
    }
    // Reserved: a later version may give them a meaning that this one must not ignore.
    if header.u16()? != 0 {
        return Err(ModelError::Value("flags"));
    }
    let (payload, notes) = (header.u32()? as usize, header.u32()? as usize);
    if payload > MAX_BYTES || notes > MAX_BYTES || bytes.len() != HEADER + payload + notes + 4 {
        return Err(ModelError::Length);
    }
    let (content, check) = bytes.split_at_checked(bytes.len() - 4).ok_or(ModelError::Length)?;
    if Reader(check).u32()? != crc32(content) {
        return Err(ModelError::Checksum);
    }
    let content = content.get(HEADER..).ok_or(ModelError::Length)?;
    content.split_at_checked(payload).ok_or(ModelError::Length)
}

pub(super) struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], ModelError> {
        let (head, rest) = self.0.split_first_chunk().ok_or(ModelError::Length)?;
        self.0 = rest;
        Ok(*head)
    }

    pub(super) fn u8(&mut self) -> Result<u8, ModelError> {
        self.array().map(u8::from_le_bytes)
    }

    pub(super) fn u16(&mut self) -> Result<u16, ModelError> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, ModelError> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn f32(&mut self) -> Result<f32, ModelError> {
        self.array().map(f32::from_le_bytes)
    }

    /// Fills the first `count` cells.
    pub(super) fn fill(&mut self, cells: &mut [f32], count: usize) -> Result<(), ModelError> {
        for cell in cells.iter_mut().take(count) {
            *cell = self.f32()?;
        }
        Ok(())
    }

    /// Fills the lower triangle of so many rows.
    fn fill_lower<const Z: usize>(&mut self, rows: &mut [[f32; Z]; Z], count: usize) -> Result<(), ModelError> {
        rows.iter_mut().take(count).enumerate().try_for_each(|(i, row)| self.fill(row, i + 1))
    }

    /// A size with its capacity.
    pub(super) fn size(&mut self, capacity: usize, what: &'static str) -> Result<u8, ModelError> {
        let size = self.u8()?;
        if size as usize > capacity { Err(ModelError::Capacity(what)) } else { Ok(size) }
    }
}

pub(super) struct Writer<'a> {
    free: &'a mut [u8],
    written: usize,
}

impl Writer<'_> {
    pub(super) fn bytes(&mut self, bytes: &[u8]) -> Result<(), ModelError> {
        let cells = self.free.get_mut(self.written..self.written + bytes.len()).ok_or(ModelError::Buffer)?;
        cells.copy_from_slice(bytes);
        self.written += bytes.len();
        Ok(())
    }

    pub(super) fn floats<'f>(&mut self, values: impl IntoIterator<Item = &'f f32>) -> Result<(), ModelError> {
        values.into_iter().try_for_each(|x| self.bytes(&x.to_le_bytes()))
    }
}

impl<const M: usize, const F: usize, const Z: usize, const C: usize, const K: usize> Model<M, F, Z, C, K> {
    /// Reads a model from its binary form and validates it.
    ///
    /// # Errors
    /// A [`ModelError`]: not a model, another version, truncated, corrupted, too large for these capacities, or with
    /// a value out of range.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        let (payload, _) = open(bytes)?;
        let mut reader = Reader(payload);
        let model = Self::read(&mut reader)?;
        if !reader.0.is_empty() {
            return Err(ModelError::Length);
        }
        model.validate()?;
        Ok(model)
    }

    fn read(reader: &mut Reader<'_>) -> Result<Self, ModelError> {
        let sampling =
            Sampling { interval_s: reader.f32()?, block_mean: reader.u16()?, segment_samples: reader.u32()? };
        let regression = read_regression(reader)?;

        let count = reader.size(F, "features")?;
        let mut features = Features { index: [0; F], count };
        for index in features.index.iter_mut().take(count as usize) {
            *index = reader.u8()?;
        }
        let z = reader.size(Z, "projected coordinates")?;
        let mut projection = Projection { matrix: [[0.0; F]; Z], mean: [0.0; F], count: z };
        reader.fill(&mut projection.mean, count as usize)?;
        for row in projection.matrix.iter_mut().take(z as usize) {
            reader.fill(row, count as usize)?;
        }
        let (discriminant, labels) = Self::read_discriminant(reader, z as usize)?;
        let novelty = read_novelty(reader, z as usize)?;
        let evidence = EvidencePlan { bet: reader.f32()?, limit: reader.f32()?, cap: reader.f32()? };
        let shaft = match flag(reader.u8()?, "shaft flag")? {
            true if K == 0 => return Err(ModelError::Value(super::NO_SHAFT)),
            true => Some(super::shaft::read(reader)?),
            false => None,
        };
        let classifier = Classifier { features, projection, discriminant, novelty };
        Ok(Self { sampling, regression, shaft, classifier, evidence, labels })
    }

    fn read_discriminant(reader: &mut Reader<'_>, z: usize) -> Result<(Discriminant<Z, C>, [Label; C]), ModelError> {
        let classes = reader.size(C, "classes")?;
        let used = classes as usize;
        let kind = if flag(reader.u8()?, "discriminant kind")? { Kind::Quadratic } else { Kind::Linear };
        let mut discriminant = Discriminant {
            kind,
            classes,
            mean: [[0.0; Z]; C],
            whitening: [[[0.0; Z]; Z]; C],
            log_normaliser: [f32::NEG_INFINITY; C],
            log_prior: [f32::NEG_INFINITY; C],
            cost: [[0.0; C]; C],
            reject_cost: f32::INFINITY,
        };
        for row in discriminant.mean.iter_mut().take(used) {
            reader.fill(row, z)?;
        }
        for u in discriminant.whitening.iter_mut().take(covariances(kind, used)) {
            reader.fill_lower(u, z)?;
        }
        reader.fill(&mut discriminant.log_normaliser, used)?;
        reader.fill(&mut discriminant.log_prior, used)?;
        for row in discriminant.cost.iter_mut().take(used) {
            reader.fill(row, used)?;
        }
        discriminant.reject_cost = reader.f32()?;
        let mut labels = [Label::EMPTY; C];
        for label in labels.iter_mut().take(used) {
            *label = Label::from_bytes(reader.array()?).ok_or(ModelError::Value("label"))?;
        }
        Ok((discriminant, labels))
    }

    /// Writes the binary form with `notes` into `buffer`; gives its length.
    ///
    /// # Errors
    /// [`ModelError::Buffer`] where the buffer is too small; any error of [`Model::validate`].
    pub fn to_bytes(&self, notes: &str, buffer: &mut [u8]) -> Result<usize, ModelError> {
        self.validate()?;
        let mut writer = Writer { free: buffer, written: HEADER };
        self.write(&mut writer)?;
        let payload = writer.written - HEADER;
        writer.bytes(notes.as_bytes())?;
        let end = writer.written;
        if payload > MAX_BYTES || notes.len() > MAX_BYTES {
            return Err(ModelError::Length);
        }
        let length = |n: usize| u32::try_from(n).map_err(|_| ModelError::Length);
        writer.written = 0;
        writer.bytes(&MAGIC)?;
        writer.bytes(&VERSION.to_le_bytes())?;
        writer.bytes(&0_u16.to_le_bytes())?;
        writer.bytes(&length(payload)?.to_le_bytes())?;
        writer.bytes(&length(notes.len())?.to_le_bytes())?;
        writer.written = end;
        let check = crc32(writer.free.get(..end).ok_or(ModelError::Buffer)?);
        writer.bytes(&check.to_le_bytes())?;
        Ok(writer.written)
    }

    fn write(&self, writer: &mut Writer<'_>) -> Result<(), ModelError> {
        let (sampling, regression) = (&self.sampling, &self.regression);
        writer.floats([&sampling.interval_s])?;
        writer.bytes(&sampling.block_mean.to_le_bytes())?;
        writer.bytes(&sampling.segment_samples.to_le_bytes())?;
        write_regression(writer, regression)?;

        let Classifier { features, projection, discriminant, novelty } = &self.classifier;
        let (f, z) = (features.count as usize, projection.count as usize);
        writer.bytes(&[features.count])?;
        writer.bytes(features.index.get(..f).ok_or(ModelError::Capacity("features"))?)?;
        writer.bytes(&[projection.count])?;
        writer.floats(projection.mean.iter().take(f))?;
        writer.floats(projection.matrix.iter().take(z).flat_map(|row| row.iter().take(f)))?;

        let used = discriminant.classes as usize;
        writer.bytes(&[discriminant.classes, u8::from(discriminant.kind == Kind::Quadratic)])?;
        writer.floats(discriminant.mean.iter().take(used).flat_map(|row| row.iter().take(z)))?;
        for u in discriminant.whitening.iter().take(covariances(discriminant.kind, used)) {
            writer.floats(lower(u, z))?;
        }
        writer.floats(discriminant.log_normaliser.iter().take(used))?;
        writer.floats(discriminant.log_prior.iter().take(used))?;
        writer.floats(discriminant.cost.iter().take(used).flat_map(|row| row.iter().take(used)))?;
        writer.floats([&discriminant.reject_cost])?;
        self.labels.iter().take(used).try_for_each(|label| writer.bytes(&label.to_bytes()))?;
        write_novelty(writer, novelty, z)?;
        let EvidencePlan { bet, limit, cap } = &self.evidence;
        writer.floats([bet, limit, cap])?;
        writer.bytes(&[u8::from(self.shaft.is_some())])?;
        self.shaft.as_ref().map_or(Ok(()), |shaft| super::shaft::write(writer, shaft))
    }
}

fn read_regression<const M: usize>(reader: &mut Reader<'_>) -> Result<Regression<M>, ModelError> {
    let order = Order::from_array(reader.array()?);
    let mut regression = Regression::new(order, flag(reader.u8()?, "offset flag")?);
    regression.method = if flag(reader.u8()?, "method")? { Method::Instruments } else { Method::LeastSquares };
    if regression.columns() > M {
        return Err(ModelError::Capacity("regressor columns"));
    }
    if flag(reader.u8()?, "memory")? {
        let forgetting = Forgetting { lambda: reader.f32()?, floor: reader.f32()? };
        regression.memory = Memory::Fading(forgetting);
    }
    regression.guard = read_guard(reader)?;
    regression.still = reader.f32()?;
    (regression.settle, regression.handover) = (reader.u16()?, reader.u16()?);
    let n = regression.parameters();
    reader.fill(&mut regression.scale, n + 1)?;
    reader.fill(&mut regression.nominal.delta, n)?;
    regression.nominal.deviation = reader.f32()?;
    Ok(regression)
}

fn write_regression<const M: usize>(writer: &mut Writer<'_>, regression: &Regression<M>) -> Result<(), ModelError> {
    writer.bytes(&regression.order.to_array())?;
    let (instruments, fading) = (regression.method == Method::Instruments, regression.memory != Memory::Segment);
    writer.bytes(&[u8::from(regression.offset), u8::from(instruments), u8::from(fading)])?;
    if let Memory::Fading(forgetting) = &regression.memory {
        writer.floats([&forgetting.lambda, &forgetting.floor])?;
    }
    write_guard(writer, &regression.guard)?;
    writer.floats([&regression.still])?;
    writer.bytes(&regression.settle.to_le_bytes())?;
    writer.bytes(&regression.handover.to_le_bytes())?;
    let n = regression.parameters();
    writer.floats(regression.scale.iter().take(n + 1))?;
    writer.floats(regression.nominal.delta.iter().take(n).chain([&regression.nominal.deviation]))
}

pub(super) fn read_guard(reader: &mut Reader<'_>) -> Result<Guard, ModelError> {
    let mut guard = Guard::OPEN;
    reader.fill(&mut guard.limit, 3)?;
    reader.fill(&mut guard.saturation, 3)?;
    for samples in &mut guard.stuck_samples {
        *samples = reader.u16()?;
    }
    guard.huber = reader.f32()?;
    Ok(guard)
}

pub(super) fn write_guard(writer: &mut Writer<'_>, guard: &Guard) -> Result<(), ModelError> {
    writer.floats(guard.limit.iter().chain(&guard.saturation))?;
    guard.stuck_samples.iter().try_for_each(|samples| writer.bytes(&samples.to_le_bytes()))?;
    writer.floats([&guard.huber])
}

/// The healthy class; nothing follows where there is none.
fn read_novelty<const Z: usize>(reader: &mut Reader<'_>, z: usize) -> Result<Novelty<Z>, ModelError> {
    let mut novelty = Novelty { class: reader.u8()?, ..Novelty::NONE };
    if novelty.class != NO_CLASS {
        reader.fill(&mut novelty.mean, z)?;
        reader.fill_lower(&mut novelty.whitening, z)?;
        for knot in &mut novelty.knots {
            reader.fill(knot, 2)?;
        }
        novelty.limit = reader.f32()?;
    }
    Ok(novelty)
}

fn write_novelty<const Z: usize>(writer: &mut Writer<'_>, novelty: &Novelty<Z>, z: usize) -> Result<(), ModelError> {
    writer.bytes(&[novelty.class])?;
    if novelty.class != NO_CLASS {
        writer.floats(novelty.mean.iter().take(z))?;
        writer.floats(lower(&novelty.whitening, z))?;
        writer.floats(novelty.knots.as_flattened())?;
        writer.floats([&novelty.limit])?;
    }
    Ok(())
}

/// The lower triangle of so many rows.
fn lower<const Z: usize>(rows: &[[f32; Z]; Z], count: usize) -> impl Iterator<Item = &f32> {
    rows.iter().take(count).enumerate().flat_map(|(i, row)| row.iter().take(i + 1))
}

/// How many whitening matrices there are.
fn covariances(kind: Kind, classes: usize) -> usize {
    match kind {
        Kind::Linear => 1,
        Kind::Quadratic => classes,
    }
}

pub(super) fn flag(byte: u8, what: &'static str) -> Result<bool, ModelError> {
    match byte {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(ModelError::Value(what)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crc_check_value() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }
}
