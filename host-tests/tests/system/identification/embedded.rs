//! The core's single-precision estimates against double-precision batch least squares on the same data.

use host_tests::data;
use model::core::features;
use model::identify::{Structure, least_squares};
use model::trace::labels::LabelledTrace;
use model::trace::{Channels, Trace};
use model::train::{Estimation, Recipe, train};
use nalgebra::{DMatrix, DVector};
use rig::Scenario;
use studies::demo::{self, FirstInput};
use traces::read;

/// Numerical error in units of the estimate's own statistical deviation: sqrt(Δᵀ cov⁻¹ Δ / n), in the δ-form, whose
/// covariance is well conditioned.
fn rho(trace: &Trace, structure: Structure, core: &[f32]) -> f64 {
    let batch = least_squares(trace, structure).expect("well posed");
    let n = structure.parameters();
    let map = features::raw_from_delta(structure).view((0, 0), (n, n)).into_owned();
    let inverse = map.try_inverse().expect("invertible map");
    let covariance: DMatrix<f64> = &inverse * batch.covariance * inverse.transpose();
    let raw = DVector::from_iterator(n + 1, batch.theta.iter().copied().chain([0.0]));
    let delta = features::delta_from_raw(structure, &raw);
    let error = DVector::from_iterator(n, core.iter().enumerate().map(|(k, x)| f64::from(*x) - delta[k]));
    let whitened = covariance.cholesky().expect("positive definite").solve(&error);
    (error.dot(&whitened) / n as f64).sqrt()
}

/// Largest ρ over traces, each run through the detector.
fn worst_rho(traces: &[LabelledTrace], classes: &[String], structure: Structure) -> f64 {
    // The classifier does not matter here, so the smallest one serves.
    let recipe = Recipe { features: vec!["a1".into()], ..Recipe::new(structure) };
    // Whole traces, however long they are.
    let segment = traces.iter().map(|t| t.trace.y.len()).max();
    let recipe = Recipe { estimation: Estimation { segment, ..recipe.estimation.clone() }, ..recipe };
    let model = train(traces, classes, &recipe).expect("trains").embed().expect("embeds");
    traces.iter().fold(0.0, |worst, labelled| {
        let segments = model.run(&labelled.trace);
        assert_eq!((segments.len(), segments[0].counts.rejected), (1, 0));
        worst.max(rho(&labelled.trace, structure, &segments[0].delta))
    })
}

/// Above the limit the arithmetic has degraded; far below single precision's own rounding something is compared with
/// itself.
fn check(what: &str, rho: f64) {
    println!("{what}: rho {rho:.1e}");
    assert!(rho <= 0.02, "{what}: {rho}");
    assert!(rho > 1e-9, "{what}: {rho}");
}

#[test]
fn open_reference_set() {
    let Some(folder) = data("dc_motor_reference") else { return };
    let labels = traces::read_labels(&folder.join("labels.csv")).expect("labels");
    let chosen = labels.select(&[]).expect("rows");
    let classes = labels.classes(&chosen, &[]).expect("classes");
    for (u1, order) in [
        ("velocity_ref_rad_s", Structure::new(2, 1, 2, 1, 1)),
        ("velocity_ref_rad_s", Structure::new(3, 1, 2, 1, 1)),
        ("velocity_ref_rad_s-velocity_rad_s", Structure::new(2, 2, 2, 1, 1)),
        ("velocity_ref_rad_s-velocity_rad_s", Structure::new(3, 3, 3, 1, 1)),
    ] {
        let channels = Channels::new("current_a", u1, "load_torque_nm");
        let traces = read(std::slice::from_ref(&folder), &channels).expect("traces");
        let traces = labels.join(&chosen, &classes, &traces).expect("labelled traces");
        assert_eq!(traces.len(), 12);
        let rho = worst_rho(&traces, &classes, order);
        check(&format!("{u1} {:?}", order.orders()), rho);
    }
}

