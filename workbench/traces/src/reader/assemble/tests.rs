use std::path::Path;
use std::sync::Arc;

use super::*;
use crate::table::{Table, write};
use crate::{read, reader};
use model::trace::{BREAK, Cells, LONGEST_GAP, Recorded, ShaftChannels};

const NAMES: [&str; 6] = ["t_s", "velocity_ref_rad_s", "velocity_rad_s", "current_a", "load_torque_nm", "angle_rad"];

fn channels() -> Channels {
    let shaft = Some(ShaftChannels::rig());
    Channels { shaft, ..Channels::new("current_a", "velocity_ref_rad_s-velocity_rad_s", "load_torque_nm") }
}

/// Numbers as of a recording, at 1 kHz.
fn recording(rows: usize) -> Vec<Vec<f64>> {
    let column = |k: usize, row: usize| match k {
        0 => row as f64 / 1000.0,
        5 => (0.05 * row as f64) % 6.0,
        _ => (row * (2 * k + 7) % 101) as f64 / 8.0,
    };
    (0..NAMES.len()).map(|k| (0..rows).map(|row| column(k, row)).collect()).collect()
}

/// The rows of which this is true.
fn only(columns: &[Vec<f64>], keep: impl Fn(usize) -> bool) -> Vec<Vec<f64>> {
    let each = |column: &Vec<f64>| (0..column.len()).filter(|row| keep(*row)).map(|row| column[row]).collect();
    columns.iter().map(each).collect()
}

/// Without numbers, but for the time, in the rows of which this is true.
fn emptied(columns: &[Vec<f64>], lost: impl Fn(usize) -> bool) -> Vec<Vec<f64>> {
    let mut columns = columns.to_vec();
    for column in &mut columns[1..] {
        column.iter_mut().enumerate().filter(|(row, _)| lost(*row)).for_each(|(_, x)| *x = f64::NAN);
    }
    columns
}

fn table(columns: &[Vec<f64>]) -> Table {
    let cells = NAMES.iter().zip(columns).map(|(name, own)| ((*name).to_string(), Cells::Numbers(own.clone())));
    Table::of(&Arc::new(Recorded::new("t", cells.collect()).expect("one length")))
}

fn trace(columns: &[Vec<f64>]) -> Trace {
    reader::read(&table(columns), &channels(), &|_| true).expect("a trace").remove(0)
}

/// All values of a trace as bits, and its interval.
fn bits(trace: &Trace) -> (Vec<Vec<u64>>, Option<u64>) {
    let motion = trace.motion.as_ref().expect("the shaft");
    let MotionTrace { current_a, velocity_rad_s, load_nm, angle_rad, .. } = motion;
    let all = [&trace.y, &trace.u1, &trace.u2, current_a, velocity_rad_s, load_nm, angle_rad];
    let of = |column: &&Vec<f64>| column.iter().map(|x| x.to_bits()).collect();
    (all.iter().map(of).collect(), trace.interval_s.map(f64::to_bits))
}

fn is_lost(row: usize) -> bool {
    row * 7919 % 5000 < 50 || (2000..2010).contains(&row)
}

#[test]
fn rows_that_are_dropped_and_rows_that_are_empty_give_the_same_trace() {
    let all = recording(5000);
    let (dropped, empty) = (trace(&only(&all, |row| !is_lost(row))), trace(&emptied(&all, is_lost)));
    assert_eq!(bits(&dropped), bits(&empty));
    let lost = (1..4999).filter(|row| is_lost(*row)).count();
    assert!(is_lost(0), "also a row at the end");
    assert_eq!((dropped.y.len(), dropped.irregular_steps), (4999, 0));
    assert_eq!(dropped.missing, Missing { samples: 4999, dropped: lost, ..Missing::default() });
    assert_eq!(empty.missing, Missing { samples: 5000, empty: lost + 1, ends: 1, ..Missing::default() });
    // Where nothing is missing, the samples are those of the whole recording.
    let whole = trace(&all);
    assert_eq!(whole.missing.count(), 0);
    for row in 1..5000 {
        let (one, other) = (dropped.y[row - 1], whole.y[row]);
        assert!(if is_lost(row) { one.is_nan() } else { one == other }, "{row}");
    }
}

#[test]
fn a_row_that_lacks_one_channel_keeps_the_others() {
    let mut columns = recording(100);
    columns[4][30] = f64::NAN;
    columns[2][40] = f64::INFINITY;
    let found = trace(&columns);
    let motion = found.motion.as_ref().expect("the shaft");
    assert!(found.u2[30].is_nan() && motion.load_nm[30].is_nan() && found.y[30].is_finite());
    assert!(found.u1[40].is_nan() && motion.velocity_rad_s[40].is_nan() && motion.current_a[40].is_finite());
    assert_eq!(found.missing, Missing { samples: 100, empty: 2, ..Missing::default() });
}

#[test]
fn a_row_without_its_time_is_missing_where_it_was() {
    let whole = recording(200);
    let mut columns = whole.clone();
    (columns[0][20], columns[0][21], columns[0][199]) = (f64::NAN, f64::NAN, f64::NAN);
    let found = trace(&columns);
    assert_eq!(bits(&found), bits(&trace(&only(&whole, |row| !matches!(row, 20 | 21 | 199)))));
    assert_eq!(found.missing, Missing { samples: 200, empty: 3, ends: 1, ..Missing::default() });
}

