//! The trained constants, immutable: in flash as a `const`, or read from a checked binary blob.

mod binary;
mod shaft;

pub use binary::{MAX_BYTES, notes};

use crate::decide::novelty::NO_CLASS;
use crate::decide::{Classifier, EvidencePlan, Novelty, features};
use crate::estimate::{
    Guard, MAX_LAMBDA, MAX_LONG_SEGMENT_SAMPLES, MAX_OUTPUT_TERMS, Memory, Method, Regression, ShaftModel, is_stable,
};

pub(crate) const NO_SHAFT: &str = "shaft, which this detector was not compiled to watch,";

/// Longest block mean: plain sums of more samples lose digits.
pub const MAX_BLOCK_MEAN: u16 = 1000;

/// When samples are taken and how many make a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sampling {
    /// Interval of the samples fed to [`Detector::step`](crate::Detector::step), s; informative, 0 where unknown.
    pub interval_s: f32,
    /// Samples averaged into one before identification; 1 for none, at most [`MAX_BLOCK_MEAN`].
    pub block_mean: u16,
    /// Samples a segment, after averaging; at most [`MAX_SEGMENT_SAMPLES`](crate::estimate::MAX_SEGMENT_SAMPLES), or what
    /// another [`Accumulator`](crate::estimate::Accumulator) takes.
    pub segment_samples: u32,
}

/// Name of a class: at most 16 bytes of UTF-8.
///
/// ```
/// use bearing_watch::Label;
/// const HEALTHY: Label = match Label::new("healthy") { Some(label) => label, None => Label::EMPTY };
/// assert_eq!(HEALTHY.as_str(), "healthy");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Label([u8; 16]);

impl Label {
    /// The label of a class that is not in use.
    pub const EMPTY: Self = Self([0; 16]);

    /// From a name; nothing where it is longer than 16 bytes or holds a zero byte.
    #[must_use]
    pub const fn new(name: &str) -> Option<Self> {
        let mut bytes = [0; 16];
        let mut from = name.as_bytes();
        let mut to = bytes.as_mut_slice();
        while let Some((byte, rest)) = from.split_first() {
            if *byte == 0 {
                return None;
            }
            let Some((cell, next)) = to.split_first_mut() else { return None };
            *cell = *byte;
            from = rest;
            to = next;
        }
        Some(Self(bytes))
    }

    /// From the zero-padded bytes of a binary model; nothing where they are no such name.
    #[must_use]
    pub fn from_bytes(bytes: [u8; 16]) -> Option<Self> {
        let label = Self(bytes);
        let name = label.name_bytes();
        let padding = bytes.get(name.len()..).unwrap_or(&[]);
        (core::str::from_utf8(name).is_ok() && padding.iter().all(|&b| b == 0)).then_some(label)
    }

    /// The bytes, padded with zeros.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; 16] {
        self.0
    }

    fn name_bytes(&self) -> &[u8] {
        self.0.split(|&b| b == 0).next().unwrap_or(&[])
    }

    /// The name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(self.name_bytes()).unwrap_or("")
    }
}

/// Everything that was trained. Capacities: `M` columns, `F` features, `Z` coordinates, `C` classes, `K` bearing orders.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Model<const M: usize, const F: usize, const Z: usize, const C: usize, const K: usize = 0> {
    /// Rate and segment length.
    pub sampling: Sampling,
    /// Structure, scales and limits of the regression.
    pub regression: Regression<M>,
    /// Torque balance and bearing orders, where the shaft is watched; that takes a `K` of at least one, be it not in use.
    pub shaft: Option<ShaftModel<K>>,
    /// Features, projection, discriminant and novelty.
    pub classifier: Classifier<F, Z, C>,
    /// Of the alarm over many segments, for [`Evidence`](crate::Evidence).
    pub evidence: EvidencePlan,
    /// Class names.
    pub labels: [Label; C],
}

/// Why a model is refused. The payload names the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ModelError {
    /// A size exceeds the capacity of the type that should hold it.
    Capacity(&'static str),
    /// A value is out of its range, or not finite.
    Value(&'static str),
    /// Not a model file at all.
    Magic,
    /// A model file of another version of the format.
    Version(u16),
    /// The file is shorter or longer than it says.
    Length,
    /// The checksum does not fit: the file was altered.
    Checksum,
    /// The buffer to write to is too small.
    Buffer,
}

impl core::fmt::Display for ModelError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Capacity(what) => write!(f, "the model has more {what} than this detector can hold"),
            Self::Value(what) => write!(f, "the model's {what} is out of range"),
            Self::Magic => f.write_str("not a bearing-watch model"),
            Self::Version(found) => {
                write!(f, "model format version {found}, but this build reads version {}", binary::VERSION)
            }
            Self::Length => f.write_str("the model is truncated or has trailing bytes"),
            Self::Checksum => f.write_str("the model's checksum does not fit its content: it is corrupted"),
            Self::Buffer => f.write_str("the buffer is too small for the model"),
        }
    }
}

