//! Command-line tests of healthy-only training, novelty gate, reject option and alarm.

use std::path::Path;

use crate::common::{refuse, rewrite_column, run, succeed};
use serde_json::Value;

const TRAIN: &str = "train --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,2,1,1";

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn healthy_traces_alone_make_a_model_that_alarms() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 20 --seed 11 --out train");
    succeed(dir, "simulate --class healthy,roughness --count 3 --seed 12 --out test");
    let train = format!("{TRAIN} --labels train/labels.csv --model m.bwm");
    let output = run(dir, &format!("{train} --rust m.rs --report m.html"));
    let (said, warned) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && said.contains("from healthy: false-alarm rate 0.01"), "{said}{warned}");
    assert!(warned.contains("keep the false-alarm rate of 0.01 in the mean only"), "{warned}");
    let source = std::fs::read_to_string(dir.join("m.rs")).expect("source");
    assert!(source.contains("class: Some(0)") && source.contains("evidence: EvidenceConstants { bet: 0.2"), "{source}");

    let records =
        "test/healthy_12_000.csv test/roughness_12_000.csv test/roughness_12_001.csv test/roughness_12_002.csv";
    let replayed = succeed(dir, &format!("replay --model m.bwm {records}"));
    let lines: Vec<&str> = replayed.lines().collect();
    assert!(lines[0].contains("  healthy  ") && lines[0].contains("distance"), "{replayed}");
    assert!(lines[1].contains("  novel  "), "{replayed}");
    let alarm = lines.iter().position(|line| line.starts_with("ALARM at segment")).expect("an alarm");
    assert!((3..=4).contains(&alarm) && lines[alarm].ends_with("unknown"), "{replayed}");
    let values = json(&succeed(dir, &format!("replay --model m.bwm {records} --json")));
    assert_eq!(
        (&values[1]["verdict"], &values[1]["class"], &values[0]["alarm"]),
        (&"novel".into(), &Value::Null, &Value::Null)
    );
    assert_eq!(values[3]["alarm"]["cause"], "unknown");
    let judged = json(&succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --classes healthy --json"));
    assert_eq!(
        (&judged["classes"], &judged["undetermined"]),
        (&serde_json::json!(["healthy"]), &serde_json::json!([0]))
    );
    // An untrained defect class can still be distinguished from healthy.
    let judged = json(&succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --json"));
    assert_eq!(judged["untrained_not_called_healthy"]["roughness"]["value"], 1.0);
    assert_eq!(judged["classes"], serde_json::json!(["healthy"]));
}

#[test]
fn the_shaft_s_features_find_a_small_defect_from_healthy_traces() {
    const SHAFT: &str = "--angle angle_rad --velocity velocity_rad_s --velocity-ref velocity_ref_rad_s --load load_torque_nm \
        --bearing 9,3,17,10 --features drag_score,inverse_kt_score,order_outer";
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 30 --seed 21 --out train");
    succeed(dir, "simulate --class spall --severity 0.25 --count 4 --seed 22 --out test");
    let train = format!("{TRAIN} --labels train/labels.csv --model m.bwm --rust m.rs {SHAFT}");
    let told = succeed(dir, &train);
    assert!(told.contains("features drag_score, inverse_kt_score, order_outer"), "{told}");
    let source = std::fs::read_to_string(dir.join("m.rs")).expect("source");
    assert!(
        source.contains("orders: 1,")
            && source.contains("struct Sample with angle { current_a: \"A\", load_torque_nm: \"N·m\" }")
            && source.contains("orders outer 3.71795"),
        "{source}"
    );
    let judged = json(&succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --json"));
    // The traces are nine standard deviations away: a single miss in four would be an error of the program, not chance.
    assert_eq!(judged["untrained_not_called_healthy"]["spall"]["value"], 1.0);
    let said = succeed(dir, "evaluate --model m.bwm --labels test/labels.csv");
    assert!(said.starts_with("spall, not trained: not called healthy 100.0 %") && !said.contains("NaN"), "{said}");
    let replayed = succeed(dir, "replay --model m.bwm test --json");
    assert_eq!(json(&replayed)[0]["friction"]["names"][7], "drag");
    assert!(succeed(dir, "replay --model m.bwm test").contains("× noise"), "{replayed}");
    let of_velocity = format!("{TRAIN} --labels train/labels.csv --model n.bwm --velocity velocity_rad_s");
    refuse(dir, &of_velocity, &["--angle"]);
    refuse(
        dir,
        &format!("{TRAIN} --labels train/labels.csv --model n.bwm {SHAFT} --orders nine=x"),
        &["nine=x", "NAME=ORDER"],
    );
    let wrong = SHAFT.replace("9,3,17,10", "9,17,3,0.1745");
    refuse(dir, &format!("{TRAIN} --labels train/labels.csv --model n.bwm {wrong}"), &["--bearing", "ball diameter"]);
    refuse(
        dir,
        &format!("{TRAIN} --labels train/labels.csv --model n.bwm --features order_outer"),
        &["no order_outer in this model"],
    );
}

/// Gives the traces of a set runs of this many, numbered from `first`, in a column `session` of their labels.
fn with_sessions(labels: &Path, size: usize, first: usize) {
    let text = std::fs::read_to_string(labels).expect("labels");
    let mut lines = text.lines();
    let mut out = format!("{},session\n", lines.next().expect("a header"));
    lines.enumerate().for_each(|(k, line)| out += &format!("{line},{}\n", first + k / size));
    std::fs::write(labels, out).expect("write");
}

/// Trains m.bwm, m.rs and m.h from sixteen runs of six healthy records; returns what is said.
fn trained_by_runs(dir: &Path) -> String {
    succeed(dir, "simulate --class healthy --condition mix --count 96 --seed 21 --out train");
    with_sessions(&dir.join("train/labels.csv"), 6, 0);
    succeed(
        dir,
        &format!(
            "{TRAIN} --labels train/labels.csv --model m.bwm --rust m.rs --c m.h --angle angle_rad \
             --velocity velocity_rad_s --velocity-ref velocity_ref_rad_s --load load_torque_nm --bearing 9,3,17,10 \
             --features drag,inverse_kt,viscous,order_outer,order_inner --group session --alarm-interval-h 1000"
        ),
    )
}

/// Ten healthy runs, and then a spall that grows by 0.002 of its full size in each of 26 runs of four records.
#[test]
fn a_slow_growth_is_told_with_its_time_before_a_single_segment_shows_it() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    trained_by_runs(dir);
    succeed(dir, "simulate --class healthy --condition mix --count 40 --seed 322 --out later");
    for k in 1..=26_u32 {
        let (severity, seed) = (0.002 * f64::from(k), 1000 + k);
        let defect = format!("--class spall --condition mix --severity {severity:.3} --count 4 --seed {seed}");
        succeed(dir, &format!("simulate {defect} --out later"));
    }
    with_sessions(&dir.join("later/labels.csv"), 4, 100);
    let said = succeed(dir, "replay --model m.bwm later --labels later/labels.csv --report r.html");
    let page = std::fs::read_to_string(dir.join("r.html")).expect("a page");
    let size = page.split("<p>Size of a defect, ").nth(1).and_then(|rest| rest.split("</p>").next()).expect("a size");
    for words in
        ["an hour of segments; if it goes on so, ", "usual runs, until ", "deviations, which a single segment shows."]
    {
        assert!(size.contains(words), "{size}");
    }
    // Of 26 runs of two thirds of usual length, after which the sizes are about half of the named one.
    let left = size.split("hours of segments, or ").nth(1).and_then(|rest| rest.split(' ').next()).expect("a number");
    assert!((8.0..50.0).contains(&left.parse::<f64>().expect("runs")), "{size}");
    // The table says of the direction of the alarm since when it has risen, as the sentence does.
    let since = said.lines().last().and_then(|words| words.split("this drive, since ").nth(1)).expect("an onset");
    let since = since.split(';').next().expect("a place");
    let feature = size.split(':').next().expect("a name").split(' ').next().expect("a word");
    let rows: Vec<&str> = page.split("<tr").filter(|row| row.contains(since)).collect();
    assert!(rows.iter().any(|row| row.contains(feature)), "{feature} since {since}: {rows:?}");
}

#[test]
fn an_alarm_by_runs_says_what_has_risen_and_is_confirmed() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --condition mix --count 12 --seed 22 --out later");
    succeed(dir, "simulate --class spall --condition mix --severity 0.35 --count 8 --seed 23 --out later");
    with_sessions(&dir.join("later/labels.csv"), 4, 100);
    let told = trained_by_runs(dir);
    assert!(told.contains("outer order; inner order), 16 runs of one drive × 6 records"), "{told}");
    let read = |file: &str| std::fs::read_to_string(dir.join(file)).expect("a file");
    assert!(read("m.rs").contains("COORDINATES: [&str; 5] = [\"drag\", \"inverse_kt\", \"viscous\", \"order_outer\""));
    assert!(read("m.h").contains("#define BW_MODEL_COORDINATE_NAMES { \"drag\", \"inverse_kt\""), "{}", read("m.h"));

    let replay = "replay --model m.bwm later --labels later/labels.csv";
    let said = succeed(dir, &format!("{replay} --report r.html"));
    assert_eq!(said.lines().filter(|line| line.starts_with("  run: ")).count(), 5, "{said}");
    let end = said.lines().last().expect("words");
    assert!(end.starts_with("ALARM: outer order has risen. It is "), "{end}");
    assert!(end.contains("since spall_0.35_mix_23_000") && end.contains("inner order are as usual"), "{end}");
    assert!(read("r.html").contains("Features over the runs") && read("r.html").contains("risen since"));
    size_on_pages(dir, &read("r.html"));
    let values = json(&succeed(dir, &format!("{replay} --json")));
    assert_eq!((&values[2]["run"], &values[3]["run"][2]["direction"]), (&Value::Null, &"order_outer".into()));
    assert!(values[19]["run"][2]["deviations"].as_f64().expect("a number") > 10.0, "{}", values[19]["run"]);
    assert_eq!(values[19]["alarm"]["cause"], "order_outer");
    refuse(dir, "replay --model m.bwm later --group session", &["--group session", "--labels"]);
    refuse(dir, "replay --model m.bwm train --labels later/labels.csv", &["no run in column session"]);
    refuse(dir, "replay --model m.bwm later --labels later/labels.csv --group day", &["no column day"]);

    let confirm = "confirm --labels later/labels.csv later/spall_0.35_mix_23_000.csv";
    let said = succeed(dir, &format!("{confirm} --false"));
    assert!(
        said.starts_with("1 recording is healthy") && said.contains("(1 of them") && said.contains("deny"),
        "{said}"
    );
    assert!(
        read("later/labels.csv").contains("spall_0.35_mix_23_000.csv,healthy,0.35"),
        "{}",
        read("later/labels.csv")
    );
    succeed(dir, "confirm --labels later/labels.csv later/spall_0.35_mix_23_000.csv --true outer");
    let unknown = "confirm --labels train/labels.csv later/spall_0.35_mix_23_000.csv --false";
    refuse(dir, unknown, &["needs a cell of column severity"]);
    let cells = "--set severity=0 --set seed=1 --set condition=mix --set waveform=sine --set session=16";
    assert!(succeed(dir, &format!("{unknown} {cells}")).contains("(0 of them"));
    assert!(read("train/labels.csv").ends_with("spall_0.35_mix_23_000,healthy,0,1,mix,sine,16\n"));
    refuse(dir, &format!("{confirm} --false --true outer"), &["--true"]);
    refuse(dir, confirm, &["--false"]);
    refuse(dir, &format!("{confirm} --true healthy"), &["no defect"]);
    refuse(dir, &format!("{confirm} --false --set day=3"), &["no column day"]);
    refuse(dir, "confirm --labels later/labels.csv later --false", &["no file"]);
}