#[test]
fn simulated_traces_with_delays_and_offset() {
    let traces = |input| demo::traces(&Scenario::STANDARD, input, (900, 4), || ()).expect("simulates");
    for (input, order, offset) in [
        (FirstInput::Reference, Structure::new(2, 1, 2, 1, 1), true),
        (FirstInput::Error, Structure::new(4, 4, 4, 1, 1), false),
        (FirstInput::Error, Structure::new(2, 2, 1, 3, 0), true),
        (FirstInput::Error, Structure::new(1, 0, 3, 1, 2), false),
    ] {
        let rho = worst_rho(&traces(input), &demo::class_names(), Structure { offset, ..order });
        check(&format!("{:?} offset {offset}", order.orders()), rho);
    }
}

/// `count` samples of a second-order model under random inputs, with white noise in the equation, seen from an
/// operating point `level` away.
fn synthetic(seed: u64, count: usize, noise: f64, level: f64) -> Trace {
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut gauss = || -> f64 { rng.sample(StandardNormal) };
    let (mut y, mut u1, mut u2) = (vec![0.0, 0.0], vec![0.0, 0.0], vec![0.0, 0.0]);
    for t in 2..count {
        y.push(1.2 * y[t - 1] - 0.4 * y[t - 2] + 0.5 * u1[t - 1] - 0.25 * u2[t - 1] + noise * gauss());
        u1.push(0.8 * u1[t - 1] + 0.6 * gauss());
        u2.push(gauss());
    }
    let lift = |x: Vec<f64>| x.into_iter().map(|x| x + level).collect();
    Trace { id: format!("s{seed}"), y: lift(y), u1: lift(u1), u2: lift(u2), ..Trace::default() }
}

#[test]
fn long_segments_small_residuals_and_far_operating_points() {
    // The target's rms is about 0.6, so noise of 0.02 and 0.002 is 3 % and 0.3 % of it: the documented limits. Near a
    // level of 1000 the samples themselves are rounded by 2e-5, a thousandth of the noise; levels taken as they are,
    // without an origin, gave 1.5 and 4.1 here.
    for (count, noise, level, limit) in [
        (100_000, 0.02, 0.0, 0.05),
        (5_000, 0.002, 0.0, 0.05),
        (5_000, 0.02, 1000.0, 0.05),
        (100_000, 0.1, 1000.0, 0.05),
    ] {
        let traces: Vec<LabelledTrace> = (0..4)
            .map(|k| LabelledTrace { trace: synthetic(500 + k, count, noise, level), class: usize::from(k > 1) })
            .collect();
        let classes = ["one".to_string(), "other".to_string()];
        let structure = Structure { offset: level != 0.0, ..Structure::new(2, 1, 1, 1, 1) };
        let rho = worst_rho(&traces, &classes, structure);
        println!("{count} rows, noise {noise}, level {level}: rho {rho:.1e}");
        assert!(rho <= limit && rho > 1e-6, "{rho}");
    }
}

#[test]
fn what_is_not_excited_is_said_by_both_halves() {
    let trace = |id: &str, [y, u1, u2]: [Vec<f64>; 3]| Trace {
        id: id.into(),
        interval_s: None,
        irregular_steps: 0,
        y,
        u1,
        u2,
        motion: None,
        ..Trace::default()
    };
    let swinging = (0..5000).map(|k| f64::from(k).sin()).collect();
    let steady = trace("steady", [swinging, vec![2.0; 5000], vec![0.5; 5000]]);
    let moving = (0..5000).map(|k| 30.0 * f64::from(k).cos()).collect();
    let unloaded = trace("unloaded", [steady.y.clone(), moving, vec![0.0; 5000]]);
    let structure = Structure::new(1, 1, 1, 1, 1);
    let error = least_squares(&steady, structure).expect_err("constant inputs").to_string();
    assert!(error.contains("steady") && error.contains("do not excite parameter c1"), "{error}");
    let training = demo::traces(&Scenario::STANDARD, FirstInput::Error, (901, 4), || ()).expect("simulates");
    let model =
        train(&training, &demo::class_names(), &Recipe::new(structure)).expect("trains").embed().expect("embeds");
    let verdict = |trace: &Trace| model.run(trace)[0].verdict.clone().expect_err("no class");
    assert!(verdict(&unloaded).starts_with("the signals do not excite parameter c1"), "{}", verdict(&unloaded));
    assert_eq!(verdict(&steady), "the shaft or the inputs are at rest");
    let empty = trace("empty", [vec![], vec![], vec![]]);
    assert_eq!(verdict(&empty), "0 samples are no more than half a segment of 5000");
}
