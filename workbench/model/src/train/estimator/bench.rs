//! The core's shaft alone over whole traces, by which its constants are compared.

use bearing_watch::model::{Channel, Sampling, ShaftConstants};
use bearing_watch::plan::{RunTime, ShaftLayout};
use bearing_watch::shaft::{Friction, ShaftEstimate};
use rayon::prelude::*;

use super::regression::successful;
use super::shaft_plan::{ShaftPlan, harmonics};
use crate::Error;
use crate::core::{Embedded, Parts, ShaftSignals, Wiring};
use crate::error::refused;
use crate::trace::labels::LabelledTrace;
use crate::trace::{MotionTrace, Trace};

/// Limits of the channels, in multiples of the largest magnitude in training.
const LIMIT: f64 = 10.0;
/// Rows from which a segment's own parameters are compared with the nominal ones.
pub(crate) const OWN_FROM_ROWS: u16 = 48;
/// The same with a weight on an axis, whose phase no nominal parameter knows.
pub(crate) const OWN_FROM_FEW_ROWS: u16 = 8;
/// Traces with their motion.
pub(crate) type AlarmState<'a> = (&'a LabelledTrace, &'a MotionTrace);

/// Runs the shaft of the core alone over whole traces.
pub(crate) struct Bench {
    layout: ShaftLayout,
    channels: Vec<Channel>,
}

impl Bench {
    /// Creates a bench in which every signal of the shaft has its own channel.
    pub(crate) fn new(own: &[AlarmState<'_>], plan: &ShaftPlan, wiring: &Wiring) -> Result<Self, Error> {
        let alone = Wiring { channels: vec![], ..wiring.clone() }.of_shaft(wiring);
        let channels = alone.core_channels(own.iter().map(|(t, _)| &t.trace), LIMIT)?;
        Ok(Self { layout: layout(plan, &alone)?, channels })
    }

    pub(crate) fn run(
        &self,
        constants: &ShaftConstants<RunTime>,
        trace: &Trace,
    ) -> Result<ShaftEstimate<RunTime>, Error> {
        let parts = Parts {
            channels: self.channels.clone(),
            regression: None,
            shaft: Some((self.layout, constants.clone())),
            averaged: 0,
        };
        let samples = trace.y.len() as u32;
        let sampling = Sampling { interval_s: 0.0, park: None, block_mean: 1, segment_samples: samples };
        let model = parts.estimating(sampling).map_err(refused)?;
        let report = Embedded::new(model).map_err(refused)?.whole(trace);
        report.shaft().cloned().ok_or_else(|| Error::trace(&trace.id, "the shaft was not watched"))
    }

    /// Returns the estimates of all traces.
    pub(crate) fn run_all(
        &self,
        constants: &ShaftConstants<RunTime>,
        own: &[AlarmState<'_>],
    ) -> Result<Vec<ShaftEstimate<RunTime>>, Error> {
        own.par_iter().map(|(labelled, _)| self.run(constants, &labelled.trace)).collect()
    }

    /// Returns the torque balances of all traces that have one.
    ///
    /// # Errors
    /// No trace has a torque balance.
    pub(crate) fn frictions(
        &self,
        constants: &ShaftConstants<RunTime>,
        own: &[AlarmState<'_>],
    ) -> Result<Vec<Friction>, Error> {
        let balance = |(labelled, _): &AlarmState<'_>| {
            let id = &labelled.trace.id;
            let ShaftEstimate { friction, friction_reason, .. } = self.run(constants, &labelled.trace)?;
            let refuse = |reason| format!("shaft: {reason}; no trace of the nominal class has a torque balance");
            friction_reason.map_or(Ok(friction), |reason| Err(Error::trace(id, refuse(reason))))
        };
        successful(own.par_iter().map(balance).collect())
    }
}

/// Returns the shaft of this plan on the channels of a wiring.
pub(crate) fn layout(plan: &ShaftPlan, wiring: &Wiring) -> Result<ShaftLayout, Error> {
    let missing = || Error::Training("the channels of the shaft are not wired".into());
    let ShaftSignals { current, velocity, load } = wiring.shaft.ok_or_else(missing)?;
    let (orders, harmonics) = (plan.orders.len() as u8, harmonics(&plan.weights));
    let load = plan.axis.load(load);
    Ok(ShaftLayout { current, velocity, load, orders, harmonics, decimation: plan.decimation })
}
