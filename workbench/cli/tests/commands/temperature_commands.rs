//! Temperatures that training finds by itself, and what it saves of its choice.

use std::path::Path;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use serde_json::Value;

use super::common::{run, succeed};

const TRAIN: &str = "train --current current_a --velocity velocity_rad_s --velocity-ref velocity_ref_rad_s \
    --angle angle_rad --bearing 9,3,17,10";

/// Samples of a record, at 500 Hz.
const SAMPLES: usize = 3000;

/// The cells of further columns of a record, by its number and the temperature that the friction follows.
type Further<'a> = &'a dyn Fn(usize, f64) -> Vec<(&'static str, Option<f64>)>;

/// Writes healthy records of a drive without load. With `depends`, the viscous friction halves every 35 K: by a factor
/// of four over them; beside that it scatters by 5 %.
fn write(folder: &Path, count: usize, seed: u64, depends: bool, further: Further<'_>) {
    std::fs::create_dir_all(folder).expect("a folder");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Of its own, so that the other columns do not depend on which further ones there are.
    let mut sensors = ChaCha8Rng::seed_from_u64(seed + 1000);
    let mut labels = String::from("trace,class_name\n");
    for k in 0..count {
        let temperature = rng.random_range(20.0..90.0);
        let (frequency, size) = (rng.random_range(1.3..2.5), rng.random_range(30.0..50.0));
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let warm = if depends { temperature - 55.0 } else { 0.0 };
        let viscous = 0.01 * f64::exp(-0.02 * warm) * (1.0 + 0.05 * draw());
        let columns = further(k, temperature);
        let names: String = columns.iter().map(|(name, _)| format!(",{name}")).collect();
        let mut text = format!("t_s,current_a,velocity_rad_s,velocity_ref_rad_s,angle_rad{names}\n");
        for sample in 0..SAMPLES {
            let t = 0.002 * sample as f64;
            let (sine, cosine) = (frequency * t).sin_cos();
            let (w, angle) = (size * sine, size / frequency * (1.0 - cosine));
            let friction = viscous * w + 0.1 * (2.0 * w).tanh();
            let current = 0.02 * size * frequency * cosine + friction + 0.02 * draw();
            text += &format!("{t:.3},{current:.6},{:.5},{w:.5},{angle:.6}", w + 0.05 * draw());
            for (_, cell) in &columns {
                // A sensor of a tenth of a kelvin.
                let noise: f64 = StandardNormal.sample(&mut sensors);
                text += &cell.map_or_else(|| ",".into(), |value| format!(",{:.3}", value + 0.1 * noise));
            }
            text.push('\n');
        }
        std::fs::write(folder.join(format!("h{k:03}.csv")), text).expect("writable");
        labels += &format!("h{k:03},healthy\n");
    }
    std::fs::write(folder.join("labels.csv"), labels).expect("writable");
}

fn json(dir: &Path, arguments: &str) -> Value {
    serde_json::from_str(&succeed(dir, arguments)).expect("JSON")
}

/// The temperature of this column among what training says of its choice.
fn temperature<'a>(report: &'a Value, column: &str) -> &'a Value {
    let all = report["automatic"]["temperatures"].as_array().expect("temperatures");
    all.iter().find(|own| own["column"] == column).unwrap_or_else(|| panic!("{column} in {all:?}"))
}

