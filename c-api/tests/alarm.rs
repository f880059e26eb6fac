//! The alarm through the C functions: of a trained defect, and of what resembles none.
#![allow(
    clippy::cast_possible_truncation,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

#[path = "../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

#[path = "support/alarmed.rs"]
mod alarmed;

use bearing_watch_c::*;

use standard_rig::model::{MODEL, Sample};
use support::{Memory, SEGMENT, alarm, bytes, channels, step};

/// The second trace is of a spall.
const SPALL: usize = 1;

/// Takes a segment of one of the three traces, with its current multiplied.
fn take(state: *mut BwState, trace: usize, gain: f32) -> BwAlarm {
    for sample in standard_rig::samples().skip(trace * SEGMENT).take(SEGMENT) {
        let values = channels(&MODEL, &Sample { current_a: gain * sample.current_a, ..sample });
        step(state, &values, 0);
    }
    alarm(state)
}

/// Raised, known, class and segment.
fn told(alarm: &BwAlarm) -> (bool, bool, u8, u32) {
    (alarm.raised, alarm.known, alarm.class_index, alarm.segment)
}

#[test]
fn a_trained_defect_is_known_and_the_alarm_keeps_its_segment() {
    let mut memory = Memory::new();
    let state = memory.state(&bytes(&alarmed::model())).expect("good model");
    assert_eq!(told(&take(state, 0, 1.0)), (false, false, 0, 0), "healthy");
    let raised = (0..4).map(|_| take(state, SPALL, 1.0)).find(|alarm| alarm.raised).expect("an alarm");
    assert_eq!(told(&raised), (true, true, 1, raised.segments));
    let later = take(state, 0, 1.0);
    assert_eq!((told(&later), later.segments), (told(&raised), raised.segments + 1));
}

#[test]
fn what_resembles_no_defect_is_not_known() {
    let mut memory = Memory::new();
    let state = memory.state(&bytes(&alarmed::model())).expect("good model");
    // A sensor of five times the gain.
    let raised = (0..4).map(|_| take(state, 0, 5.0)).find(|alarm| alarm.raised).expect("an alarm");
    assert_eq!(told(&raised), (true, false, 0, raised.segments));
}

#[test]
fn an_alarm_stands_until_it_is_denied_or_reset() {
    let mut memory = Memory::new();
    let state = memory.state(&bytes(&alarmed::model())).expect("good model");
    for afresh in [bw_deny, bw_reset] {
        assert!((0..4).any(|_| take(state, SPALL, 1.0).raised));
        assert!((0..3).all(|_| take(state, 0, 1.0).raised), "healthy");
        // SAFETY: the state is initialised.
        assert_eq!(unsafe { afresh(state) }, BwCode::Ok);
        assert_eq!((told(&alarm(state)), alarm(state).score), ((false, false, 0, 0), 0.0));
    }
}

#[test]
fn an_alarm_of_a_class_says_of_no_coordinate_that_it_has_risen_or_fallen() {
    let mut memory = Memory::new();
    let state = memory.state(&bytes(&alarmed::model())).expect("good model");
    let raised = (0..4).map(|_| take(state, SPALL, 1.0)).find(|alarm| alarm.raised).expect("an alarm");
    let BwAlarm { risen, fallen, coordinate, deviations, since, .. } = raised;
    assert_eq!((risen, fallen, coordinate, deviations, since), (false, false, 0, 0.0, 0));
}
