//! The frame for CAN through the C functions: the bits of the Rust core, the alarm and a withdrawn report in it, and
//! what is refused.
#![allow(
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

use core::ptr::null_mut;

use bearing_watch::telemetry::{CanPieces, SegmentFrame};
use bearing_watch::{Cause, Detector, Monitor, Verdict};
use bearing_watch_c::*;

use standard_rig::model::{MODEL, Sample};
use support::{FILE, Memory, bytes, channels};

const UNTOUCHED: [u8; BW_CAN_FRAME_SIZE] = [0xA5; BW_CAN_FRAME_SIZE];

fn frame(state: *mut BwState) -> (BwCode, [u8; BW_CAN_FRAME_SIZE]) {
    let mut bytes = UNTOUCHED;
    // SAFETY: the state is NULL, initialised or refused, and the frame has so many bytes.
    let code = unsafe { bw_can_frame(state, bytes.as_mut_ptr()) };
    (code, bytes)
}

fn step(state: *mut BwState, sample: &Sample) -> BwCode {
    let values = channels(&MODEL, sample);
    support::step(state, &values, 0)
}

#[test]
fn frames_are_those_of_the_core() {
    let model = alarmed::model();
    let (mut memory, mut detector, mut monitor) = (Memory::new(), Detector::new(&model), Monitor::new(&model));
    let state = memory.state(&bytes(&model)).expect("good model");
    let mut frames = Vec::new();
    for sample in standard_rig::samples() {
        let code = step(state, &sample);
        if monitor.step(&mut detector, &sample).is_some() {
            assert_eq!(code, BwCode::Report);
            let report = monitor.report().expect("a report");
            let sent = SegmentFrame::of(&model, report, monitor.evidence());
            assert_eq!(frame(state), (BwCode::Ok, sent.to_bytes()));
            frames.push(sent);
        }
    }
    assert_eq!([0, 1, 2].map(|k| frames[k].segment()), [1, 2, 3]);
    assert_eq!(frames[1].verdict(), Verdict::Class(1));
    assert_eq!([0, 2].map(|k| frames[k].alarm()), [None, Some(Cause::Unknown)]);
    assert!(frames[1].distance() > frames[0].distance(), "{frames:?}");
}

#[test]
fn what_is_wrong_is_refused_and_writes_nothing() {
    let mut memory = Memory::new();
    let state = memory.state(FILE).expect("good model");
    assert_eq!(frame(state), (BwCode::NoReport, UNTOUCHED));
    assert_eq!(frame(null_mut()), (BwCode::Null, UNTOUCHED));
    assert_eq!(frame(state.wrapping_byte_add(8)), (BwCode::NotInitialised, UNTOUCHED));
    assert_eq!(frame(state.wrapping_byte_add(1)), (BwCode::Misaligned, UNTOUCHED));
    // SAFETY: NULL is refused.
    assert_eq!(unsafe { bw_can_frame(state, null_mut()) }, BwCode::Null);
}

/// Keeps what is sent; the bus takes `.1` data frames.
unsafe extern "C" fn send(context: *mut core::ffi::c_void, data: *const u8, size: usize) -> i32 {
    // SAFETY: the test passes this type, and the bytes are there.
    let (bus, data) =
        unsafe { (&mut *context.cast::<(Vec<Vec<u8>>, usize)>(), core::slice::from_raw_parts(data, size)) };
    if bus.0.len() == bus.1 {
        return 1;
    }
    bus.0.push(data.to_vec());
    0
}

#[test]
fn a_frame_of_the_telemetry_goes_in_the_pieces_of_the_core() {
    let frame: Vec<u8> = (1..=150).chain([0]).collect();
    let stream = |number: &mut u8, most: usize, takes: usize| {
        let mut bus = (Vec::new(), takes);
        // SAFETY: number and frame are there, and the context is that of `send`.
        let code =
            unsafe { bw_can_stream(number, frame.as_ptr(), frame.len(), most, Some(send), (&raw mut bus).cast()) };
        (code, bus.0)
    };
    for (most, mut pieces) in [(8, CanPieces::classic()), (64, CanPieces::fd())] {
        let mut number = 0;
        for _ in 0..20 {
            let expected: Vec<Vec<u8>> = pieces.cut(&frame).map(|piece| piece.data().to_vec()).collect();
            assert_eq!(stream(&mut number, most, usize::MAX), (BwCode::Ok, expected));
            assert_eq!(number, pieces.number());
        }
    }
    // The number of the one that failed is not used again: the receiver sees the gap.
    let mut number = 7;
    let (code, sent) = stream(&mut number, 8, 2);
    assert_eq!((code, sent.len(), number), (BwCode::CanFailed, 2, 10));
    assert_eq!(stream(&mut number, 9, 0).0, BwCode::OutOfRange);
    // SAFETY: NULL is refused.
    unsafe {
        let (bytes, nothing) = (frame.as_ptr(), null_mut());
        assert_eq!(bw_can_stream(null_mut(), bytes, 1, 8, Some(send), nothing), BwCode::Null);
        assert_eq!(bw_can_stream(&raw mut number, core::ptr::null(), 1, 8, Some(send), nothing), BwCode::Null);
        assert_eq!(bw_can_stream(&raw mut number, bytes, 1, 8, None, nothing), BwCode::Null);
    }
}