#[test]
fn a_temperature_that_friction_follows_is_found_and_saved() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    // A column that follows the temperature as well, but is not called one, is never taken.
    let columns: Further<'_> = &|_, t| vec![("t_winding_degc", Some(t)), ("x_cover", Some(t - 3.0))];
    write(&dir.join("train"), 60, 1, true, columns);
    write(&dir.join("test"), 60, 2, true, columns);
    let report = json(dir, &format!("{TRAIN} --labels train/labels.csv --model m.bwm --json --save drive.toml"));
    let found = temperature(&report, "t_winding_degc");
    assert!(found["taken"] == true && report["automatic"]["temperatures"].as_array().map(Vec::len) == Some(1));
    assert_eq!(report["covariates"]["covariates"][0]["name"], "mean_t_winding_degc", "{}", report["covariates"]);
    let part = found["explained"].as_array().into_iter().flatten().find(|own| own["feature"] == "drag");
    // A factor of four beside a scatter of 5 %: 98 % or more of the variance.
    assert!(part.and_then(|own| own["part"].as_f64()).is_some_and(|part| (0.9..1.0).contains(&part)), "{found}");
    // Friction is found from a size on that is several times smaller than without the temperature.
    let compared = report["automatic"]["compared"].as_array().expect("compared");
    let size = |rival: &Value| {
        let own = rival["detected"].as_array().into_iter().flatten();
        let friction = own.filter(|one| one["kind"].as_str().is_some_and(|kind| kind.contains("friction")));
        friction.filter_map(|one| one["half_a"].as_f64()).fold(f64::INFINITY, f64::min)
    };
    let without = compared.iter().filter(|own| own["covariates"].as_array().is_some_and(Vec::is_empty));
    let (own, best) = (
        size(&compared[report["automatic"]["chosen"].as_u64().expect("a place") as usize]),
        without.map(size).fold(f64::INFINITY, f64::min),
    );
    assert!(own < 0.4 * best && own > 0.02 * best, "{own} {best}");
    // Other records at any temperature: at 1 %, more than four of sixty have a probability of 3e-4; a gate of 60
    // records scatters by a factor of two.
    let judged = json(dir, "evaluate --model m.bwm --labels test/labels.csv --json");
    let wrong = 60.0 * judged["error_rate"]["value"].as_f64().expect("a rate");
    assert!(wrong <= 4.5, "{judged}");

    // The saved file has what was chosen, and gives the same model.
    let saved = std::fs::read_to_string(dir.join("drive.toml")).expect("saved");
    for line in [
        "covariates = [\"mean_t_winding_degc\"]",
        "orders = [\"outer=",
        "velocity_from = \"",
        "harmonics = [1.0",
        "slip = 0.022",
        "group = \"none\"",
        "drag",
    ] {
        assert!(saved.contains(line), "{line} in {saved}");
    }
    let again = json(dir, "train drive.toml --model again.bwm --json");
    assert!(again["automatic"].is_null(), "nothing is left to choose");
    let bytes = |name: &str| std::fs::read(dir.join(name)).expect("a model");
    assert!(bytes("m.bwm") == bytes("again.bwm"), "{saved}");
    let told = succeed(dir, &format!("{TRAIN} --labels train/labels.csv --model n.bwm --no-drive"));
    assert!(
        told.contains("temperature t_winding_degc is used") && told.contains("the firmware must give it"),
        "{told}"
    );
}

#[test]
fn temperatures_that_explain_nothing_are_not_used() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let columns: Further<'_> = &|k, t| {
        let rare = (k > 0).then_some(t);
        vec![("t_winding_degc", Some(t)), ("oil_temp", rare), ("x_random", Some((k * k % 17) as f64))]
    };
    write(&dir.join("with"), 50, 3, false, columns);
    write(&dir.join("without"), 50, 3, false, &|_, _| vec![]);
    let output = run(dir, &format!("{TRAIN} --labels with/labels.csv --model with.bwm --json"));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let why = |column: &str| {
        let own = temperature(&report, column);
        assert!(own["taken"] == false, "{own}");
        own["refused"].as_str().unwrap_or_default().to_string()
    };
    assert!(why("t_winding_degc").contains("explains nothing"), "{report}");
    assert!(why("oil_temp").contains("no number in any row"), "{report}");
    // The model is that of records without the columns.
    succeed(dir, &format!("{TRAIN} --labels without/labels.csv --model without.bwm"));
    let bytes = |name: &str| std::fs::read(dir.join(name)).expect("a model");
    assert!(bytes("with.bwm") == bytes("without.bwm"));
    assert!(report["covariates"].is_null() && report["automatic"]["temperatures"].as_array().map(Vec::len) == Some(2));
}
