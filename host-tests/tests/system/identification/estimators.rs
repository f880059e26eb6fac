//! Estimators against truths found another way: searches of other programs, a textbook anchor, noise-free data; and
//! what they say of data that cannot be estimated.

use host_tests::data;
use model::Error;
use model::identify::{Method, Noise, Options, Structure, estimate, estimate_with, fit_percent, simulate};
use model::trace::{Channels, Trace, stem};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use traces::read;

const ALL: [Method; 7] = [Method::Ls, Method::Iv, Method::Iv4, Method::Sriv, Method::Sm, Method::Oe, Method::Armax];

fn white(generator: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| StandardNormal.sample(generator)).collect()
}

fn plain(order: Structure) -> Structure {
    order
}

/// Two white inputs through the model, and white output noise of the given standard deviation.
fn simulated(structure: Structure, theta: &[f64], noise: f64, samples: usize, seed: u64) -> Trace {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let [u1, u2, e] = [(); 3].map(|()| white(&mut generator, samples));
    let mut trace = Trace { id: format!("seed {seed}"), u1, u2, ..Trace::default() };
    trace.y = vec![0.0; samples];
    trace.y = simulate(&trace, structure, theta).iter().zip(&e).map(|(clean, e)| clean + noise * e).collect();
    trace
}

/// Least output error Σ from t₀ = 2, and its place, on the twelve open traces (error, [2 2 2 1 1]): the lowest end of
/// twelve starts of scipy 1.17.1 `least_squares(method="lm")` with numerical derivatives on `lfilter` simulations.
const SCIPY: [(f64, [f64; 6]); 12] = [
    (108.270010203, [-1.25040324, 0.284499462, 0.335495299, -0.333569603, 0.516032665, 0.151339443]),
    (109.011316227, [-1.25525192, 0.289001528, 0.332818119, -0.33097319, 0.510115699, 0.151120543]),
    (110.197569407, [-1.25387865, 0.289001363, 0.331562312, -0.329678337, 0.518922196, 0.170480502]),
    (112.602359556, [-1.253536, 0.287669984, 0.33043502, -0.32856542, 0.558961502, 0.110646225]),
    (188.809317202, [-1.24269534, 0.281354839, 0.324004269, -0.321452843, 0.457673909, 0.282054236]),
    (214.362204965, [-1.25236065, 0.287751413, 0.32851463, -0.326159982, 0.551969514, 0.130221174]),
    (188.927402608, [-1.23796486, 0.276846577, 0.329876657, -0.327303126, 0.507155202, 0.239092354]),
    (233.011454307, [-1.26081794, 0.291405623, 0.33253866, -0.330310883, 0.478191502, 0.108753463]),
    (331.336825011, [-1.75831615, 0.758327699, 0.0425813681, -0.0424448939, 3.29798415, -3.2973002]),
    (330.537170150, [-1.75984956, 0.759862056, 0.0422355471, -0.0421001109, 3.2763442, -3.27562273]),
    (332.998868198, [-1.76008533, 0.760096467, 0.0421097077, -0.0419745131, 3.28010774, -3.27944795]),
    (337.910951767, [-1.76571398, 0.765726449, 0.0409827597, -0.0408503219, 3.2057113, -3.20509554]),
];

#[test]
fn output_error_reaches_the_least_minimum_that_scipy_found() {
    let Some(folder) = data("dc_motor_reference") else { return };
    let u1 = "velocity_ref_rad_s-velocity_rad_s";
    let channels = Channels::new("current_a", u1, "load_torque_nm");
    let (mut worst, mut above) = (0.0_f64, 0.0_f64);
    for trace in read(&[folder], &channels).expect("readable traces") {
        let number: usize = stem(&trace.id).trim_start_matches("trace_").parse().expect("trace number");
        let found = estimate(&trace, plain(Structure::new(2, 2, 2, 1, 1)), Method::Oe).expect("well posed");
        assert!(found.convergence.converged && found.convergence.stable, "{}: {:?}", trace.id, found.convergence);
        let loss: f64 = found.residuals.iter().map(|e| e * e).sum();
        let (least, theta) = SCIPY[number];
        above = above.max((loss / least - 1.0).abs());
        for (got, want) in found.theta.iter().zip(theta) {
            worst = worst.max((got - want).abs() / want.abs());
        }
    }
    println!("oe against scipy: parameters {worst:.1e} relative, sum of squares {above:.1e} relative");
    // scipy's numerical derivatives leave it 1e-5 from the minimum, where the sum is flat to the square of that.
    assert!(worst < 1e-4 && above < 1e-8 && worst > 0.0);
}

