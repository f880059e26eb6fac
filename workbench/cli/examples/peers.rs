//! The workbench's part of `cargo xtask docs peers`: measures the times of the tasks that other programs are timed on.
//!
//! `peers write DIR` writes a training and a validation trace, `peers time DIR` reads them and prints one JSON object:
//! medians in seconds, the estimates for the comparison of accuracy, and the best structures.

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use model::identify::{self, Estimate, Structure};
use model::structure::{Estimator, Grid, estimate_all, search};
use model::trace::{Channels, Trace};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rig::{Scenario, simulate};
use serde_json::{Value, json};
use traces::read;

/// Structure of the single estimates.
const SINGLE: Structure = Structure::new(2, 2, 2, 1, 1);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["write", folder] => write(Path::new(folder)),
        ["time", folder] => {
            println!("{}", time(Path::new(folder))?);
            Ok(())
        }
        _ => Err("usage: peers write DIR | peers time DIR".into()),
    }
}

/// Structure with one input, for programs that do not support a second one.
const ONE_INPUT: Structure = Structure::new(2, 2, 0, 1, 1);

/// Writes two healthy traces of the standard rig, with all digits.
fn write(folder: &Path) -> Result<(), Box<dyn Error>> {
    for (name, seed) in [("train", 1), ("validate", 2)] {
        let trace = simulate(&Scenario::STANDARD, seed)?;
        let mut text = String::from("current_a,velocity_error_rad_s,load_torque_nm,velocity_ref_rad_s\n");
        for k in 0..trace.current_a.len() {
            let error = trace.velocity_ref_rad_s[k] - trace.velocity_rad_s[k];
            let (y, u2, reference) = (trace.current_a[k], trace.load_torque_nm[k], trace.velocity_ref_rad_s[k]);
            text += &format!("{y},{error},{u2},{reference}\n");
        }
        std::fs::write(folder.join(name).with_extension("csv"), text)?;
    }
    write_armax(folder)
}

/// True parameters of the ARMAX record: a₁ a₂ b₁ b₂ c₁ c₂ of [`SINGLE`], and d₁.
const ARMAX: ([f64; 6], f64) = ([-1.2, 0.4, 0.5, 0.3, -0.4, 0.2], 0.7);

/// Writes a record of a true ARMAX system with white inputs, to compare estimates with the true parameters.
fn write_armax(folder: &Path) -> Result<(), Box<dyn Error>> {
    let ([a1, a2, b1, b2, c1, c2], d1) = ARMAX;
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut draw = || -> f64 { rng.sample(StandardNormal) };
    let mut text = String::from("current_a,velocity_error_rad_s,load_torque_nm,velocity_ref_rad_s\n");
    let (mut y, mut u, mut w, mut e) = ([0.0; 2], [0.0; 2], [0.0; 2], 0.0);
    for _ in 0..5000 {
        let new = 0.5 * draw();
        let output = b1 * u[0] + b2 * u[1] + c1 * w[0] + c2 * w[1] - a1 * y[0] - a2 * y[1] + new + d1 * e;
        let (next_u, next_w) = (draw(), draw());
        text += &format!("{output},{next_u},{next_w},0\n");
        (y, u, w, e) = ([output, y[0]], [next_u, u[0]], [next_w, w[0]], new);
    }
    Ok(std::fs::write(folder.join("armax.csv"), text)?)
}

fn time(folder: &Path) -> Result<Value, Box<dyn Error>> {
    let load = |name: &str, u1: &str| -> Result<Vec<Trace>, model::Error> {
        let channels = Channels::new("current_a", u1, "load_torque_nm");
        read(&[folder.join(name)], &channels)
    };
    let (train, validate) = (load("train.csv", "velocity_error_rad_s")?, load("validate.csv", "velocity_error_rad_s")?);
    let structures = Grid::up_to(Structure::new(4, 4, 4, 4, 4), false).structures()?;
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut result = json!({ "samples": train[0].y.len(), "threads": rayon::current_num_threads() });
    for (name, estimator, runs) in [("ls", Estimator::Ls, 15), ("iv4", Estimator::Iv4, 5)] {
        let estimation = || estimate_all(&train, &structures, estimator);
        let scored = || search(&train, &validate, &structures, estimator);
        let found = scored()?;
        let fits: Vec<Value> = found
            .candidates
            .iter()
            .map(|c| json!([c.fitted.structure.orders(), c.fit_percent, c.fitted.theta]))
            .collect();
        result[name] = json!({
            "estimate_s": median(runs, estimation),
            "score_s": median(runs, scored),
            "estimate_one_thread_s": one_thread.install(|| median(runs, estimation)),
            "score_one_thread_s": one_thread.install(|| median(runs, scored)),
            "structures": fits,
        });
    }
    let single = std::slice::from_ref(&SINGLE);
    let lone = estimate_all(&train, single, Estimator::Ls)?.remove(0)?;
    result["one_ls"] = json!({
        "lone_s": median(101, || estimate_all(&train, single, Estimator::Ls)),
        "theta": lone.theta,
        "whole": whole(2001, || identify::least_squares(&train[0], SINGLE))?,
    });
    result["one_iv4"] = json!({
        "lone_s": median(51, || estimate_all(&train, single, Estimator::Iv4)),
        "whole": whole(501, || identify::iv4(&train[0], SINGLE))?,
    });
    let armax = load("armax.csv", "velocity_error_rad_s")?.remove(0);
    let estimated = identify::armax(&armax, SINGLE, Some(1))?;
    result["armax"] = json!({
        "s": median(21, || identify::armax(&armax, SINGLE, Some(1))),
        "theta": estimated.theta.as_slice(),
        "truth": ARMAX.0,
        "sd": estimated.deviations(),
    });
    for (name, u1) in [("error", "velocity_error_rad_s"), ("reference", "velocity_ref_rad_s")] {
        let train = load("train.csv", u1)?;
        let one = |estimator| estimate_all(&train, std::slice::from_ref(&ONE_INPUT), estimator);
        for (method, estimator) in [("ls", Estimator::Ls), ("iv4", Estimator::Iv4)] {
            let theta = one(estimator)?.remove(0)?.theta;
            result["one_input"][name][method] = json!({ "s": median(201, || one(estimator)), "theta": theta });
        }
    }
    Ok(result)
}

/// Shortest time and results of an estimate with residuals, covariance and fits.
fn whole(runs: usize, call: impl Fn() -> Result<Estimate, model::Error>) -> Result<Value, model::Error> {
    let found = call()?;
    Ok(json!({
        "s": times(runs, &call)[0],
        "theta": found.theta.as_slice(),
        "covariance": found.covariance.as_slice(),
        "variance": found.variance,
        "residual_sum": found.residuals.iter().map(|e| e * e).sum::<f64>(),
        "fits": [found.fit_percent, found.prediction_fit_percent],
    }))
}

/// Median time of a call, s.
fn median<T>(runs: usize, call: impl Fn() -> T) -> f64 {
    times(runs, call)[runs / 2]
}

/// Times of calls, s, in ascending order.
fn times<T>(runs: usize, call: impl Fn() -> T) -> Vec<f64> {
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let start = Instant::now();
            black_box(call());
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times
}
