//! Size of the study.

use crate::field::delay;

/// Parts of the life at which the time left is asked for.
pub const PARTS: [f64; 3] = [0.25, 0.5, 0.75];

/// Size of the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Training, records a run, judged drives, and recorded runs of each, healthy and of each size.
    pub fleet: delay::Settings,
    /// Histories of each law and drive.
    pub histories: u32,
    /// Shortest and longest life, runs.
    pub life: [f64; 2],
}

impl Settings {
    /// 20 drives of training, 8 judged ones, and 40 histories of each law on each.
    pub const STANDARD: Self = Self {
        fleet: delay::Settings { drives: 8, healthy: 24, ..delay::Settings::STANDARD },
        histories: 40,
        life: [40.0, 250.0],
    };
}
