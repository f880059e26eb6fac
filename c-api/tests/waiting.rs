//! Samples that wait for a lower interrupt give the reports of `bw_collect`; what finds no place is counted, and
//! missing for the detector.
#![allow(clippy::expect_used, clippy::indexing_slicing, clippy::panic, reason = "a test fails by a panic")]

#[path = "../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::mem::MaybeUninit;
use core::ptr::null_mut;

use bearing_watch_c::*;

use standard_rig::model::MODEL;
use support::{FILE, Memory, SEGMENT, channels, values};

/// A segment and a half.
fn rows() -> Vec<Vec<f32>> {
    standard_rig::samples().take(SEGMENT * 3 / 2).map(|sample| channels(&MODEL, &sample)).collect()
}

fn put(state: *mut BwState, row: &[f32], found_late: bool) -> BwCode {
    // SAFETY: the state is initialised, and the values are there.
    unsafe { bw_put(state, row.as_ptr(), row.len(), 0, found_late) }
}

fn collect(state: *mut BwState) -> BwCode {
    // SAFETY: the state is initialised.
    unsafe { bw_collect_waiting(state) }
}

/// The last report.
fn report(state: *mut BwState) -> BwReport {
    let mut report = MaybeUninit::<BwReport>::uninit();
    // SAFETY: the state is initialised; the report is written if the code says so.
    unsafe {
        assert_eq!(bw_report(state, report.as_mut_ptr()), BwCode::Ok);
        report.assume_init()
    }
}

/// The parameters of the closed segment, its rows, and the samples that were lost.
fn concluded(state: *mut BwState) -> (Vec<u32>, u32, u32) {
    // SAFETY: the state is initialised.
    assert_eq!(unsafe { bw_conclude(state) }, BwCode::Report);
    let report = report(state);
    let parameters = values(state, BwValues::Parameters).into_iter().map(f32::to_bits).collect();
    (parameters, report.rows, report.lost_samples)
}

/// By `bw_collect`, with some rows as missing ones, and `bw_discard` before one of them.
fn alone(missing: core::ops::Range<usize>, discard_at: usize) -> (Vec<u32>, u32) {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    for (k, row) in rows().iter().enumerate() {
        let row = if missing.contains(&k) { vec![f32::NAN; row.len()] } else { row.clone() };
        // SAFETY: the state is initialised, and the values are there.
        unsafe {
            if k == discard_at {
                assert_eq!(bw_discard(state, null_mut()), BwCode::Ok);
            }
            bw_collect(state, row.as_ptr(), row.len(), 0);
        }
    }
    let (parameters, rows, _) = concluded(state);
    (parameters, rows)
}

#[test]
fn reports_are_those_of_samples_that_do_not_wait() {
    let expected = alone(0..0, 700);
    for late in 1..=4 {
        let mut memory = Memory::new();
        let state = memory.state(FILE).expect("a good model");
        let mut closed = 0;
        for (k, row) in rows().iter().enumerate() {
            assert_eq!(put(state, row, k == 700), BwCode::Ok);
            if k % late == late - 1 {
                closed += usize::from(collect(state) == BwCode::Segment);
            }
        }
        let (parameters, rows, lost) = concluded(state);
        assert_eq!((closed, lost), (1, 0));
        assert!((parameters, rows) == expected, "{late}");
    }
}

#[test]
fn samples_that_find_no_place_are_counted_and_missing() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    let codes: Vec<BwCode> = rows()
        .iter()
        .enumerate()
        .map(|(k, row)| {
            // A fault is found late with a sample that is lost.
            let code = put(state, row, k == 1006);
            if !(1000..1010).contains(&k) {
                collect(state);
            }
            code
        })
        .collect();
    let lost: Vec<usize> = (0..codes.len()).filter(|k| codes[*k] == BwCode::SampleLost).collect();
    assert_eq!(lost, (1004..1011).collect::<Vec<_>>(), "four wait");
    let (parameters, rows, lost) = concluded(state);
    // The next sample that finds a place carries the fault.
    assert_eq!((lost, (parameters, rows)), (7, alone(1004..1011, 1004)));
}

#[test]
fn a_restart_drops_what_waits_and_what_was_lost() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    let rows = rows();
    for row in rows.iter().take(3) {
        put(state, row, false);
    }
    collect(state);
    // Four wait. The fifth is lost, and its fault would go with the next sample.
    let codes: Vec<BwCode> = rows.iter().skip(3).take(5).map(|row| put(state, row, true)).collect();
    assert_eq!(codes.last(), Some(&BwCode::SampleLost));
    // SAFETY: the state is initialised.
    assert_eq!(unsafe { bw_restart(state) }, BwCode::Ok);
    assert_eq!(collect(state), BwCode::Ok, "nothing waits");
    for row in &rows {
        put(state, row, false);
        collect(state);
    }
    let (parameters, taken, lost) = concluded(state);
    assert_eq!((lost, (parameters, taken)), (1, alone(0..0, usize::MAX)));
}

#[test]
fn a_report_stands_after_a_restart_that_drops_a_fault_behind_it() {
    for restarts in [true, false] {
        let mut memory = Memory::new();
        let state = memory.state(FILE).expect("a good model");
        let rows = rows();
        for row in rows.iter().take(SEGMENT) {
            put(state, row, false);
            collect(state);
        }
        concluded(state);
        // Four wait; the fault comes with the fifth, which is lost.
        let codes: Vec<BwCode> = (0..5).map(|k| put(state, &rows[k], k == 4)).collect();
        assert_eq!(codes.last(), Some(&BwCode::SampleLost));
        if restarts {
            // SAFETY: the state is initialised.
            assert_eq!(unsafe { bw_restart(state) }, BwCode::Ok);
        }
        collect(state);
        put(state, &rows[5], false);
        collect(state);
        let expected = if restarts { BwReason::None } else { BwReason::FoundLate };
        assert_eq!(report(state).reason, expected, "restarts: {restarts}");
    }
}

#[test]
fn wrong_calls_are_refused() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    assert_eq!(put(state, &[1.0; 2], false), BwCode::WrongChannelCount);
    assert_eq!([put(null_mut(), &[1.0; 3], false), collect(null_mut())], [BwCode::Null; 2]);
    assert_eq!(collect(state), BwCode::Ok, "nothing waits");
}