/// The pages of a drive with an alarm, of a healthy one, and of a single run.
fn size_on_pages(dir: &Path, alarmed: &str) {
    const FIGURE: &str = "Size of a defect over the runs";
    assert!(alarmed.contains(FIGURE) && alarmed.contains("an estimate from the past of this drive"));
    let told = alarmed.split("<p>Size of a defect, outer order: ").nth(1).and_then(|rest| rest.split("</p>").next());
    let told = told.expect("the size of the direction that raised the alarm");
    assert!(told.contains("] deviations above what is usual for this drive (90 % interval), "), "{told}");
    let of_healthy = |count: usize| {
        let records: Vec<String> = (0..count).map(|k| format!("later/healthy_mix_22_{k:03}.csv")).collect();
        let replay = format!("replay --model m.bwm {} --labels later/labels.csv", records.join(" "));
        let said = succeed(dir, &format!("{replay} --report h.html"));
        (said, std::fs::read_to_string(dir.join("h.html")).expect("a page"))
    };
    let (said, page) = of_healthy(12);
    assert!(said.contains("(90 % interval), not growing\n") && !said.contains("Size of a defect"), "{said}");
    assert!(page.contains(FIGURE) && page.contains(", not growing. This is an estimate"));
    let (_, page) = of_healthy(4);
    assert!(!page.contains("Size of a defect") && page.contains("After 1 run, in "));
}

