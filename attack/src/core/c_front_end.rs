//! The C interface of front end, calibration and check of the wiring: wrong pointers, sizes, constants and orders of
//! calls are refused by a code.

use core::ffi::c_void;
use core::mem::MaybeUninit;
use core::ptr::null_mut;
use std::cell::RefCell;

use bearing_watch_c::{
    BW_CALIBRATION_SIZE, BW_FRONT_END_SIZE, BW_MAX_FURTHER, BW_STATE_SIZE, BW_WIRING_SIZE, BwCalibration,
    BwCalibrationLimits, BwCode, BwFrontEnd, BwFrontEndConstants, BwFrontEndFaults, BwPhaseSensor, BwRawSample,
    BwRefusedOffset, BwState, BwWiring, BwWiringCheck, BwWiringLimits, bw_advance, bw_calibration_finish,
    bw_calibration_init, bw_calibration_push, bw_check_wiring, bw_clear_faults, bw_collect, bw_faults,
    bw_front_end_init, bw_sample_raw, bw_start, bw_stop, bw_wiring_conclude, bw_wiring_init,
};

use crate::input::Input;
use crate::memory;

/// Words of the memory of an object, of which the last one is not given to the library.
const WORDS: usize = BW_FRONT_END_SIZE / 8 + 1;
/// The same of a state.
const OF_STATE: usize = BW_STATE_SIZE / 8 + 1;
/// A model of current, velocity and two further channels.
static MODEL: &[u8] = include_bytes!("../../../examples/support/actuator/model.bwm");
/// What is where nothing may be written.
pub(super) const UNTOUCHED: u64 = 0x5AA5_5AA5_5AA5_5AA5;
/// Calls of an attack, so that a long input is not a slow one.
const CALLS: usize = 40;

/// Memory of a front end, a calibration and a check of the wiring.
type Memory = [[u64; WORDS]; 3];

thread_local! {
    static MEMORY: RefCell<Box<Memory>> = RefCell::new(Box::new([[UNTOUCHED; WORDS]; 3]));
    static STATE: RefCell<Vec<u64>> = RefCell::new(vec![UNTOUCHED; OF_STATE]);
}

/// A good pointer, NULL or a misaligned one.
pub(super) fn either<T>(input: &mut Input<'_>, good: *mut T) -> *mut T {
    match input.byte() {
        0..=7 => null_mut(),
        8..=15 if align_of::<T>() > 1 => good.wrapping_byte_add(1),
        _ => good,
    }
}

/// Calls of any kind.
pub fn attack(bytes: &[u8]) {
    MEMORY.with_borrow_mut(|memory| {
        STATE.with_borrow_mut(|state| {
            let mut input = Input::new(bytes);
            memory::without_allocation(|| run(memory, state, &mut input));
            assert!(memory.iter().all(|own| own[WORDS - 1] == UNTOUCHED), "memory beyond the objects");
            assert_eq!(state[OF_STATE - 1], UNTOUCHED, "memory beyond the state");
        });
    });
}

fn run(memory: &mut Memory, state: &mut [u64], input: &mut Input<'_>) {
    memory.iter_mut().for_each(|own| own[..WORDS - 1].fill(0));
    state[..OF_STATE - 1].fill(0);
    let state: *mut BwState = state.as_mut_ptr().cast();
    let objects: [*mut c_void; 3] = [0, 1, 2].map(|k: usize| memory[k].as_mut_ptr().cast());
    let mut constants = good();
    let mut number = 0;
    for _ in 0..CALLS {
        if input.is_empty() {
            break;
        }
        match input.byte() % 16 {
            0 => init_front_end(objects[0], state, &mut constants, input),
            1 => init_calibration(objects[1], input),
            2 => init_wiring(objects[2], &mut constants, input),
            3 => constants = any(input),
            4..=8 => push(state, &mut number, input),
            9 | 10 => calibrate(objects[1].cast(), &mut constants, input),
            11 | 12 => check_wiring((state, objects[2].cast()), &mut number, input),
            13 => faults(state, input),
            14 => conclude(objects[2].cast(), input),
            _ => {
                // An object of one kind does not pass for another one.
                let wrong: *mut BwWiringCheck = objects[input.below(2)].cast();
                let mut wiring = MaybeUninit::<BwWiring>::uninit();
                // SAFETY: as many bytes as a check has are readable there.
                let code = unsafe { bw_wiring_conclude(wrong, wiring.as_mut_ptr()) };
                assert_eq!(code, BwCode::NotInitialised);
            }
        }
    }
}

