//! Files as users have them, to the last bit of what SciPy and pandas read.

use std::path::PathBuf;

use host_tests::data;
use model::audit::orders;
use model::trace::{Channels, Trace};

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
