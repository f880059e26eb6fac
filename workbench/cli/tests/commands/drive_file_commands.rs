//! Command-line tests of drive files: written by `init` and `--save`, taken by every command.

use serde_json::Value;

use super::common::{refuse, run, succeed};
use crate::form::{fit, schema};

const FLAGS: &str = "--y current_a --u1 velocity_ref_rad_s-velocity_rad_s --u2 load_torque_nm --order 2,2,2,1,1 \
    --features a,b --healthy healthy --false-alarm 0.05 --classes healthy,spall";

#[test]
fn a_file_stands_for_its_options() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 12 --seed 5 --out runs");
    let first = succeed(dir, &format!("train --labels runs/labels.csv {FLAGS} --model flags.bwm --save drive.toml"));
    let saved = std::fs::read_to_string(dir.join("drive.toml")).expect("saved");
    for line in ["labels = \"runs/labels.csv\"", "features = [\"a\", \"b\"]", "false_alarm = 0.05", "[channels]"] {
        assert!(saved.contains(line), "{line} in {saved}");
    }
    let again = succeed(dir, "train drive.toml --model file.bwm --report page.html");
    assert_eq!(again.lines().count(), first.lines().count());
    let page = std::fs::read_to_string(dir.join("page.html")).expect("a page");
    assert!(page.contains("<h2>Drive file</h2>") && page.contains("false_alarm = 0.05"));
    // The model carries the text of the file that is saved, and is the same if it is trained by it.
    let bytes = |name: &str| std::fs::read(dir.join(name)).expect("a model");
    let (flags, file) = (bytes("flags.bwm"), bytes("file.bwm"));
    assert!(flags == file && String::from_utf8_lossy(&file).contains("[channels]"));
    let estimates = succeed(dir, "identify drive.toml runs/healthy_5_000.csv");
    assert!(estimates.contains("healthy_5_000") && !estimates.contains("spall"), "traces of the command line go first");
    assert!(succeed(dir, "evaluate drive.toml --model file.bwm").contains("healthy"));
    // An option of the command line goes first.
    succeed(dir, "train drive.toml --features a --model one.bwm --json --save other.toml");
    let other = std::fs::read_to_string(dir.join("other.toml")).expect("saved");
    assert!(other.contains("features = [\"a\"]") && other.contains("order = \"2,2,2,1,1\""), "{other}");
}

#[test]
fn problems_name_file_line_and_key() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let write = |text: &str| std::fs::write(dir.join("d.toml"), text).expect("writable");
    write("[data]\nlabel = \"labels.csv\"\n");
    refuse(dir, "train d.toml --model m.bwm", &["d.toml, line 2: there is no key label; did you mean labels?"]);
    write("[model]\noffset = 3\n");
    refuse(dir, "train d.toml --model m.bwm", &["d.toml, line 2: offset is true or false"]);
    write("[model]\norder = [2, 2\n");
    refuse(dir, "train d.toml --model m.bwm", &["d.toml, line "]);
    refuse(dir, "train missing.toml --model m.bwm", &["missing.toml: No such file"]);
    write("[channels]\ny = \"i\"\n");
    refuse(dir, "train d.toml --model m.bwm", &["--labels"]);
}

#[test]
fn init_describes_what_it_sees() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 12 --seed 6 --out runs");
    let told = succeed(dir, "init runs");
    assert!(told.contains("runs/drive.toml: 24 files; current current_a, velocity velocity_rad_s"), "{told}");
    let text = std::fs::read_to_string(dir.join("runs/drive.toml")).expect("written");
    for line in ["traces = [\".\"]", "labels = \"labels.csv\"", "healthy = \"healthy\"", "u2 = \"load_torque_nm\""] {
        assert!(text.contains(&format!("\n{line}\n")), "{line} in {text}");
    }
    // Ready to train, without any other option.
    succeed(dir, "train runs/drive.toml --model m.bwm");
    succeed(dir, "evaluate runs/drive.toml --model m.bwm --json");
    refuse(dir, "init runs", &["runs/drive.toml exists"]);
    succeed(dir, "init runs --force");
    std::fs::create_dir(dir.join("empty")).expect("a folder");
    refuse(dir, "init empty", &["no recording can be read in empty: no file of a known format"]);
}