impl core::error::Error for ModelError {}

impl<const M: usize, const F: usize, const Z: usize, const C: usize, const K: usize> Model<M, F, Z, C, K> {
    /// Name of a class, empty where there is no such class.
    #[must_use]
    pub fn label(&self, class: u8) -> &str {
        self.labels.get(class as usize).map_or("", Label::as_str)
    }

    /// Checks every size against the capacities and every number against its range.
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub fn validate(&self) -> Result<(), ModelError> {
        use ModelError::{Capacity, Value};
        let (sampling, regression) = (&self.sampling, &self.regression);
        let classifier = &self.classifier;
        let discriminant = &classifier.discriminant;
        if regression.order.parameters() == 0 {
            return Err(Value("order"));
        }
        // Places of columns are bytes.
        if regression.capacity() > M.min(255) {
            return Err(Capacity("regressor columns"));
        }
        check(sampling.interval_s.is_finite() && sampling.interval_s >= 0.0, "sampling interval")?;
        check((1..=MAX_BLOCK_MEAN).contains(&sampling.block_mean), "block mean")?;
        let least = regression.columns() + regression.order.depth();
        let long_enough = sampling.segment_samples as usize > least;
        check(long_enough && sampling.segment_samples <= MAX_LONG_SEGMENT_SAMPLES, "segment length")?;
        validate_regression(regression, sampling.segment_samples)?;

        let features = &classifier.features;
        let used = |count: u8, capacity: usize, what| {
            if count as usize > capacity { Err(Capacity(what)) } else { check(count > 0, what) }
        };
        used(features.count, F, "features")?;
        used(classifier.projection.count, Z, "projected coordinates")?;
        used(discriminant.classes, C, "classes")?;
        if let Some(shaft) = &self.shaft {
            // Known when compiling: what watches no shaft carries no checks of one.
            if K == 0 {
                return Err(ModelError::Value(NO_SHAFT));
            }
            shaft::validate(shaft)?;
        }
        let orders = self.shaft.as_ref().map(|shaft| shaft.tracking.count);
        let in_range = |index: &u8| features::exists(*index, regression.parameters(), orders);
        check(features.index.iter().take(features.count as usize).all(in_range), "feature index")?;

        let (f, z) = (features.count as usize, classifier.projection.count as usize);
        let in_use = discriminant.classes as usize;
        let projection = &classifier.projection;
        check(neutral(&projection.mean, f) && neutral_rows(&projection.matrix, z, f), "projection")?;
        let covariances = discriminant.whitening.iter().all(|u| neutral_rows(u, z, z));
        check(covariances && neutral_rows(&discriminant.mean, in_use, z), "class density")?;
        let costs = discriminant.cost.iter().take(in_use);
        check(costs.into_iter().all(|row| all_within(parted(row, in_use).0, 0.0, 1e6)), "cost")?;
        let impossible = f32::NEG_INFINITY;
        let finite_in_use = |values: &[f32]| {
            let (used, unused) = parted(values, in_use);
            all_within(used, f32::MIN, f32::MAX) && all_within(unused, impossible, impossible)
        };
        check(finite_in_use(&discriminant.log_normaliser), "class normaliser")?;
        check(finite_in_use(&discriminant.log_prior), "prior")?;
        // Infinity is in range: never.
        check(discriminant.reject_cost >= 0.0, "reject cost")?;
        validate_novelty(&classifier.novelty, (in_use, z))?;
        let EvidencePlan { bet, limit, cap } = self.evidence;
        check(bet > 0.0 && bet < 1.0, "evidence bet")?;
        check(limit > 0.0, "evidence limit")?;
        check(cap > 0.0 && cap.is_finite(), "evidence cap")
    }
}

fn check(good: bool, what: &'static str) -> Result<(), ModelError> {
    if good { Ok(()) } else { Err(ModelError::Value(what)) }
}

