//! The report of a segment as it is sent.

use serde::{Deserialize, Serialize};

use super::codes::{AlarmCode, VerdictCode};
use super::risen::{self, Contributions};
use super::samples::Numbers;
use super::sink::{Sink, TooSmall};
use super::split;
use crate::alarm::Contribution;
use crate::alarm::evidence::{Alarm, Evidence};
use crate::model::{Model, Most};
use crate::plan::{Cells, Plan};
use crate::report::{Report, Verdict};
use crate::signal::{ChannelSet, Counts};

#[derive(Serialize, Deserialize)]
struct Fields {
    #[serde(with = "postcard::fixint::le")]
    segment: u32,
    verdict: VerdictCode,
    distance: f32,
    distance_surprise: f32,
    surprise: f32,
    score: f32,
    alarm: AlarmCode,
    #[serde(with = "postcard::fixint::le")]
    undetermined: u32,
    #[serde(with = "postcard::fixint::le")]
    rows: u32,
    #[serde(with = "postcard::fixint::le")]
    rejected: u32,
    #[serde(with = "postcard::fixint::le")]
    saturated: u32,
    #[serde(with = "postcard::fixint::le")]
    resting: u32,
    #[serde(with = "postcard::fixint::le")]
    stuck: u16,
    refused: u8,
    classes: u8,
    features: u8,
    orders: u8,
    rising: u8,
    /// The coordinate that departs most and whether it falls; 255 for none.
    most: u8,
    falls: bool,
}

/// The result of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Summary<'a> {
    /// Number of segments that the evidence has observed, with this one; the first is 1.
    pub segment: u32,
    /// The class, or why there is none.
    pub verdict: Verdict,
    /// Distance from the healthy class in its standard deviations; 0 without a healthy class or without a verdict.
    pub distance: f32,
    /// Surprise of the distance, nats; 0 in the same cases.
    pub distance_surprise: f32,
    /// Surprise that the novelty gate compares, nats; 0 in the same cases.
    pub surprise: f32,
    /// Largest score of the evidence, nats.
    pub score: f32,
    /// The alarm that stands.
    pub alarm: Option<Alarm>,
    /// Number of undetermined segments so far.
    pub undetermined: u32,
    /// Rows of the regression; in a plan without one, usable samples.
    pub rows: u32,
    /// Samples, rows and channels of the segment that were refused.
    pub counts: Counts,
    /// Posterior of each class; none without a verdict.
    pub posteriors: Numbers<'a>,
    /// Value of each feature of the model before covariates and projection, NaN if it is missing.
    pub features: Numbers<'a>,
    /// Score of each bearing order; none in a plan without a shaft.
    pub order_scores: Numbers<'a>,
    /// The smallest defect in each rising coordinate, the last ones, that the segment would have shown
    /// ([`Report::smallest`](crate::Report::smallest)); none in a model without such coordinates.
    pub smallest: Numbers<'a>,
    /// The coordinate that departs most from healthy; `None` without a healthy class or without a verdict.
    pub most: Option<Most>,
    /// What raised the alarm: the direction, by how many deviations, and since when; `None` without an alarm by a
    /// direction.
    pub risen: Option<Contribution>,
    /// What each direction contributes; none in a model without directions.
    pub contributions: Contributions<'a>,
}

/// Fields and lists.
pub(super) fn write<P: Plan>(
    model: &Model<P>,
    report: &Report<P>,
    evidence: &Evidence<P>,
    sink: &mut Sink<'_>,
) -> Result<(), TooSmall> {
    let (layout, decision) = (model.plan().layout(), report.decision.as_ref());
    let (segment, undetermined) = evidence.segments();
    let Counts { rejected, saturated, resting, stuck, refused } = report.counts;
    let most = decision.and_then(|decision| decision.most);
    sink.fields(&Fields {
        segment,
        verdict: report.verdict.into(),
        distance: decision.map_or(0.0, |decision| decision.distance),
        distance_surprise: decision.map_or(0.0, |decision| decision.distance_surprise),
        surprise: decision.map_or(0.0, |decision| decision.surprise),
        score: evidence.score(),
        alarm: evidence.alarm().into(),
        undetermined,
        rows: report.rows,
        rejected,
        saturated,
        resting,
        stuck: stuck.0,
        refused,
        classes: decision.map_or(0, |_| layout.classes),
        features: layout.features,
        orders: layout.shaft.map_or(0, |shaft| shaft.orders),
        rising: layout.rising,
        most: most.map_or(u8::MAX, |most| most.coordinate),
        falls: most.is_some_and(|most| most.falls),
    })?;
    let posteriors = decision.map_or(&[][..], |decision| decision.posteriors());
    posteriors.iter().try_for_each(|posterior| sink.number(*posterior))?;
    for feature in model.constants().classifier.features.cells() {
        let value = feature.value(model.plan(), report.estimates(model.constants().balance()));
        let value = value.ok().filter(|value| !value.is_missing());
        sink.number(value.map_or(f32::NAN, |value| value.value))?;
    }
    let orders = report.shaft().map_or(&[][..], |shaft| shaft.orders());
    orders.iter().try_for_each(|order| sink.number(order.score))?;
    report.smallest().iter().try_for_each(|size| sink.number(*size))?;
    risen::write(model.constants().classifier.novelty.directions.list.cells(), evidence, sink)
}

impl<'a> Summary<'a> {
    /// From fields and lists; `None` if they do not fit.
    pub(super) fn read(bytes: &'a [u8]) -> Option<Self> {
        let (fields, bytes): (Fields, _) = split(bytes)?;
        let Fields { rejected, saturated, resting, stuck, refused, .. } = fields;
        let list = |bytes: &'a [u8], count: u8| bytes.split_at_checked(4 * usize::from(count));
        let (posteriors, bytes) = list(bytes, fields.classes)?;
        let (features, bytes) = list(bytes, fields.features)?;
        let (order_scores, bytes) = list(bytes, fields.orders)?;
        let (smallest, bytes) = list(bytes, fields.rising)?;
        let (risen, contributions) = risen::read(bytes)?;
        Some(Self {
            segment: fields.segment,
            verdict: fields.verdict.verdict()?,
            distance: fields.distance,
            distance_surprise: fields.distance_surprise,
            surprise: fields.surprise,
            score: fields.score,
            alarm: fields.alarm.alarm()?,
            undetermined: fields.undetermined,
            rows: fields.rows,
            counts: Counts { rejected, saturated, resting, stuck: ChannelSet(stuck), refused },
            posteriors: Numbers(posteriors),
            features: Numbers(features),
            order_scores: Numbers(order_scores),
            smallest: Numbers(smallest),
            most: (fields.most < u8::MAX).then_some(Most { coordinate: fields.most, falls: fields.falls }),
            risen,
            contributions,
        })
    }
}
