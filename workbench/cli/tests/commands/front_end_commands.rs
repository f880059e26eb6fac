//! Command-line tests of recordings at the control rate: `--front-end`.

use std::path::Path;

use crate::common::{refuse, rewrite_column, run, succeed};

const CHANNELS: &str = "--y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm";
const TRAIN: &str = "train --labels t/labels.csv --order 2,1,1,1,1 --angle angle_rad --velocity velocity_rad_s \
    --load load_torque_nm --orders inner=5.28206 --features drag,viscous --discriminant linear";

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn raw_recordings_pass_the_front_end_in_training_evaluation_and_replay() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --rig ema --class healthy --condition moog-1 --count 1 --out held");
    assert!(!dir.join("held/front_end.toml").exists(), "rows with held values are not raw");
    // 4 kHz → 1 kHz.
    let simulate = "simulate --rig ema --class healthy,roughness --log-every 3";
    succeed(dir, &format!("{simulate} --count 3 --seed 1 --out t"));
    succeed(dir, &format!("{simulate} --count 2 --seed 2 --out v"));

    let train = format!("{TRAIN} {CHANNELS} --front-end t/front_end.toml");
    succeed(dir, &format!("{train} --model m.bwm --rust m.rs --c m.h"));
    succeed(dir, &format!("{train} --model left.bwm --c left.h --c-name left"));
    let named = text(&dir.join("left.h"));
    assert!(named.contains("} BwLeftDrive;") && named.contains("#define BW_LEFT_FRONT_END_FACTOR 4u"), "{named}");
    let source = text(&dir.join("m.rs"));
    for words in [
        "pub type DriveFrontEnd = bearing_watch::drive::FrontEnd<FURTHER, 4>;",
        "pub const FURTHER: usize = 1;",
        "pub const FRONT_END: bearing_watch::drive::FrontEndConstants",
        "pub const fn position(counts: u32)",
        "let [load_torque_nm] = clean.further;",
        "Feed every sample of the front end",
    ] {
        assert!(source.contains(words), "{words} in {source}");
    }
    let header = text(&dir.join("m.h"));
    for words in [
        "#include \"bearing_watch.h\"",
        "#define BW_FRONT_END_FACTOR 4u",
        "#define BW_FRONT_END_POSITION_BITS 14u",
        "enum { BW_FRONT_END_FURTHER_LOAD_TORQUE_NM = 0 };",
        "4000.0f, /* control_rate_hz */",
        "raw.angle = bw_angle(reading->position, BW_FRONT_END_POSITION_BITS);",
    ] {
        assert!(header.contains(words), "{words} in {header}");
    }
    // The model knows its front end.
    let judged = succeed(dir, "evaluate --model m.bwm --labels v/labels.csv --json");
    assert!(judged.contains("error_rate"), "{judged}");
    let shown = succeed(dir, "replay --model m.bwm v/ema_roughness_2_000.csv");
    assert!(shown.contains("roughness"), "{shown}");

    // Rows for firmware: 8 bytes of heading, then 20 for each of 40 000 rows at most.
    succeed(dir, "replay --model m.bwm v/ema_roughness_2_000.csv --rows rows.bin");
    let rows = std::fs::read(dir.join("rows.bin")).expect("rows");
    assert!(rows.starts_with(b"BWR1\x01\0\0\0") && rows.len() == 8 + 20 * 40_000, "{}", rows.len());
    refuse(dir, "replay --model m.bwm v --rows rows.bin", &["--rows", "one recording"]);

    // A phase without current is named, and leaves no verdict from its samples.
    let broken = dir.join("broken.csv");
    rewrite_column(&dir.join("v/ema_healthy_2_000.csv"), &broken, "phase_b_a", |_| "0".into());
    let output = run(dir, "replay --model m.bwm broken.csv");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(err.contains("the currents do not fit each other"), "{err}");
    assert!(out.contains("undetermined"), "{out}");
    let identify = format!("identify broken.csv {CHANNELS} --order 2,1,1,1,1 --front-end t/front_end.toml --out p.csv");
    refuse(dir, &identify, &["broken", "do not fit each other", "cut the recording"]);

    let front_end = text(&dir.join("t/front_end.toml"));
    let with =
        |from: &str, to: &str| std::fs::write(dir.join("t/other.toml"), front_end.replace(from, to)).expect("ok");
    let other = train.replace("front_end.toml", "other.toml");
    with("control_rate_hz = 4000.0", "control_rate_hz = 8000.0");
    refuse(dir, &format!("{other} --model o.bwm"), &["ema_healthy_1_000", "recorded every 0.00025 s"]);
    with("\"phase_b_a\"", "\"phase_B_a\"");
    refuse(dir, &format!("{other} --model o.bwm"), &["phase_B_a"]);
    with("factor = 4", "factor = 5");
    refuse(dir, &format!("{other} --model o.bwm"), &["other.toml", "factor 5"]);
    refuse(dir, &format!("{train} --park thesis --model o.bwm"), &["--park", "--front-end"]);
    let difference =
        format!("{train} --identify").replace("--u1 velocity_ref_rad_s", "--u1 velocity_ref_rad_s-position_m");
    refuse(dir, &format!("{difference} --model o.bwm --rust o.rs"), &["--rust", "a difference of columns"]);
    refuse(dir, &format!("{difference} --model o.bwm --c o.h"), &["--c", "a difference of columns"]);
    refuse(dir, &format!("{train} --front-end missing.toml --model o.bwm"), &["--front-end"]);
    refuse(dir, &format!("{train} --model o.bwm --c o.h --c-name 2nd"), &["--c-name", "2nd", "a letter"]);
}

