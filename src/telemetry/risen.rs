//! What the directions of the alarm contribute, behind the other lists of a report.

use serde::{Deserialize, Serialize};

use super::sink::{Sink, TooSmall};
use super::split;
use crate::alarm::Contribution;
use crate::alarm::evidence::Evidence;
use crate::decide::Direction;
use crate::plan::Plan;
use crate::regression::factor::pairs;

/// Bytes of a direction.
const BYTES: usize = 13;

/// A contribution behind a number: of the alarm that of the direction, in the list that of the coordinate.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Fields {
    number: u8,
    deviations: f32,
    score: f32,
    #[serde(with = "postcard::fixint::le")]
    since: u32,
}

#[derive(Serialize, Deserialize)]
struct Head {
    alarm: Option<Fields>,
    directions: u8,
}

impl Fields {
    fn of(number: u8, Contribution { deviations, score, since, .. }: Contribution) -> Self {
        Self { number, deviations, score, since }
    }

    fn contribution(self, direction: u8) -> Contribution {
        let Self { deviations, score, since, .. } = self;
        Contribution { direction, deviations, score, since }
    }
}

/// What each direction of the alarm contributes at the end of the last run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Contributions<'a>(&'a [u8]);

impl Contributions<'_> {
    /// Number of directions.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.0.len() / BYTES
    }

    /// Whether there is none, as of a model without directions.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The coordinate that a defect raises, and the contribution, of each direction in the order of the model; the
    /// hello says which feature a coordinate is.
    pub fn iter(&self) -> impl Iterator<Item = (u8, Contribution)> {
        let (chunks, _) = self.0.as_chunks::<BYTES>();
        pairs(chunks, 0..u8::MAX).filter_map(|(bytes, direction)| {
            let (fields, _): (Fields, _) = split(bytes)?;
            Some((fields.number, fields.contribution(direction)))
        })
    }
}

/// The contribution of the alarm, and those of all directions.
pub(super) fn write<P: Plan>(
    directions: &[Direction],
    evidence: &Evidence<P>,
    sink: &mut Sink<'_>,
) -> Result<(), TooSmall> {
    let alarm = evidence.main_contribution().map(|main| Fields::of(main.direction, main));
    // A plan has at most eight.
    sink.fields(&Head { alarm, directions: u8::try_from(directions.len()).unwrap_or(u8::MAX) })?;
    pairs(directions, 0..u8::MAX).try_for_each(|(direction, index)| {
        sink.fields(&Fields::of(direction.coordinate, evidence.contribution(index).unwrap_or_default()))
    })
}

/// From these bytes and no others; `None` if they do not fit.
pub(super) fn read(bytes: &[u8]) -> Option<(Option<Contribution>, Contributions<'_>)> {
    let (Head { alarm, directions }, list): (Head, _) = split(bytes)?;
    let whole = list.len() == BYTES * usize::from(directions);
    whole.then(|| (alarm.map(|fields| fields.contribution(fields.number)), Contributions(list)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// ½ deviation above usual, a score of 2 nats, since segment 258, behind a number.
    fn bytes(number: u8) -> Vec<u8> {
        [&[number][..], &[0, 0, 0, 0x3F], &[0, 0, 0, 0x40], &[2, 1, 0, 0]].concat()
    }

    #[test]
    fn contributions_are_the_bytes_of_the_format() {
        let contribution = |direction| Contribution { direction, deviations: 0.5, score: 2.0, since: 258 };
        let sent = [&[1][..], &bytes(1), &[2], &bytes(7), &bytes(4)].concat();
        let (alarm, list) = read(&sent).unwrap();
        assert_eq!((alarm, list.len(), list.is_empty()), (Some(contribution(1)), 2, false));
        assert_eq!(list.iter().collect::<Vec<_>>(), [(7, contribution(0)), (4, contribution(1))]);
        let mut buffer = [0; BYTES];
        let written = postcard::to_slice(&Fields::of(7, contribution(0)), &mut buffer).unwrap();
        assert_eq!(written, bytes(7));
    }

    #[test]
    fn a_model_without_directions_has_two_zeros() {
        assert_eq!(read(&[0, 0]), Some((None, Contributions::default())));
        assert!(Contributions::default().is_empty());
    }

    #[test]
    fn lists_of_another_length_and_marks_that_are_none_are_refused() {
        let two = [&[0, 2][..], &bytes(7), &bytes(4)].concat();
        assert!(read(&two).is_some());
        let long = [&two[..], &[0]].concat();
        for wrong in [&two[..two.len() - 1], &long, &[], &[0], &[2, 0], &[1, 0]] {
            assert_eq!(read(wrong), None, "{wrong:?}");
        }
    }
}
