//! The C interface of the detector: NULL, misaligned memory, wrong sizes and calls out of order are refused by a code,
//! and nothing is written beyond what a caller gave.

use core::ffi::{CStr, c_void};
use core::ptr::{null, null_mut};
use std::cell::RefCell;

use bearing_watch_c::{
    BW_MAX_CHANNELS, BW_STATE_SIZE, BwAlarm, BwCode, BwInfo, BwReport, BwState, BwStatus, bw_advance, bw_alarm,
    bw_angle, bw_check_channel, bw_check_interval, bw_check_park, bw_clock, bw_code_name, bw_collect, bw_end_run,
    bw_error_text, bw_info, bw_label, bw_reason_name, bw_report, bw_reset, bw_restart, bw_restore, bw_sample, bw_save,
    bw_saved_size, bw_start, bw_state_size, bw_status, bw_stop, bw_values, bw_verdict_name,
};

use super::c_front_end::UNTOUCHED;
use crate::input::Input;
use crate::models::BYTES;
use crate::models::numbers::Numbers;
use crate::{checksum, memory};

/// Words of memory, of which the last one is not given to the library.
const WORDS: usize = BW_STATE_SIZE / 8 + 1;
/// Numbers of a list, of which those beyond a capacity are not written.
const LIST: usize = 40;
/// Calls of an attack, so that a long input is not a slow one.
const CALLS: usize = 40;
/// Bytes of a saved state.
const SAVED: usize = 512;

thread_local! {
    static MEMORY: RefCell<Vec<u64>> = RefCell::new(vec![UNTOUCHED; WORDS]);
}

/// What a function that takes a pointer may be given.
fn either<T>(input: &mut Input<'_>, good: *mut T) -> *mut T {
    match input.byte() {
        0..=7 => null_mut(),
        8..=15 => good.wrapping_byte_add(1),
        _ => good,
    }
}

/// Calls of any kind.
pub fn attack(bytes: &[u8]) {
    let _models = BYTES.len();
    MEMORY.with_borrow_mut(|memory| {
        let mut input = Input::new(bytes);
        memory::without_allocation(|| run(memory, &mut input));
        assert_eq!(memory[WORDS - 1], UNTOUCHED, "memory beyond the state");
    });
}

fn run(memory: &mut [u64], input: &mut Input<'_>) {
    // What an earlier attack left there is no state at first.
    memory[..WORDS - 1].fill(0);
    let mut numbers = Numbers(1);
    let own: *mut c_void = memory.as_mut_ptr().cast();
    let mut state: *mut BwState = own.cast();
    for _ in 0..CALLS {
        if input.is_empty() {
            break;
        }
        let call = input.byte() % 24;
        let at = either(input, state);
        let code = match call {
            0 => init(own, &mut state, input),
            1..=5 => sample(at, input, &mut numbers),
            6..=19 => simple(at, call, input),
            20 => values(at, input),
            21 => save(at, input),
            _ => texts(at, input),
        };
        for text in [bw_error_text, bw_code_name, bw_verdict_name, bw_reason_name] {
            // SAFETY: the text of any number is a text that lives as long as the program.
            let text = unsafe { CStr::from_ptr(text(code as i32)) };
            assert!(!text.is_empty());
        }
    }
}

/// Makes a state of a model, some of whose bytes may be changed, in memory that may be wrong.
fn init(own: *mut c_void, state: &mut *mut BwState, input: &mut Input<'_>) -> BwCode {
    let mut model = [0; 4096];
    let good = &BYTES[input.below(BYTES.len())];
    let given = good.len().min(model.len());
    model[..given].copy_from_slice(&good[..given]);
    for _ in 0..input.byte() % 4 {
        model[usize::from(input.half()) % given] = input.byte();
    }
    if input.byte().is_multiple_of(2) {
        checksum::put(&mut model[..given]);
    }
    let length = if input.byte().is_multiple_of(8) { usize::from(input.half()) % model.len() } else { given };
    let size = match input.byte() % 8 {
        0 => usize::from(input.half()) % bw_state_size(),
        1 => bw_state_size(),
        _ => BW_STATE_SIZE,
    };
    let mut found = null_mut();
    let (place, bytes, pointer) =
        (either(input, own), either(input, model.as_mut_ptr()), either(input, &raw mut found));
    // A model is bytes: it is at any address.
    let length = if bytes.is_null() { length } else { length.min(model.len() - 1) };
    // SAFETY: every pointer is NULL, or that of as many bytes, or misaligned and refused.
    let code = unsafe {
        // One that runs is refused, or stopped before.
        if !input.byte().is_multiple_of(8) {
            let _code = bw_stop(*state);
        }
        bw_start(place, size, bytes, length, null_mut(), pointer)
    };
    if code == BwCode::Ok {
        assert!(!found.is_null() && found.cast() == own && size >= bw_state_size());
        *state = found;
    } else {
        assert!(found.is_null());
    }
    code
}

/// Takes samples, ordinary ones or of any bits.
fn sample(at: *mut BwState, input: &mut Input<'_>, numbers: &mut Numbers) -> BwCode {
    let mut code = BwCode::Ok;
    let (how, times) = (input.byte(), 1 + input.byte() % 64);
    let count = if how & 0x0F == 0 { input.below(BW_MAX_CHANNELS) } else { channels(at).unwrap_or(3) };
    for k in 0..times {
        let mut values: [f32; BW_MAX_CHANNELS] = numbers.array();
        if how & 0x70 == 0 {
            values.iter_mut().take(3).for_each(|value| *value = input.number());
        }
        let pointer = if how == 255 { either(input, values.as_mut_ptr()) } else { values.as_mut_ptr() };
        let angle = bw_angle(u32::from(k).wrapping_mul(48), u32::from(how));
        // SAFETY: the pointer is NULL, or that of as many numbers, or misaligned and refused.
        code = unsafe { bw_sample(at, pointer, count, angle) };
        // Now and then the lower interrupt is late.
        if how & 0x80 == 0 || k % 8 == 0 {
            // SAFETY: the state is NULL, one, or misaligned and refused.
            let _code = unsafe { bw_collect(at) };
        }
    }
    code
}

