//! A trace's samples as the core takes them, and the shaft's features as it extracts them.

use bearing_watch::decide::{Features, SHAFT_FEATURES};
use bearing_watch::{Motion, Report, Sample};

use crate::trace::{MotionTrace, Trace};

/// Bearing orders that the workbench can watch.
pub const MAX_ORDERS: usize = 8;

/// Samples with the shaft's motion; at rest where the trace has none.
pub(super) fn samples(trace: &Trace) -> impl Iterator<Item = (Sample, Motion)> {
    let rows = trace.y.iter().zip(&trace.u1).zip(&trace.u2);
    let samples = rows.map(|((y, u1), u2)| Sample { y: *y as f32, u1: *u1 as f32, u2: *u2 as f32 });
    let motions = (0..trace.y.len()).map(|k| trace.motion.as_ref().map_or_else(Motion::default, |m| m.at(k)));
    samples.zip(motions)
}

impl MotionTrace {
    /// One sample as the core takes it.
    #[must_use]
    pub fn at(&self, k: usize) -> Motion {
        // The fraction of a turn survives single precision only if it is taken before.
        let turns = self.angle_rad[k] / std::f64::consts::TAU;
        let bits = ((turns - turns.floor()) * 4_294_967_296.0) as u64 as u32;
        Motion {
            current_a: self.current_a[k] as f32,
            velocity_rad_s: self.velocity_rad_s[k] as f32,
            reference_rad_s: self.reference_rad_s[k] as f32,
            load_nm: self.load_nm[k] as f32,
            angle: bearing_watch::Angle::from_bits(bits),
        }
    }
}

/// Every feature of the shaft that the core can extract, in the order of [`super::features::Catalogue::shaft`].
pub(super) fn shaft_features<const M: usize, const P: usize, const C: usize>(
    report: &Report<M, P, C, MAX_ORDERS>,
    orders: usize,
) -> Vec<f32> {
    let Some(shaft) = report.shaft.filter(|shaft| shaft.reason.or(shaft.orders_reason).is_none()) else {
        return vec![];
    };
    let place = |offset: usize| SHAFT_FEATURES + offset as u8;
    let indices = (0..6).chain(8..14).chain([16]).chain(32..32 + orders).chain(64..64 + orders);
    let mut features = Features { index: [0; 64], count: 0 };
    for (cell, index) in features.index.iter_mut().zip(indices) {
        *cell = place(index);
        features.count += 1;
    }
    let values = features.extract(&report.estimate, Some(&shaft)).unwrap_or([0.0; 64]);
    values[..features.count as usize].to_vec()
}