/// Nelder and Mead's simplex, for a few parameters near one in size.
fn simplex(start: &[f64], loss: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let n = start.len();
    let mut points: Vec<Vec<f64>> = (0..=n).map(|_| start.to_vec()).collect();
    (0..n).for_each(|k| points[k + 1][k] += 0.1);
    let mut points: Vec<(f64, Vec<f64>)> = points.into_iter().map(|p| (loss(&p), p)).collect();
    for _ in 0..2000 {
        points.sort_by(|one, other| one.0.total_cmp(&other.0));
        let centre: Vec<f64> = (0..n).map(|k| points[..n].iter().map(|p| p.1[k]).sum::<f64>() / n as f64).collect();
        let along = |share: f64| -> (f64, Vec<f64>) {
            let p: Vec<f64> = centre.iter().zip(&points[n].1).map(|(c, worst)| c + share * (c - worst)).collect();
            (loss(&p), p)
        };
        let mirrored = along(1.0);
        let candidate = if mirrored.0 < points[0].0 {
            let far = along(2.0);
            if far.0 < mirrored.0 { far } else { mirrored }
        } else if mirrored.0 < points[n - 1].0 {
            mirrored
        } else {
            along(if mirrored.0 < points[n].0 { 0.5 } else { -0.5 })
        };
        if candidate.0 < points[n].0 {
            points[n] = candidate;
        } else {
            let best = points[0].1.clone();
            for (value, p) in &mut points[1..] {
                p.iter_mut().zip(&best).for_each(|(p, best)| *p = 0.5 * (*p + best));
                *value = loss(p);
            }
        }
    }
    points.sort_by(|one, other| one.0.total_cmp(&other.0));
    points.swap_remove(0).1
}

#[test]
fn output_error_is_where_a_simplex_search_ends() {
    let structure = plain(Structure::new(1, 1, 1, 1, 2));
    for seed in 0..5 {
        let trace = simulated(structure, &[-0.8, 0.7, 0.4], 1.0, 400, seed);
        let loss = |theta: &[f64]| -> f64 {
            let mut y = vec![0.0; 3];
            for t in 0..trace.y.len() {
                let at = |x: &[f64], lag: usize| if t >= lag { x[t - lag] } else { 0.0 };
                let past = if t > 0 { y[t + 2] } else { 0.0 };
                y.push(-theta[0] * past + theta[1] * at(&trace.u1, 1) + theta[2] * at(&trace.u2, 2));
            }
            trace.y[2..].iter().zip(&y[5..]).map(|(y, simulated)| (y - simulated).powi(2)).sum()
        };
        let found = estimate(&trace, structure, Method::Oe).expect("well posed");
        let searched = simplex(&[-0.5, 0.5, 0.5], loss);
        for (got, want) in found.theta.iter().zip(&searched) {
            // A search by values alone cannot see below the square root of rounding.
            assert!((got - want).abs() < 1e-6, "{:?} {searched:?}", found.theta.as_slice());
        }
        // A converged refined IV is stationary for the same sum.
        let refined = estimate(&trace, structure, Method::Sriv).expect("well posed");
        assert!((refined.theta - &found.theta).amax() < 1e-6 && refined.convergence.converged);
    }
}

