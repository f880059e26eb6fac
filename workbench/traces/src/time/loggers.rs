//! Times as loggers write them, each with the rate that it means.

use model::audit::times::Times;

use crate::reader::of_content;

/// Rows of each file.
const ROWS: u64 = 400;

/// The time of the day of a row, ms, from just before midnight on.
fn clock(k: u64) -> (u64, u64, u64, u64) {
    let ms = 86_399_900 + k;
    let of_day = ms % 86_400_000;
    (of_day / 3_600_000, of_day / 60_000 % 60, of_day / 1000 % 60, of_day % 1000)
}

/// The day of a row: the 26th, and the 27th behind midnight.
fn day(k: u64) -> u64 {
    26 + (86_399_900 + k) / 86_400_000
}

type Row = fn(u64) -> String;

const CASES: [(&str, Row, Option<f64>); 20] = [
    ("timestamp", |k| (1_764_200_000_000 + 2 * k).to_string(), Some(500.0)),
    ("time", |k| (1_764_200_000_000_000 + 50 * k).to_string(), Some(20_000.0)),
    ("%time", |k| (1_764_200_000_000_000_000 + 100_000 * k).to_string(), Some(10_000.0)),
    ("ms_today", |k| (40_000_000 + 4 * k).to_string(), Some(250.0)),
    ("Time (ms)", |k| format!("{:.1}", 0.5 * k as f64), Some(2000.0)),
    ("Elapsed Time [s]", |k| format!("{:.3}", k as f64 / 1e3), Some(1000.0)),
    ("t/ms", |k| (2 * k).to_string(), Some(500.0)),
    ("seconds", |k| format!("{:.3}", k as f64 / 1e3), Some(1000.0)),
    ("Time_sec", |k| format!("{:.6e}", k as f64 / 2e4), Some(20_000.0)),
    ("__time", |k| format!("{}.{:05}", 1_764_200_000 + 5 * k / 100_000, 5 * k % 100_000), Some(20_000.0)),
    ("log", |k| format!("2026-11-26T10:00:00.{:06}Z", 250 * k), Some(4000.0)),
    ("log", |k| format!("2026-11-26T10:00:00.{k:03}+01:00"), Some(1000.0)),
    (
        "Datum",
        |k| {
            let (h, m, s, ms) = clock(k);
            format!("{}.11.2026 {h:02}:{m:02}:{s:02}.{ms:03}", day(k))
        },
        Some(1000.0),
    ),
    (
        "Date Time",
        |k| {
            let (h, m, s, ms) = clock(k);
            format!("11/{}/2026 {h:02}:{m:02}:{s:02}.{ms:03}", day(k))
        },
        Some(1000.0),
    ),
    (
        "clock",
        |k| {
            let (h, m, s, ms) = clock(k);
            format!("{h:02}:{m:02}:{s:02}.{ms:03}")
        },
        Some(1000.0),
    ),
    ("timestamp", |k| ((4_294_960_000 + 250 * k) % (1 << 32)).to_string(), Some(4000.0)),
    ("time_ms", |k| ((65_400 + k) % 65_536).to_string(), Some(1000.0)),
    ("time_ms", |k| (2 * k / 3).to_string(), Some(1500.0)),
    // A temperature, and a count of rows.
    ("T", |k| format!("{}", 20 + k % 5), None),
    ("time", |k| k.to_string(), None),
];

#[test]
fn times_of_many_loggers_have_their_rate() {
    for (case, (name, row, rate_hz)) in CASES.iter().enumerate() {
        let rows: String = (0..ROWS).map(|k| format!("{},{}.5,{}\n", row(k), k % 7, 100 + k % 11)).collect();
        let read = of_content(&format!("{case}.csv"), &format!("{name},current_A,speed_rpm\n{rows}"), None);
        let (names, read, _) = read.expect(name);
        let found = read.times_s.as_deref().and_then(Times::of).map(|times| times.rate_hz);
        let right = found.zip(*rate_hz).map_or(found == *rate_hz, |(found, rate)| (found / rate - 1.0).abs() < 2e-5);
        assert!(right, "{case} {name}: {found:?} for {rate_hz:?}");
        let current = names.iter().position(|name| name == "current_A").expect("a column");
        assert_eq!(read.columns[current].len() as u64, ROWS, "{name}");
    }
}

/// A time beside each channel is one time where all are the same, and refused where they are not.
#[test]
fn times_beside_each_channel_are_one() {
    let twincat = "Name;Project\nFile;C:\\a.tcscope\n\nName;Axis.Current;Name;Axis.Speed\n\
                   SymbolBased;True;SymbolBased;True\nSampleTime[ms];0.5;SampleTime[ms];0.5\n\n";
    for (head, names) in [
        (twincat, ["Axis.Current", "Axis.Speed"]),
        ("Time [ms];I;Time [ms];n\n", ["I", "n"]),
        ("time_ms;I;time_ms.1;n\n", ["I", "n"]),
    ] {
        let cell = |k: u64| k as f64 * 0.5;
        let rows: String =
            (0..ROWS).map(|k| format!("{};{}.5;{};{}\n", cell(k), k % 7, cell(k), 100 + k % 11)).collect();
        let read = |rows: &str| of_content("a.csv", &format!("{head}{rows}"), None);
        let (own, found, told) = read(&rows).expect(head);
        assert_eq!(own, names, "{head}");
        let rate = found.times_s.as_deref().and_then(Times::of).expect("a time").rate_hz;
        assert!((rate / 2000.0 - 1.0).abs() < 2e-5, "{head}: {rate}");
        assert!(
            told.iter().any(|note| note.contains("column 3") && note.contains("the same time as column 1")),
            "{told:?}"
        );
        // In the first rows, and far behind them.
        for row in [1, ROWS - 2] {
            let late = format!("{};{}.5;{};", cell(row), row % 7, cell(row));
            let other = rows.replacen(&late, &format!("{};{}.5;{};", cell(row), row % 7, cell(row) + 0.25), 1);
            let refused = read(&other).map(drop).expect_err(head).to_string();
            assert!(refused.contains("this channel has times of its own"), "{refused}");
        }
    }
}
