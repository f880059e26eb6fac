//! The state of the bearing in one segment.

use crate::reason::Reason;

/// The state of the bearing in one segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// Index of a class; [`Model::label`](crate::Model::label) gives its name. It is the most plausible of the
    /// *trained* classes, and the segment is not far from all of them.
    Class(u8),
    /// Healthy is the most plausible class, but the segment is farther from it than healthy segments are: a small or
    /// unknown defect, or conditions that were not trained. Or the segment is far from every class: another or a much
    /// larger defect, or a faulty sensor. Never without a healthy class in the model.
    Novel,
    /// No class is plausible enough.
    Ambiguous,
    /// No verdict, and why: no feature is available, or less than half of the segment was usable.
    Undetermined(Reason),
}
