//! The front end over recordings: what its file refuses, and what it makes of rows with a known current.

use std::f64::consts::TAU;

use crate::front_end::clean::{Clean, clean};
use model::trace::front_end::{FACTORS, FrontEndFile};
use rig::ema::{EmaScenario, Logging};

/// The front end for traces of the standard actuator that are logged so.
fn of_rig(logging: Logging) -> FrontEndFile {
    let text = EmaScenario::STANDARD.logged(logging).front_end_toml(&FACTORS).expect("raw rows");
    FrontEndFile::parse(&text).expect("the text of a front end")
}

/// 4 kHz → 1 kHz, three currents, 14 bits of angle.
fn file() -> FrontEndFile {
    of_rig(Logging { every: 3, hold: 1 })
}

/// Rows of a shaft that turns at a constant velocity with a constant quadrature current: phases and counts.
fn rows(count: usize, current_a: f64, velocity_rad_s: f64) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![]; 4];
    for row in 0..count {
        let angle = velocity_rad_s * row as f64 / 4000.0;
        for (phase, column) in columns.iter_mut().take(3).enumerate() {
            // Iq of the standard convention is along −sin.
            column.push(-current_a * (6.0 * angle - phase as f64 * TAU / 3.0).sin());
        }
        columns[3].push((angle / TAU * 16_384.0).round().rem_euclid(16_384.0));
    }
    columns
}

fn slices(columns: &[Vec<f64>]) -> Vec<&[f64]> {
    columns.iter().map(Vec::as_slice).collect()
}

#[test]
fn the_text_of_a_front_end_gives_the_same_front_end() {
    let own = file();
    assert_eq!((own.control_rate_hz, own.factor), (4000.0, 4));
    assert_eq!(FrontEndFile::parse(&own.to_text().expect("text")), Ok(own));
    // 12, 4 and 1.2 kHz.
    for every in [1, 3, 10] {
        let own = of_rig(Logging { every, hold: 1 });
        assert_eq!(FrontEndFile::parse(&own.to_text().expect("text")), Ok(own));
    }
}

#[test]
fn a_file_is_refused_by_line_or_key() {
    let text = file().to_text().expect("text");
    for (from, to, place, words) in [
        ("factor = 4", "factor = 3", "values", "factor 3: there are filters for 1, 2, 4"),
        ("factor = 4", "faktor = 4", "line 3", "unknown field `faktor`"),
        ("factor = 4", "factor = ", "line 3", ""),
        ("factor = 4", "", "line 1", "missing field `factor`"),
        ("bits = 14", "bits = 33", "values", "[position] bits 33"),
        ("pole_pairs = 6", "pole_pairs = 0", "values", "pole"),
        ("control_rate_hz = 4000.0", "control_rate_hz = nan", "values", "rate"),
        ("electrical_offset_rad = 0.0", "electrical_offset_rad = inf", "values", "electrical_offset_rad"),
        (", \"phase_c_a\"]", "]", "values", "[currents] has two or three columns"),
        ("park = \"standard\"", "park = \"mine\"", "line", "unknown variant `mine`"),
    ] {
        assert!(text.contains(from), "{from}");
        let (at, problem) = FrontEndFile::parse(&text.replace(from, to)).expect_err(to);
        assert!(at.starts_with(place) && problem.contains(words), "{to}: {at}: {problem}");
    }
}

#[test]
fn constant_rows_give_their_current_and_velocity() {
    let columns = rows(4000, 5.0, 40.0);
    let load = vec![vec![0.25; 4000]];
    let clean = clean(&file(), &slices(&columns), &slices(&load), None).expect("clean");
    assert_eq!(clean.refused, None);
    let [current, velocity, angle, further] = &clean.columns[..] else { panic!("four columns") };
    // A filter's start-up and the lock of the loop are left out: 32 samples and a few.
    assert!((900..1000).contains(&current.len()), "{}", current.len());
    let worst = |column: &[f64], value: f64| column.iter().map(|x| (x - value).abs()).fold(0.0, f64::max);
    // Steps of the converter of 0.025 A; 14 bits are 3.8e-4 rad, 1.5 rad/s from row to row before the filters.
    assert!(worst(current, 5.0) < 0.02, "{}", worst(current, 5.0));
    assert!(worst(velocity, 40.0) < 0.6, "{}", worst(velocity, 40.0));
    assert!(worst(further, 0.25) < 1e-6);
    let steps = angle.windows(2).map(|pair| (pair[1] - pair[0]).rem_euclid(TAU));
    assert!(steps.map(|step| (step - 0.04).abs()).fold(0.0, f64::max) < 4e-4);
}

