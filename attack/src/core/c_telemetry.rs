//! The C interface of recorders and frames: wrong pointers, sizes and orders of calls are refused by a code, and every
//! frame that is written is one that a receiver takes.

use core::ffi::c_void;
use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};
use std::cell::RefCell;

use bearing_watch::telemetry::Decoder;
use bearing_watch_c::{
    BW_FRAME_SIZE, BW_MAX_CHANNELS, BW_MAX_FURTHER, BW_RAW_RECORDER_SIZE, BW_RECORDER_SIZE, BW_STATE_SIZE,
    BW_TELEMETRY_SIZE, BwCode, BwInfo, BwRawRecorder, BwRecorder, BwState, BwTelemetry, bw_collect_recorded, bw_info,
    bw_raw_recorder_init, bw_raw_recorder_push, bw_recorder_init, bw_recorder_push, bw_recorder_skip, bw_sample,
    bw_start, bw_stop, bw_telemetry_hello, bw_telemetry_init, bw_telemetry_raw, bw_telemetry_report,
    bw_telemetry_samples,
};

use super::c_front_end::{UNTOUCHED, either, raw, size};
use crate::input::Input;
use crate::memory;
use crate::models::BYTES;
use crate::models::numbers::Numbers;

/// Words of the memory of a state, and of another object; the last one of each is not given to the library.
const STATE: usize = BW_STATE_SIZE / 8 + 1;
const WORDS: usize = BW_RECORDER_SIZE / 8 + 1;
/// Calls of an attack, so that a long input is not a slow one.
const CALLS: usize = 60;

/// Memory of a state, and of a line, a recorder and a recorder of raw samples.
struct Memory {
    state: [u64; STATE],
    objects: [[u64; WORDS]; 3],
    receiver: Decoder<BW_FRAME_SIZE>,
}

thread_local! {
    static MEMORY: RefCell<Box<Memory>> = RefCell::new(Box::new(Memory {
        state: [UNTOUCHED; STATE],
        objects: [[UNTOUCHED; WORDS]; 3],
        receiver: Decoder::new(),
    }));
}

/// Calls of any kind.
pub fn attack(bytes: &[u8]) {
    let _models = BYTES.len();
    MEMORY.with_borrow_mut(|memory| {
        let mut input = Input::new(bytes);
        memory::without_allocation(|| run(memory, &mut input));
        assert_eq!(memory.state[STATE - 1], UNTOUCHED, "memory beyond the state");
        assert!(memory.objects.iter().all(|own| own[WORDS - 1] == UNTOUCHED), "memory beyond the objects");
    });
}

fn run(memory: &mut Memory, input: &mut Input<'_>) {
    memory.objects.iter_mut().for_each(|own| own[..WORDS - 1].fill(0));
    let [line, recorder, raw_recorder]: [*mut c_void; 3] = [0, 1, 2].map(|k| memory.objects[k].as_mut_ptr().cast());
    let receiver = &mut memory.receiver;
    *receiver = Decoder::new();
    let (state, channels) = state(&mut memory.state, input);
    let (mut number, mut numbers) = (0, Numbers(1));
    for _ in 0..CALLS {
        if input.is_empty() {
            break;
        }
        match input.byte() % 16 {
            0 => init_line(line, state, input),
            1 => init_recorder(recorder, state, input),
            2 => init_raw_recorder(raw_recorder, input),
            3..=6 => push((recorder.cast(), state), channels, &mut numbers, input),
            7 => {
                // SAFETY: the pointer is NULL, or that of a place of its type, or misaligned and refused.
                let _code = unsafe { bw_recorder_skip(either(input, recorder.cast()), input.word()) };
            }
            8..=10 => push_raw(raw_recorder.cast(), &mut number, input),
            kind => send((line.cast(), recorder.cast(), raw_recorder.cast()), kind, receiver, input),
        }
    }
}

/// A state of one of the models, and the number of its channels.
fn state(memory: &mut [u64], input: &mut Input<'_>) -> (*mut BwState, usize) {
    let (model, mut state) = (&BYTES[input.below(BYTES.len())], null_mut());
    let mut info = MaybeUninit::<BwInfo>::uninit();
    // SAFETY: memory, model and the place of the result are there; a result is there if the code says so.
    unsafe {
        let _stopped = bw_stop(memory.as_mut_ptr().cast());
        let (place, first, none) = (memory.as_mut_ptr().cast(), model.as_ptr(), null_mut());
        let code = bw_start(place, BW_STATE_SIZE, first, model.len(), none, &raw mut state);
        // A model of other sizes: every call finds no state.
        if code != BwCode::Ok || bw_info(state, info.as_mut_ptr()) != BwCode::Ok {
            return (null_mut(), 0);
        }
        (state, usize::from(info.assume_init().channels))
    }
}