fn channels(at: *mut BwState) -> Option<usize> {
    let mut info = core::mem::MaybeUninit::<BwInfo>::uninit();
    // SAFETY: the place is that of the whole result, which is there if the code says so.
    unsafe { (bw_info(at, info.as_mut_ptr()) == BwCode::Ok).then(|| usize::from(info.assume_init().channels)) }
}

/// Functions with one argument besides the state.
fn simple(at: *mut BwState, call: u8, input: &mut Input<'_>) -> BwCode {
    let mut status = core::mem::MaybeUninit::<BwStatus>::uninit();
    let (mut report, mut alarm) =
        (core::mem::MaybeUninit::<BwReport>::uninit(), core::mem::MaybeUninit::<BwAlarm>::uninit());
    let pointers = (either(input, report.as_mut_ptr()), either(input, alarm.as_mut_ptr()));
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    unsafe {
        match call {
            6 => bw_restart(at),
            7 => bw_stop(at),
            8 => bw_status(at, either(input, status.as_mut_ptr())),
            9..=12 => bw_advance(at, pointers.0, pointers.1),
            13 => bw_clock(at, input.word()),
            14 | 15 => {
                let code = bw_report(at, pointers.0);
                if code == BwCode::Ok {
                    let report = report.assume_init();
                    assert!(report.distance.is_finite() && report.surprise.is_finite(), "{report:?}");
                }
                code
            }
            16 => {
                let code = bw_alarm(at, pointers.1);
                if code == BwCode::Ok {
                    let alarm = alarm.assume_init();
                    assert!(alarm.score.is_finite() && alarm.undetermined <= alarm.segments, "{alarm:?}");
                }
                code
            }
            17 => bw_end_run(at, null_mut(), 0, null_mut()),
            18 => bw_reset(at),
            _ => bw_check_park(at, i32::from(input.byte()) - 4),
        }
    }
}

/// A list of numbers, of which nothing is written beyond the capacity.
fn values(at: *mut BwState, input: &mut Input<'_>) -> BwCode {
    let mark = f32::from_bits(0x7FC0_5AA5);
    let (mut list, mut count) = ([mark; LIST], 0_usize);
    let (what, capacity) = (i32::from(input.byte() % 20) - 2, input.below(LIST));
    let (place, number) = (either(input, list.as_mut_ptr()), either(input, &raw mut count));
    // SAFETY: every pointer is NULL, or that of as many numbers, or misaligned and refused.
    let code = unsafe { bw_values(at, what, place, capacity, number) };
    let untouched = if matches!(code, BwCode::Ok | BwCode::BufferTooSmall) { count.min(capacity) } else { 0 };
    assert!(list[untouched..].iter().all(|value| value.to_bits() == mark.to_bits()), "{code:?} {what} {capacity}");
    code
}

/// Saves, and restores bytes of which some may be changed.
fn save(at: *mut BwState, input: &mut Input<'_>) -> BwCode {
    let (mut bytes, mut length) = ([0xA5; SAVED], 0_usize);
    let capacity = if input.byte().is_multiple_of(4) { usize::from(input.half()) % SAVED } else { SAVED };
    // SAFETY: every pointer is NULL, or that of as many bytes, or misaligned and refused.
    let code = unsafe {
        let _code = bw_saved_size(at, either(input, &raw mut length));
        bw_save(at, if input.byte() == 0 { null_mut() } else { bytes.as_mut_ptr() }, capacity)
    };
    assert!(bytes[capacity..].iter().all(|byte| *byte == 0xA5), "nothing is written beyond the capacity");
    for _ in 0..input.byte() % 4 {
        bytes[usize::from(input.half()) % SAVED] = input.byte();
    }
    let length = length.min(SAVED);
    if input.byte().is_multiple_of(2) {
        checksum::put(&mut bytes[..length]);
    }
    // SAFETY: as many bytes are there.
    let restored = unsafe { bw_restore(at, if input.byte() == 0 { null() } else { bytes.as_ptr() }, length) };
    if code == BwCode::Ok { restored } else { code }
}

/// Labels, names and intervals.
fn texts(at: *mut BwState, input: &mut Input<'_>) -> BwCode {
    let mut text = [1; 20];
    let capacity = input.below(text.len());
    let names = [c"current_a", c"velocity_ref_rad_s", c"", c"\xFF\xFE", c"N\xC2\xB7m"];
    let (name, unit) = (names[input.below(names.len())].as_ptr(), names[input.below(names.len())].as_ptr());
    let (class, channel) = (input.byte() % 8, input.byte() % 10);
    // SAFETY: every pointer is NULL, or that of a text that ends, or that of as many bytes.
    let code = unsafe {
        let _code = bw_check_channel(at, channel, if input.byte() == 0 { null() } else { name }, unit);
        let _code = bw_check_interval(at, input.number());
        bw_label(at, class, if input.byte() == 0 { null_mut() } else { text.as_mut_ptr() }, capacity)
    };
    assert!(text[capacity..].iter().all(|byte| *byte == 1), "nothing is written beyond the capacity");
    code
}