#[test]
fn what_is_wrong_in_a_recording_is_counted_and_named() {
    let names = |columns: &[Vec<f64>], times: Option<&[f64]>| {
        let outcome = clean(&file(), &slices(columns), &[], times);
        outcome.map(|clean| clean.refused.map_or(String::new(), |refused| refused.to_string()))
    };
    let good = rows(4000, 5.0, 40.0);
    assert_eq!(names(&good, None), Ok(String::new()));
    let mut open = good.clone();
    open[2].fill(0.0);
    let refused = names(&open, None).expect("the first window passes");
    assert!(refused.contains("the currents do not fit each other"), "{refused}");
    let mut saturated = good.clone();
    saturated[0][2000] = 1e3;
    let refused = names(&saturated, None).expect("one sample");
    assert!(refused.contains("phase a saturated 1 times"), "{refused}");
    let mut missing = good.clone();
    missing.iter_mut().for_each(|column| drop(column.drain(2000..2100)));
    let times: Vec<f64> =
        (0..4000).filter(|row| !(2000..2100).contains(row)).map(|row| f64::from(row) / 4000.0).collect();
    let refused = names(&missing, Some(&times)).expect("a gap");
    assert!(refused.contains("1 gaps in time"), "{refused}");
    let mut blind = good;
    blind[3].fill(f64::NAN);
    let refused = names(&blind, None).expect_err("no angle");
    assert!(refused.contains("no sample passes the front end: 4000 angles missing"), "{refused}");
}

/// The columns as bits: a missing value equals another one.
fn bits(clean: &Clean) -> Vec<Vec<u64>> {
    clean.columns.iter().map(|column| column.iter().map(|x| x.to_bits()).collect()).collect()
}

#[test]
fn rows_without_currents_or_time_are_those_that_the_drive_missed() {
    let all = rows(4000, 5.0, 40.0);
    let times: Vec<f64> = (0..4000).map(|row| f64::from(row) / 4000.0).collect();
    let kept: Vec<usize> = (0..4000).filter(|row| !matches!(row, 1500 | 2000..2100)).collect();
    let of = |column: &Vec<f64>| kept.iter().map(|row| column[*row]).collect();
    let dropped: Vec<Vec<f64>> = all.iter().map(of).collect();
    let expected = clean(&file(), &slices(&dropped), &[], Some(&of(&times))).expect("clean");
    assert!(expected.refused.is_some_and(|refused| refused.faults.gaps == 2));
    let (mut empty, mut untimed) = (all.clone(), times.clone());
    empty[1][2000..2100].fill(f64::NAN);
    empty[0][1500] = f64::NAN;
    let found = clean(&file(), &slices(&empty), &[], Some(&times)).expect("clean");
    assert_eq!(bits(&found), bits(&expected));
    untimed[1500] = f64::NAN;
    untimed[2000..2100].fill(f64::NAN);
    let found = clean(&file(), &slices(&all), &[], Some(&untimed)).expect("clean");
    assert_eq!(bits(&found), bits(&expected));
}

/// 4 kHz: steps of 0.25 ms, which whole tenths of a millisecond round.
#[test]
fn rows_are_numbered_by_seconds_whatever_the_unit_of_the_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let front_end = file();
    let columns = rows(4000, 5.0, 40.0);
    let read = |time: &str, of_row: &dyn Fn(usize) -> String| {
        let mut text = format!("{time},{}\n", front_end.columns().join(","));
        for row in 0..4000 {
            let values: Vec<String> = columns.iter().map(|column| column[row].to_string()).collect();
            text += &format!("{},{}\n", of_row(row), values.join(","));
        }
        let path = folder.path().join("trace.csv");
        std::fs::write(&path, text).expect("writable");
        crate::front_end::raw_rows(&path, &front_end, &[]).expect("rows")
    };
    let seconds = read("time_s", &|row| format!("{:.5}", row as f64 / 4000.0));
    assert_eq!(seconds.len(), 8 + 4000 * 16);
    assert!(seconds == read("time_us", &|row| (250 * row).to_string()));
    assert!(seconds == read("time_ms", &|row| format!("{:.2}", 0.25 * row as f64)));
    assert!(seconds == read("time_ms", &|row| format!("{:.1}", 0.25 * row as f64)));
}

#[test]
fn a_fault_that_is_found_late_is_kept_with_its_sample() {
    let mut columns = rows(12_000, 5.0, 40.0);
    let whole = clean(&file(), &slices(&columns), &[], None).expect("clean");
    assert_eq!(whole.found_late, Vec::<usize>::new());
    // From one second on, two phases are exchanged.
    let [_, b, c, _] = &mut columns[..] else { panic!("four columns") };
    b[4000..].swap_with_slice(&mut c[4000..]);
    let Clean { found_late, columns, .. } = clean(&file(), &slices(&columns), &[], None).expect("clean");
    // A sample is 1 ms; the next window of electrical angles, of 15 a second and mechanical turn, finds it.
    let [late] = found_late[..] else { panic!("{found_late:?}") };
    assert!((900..2900).contains(&late) && columns[0].len() > late, "{late}");
}