/// Constants that are accepted.
fn good() -> BwFrontEndConstants {
    let sensor = BwPhaseSensor { offset_counts: 2048.0, gain_a: 0.02, lowest_counts: 16, highest_counts: 4079 };
    BwFrontEndConstants {
        control_rate_hz: 10_000.0,
        factor: 8,
        further: 2,
        sensors: [sensor; 3],
        stuck_samples: 100,
        balance_window_samples: 32,
        balance_noise_a: 0.1,
        balance_offset_a: 1.0,
        balance_gain_tolerance: 0.02,
        tracking_bandwidth_hz: 300.0,
        tracking_damping: 0.7,
        tracking_error_limit_rad: 0.1,
        tracking_lost_samples: 20,
        tracking_settle_samples: 20,
        resolver_lowest_amplitude: 0.8,
        resolver_highest_amplitude: 1.2,
        resolver_mismatch: 0.05,
        pole_pairs: 6,
        electrical_offset_turn32: 0,
        park: 1,
    }
}

/// The same with one of them of any value.
fn any(input: &mut Input<'_>) -> BwFrontEndConstants {
    let mut own = good();
    match input.byte() % 20 {
        0 => own.control_rate_hz = input.number(),
        1 => own.factor = u16::from(input.byte()),
        2 | 3 => own.further = u16::from(input.byte() % 9),
        4 => own.sensors[input.below(3)].offset_counts = input.number(),
        5 => own.sensors[input.below(3)].gain_a = input.number(),
        6 => own.sensors[input.below(3)].lowest_counts = input.half(),
        7 => own.sensors[input.below(3)].highest_counts = input.half(),
        8 => own.stuck_samples = input.half(),
        9 => own.balance_window_samples = input.half(),
        10 => own.balance_noise_a = input.number(),
        11 => own.tracking_bandwidth_hz = input.number(),
        12 => own.tracking_damping = input.number(),
        13 => own.tracking_error_limit_rad = input.number(),
        14 => (own.tracking_lost_samples, own.tracking_settle_samples) = (input.half(), input.half()),
        15 => own.resolver_lowest_amplitude = input.number(),
        16 => own.resolver_mismatch = input.number(),
        17 => own.pole_pairs = input.word(),
        18 => own.park = i32::from(input.byte()) - 2,
        // The filters of any other factor.
        _ => own.factor = [1, 2, 4, 16, 32, 6, 12, 24, 48, 10, 20, 40][input.below(12)],
    }
    own
}

/// All bytes of an object's memory, or less.
pub(super) fn size(most: usize, input: &mut Input<'_>) -> usize {
    if input.byte().is_multiple_of(8) { usize::from(input.half()) % most } else { most }
}

/// Makes a front end, and starts a state with it.
fn init_front_end(own: *mut c_void, state: *mut BwState, constants: &mut BwFrontEndConstants, input: &mut Input<'_>) {
    let (mut found, mut started): (*mut BwFrontEnd, *mut BwState) = (null_mut(), null_mut());
    let size = size(BW_FRONT_END_SIZE, input);
    let (place, from) = (either(input, own.cast::<u64>()), either(input, constants));
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused. A state that has the
    // memory of the front end has stopped.
    unsafe {
        let stopped = bw_stop(state);
        assert!(matches!(stopped, BwCode::Ok | BwCode::NotInitialised), "{stopped:?}");
        let code = bw_front_end_init(place.cast(), size, from, either(input, &raw mut found));
        assert_eq!(code == BwCode::Ok, found.cast() == own);
        if code == BwCode::Ok {
            let (model, length) = (MODEL.as_ptr(), MODEL.len());
            let code = bw_start(state.cast(), BW_STATE_SIZE, model, length, found, &raw mut started);
            assert_eq!(code == BwCode::Ok, started == state, "{code:?}");
        }
    }
}

fn init_calibration(own: *mut c_void, input: &mut Input<'_>) {
    let mut found: *mut BwCalibration = null_mut();
    let size = size(BW_CALIBRATION_SIZE, input);
    let mut limits = BwCalibrationLimits {
        samples: u16::from(input.byte() % 8),
        lowest_offset_counts: input.number(),
        highest_offset_counts: input.number(),
        lowest_deviation_counts: input.number(),
        highest_deviation_counts: input.number(),
    };
    let (place, from) = (either(input, own.cast::<u64>()), either(input, &raw mut limits));
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    let code = unsafe { bw_calibration_init(place.cast(), size, from, either(input, &raw mut found)) };
    assert_eq!(code == BwCode::Ok, found.cast() == own);
}

