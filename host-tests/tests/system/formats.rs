//! Files as users have them, to the last bit of what SciPy and pandas read, and folders of files as loggers and
//! laboratories write them: `init` finds rate and classes and writes what training accepts, or it says why not.

use std::path::{Path, PathBuf};

use host_tests::data;
use model::audit::orders;
use model::session::{Log, Quiet};
use model::settings::Data;
use model::trace::{Channels, Trace};
use traces::audit::Audit;
use traces::describe::{Asked, describe};
use traces::reader::{Series, numeric, series};
use traces::table::Table;

/// Σ (2k + 1) bits of the k-th value, modulo 2⁶⁴.
fn sum(values: &[f64]) -> u64 {
    let each = values.iter().zip((1_u64..).step_by(2)).map(|(value, odd)| value.to_bits().wrapping_mul(odd));
    each.fold(0, u64::wrapping_add)
}

fn read(file: PathBuf, channels: Channels) -> Trace {
    let mut traces = traces::read(&[file], &channels).expect("readable");
    assert_eq!(traces.len(), 1);
    traces.remove(0)
}

/// The sums are those of `numpy.asarray(x, float64).view(uint64)`, read by `scipy.io.loadmat` and `pandas`.
#[test]
fn formats_have_the_bits_of_other_readers() {
    let Some(folder) = data("formats") else { return };
    let of = |trace: &Trace| [&trace.y, &trace.u1, &trace.u2].map(|column| (column.len(), sum(column)));
    // A "structure with time".
    let motor = read(folder.join("dc_motor_friction.mat"), Channels::new("Current", "Speed", "Acc"));
    let expected = [11_516_407_979_714_884_112, 2_614_148_536_188_654_795, 8_378_148_591_201_295_930];
    assert_eq!(of(&motor), expected.map(|sum| (45_001, sum)));
    assert!(motor.interval_s.is_some_and(|step| (step - 1e-3).abs() < 1e-9), "{:?}", motor.interval_s);
    // Vectors, and a number that is constant.
    let columns = Channels {
        further: vec!["X131RPM".into(), "X131RPM rpm".into()],
        ..Channels::new("X131_DE_time", "X131_FE_time", "X131_BA_time")
    };
    let error = traces::read(&[folder.join("bearing_or007.mat")], &columns).expect_err("no unit").to_string();
    assert!(error.contains("the column has no unit in its name"), "{error}");
    let columns = Channels { further: vec!["X131RPM".into()], ..columns };
    let bearing = read(folder.join("bearing_or007.mat"), columns);
    let expected = [11_923_617_988_682_794_158, 9_927_603_639_908_676_040, 9_263_534_697_975_228_852];
    assert_eq!(of(&bearing), expected.map(|sum| (122_426, sum)));
    assert!(bearing.further[0].iter().all(|rpm| rpm.to_bits() == 1773_f64.to_bits()));
    // Floating-point numbers, flags, whole numbers; the rows are not in the order of time.
    let columns = Channels { time: Some("none".into()), ..Channels::new("motor_iq_1", "motor_torque_6", "anomaly") };
    let robot = read(folder.join("robot_axis.parquet"), columns.clone());
    let expected = [13_639_749_436_165_849_088, 11_762_933_550_196_719_616, 10_304_235_947_423_694_848];
    assert_eq!(of(&robot), expected.map(|sum| (398, sum)));
    let by_time = Channels { time: None, ..columns };
    let error = traces::read(&[folder.join("robot_axis.parquet")], &by_time).expect_err("disorder").to_string();
    assert!(error.contains("row 101, column time: time runs backwards"), "{error}");
}

#[test]
fn logs_have_the_bits_of_pandas() {
    let Some(folder) = data("microchip_pmsm") else { return };
    let columns = Channels { rate_hz: Some(1919.0), ..Channels::new("IQ", "RPM", "integrate(RPM)") };
    let log = read(folder.join("normal_800_1.csv"), columns);
    assert_eq!((sum(&log.y), sum(&log.u1)), (16_372_906_814_049_615_872, 6_373_525_858_589_605_888));
    // Half a minute at 800 rpm; the trapezoidal rule by hand.
    let mut turns = 0.0;
    for (pair, found) in log.u1.windows(2).zip(log.u2.windows(2)) {
        turns += 0.5 * (pair[0] + pair[1]) / 1919.0;
        assert!((found[1] - turns).abs() < 1e-9 * turns);
    }
    let Some(folder) = data("moteus_dyno") else { return };
    let columns = Channels::new("vel1_rad_s", "iq1_A", "iq1_cmd_A");
    let log = read(folder.join("ex8__06_05_2021_17-22-41.csv"), columns);
    assert_eq!((log.y.len(), sum(&log.y)), (9247, 2_233_479_080_335_344_407));
}

/// The logger's maker says 2000 rows a second; the fifth order of the rotor says 1919.
#[test]
fn the_rotor_tells_the_rate_of_a_logger_and_an_unbalanced_load() {
    let Some(folder) = data("microchip_pmsm") else { return };
    let columns = Channels { rate_hz: Some(2000.0), ..Channels::new("IQ", "(RPM)rad/s", "RPM") };
    let logs = traces::read(&[folder], &columns).expect("readable");
    let pairs: Vec<(&[f64], &[f64])> = logs.iter().map(|log| (log.y.as_slice(), log.u1.as_slice())).collect();
    let (rate_hz, sharpness) = orders::rate(&pairs, 2000.0).expect("lines of the rotor");
    println!("{rate_hz:.1} rows a second, {sharpness:.0} times the power of other rates");
    // Two steps of the search.
    assert!((rate_hz / 1919.0 - 1.0).abs() < 5e-4, "{rate_hz}");
    let (mut normal, mut unbalanced) = (vec![], vec![]);
    for log in &logs {
        let angle = orders::angle(&log.u1, rate_hz);
        let ratio = orders::amplitude(&log.y, &angle, 1.0) / orders::floor(&log.y, &angle);
        let is_unbalanced = log.id.starts_with("unbalanced");
        if is_unbalanced { &mut unbalanced } else { &mut normal }.push(ratio);
    }
    let largest = normal.iter().copied().fold(0.0, f64::max);
    let least = unbalanced.iter().copied().fold(f64::INFINITY, f64::min);
    println!("order 1 over the floor: normal up to {largest:.1}, unbalanced from {least:.1}");
    assert!((normal.len(), unbalanced.len()) == (11, 11) && 5.0 * largest < least, "{normal:?} {unbalanced:?}");
}

/// This crate asks `serde_json` for all digits of numbers, as the Python package does; flattened fields then lose them.
#[test]
fn a_model_with_a_front_end_is_read_where_numbers_have_all_digits() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/support/actuator/model.bwm");
    let model = model::session::ModelFile::read(file.as_ref()).expect("readable");
    let front_end = model.channels().front_end.as_ref().expect("a front end");
    assert_eq!(front_end.control_rate_hz, 10_000.0);
}

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
