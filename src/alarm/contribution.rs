//! What a direction contributes, for reports and for those who ask.

/// What a direction contributes to the evidence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Contribution {
    /// Place of the direction in the model.
    pub direction: u8,
    /// The mean of the last run less the drive's usual mean, in standard deviations of runs.
    pub deviations: f32,
    /// The largest score of the direction, nats.
    pub score: f32,
    /// Number of the last segment before the change.
    pub since: u32,
}
