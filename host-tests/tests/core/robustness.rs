//! What happens to the core's estimators when samples go wrong: nothing that is not finite, and the next segment's error
//! is no more than twice the undisturbed one.
//!
//! Error: distance from the truth in units of the stated standard deviations, rms over parameters and runs; 1 is what
//! chance alone gives. Least squares, biased by output noise, is judged by where a long undisturbed record takes it.

use bearing_watch::estimate::{Accumulator, Fading, Guard, Instruments, Nominal, Regressor, Rows, Triangle};
use bearing_watch::{Estimate, Estimator, Reason, Regression, Sample};
use host_tests::oracle::{self, Fit, Record};
use host_tests::plants::{PLANTS, Plant};
use host_tests::streams::{L, M, P, fading, refined, regression, rho};
use rayon::prelude::*;

const RUNS: u64 = 8;
/// Three seconds; three times the memory that fades.
const SEGMENT: usize = 30_000;
/// Segments of a run; the third goes wrong, the fourth is judged.
const SEGMENTS: usize = 4;
/// Samples of standstill, a bit more than a million: whole segments.
const STANDSTILL: usize = 34 * SEGMENT;

#[derive(Clone, Copy, Debug)]
enum Fault {
    None,
    /// Reference and load rest, and so in the end does everything.
    Standstill,
    /// The same, but the output carries its noise: nothing but noise excites.
    NoisyStandstill,
    /// The recorder repeats one sample; the drive goes on.
    Frozen,
    /// All signals jump by about five times their rms for a tenth of a second.
    Jump,
    /// Bursts of one value in one signal after the other.
    Burst(f32),
}

const FAULTS: [Fault; 10] = [
    Fault::Standstill,
    Fault::NoisyStandstill,
    Fault::Frozen,
    Fault::Jump,
    Fault::Burst(f32::NAN),
    Fault::Burst(f32::INFINITY),
    Fault::Burst(f32::NEG_INFINITY),
    Fault::Burst(1e30),
    Fault::Burst(1e3),
    Fault::Burst(15.0),
];

/// A run with the fault in the middle of the third segment. Whole segments may come in between.
fn record(plant: &Plant, noise: f64, seed: u64, fault: Fault) -> Vec<Sample> {
    let mut source = plant.source(noise, seed);
    let middle = 2 * SEGMENT + SEGMENT / 2;
    let mut samples: Vec<_> = source.by_ref().take(middle).collect();
    match fault {
        Fault::Standstill | Fault::NoisyStandstill => {
            source.hold(true, if matches!(fault, Fault::Standstill) { 0.0 } else { noise });
            samples.extend(source.by_ref().take(STANDSTILL));
            source.hold(false, noise);
        }
        Fault::Frozen => samples.extend(std::iter::repeat_n(samples[middle - 1], STANDSTILL)),
        Fault::None | Fault::Jump | Fault::Burst(_) => {}
    }
    let from = samples.len();
    samples.extend(source.take(SEGMENTS * SEGMENT - middle));
    for (place, sample) in samples[from..].iter_mut().enumerate() {
        let Sample { y, u1, u2 } = sample;
        match (fault, place) {
            (Fault::Jump, ..100) => (*y, *u1, *u2) = (*y + 5.0, *u1 + 5.0, *u2 + 5.0),
            (Fault::Burst(value), ..300) => match (place / 10) % 10 {
                0 => *y = value,
                3 => *u1 = value,
                6 => *u2 = value,
                _ => {}
            },
            _ => {}
        }
    }
    samples
}

fn finite(result: &Result<Estimate<M, P>, Reason>) -> bool {
    result.as_ref().map_or(true, |estimate| {
        estimate.variance.is_finite() && estimate.delta.iter().chain(&estimate.covariance).all(|x| x.is_finite())
    })
}

/// The last segment's estimate; looks at the open segment now and then.
fn last<R: Rows<M>, A: Accumulator<M, P>>(regression: &Regression<M>, samples: &[Sample]) -> Estimate<M, P> {
    assert!(Estimator::<M, P, L, R, A>::fits(regression));
    let mut estimator = Estimator::<M, P, L, R, A>::new(regression);
    let mut result = Err(Reason::TooFewRows);
    for segment in samples.chunks_exact(SEGMENT) {
        for (place, sample) in segment.iter().enumerate() {
            estimator.step(sample);
            assert!(place % 997 != 0 || finite(&estimator.estimate()), "{place}");
        }
        result = estimator.close();
        assert!(finite(&result));
    }
    result.expect("an estimate of the last segment")
}

type Method = fn(&Regression<M>, &[Sample]) -> Estimate<M, P>;

