//! What a segment has used of its samples.

/// Samples seen and used in a segment, whether the angle has moved in it, and steps that no motor makes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Usage {
    pub(super) seen: u32,
    pub(super) used: u32,
    pub(super) steps: u32,
    pub(super) moved: bool,
}