#[test]
fn refined_methods_hold_the_pole_that_least_squares_loses() {
    let structure = plain(Structure::new(1, 1, 0, 1, 1));
    let mean_pole = |method: Method| -> f64 {
        let pole = |seed| {
            let trace = simulated(structure, &[-0.9, 0.743], 1.0, 2000, seed);
            -estimate(&trace, structure, method).expect("well posed").theta[0]
        };
        (0..300_u64).into_par_iter().map(pole).sum::<f64>() / 300.0
    };
    let [ls, sriv, oe] = [Method::Ls, Method::Sriv, Method::Oe].map(mean_pole);
    println!("pole 0.9, unit output noise: ls {ls:.4}, sriv {sriv:.4}, oe {oe:.4}");
    // Plim of least squares: 0.9 v/(v + 1) with v = 0.743²/(1 − 0.81) = 2.906 is 0.6696.
    assert!((ls - 0.67).abs() < 0.005, "{ls}");
    assert!((sriv - 0.9).abs() <= 0.005 && (oe - 0.9).abs() <= 0.005, "{sriv} {oe}");
}

#[test]
fn noise_free_data_give_the_model_back_by_every_method() {
    for offset in [false, true] {
        let structure = Structure { offset, ..Structure::new(2, 2, 1, 1, 3) };
        let theta = &[-1.5, 0.7, 0.5, -0.2, 0.3, 0.8][..structure.parameters()];
        let trace = simulated(structure, theta, 0.0, 300, 1);
        // The filters of iv4 start from zero, where a model with a constant term is not at rest.
        for method in ALL.into_iter().filter(|method| *method != Method::Iv4 || !offset) {
            // The residuals of an exact model are rounding: iv4 has nothing to shape, and may say so.
            let found = match estimate(&trace, structure, method) {
                Err(error) if method == Method::Iv4 => {
                    assert!(error.to_string().contains("residuals"), "{error}");
                    continue;
                }
                found => found.expect("well posed"),
            };
            for (got, want) in found.theta.iter().zip(theta) {
                assert!((got - want).abs() < 1e-8, "{method:?} {offset}: {:?}", found.theta.as_slice());
            }
            assert!(found.convergence.converged && found.convergence.stable, "{method:?}: {:?}", found.convergence);
            assert!(found.fit_percent > 99.999, "{method:?}: {}", found.fit_percent);
        }
    }
}

#[test]
fn the_two_fits_are_what_their_names_say() {
    let structure = plain(Structure::new(1, 1, 1, 1, 1));
    let trace = simulated(structure, &[-0.9, 0.743, 0.2], 1.0, 2000, 3);
    for method in ALL {
        let found = estimate(&trace, structure, method).expect("well posed");
        assert_eq!(found.residuals.len(), found.rows);
        let simulation = fit_percent(&trace.y, &simulate(&trace, structure, found.theta.as_slice()));
        assert_eq!(found.fit_percent, simulation);
        let measured = &trace.y[trace.y.len() - found.rows..];
        let predicted: Vec<f64> = measured.iter().zip(&found.residuals).map(|(y, e)| y - e).collect();
        assert!((found.prediction_fit_percent - fit_percent(measured, &predicted)).abs() < 1e-9); // same sums
        if found.noise == Noise::Output {
            // One sample less of 2000.
            assert!((found.prediction_fit_percent - found.fit_percent).abs() < 0.1, "{method:?}");
        }
        if method == Method::Ls {
            // Least squares has the least equation error, and simulates worse than the least output error.
            let oe = estimate(&trace, structure, Method::Oe).expect("well posed");
            assert!(found.fit_percent < oe.fit_percent - 1.0, "{} {}", found.fit_percent, oe.fit_percent);
        }
    }
}

#[test]
fn armax_finds_the_noise_polynomial_with_honest_deviations() {
    let structure = plain(Structure::new(1, 1, 0, 1, 1));
    let (mut held, mut sum, runs) = (0, 0.0, 400);
    for seed in 0..runs {
        let mut trace = simulated(structure, &[-0.8, 1.0], 0.0, 600, seed);
        let e = white(&mut ChaCha8Rng::seed_from_u64(10_000 + seed), 600);
        let mut noise = 0.0;
        for t in 1..600 {
            noise = 0.8 * noise + e[t] + 0.6 * e[t - 1]; // A w = D e
            trace.y[t] += noise;
        }
        let found = estimate(&trace, structure, Method::Armax).expect("well posed");
        let Noise::MovingAverage { terms, deviations } = &found.noise else { panic!("{:?}", found.noise) };
        held += u32::from((terms[1] - 0.6).abs() <= 1.959_964 * deviations[0]);
        sum += terms[1] - 0.6;
    }
    let (coverage, bias) = (f64::from(held) / runs as f64, sum / runs as f64);
    println!("armax d1: mean {:.4} of 0.6, 95 % intervals cover {:.1} %", 0.6 + bias, 100.0 * coverage);
    // sd of d1 is √((1 − 0.36)/600) = 0.033, of the mean 0.0016; of the share over 400 runs 1.1 %.
    assert!(bias.abs() < 0.007 && (0.91..=0.985).contains(&coverage));
}

