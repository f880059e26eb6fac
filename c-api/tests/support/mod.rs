//! What the tests share: a state in memory of its own, the models of the examples, and samples for them.

use core::ffi::c_void;
use core::mem::MaybeUninit;
use core::ptr::null_mut;

use bearing_watch::Model;
use bearing_watch::plan::{Plan, Signals};
use bearing_watch_c::{BW_STATE_SIZE, BwAlarm, BwCode, BwState, BwValues, bw_alarm, bw_init, bw_values};

/// The trained model of the standard rig.
pub static FILE: &[u8] = include_bytes!("../../../examples/support/standard_rig/model.bwm");

/// Samples of a trace of the standard rig, and of a segment of its model.
pub const SEGMENT: usize = 5000;

/// Memory for a state, aligned to 8 bytes.
pub struct Memory(Box<[u64]>);

impl Memory {
    pub fn new() -> Self {
        Self(vec![0; BW_STATE_SIZE / 8 + 1].into_boxed_slice())
    }

    pub fn address(&mut self) -> *mut c_void {
        self.0.as_mut_ptr().cast()
    }

    /// Initialises a state in this memory.
    pub fn state(&mut self, model: &[u8]) -> Result<*mut BwState, BwCode> {
        let mut state = null_mut();
        // SAFETY: memory and bytes are there for the whole call.
        let code = unsafe { bw_init(self.address(), BW_STATE_SIZE, model.as_ptr(), model.len(), &raw mut state) };
        if code == BwCode::Ok { Ok(state) } else { Err(code) }
    }
}

/// The binary form of a model.
pub fn bytes<P: Plan>(model: &Model<P>) -> Vec<u8> {
    let mut buffer = vec![0; 1 << 16];
    let length = model.to_bytes("", &mut buffer).expect("fits");
    buffer.truncate(length);
    buffer
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
