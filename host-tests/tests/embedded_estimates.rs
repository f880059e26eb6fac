//! The core's single-precision estimates against double-precision batch least squares on the same data.

use bearing_watch::Reason;
use host_tests::data;
use nalgebra::{DMatrix, DVector};
use workbench::demo::{self, FirstInput};
use workbench::features;
use workbench::identify::{Order, Structure, least_squares};
use workbench::rig::Scenario;
use workbench::trace::labels::LabelledTrace;
use workbench::trace::{Channels, Labels, Trace, read};
use workbench::train::{Recipe, train};

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
    let model = train(traces, classes, &recipe).expect("trains").embed().expect("embeds");
    traces.iter().fold(0.0, |worst, labelled| {
        let segments = model.run(&labelled.trace).expect("runs");
        assert_eq!((segments.len(), segments[0].rejected), (1, 0));
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
    let labels = Labels::read(&folder.join("labels.csv")).expect("labels");
    let chosen = labels.select(&[]).expect("rows");
    let classes = labels.classes(&chosen, &[]).expect("classes");
    for (u1, order) in [
        ("velocity_ref_rad_s", Order::new(2, 1, 2, 1, 1)),
        ("velocity_ref_rad_s", Order::new(3, 1, 2, 1, 1)),
        ("velocity_ref_rad_s-velocity_rad_s", Order::new(2, 2, 2, 1, 1)),
        ("velocity_ref_rad_s-velocity_rad_s", Order::new(3, 3, 3, 1, 1)),
    ] {
        let channels = Channels { y: "current_a".into(), u1: u1.into(), u2: "load_torque_nm".into() };
        let traces = read(std::slice::from_ref(&folder), &channels).expect("traces");
        let traces = labels.join(&chosen, &classes, &traces).expect("labelled traces");
        assert_eq!(traces.len(), 12);
        let rho = worst_rho(&traces, &classes, Structure { order, offset: false });
        check(&format!("{u1} {:?}", order.to_array()), rho);
    }
}

#[test]
fn simulated_traces_with_delays_and_offset() {
    let traces = |input| demo::traces(&Scenario::STANDARD, input, (900, 4), || ()).expect("simulates");
    for (input, order, offset) in [
        (FirstInput::Reference, Order::new(2, 1, 2, 1, 1), true),
        (FirstInput::Error, Order::new(4, 4, 4, 1, 1), false),
        (FirstInput::Error, Order::new(2, 2, 1, 3, 0), true),
        (FirstInput::Error, Order::new(1, 0, 3, 1, 2), false),
    ] {
        let rho = worst_rho(&traces(input), &demo::class_names(), Structure { order, offset });
        check(&format!("{:?} offset {offset}", order.to_array()), rho);
    }
}

#[test]
fn what_is_not_excited_is_said_by_both_halves() {
    let flat = Trace { id: "flat".into(), interval_s: None, y: vec![1.0; 500], u1: vec![2.0; 500], u2: vec![0.5; 500] };
    let structure = Structure { order: Order::new(1, 1, 1, 1, 1), offset: false };
    let error = least_squares(&flat, structure).expect_err("constant signals").to_string();
    assert!(error.contains("flat") && error.contains("do not excite"), "{error}");
    let training = demo::traces(&Scenario::STANDARD, FirstInput::Error, (901, 4), || ()).expect("simulates");
    let model =
        train(&training, &demo::class_names(), &Recipe::new(structure)).expect("trains").embed().expect("embeds");
    let segments = model.run(&flat).expect("runs");
    let expected = Reason::NotExcited(1).to_string();
    assert_eq!(segments[0].verdict, Err(expected));
    let empty = Trace { id: "empty".into(), interval_s: None, y: vec![], u1: vec![], u2: vec![] };
    assert_eq!(model.run(&empty).expect("runs")[0].verdict, Err(Reason::TooFewRows.to_string()));
}