#[test]
fn every_mode_stays_finite_and_recovers_within_a_segment() {
    let plant = &PLANTS[4];
    let (order, noise) = (plant.order(), plant.noise(20.0));
    let long: Vec<_> = plant.source(noise, 77).take(200_000).collect();
    let long_record = Record::new(&long);
    // Signals have an rms of one or two; spikes of fifteen pass the range guard and meet the weights.
    let guard = Guard { huber: 6.0, stuck_samples: [50, 0, 0], ..Guard::within([20.0; 3]) };
    let settled = oracle::least_squares(&long_record, order, order.depth()..long.len(), 1.0).delta(order);
    let mut delta = [0.0; M];
    delta.iter_mut().zip(&settled.theta).for_each(|(cell, x)| *cell = *x as f32);
    let nominal = Nominal { delta, deviation: settled.variance.sqrt() as f32 };
    // Mean motions are near 0.5 unfiltered and 4e-4 filtered.
    let least = Regression { nominal, guard, still: 0.2, ..regression(order, &long) };
    let refined = refined(plant, &long);
    let refined = Regression {
        settle: 300,
        still: 5e-5,
        nominal: Nominal { deviation: noise as f32, ..refined.nominal },
        guard,
        ..refined
    };
    let truth = oracle::delta(order, &plant.truth());
    let methods: [(&str, Method, Regression<M>, &nalgebra::DVector<f64>); 4] = [
        ("least squares", last::<Regressor<M, L>, Triangle<M, P>>, least, &settled.theta),
        ("refined", last::<Instruments<M, L>, Triangle<M, P>>, refined, &truth),
        ("fading", last::<Regressor<M, L>, Fading<M, P>>, fading(least, 1e-3), &settled.theta),
        ("fading refined", last::<Instruments<M, L>, Fading<M, P>>, fading(refined, 1e-3), &truth),
    ];
    let mut failures = vec![];
    println!("error after one segment, in standard deviations (and times the undisturbed)");
    for (name, method, regression, aim) in methods {
        let error = |fault: Fault| {
            let squares = (0..RUNS).into_par_iter().map(|seed| {
                let estimate = method(&regression, &record(plant, noise, 500 + seed, fault));
                let n = estimate.parameters();
                let covariance = estimate.covariance_matrix().view((0, 0), (n, n)).map(f64::from);
                let fit = Fit { theta: aim.clone(), covariance, variance: 0.0, rows: 0 };
                rho(&estimate.delta, &fit).powi(2)
            });
            (squares.sum::<f64>() / RUNS as f64).sqrt()
        };
        let undisturbed = error(Fault::None);
        println!("{name:16}{undisturbed:6.2}");
        for fault in FAULTS {
            let found = error(fault);
            let times = found / undisturbed;
            println!("{name:16}{found:6.2} ({times:.2})  {fault:?}");
            // Half of it would mean that the fault teaches something.
            if !(0.5..=2.0).contains(&times) {
                failures.push(format!("{name}, {fault:?}: {found} after {undisturbed}"));
            }
        }
        // Chance alone gives 1, of eight runs of five parameters to a fifth or so; fading memory weighs few rows.
        assert!((0.5..1.5).contains(&undisturbed), "{name}: {undisturbed}");
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn a_constant_term_survives_rejected_samples() {
    let plant = &PLANTS[4];
    let (order, noise) = (plant.order(), plant.noise(20.0));
    let truth = oracle::delta(order, &plant.truth());
    let shifted = |sample: Sample| Sample { y: sample.y + 30.0, u1: sample.u1 - 20.0, u2: sample.u2 + 10.0 };
    let long: Vec<_> = plant.source(noise, 77).take(200_000).map(shifted).collect();
    let mut segments = refined(plant, &long);
    segments.offset = true;
    // A restart's transient is as large as the signal: exp(−6) of it is left. Half the wait costs 2.7 here instead of 1.
    segments.settle = 300;
    // The target's scale moves one place on behind the constant's; the nominal constant is that of the shift.
    let n = order.parameters();
    (segments.scale[n + 1], segments.scale[n]) = (segments.scale[n], 1.0);
    let level = |k: usize| f64::from(segments.nominal.delta[k]);
    let (t0, beta, gamma) = (level(0), level(order.na.into()), level((order.na + order.nb).into()));
    segments.nominal.delta[n] = (-(t0 * 30.0) + beta * 20.0 - gamma * 10.0) as f32;
    let methods: [(&str, Method, Regression<M>); 2] = [
        ("refined", last::<Instruments<M, L>, Triangle<M, P>>, segments),
        (
            "fading refined",
            last::<Instruments<M, L>, Fading<M, P>>,
            fading(Regression { still: 5e-8, ..segments }, 1e-3),
        ),
    ];
    println!("with a constant term: error without and with a rejected sample every 2500, in standard deviations");
    for (name, method, regression) in methods {
        let error = |holes: bool| {
            let squares = (0..RUNS).into_par_iter().map(|seed| {
                let samples = plant.source(noise, 900 + seed).take(SEGMENTS * SEGMENT).map(shifted);
                let punched = |(place, sample): (usize, Sample)| {
                    if holes && place % 2500 == 0 { Sample { y: f32::NAN, ..sample } } else { sample }
                };
                let samples: Vec<_> = samples.enumerate().map(punched).collect();
                let estimate = method(&regression, &samples);
                let covariance = estimate.covariance_matrix().view((0, 0), (n, n)).map(f64::from);
                let fit = Fit { theta: truth.clone(), covariance, variance: 0.0, rows: 0 };
                rho(&estimate.delta, &fit).powi(2)
            });
            (squares.sum::<f64>() / RUNS as f64).sqrt()
        };
        let found = [error(false), error(true)];
        println!("{name:16}{:6.2} {:6.2}", found[0], found[1]);
        // Rows of one segment around several origins would give 20.
        assert!(found.iter().all(|error| (0.5..1.5).contains(error)), "{name}: {found:?}");
    }
}
