//! Each cause has its own name in every door: causes are injected into the current of three rigs, and the names are read
//! from text, JSON, page, DBC, CAN, telemetry, C header and Rust source.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use bearing_watch::model::FeatureValue;
use bearing_watch::plan::RunTime;
use bearing_watch::telemetry::{Encoder, SegmentFrame, Source};
use bearing_watch::{Decision, Detector, Evidence, Model, Verdict};
use serde_json::Value;

use crate::common::succeed;

/// In another order than that of the core (viscous, coulomb, inverse_kt, load_friction; outer, inner, ball, cage), with
/// those last that a defect raises.
const COORDINATES: [&str; 8] =
    ["inverse_kt", "load_friction", "viscous", "coulomb", "order_outer", "order_inner", "order_cage", "order_ball"];

/// A cause: its coordinate, its name for a reader, and the size of its current in parts of the rms of the record's;
/// that of load friction is given for each rig, since Coulomb friction rises with a large one.
const CAUSES: [(&str, &str, f64); 7] = [
    ("viscous", "viscous friction", 0.3),
    ("coulomb", "Coulomb friction", 0.3),
    ("load_friction", "load friction", 1.0),
    ("order_outer", "outer order", 0.2),
    ("order_inner", "inner order", 0.2),
    ("order_cage", "cage order", 0.6),
    ("order_ball", "ball order", 0.2),
];

/// Events per turn of the bearing 9,3,17,10.
fn order(cause: &str) -> f64 {
    let r = 3.0 / 17.0 * 0.1745_f64.cos();
    match cause {
        "order_outer" => 4.5 * (1.0 - r),
        "order_inner" => 4.5 * (1.0 + r),
        "order_cage" => 0.5 * (1.0 - r),
        _ => 0.5 * 17.0 / 3.0 * (1.0 - r * r),
    }
}

/// The current of a cause at this velocity, angle and load, of any size. Pulses of an order have no mean, so that no
/// friction rises with them; the cage has a line alone, since the ninth harmonic of its pulses is the outer order.
fn shape(cause: &str, [velocity, angle, load]: [f64; 3]) -> f64 {
    const DUTY: f64 = 0.15;
    let sign = velocity.tanh();
    let pulse = || {
        let x = (order(cause) * angle / TAU).rem_euclid(1.0) / DUTY;
        if x < 1.0 { 0.5 * (1.0 - (TAU * x).cos()) } else { 0.0 }
    };
    match cause {
        "viscous" => velocity,
        "coulomb" => sign,
        "load_friction" => load.abs() * sign,
        "order_cage" => sign * (order(cause) * angle).cos(),
        _ => sign * (pulse() - 0.5 * DUTY),
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.filter(|x| x.is_finite()).fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Writes the healthy records of a folder with the current of a cause.
fn inject(dir: &Path, (cause, part): (&str, f64)) {
    let to = dir.join(cause);
    std::fs::create_dir_all(&to).expect("a folder");
    for entry in std::fs::read_dir(dir.join("healthy")).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|kind| kind != "csv") || path.ends_with("labels.csv") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a trace");
        let mut rows: Vec<Vec<String>> = text.lines().map(|line| line.split(',').map(String::from).collect()).collect();
        let place = |name: &str| rows[0].iter().position(|own| own == name).expect("a column");
        let current = place("current_a");
        let inputs = ["velocity_rad_s", "angle_rad", "load_torque_nm"].map(place);
        let number = |row: &[String], place: usize| row[place].parse::<f64>().expect("a number");
        let added: Vec<f64> =
            rows[1..].iter().map(|row| shape(cause, inputs.map(|place| number(row, place)))).collect();
        let size = part * rms(rows[1..].iter().map(|row| number(row, current))) / rms(added.iter().copied());
        for (row, added) in rows[1..].iter_mut().zip(added) {
            row[current] = (number(row, current) + size * added).to_string();
        }
        let lines: Vec<String> = rows.iter().map(|row| row.join(",") + "\n").collect();
        std::fs::write(to.join(path.file_name().expect("a name")), lines.concat()).expect("writable");
    }
}