/// Scales, guard, method and memory of the estimation.
fn validate_regression<const M: usize>(regression: &Regression<M>, segment_samples: u32) -> Result<(), ModelError> {
    let Regression { order, method, memory, guard, nominal, settle, handover, .. } = regression;
    let n = regression.parameters();
    let Guard { limit, saturation, stuck_samples, huber } = guard;
    let finite = |x: &f32| x.is_finite();
    check(all_within(limit, f32::MIN_POSITIVE, f32::MAX), "signal limit")?;
    let ordered = saturation.iter().zip(limit).all(|(most, limit)| *most > 0.0 && most <= limit);
    check(ordered, "saturation")?;
    // One equal sample is no run.
    check(stuck_samples.iter().all(|count| *count != 1), "stuck samples")?;
    check(finite(huber) && *huber >= 0.0, "outlier threshold")?;
    check(regression.scale.iter().take(n + 1).all(|x| is_power_of_two(*x)), "column scale")?;
    check(regression.differences_share_scales(), "column scale")?;
    // Beyond that, sums of squares over a segment could leave the range of f32.
    let [y, u1, u2] = *limit;
    let (na, nb, nc) = (order.na as usize, order.nb as usize, order.nc as usize);
    let bounded = |limit: f32, from: usize, columns: usize| {
        all_within(regression.scale.get(from..from + columns).unwrap_or(&[]), 0.0, 1e14 / limit)
    };
    let inputs = bounded(u1, na, nb.min(2)) && bounded(u2, na + nb, nc.min(2));
    // At the end the constant, where there is one, and the target.
    let rest = bounded(y.max(1.0), na + nb + nc, n + 1 - (na + nb + nc));
    check(bounded(y, 0, na.min(2)) && inputs && rest, "signal limit beside the column scale")?;
    let known = all_within(parted(&nominal.delta, n).0, f32::MIN, f32::MAX);
    check(known && finite(&nominal.deviation) && nominal.deviation >= 0.0, "nominal model")?;
    if *method == Method::Instruments {
        let terms = order.na as usize;
        check((1..=MAX_OUTPUT_TERMS).contains(&terms), "number of output terms for instruments")?;
        check(is_stable(nominal.delta.get(..terms).unwrap_or(&[])), "nominal model, which must be stable,")?;
        let lost = u32::from(*settle) + u32::from(*handover);
        check(segment_samples / 4 >= lost, "segment length beside settling and handover")?;
    }
    check(finite(&regression.still) && regression.still >= 0.0, "excitation threshold")?;
    check(u32::from(*handover) <= segment_samples / 2, "handover")?;
    if let Memory::Fading(forgetting) = memory {
        // Forgetting without excitation would let noise take the place of knowledge; without inputs nothing moves.
        check(regression.still > 0.0 && order.nb + order.nc > 0, "excitation threshold")?;
        // A memory of n rows has nothing left to estimate a variance from.
        let rows = 1.0 / (1.0 - forgetting.lambda);
        check(forgetting.lambda <= MAX_LAMBDA && rows > 2.0 * n as f32, "forgetting factor")?;
        check(finite(&forgetting.floor) && forgetting.floor > 0.0, "forgetting floor")?;
    }
    Ok(())
}

/// The healthy class of so many classes and coordinates.
fn validate_novelty<const Z: usize>(novelty: &Novelty<Z>, (classes, z): (usize, usize)) -> Result<(), ModelError> {
    let none = novelty.class == NO_CLASS;
    check(none || (novelty.class as usize) < classes, "healthy class")?;
    let z = if none { 0 } else { z };
    check(neutral(&novelty.mean, z) && neutral_rows(&novelty.whitening, z, z), "healthy density")?;
    let knots = novelty.knots.as_flattened();
    if none {
        check(all_within(knots, 0.0, 0.0), "surprise curve")?;
        return check(novelty.limit.is_infinite(), "novelty limit");
    }
    check(rises(&novelty.knots) && all_within(knots, 0.0, f32::MAX), "surprise curve")?;
    check(novelty.limit > 0.0, "novelty limit")
}

/// Not inlined, where it would be unrolled: flash is dear. NaN rises nowhere.
#[inline(never)]
fn rises(knots: &[[f32; 2]]) -> bool {
    knots.windows(2).all(|pair| matches!(pair, [[x0, s0], [x1, s1]] if x0 < x1 && s0 < s1))
}

/// One loop for all the arrays of a model: this runs once, and flash is dear. NaN lies nowhere.
#[inline(never)]
fn all_within(values: &[f32], least: f32, most: f32) -> bool {
    values.iter().all(|x| (least..=most).contains(x))
}

/// What is in use, and what is not.
fn parted(values: &[f32], in_use: usize) -> (&[f32], &[f32]) {
    values.split_at_checked(in_use).unwrap_or((values, &[]))
}

/// Within 2^±60, so that sums of squares stay far inside the range of `f32`.
fn is_power_of_two(x: f32) -> bool {
    (8.67e-19..=1.16e18).contains(&x) && x.to_bits() & 0x007F_FFFF == 0
}

/// Finite where in use and zero elsewhere: what a wider capacity adds must not count.
fn neutral(values: &[f32], in_use: usize) -> bool {
    let (used, unused) = parted(values, in_use);
    all_within(used, f32::MIN, f32::MAX) && all_within(unused, 0.0, 0.0)
}

fn neutral_rows<const N: usize>(rows: &[[f32; N]], rows_in_use: usize, in_use: usize) -> bool {
    rows.iter().enumerate().all(|(k, row)| neutral(row, if k < rows_in_use { in_use } else { 0 }))
}