#[test]
fn a_gate_beside_trained_classes() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall,roughness --count 12 --seed 13 --out train");
    succeed(dir, "simulate --class healthy,spall,roughness --count 3 --seed 14 --out test");
    let train = format!("{TRAIN} --labels train/labels.csv --model m.bwm");
    let told = json(&succeed(dir, &format!("{train} --false-alarm 0.02 --alarm-interval-h 100 --json")));
    let novelty = &told["novelty"];
    assert_eq!((&novelty["healthy"], &novelty["false_alarm"]), (&"healthy".into(), &0.02.into()));
    // 100 hours in segments of 10 s; three scores share the rate.
    assert!((novelty["alarm_interval_segments"].as_f64().expect("an interval") - 36_000.0).abs() < 1e-6);
    assert!((novelty["alarm_limit_nats"].as_f64().expect("a limit") - 108_000_f64.ln()).abs() < 1e-5);
    let judged = json(&succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --json"));
    assert_eq!(judged["called_healthy"][0], Value::Null);
    assert_eq!(judged["called_healthy"][1]["value"].as_f64(), Some(0.0));
    let records = "test/spall_14_000.csv test/spall_14_001.csv test/spall_14_002.csv";
    let replayed = succeed(dir, &format!("replay --model m.bwm {records}"));
    assert!(replayed.lines().any(|line| line == "ALARM at segment 2: spall"), "{replayed}");
    let conclusion = replayed.lines().last().expect("a conclusion");
    assert!(conclusion.starts_with("ALARM: spall. It was raised in spall_14_001.csv;"), "{conclusion}");
    let healthy = succeed(dir, "replay --model m.bwm test/healthy_14_000.csv");
    assert!(healthy.contains("\nNo defect found: 1 segment of 1 trace is healthy"), "{healthy}");
    // If a rejection costs nothing, every segment is rejected.
    succeed(dir, &format!("{train} --reject-cost 0"));
    let judged = json(&succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --json"));
    let named: u64 = judged["confusion"]
        .as_array()
        .expect("rows")
        .iter()
        .flat_map(|row| row.as_array())
        .flatten()
        .filter_map(Value::as_u64)
        .sum();
    assert!(named <= 9, "{judged}");
    let gateless = succeed(dir, &format!("{train} --classes spall,roughness"));
    assert!(!gateless.contains("Novel beyond"), "{gateless}");
    let similar = succeed(dir, "replay --model m.bwm test/healthy_14_000.csv");
    assert!(similar.contains("\nThis model has no healthy class: it cannot say that a drive is healthy"), "{similar}");
}

#[test]
fn too_few_and_nonsense_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 9 --seed 15 --out t");
    let train = format!("{TRAIN} --labels t/labels.csv --model none.bwm");
    for (options, words) in [
        ("--false-alarm 0.00001", vec!["9 healthy segments are too few", "give at least"]),
        ("--classes healthy --false-alarm 0.00001", vec!["9 healthy segments are too few"]),
        ("--false-alarm 0.9", vec!["--false-alarm 0.9", "from 1e-9 to 0.5"]),
        ("--healthy worn", vec!["--healthy", "unknown class worn"]),
        ("--reject-cost=-1", vec!["--reject-cost"]),
        ("--alarm-interval-segments 3", vec!["at least 10 segments"]),
        (
            "--false-alarm 0.2 --alarm-interval-segments 40 --segments-a-run 5",
            vec!["too often for runs of 5 segments", "at least 50 segments"],
        ),
        (
            "--false-alarm 0.2 --alarm-interval-segments 1e30",
            vec!["9 segments say too little of the healthy drive", "use fewer features"],
        ),
        ("--alarm-interval-segments 30 --alarm-interval-h 3", vec!["cannot be used with"]),
        ("--classes healthy --projection fisher", vec!["needs two classes"]),
    ] {
        refuse(dir, &format!("{train} {options}"), &words);
    }
    // If no gate was requested and there are too few traces, the gate is omitted with a warning.
    succeed(dir, "simulate --class healthy,spall --count 5 --seed 16 --out few");
    let output = run(dir, &format!("{TRAIN} --labels few/labels.csv --model m.bwm --json"));
    let warned = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && warned.contains("too few") && warned.contains("none is set"), "{warned}");
    assert_eq!(json(&String::from_utf8_lossy(&output.stdout))["novelty"], Value::Null);
}

