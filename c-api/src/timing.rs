//! What a state knows of the clock of the firmware.

use bearing_watch::model::Sampling;
use bearing_watch::{Liveness, LivenessLimits, RateCheck};

/// What the clock is compared with.
#[derive(Debug)]
pub(crate) struct Clock {
    pub(crate) rate: RateCheck,
    /// Whether the last window of the rate was right.
    pub(crate) right: bool,
    /// Whether the clock was read.
    pub(crate) started: bool,
    pub(crate) liveness: Liveness,
}

impl Clock {
    pub(crate) fn new(sampling: &Sampling) -> Self {
        let liveness = Liveness::new(LivenessLimits::of_segments(sampling.segment_s()));
        Self { rate: RateCheck::of_milliseconds(sampling.interval_s), right: true, started: false, liveness }
    }

    /// Starts anew, after a pause of the samples.
    pub(crate) const fn restart(&mut self) {
        self.rate.restart();
        self.liveness.restart();
    }
}
