//! Through the C functions the frames are those of the Rust core, byte for byte; blocks wait for the main loop; what is
//! wrong is refused.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

#[allow(dead_code, reason = "only its raw samples are used")]
#[path = "support/drive.rs"]
mod drive;
#[allow(dead_code, reason = "only its model and samples are used")]
#[path = "../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::ptr::{null, null_mut};

use bearing_watch::plan::Signals;
use bearing_watch::telemetry::{Body, Decoder, Encoder, RawEncoder, RawRecorder, Recorder, Source};
use bearing_watch::{Detector, Evidence};
use bearing_watch_c::*;

use drive::{raw, raw_for_c};
use standard_rig::model::MODEL;
use support::{FILE, Memory, channels};

const SOURCE: Source = Source { model_id: 7, session: 9 };
const BLOCK: usize = BW_BLOCK_BYTES;

/// Calls of functions on memory of the test.
macro_rules! call {
    ($($call:tt)*) => {
        // SAFETY: every pointer is NULL, misaligned, or that of memory that the test owns.
        unsafe { $($call)* }
    };
}

/// Memory of a line and of recorders.
struct Room(Box<[[u64; 160]; 3]>);

impl Room {
    fn new() -> Self {
        Self(Box::new([[0; 160]; 3]))
    }

    fn line(&mut self, state: *const BwState) -> Result<*mut BwTelemetry, BwCode> {
        let (place, mut own) = (self.0[0].as_mut_ptr().cast(), null_mut());
        let Source { model_id, session } = SOURCE;
        match call!(bw_telemetry_init(place, BW_TELEMETRY_SIZE, state, model_id, session, &raw mut own)) {
            BwCode::Ok => Ok(own),
            code => Err(code),
        }
    }

    fn recorder(&mut self, state: *const BwState) -> Result<*mut BwRecorder, BwCode> {
        let (place, mut own) = (self.0[1].as_mut_ptr().cast(), null_mut());
        match call!(bw_recorder_init(place, BW_RECORDER_SIZE, state, &raw mut own)) {
            BwCode::Ok => Ok(own),
            code => Err(code),
        }
    }

    fn raw_recorder(&mut self, rate_hz: f32, further: u16) -> Result<*mut BwRawRecorder, BwCode> {
        let (place, mut own) = (self.0[2].as_mut_ptr().cast(), null_mut());
        match call!(bw_raw_recorder_init(place, BW_RAW_RECORDER_SIZE, rate_hz, further, &raw mut own)) {
            BwCode::Ok => Ok(own),
            code => Err(code),
        }
    }
}

/// The frame that a function writes.
fn frame(write: impl FnOnce(*mut u8, usize, *mut usize) -> BwCode) -> Result<Vec<u8>, BwCode> {
    let (mut buffer, mut length) = (vec![0; BW_FRAME_SIZE], 0);
    match write(buffer.as_mut_ptr(), buffer.len(), &raw mut length) {
        BwCode::Ok => Ok(buffer[..length].to_vec()),
        code => Err(code),
    }
}

fn hello(line: *mut BwTelemetry) -> Result<Vec<u8>, BwCode> {
    frame(|buffer, capacity, length| call!(bw_telemetry_hello(line, buffer, capacity, length)))
}

fn report(line: *mut BwTelemetry) -> Result<Vec<u8>, BwCode> {
    frame(|buffer, capacity, length| call!(bw_telemetry_report(line, buffer, capacity, length)))
}

fn samples(line: *mut BwTelemetry, recorder: *mut BwRecorder) -> Result<Vec<u8>, BwCode> {
    frame(|buffer, capacity, length| call!(bw_telemetry_samples(line, recorder, buffer, capacity, length)))
}

fn raw_samples(line: *mut BwTelemetry, recorder: *mut BwRawRecorder) -> Result<Vec<u8>, BwCode> {
    frame(|buffer, capacity, length| call!(bw_telemetry_raw(line, recorder, buffer, capacity, length)))
}

