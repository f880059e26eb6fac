//! Folders as loggers and laboratories leave them: what `init` writes is what `train` accepts, or it is refused with a
//! reason.

use std::fmt::Write as _;
use std::path::Path;

use crate::common::{run, succeed};

/// A way to write the same recordings.
struct Way {
    separator: char,
    decimal_comma: bool,
    /// Lines before the header, and whether units have a line of their own.
    before: &'static str,
    units: bool,
    /// The time of a row at 1000 rows a second.
    time: (&'static str, fn(usize) -> String),
    end: &'static str,
}

/// The usual way; the others differ in a few things.
const USUAL: Way =
    Way { separator: ',', decimal_comma: false, before: "", units: false, time: ("t_s", plain), end: "" };

const WAYS: [Way; 8] = [
    USUAL,
    Way { separator: ';', decimal_comma: true, time: ("Zeit [s]", comma), ..USUAL },
    Way { separator: ';', units: true, time: ("Time", plain), ..USUAL },
    Way {
        separator: '\t',
        before: "Logger\t7\nOperator\tJ. Doe\tBay 4\n\n",
        time: ("time_us", |k| (4_294_000_000_u64 + 1000 * k as u64).rem_euclid(1 << 32).to_string()),
        ..USUAL
    },
    Way { time: ("timestamp", |k| format!("2026-11-26 00:00:{:02}.{:03}", k / 1000, k % 1000)), ..USUAL },
    Way { time: ("time", |k| format!("{}.{:03}", 1_764_200_000 + k / 1000, k % 1000)), end: "9.99,1", ..USUAL },
    Way {
        separator: ';',
        decimal_comma: true,
        time: ("Datum", |k| format!("26.11.2026 08:17:{:02},{:03}", k / 1000, k % 1000)),
        ..USUAL
    },
    Way { time: ("timestamp", |k| (77_000_000 + 1000 * k).to_string()), ..USUAL },
];

fn plain(k: usize) -> String {
    format!("{}.{:03}", k / 1000, k % 1000)
}

fn comma(k: usize) -> String {
    plain(k).replace('.', ",")
}

/// Rows of a current and a speed that answers it, different in each recording.
fn text(way: &Way, seed: usize, pole: f64) -> String {
    let Way { separator: s, decimal_comma, before, units, time: (time, of_row), end } = way;
    let mut text = String::from(*before);
    let names = if *units { ["Current", "Speed"] } else { ["current_A", "speed_rpm"] };
    let _never_fails = writeln!(text, "{time}{s}{}{s}{}", names[0], names[1]);
    if *units {
        let _never_fails = writeln!(text, "[s]{s}[A]{s}[rpm]");
    }
    let (mut state, mut speed) = (seed as u64 * 7919 + 1, 0.0);
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(u32::MAX >> 1) - 0.5
    };
    for k in 0..1500 {
        let current = (k as f64 * 0.037).sin() + noise();
        speed = pole * speed + 3.0 * current;
        let cells = [current, speed + noise()].map(|x| format!("{x:.6}"));
        let cells = if *decimal_comma { cells.map(|cell| cell.replace('.', ",")) } else { cells };
        let _never_fails = writeln!(text, "{}{s}{}{s}{}", of_row(k), cells[0], cells[1]);
    }
    text + end
}

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    std::fs::write(path, text).expect("writable");
}

#[test]
fn what_init_writes_is_what_train_accepts() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for (k, way) in WAYS.iter().enumerate() {
        let name = format!("way{k}");
        for record in 0..12 {
            write(&dir.join(&name), &format!("rec_{record:02}.csv"), &text(way, record, 0.95));
        }
        let told = succeed(dir, &format!("init {name}"));
        assert!(told.contains("12 files"), "{told}");
        let file = std::fs::read_to_string(dir.join(&name).join("drive.toml")).expect("written");
        // 1000 rows a second to 2e-5, as the first and the last row tell.
        let rate = file.split(" rows in the first, ").nth(1).and_then(|rest| rest.split(' ').next());
        let rate: f64 = rate.and_then(|rate| rate.parse().ok()).unwrap_or_else(|| panic!("{name}: {file}"));
        assert!((rate / 1000.0 - 1.0).abs() < 2e-5, "{name}: {rate}");
        succeed(dir, &format!("train {name}/drive.toml --model m.bwm"));
    }
}

#[test]
fn folders_are_classes_and_one_bad_file_takes_nothing_from_others() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for record in 0..12 {
        write(dir, &format!("bench/healthy/rec{record}.csv"), &text(&USUAL, record, 0.95));
        let slower = text(&USUAL, 100 + record, 0.8);
        write(dir, &format!("bench/inner race fault of the drive side/rec{record}.csv"), &slower);
    }
    let good = text(&USUAL, 5, 0.95);
    write(dir, "bench/healthy/garbage.csv", &good.replace("\n0.700,", "\n0.700,1e306,"));
    let output = run(dir, "init bench");
    let said = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("24 files") && said.contains("classes by the folders"), "{said}");
    assert!(said.contains("garbage.csv: line 702: 4 cells where the header has 3"), "{said}");
    let trained = succeed(dir, "train bench/drive.toml --model m.bwm");
    assert!(trained.contains("12 healthy, 12 inner race fault of the drive side"), "{trained}");
}

