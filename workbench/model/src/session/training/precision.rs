//! Whether single precision is fine enough: for the signals ([`doubt`]), where the detector's estimates are compared
//! with those of batch least squares in double precision, and for the gate ([`agree`]), where its verdicts on the healthy
//! segments of training are compared with those of the trained gate in double precision.
//!
//! Rounding grows with the ratio of the signals' levels to the residual, and with the rows of a segment
//! (`factor/triangle.rs` of the core says how far it may be neglected).

use rayon::prelude::*;

use crate::Error;
use crate::core::features::{of_core, vector};
use crate::core::{Embedded, SegmentReport};
use crate::identify::{Terms as _, least_squares};
use crate::statistics::mean_sd;
use crate::trace::labels::LabelledTrace;
use crate::train::{Doubted, Trained, features_of};

/// Traces that are looked at, of different classes first: those of one drive are on one level.
const LOOKED_AT: usize = 4;
/// Part of its deviation by which a parameter may be off.
const NEGLIGIBLE: f64 = 0.05;
/// Part of the gate's limit by which a surprise may be off: the core's law is a line between knots.
const NEAR: f64 = 0.05;

/// A warning with the first of these traces in which a parameter is off by more than a twentieth of its deviation. Only
/// for least squares on separate segments: batch least squares computes the same estimate.
pub(crate) fn doubt(trained: &Trained, traces: &[LabelledTrace]) -> Option<String> {
    let recipe = &trained.recipe;
    if !recipe.estimation.is_batch() || !trained.identifies() {
        return None;
    }
    let core = Embedded::new(trained.to_core().ok()?).ok()?;
    let mut looked_at: Vec<&LabelledTrace> = (0..trained.classes.len())
        .filter_map(|class| traces.iter().find(|own| own.class == class && own.trace.missing.count() == 0))
        .collect();
    looked_at.truncate(LOOKED_AT);
    looked_at.into_iter().find_map(|own| {
        let segment = own.trace.first_rows(trained.segment_samples);
        let first = core.run(&segment).into_iter().next().filter(|first| first.estimated)?;
        let batch = least_squares(&segment, recipe.structure).ok()?;
        let deviations = batch.deviations();
        let (single, double) = (of_core(recipe.structure, &first.delta, first.variance), vector(&batch));
        let off = |k: usize| (single[k] - double[k]).abs() / deviations[k];
        let worst = (0..deviations.len()).max_by(|j, k| off(*j).total_cmp(&off(*k)))?;
        (off(worst) > NEGLIGIBLE).then(|| {
            format!(
                "trace {}: in single precision parameter {} is off by {:.2} of its standard deviation; subtract the \
                 levels of the signals, for example \"{y}-{:.4}\", or take shorter segments",
                own.trace.id,
                recipe.structure.names()[worst],
                off(worst),
                mean_sd(&own.trace.y).0,
                y = recipe.columns.y
            )
        })
    })
}

/// Compares the novel healthy segments of training by the core with those by the trained gate in double precision.
///
/// # Errors
/// Other segments than those that are near the limit, or left out of training, are judged differently; it names the
/// feature that differs most.
pub(crate) fn agree(trained: &Trained, traces: &[LabelledTrace]) -> Result<(), Error> {
    let Some(gate) = &trained.watch.gate else { return Ok(()) };
    let table = &trained.coordinates;
    let own = (0..table.rows.len()).filter(|&row| table.classes[row] == gate.class);
    let surprises: Vec<f64> =
        own.map(|row| gate.surprise(&table.rows[row], &table.variances[row]).unwrap_or(f64::INFINITY)).collect();
    let core = trained.embed()?;
    let healthy = traces.iter().filter(|own| own.class == gate.class);
    let segments: Vec<SegmentReport> =
        healthy.collect::<Vec<_>>().par_iter().flat_map(|own| core.run(&own.trace)).collect();
    let judged: Vec<&SegmentReport> = segments.iter().filter(|segment| segment.verdict.is_ok()).collect();
    let novel = |surprise: f64| surprise >= gate.limit;
    let by_core = judged.iter().filter(|segment| novel(f64::from(segment.surprise))).count();
    let by_gate = surprises.iter().filter(|surprise| novel(**surprise)).count();
    let near = |surprise: &f64| (surprise - gate.limit).abs() <= NEAR * gate.limit;
    let doubted = trained.doubted.as_ref().map_or(0, Doubted::left_out);
    // A segment that is left out of training may be judged either way.
    let may_differ = surprises.iter().filter(|surprise| near(surprise)).count() + doubted;
    if by_core.abs_diff(by_gate) <= may_differ {
        return Ok(());
    }
    Err(Error::Training(format!(
        "of the healthy segments of training the detector calls {by_core} of {} novel, and the trained gate {by_gate} of \
         {}: {}; subtract the levels of the signals, or leave the feature out",
        judged.len(),
        surprises.len(),
        most_different(trained, gate.class, &judged)
    )))
}