#[test]
fn frames_are_those_of_the_core() {
    let (mut memory, mut room) = (Memory::new(), Room::new());
    let state = memory.state(FILE).expect("good model");
    let (line, recorder) = (room.line(state).expect("a line"), room.recorder(state).expect("a recorder"));
    let mut detector = Detector::new(&MODEL);
    let mut evidence = Evidence::new(&MODEL);
    let mut encoder = Encoder::new(&MODEL, SOURCE);
    let mut own = Recorder::<_, BLOCK>::new(MODEL.plan());
    let mut buffer = [0; BW_FRAME_SIZE];
    assert_eq!(report(line), Err(BwCode::NoReport));
    assert_eq!(hello(line).unwrap(), encoder.hello(&mut buffer).unwrap());
    let (mut blocks, mut reports) = (0, 0);
    for (number, sample) in standard_rig::samples().enumerate() {
        let values = channels(&MODEL, &sample);
        let (first, count, angle) = (values.as_ptr(), values.len(), sample.angle().bits());
        let code = call!(bw_recorder_push(recorder, first, count, angle));
        if own.push(&sample) {
            assert_eq!(code, BwCode::Block);
            assert_eq!(samples(line, recorder).unwrap(), encoder.samples(&own.block(), &mut buffer).unwrap());
            own.clear();
            blocks += 1;
        } else {
            assert_eq!(code, BwCode::Ok, "{number}");
        }
        let code = support::step(state, &values, angle);
        if let Some(found) = detector.step(&sample) {
            assert_eq!(code, BwCode::Report);
            evidence.observe(found.decision.as_ref());
            assert_eq!(report(line).unwrap(), encoder.report(&found, &evidence, &mut buffer).unwrap());
            own.skip(1);
            assert_eq!(call!(bw_recorder_skip(recorder, 1)), BwCode::Ok);
            reports += 1;
        }
    }
    assert_eq!((blocks, reports), (3 * 125, 3));
}

#[test]
fn raw_frames_are_those_of_the_core_with_and_without_a_model() {
    let (mut memory, mut room) = (Memory::new(), Room::new());
    let state = memory.state(FILE).expect("good model");
    let recorder = room.raw_recorder(drive::RATE_HZ, 2).expect("a recorder");
    let mut own = RawRecorder::<2, BLOCK>::new(drive::RATE_HZ);
    let mut buffer = [0; BW_FRAME_SIZE];
    for with_model in [false, true] {
        let line = room.line(if with_model { state } else { null_mut() }).expect("a line");
        let (mut encoder, mut without) = (Encoder::new(&MODEL, SOURCE), RawEncoder::new(SOURCE));
        let mut blocks = 0;
        for number in 0..240 {
            let sample = raw(number);
            let code = call!(bw_raw_recorder_push(recorder, &raw_for_c(&sample), sample.further.as_ptr(), 2));
            if own.push(&sample) {
                assert_eq!(code, BwCode::Block);
                let block = own.block();
                let frame =
                    if with_model { encoder.raw(&block, &mut buffer) } else { without.raw(&block, &mut buffer) };
                assert_eq!(raw_samples(line, recorder).unwrap(), frame.unwrap());
                own.clear();
                blocks += 1;
            } else {
                assert_eq!(code, BwCode::Ok);
            }
        }
        assert_eq!(blocks, 10);
    }
}

/// The interrupt goes on while a block waits; a main loop that is too slow leaves a gap that the receiver sees.
#[test]
fn a_block_waits_while_the_next_one_is_filled_and_then_samples_are_left_out() {
    let (mut memory, mut room) = (Memory::new(), Room::new());
    let state = memory.state(FILE).expect("good model");
    let (line, recorder) = (room.line(state).expect("a line"), room.recorder(state).expect("a recorder"));
    let push = || call!(bw_recorder_push(recorder, [1.0_f32; 3].as_ptr(), 3, 0));
    let each = BLOCK / 12;
    let codes: Vec<_> = (0..2 * each + 5).map(|_| push()).collect();
    let complete = codes.iter().position(|code| *code == BwCode::Block);
    assert_eq!(complete, Some(each - 1));
    assert!(codes[each..2 * each].iter().all(|code| *code == BwCode::Ok));
    assert!(codes[2 * each..].iter().all(|code| *code == BwCode::RecorderFull));
    let mut decoder = Decoder::<1024>::new();
    let mut firsts = Vec::new();
    let mut receive = |bytes: Vec<u8>| {
        for byte in bytes {
            if let Some(Body::Samples(block)) = decoder.push(byte).map(|frame| frame.body) {
                firsts.push((block.first as usize, block.len()));
            }
        }
    };
    receive(hello(line).unwrap());
    receive(samples(line, recorder).unwrap());
    assert_eq!(samples(line, recorder), Err(BwCode::Idle), "the second block is handed over by the next sample");
    assert_eq!(push(), BwCode::Ok);
    receive(samples(line, recorder).unwrap());
    (1..each).for_each(|_| assert_ne!(push(), BwCode::RecorderFull));
    receive(samples(line, recorder).unwrap());
    assert_eq!(push(), BwCode::Ok);
    assert_eq!(call!(bw_recorder_skip(recorder, 3)), BwCode::Block);
    receive(samples(line, recorder).unwrap());
    assert_eq!(call!(bw_recorder_skip(recorder, 3)), BwCode::Ok, "an empty block is none");
    (0..each).for_each(|_| assert_ne!(push(), BwCode::RecorderFull));
    receive(samples(line, recorder).unwrap());
    let last = 3 * each + 5;
    assert_eq!(firsts, [(0, each), (each, each), (2 * each + 5, each), (last, 1), (last + 7, each)]);
}

