//! The clock of the firmware against what the three contexts do.

use core::fmt;
use core::sync::atomic::Ordering;

use super::{Main, Watch};
use crate::plan::Plan;
use crate::reason::{ArithmeticFault, Implausible, Reason};
use crate::report::Verdict;
use crate::signal::{Liveness, LivenessLimits, Stage};

/// Why the drive is not watched as it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Lapse {
    /// No sample comes: [`Watch::sample`] is not called.
    NoSample,
    /// Samples wait, but [`Watch::collect`] is not called.
    NotCollected,
    /// The context of [`Watch::collect`] computes otherwise than the host of the training: no segment closes.
    Arithmetic(ArithmeticFault),
    /// Samples come, but no segment closes: each is lost because [`Watch::advance`] is not called, or they are too
    /// rare.
    NoSegment,
    /// Segments close, but none has a verdict; why the last one has none.
    NoVerdict(Option<Reason>),
    /// The samples do not come at the rate of the model: no segment has a verdict.
    Rate,
}

impl Lapse {
    /// What is wrong, in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::NoSample => "no samples come from the current loop",
            Self::NotCollected => "samples wait, but are not collected",
            Self::Arithmetic(kernel) => kernel.message(),
            Self::NoSegment => "samples come, but no segment closes",
            Self::NoVerdict(_) => "no segment has had a verdict for too long",
            Self::Rate => Implausible::Rate.message(),
        }
    }
}

impl fmt::Display for Lapse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoVerdict(Some(reason)) => write!(f, "{}: {reason}", self.message()),
            _ => f.write_str(self.message()),
        }
    }
}

impl<P: Plan, F> Watch<P, F> {
    /// Compares what was done with the clock of the firmware, in milliseconds with wrap-around, which the timer of the
    /// samples does not make. Call it in the main loop, as often as you like.
    ///
    /// Returns why the drive is not watched as it should be, each reason once until it is right again: no sample, no
    /// segment or no verdict has come for the times of [`LivenessLimits::of_segments`]; or samples come at another
    /// rate than that of training over a window of ten seconds. While they do, no segment has a verdict
    /// ([`Implausible::Rate`]), and what the first window has added to the alarm is taken out again. The times count
    /// from the first call, and anew from the last reading of [`Watch::check_wiring`].
    #[must_use = "nothing else tells that the diagnosis has ended"]
    pub fn clock(&self, milliseconds: u32) -> Option<Lapse> {
        self.main.with(|main| self.compare(main, milliseconds)).flatten()
    }

    /// Sets other limits than [`LivenessLimits::of_segments`]; the times count anew.
    pub fn limit_liveness(&self, limits: LivenessLimits) {
        self.main.with(|main| main.liveness = Liveness::new(limits));
    }

    fn compare(&self, main: &mut Main<P>, milliseconds: u32) -> Option<Lapse> {
        let rows = self.link.counters.rows.load(Ordering::Relaxed);
        if !core::mem::replace(&mut main.on_trial, true) {
            main.monitor.begin_trial();
        }
        if let Some(right) = main.rate.push(rows, milliseconds) {
            main.monitor.refuse((!right).then_some(Implausible::Rate));
            if !right && core::mem::replace(&mut main.right_rate, right) {
                return Some(Lapse::Rate);
            }
            main.right_rate = right;
        }
        let checked = self.link.counters.checked.load(Ordering::Relaxed);
        if core::mem::replace(&mut main.checked, checked) != checked {
            // The current loop runs, but its readings are those of the commissioning.
            main.rate.restart();
            main.liveness.restart();
        }
        let closed = self.link.counters.closed.load(Ordering::Relaxed);
        match main.liveness.push([rows, closed, main.verdicts], milliseconds)? {
            Stage::Samples => Some(self.without_samples()),
            Stage::Segments => Some(Lapse::NoSegment),
            Stage::Verdicts => {
                let reason = main.monitor.report().and_then(|report| match report.verdict {
                    Verdict::Undetermined(reason) => Some(reason),
                    _ => None,
                });
                Some(Lapse::NoVerdict(reason))
            }
        }
    }

    fn without_samples(&self) -> Lapse {
        if let Some(kernel) = self.status().failed {
            return Lapse::Arithmetic(kernel);
        }
        let waiting = self.link.queue.try_lock().is_none_or(|queue| !queue.is_empty());
        if waiting { Lapse::NotCollected } else { Lapse::NoSample }
    }
}
