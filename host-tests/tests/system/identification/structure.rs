//! Structure search against the estimators of single structures, on the standard rig.

use std::slice::from_ref;

use model::identify::{self, Structure};
use model::structure::{Estimator, Grid, Search, search};
use model::trace::Trace;
use rig::{Scenario, simulate};

/// A healthy trace; u1 is the error of the velocity, or its reference.
fn rig(seed: u64, error: bool) -> Trace {
    let trace = simulate(&Scenario::STANDARD, seed).expect("the standard rig runs");
    let u1 = if error {
        host_tests::difference(&trace.velocity_ref_rad_s, &trace.velocity_rad_s)
    } else {
        trace.velocity_ref_rad_s
    };
    let (y, u2) = (trace.current_a, trace.load_torque_nm);
    Trace { id: format!("rig {seed}"), interval_s: Some(0.002), y, u1, u2, ..Trace::default() }
}

fn grid(max: Structure, offset: bool) -> Vec<Structure> {
    Grid::up_to(max, offset).structures().expect("a grid")
}

/// Largest relative difference of θ, σ² and fit between every structure of a search and its single estimate.
fn worst(train: &Trace, validate: &Trace, search: &Search, method: identify::Method) -> f64 {
    let mut worst = 0.0_f64;
    for candidate in &search.candidates {
        let structure = candidate.fitted.structure;
        let single = identify::estimate(train, structure, method).expect("estimated by the search too");
        // θ relative to its own size: a parameter near zero is as exact as the others.
        let size = single.theta.amax();
        for (got, want) in candidate.fitted.theta.iter().zip(single.theta.iter()) {
            worst = worst.max((got - want).abs() / size);
        }
        worst = worst.max((candidate.fitted.variance() / single.variance - 1.0).abs());
        assert_eq!((candidate.fitted.rows, candidate.stable), (single.rows, single.is_stable()), "{structure:?}");
        let output = identify::simulate(validate, structure, single.theta.as_slice());
        let fit = identify::fit_percent(&validate.y, &output);
        worst = worst.max((candidate.fit_percent - fit).abs() / 100.0);
    }
    worst
}

#[test]
fn every_least_squares_structure_is_that_of_identify() {
    for (error, offset) in [(true, false), (true, true), (false, false)] {
        let (train, validate) = (rig(1, error), rig(2, error));
        let structures = grid(Structure::new(4, 4, 4, 4, 4), offset);
        let found = search(from_ref(&train), from_ref(&validate), &structures, Estimator::Ls).expect("a search");
        assert_eq!(found.candidates.len() + found.refused.len(), 1024);
        for refusal in &found.refused {
            assert!(identify::least_squares(&train, refusal.structure).is_err(), "{refusal:?}");
        }
        // The pure sine of the reference carries two terms, not three.
        assert_eq!(found.refused.len(), if error { 0 } else { 512 });
        let worst = worst(&train, &validate, &found, identify::Method::Ls);
        println!("ls, error input {error}, offset {offset}: {worst:.1e} over {} structures", found.candidates.len());
        // Rounding times the condition of the columns; two lags of a slow sine have one of about a thousand.
        assert!(worst < 1e-9 && worst > 0.0, "{worst:e}");
    }
}

#[test]
fn every_iv4_structure_is_that_of_identify() {
    for (error, offset) in [(true, false), (false, true)] {
        let (train, validate) = (rig(1, error), rig(2, error));
        let structures = grid(Structure::new(3, 2, 3, 2, 2), offset);
        let found = search(from_ref(&train), from_ref(&validate), &structures, Estimator::Iv4).expect("a search");
        assert_eq!(found.candidates.len() + found.refused.len(), 72);
        assert!(found.candidates.len() >= 60, "{:?}", found.refused);
        let worst = worst(&train, &validate, &found, identify::Method::Iv4);
        println!("iv4, error input {error}, offset {offset}: {worst:.1e} over {} structures", found.candidates.len());
        // Rounding, magnified by the nearly redundant columns of the wider structures.
        assert!(worst < 1e-8 && worst > 0.0, "{worst:e}");
    }
}

