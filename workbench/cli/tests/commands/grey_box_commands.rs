//! Command-line tests of `grey-box`.

use std::path::Path;
use std::process::Command;

fn run(folder: &Path, arguments: &str) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    let output = command.current_dir(folder).args(arguments.split_whitespace()).output().expect("the command starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

fn json(folder: &Path, arguments: &str) -> serde_json::Value {
    let (code, out, err) = run(folder, arguments);
    assert_eq!(code, 0, "{arguments}\n{err}");
    serde_json::from_str(&out).expect("JSON")
}

/// Value and standard deviation of a quantity with this name at any depth of the JSON output.
fn quantity(value: &serde_json::Value, name: &str) -> (f64, f64) {
    let number = |v: &serde_json::Value, key: &str| v[key].as_f64();
    match value {
        serde_json::Value::Array(items) => items.iter().map(|item| quantity(item, name)).find(|q| q.0.is_finite()),
        serde_json::Value::Object(map) => {
            if value["name"] == name {
                return (number(value, "value").expect("value"), number(value, "sd").expect("sd"));
            }
            match map.get(name) {
                Some(inner) if inner["value"].is_number() => {
                    Some((number(inner, "value").expect("value"), number(inner, "sd").expect("sd")))
                }
                _ => map.values().map(|inner| quantity(inner, name)).find(|q| q.0.is_finite()),
            }
        }
        _ => None,
    }
    .unwrap_or((f64::NAN, f64::NAN))
}

/// The error is below four reported standard deviations, and the standard deviation is below `part` of the true value.
fn near(found: (f64, f64), truth: f64, part: f64) {
    assert!((found.0 - truth).abs() < 4.0 * found.1 && found.1 < part * truth.abs(), "{found:?} {truth}");
}

#[test]
fn motor_constants_of_the_rig() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    assert_eq!(run(dir, "simulate --class healthy --count 1 --seed 11 --out t").0, 0);
    let found = json(dir, "grey-box motor t/healthy_11_000.csv --json");
    near(quantity(&found, "J"), 2.5e-4, 0.1);
    near(quantity(&found, "B"), 1e-4, 0.3);
    near(quantity(&found, "Kt"), 0.05, 0.01);
}

/// Writes current and velocity of the forward-Euler motor of thesis Eq. 2.41 under a random voltage and load.
fn electrical(dir: &Path) {
    let (r, l, k, j, b, t) = (0.5, 4.5e-3, 0.05, 2.5e-4, 1e-4, 1e-3);
    let mut state = 1_u32;
    let mut draw = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / 16_777_216.0 - 0.5
    };
    let mut rows = String::from("t_s,current_a,voltage_v,velocity_rad_s,load_torque_nm\n");
    let (mut i, mut w) = (0.0, 0.0);
    for n in 0..4000 {
        let (v, load) = (20.0 * draw(), 0.2 * draw());
        rows += &format!("{},{},{v},{w},{load}\n", f64::from(n) * t, i + 1e-3 * draw());
        (i, w) = (i + t / l * (v - r * i - k * w), w + t / j * (k * i - b * w - load));
    }
    std::fs::write(dir.join("e.csv"), rows).expect("writable");
}

#[test]
fn electrical_constants_of_an_euler_motor() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    electrical(dir);
    let found = json(dir, "grey-box electrical e.csv --json");
    for (name, truth) in [("R", 0.5), ("L", 4.5e-3)] {
        let value = quantity(&found, name).0;
        // Least squares on a current with little noise: error below one percent.
        assert!((value / truth - 1.0).abs() < 0.01, "{name} {value}\n{found}");
    }
    assert!(found.to_string().contains("Ke = Kt"), "the assumption is said: {found}");
}

#[test]
fn bad_input_is_one_line() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    std::fs::write(dir.join("x.csv"), "t_s,position,force\n0,1,2\n0.001,1,2\n0.002,1,2\n").expect("writable");
    std::fs::write(dir.join("other.csv"), "position,force\n2,1\n3,5\n4,4\n").expect("writable");
    for (arguments, words) in [
        ("grey-box linear x.csv --position position --force force", "x.csv"),
        ("grey-box linear x.csv --position place --force force", "place"),
        ("grey-box motor x.csv", "current_a"),
        ("structure x.csv other.csv --y position --u1 force --u2 force --max 2,2,2,1,1", "x.csv"),
        ("validate x.csv --y position --u1 force --u2 force --order 1,1,1,1,1", "x.csv"),
    ] {
        let (code, out, err) = run(dir, arguments);
        assert!(code == 2 && out.is_empty() && err.trim_end().lines().count() == 1, "{arguments}\n{code} {out}{err}");
        assert!(err.contains(words), "{arguments}\n{err}");
    }
}

#[test]
fn a_drive_that_runs_harder_backward_says_so() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let row = |k: u32| {
        let (t, w) = (f64::from(k) * 1e-3, std::f64::consts::TAU * 0.5);
        let (x, v, a) = (0.1 * (w * t).sin(), 0.1 * w * (w * t).cos(), -0.1 * w * w * (w * t).sin());
        let viscous = if v < 0.0 { 240.0 } else { 170.0 };
        format!("{t},{x},{}\n", 95.0 * a + viscous * v + 20.0 * v.signum())
    };
    let table: String = std::iter::once("t_s,x_m,force_n\n".to_string()).chain((0..20_000).map(row)).collect();
    std::fs::write(dir.join("x.csv"), table).expect("writable");
    let found = json(dir, "grey-box linear x.csv --position x_m --force force_n --asymmetric --json");
    let viscous = &found[0]["asymmetry"]["Fv"];
    // 240 − 170; rows across a reversal contain both directions.
    assert!((viscous["value"].as_f64().expect("value") - 70.0).abs() < 5.0, "{found}");
    assert!(viscous["z"].as_f64().expect("z") > 10.0, "{found}");
    let (_, text, _) = run(dir, "grey-box linear x.csv --position x_m --force force_n --asymmetric");
    assert!(text.contains("Fv- − Fv+") && text.contains("standard deviations from even"), "{text}");
    let even = json(dir, "grey-box linear x.csv --position x_m --force force_n --json");
    assert_eq!(even[0]["asymmetry"], serde_json::json!({}));
}