#[test]
fn options_reach_their_methods() {
    let structure = plain(Structure::new(1, 1, 1, 1, 1));
    let trace = simulated(structure, &[-0.9, 0.743, 0.2], 1.0, 500, 4);
    for passes in 1..=3 {
        let options = Options { passes, ..Options::default() };
        let found = estimate_with(&trace, structure, Method::Iv, options).expect("well posed");
        assert_eq!(found.convergence.iterations, passes);
    }
    let terms = |noise_order| {
        let options = Options { noise_order, ..Options::default() };
        match estimate_with(&trace, structure, Method::Armax, options).expect("well posed").noise {
            Noise::MovingAverage { terms, .. } => terms.len(),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!((terms(None), terms(Some(0)), terms(Some(3))), (2, 1, 4));
}

#[test]
fn what_cannot_be_estimated_is_said_in_one_line() {
    let structure = plain(Structure::new(2, 2, 2, 1, 1));
    let good = simulated(structure, &[-1.5, 0.7, 0.5, -0.2, 0.3, 0.1], 0.1, 300, 5);
    let refuse = |trace: &Trace, structure: Structure, words: &[&str]| {
        for method in ALL {
            let error: Error = estimate(trace, structure, method).expect_err("refused");
            let line = error.to_string();
            assert!(!line.contains('\n') && words.iter().all(|word| line.contains(word)), "{method:?}: {line}");
        }
    };
    let few = Trace { y: good.y[..8].to_vec(), u1: good.u1[..8].to_vec(), u2: good.u2[..8].to_vec(), ..good.clone() };
    refuse(&few, structure, &["8 samples for 6 parameters", "record more"]);
    refuse(&few, plain(Structure::new(1, 1, 1, 20, 1)), &["8 samples", "from sample 20 on", "reduce the order"]);
    refuse(&Trace { y: vec![3.0; 300], ..good.clone() }, structure, &["output is constant", "check --y"]);
    refuse(&Trace { u2: vec![0.0; 300], ..good.clone() }, structure, &["do not excite", "c1", "column is zero"]);
    refuse(&Trace { u1: vec![2.0; 300], ..good.clone() }, structure, &["do not excite", "b2", "b1", "lower order"]);
    let sine: Vec<f64> = (0..300).map(|t| (0.05 * f64::from(t)).sin()).collect();
    let structure = plain(Structure::new(1, 3, 1, 1, 1));
    refuse(&Trace { u1: sine, ..good.clone() }, structure, &["do not excite", "b3", "b1, b2", "richer command"]);
}

#[test]
fn what_does_not_converge_is_flagged_and_finite() {
    // Output and inputs have nothing to do with each other: pole and zero cancel anywhere, or run to the circle.
    let structure = plain(Structure::new(3, 3, 3, 1, 1));
    let mut flagged = 0;
    for seed in 0..40 {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let [y, u1, u2] = [(); 3].map(|()| white(&mut generator, 60));
        let trace = Trace {
            id: "noise".into(),
            interval_s: None,
            irregular_steps: 0,
            y,
            u1,
            u2,
            motion: None,
            ..Trace::default()
        };
        for method in ALL {
            let Ok(found) = estimate(&trace, structure, method) else { continue };
            assert!(found.theta.iter().all(|p| p.is_finite()), "{method:?}, {seed}");
            assert!(found.variance.is_finite() && found.fit_percent.is_finite(), "{method:?}, {seed}");
            flagged += u32::from(!found.convergence.converged);
        }
    }
    println!("{flagged} estimates of pure noise are flagged as not converged");
    assert!((1..280).contains(&flagged));
}