/// Stacked traces: one trace cut in two loses only the rows at the cut, and one given twice changes nothing but N.
#[test]
fn several_traces_give_one_model() {
    let (train, validate) = (rig(1, true), rig(2, true));
    let structures = grid(Structure::new(2, 2, 2, 2, 1), false);
    for estimator in [Estimator::Ls, Estimator::Iv4] {
        let once = search(from_ref(&train), from_ref(&validate), &structures, estimator).expect("a search");
        let both = [train.clone(), train.clone()];
        let twice = search(&both, from_ref(&validate), &structures, estimator).expect("a search");
        for (one, two) in once.candidates.iter().zip(&twice.candidates) {
            assert_eq!(two.fitted.rows, 2 * one.fitted.rows);
            for (a, b) in one.fitted.theta.iter().zip(&two.fitted.theta) {
                assert!((a - b).abs() < 1e-8, "{estimator:?} {a} {b}"); // rounding of another summation order
            }
        }
    }
    let half = train.y.len() / 2;
    let part = |range: std::ops::Range<usize>| Trace {
        y: train.y[range.clone()].to_vec(),
        u1: train.u1[range.clone()].to_vec(),
        u2: train.u2[range].to_vec(),
        ..train.clone()
    };
    let parts = [part(0..half), part(half..train.y.len())];
    let cut = search(&parts, from_ref(&validate), &structures, Estimator::Ls).expect("a search");
    let whole = search(&[train], &[validate], &structures, Estimator::Ls).expect("a search");
    for (a, b) in cut.candidates.iter().zip(&whole.candidates) {
        assert_eq!(b.fitted.rows - a.fitted.rows, a.fitted.structure.depth());
        let change = (a.fitted.theta[0] - b.fitted.theta[0]).abs();
        // Three rows of 5000 move a parameter by a small part of its deviation of about 1e-2.
        assert!(change < 1e-2 && change > 0.0, "{change}");
    }
}

/// An ARX system of known structure in noise: fit, AIC and MDL find it, and overfits win nothing.
#[test]
fn a_known_structure_is_found() {
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};
    let draw = |seed: u64| {
        let mut source = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut noise = |n: usize| -> Vec<f64> { (0..n).map(|_| StandardNormal.sample(&mut source)).collect() };
        let (u1, u2, e) = (noise(3000), noise(3000), noise(3000));
        let at = |x: &[f64], t: usize, lag: usize| if t >= lag { x[t - lag] } else { 0.0 };
        let mut y = vec![0.0; 3000];
        for t in 0..y.len() {
            y[t] = 1.5 * at(&y, t, 1) - 0.7 * at(&y, t, 2)
                + at(&u1, t, 2)
                + 0.5 * at(&u1, t, 3)
                + 0.8 * at(&u2, t, 1)
                + 0.1 * e[t];
        }
        Trace { id: format!("arx {seed}"), y, u1, u2, ..Trace::default() }
    };
    let truth = Structure::new(2, 2, 1, 2, 1);
    let structures = grid(Structure::new(4, 4, 3, 3, 3), false);
    let found = search(&[draw(1)], &[draw(2)], &structures, Estimator::Ls).expect("a search");
    assert_eq!(found.best_mdl().expect("a best").fitted.structure, truth);
    let chosen = found.find(truth).expect("in the grid");
    let best = found.best_fit().expect("a best").fit_percent;
    assert!(best >= chosen.fit_percent && best - chosen.fit_percent < 0.05, "{best} {}", chosen.fit_percent);
    // AIC charges two a parameter where a superfluous one gains about one: it keeps the truth within its best few.
    let aic = found.best_aic().expect("a best").fitted.structure;
    assert!(aic.na >= 2 && aic.na <= 4 && aic.nkb <= 2 && aic.nb + aic.nkb >= 4, "{aic:?}");
    let by_count = found.best_by_count();
    assert_eq!(by_count.first().map(|c| c.fitted.parameters()), Some(3));
    let five = by_count.iter().find(|c| c.fitted.parameters() == 5).expect("five parameters");
    assert_eq!(five.fitted.structure, truth);
}

#[test]
fn bad_input_is_one_clear_line() {
    let good = rig(1, true);
    let structures = grid(Structure::new(2, 2, 2, 2, 2), false);
    let refused = |train: Trace, validate: Trace, structures: &[Structure]| {
        let error = search(&[train], &[validate], structures, Estimator::Ls).expect_err("bad input").to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    };
    let short = |n: usize| Trace {
        y: good.y[..n].to_vec(),
        u1: good.u1[..n].to_vec(),
        u2: good.u2[..n].to_vec(),
        ..good.clone()
    };
    let error = refused(short(9), good.clone(), &structures);
    assert!(error.contains("9 samples, but lags back to 3 and 6 parameters need 10"), "{error}");
    assert!(refused(good.clone(), short(3), &structures).contains("3 samples"));
    let delayed = [Structure::new(1, 1, 1, 20, 1)];
    assert!(refused(short(20), good.clone(), &delayed).contains("lags back to 20"));
    let still = Trace { u2: vec![0.1; good.u2.len()], ..good.clone() };
    assert!(refused(still, good.clone(), &structures).contains("u2 is constant"));
    let still = Trace { y: vec![0.0; good.y.len()], ..good.clone() };
    assert!(refused(good.clone(), still, &structures).contains("y is constant"));
    assert!(refused(good.clone(), good.clone(), &[]).contains("needs a structure"));
}