/// Adds the column `run` to the labels of a folder: runs of four traces each.
fn add_runs(dir: &Path, folder: &str) {
    let path = dir.join(folder).join("labels.csv");
    let labels = std::fs::read_to_string(&path).expect("labels");
    let rows = labels.lines().enumerate().map(|(k, line)| match k {
        0 => format!("{line},run\n"),
        _ => format!("{line},r{}\n", (k - 1) / 4),
    });
    std::fs::write(&path, rows.collect::<String>()).expect("writable");
}

#[test]
fn the_rate_of_the_next_run() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 24 --seed 17 --out train");
    succeed(dir, "simulate --class healthy --count 8 --seed 18 --out test");
    add_runs(dir, "train");
    add_runs(dir, "test");
    let train = format!("{TRAIN} --labels train/labels.csv --model m.bwm --group run");
    // Six runs support 1 % with one coordinate, not with two.
    refuse(dir, &format!("{train} --features a"), &["6 runs support a false-alarm rate of 3 %", "at least 7 runs"]);
    let said = succeed(dir, &format!("{train} --features b1"));
    assert!(said.contains("The rate is that of the next run") && said.contains("6 runs"), "{said}");
    // One in seven runs, not one in 24 segments.
    let rests = ["of 6 runs, which count as ", "rates below 1.43e-1 rest on the fitted law and not on counted runs"];
    assert!(rests.iter().all(|part| said.contains(part)), "{said}");
    let table = said.split("forward in time, gates of the first runs on later ones:\n").nth(1).expect("a table");
    assert!(table.contains("4 runs  no gate, ") && table.contains("support"), "{said}");
    assert!(table.contains(" 5 runs  ") && table.contains("by runs, in"), "{said}");
    let told = json(&succeed(dir, &format!("{train} --features b1 --json")));
    assert_eq!((&told["novelty"]["next_run"]["runs"], told["forward"].as_array().map(Vec::len)), (&6.into(), Some(4)));
    let judged = succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --group run");
    assert!(judged.contains("false alarms ") && judged.contains("of 2 runs: r0 "), "{judged}");
    let judged = json(&succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --group run --json"));
    assert_eq!(judged["false_alarms_by_run"]["runs"][1]["judged"], 4, "{judged}");
    // A run is as long as the longest healthy one unless given; another drive differs for good.
    assert_eq!(told["novelty"]["alarm_segments_a_run"], 4, "{told}");
    let said = succeed(dir, &format!("{train} --features b1 --segments-a-run 2"));
    assert!(said.contains("a run ends after 2 segments"), "{said}");
    // A trace is one segment: its evidence counts at the end of a run, so after two traces or, if told so, after each.
    succeed(dir, "simulate --class roughness --count 8 --seed 19 --out rough");
    let scores = |options: &str| {
        let replayed = json(&succeed(dir, &format!("replay --model m.bwm rough --json {options}")));
        let replayed = replayed.as_array().expect("a list").clone();
        replayed.iter().map(|own| own["score"].as_f64().expect("a number")).collect::<Vec<_>>()
    };
    let (by_two, by_one) = (scores(""), scores("--run-a-trace"));
    assert_eq!((by_two.len(), by_one.len()), (8, 8));
    assert!(by_two.windows(2).zip(1..).all(|(pair, k)| (pair[0] == pair[1]) == (k % 2 == 0)), "{by_two:?}");
    assert!(by_one.windows(2).all(|pair| pair[0] < pair[1]), "{by_one:?}");
    let said = succeed(dir, &format!("{train} --features b1 --other-drive"));
    assert!(said.contains("that of another drive") && said.contains(": 6 drives, "), "{said}");
    let output = run(dir, &format!("{TRAIN} --labels train/labels.csv --model n.bwm --other-drive"));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && error.contains("--group"), "{error}");
}