#[test]
fn names_of_files_become_labels() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 12 --seed 9 --out runs");
    std::fs::remove_file(dir.join("runs/labels.csv")).expect("labels");
    succeed(dir, "init runs --labels-from-names classes.csv --out drive.toml");
    let labels = std::fs::read_to_string(dir.join("classes.csv")).expect("written");
    assert!(labels.contains("healthy_9_000,healthy,9,000\n") && labels.contains(",spall,9,"), "{labels}");
    succeed(dir, "train drive.toml --model m.bwm");
    // Without an option, labels.csv beside the drive file.
    let told = succeed(dir, "init runs");
    assert!(told.contains("runs/labels.csv: classes by the names of the files"), "{told}");
    succeed(dir, "train runs/drive.toml --model m.bwm");
}

/// One long recording without a class is cut into segments for training, and segments that differ from it are novel.
#[test]
fn a_single_recording_is_a_reference_and_is_cut() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,roughness --count 9 --seed 13 --out runs");
    let read = |name: String| std::fs::read_to_string(dir.join("runs").join(name)).expect("a trace");
    let join = |class: &str| {
        let mut text = String::new();
        for k in 0..9 {
            let trace = read(format!("{class}_13_00{k}.csv"));
            let (head, rows) = trace.split_once('\n').expect("a heading");
            let own = if k == 0 { format!("{head}\n{rows}") } else { rows.to_string() };
            text += &own;
        }
        // The time starts again in each trace.
        let cell = |line: &str| line.split_once(',').map_or(String::new(), |(_, rest)| format!("{rest}\n"));
        text.lines().map(cell).collect::<String>()
    };
    std::fs::create_dir(dir.join("one")).expect("a folder");
    std::fs::write(dir.join("one/recording.csv"), join("healthy")).expect("written");
    std::fs::write(dir.join("rough.csv"), join("roughness")).expect("written");
    let told = succeed(dir, "init one --rate-hz 500");
    assert!(told.contains("all are called reference. Which recordings are healthy?"), "{told}");
    let text = std::fs::read_to_string(dir.join("one/drive.toml")).expect("written");
    assert!(
        text.contains("\nsegment = 1125  # samples: 40 segments") && text.contains("healthy = \"reference\""),
        "{text}"
    );
    succeed(dir, "train one/drive.toml --model m.bwm");
    let novel = |file: &str| {
        let json: serde_json::Value =
            serde_json::from_str(&succeed(dir, &format!("replay --model m.bwm {file} --json"))).expect("JSON");
        let segments = json.as_array().expect("a list").clone();
        let novel = segments.iter().filter(|segment| segment["verdict"] == "novel").count();
        novel as f64 / segments.len() as f64
    };
    let (own, rough) = (novel("one/recording.csv"), novel("rough.csv"));
    assert!(own < 0.1 && rough > 0.5, "{own} {rough}");
}

#[test]
fn init_offers_no_gate_that_so_few_runs_do_not_support() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 12 --seed 8 --out runs");
    let labels = std::fs::read_to_string(dir.join("runs/labels.csv")).expect("labels");
    let with_run =
        |(k, line): (usize, &str)| if k == 0 { format!("{line},run\n") } else { format!("{line},{}\n", k % 4) };
    std::fs::write(dir.join("runs/labels.csv"), labels.lines().enumerate().map(with_run).collect::<String>())
        .expect("written");
    succeed(dir, "init runs");
    let text = std::fs::read_to_string(dir.join("runs/drive.toml")).expect("written");
    assert!(text.contains("\ngroup = \"run\"\n"), "{text}");
    assert!(
        text.contains("# healthy = \"healthy\"  # 4 runs support no false-alarm rate of 0.01 with 7 features")
            && text.contains("\nnovelty = \"none\""),
        "{text}"
    );
    succeed(dir, "train runs/drive.toml --model m.bwm");
    succeed(dir, "evaluate runs/drive.toml --model m.bwm");
}

#[test]
fn a_single_input_needs_no_second_one() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 2 --seed 7 --out runs");
    let channels = "--y current_a --u1 velocity_ref_rad_s";
    let file = "runs/healthy_7_000.csv";
    assert!(succeed(dir, &format!("identify {file} {channels} --order 2,2,0,1,0")).contains("healthy_7_000"));
    assert!(succeed(dir, &format!("validate {file} {channels} --order 2,2,0,1,0")).contains("healthy_7_000"));
    let search = format!("structure {file} runs/healthy_7_001.csv {channels} --max 3,3,0,1,0");
    assert!(succeed(dir, &search).contains("best fit     1,2,0,1,0"));
    refuse(dir, &format!("identify {file} {channels} --order 2,2,1,1,1"), &["1 terms of a second input; give --u2"]);
}