#[test]
fn the_traces_of_one_table_are_labelled() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let mut all = String::from("trace,t_s,current_A,speed_rpm\n");
    for record in 0..8 {
        for (class, pole) in [("normal", 0.95), ("outer", 0.8)] {
            let recording = text(&USUAL, record, pole);
            recording.lines().skip(1).for_each(|line| all += &format!("{class}_{record},{line}\n"));
        }
    }
    write(dir, "table/all.csv", &all);
    let told = succeed(dir, "init table");
    assert!(told.contains("classes by the names"), "{told}");
    let labels = std::fs::read_to_string(dir.join("table/labels.csv")).expect("written");
    assert!(labels.contains("normal_7,normal,7\n") && labels.contains("outer_0,outer,0\n"), "{labels}");
    assert!(succeed(dir, "train table/drive.toml --model m.bwm").contains("8 normal, 8 outer"));
}

#[test]
fn what_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let refused = |name: &str, text: &str, why: &str| {
        write(dir, &format!("{name}/a.csv"), text);
        let output = run(dir, &format!("init {name}"));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(why), "{name}: {said}");
    };
    let rows = text(&USUAL, 1, 0.95);
    refused("twice", &format!("{rows}{rows}"), "line 1502, column current_A: the header comes again");
    refused("complex", "3.9+4.1i\n3.8+4.2i\n3.7-1e-3i\n", "is a complex number");
    let thousands = "t_s;n\n0,5;2.000\n0,6;3.000\n0,7;4.000\n";
    refused("thousands", thousands, "\"2.000\" is not a number; --decimal point or comma tells");
    refused("junk", &"\u{1}\u{2}\u{3}x\n".repeat(1000), "no text; save the recording as CSV, MATLAB or Parquet");
}

/// What guessing cannot know is given, written into the drive file, and kept in the model.
#[test]
fn the_layout_of_a_text_is_given_where_guessing_fails() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for seed in 1..=6 {
        for (class, pole) in [("normal", 0.9), ("outer", 0.5)] {
            // Counts that look like rows, units that are no units, a separator of its own.
            let rows = text(&USUAL, seed, pole).replace(',', "~").replacen('\n', "\np.u.~n.a.~n.a.\n", 1);
            write(dir, &format!("runs/{class}_{seed}.txt"), &format!("1~2~3\n4~5~6\n7~8~9\n{rows}"));
        }
    }
    let given = "--skip 3 --units-row --separator ~ --decimal point";
    succeed(dir, &format!("init runs {given}"));
    let file = std::fs::read_to_string(dir.join("runs/drive.toml")).expect("drive file");
    for line in ["skip = 3", "units_row = true", "separator = \"~\"", "decimal = \"point\"", "u1 = \"current_A\""] {
        assert!(file.contains(line), "{line} in {file}");
    }
    assert!(succeed(dir, "train runs/drive.toml --model m.bwm").contains("6 normal, 6 outer"));
    succeed(dir, "evaluate --no-drive --model m.bwm --labels runs/labels.csv");
    assert!(succeed(dir, &format!("audit runs {given} --no-drive")).contains("1000.000"));
    succeed(dir, &format!("convert runs/normal_1.txt {given} --no-drive --out a.csv"));
    let columns = std::fs::read_to_string(dir.join("a.csv")).expect("a.csv");
    assert!(columns.starts_with("t_s,current_A,speed_rpm\n"), "{}", &columns[..60]);
    let wrong = run(dir, "audit runs --separator 7");
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("separates no cells"));
}

/// A current that a slow bus holds is named with its rate, and no model is made of it.
#[test]
fn a_current_that_is_held_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    for seed in 1..=4 {
        for (class, pole) in [("normal", 0.95), ("outer", 0.5)] {
            let all = text(&USUAL, seed, pole);
            let rows: Vec<Vec<&str>> = all.lines().skip(1).map(|line| line.split(',').collect()).collect();
            let held = |k: usize| format!("{},{},{}\n", rows[k][0], rows[k / 44 * 44][1], rows[k][2]);
            let rows: String = (0..rows.len()).map(held).collect();
            write(dir, &format!("{class}_{seed}.csv"), &format!("t_s,current_A,speed_rpm\n{rows}"));
        }
    }
    let said = String::from_utf8_lossy(&run(dir, "audit .").stdout).into_owned();
    assert!(said.contains("the current changes every 44 rows only, 22.7273 times a second: no verdict"), "{said}");
    let refused = run(dir, "init .");
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && said.contains("no verdict on a bearing is possible"), "{said}");
    let refused = run(dir, "train drive.toml --model m.bwm");
    assert!(String::from_utf8_lossy(&refused.stderr).contains("changes every 44 rows only"));
}
