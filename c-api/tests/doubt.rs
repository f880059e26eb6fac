//! Reports in doubt, a lost diagnosis, and a state that starts afresh.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic, and its inputs are small constants"
)]

#[allow(dead_code, reason = "other tests use the rest")]
#[path = "support/drive.rs"]
mod drive;
#[path = "../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::mem::MaybeUninit;
use core::ptr::null_mut;

use bearing_watch_c::*;

use standard_rig::model::{MODEL, Sample};
use support::{FILE, Memory, SEGMENT, alarm, channels};

fn samples(count: usize) -> impl Iterator<Item = Sample> {
    standard_rig::samples().collect::<Vec<_>>().into_iter().cycle().take(count)
}

/// Takes samples by `bw_collect`, or by `bw_step`; returns the last code.
fn take(state: *mut BwState, count: usize, at_once: bool) -> BwCode {
    let mut last = BwCode::Ok;
    for sample in samples(count) {
        let values = channels(&MODEL, &sample);
        // SAFETY: the state is initialised, and the values are there.
        last = unsafe { (if at_once { bw_step } else { bw_collect })(state, values.as_ptr(), values.len(), 0) };
    }
    last
}

fn discard(state: *mut BwState) -> u8 {
    let mut in_doubt = 7;
    // SAFETY: the state is initialised, and the place is writable.
    assert_eq!(unsafe { bw_discard(state, &raw mut in_doubt) }, BwCode::Ok);
    in_doubt
}

/// Verdict and reason of the report, and segments and undetermined ones of the alarm.
fn told(state: *mut BwState) -> (BwVerdict, BwReason, [u32; 2]) {
    let (mut report, alarm) = (MaybeUninit::<BwReport>::uninit(), alarm(state));
    // SAFETY: the state is initialised; the report is written if the code says so.
    let report = unsafe {
        assert_eq!(bw_report(state, report.as_mut_ptr()), BwCode::Ok);
        report.assume_init()
    };
    (report.verdict, report.reason, [alarm.segments, alarm.undetermined])
}

const GOOD: (BwVerdict, BwReason, [u32; 2]) = (BwVerdict::Class, BwReason::None, [1, 0]);
const DOUBTED: (BwVerdict, BwReason, [u32; 2]) = (BwVerdict::Undetermined, BwReason::FoundLate, [1, 1]);

#[test]
fn a_report_in_doubt_is_withdrawn_whether_it_was_given_or_not() {
    for at_once in [true, false] {
        let mut memory = Memory::new();
        let state = memory.state(FILE).expect("good model");
        let code = take(state, SEGMENT, at_once);
        if at_once {
            assert_eq!((code, told(state)), (BwCode::Report, GOOD));
        } else {
            assert_eq!(code, BwCode::Segment);
        }
        take(state, SEGMENT / 4, false);
        assert_eq!(discard(state), 1);
        if !at_once {
            // SAFETY: the state is initialised.
            assert_eq!(unsafe { bw_conclude(state) }, BwCode::Report);
        }
        assert_eq!(told(state), DOUBTED, "{at_once}");
        assert_eq!(told(state), DOUBTED, "once only");
        // The next segment closes where it would have, and its own report is not in doubt.
        assert_eq!(take(state, SEGMENT - SEGMENT / 4, false), BwCode::Segment);
        // SAFETY: the state is initialised.
        assert_eq!(unsafe { bw_conclude(state) }, BwCode::Report);
        assert_eq!(told(state).2, [2, 1]);
        assert_ne!(told(state).1, BwReason::FoundLate);
    }
}

#[test]
fn a_segment_of_which_half_has_passed_and_one_that_was_lost_do_not_doubt_another() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    take(state, SEGMENT, true);
    take(state, SEGMENT / 2, false);
    assert_eq!((discard(state), told(state)), (0, GOOD));
    // The second segment waits, the third one is lost, and in doubt.
    assert_eq!(take(state, SEGMENT / 2, false), BwCode::Segment);
    assert_eq!(take(state, SEGMENT, false), BwCode::SegmentLost);
    assert_eq!((discard(state), told(state)), (1, GOOD));
    // SAFETY: the state is initialised.
    assert_eq!(unsafe { bw_conclude(state) }, BwCode::Report);
    assert_ne!(told(state).1, BwReason::FoundLate);
}

