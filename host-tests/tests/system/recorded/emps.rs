//! Grey boxes and difference models on a recorded drive: a positioning system with published constants (EMPS). Its
//! screw is worn: the tests show how far friction differs between the two directions, over two records and their
//! quarters. The authors explain the difference by fatigue of the screw.
//!
//! Standard deviations allow for correlated residuals (Newey and West); the scatter over the quarters is an independent
//! measure of the same.

use std::path::Path;

use host_tests::{columns, data, documents};
use model::grey_box::linear::{
    Asymmetry, Friction, LinearRecord, LinearSettings, asymmetries, cross_validate, estimate,
};
use model::identify::{Structure, fit_percent, least_squares, simulate};
use model::trace::{Preparation, Trace};

const INTERVAL_S: f64 = 1e-3;

/// Newtons a volt of the controller's output.
const FORCE_GAIN: f64 = 35.150_651_882_485_47;

/// Parts of a record.
const PARTS: usize = 4;

/// Position and force of one EMPS file.
fn emps(folder: &Path, file: &str) -> (Vec<f64>, Vec<f64>) {
    let recorded = columns(&folder.join(file), 2);
    let force = recorded[1].iter().map(|v| FORCE_GAIN * v).collect();
    (recorded[0].clone(), force)
}

/// Estimates on the training file: named values, relative error, relative error of the pulses.
fn published(friction: Friction, wanted: &[(&str, f64, f64)]) -> Option<(f64, f64)> {
    let folder = data("emps")?;
    let settings = LinearSettings { friction, ..LinearSettings::default() };
    let (train, pulses) = (emps(&folder, "emps_train.csv"), emps(&folder, "emps_test_pulses.csv"));
    let train = LinearRecord { id: "train", interval_s: INTERVAL_S, position_m: &train.0, force_n: &train.1 };
    let pulses = LinearRecord { id: "pulses", position_m: &pulses.0, force_n: &pulses.1, ..train };
    let found = estimate(&train, &settings).expect("rich motion");
    let cross = cross_validate(&pulses, &settings, &found).expect("rich motion");
    for &(name, value, tolerance) in wanted {
        let quantity = found.get(name).expect("named");
        let off = quantity.value / value - 1.0;
        println!("{name} {:.4} ± {:.4} (published {value}, {:+.3} %)", quantity.value, quantity.sd, 100.0 * off);
        assert!(off.abs() <= tolerance, "{name} {quantity:?}");
        assert!(quantity.sd > 0.0 && quantity.relative_sd() < 0.2, "{quantity:?}");
    }
    println!("relative error {:.4} %, pulses {cross:.4} %", found.relative_error_percent);
    Some((found.relative_error_percent, cross))
}

#[test]
fn emps_constants_are_the_published_ones() {
    let wanted = [("M", 95.1089, 0.005), ("Fv", 203.5034, 0.005), ("Fc", 20.3935, 0.005), ("offset", -3.1648, 0.01)];
    let Some((own, cross)) = published(Friction::Symmetric, &wanted) else { return };
    // Published 4.0834 and 5.9824 %; far below would mean that noise is fitted or rows are lost.
    assert!((3.9..=4.1).contains(&own), "{own}");
    assert!((5.7..=6.0).contains(&cross), "{cross}");
}

#[test]
fn emps_one_sided_friction_shows_the_worn_screw() {
    let wanted = [
        ("M", 95.1540, 0.005),
        ("Fv+", 166.7061, 0.005),
        ("Fc+", 20.1440, 0.005),
        ("Fv-", 240.4236, 0.005),
        ("Fc-", 20.6277, 0.005),
    ];
    let Some((own, _)) = published(Friction::OneSided, &wanted) else { return };
    assert!((2.9..=3.1117).contains(&own), "{own}"); // published 3.1117 %
}

/// Velocity (central differences) and force in block means of 5 ms, with the direction of motion as second input.
fn first_order(folder: &Path, file: &str) -> Trace {
    let (position, force) = emps(folder, file);
    let last = position.len() - 1;
    let at = |t: usize| (position[(t + 1).min(last)] - position[t.saturating_sub(1)]) / (2.0 * INTERVAL_S);
    let velocity: Vec<f64> = (0..=last).map(at).collect();
    let direction = velocity.iter().map(|v| if *v == 0.0 { 0.0 } else { v.signum() }).collect();
    let trace = Trace {
        id: file.into(),
        interval_s: Some(INTERVAL_S),
        irregular_steps: 0,
        y: velocity,
        u1: force,
        u2: direction,
        motion: None,
        ..Trace::default()
    };
    Preparation { block_mean: 5, decimate: 1 }.apply(&trace).expect("long enough")
}

