//! Command-line tests of load collective and nominal life.

use std::path::Path;

use serde_json::Value;

use super::common::{refuse, run, succeed};

const TRAIN: &str = "train --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,1,1,1 \
    --angle angle_rad --velocity velocity_rad_s --features drag --model m.bwm --labels runs/labels.csv";

fn json(folder: &Path, arguments: &str) -> Value {
    serde_json::from_str(&succeed(folder, arguments)).expect("JSON")
}

#[test]
fn replay_gives_the_nominal_life_of_a_loaded_bearing() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 12 --seed 31 --out runs");
    succeed(dir, &format!("{TRAIN} --load load_torque_nm"));
    let traces = "runs/healthy_31_000.csv runs/healthy_31_001.csv";
    let replay = format!("replay --model m.bwm {traces}");
    // Nothing is said of a life, unless something is said of the bearing.
    assert!(!succeed(dir, &replay).contains("nominal life"));
    let told = succeed(dir, &format!("{replay} --bearing 9,3,17,10"));
    assert!(told.contains("no nominal life: give the bearing's basic dynamic load rating C"), "{told}");

    let constant = "--load-rating-n 13500 --bearing-load-n 1000 --bearing 9,3,17,10";
    let told = succeed(dir, &format!("{replay} {constant}"));
    for part in
        ["nominal life L10 by ISO 281: 2 460 million turns or ", "mean load 1000 N", "nine of ten such bearings"]
    {
        assert!(told.contains(part), "{part} in {told}");
    }
    let values = json(dir, &format!("{replay} {constant} --json"));
    let lives: Vec<&Value> = values.as_array().expect("segments").iter().map(|own| &own["life"]).collect();
    let turns = |life: &Value| life["turns"].as_f64().expect("turns");
    let given: Vec<&&Value> = lives.iter().filter(|life| life.is_object()).collect();
    assert!(given.len() == 2 && turns(given[1]) > turns(given[0]), "after each trace: {lives:?}");
    assert!(lives.last().is_some_and(|life| life.is_object()), "{lives:?}");
    let million = given[1]["l10_million_turns"].as_f64().expect("a life");
    assert!((million / 2460.375 - 1.0).abs() < 1e-9, "{million}");

    // A load that follows the torque, by the sensor and by the current; the rig's motor has 0.05 N·m/A.
    let follows = "--load-rating-n 13500 --bearing-load-per-nm 4000";
    for torque in ["", "--torque-constant-nm-a 0.05"] {
        let values = json(dir, &format!("{replay} {follows} {torque} --json"));
        let life = values.as_array().and_then(|all| all.last()).expect("a segment")["life"].clone();
        let mean = life["mean_load_n"].as_f64().expect("a load");
        assert!(mean > 1.0 && life["short_swings"].is_null(), "{life}");
    }
    succeed(dir, &format!("{replay} {follows} --report page.html"));
    let page = std::fs::read_to_string(dir.join("page.html")).expect("a page");
    assert!(page.contains("Nominal life of the bearing") && page.contains("load from / N"), "no section");
    refuse(dir, &format!("{replay} --load-rating-n 0 --bearing-load-n 1"), &["--load-rating-n is a number above 0"]);
}

/// The drive file of the training says what loads the bearing.
#[test]
fn the_bearing_of_the_training_is_that_of_the_replay() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 12 --seed 32 --out runs");
    let file = "[bearing]\nload_rating_n = 13500\nrollers = true\nbearing_load_n = 1350\n";
    std::fs::write(dir.join("own.toml"), file).expect("writable");
    succeed(dir, &TRAIN.replacen("train", "train own.toml", 1));
    let replay = "replay --model m.bwm runs/healthy_32_000.csv";
    // 10^(10/3).
    let told = succeed(dir, replay);
    assert!(
        told.contains("2 154 million turns") && told.contains("is not known: give the bearing's geometry"),
        "{told}"
    );
    assert!(succeed(dir, &format!("{replay} --bearing-load-n 2700")).contains("mean load 2700 N"));
    // Without a load sensor the torque is that of the current.
    let lacks = run(dir, &format!("{replay} --bearing-load-per-nm 40"));
    let told = String::from_utf8_lossy(&lacks.stdout).into_owned();
    assert!(told.contains("no load sensor; give the motor's --torque-constant-nm-a"), "{told}");
}