#[test]
fn what_is_wrong_is_refused_and_changes_nothing() {
    let (mut memory, mut room) = (Memory::new(), Room::new());
    let state = memory.state(FILE).expect("good model");
    assert_eq!(room.line(memory.address().wrapping_byte_add(8).cast()), Err(BwCode::NotInitialised));
    assert_eq!(room.recorder(null()), Err(BwCode::Null));
    let wrong = [0.0, -1.0, f32::NAN, f32::INFINITY].map(|rate_hz| room.raw_recorder(rate_hz, 0));
    assert_eq!(wrong, [Err(BwCode::FrontEndControlRate); 4]);
    let wrong = [BW_MAX_FURTHER as u16 + 1, u16::MAX].map(|further| room.raw_recorder(1e4, further));
    assert_eq!(wrong, [Err(BwCode::FrontEndFurther); 2]);

    let without = room.line(null()).expect("a line");
    let recorder = room.recorder(state).expect("a recorder");
    assert_eq!([hello(without), report(without)], [const { Err(BwCode::NotInitialised) }; 2]);
    assert_eq!(samples(without, recorder), Err(BwCode::NotInitialised));
    assert_eq!(samples(without, null_mut()), Err(BwCode::Null));
    assert_eq!(raw_samples(null_mut(), room.raw_recorder(1e4, 0).expect("a recorder")), Err(BwCode::Null));
    assert_eq!(raw_samples(without, recorder.cast()), Err(BwCode::NotInitialised), "another kind of recorder");

    let line = room.line(state).expect("a line");
    let push = |count| call!(bw_recorder_push(recorder, [1.0_f32; 4].as_ptr(), count, 0));
    assert_eq!([push(2), push(4)], [BwCode::WrongChannelCount; 2]);
    assert_eq!(call!(bw_recorder_push(recorder, null(), 3, 0)), BwCode::Null);
    (0..BLOCK / 12).for_each(|_| assert!(push(3) as i32 >= 0));
    let (mut buffer, mut length) = (vec![0; BW_FRAME_SIZE], 0);
    let (bytes, place) = (buffer.as_mut_ptr(), &raw mut length);
    call!({
        assert_eq!(bw_telemetry_samples(line, recorder, null_mut(), BW_FRAME_SIZE, place), BwCode::Null);
        assert_eq!(bw_telemetry_samples(line, recorder, bytes, BW_FRAME_SIZE, null_mut()), BwCode::Null);
        for capacity in [0, 1, BLOCK] {
            let code = bw_telemetry_samples(line, recorder, bytes, capacity, place);
            assert_eq!(code, BwCode::BufferTooSmall, "{capacity}");
            assert_eq!(bw_telemetry_hello(line, bytes, capacity.min(60), place), BwCode::BufferTooSmall);
        }
    });
    assert_eq!(length, 0);
    let mut other = Encoder::new(&MODEL, SOURCE);
    let mut own = Recorder::<_, BLOCK>::new(MODEL.plan());
    let sample = Signals::of(&[1.0; 3], bearing_watch::Angle::ZERO);
    while !own.push(&sample) {}
    let frame = samples(line, recorder).unwrap();
    assert_eq!(frame, other.samples(&own.block(), &mut buffer).unwrap(), "it still waited, with the same number");
}

#[test]
fn sizes_are_enough_and_not_much_too_large() {
    for (own, size) in [
        (size_of::<BwTelemetry>(), BW_TELEMETRY_SIZE),
        (size_of::<BwRecorder>(), BW_RECORDER_SIZE),
        (size_of::<BwRawRecorder>(), BW_RAW_RECORDER_SIZE),
    ] {
        assert!((0.9..=1.0).contains(&(own as f64 / size as f64)), "{own} of {size}");
    }
}