#[test]
fn the_last_report_of_a_run_that_has_ended_stands() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    assert_eq!(take(state, SEGMENT, false), BwCode::Segment);
    // SAFETY: the state is initialised.
    unsafe {
        assert_eq!(bw_advance(state), BwCode::Ok);
        assert_eq!(bw_end_run(state), BwCode::Ok);
        assert_eq!([bw_advance(state), bw_conclude(state)], [BwCode::Idle; 2], "the solve was finished");
    }
    assert_eq!(told(state), GOOD);
    assert_eq!((discard(state), told(state)), (1, GOOD));
}

#[test]
fn verdicts_that_are_missing_for_too_long_are_told_with_their_reason() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    // SAFETY: the state is initialised, or NULL.
    unsafe {
        assert_eq!(bw_limit_silence(null_mut(), 2, 0.0), BwCode::Null);
        assert_eq!([f32::NAN, -1.0].map(|hours| bw_limit_silence(state, 2, hours)), [BwCode::OutOfRange; 2]);
        assert_eq!(bw_limit_silence(state, 2, 0.0), BwCode::Ok);
    }
    let mut silent = Vec::new();
    for _ in 0..2 {
        for _ in 0..SEGMENT {
            let values = [f32::NAN, 1.0, 0.1];
            // SAFETY: the state is initialised, and the values are there.
            unsafe { bw_step(state, values.as_ptr(), 3, 0) };
        }
        silent.push(alarm(state).silent);
    }
    let BwAlarm { silent_segments, silent_reason, raised, .. } = alarm(state);
    assert_eq!((silent, silent_segments, raised), (vec![false, true], 2, false));
    assert_eq!(silent_reason, BwReason::TooFewRows);
    take(state, SEGMENT, true);
    assert!(!alarm(state).silent, "a verdict ends it");
}

/// A segment takes ten seconds.
#[test]
fn a_silence_counts_the_hours_of_the_segments() {
    for (seconds, expected) in [(9.0, [true; 3]), (19.0, [false, true, true]), (29.0, [false, false, true])] {
        let mut memory = Memory::new();
        let state = memory.state(FILE).expect("good model");
        // SAFETY: the state is initialised, and the values are there.
        let silent = unsafe {
            assert_eq!(bw_limit_silence(state, 0, seconds / 3600.0), BwCode::Ok);
            [(); 3].map(|()| {
                (0..SEGMENT).for_each(|_| _ = bw_step(state, [f32::NAN, 1.0, 0.1].as_ptr(), 3, 0));
                alarm(state).silent
            })
        };
        assert_eq!(silent, expected, "{seconds} s");
    }
}

#[test]
fn after_a_reset_or_a_restored_state_there_is_no_report_and_nothing_to_solve() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    let (mut bytes, mut report) = ([0; 512], MaybeUninit::<BwReport>::uninit());
    // SAFETY: the state is initialised, and the places are writable.
    unsafe {
        let mut size = 0;
        assert_eq!([bw_saved_size(state, &raw mut size), bw_save(state, bytes.as_mut_ptr(), 512)], [BwCode::Ok; 2]);
        let restore = || bw_restore(state, bytes.as_ptr(), size);
        let ways: [&dyn Fn() -> BwCode; 2] = [&|| bw_reset(state), &restore];
        for afresh in ways {
            assert_eq!(take(state, SEGMENT, true), BwCode::Report);
            assert_eq!((afresh(), bw_report(state, report.as_mut_ptr())), (BwCode::Ok, BwCode::NoReport));
            assert_eq!((alarm(state).segments, alarm(state).score), (0, 0.0));
            assert_eq!((take(state, SEGMENT, false), bw_advance(state)), (BwCode::Segment, BwCode::Ok));
            assert_eq!([afresh(), bw_advance(state), bw_end_run(state)], [BwCode::Ok, BwCode::Idle, BwCode::Ok]);
            assert_eq!(alarm(state).segments, 0, "what was being solved is left out");
        }
    }
}

#[test]
fn a_closed_segment_and_a_report_remain_after_a_restart() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    assert_eq!(take(state, SEGMENT, false), BwCode::Segment);
    // SAFETY: the state is initialised.
    unsafe {
        assert_eq!([bw_restart(state), bw_conclude(state)], [BwCode::Ok, BwCode::Report]);
        assert_eq!((told(state), bw_restart(state), told(state)), (GOOD, BwCode::Ok, GOOD));
    }
}

