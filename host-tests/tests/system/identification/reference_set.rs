//! Batch identification against the open reference set: estimates of an independent program on simulated traces.

use std::path::Path;

use host_tests::{data, table};
use model::identify::{Method, Structure, estimate};
use model::trace::{Channels, Trace, stem};
use traces::read;

fn traces(folder: &Path, input: &str) -> Vec<Trace> {
    let u1 = if input == "err" { "velocity_ref_rad_s-velocity_rad_s" } else { "velocity_ref_rad_s" };
    let channels = Channels::new("current_a", u1, "load_torque_nm");
    read(&[folder.to_path_buf()], &channels).expect("readable traces")
}

/// Largest deviation of parameters, relative to the reference, and of the fit in percent points.
fn deviation(method: Method, input: &str, order: Structure) -> Option<(f64, f64)> {
    let folder = data("dc_motor_reference")?;
    let name = format!("{method:?}").to_lowercase();
    let digits: String = order.orders().iter().map(ToString::to_string).collect();
    let (_, reference) = table(&folder.join(format!("{name}_{input}_{digits}.csv")));
    let traces = traces(&folder, input);
    assert_eq!((traces.len(), reference.len()), (12, 12));
    let structure = order;
    let (mut worst, mut well_posed) = ((0.0_f64, 0.0_f64), 0);
    for (id, row) in reference {
        let trace = traces.iter().find(|t| stem(&t.id) == stem(&id)).expect("trace of the reference");
        let got = estimate(trace, structure, method).expect("well posed");
        assert!(got.convergence.converged, "{id}: {:?}", got.convergence);
        let (fit, theta) = row.split_last().expect("a fit in the last column");
        // A converged refined IV rests where the output error is stationary; references of visibly worse fit do not.
        if method == Method::Sriv && *fit < got.fit_percent - 5e-5 {
            println!(
                "sriv {input} {digits} {id}: the reference has not converged, {fit} % against {}",
                got.fit_percent
            );
            continue;
        }
        well_posed += 1;
        for (got, want) in got.theta.iter().zip(theta) {
            worst.0 = worst.0.max((got - want).abs() / want.abs());
        }
        worst.1 = worst.1.max((got.fit_percent - fit).abs());
    }
    // Four references of refined IV stopped short.
    assert!(well_posed == 12 || (method == Method::Sriv && well_posed == 8), "{well_posed}");
    println!(
        "{name} {input} {digits}, {well_posed} traces: parameters {:.1e} relative, fit {:.1e} points",
        worst.0, worst.1
    );
    Some(worst)
}

const CASES: [(&str, Structure); 4] = [
    ("ref", Structure::new(2, 1, 2, 1, 1)),
    ("ref", Structure::new(3, 1, 2, 1, 1)),
    ("err", Structure::new(2, 2, 2, 1, 1)),
    ("err", Structure::new(3, 3, 3, 1, 1)),
];

#[test]
fn least_squares_matches_the_reference() {
    for (input, order) in CASES {
        let Some((theta, fit)) = deviation(Method::Ls, input, order) else { return };
        // The references carry 12 digits; exact agreement of more than that would be a comparison with ourselves.
        assert!(theta <= 1e-6 && theta > 0.0, "{theta}");
        assert!(fit <= 1e-6, "{fit}");
    }
}

#[test]
fn iv4_matches_the_reference() {
    for (input, order) in CASES {
        let Some((theta, fit)) = deviation(Method::Iv4, input, order) else { return };
        assert!(theta <= 1e-5 && theta > 0.0, "{theta}");
        assert!(fit <= 1e-4, "{fit}");
    }
}

#[test]
fn refined_iv_and_steiglitz_mcbride_match_the_reference() {
    for method in [Method::Sriv, Method::Sm] {
        let Some((theta, fit)) = deviation(method, "err", Structure::new(2, 2, 2, 1, 1)) else { return };
        // Iterations end somewhere near the fixed point; the references stop by rules of their own.
        assert!(theta <= 1e-3 && theta > 0.0, "{theta}");
        assert!(fit <= 1e-4, "{fit}");
    }
}