#[test]
fn emps_first_order_model_runs_free() {
    let Some(folder) = data("emps") else { return };
    let structure = Structure::new(1, 1, 1, 1, 1).with_offset();
    let train = first_order(&folder, "emps_train.csv");
    let pulses = first_order(&folder, "emps_test_pulses.csv");
    let found = least_squares(&train, structure).expect("excited");
    let theta = found.theta.as_slice();
    let carried_over = fit_percent(&pulses.y, &simulate(&pulses, structure, theta));
    // Sampling M dv/dt = F − Fv v with F held: b = T/M (1 − p)/(−ln p), p the pole.
    let pole = -theta[0];
    let mass = 5.0 * INTERVAL_S / theta[1] * (1.0 - pole) / -pole.ln();
    println!("fit {:.2} % train, {carried_over:.2} % pulses, implied M {mass:.2} kg", found.fit_percent);
    // An independent prototype: 94.3 and 93.4 %, 95.55 kg; the published mass is 95.11 kg.
    assert!((94.0..95.0).contains(&found.fit_percent));
    assert!((93.0..94.0).contains(&carried_over));
    assert!((mass / 95.55 - 1.0).abs() < 1e-3, "{mass}"); // how velocity is differenced moves it by 0.15 kg
}

/// Viscous and Coulomb difference of a part of a record.
fn differences(position_m: &[f64], force_n: &[f64]) -> [Asymmetry; 2] {
    let record = LinearRecord { id: "emps", interval_s: INTERVAL_S, position_m, force_n };
    let settings = LinearSettings { friction: Friction::OneSided, ..LinearSettings::default() };
    asymmetries(&estimate(&record, &settings).expect("rich motion")).try_into().expect("two")
}

fn shown(d: &Asymmetry) -> String {
    format!("{0}⁻ − {0}⁺ {1:.2} ± {2:.2} {3} (z {4:.1})", d.name, d.value, d.sd, d.unit, d.z())
}

/// The whole record, then its parts.
fn record(folder: &Path, file: &str) -> ([Asymmetry; 2], Vec<[Asymmetry; 2]>) {
    let (position, force) = emps(folder, file);
    let whole = differences(&position, &force);
    println!("{file}, whole: {}, {}", shown(&whole[0]), shown(&whole[1]));
    let samples = force.len() / PARTS;
    let part = |k: usize| {
        let range = k * samples..(k + 1) * samples;
        let quarter = differences(&position[range.clone()], &force[range]);
        println!("{file}, quarter {}: {}, {}", k + 1, shown(&quarter[0]), shown(&quarter[1]));
        quarter
    };
    (whole, (0..PARTS).map(part).collect())
}

#[test]
fn friction_differs_between_the_directions_of_a_worn_screw() {
    let Some(folder) = data("emps") else { return };
    let head = ["record", "Fv⁻ − Fv⁺, N·s/m", "z", "its quarters", "Fc⁻ − Fc⁺, N", "z"];
    let mut rows = vec![head.map(String::from).to_vec()];
    for file in ["emps_train.csv", "emps_test_pulses.csv"] {
        let (whole, parts) = record(&folder, file);
        let name = if file.contains("pulses") { "test, with pulses" } else { "train" };
        let quarters: Vec<String> = parts.iter().map(|part| format!("{:.1}", part[0].value)).collect();
        let [viscous, coulomb] =
            whole.each_ref().map(|d| [format!("{:.2} ± {:.2}", d.value, d.sd), format!("{:.1}", d.z())]);
        rows.push([vec![name.to_owned()], viscous.to_vec(), vec![quarters.join(", ")], coulomb.to_vec()].concat());
        let [viscous, coulomb] = whole;
        // Published 240.4236 − 166.7061 on the first record; the second, which the publication does not regress, within
        // two standard deviations of it.
        assert!((viscous.value - 73.7175).abs() < 2.0 * viscous.sd, "{viscous:?}");
        // Deviations for uncorrelated residuals would promise far more than 30.
        assert!((20.0..30.0).contains(&viscous.z()), "{viscous:?}");
        // Published 20.6277 − 20.1440 N: not told from none.
        assert!((coulomb.value - 0.4837).abs() < 0.2 && coulomb.z().abs() < 3.0, "{coulomb:?}");
        // A quarter has twice the deviation, so half the z.
        assert!(parts.iter().all(|p| (10.0..15.0).contains(&p[0].z())), "{parts:?}");
        for k in 0..2 {
            let mean = parts.iter().map(|p| p[k].value).sum::<f64>() / PARTS as f64;
            let squares = parts.iter().map(|p| (p[k].value - mean).powi(2)).sum::<f64>();
            let scatter = (squares / (PARTS * (PARTS - 1)) as f64).sqrt();
            println!(
                "{file}, {}: mean of quarters {mean:.2} ± {scatter:.2} by their scatter (z {:.1}), whole ± {:.2}",
                whole[k].name,
                mean / scatter,
                whole[k].sd
            );
            // What returns in every quarter is no scatter, so this is the smaller of the two; more than a half above
            // would mean that the deviations promise too much.
            assert!(scatter > 0.0 && scatter < 1.5 * whole[k].sd, "{scatter} {:?}", whole[k]);
        }
    }
    documents::check("docs/recorded.md", "recorded-wear", rows);
}