/// Trains m.bwm, m.h and m.rs on so many runs of four healthy records of a rig.
fn train(dir: &Path, rig: &str, runs: u32) {
    succeed(dir, &format!("simulate {rig} --class healthy --count {} --seed 21 --out train", 4 * runs));
    succeed(dir, &format!("simulate {rig} --class healthy --count 10 --seed 322 --out healthy"));
    let labels = dir.join("train/labels.csv");
    let text = std::fs::read_to_string(&labels).expect("labels");
    let row = |(k, line): (usize, &str)| match k.checked_sub(1) {
        None => format!("{line},session\n"),
        Some(k) => format!("{line},{}\n", k / 4),
    };
    std::fs::write(labels, text.lines().enumerate().map(row).collect::<String>()).expect("writable");
    let features = COORDINATES.join(",");
    succeed(
        dir,
        &format!(
            "train --current current_a --velocity velocity_rad_s --velocity-ref velocity_ref_rad_s --angle angle_rad \
             --load load_torque_nm --bearing 9,3,17,10 --labels train/labels.csv --group session --false-alarm 0.05 \
             --alarm-interval-h 1000 --features {features} --rising load_friction,viscous,coulomb --model m.bwm \
             --c m.h --rust m.rs"
        ),
    );
}

/// The last alarm of lines of JSON.
fn last_alarm(lines: &str) -> Value {
    let values = lines.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
    values
        .filter_map(|mut value| value.get_mut("alarm").map(Value::take))
        .rfind(|own| !own.is_null())
        .unwrap_or_default()
}

/// What text, page and JSON of `replay` say of records with a cause: whether each names it.
fn replayed(dir: &Path, (cause, words, _): (&str, &str, f64)) -> [bool; 4] {
    let replay = format!("replay --model m.bwm --run-a-trace {cause}");
    let text = succeed(dir, &format!("{replay} --report page.html"));
    let page = std::fs::read_to_string(dir.join("page.html")).expect("a page");
    let values: Value = serde_json::from_str(&succeed(dir, &format!("{replay} --json"))).expect("JSON");
    let last = values.as_array().and_then(|list| list.last()).expect("a segment");
    let said = text.lines().last().expect("words");
    let growth = last["growth"]["direction"].as_str().unwrap_or_default();
    println!("{cause}: {said}");
    [
        said.starts_with(&format!("ALARM: {words} has risen.")),
        page.contains(&format!("ALARM: {words} has risen.")) && page.contains(&format!("Size of a defect, {words}")),
        last["alarm"]["cause"] == *cause,
        growth.split(' ').next() == Some(cause),
    ]
}

/// What a drive sends while one direction after another has risen: frames of the telemetry, and a log of a CAN bus.
fn sent(model: &Model<RunTime>, direction: usize) -> (Vec<u8>, String) {
    let classifier = &model.constants().classifier;
    let directions = &classifier.novelty.directions.list;
    let mut evidence = Evidence::new(model);
    let mut report = Detector::new(model).finish();
    let mut encoder = Encoder::new(model, Source::default());
    let mut buffer = [0; 1024];
    let mut frames = encoder.hello(&mut buffer).expect("fits").to_vec();
    let mut log = String::new();
    for run in 0..12_u32 {
        for segment in 1..=4 {
            let deviation = |k: usize| {
                if k == direction && run >= 6 { 30.0 * (directions[k].run + directions[k].segment).sqrt() } else { 0.0 }
            };
            let value = |k: usize| FeatureValue { value: deviation(k), variance: 0.0 };
            let decided: Option<Decision<RunTime>> = classifier.decide(model.plan(), &[0.0], 0.5);
            let mut decision = decided.expect("a decision");
            decision.set_directed(&(0..directions.len()).map(value).collect::<Vec<_>>());
            (report.verdict, report.decision) = (Verdict::Class(0), Some(decision));
            evidence.observe(report.decision.as_ref());
            if segment == 4 {
                evidence.end_run();
            }
            frames.extend_from_slice(encoder.report(&report, &evidence, &mut buffer).expect("fits"));
            let bytes = SegmentFrame::of(model, &report, &evidence).to_bytes();
            let digits: String = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
            log += &format!("({}.5) can0 123#{digits}\n", 4 * run + segment);
        }
    }
    (frames, log)
}

