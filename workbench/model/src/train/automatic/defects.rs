//! Defects of every kind that are added to healthy traces.
//!
//! ```text
//! pulses of an order   i' = i + sgn(ω) Σ_h A √w_h cos(h (O (1 + c δ) θ + φ))                       (1)
//! friction             i' = i + ΔB ω                                                               (2)
//! friction with load   i' = i + Δμ |T| sgn(ω)                                                      (3)
//! ```
//!
//! Sizes are in steps of two. A of (1) is in deviations of the order's amplitude; ΔB ω_rms of (2) and Δμ T_rms of (3)
//! are parts of the healthy friction at the usual speed and load, or of the current if there is no friction.

use bearing_watch::model::TrackedOrder;
use rayon::prelude::*;

use super::situation::Situation;
use crate::Error;
use crate::trace::MotionTrace;
use crate::trace::labels::LabelledTrace;
use crate::train::estimates::Estimates;
use crate::train::estimator::nominal::median;
use crate::train::estimator::pulses;
use crate::train::rows::core_features;
use crate::train::{FeatureTable, ShaftPlan};

/// Healthy traces to which defects are added.
const MOST_TRACES: usize = 100;
/// Healthy traces by which the deviations of the amplitudes are known.
const MEASURED: usize = 32;
/// Weights of the harmonics of (1): pulses of a tenth to half of a period.
const WEIGHTS: [f64; 3] = [1.0, 0.5, 0.25];
/// Sizes of (1), deviations.
const PULSES: [f64; 6] = [2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
/// Sizes of (2) and (3), parts of the healthy friction; without a load sensor, of a tenth of the current.
const FRICTIONS: [f64; 7] = [1.0 / 32.0, 1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 1.0, 2.0];
const OF_CURRENT: [f64; 7] = [1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 1.0, 2.0, 4.0, 8.0];

/// A kind of defect at all its sizes.
pub(super) struct Added {
    /// What it is, in words.
    pub(super) name: String,
    /// Its part in the choice: the orders of a bearing count as one kind.
    pub(super) weight: f64,
    /// Sizes in steps of two, A: the pulses' first harmonic, the friction at the usual speed and load.
    pub(super) sizes: Vec<f64>,
    /// The features at each size, and the trace of each row.
    pub(super) tables: Vec<(FeatureTable, Vec<usize>)>,
}

/// What is added.
enum Kind {
    /// (1) of an order.
    Pulses(TrackedOrder),
    /// (2).
    Viscous,
    /// (3).
    Load,
}

/// Healthy traces, with the motion as the shaft takes it.
struct Healthy<'a> {
    of: Vec<(usize, &'a LabelledTrace, MotionTrace)>,
    y_is_current: bool,
    slip: f64,
}

impl Healthy<'_> {
    /// The traces with a defect of this size.
    fn with(&self, kind: &Kind, size: f64) -> Vec<LabelledTrace> {
        let each = |(number, (_, labelled, motion)): (usize, &(usize, &LabelledTrace, MotionTrace))| {
            let mut own = (*labelled).clone();
            let mut added = vec![0.0; own.trace.y.len()];
            match kind {
                Kind::Pulses(order) => {
                    let (slip, phase) = pulses::slip_and_phase(number, self.slip);
                    let order = f64::from(order.order()) * (1.0 + f64::from(order.slip_ratio) * slip);
                    pulses::add(&mut added, motion, order, phase, WEIGHTS.map(|weight| size * weight.sqrt()));
                }
                Kind::Viscous => added.iter_mut().zip(&motion.velocity_rad_s).for_each(|(i, w)| *i = size * w),
                Kind::Load => {
                    let signals = motion.load_nm.iter().zip(&motion.velocity_rad_s);
                    added.iter_mut().zip(signals).for_each(|(i, (load, w))| *i = size * load.abs() * w.signum());
                }
            }
            // A lost sample of the velocity adds nothing; the core does not take it.
            let add = |signal: &mut [f64]| {
                signal.iter_mut().zip(&added).filter(|(_, a)| a.is_finite()).for_each(|(x, a)| *x += a);
            };
            own.trace.motion.iter_mut().for_each(|motion| add(&mut motion.current_a));
            if self.y_is_current {
                add(&mut own.trace.y);
            }
            own
        };
        self.of.par_iter().enumerate().map(each).collect()
    }
}