/// `init --front-end` needs no figure from the user, and what it writes trains and exports.
#[test]
fn recordings_of_raw_signals_tell_their_front_end() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let simulate = "simulate --rig ema --condition rit-mix --class healthy,spall --log-every 1";
    succeed(dir, &format!("{simulate} --count 8 --seed 3 --out t"));
    refuse(dir, "init --front-end t", &["front_end.toml exists", "--force"]);
    succeed(dir, "init --front-end --force t");
    // The audit looks at the rows as they are recorded, and at what the front end makes of them.
    let audited = crate::common::run(dir, "audit t/drive.toml");
    let audited = String::from_utf8_lossy(&audited.stdout).into_owned();
    assert!(audited.contains(" as recorded)") && audited.contains("lines of orders, median of"), "{audited}");
    let file = text(&dir.join("t/front_end.toml"));
    for words in [
        "control_rate_hz = 10000.000",
        "columns = [\"phase_a_a\", \"phase_b_a\", \"phase_c_a\"]",
        "counts = \"resolver_counts\"",
        "bits = 14",
        "pole_pairs = 6 ",
    ] {
        assert!(file.contains(words), "{words} in {file}");
    }
    // Of the rig it is 0; a degree of it costs 2·10⁻⁴ of the current.
    let offset = file.lines().find_map(|line| line.strip_prefix("electrical_offset_rad = ")?.parse::<f64>().ok());
    assert!(offset.is_some_and(|offset| offset.abs() < 0.02), "{file}");
    assert!(text(&dir.join("t/drive.toml")).contains("front_end = \"front_end.toml\""));
    succeed(dir, "train t/drive.toml --orders inner=5.28206 --model m.bwm --rust m.rs --c m.h");
    assert!(text(&dir.join("m.rs")).contains("pub static WATCH: Drive, DriveFrontEnd;"));
    assert!(text(&dir.join("m.h")).contains("bw_drive_sample(BwDrive *drive, const BwReading *reading)"));
    let judged = succeed(dir, "evaluate t/drive.toml --model m.bwm --json");
    assert!(judged.contains("\"error_rate\""), "{judged}");
    // Clean signals are no raw ones.
    succeed(dir, "simulate --rig ema --condition rit-mix --class healthy --count 1 --seed 3 --out c");
    std::fs::write(dir.join("c/clean.csv"), "t_s,current_a,angle_rad\n0,1,2\n0.1,2,3\n0.2,3,4\n").expect("writable");
    refuse(dir, "init --front-end --force c/clean.csv", &["no columns of two or three phase currents"]);
}