/// Whether telemetry and CAN, each as text and JSON, name a direction as the cause.
fn listened(dir: &Path, model: &Model<RunTime>, (direction, cause, words): (usize, &str, &str)) -> [bool; 5] {
    let (frames, log) = sent(model, direction);
    std::fs::write(dir.join("frames.bin"), frames).expect("writable");
    std::fs::write(dir.join("bus.log"), log).expect("writable");
    let listen = |options: &str| succeed(dir, &format!("listen {options}"));
    let sentence = format!(": {words} has risen. ");
    let said = |text: &str| text.lines().any(|line| line.starts_with("ALARM at ") && line.contains(&sentence));
    // Without the model an order has its number, a friction its name.
    let unnamed = listen("frames.bin");
    [
        said(&listen("frames.bin --model m.bwm")),
        cause.starts_with("order_") || said(&unnamed),
        last_alarm(&listen("frames.bin --model m.bwm --json"))["cause"] == *cause,
        said(&listen("bus.log --can-id 0x123 --model m.bwm")),
        last_alarm(&listen("bus.log --can-id 0x123 --model m.bwm --json"))["cause"] == *cause,
    ]
}

/// The names in quotes of the first line that starts so.
fn quoted(text: &str, start: &str) -> Vec<String> {
    let line = text.lines().find_map(|line| line.strip_prefix(start)).unwrap_or_else(|| panic!("no {start} in {text}"));
    line.split('"').skip(1).step_by(2).map(String::from).collect()
}

/// The names that C, Rust and DBC give the coordinates.
fn exported(dir: &Path) {
    let read = |file: &str| std::fs::read_to_string(dir.join(file)).expect("a file");
    assert_eq!(quoted(&read("m.h"), "#define BW_MODEL_COORDINATE_NAMES "), COORDINATES);
    assert_eq!(quoted(&read("m.rs"), "pub const COORDINATES: "), COORDINATES);
    let dbc = succeed(dir, "dbc --model m.bwm --id 0x123");
    let causes = dbc.lines().find_map(|line| line.strip_prefix("VAL_ 291 Alarm ")).expect("causes");
    for (place, name) in COORDINATES.iter().enumerate() {
        assert!(causes.contains(&format!(" {} \"risen: {name}\" ", 128 + place)), "{name}: {causes}");
    }
}

/// Reads every door of a rig; each of the seven causes has nine names.
fn oracle(rig: &str, load_friction: f64, runs: u32) {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    train(dir, rig, runs);
    exported(dir);
    let model = Model::<RunTime>::from_bytes(&std::fs::read(dir.join("m.bwm")).expect("a model")).expect("a model");
    let directions = &model.constants().classifier.novelty.directions.list;
    let watched: BTreeMap<&str, usize> = directions
        .iter()
        .enumerate()
        .map(|(k, direction)| (COORDINATES[usize::from(direction.coordinate)], k))
        .collect();
    let mut wrong = vec![];
    for cause in CAUSES {
        inject(dir, (cause.0, if cause.0 == "load_friction" { load_friction } else { cause.2 }));
        let said = replayed(dir, cause);
        let heard = listened(dir, &model, (watched[cause.0], cause.0, cause.1));
        if said.iter().chain(&heard).any(|right| !right) {
            wrong.push((cause.0, said, heard));
        }
    }
    assert!(wrong.is_empty(), "{rig}: {wrong:?}");
}

#[test]
fn causes_on_the_motor_have_their_names_in_every_door() {
    oracle("--condition mix", 0.02, 16);
}

#[test]
fn causes_in_the_field_have_their_names_in_every_door() {
    oracle("--condition field-any", 0.2, 16);
}

#[test]
fn causes_on_the_actuator_have_their_names_in_every_door() {
    // A line at the cage order raises all orders. Of 16 runs the deviation of runs at the cage is known too badly to
    // tell them apart.
    oracle("--rig ema --condition mix", 0.05, 48);
}