fn init_line(own: *mut c_void, state: *mut BwState, input: &mut Input<'_>) {
    let mut found: *mut BwTelemetry = null_mut();
    let of = if input.byte().is_multiple_of(8) { null() } else { state.cast_const() };
    let size = size(BW_TELEMETRY_SIZE, input);
    let place = either(input, own.cast::<u64>()).cast();
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    let code = unsafe { bw_telemetry_init(place, size, of, 1, input.word(), either(input, &raw mut found)) };
    assert_eq!(code == BwCode::Ok, found.cast() == own);
}

fn init_recorder(own: *mut c_void, state: *mut BwState, input: &mut Input<'_>) {
    let mut found: *mut BwRecorder = null_mut();
    let size = size(BW_RECORDER_SIZE, input);
    let place = either(input, own.cast::<u64>()).cast();
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    let code = unsafe { bw_recorder_init(place, size, either(input, state), either(input, &raw mut found)) };
    assert_eq!(code == BwCode::Ok, found.cast() == own);
}

fn init_raw_recorder(own: *mut c_void, input: &mut Input<'_>) {
    let mut found: *mut BwRawRecorder = null_mut();
    let size = size(BW_RAW_RECORDER_SIZE, input);
    let place = either(input, own.cast::<u64>()).cast();
    let rate_hz = if input.byte().is_multiple_of(4) { input.number() } else { 10_000.0 };
    let further = if input.byte().is_multiple_of(4) { input.half() } else { 2 };
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    let code = unsafe { bw_raw_recorder_init(place, size, rate_hz, further, either(input, &raw mut found)) };
    assert_eq!(code == BwCode::Ok, found.cast() == own);
}

/// Samples for the recorder and for the detector, which then has reports to send.
fn push((own, state): (*mut BwRecorder, *mut BwState), channels: usize, numbers: &mut Numbers, input: &mut Input<'_>) {
    let count = if input.byte().is_multiple_of(16) { input.below(BW_MAX_CHANNELS + 1) } else { channels };
    let (own, any) = (either(input, own), input.byte().is_multiple_of(4));
    for _ in 0..=input.byte() {
        let mut values: [f32; BW_MAX_CHANNELS] = numbers.array();
        if any {
            values[0] = input.number();
        }
        let first = either(input, &raw mut values[0]);
        // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
        unsafe {
            let _codes = [bw_recorder_push(own, first, count, 7), bw_sample(state, first, count, 7)];
            let _code = bw_collect_recorded(state, own);
        }
    }
}

fn push_raw(own: *mut BwRawRecorder, number: &mut u32, input: &mut Input<'_>) {
    let mut further: [f32; BW_MAX_FURTHER] = [input.number(); BW_MAX_FURTHER];
    let count = if input.byte().is_multiple_of(16) { input.below(BW_MAX_FURTHER) } else { 2 };
    for _ in 0..=input.byte() % 64 {
        let mut raw = raw(number, input);
        let pointers = (either(input, own), either(input, &raw mut raw), either(input, &raw mut further[0]));
        // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
        let _code = unsafe { bw_raw_recorder_push(pointers.0, pointers.1, pointers.2, count) };
    }
}

/// Writes a frame; a receiver takes it.
fn send(
    (line, recorder, raw_recorder): (*mut BwTelemetry, *mut BwRecorder, *mut BwRawRecorder),
    kind: u8,
    receiver: &mut Decoder<BW_FRAME_SIZE>,
    input: &mut Input<'_>,
) {
    let (mut buffer, mut length) = ([0xAA_u8; BW_FRAME_SIZE], usize::MAX);
    let capacity = size(BW_FRAME_SIZE, input);
    let line = either(input, line);
    let bytes = if input.byte() < 8 { null_mut() } else { buffer.as_mut_ptr() };
    let place = either(input, &raw mut length);
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    let code = unsafe {
        match kind {
            11 => bw_telemetry_hello(line, bytes, capacity, place),
            12 => bw_telemetry_report(line, bytes, capacity, place),
            13 | 14 => bw_telemetry_samples(line, either(input, recorder), bytes, capacity, place),
            _ => bw_telemetry_raw(line, either(input, raw_recorder), bytes, capacity, place),
        }
    };
    assert!(buffer[capacity..].iter().all(|byte| *byte == 0xAA), "bytes beyond the capacity");
    if code != BwCode::Ok {
        assert_eq!(length, usize::MAX, "{code:?}");
        return;
    }
    assert!(length <= capacity);
    let before = receiver.counts();
    for byte in &buffer[..length] {
        receiver.push(*byte);
    }
    let counts = receiver.counts();
    // A line that was initialised again starts to count anew.
    assert_eq!(counts.frames + counts.repeated, before.frames + before.repeated + 1, "{kind} {counts:?}");
    assert_eq!((counts.bad, counts.oversize, counts.unknown), (0, 0, 0), "{kind}");
}