#[test]
fn the_first_ten_seconds_go_with_a_wrong_rate_and_later_ones_stay() {
    for (samples, left) in [(10_001, 0), (5_001, 1)] {
        let mut memory = Memory::new();
        let state = memory.state(FILE).expect("good model");
        // SAFETY: the state is initialised.
        let check = |samples, milliseconds| unsafe { bw_clock(state, samples, milliseconds) };
        assert_eq!(check(1, 0), BwCode::Ok);
        assert_eq!(take(state, SEGMENT, true), BwCode::Report);
        let wrong = if left == 0 { BwCode::WrongRate } else { BwCode::Ok };
        assert_eq!((check(samples, 10_000), alarm(state).segments), (wrong, left));
        check(samples, 10_001);
        assert_eq!(take(state, SEGMENT, true), BwCode::Report);
        check(samples + 20_000, 20_000);
        assert_eq!(alarm(state).segments, left + 1);
    }
}

#[test]
fn no_segment_has_a_verdict_before_the_wiring_is_known() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    let mut tell = |alignment: BwAlignment| {
        // SAFETY: the state is initialised.
        assert_eq!(unsafe { bw_tell_alignment(state, alignment as u8) }, BwCode::Ok);
        take(state, SEGMENT, true);
        told(state).1
    };
    assert_eq!([BwAlignment::Undecided, BwAlignment::Misaligned].map(&mut tell), [BwReason::Implausible; 2]);
    assert_eq!([BwAlignment::Aligned, BwAlignment::Unknown].map(&mut tell), [BwReason::None; 2]);
}

#[test]
fn behind_a_front_end_no_segment_has_a_verdict_before_it_tells_the_wiring() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    // The samples of the model come every 2 ms.
    let good = BwFrontEndConstants { control_rate_hz: 4000.0, ..drive::for_c(&drive::CONSTANTS, 8, 2) };
    let checked = |constants: BwFrontEndConstants| {
        // SAFETY: the state is initialised, and the constants are there.
        let code = unsafe { bw_check_front_end(state, &raw const constants) };
        take(state, SEGMENT, true);
        (code, told(state).1)
    };
    let other = BwFrontEndConstants { factor: 16, ..good };
    assert_eq!(checked(other), (BwCode::ModelInterval, BwReason::None), "a front end that is refused is none");
    assert_eq!(checked(good), (BwCode::Ok, BwReason::Implausible));
    // SAFETY: the state is initialised.
    assert_eq!(unsafe { bw_tell_alignment(state, BwAlignment::Aligned as u8) }, BwCode::Ok);
    take(state, SEGMENT, true);
    assert_eq!(told(state).1, BwReason::None);
}

#[test]
fn a_reset_leaves_neither_a_closed_segment_nor_missed_samples() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    assert_eq!(take(state, SEGMENT, false), BwCode::Segment);
    take(state, 10, false);
    let mut pending = 7;
    // SAFETY: the state is initialised, and the place is writable.
    unsafe {
        assert_eq!(bw_reset(state), BwCode::Ok);
        assert_eq!([bw_advance(state), bw_conclude(state)], [BwCode::Idle; 2]);
        assert_eq!((bw_pending(state, &raw mut pending), pending), (BwCode::Ok, 0));
    }
    assert_eq!(take(state, SEGMENT, true), BwCode::Report);
    assert_eq!(told(state), GOOD, "as of a new state");
}

#[test]
fn the_kernels_have_their_known_answers() {
    assert_eq!(bw_known_answer_test(), 0);
}

#[test]
fn samples_at_another_rate_than_that_of_the_model_have_no_verdict() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    // SAFETY: the state is initialised.
    let check = |samples, milliseconds| unsafe { bw_clock(state, samples, milliseconds) };
    // 500 Hz: 10 000 samples in 10 s are twice as many. Before the first sample no time counts.
    assert_eq!([check(0, 0), check(1, 2000)], [BwCode::Ok; 2]);
    assert_eq!([check(10_001, 12_000), check(10_001, 12_001)], [BwCode::WrongRate, BwCode::Ok], "told once");
    assert_eq!(take(state, SEGMENT, true), BwCode::Report);
    assert_eq!(told(state), (BwVerdict::Undetermined, BwReason::Implausible, [1, 1]));
    assert_eq!(check(15_051, 22_000), BwCode::Ok);
    assert_eq!(take(state, SEGMENT, true), BwCode::Report);
    assert_eq!(told(state), (BwVerdict::Class, BwReason::None, [2, 1]));
    // SAFETY: NULL is refused.
    assert_eq!(unsafe { bw_clock(null_mut(), 0, 0) }, BwCode::Null);
}