#[test]
fn a_pause_is_filled_up_to_its_limit_and_a_break_beyond() {
    let paused = |rows: usize| {
        let mut columns = recording(2000);
        columns[0].iter_mut().skip(900).for_each(|t| *t += rows as f64 / 1000.0);
        trace(&columns)
    };
    let (gap, long) = (paused(LONGEST_GAP), paused(LONGEST_GAP + 1));
    assert_eq!((gap.y.len(), gap.missing.dropped, gap.missing.breaks), (3000, 1000, 0));
    assert_eq!((long.y.len(), long.missing.dropped, long.missing.breaks), (2000 + BREAK, BREAK, 1));
    assert!(long.missing.to_string().contains("1 pause is a break of the recording"), "{}", long.missing);
    assert_eq!(long.irregular_steps, 0);
}

#[test]
fn without_a_time_only_empty_rows_are_missing() {
    let columns = only(&emptied(&recording(300), |row| row == 7), |row| row != 50);
    let of = Channels { time: Some(NO_TIME.into()), rate_hz: Some(1000.0), ..channels() };
    let found = reader::read(&table(&columns), &of, &|_| true).expect("a trace").remove(0);
    assert_eq!((found.y.len(), found.missing.count(), found.interval_s), (299, 1, Some(0.001)));
    assert!(found.y[7].is_nan() && found.y[6].is_finite());
}

#[test]
fn a_channel_without_a_number_is_refused_by_name() {
    let ids = Cells::Texts((0..6).map(|row| ["a", "b"][row / 3].to_string()).collect());
    let mut cells = vec![("trace".to_string(), ids)];
    for name in &NAMES {
        let own = (0..6).map(|row| if *name == "load_torque_nm" && row > 2 { f64::NAN } else { row as f64 });
        cells.push(((*name).to_string(), Cells::Numbers(own.collect())));
    }
    let table = Table::of(&Arc::new(Recorded::new("t", cells).expect("one length")));
    let problem = reader::read(&table, &channels(), &|_| true).expect_err("no load").to_string();
    assert!(problem.starts_with("trace b: channel load_torque_nm has no number in any row"), "{problem}");
    assert_eq!(reader::read(&table, &channels(), &|id| id == "a").expect("a alone").len(), 1);
}

#[test]
fn a_piece_has_a_sample_for_each_row() {
    let lost = |row: usize| !(3..=15).contains(&row) || row == 7;
    let mut columns = emptied(&recording(20), lost);
    columns[4] = vec![f64::NAN; 20];
    let cells = NAMES.iter().zip(&columns).map(|(name, own)| ((*name).to_string(), Cells::Numbers(own.clone())));
    let recorded = Arc::new(Recorded::new("t", cells.collect()).expect("one length"));
    let found = crate::read_piece(&recorded, &channels()).expect("a piece").remove(0);
    assert!((0..20).all(|row| found.y[row].is_nan() == lost(row) && found.u2[row].is_nan()));
}

fn of_file(path: &Path) -> Trace {
    read(&[path.to_path_buf()], &channels()).expect("a trace").remove(0)
}

#[test]
fn every_format_has_missing_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = NAMES.map(String::from);
    let columns = emptied(&recording(400), |row| row == 9 || row == 201);
    let expected = bits(&trace(&columns));
    for ending in ["csv", "tsv", "csv.gz", "csv.zst", "mat", "parquet", "arrow", "npz"] {
        let path = folder.path().join(format!("t.{ending}"));
        write(&path, &names, &columns).expect("written");
        let found = of_file(&path);
        assert_eq!((bits(&found), found.missing.count()), (expected.clone(), 2), "{ending}");
    }
}

#[test]
fn every_word_for_a_missing_value_is_a_missing_sample() {
    let folder = tempfile::tempdir().expect("a folder");
    let words =
        ["nan", "NaN", "-nan", "NA", "n/a", "null", "None", "inf", "-Infinity", "1.#QNAN", "", "-", "---", "#N/A"];
    for (separator, point, ending) in [(',', '.', "csv"), (';', ',', "csv"), ('\t', '.', "tsv"), (' ', '.', "txt")] {
        // Blanks hold no empty cell.
        for word in words.iter().filter(|word| separator != ' ' || !word.is_empty()) {
            let row = |k: usize| {
                let cell = if k == 5 { (*word).to_string() } else { format!("{k}{point}5") };
                [format!("{k}"), cell, format!("{}{point}25", k % 7), format!("{}", k % 3)].join(&separator.to_string())
            };
            let head = ["t_s", "i", "v", "load"].join(&separator.to_string());
            let text: Vec<String> = std::iter::once(head).chain((0..20).map(row)).collect();
            let path = folder.path().join(format!("t.{ending}"));
            std::fs::write(&path, text.join("\n")).expect("writable");
            let found = read(&[path], &Channels::new("i", "v", "load")).expect("a trace").remove(0);
            let missing: Vec<usize> = (0..20).filter(|row| found.y[*row].is_nan()).collect();
            assert_eq!(missing, [5], "{separator:?} {word:?}");
            assert_eq!((found.y[6], found.u1[5], found.missing.count()), (6.5, 5.25, 1));
        }
    }
}

#[test]
fn truth_values_are_one_and_zero() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.csv");
    let rows: String = (0..20).map(|k| format!("{k},{k}.5,{},{}\n", k % 2 == 0, k % 3)).collect();
    std::fs::write(&path, format!("t_s,i,brake,load\n{rows}")).expect("writable");
    let trace = read(&[path], &Channels::new("i", "brake", "load")).expect("a trace").remove(0);
    assert_eq!(trace.u1[..3], [1.0, 0.0, 1.0]);
}
