//! The core's streaming refined instrumental variables, f32, against double precision on the same samples.
//!
//! Two readings, each the largest error of a δ-parameter in units of its standard deviation σ, over the third and
//! fourth segment:
//!
//! * *arithmetic*: against one pass with the very auxiliary models that the stream had;
//! * *statistics*: against the batch estimate over the same rows, iterated until it rests on its own model.
//!
//! The second is no matter of arithmetic. A pass answers to its auxiliary model by K = ∂θ̂/∂θ_aux, which is of the
//! structure of the noise over the signal within the filter's band; the stream's auxiliary model is the estimate of the
//! segment before and so differs from the batch's by about √2 σ. To first structure
//!
//! ```text
//! stream − batch = K (θ_before − θ_batch)                                                         (1)
//! ```
//!
//! *left* is what (1) does not explain. K falls as the record grows, so where the second reading is too large, longer
//! segments cure it; in f32 or f64 alike.

use host_tests::oracle::{self, Record};
use host_tests::plants::{PLANTS, Plant};
use host_tests::streams::{Run, refined, worst};
use nalgebra::DVector;
use rayon::prelude::*;

struct Readings {
    arithmetic: f64,
    statistics: f64,
    left: f64,
    /// Norm of K where the covariance is the unit matrix.
    gain: f64,
}

fn readings(plant: &Plant, ratio_db: f64) -> Readings {
    let structure = plant.structure();
    let length = if plant.rate_hz > 5e3 { 40_000 } else { 20_000 };
    let samples: Vec<_> = plant.source(plant.noise(ratio_db), 11).take(4 * length).collect();
    let run = Run::new(&refined(plant, &samples), &samples, length);
    let record = Record::new(&samples);
    let mut found = Readings { arithmetic: 0.0, statistics: 0.0, left: 0.0, gain: 0.0 };
    for number in 2..4 {
        let estimate = run.segments[number].as_ref().expect("an estimate");
        let rows = run.rows(number);
        let pass = oracle::one_pass(&record, structure, &run.course, rows.clone()).delta(structure);
        found.arithmetic = found.arithmetic.max(worst(estimate.delta(), &pass));
        let (batch, _) = oracle::batch(&record, structure, &plant.truth(), rows.clone()).expect("converges");
        let answer = oracle::sensitivity(&record, structure, &batch, &rows);
        let batch = batch.delta(structure);
        found.statistics = found.statistics.max(worst(estimate.delta(), &batch));
        let sd = DVector::from_vec(batch.deviations());
        let before = oracle::delta(structure, &run.course.auxiliaries[number].1);
        let left = (pass.theta - &batch.theta - &answer * (before - &batch.theta)).component_div(&sd); // (1)
        found.left = found.left.max(left.amax());
        let root = batch.covariance.cholesky().expect("positive definite").l();
        let whitened = root.solve_lower_triangular(&(answer * &root)).expect("regular");
        found.gain = found.gain.max(whitened.singular_values().max());
    }
    found
}

#[test]
fn follows_double_precision_within_a_small_part_of_sigma() {
    let cases: Vec<_> = PLANTS.iter().flat_map(|plant| [25.0, 20.0, 10.0].map(|ratio_db| (plant, ratio_db))).collect();
    let found: Vec<_> = cases.par_iter().map(|(plant, ratio_db)| readings(plant, *ratio_db)).collect();
    println!("{:20}{:>4}{:>12}{:>12}{:>8}{:>8}", "in units of σ", "dB", "arithmetic", "statistics", "left", "|K|");
    let (mut within, mut failures) = (0, vec![]);
    for ((plant, ratio_db), found) in cases.into_iter().zip(found) {
        let Readings { arithmetic, statistics, left, gain } = found;
        let line = format!("{:20}{ratio_db:>4}{arithmetic:>12.1e}{statistics:>12.3}{left:>8.3}{gain:>8.3}", plant.name);
        println!("{line}");
        let limit = if ratio_db < 15.0 { 0.1 } else { 0.05 };
        within += u32::from(statistics <= limit);
        // Ten times the largest found; no f32 comes closer than a millionth. What (1) leaves is of second structure in
        // the auxiliary model's error.
        if !(1e-6..=0.006).contains(&arithmetic) || left > limit || (statistics > limit && statistics > 8.0 * gain) {
            failures.push(line);
        }
    }
    println!("{within} of 36 within 0.05 (0.1 at 10 dB) of the iterated batch");
    assert!(failures.is_empty(), "{failures:#?}");
    assert!((26..=30).contains(&within), "27 when this was written");
}