/// Returns the features of healthy traces with defects of all kinds that the shaft may tell.
pub(super) fn added(own: &Estimates<'_>, situation: &Situation) -> Result<Vec<Added>, Error> {
    let (Some(plan), Some((_, shaft))) = (&own.recipe.shaft, &own.parts.shaft) else { return Ok(vec![]) };
    let class = own.sound();
    let all: Vec<usize> = (0..own.traces.len()).filter(|&k| own.traces[k].class == class).collect();
    // Evenly over all of them: neighbours are often alike.
    let some = all.iter().copied().step_by(all.len().div_ceil(MOST_TRACES).max(1));
    let with_motion = some.filter_map(|place| {
        let motion = plan.velocity.motion(own.traces[place].trace.motion.as_ref()?, own.interval_s).into_owned();
        Some((place, &own.traces[place], motion))
    });
    let columns = &own.recipe.columns;
    let y_is_current = columns.shaft.as_ref().is_some_and(|shaft| shaft.current == columns.y);
    let healthy = Healthy { of: with_motion.collect(), y_is_current, slip: plan.slip };
    let deviations = deviations(own, &healthy)?;
    let tracked = plan.orders.iter().zip(&shaft.tracking.orders).zip(&deviations);
    let count = plan.orders.len() as f64;
    let orders = tracked.filter(|(_, deviation)| **deviation > 0.0).map(|(((name, _), order), deviation)| {
        let sizes = PULSES.map(|size| size * deviation).to_vec();
        (format!("pulses at the order {name}"), Kind::Pulses(*order), 1.0 / count, sizes, 1.0)
    });
    let friction = usual_friction_a(own, plan);
    let [velocity, load] = [shaft.balance.usual_velocity_rad_s, shaft.balance.usual_load_nm].map(f64::from);
    let viscous = (velocity > 0.0).then(|| {
        let parts = if plan.load { FRICTIONS } else { OF_CURRENT };
        let sizes = parts.map(|part| part * friction / velocity).to_vec();
        ("friction that grows with speed".to_string(), Kind::Viscous, 1.0, sizes, velocity)
    });
    let with_load = (situation.load && load > 0.0).then(|| {
        let sizes = FRICTIONS.map(|part| part * friction / load).to_vec();
        ("friction that grows with load".to_string(), Kind::Load, 1.0, sizes, load)
    });
    let kinds: Vec<_> = orders.chain(viscous).chain(with_load).collect();
    let each = |(name, kind, weight, sizes, current): (String, Kind, f64, Vec<f64>, f64)| {
        let at = |size: &f64| {
            let traces = healthy.with(&kind, *size);
            let classes = own.classes;
            let (table, origins, _) =
                core_features::run_plain(&traces, classes, (&own.parts, &own.catalogue), own.segment)?;
            let origins = origins.into_iter().map(|k| healthy.of[k].0).collect();
            Ok((table.beyond(&own.estimated.candidates.table.usual), origins))
        };
        let tables = sizes.iter().map(at).collect::<Result<_, Error>>()?;
        let sizes = sizes.iter().map(|size| size * current).collect();
        Ok(Added { name, weight, sizes, tables })
    };
    kinds.into_iter().map(each).collect()
}

/// Current of the healthy friction at the usual speed and load, A: the median drag, or the deviation of the current.
fn usual_friction_a(own: &Estimates<'_>, plan: &ShaftPlan) -> f64 {
    let table = &own.estimated.candidates.table;
    let class = own.sound();
    let place = own.catalogue.names().iter().position(|name| name == "drag");
    let drag = place.map(|k| table.with(class, k).map(|row| table.rows[row][k]).collect::<Vec<f64>>());
    let drag = drag.filter(|all| !all.is_empty()).map_or(0.0, median);
    let motions = own.traces.iter().filter_map(|own| own.trace.motion.as_ref());
    let squares = motions.map(|motion| {
        let finite = || motion.current_a.iter().filter(|x| x.is_finite());
        finite().map(|x| x * x).sum::<f64>() / finite().count().max(1) as f64
    });
    let current = median(squares.collect()).sqrt();
    // Friction that is small or not known: a tenth of the current. What contains the load is no measure of friction.
    if plan.load && drag > 0.0 { drag.min(current) } else { 0.1 * current }
}

/// Median deviation of the amplitude of each order, A.
fn deviations(own: &Estimates<'_>, healthy: &Healthy<'_>) -> Result<Vec<f64>, Error> {
    let detector = core_features::estimator(&own.parts, own.segment)?;
    let some: Vec<_> = healthy.of.iter().take(MEASURED).collect();
    let reports: Vec<_> = some.par_iter().map(|(_, labelled, _)| detector.whole(&labelled.trace)).collect();
    let shafts = || reports.iter().filter_map(|report| report.shaft()).filter(|own| own.orders_reason.is_none());
    let count = shafts().next().map_or(0, |own| own.orders().len());
    let of =
        |k: usize| median(shafts().filter_map(|own| own.orders().get(k)).map(|o| f64::from(o.deviation)).collect());
    Ok((0..count).map(of).collect())
}