/// The current sensor's gain rises by 3 % from run to run.
#[test]
fn a_drift_over_the_runs_is_told() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 24 --seed 19 --out train");
    add_runs(dir, "train");
    let labels = std::fs::read_to_string(dir.join("train/labels.csv")).expect("labels");
    for (k, line) in labels.lines().skip(1).enumerate() {
        let path = dir.join("train").join(line.split(',').next().expect("a name"));
        let gain = 1.0 + 0.03 * (k / 4) as f64;
        rewrite_column(&path, &path, "current_a", |cell| (gain * cell.parse::<f64>().expect("a number")).to_string());
    }
    let train = format!("{TRAIN} --labels train/labels.csv --model m.bwm --group run --features b1 --false-alarm 0.05");
    let said = succeed(dir, &train);
    assert!(said.contains(" The runs drift: b1 by ") && said.contains("train again before"), "{said}");
    let steady = succeed(dir, &train.replace("--group run ", "--group none "));
    assert!(!steady.contains("drift"), "{steady}");
    // The column of the labels is found without its name.
    let output = run(dir, &train.replace("--group run ", ""));
    assert!(String::from_utf8_lossy(&output.stdout).contains(" The runs drift: b1 by "));
    let warned = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(warned.contains("healthy traces with the same run are alike"), "{warned}");
}
