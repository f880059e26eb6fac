//! Folders of files as loggers and laboratories write them: `init` finds rate and classes and writes what training
//! accepts, or it says why not.

use std::path::{Path, PathBuf};

use host_tests::data;
use model::session::{Log, Quiet};
use model::settings::Data;
use traces::audit::Audit;
use traces::describe::{Asked, describe};
use traces::reader::{Series, numeric, series};
use traces::table::Table;

/// What a folder has to give.
enum Right {
    /// Rows a second, and a part of what the drive file or the labels say.
    Rate(f64, &'static str),
    /// The words of the refusal.
    Refused(&'static str),
}
use Right::{Rate, Refused};

const KINDS: [(&str, Right); 26] = [
    ("class_folders", Rate(4000.0, "inner_race_fault/rec2,inner_race_fault")),
    ("cobot_semicolon_decimal_comma", Rate(0.99, "Speed_J5")),
    ("complex_no_header", Refused("is a complex number")),
    ("decimal_comma_2", Rate(1000.0, "strom_A, drehzahl_rpm")),
    ("decimal_comma_dotted_date", Rate(1000.0, "strom_A, drehzahl_rpm")),
    ("epoch_nanoseconds", Rate(4000.0, "current_a")),
    ("epoch_seconds_20khz", Rate(20_000.0, "current_a")),
    ("header_repeated", Refused("line 303, column")),
    ("integer_microseconds", Rate(4000.0, "current_a")),
    ("iso_time", Rate(2000.0, "current_a")),
    ("matlab_table", Refused("save it with table2struct or parquetwrite")),
    ("microseconds_wrap_32_bit", Rate(4000.0, "current_a")),
    ("one_record_a_class", Rate(4000.0, "outer_0.7_100watt_1,outer")),
    ("parquet_category", Rate(2000.0, "run_2,reference")),
    ("parquet_duration", Rate(2000.0, "current_a")),
    ("parquet_float16", Rate(2000.0, "current_a")),
    ("parquet_int96", Rate(2000.0, "current_a")),
    ("parquet_text_time", Rate(2000.0, "current_a")),
    ("parquet_timestamp_us", Rate(2000.0, "current_a")),
    ("plotjuggler", Rate(4000.0, "/joint_states/j1/velocity")),
    ("preamble_key_value", Rate(2000.0, "c2, c3, c4")),
    ("preamble_semicolon", Rate(100_000.0, "CH1(V)")),
    ("robot_joint", Rate(100.0, "is no measured value")),
    ("scipy_mat", Rate(500.0, "current_a")),
    ("units_and_increment_row", Rate(500_000.0, "CH1 [V], CH2 [V]")),
    ("units_row", Rate(1000.0, "Current [A], Speed [rpm]")),
];

fn copied(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        let target = to.join(entry.file_name().expect("a name"));
        if entry.is_dir() {
            copied(&entry, &target);
        } else {
            std::fs::write(&target, std::fs::read(&entry).expect("readable")).expect("writable");
        }
    }
}

#[test]
fn files_of_laboratories_train_or_are_refused_with_the_reason() {
    let Some(files) = data("lab_files") else { return };
    let copies = tempfile::tempdir().expect("a folder");
    for (name, right) in &KINDS {
        let folder = copies.path().join(name);
        copied(&files.join(name), &folder);
        let data = Data { traces: vec![folder.clone()], ..Data::default() };
        let asked =
            Asked { data: &data, labels: None, labels_from_names: None, out: None, front_end: None, force: false };
        // It tries training itself, and is an error where training refuses.
        let described = describe(&asked, &Log::new(&Quiet));
        match (right, described) {
            (Rate(rate_hz, says), Ok(described)) => {
                let labels = std::fs::read_to_string(folder.join("labels.csv")).expect("labels");
                let text = std::fs::read_to_string(&described.file).expect("a drive file") + &labels;
                assert!(text.contains(says), "{name}: {text}");
                assert!(
                    !labels.contains(",healthy") || text.contains("healthy_") || *name == "class_folders",
                    "{name}"
                );
                let told = text.split(" rows in the first, ").nth(1).and_then(|rest| rest.split(' ').next());
                let told: f64 = told.and_then(|told| told.parse().ok()).unwrap_or_else(|| panic!("{name}: {text}"));
                // The rate of irregular times is known to about a hundredth.
                let part = if matches!(*name, "cobot_semicolon_decimal_comma" | "robot_joint") { 0.03 } else { 2e-5 };
                assert!((told / rate_hz - 1.0).abs() < part, "{name}: {told} for {rate_hz}");
            }
            (Refused(words), Err(error)) => assert!(error.to_string().contains(words), "{name}: {error}"),
            (_, other) => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn faults_of_the_angle_are_found_in_recordings() {
    let Some(files) = data("lab_files/angle_faults") else { return };
    let findings_of = |name: &str| -> String {
        let file: PathBuf = files.join(format!("{name}.csv"));
        let (audit, log) = (Audit::usual(&file), Log::new(&Quiet));
        let outcome = audit.listing(&log).and_then(|files| audit.audit(&files, &log)).expect(name);
        outcome.findings.iter().map(|finding| format!("{}\n", finding.what)).collect()
    };
    for (name, words) in [
        ("low_passed_across_the_wrap", "low-passed or averaged across its wrap at 10 rows"),
        ("runs_backwards_for_a_sample", "runs backwards for a sample at"),
        ("sine_cosine_8_degrees_off", "8.0° off 90°"),
        ("velocity_of_a_coarse_encoder", "steps of 2.6180 rad/s, one count of the angle a row"),
        ("sentinel_speed", "10980.66"),
    ] {
        let findings = findings_of(name);
        assert!(findings.contains(words), "{name}: {findings}");
        assert!(findings.lines().count() <= 2, "{name}: {findings}");
    }
}

/// The names of the columns of numbers of a reported file, and its only trace.
fn reported(path: &Path) -> (Vec<String>, Series) {
    let table = Table::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let (names, _) = numeric(&table, None).expect("columns");
    let mut all = series(&table, (None, None), &names).expect("rows");
    assert_eq!(all.len(), 1, "{}", path.display());
    (names, all.remove(0))
}

#[test]
fn reported_files_have_their_columns_and_rows() {
    let Some(files) = data("field_reports") else { return };
    for (file, columns, rows, last_s) in [
        ("twincat_grouped/real_grouped_decimal_comma.csv", 21, 631, Some(0.126)),
        ("twincat_grouped/real_pairs_one_rate_semicolon.csv", 19, 377, Some(0.376)),
        ("odrive_characterization/chirp1.csv", 4, 387, None),
        ("quoted_newline/m.csv", 2, 99, Some(0.049)),
        ("octave_text/m.txt", 2, 400, Some(0.399)),
    ] {
        let (names, series) = reported(&files.join(file));
        assert_eq!((names.len(), series.columns[0].len()), (columns, rows), "{file}: {names:?}");
        let last = series.times_s.as_ref().and_then(|times| times.last().copied());
        assert!(last.zip(last_s).map_or(last == last_s, |(own, told)| (own - told).abs() < 1e-9), "{file}: {last:?}");
    }
}

#[test]
fn reported_files_have_their_rate() {
    let Some(files) = data("field_reports") else { return };
    for (file, expected) in [
        ("preamble_abtastrate_comma_khz/m.csv", 12_500.0),
        ("preamble_de_thousand/m.csv", 8000.0),
        ("preamble_delta_x/m.csv", 8000.0),
        ("preamble_downs/m.csv", 2000.0),
        ("preamble_elmo_usec/EASII_rec.csv", 10_000.0),
        ("lvm/run2_8kHz.lvm", 8000.0),
        ("rate_of_rounded_times/m.csv", 8192.0),
    ] {
        let (names, series) = reported(&files.join(file));
        let times_s = series.times_s.unwrap_or_else(|| panic!("{file}: no times"));
        let rate = (times_s.len() - 1) as f64 / (times_s[times_s.len() - 1] - times_s[0]);
        assert!((rate / expected - 1.0).abs() < 1e-6, "{file}: {rate}");
        assert!(!file.ends_with("lvm") || names == ["Current [A]", "Velocity [rad/s]", "Position [rad]"], "{names:?}");
    }
}