/// The feature whose mean differs most between the core's healthy segments and those of training, in words.
fn most_different(trained: &Trained, healthy: usize, judged: &[&SegmentReport]) -> String {
    let catalogue = trained.catalogue();
    let names = catalogue.names();
    let each = |(k, name): (usize, &String)| {
        let place = names.iter().position(|own| own == name)?;
        let of_core: Vec<f64> = judged
            .iter()
            .map(|segment| features_of(segment, &catalogue))
            .filter_map(|(value, variance)| variance[place].is_finite().then_some(value[place]))
            .collect();
        let of_training: Vec<f64> = trained.raw.with(healthy, k).map(|row| trained.raw.rows[row][k]).collect();
        let ((core, _), (mean, deviation)) = (mean_sd(&of_core), mean_sd(&of_training));
        let off = (core - mean).abs() / deviation;
        Some((off, format!("{name} is {core:.6} in the mean there and {mean:.6} ± {deviation:.6} here")))
    };
    let worst = trained.feature_names.iter().enumerate().filter_map(each).max_by(|a, b| a.0.total_cmp(&b.0));
    worst.map_or_else(|| "no feature differs".into(), |(_, words)| words)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;
    use crate::identify::Structure;
    use crate::trace::Trace;
    use crate::train::{Alarms, Recipe, train};

    /// Two classes on a level, in deviations of the output.
    fn on(level: f64) -> Option<String> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let mut trace = |k: usize| {
            let (pole, mut y) = (0.8 + 0.1 * (k % 2) as f64, vec![level; 9_900]);
            let mut u1 = y.clone();
            for row in 1..y.len() {
                y[row] = pole * y[row - 1] + (1.0 - pole) * u1[row - 1] + 0.5 * normal();
                u1[row] += 0.1 * normal();
            }
            let trace = Trace { id: k.to_string(), u2: vec![0.0; y.len()], y, u1, ..Trace::default() };
            LabelledTrace { trace, class: k % 2 }
        };
        let traces: Vec<LabelledTrace> = (0..12).map(&mut trace).collect();
        // On a high level the other parameters follow from the first.
        let features = vec!["a1".into(), "log_variance".into()];
        let recipe = Recipe { features, ..Recipe::new(Structure::new(1, 1, 0, 1, 1)) };
        let trained = train(&traces, &["a".into(), "b".into()], &recipe).expect("a model");
        doubt(&trained, &traces)
    }

    #[test]
    fn a_system_without_noise_is_judged_as_trained() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut trace = |k: usize| {
            let u1: Vec<f64> = (0..600).map(|_| StandardNormal.sample(&mut rng)).collect();
            let mut y = vec![0.0; u1.len()];
            (1..y.len()).for_each(|row| y[row] = 0.9 * y[row - 1] + 0.1 * u1[row - 1]);
            let trace = Trace { id: k.to_string(), u2: vec![0.0; y.len()], y, u1, ..Trace::default() };
            LabelledTrace { trace, class: 0 }
        };
        let traces: Vec<LabelledTrace> = (0..60).map(&mut trace).collect();
        let alarms = Alarms { healthy: Some(0), false_alarm: 0.01, ..Alarms::default() };
        let recipe = Recipe { alarms, features: vec!["a1".into()], ..Recipe::new(Structure::new(1, 1, 0, 1, 1)) };
        let mut trained = train(&traces, &["healthy".into()], &recipe).expect("a model");
        agree(&trained, &traces).expect("the features of training are those of the core");
        // A gate that is trained on other features than the core has is refused, and the feature named.
        trained.coordinates.rows.iter_mut().for_each(|row| *row *= 1e3);
        trained.raw.rows.iter_mut().for_each(|row| *row *= 1e3);
        let told = agree(&trained, &traces).expect_err("other features").to_string();
        assert!(told.contains("a1 is ") && told.contains("novel, and the trained gate"), "{told}");
    }

    #[test]
    fn high_levels_are_told_and_usual_ones_are_not() {
        assert_eq!(on(0.0), None);
        assert_eq!(on(10.0), None);
        let told = on(2e4).expect("a doubt");
        assert!(told.contains("in single precision parameter") && told.contains("subtract the levels"), "{told}");
    }
}
