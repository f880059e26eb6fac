//! Size of the campaign on the actuator.

/// Size of the campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Number of draws of training and validation sets.
    pub draws: u32,
    /// Number of the first draw; other numbers give other records.
    pub first: u32,
    /// Number of records per class and set.
    pub records: u32,
    /// The detector of a user who names no features, instead of [`super::recipe`]; without the source's method.
    pub default: bool,
}