/// So few runs get the recipe that training chooses, which finds a spall where means and rms do not.
#[test]
fn a_few_healthy_runs_keep_the_usual_recipe() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy --count 16 --seed 5 --mix --angle-bits 16 --out all");
    succeed(dir, "simulate --class spall --count 5 --seed 9 --mix --angle-bits 16 --out spall");
    std::fs::create_dir_all(dir.join("runs")).expect("writable");
    for k in 0..16 {
        let name = format!("runs/gesund_Lauf{:02}_{}.csv", k / 2 + 1, k % 2 + 1);
        std::fs::copy(dir.join(format!("all/healthy_mix_5_{k:03}.csv")), dir.join(name)).expect("a copy");
    }
    succeed(dir, "init runs");
    let file = std::fs::read_to_string(dir.join("runs/drive.toml")).expect("a drive file");
    assert!(!file.contains("\nfeatures = ") && file.contains("healthy = \"gesund\""), "{file}");
    assert!(file.contains("group = \"run\""), "{file}");
    // Without a bearing eight runs support a gate of few features, and with one its orders.
    succeed(dir, "train runs/drive.toml --model few.bwm");
    succeed(dir, "train runs/drive.toml --bearing 9,3,17,10 --model m.bwm");
    let told = succeed(dir, "replay --model m.bwm spall");
    assert_eq!(told.matches("  novel  ").count(), 5, "{told}");
}

#[test]
fn init_prints_columns_and_questions() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let json = |text: &str| serde_json::from_str::<Value>(text).expect("JSON");
    succeed(dir, "simulate --class healthy,spall --count 12 --seed 6 --out runs");
    let all = json(&succeed(dir, "init runs --json"));
    fit(&schema("init"), &all);
    assert_eq!((all["classes"][0].as_str(), all["classes"][1].as_str()), (Some("healthy"), Some("spall")));
    assert_eq!((all["files"].as_u64(), all["rows"].as_u64(), &all["refused"]), (Some(24), Some(5000), &Value::Null));
    let named = |name: &str| all["columns"].as_array().expect("columns").iter().find(|own| own["name"] == name);
    let current = named("current_a").expect("the current");
    assert_eq!((current["role"].as_str(), current["unit"].as_str()), (Some("current"), Some("A")));
    let course = current["course"].as_array().expect("a course");
    assert!((100..=120).contains(&course.len()) && course.iter().all(|part| part[0].as_f64() <= part[1].as_f64()));
    assert_eq!(all["questions"], Value::Array(vec![]));

    // Two motors that move, an angle whose unit nothing tells, no time, and no word of a class.
    let wave = |k: u32, f: f64| (f * f64::from(k)).sin();
    for file in 0..3 {
        let row =
            |k: u32| format!("{:.4},{:.4},{:.4},{:.4}\n", wave(k, 0.1), wave(k, 0.013), wave(k, 0.07), wave(k, 0.02));
        let text = "ax1_iq,ax1_pos,ax2_iq,ax2_pos\n".to_string() + &(file..2000 + file).map(row).collect::<String>();
        std::fs::create_dir_all(dir.join("two")).expect("a folder");
        std::fs::write(dir.join(format!("two/a{file}.csv")), text).expect("writable");
    }
    let output = run(dir, "init two --json");
    let all = json(&String::from_utf8_lossy(&output.stdout));
    let text = std::fs::read_to_string(dir.join("two/drive.toml")).expect("written");
    let questions = all["questions"].as_array().expect("questions");
    let axis = questions.iter().find(|own| own["answers"][1] == "2").expect("which axis");
    let marks =
        questions.iter().flat_map(|own| own["marks"].as_array().into_iter().flatten().filter_map(Value::as_str));
    assert!(marks.clone().any(|mark| mark == "ax?_iq") && axis["key"].is_null(), "{all:#}");
    assert!(marks.clone().filter(|mark| text.contains(mark)).count() > 0, "{text}");
    let keys: Vec<&str> = questions.iter().filter_map(|own| own["key"].as_str()).collect();
    assert_eq!(keys, ["rate_hz", "labels"]);
}
