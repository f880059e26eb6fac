//! What does not come any more is told once by the clock, with the reason as a code that has a text.
#![allow(clippy::expect_used, clippy::indexing_slicing, clippy::panic, reason = "a test fails by a panic")]

#[path = "../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use std::ops::Range;

use bearing_watch::Model;
use bearing_watch_c::*;

use standard_rig::model::{Drive, MODEL};
use support::{FILE, Memory, SEGMENT, bytes, channels};

/// The codes of the clock below 0 with their times in ms, of a drive whose contexts run within some times, at 500 Hz.
fn told(sampled: Range<u32>, collected: Range<u32>, solved: Range<u32>, end_ms: u32) -> Vec<(u32, BwCode)> {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    let (mut samples, mut told) = (0, Vec::new());
    // SAFETY: the state is initialised, and the values are there.
    unsafe {
        assert_eq!(bw_limit_liveness(state, 1.0, 15.0, 40.0), BwCode::Ok);
        let rows: Vec<Vec<f32>> =
            standard_rig::samples().take(SEGMENT).map(|sample| channels(&MODEL, &sample)).collect();
        for (now, row) in (0..end_ms).step_by(2).zip(rows.iter().cycle()) {
            if sampled.contains(&now) {
                samples += 1;
                bw_put(state, row.as_ptr(), row.len(), 0, false);
            }
            if collected.contains(&now) {
                bw_collect_waiting(state);
            }
            if solved.contains(&now) {
                bw_advance(state);
            }
            let code = bw_clock(state, samples, now);
            if (code as i32) < 0 {
                told.push((now, code));
            }
        }
    }
    told
}

#[test]
fn what_does_not_come_any_more_is_told_once_with_the_reason() {
    let always = 0..u32::MAX;
    assert_eq!(told(always.clone(), always.clone(), always.clone(), 60_000), []);
    let lapse = |told: &[(u32, BwCode)]| (told.len(), told[0].1, told[0].0 / 100);
    assert_eq!(lapse(&told(0..12_000, always.clone(), always.clone(), 19_000)), (1, BwCode::NoSample, 129));
    assert_eq!(lapse(&told(always.clone(), 0..12_000, always.clone(), 19_000)), (1, BwCode::NotCollected, 129));
    // The first segment, of ten seconds, waits, and the others are lost.
    assert_eq!(lapse(&told(always.clone(), always, 0..0, 39_000)), (1, BwCode::NoSegment, 249));
}

/// Steps a drive without a queue through samples of the standard rig, one every `interval_ms`. Gives the codes of the
/// clock below 0 with their times, and the number of reports.
fn told_at_once(model: &[u8], samples: usize, interval_ms: u32, limits: [f32; 3]) -> (Vec<(u32, BwCode)>, usize) {
    let mut memory = Memory::new();
    let state = memory.state(model).expect("a good model");
    let rows: Vec<Vec<f32>> = standard_rig::samples().take(SEGMENT).map(|sample| channels(&MODEL, &sample)).collect();
    let (mut taken, mut told, mut reports) = (0, Vec::new(), 0);
    let [sample_s, segment_s, verdict_s] = limits;
    // SAFETY: the state is initialised, and the values are there.
    unsafe {
        if sample_s > 0.0 {
            assert_eq!(bw_limit_liveness(state, sample_s, segment_s, verdict_s), BwCode::Ok);
        }
        for row in rows.iter().cycle().take(samples) {
            taken += 1;
            reports += usize::from(bw_step(state, row.as_ptr(), row.len(), 0) == BwCode::Report);
            let now = interval_ms * taken;
            let code = bw_clock(state, taken, now);
            if (code as i32) < 0 {
                told.push((now, code));
            }
        }
    }
    (told, reports)
}

#[test]
fn segments_and_verdicts_without_a_queue_are_seen() {
    assert_eq!(told_at_once(FILE, 6 * SEGMENT, 2, [1.0, 15.0, 25.0]), (vec![], 6));
}

#[test]
fn a_segment_of_block_means_has_its_whole_time_to_close() {
    let mut constants = MODEL.constants().clone();
    let sampling = &mut constants.sampling;
    (sampling.interval_s, sampling.block_mean, sampling.segment_samples) = (0.01, 8, 1000);
    let model = Model::new(Drive, constants).expect("a good model");
    // 80 s: of samples without their means, three segments and three seconds would be 33 s.
    assert_eq!(told_at_once(&bytes(&model), 17_000, 10, [0.0; 3]), (vec![], 2));
}

/// Reads the clock while samples come at one rate after the other, in Hz, each for its seconds. A pause of five seconds
/// and a restart stand between two rates. Gives the codes below 0.
fn told_of_rates(rates: &[(u32, u32)]) -> Vec<BwCode> {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    let (mut samples, mut now, mut told) = (0, 0, Vec::new());
    for (place, (rate_hz, seconds)) in rates.iter().enumerate() {
        if place > 0 {
            now += 5_000;
            // SAFETY: the state is initialised.
            assert_eq!(unsafe { bw_restart(state) }, BwCode::Ok);
        }
        for _ in 0..10 * seconds {
            samples += rate_hz / 10;
            now += 100;
            // SAFETY: the state is initialised.
            told.push(unsafe { bw_clock(state, samples, now) });
        }
    }
    told.retain(|code| (*code as i32) < 0);
    told
}

#[test]
fn a_pause_before_a_restart_does_not_count() {
    assert_eq!(told_of_rates(&[(500, 14), (500, 12)]), []);
}

#[test]
fn a_wrong_rate_is_told_again_once_it_was_right() {
    assert_eq!(told_of_rates(&[(1000, 30), (500, 15), (250, 30)]), [BwCode::WrongRate; 2]);
}

#[test]
fn with_other_times_they_count_anew() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    // SAFETY: the state is initialised.
    unsafe {
        assert_eq!([bw_clock(state, 0, 0), bw_clock(state, 0, 900)], [BwCode::Ok; 2]);
        assert_eq!(bw_limit_liveness(state, 1.0, 15.0, 40.0), BwCode::Ok);
        let codes = [1_100, 2_099, 2_100].map(|now| bw_clock(state, 0, now));
        assert_eq!(codes, [BwCode::Ok, BwCode::Ok, BwCode::NoSample]);
    }
}

#[test]
fn segments_whose_verdict_is_undetermined_are_no_verdicts_for_the_clock() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("a good model");
    let (mut told, mut reports) = (Vec::new(), 0);
    // SAFETY: the state is initialised, and the values are there.
    unsafe {
        assert_eq!(bw_limit_liveness(state, 1.0, 15.0, 25.0), BwCode::Ok);
        for taken in (1..).take(3 * SEGMENT) {
            // No channel has a number.
            reports += usize::from(bw_step(state, [f32::NAN; 3].as_ptr(), 3, 0) == BwCode::Report);
            let code = bw_clock(state, taken, 2 * taken);
            if (code as i32) < 0 {
                told.push((code, 2 * taken / 100));
            }
        }
    }
    assert_eq!((reports, told), (3, vec![(BwCode::NoVerdict, 250)]));
}