fn init_wiring(own: *mut c_void, constants: &mut BwFrontEndConstants, input: &mut Input<'_>) {
    let mut found: *mut BwWiringCheck = null_mut();
    let size = size(BW_WIRING_SIZE, input);
    let mut limits = BwWiringLimits {
        least_current_a: input.number(),
        offset_rad: input.number(),
        delay_s: input.number(),
        velocity_tolerance: input.number(),
        slowest_rad_s: input.number(),
    };
    let (place, limits) = (either(input, own.cast::<u64>()), either(input, &raw mut limits));
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    let code =
        unsafe { bw_wiring_init(place.cast(), size, either(input, constants), limits, either(input, &raw mut found)) };
    assert_eq!(code == BwCode::Ok, found.cast() == own);
}

/// A raw sample of any bits, or one of a motor that turns.
pub(super) fn raw(number: &mut u32, input: &mut Input<'_>) -> BwRawSample {
    *number = if input.byte().is_multiple_of(16) { input.word() } else { number.wrapping_add(1) };
    if input.byte().is_multiple_of(2) {
        let counts = [0_u16, 1, 2].map(|phase| 1500 + (*number as u16).wrapping_mul(7 + phase) % 1000);
        let angle = number.wrapping_mul(20_507_188);
        return BwRawSample {
            number: *number,
            counts,
            phases: 2,
            position: 1,
            angle,
            sin: 0.0,
            cos: 0.0,
            current_a: 0.0,
        };
    }
    BwRawSample {
        number: *number,
        counts: [input.half(), input.half(), input.half()],
        phases: input.byte() % 5,
        position: input.byte() % 4,
        angle: input.word(),
        sin: input.number(),
        cos: input.number(),
        current_a: input.number(),
    }
}

fn push(own: *mut BwState, number: &mut u32, input: &mut Input<'_>) {
    let mut further: [f32; BW_MAX_FURTHER] = [input.number(); BW_MAX_FURTHER];
    let count = if input.byte().is_multiple_of(16) { input.below(BW_MAX_FURTHER) } else { 2 };
    for _ in 0..=input.byte() % 32 {
        let mut raw = raw(number, input);
        let pointers = (either(input, own), either(input, &raw mut raw), either(input, &raw mut further[0]));
        // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
        unsafe {
            if bw_sample_raw(pointers.0, pointers.1, pointers.2, count) == BwCode::Collect {
                let _code = bw_collect(own);
            }
            let _code = bw_advance(own, null_mut(), null_mut());
        }
    }
}

fn calibrate(own: *mut BwCalibration, constants: &mut BwFrontEndConstants, input: &mut Input<'_>) {
    let mut refused = MaybeUninit::<BwRefusedOffset>::uninit();
    let mut counts = [input.half(), input.half(), input.half()];
    let phases = input.byte() % 5;
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    unsafe {
        for _ in 0..=input.byte() % 8 {
            let _code = bw_calibration_push(either(input, own), either(input, counts.as_mut_ptr()), phases);
        }
        let (to, place) = (either(input, constants), either(input, refused.as_mut_ptr()));
        let code = bw_calibration_finish(either(input, own), to, place);
        if code == BwCode::Ok {
            assert!(constants.sensors.iter().all(|sensor| sensor.offset_counts.is_finite()), "{constants:?}");
        }
    }
}

fn check_wiring((own, check): (*mut BwState, *mut BwWiringCheck), number: &mut u32, input: &mut Input<'_>) {
    let velocity_rad_s = input.number();
    for _ in 0..=input.byte() % 32 {
        let mut raw = raw(number, input);
        // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
        let _code = unsafe {
            let pointers = (either(input, own), either(input, &raw mut raw));
            bw_check_wiring(pointers.0, pointers.1, velocity_rad_s, either(input, check))
        };
    }
}

fn faults(own: *mut BwState, input: &mut Input<'_>) {
    let mut faults = MaybeUninit::<BwFrontEndFaults>::uninit();
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    unsafe {
        let code = bw_faults(either(input, own), either(input, faults.as_mut_ptr()));
        if code == BwCode::Ok {
            assert!(!faults.assume_init().gain_error.is_infinite());
        }
        if input.byte().is_multiple_of(2) {
            let _code = bw_clear_faults(own);
        }
    }
}

fn conclude(own: *mut BwWiringCheck, input: &mut Input<'_>) {
    let mut wiring = MaybeUninit::<BwWiring>::uninit();
    // SAFETY: every pointer is NULL, or that of a place of its type, or misaligned and refused.
    unsafe {
        let code = bw_wiring_conclude(either(input, own), either(input, wiring.as_mut_ptr()));
        if code == BwCode::Ok {
            let wiring = wiring.assume_init();
            assert!(!wiring.coherence.is_infinite() && !wiring.offset_rad.is_infinite(), "{wiring:?}");
        }
    }
}
