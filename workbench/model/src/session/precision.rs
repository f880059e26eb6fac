//! Whether single precision is fine enough for the signals. The detector's estimates are compared with those of batch
//! least squares in double precision.
//!
//! Rounding grows with the ratio of the signals' levels to the residual, and with the rows of a segment
//! (`factor/triangle.rs` of the core says how far it may be neglected).

use crate::core::Embedded;
use crate::core::features::{of_core, vector};
use crate::identify::{Terms as _, least_squares};
use crate::trace::labels::LabelledTrace;
use crate::train::Trained;

/// Traces that are looked at, of different classes first: those of one drive are on one level.
const LOOKED_AT: usize = 4;
/// Part of its deviation by which a parameter may be off.
const NEGLIGIBLE: f64 = 0.05;

/// A warning with the first of these traces in which a parameter is off by more than a twentieth of its deviation. Only
/// for least squares on separate segments: batch least squares computes the same estimate.
pub(super) fn doubt(trained: &Trained, traces: &[LabelledTrace]) -> Option<String> {
    let recipe = &trained.recipe;
    if !recipe.estimation.is_batch() {
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
                crate::statistics::mean_sd(&own.trace.y).0,
                y = recipe.columns.y
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;
    use crate::identify::Structure;
    use crate::trace::Trace;
    use crate::train::{Recipe, train};

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
    fn high_levels_are_told_and_usual_ones_are_not() {
        assert_eq!(on(0.0), None);
        assert_eq!(on(10.0), None);
        let told = on(2e4).expect("a doubt");
        assert!(told.contains("in single precision parameter") && told.contains("subtract the levels"), "{told}");
    }
}
