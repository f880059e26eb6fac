//! The names and constants that a receiver needs for reports and samples.

use serde::{Deserialize, Serialize};

use super::samples::Numbers;
use super::sink::{Sink, TooSmall};
use super::split;
use crate::model::{Buffer, Feature, Model, Reader, Sampling, Writer};
use crate::plan::{Cells, Plan};

#[derive(Serialize, Deserialize)]
struct Fields {
    #[serde(with = "postcard::fixint::le")]
    model_id: u32,
    #[serde(with = "postcard::fixint::le")]
    session: u32,
    interval_s: f32,
    #[serde(with = "postcard::fixint::le")]
    block_mean: u16,
    #[serde(with = "postcard::fixint::le")]
    segment_samples: u32,
    channels: u8,
    angle: bool,
    classes: u8,
    healthy: Option<u8>,
    features: u8,
    coordinates: u8,
    orders: u8,
}

/// In the place of a feature: the coordinate is a combination.
const COMBINATION: u8 = u8::MAX;

/// Where frames come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Source {
    /// Any number that identifies the model, for instance the checksum of its binary form (its last four bytes).
    pub model_id: u32,
    /// A number that changes with each power-up, such as a count of them or a random number. With equal numbers a
    /// receiver sees a restart only by its hello.
    pub session: u32,
}

/// What the other frames of its stream mean.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Hello<'a> {
    /// Model and session.
    pub source: Source,
    /// Sampling interval, s; 0 if it is unknown.
    pub interval_s: f32,
    /// Number of samples averaged into one before the regression.
    pub block_mean: u16,
    /// Number of samples in a segment, after averaging.
    pub segment_samples: u32,
    /// Number of channels of a sample.
    pub channel_count: u8,
    /// Whether samples have an angle.
    pub with_angle: bool,
    /// Number of classes.
    pub class_count: u8,
    /// The healthy class.
    pub healthy: Option<u8>,
    /// The bearing orders, pulses a turn.
    pub orders: Numbers<'a>,
    features: &'a [u8],
    coordinates: &'a [u8],
    texts: &'a [u8],
}

/// Fields and lists.
pub(super) fn write<P: Plan>(model: &Model<P>, source: Source, sink: &mut Sink<'_>) -> Result<(), TooSmall> {
    let (layout, constants) = (model.plan().layout(), model.constants());
    let Sampling { interval_s, block_mean, segment_samples, .. } = constants.sampling;
    sink.fields(&Fields {
        model_id: source.model_id,
        session: source.session,
        interval_s,
        block_mean,
        segment_samples,
        channels: layout.channels,
        angle: layout.needs_angle(),
        classes: layout.classes,
        healthy: constants.classifier.novelty.class,
        features: layout.features,
        coordinates: layout.coordinates,
        orders: layout.shaft.map_or(0, |shaft| shaft.orders),
    })?;
    for feature in constants.classifier.features.cells() {
        let mut code = [0; 2];
        Writer(Buffer { free: &mut code, written: 0 }).feature(*feature).map_err(|_| TooSmall)?;
        sink.bytes(&code)?;
    }
    for index in 0..layout.coordinates {
        let feature = constants.classifier.projection.feature(index.into());
        sink.bytes(&[feature.unwrap_or(COMBINATION)])?;
    }
    let shaft = constants.shaft.part();
    let orders = shaft.map_or(&[][..], |shaft| shaft.tracking.orders.cells());
    orders.iter().try_for_each(|order| sink.number(order.order()))?;
    for channel in constants.channels.cells() {
        sink.text(channel.name.as_str())?;
        sink.text(channel.unit.as_str())?;
    }
    constants.labels.cells().iter().try_for_each(|label| sink.text(label.as_str()))
}

impl<'a> Hello<'a> {
    /// From fields and lists; `None` if they do not fit.
    pub(super) fn read(bytes: &'a [u8]) -> Option<Self> {
        let (fields, bytes): (Fields, _) = split(bytes)?;
        let (features, bytes) = bytes.split_at_checked(2 * usize::from(fields.features))?;
        let (coordinates, bytes) = bytes.split_at_checked(fields.coordinates.into())?;
        let (orders, texts) = bytes.split_at_checked(4 * usize::from(fields.orders))?;
        let hello = Self {
            source: Source { model_id: fields.model_id, session: fields.session },
            interval_s: fields.interval_s,
            block_mean: fields.block_mean,
            segment_samples: fields.segment_samples,
            channel_count: fields.channels,
            with_angle: fields.angle,
            class_count: fields.classes,
            healthy: fields.healthy,
            orders: Numbers(orders),
            features,
            coordinates,
            texts,
        };
        // Not by `count`, whose overflow check stays.
        let ends = texts.iter().fold(0_usize, |ends, byte| ends.saturating_add(usize::from(*byte == 0)));
        let wanted = 2 * usize::from(fields.channels) + usize::from(fields.classes);
        let whole = ends == wanted && texts.last().is_none_or(|byte| *byte == 0);
        let named = coordinates.iter().all(|index| *index < fields.features || *index == COMBINATION);
        let readable =
            whole && named && core::str::from_utf8(texts).is_ok() && hello.features().all(|feature| feature.is_some());
        readable.then_some(hello)
    }

    fn texts(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.texts.split(|byte| *byte == 0).map(|text| core::str::from_utf8(text).unwrap_or(""))
    }

    /// Name and unit of each channel, in the order of the sample.
    pub fn channels(&self) -> impl Iterator<Item = (&'a str, &'a str)> + use<'a> {
        let mut texts = self.texts();
        (0..self.channel_count).map_while(move |_| texts.next().zip(texts.next()))
    }

    /// Name of each class.
    pub fn classes(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.texts().skip(2 * usize::from(self.channel_count)).take(self.class_count.into())
    }

    /// The features of the model, in the order of [`Summary::features`](super::Summary::features).
    pub fn features(&self) -> impl Iterator<Item = Option<Feature>> + use<'a> {
        let (codes, _) = self.features.as_chunks::<2>();
        codes.iter().map(|code| Reader(code).feature().ok())
    }

    /// The feature that each coordinate is, by its index; `None` for a combination.
    pub fn coordinates(&self) -> impl Iterator<Item = Option<u8>> + use<'a> {
        self.coordinates.iter().map(|index| (*index != COMBINATION).then_some(*index))
    }
}
