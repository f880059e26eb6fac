//! What the tests share: a state in memory of its own, the models of the examples, and samples for them.

use core::ffi::c_void;
use core::mem::MaybeUninit;
use core::ptr::null_mut;

use bearing_watch::Model;
use bearing_watch::plan::{Plan, Signals};
use bearing_watch_c::{
    BW_FRONT_END_SIZE, BW_STATE_SIZE, BwAlarm, BwCode, BwFrontEnd, BwFrontEndConstants, BwState, BwValues, bw_advance,
    bw_alarm, bw_collect, bw_front_end_init, bw_sample, bw_start, bw_stop, bw_values,
};

/// The trained model of the standard rig.
pub static FILE: &[u8] = include_bytes!("../../../examples/support/standard_rig/model.bwm");

/// That of the simulated actuator, behind a front end.
pub static ACTUATOR: &[u8] = include_bytes!("../../../examples/support/actuator/model.bwm");

/// Samples of a trace of the standard rig, and of a segment of its model.
pub const SEGMENT: usize = 5000;

/// Memory for a state and a front end, aligned to 8 bytes.
pub struct Memory(Box<[u64]>, Box<[u64]>);

impl Memory {
    pub fn new() -> Self {
        Self(vec![0; BW_STATE_SIZE / 8 + 1].into(), vec![0; BW_FRONT_END_SIZE / 8].into())
    }

    pub fn address(&mut self) -> *mut c_void {
        self.0.as_mut_ptr().cast()
    }

    /// Starts a drive with signals of its own in this memory.
    pub fn state(&mut self, model: &[u8]) -> Result<*mut BwState, BwCode> {
        self.start(model, null_mut())
    }

    /// Starts a drive with raw counts.
    pub fn drive(&mut self, model: &[u8], constants: &BwFrontEndConstants) -> Result<*mut BwState, BwCode> {
        let (mut front_end, memory) = (null_mut(), self.1.as_mut_ptr().cast());
        // SAFETY: memory and constants are there for the whole call.
        match unsafe { bw_front_end_init(memory, BW_FRONT_END_SIZE, constants, &raw mut front_end) } {
            BwCode::Ok => self.start(model, front_end),
            code => Err(code),
        }
    }

    fn start(&mut self, model: &[u8], front_end: *mut BwFrontEnd) -> Result<*mut BwState, BwCode> {
        let (mut state, memory) = (null_mut(), self.address());
        let (first, length) = (model.as_ptr(), model.len());
        // SAFETY: memory and bytes are there for the whole call.
        let code = unsafe { bw_start(memory, BW_STATE_SIZE, first, length, front_end, &raw mut state) };
        if code == BwCode::Ok { Ok(state) } else { Err(code) }
    }

    /// The same where a state runs already.
    pub fn again(&mut self, model: &[u8]) -> Result<*mut BwState, BwCode> {
        // SAFETY: the memory is that of a state.
        assert_eq!(unsafe { bw_stop(self.address().cast()) }, BwCode::Ok);
        self.state(model)
    }
}

/// The binary form of a model.
pub fn bytes<P: Plan>(model: &Model<P>) -> Vec<u8> {
    let mut buffer = vec![0; 1 << 16];
    let length = model.to_bytes("", &mut buffer).expect("fits");
    buffer.truncate(length);
    buffer
}

/// Takes a sample in one context; `BW_CODE_SEGMENT` with the one that closes a segment.
pub fn collect(state: *mut BwState, values: &[f32], angle: u32) -> BwCode {
    // SAFETY: the state is one of the tests', and the values are there.
    unsafe {
        match bw_sample(state, values.as_ptr(), values.len(), angle) {
            BwCode::Collect => bw_collect(state),
            code => code,
        }
    }
}

/// Solves a closed segment; returns the last code.
pub fn conclude(state: *mut BwState) -> BwCode {
    loop {
        // SAFETY: the state is one of the tests'.
        match unsafe { bw_advance(state, null_mut(), null_mut()) } {
            BwCode::Ok => {}
            code => return code,
        }
    }
}

/// Takes a sample and solves at once; `BW_CODE_REPORT` with the one that closes a segment.
pub fn step(state: *mut BwState, values: &[f32], angle: u32) -> BwCode {
    match collect(state, values, angle) {
        BwCode::Segment => conclude(state),
        code => code,
    }
}

/// The channels of a sample.
pub fn channels<P: Plan>(model: &Model<P>, sample: &P::Sample) -> Vec<f32> {
    (0..usize::from(model.plan().layout().channels)).map(|channel| sample.value(channel)).collect()
}

/// A list of numbers of the last report.
pub fn values(state: *mut BwState, what: BwValues) -> Vec<f32> {
    let (mut values, mut count) = (vec![0.0; 64], 0);
    // SAFETY: the state is initialised, and the buffer has 64 elements.
    let code = unsafe { bw_values(state, what as i32, values.as_mut_ptr(), values.len(), &raw mut count) };
    assert_eq!(code, BwCode::Ok);
    values.truncate(count);
    values
}

/// The alarm of a state.
pub fn alarm(state: *mut BwState) -> BwAlarm {
    let mut alarm = MaybeUninit::<BwAlarm>::uninit();
    // SAFETY: the state is initialised; the alarm is written if the code says so.
    unsafe {
        assert_eq!(bw_alarm(state, alarm.as_mut_ptr()), BwCode::Ok);
        alarm.assume_init()
    }
}
