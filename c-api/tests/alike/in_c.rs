//! A drive whose firmware is in C.

use core::mem::MaybeUninit;

use bearing_watch::drive::RawSample;
use bearing_watch::{Alarm, Cause, Model};
use bearing_watch_c::*;

use crate::actuator::Drive;
use crate::cases::{Action, Fields, Told};
use crate::drive::{CONSTANTS, for_c, raw_for_c};
use crate::support::{Memory, bytes};
use crate::{LIMITS, SILENCE, Side};

pub struct C(*mut BwState, Memory, Vec<u8>);

impl C {
    pub fn new(model: &'static Model<Drive>) -> Self {
        let (mut memory, bytes) = (Memory::new(), bytes(model));
        let state = memory.drive(&bytes, &for_c(&CONSTANTS, 10, 2)).expect("it starts");
        let own = Self(state, memory, bytes);
        own.limit();
        own
    }

    fn limit(&self) {
        // SAFETY: the state runs.
        let code = unsafe { bw_limit_liveness(self.0, LIMITS.sample_s, LIMITS.segment_s, LIMITS.verdict_s) };
        assert_eq!(code, BwCode::Ok);
    }
}

// In all of them the state runs, and the places are writable; what is read was written if the code says so.
impl Side for C {
    fn sample(&mut self, reading: &RawSample<2>) {
        // SAFETY: as above.
        let code = unsafe { bw_sample_raw(self.0, &raw_for_c(reading), reading.further.as_ptr(), 2) };
        assert!(matches!(code, BwCode::Ok | BwCode::Collect), "{code:?}");
    }

    fn collect(&mut self) {
        // SAFETY: as above.
        unsafe { bw_collect(self.0) };
    }

    fn advance(&mut self) -> Option<Told> {
        let (mut report, mut alarm) = (MaybeUninit::<BwReport>::uninit(), MaybeUninit::<BwAlarm>::uninit());
        // SAFETY: as above.
        let (code, report, alarm) = unsafe {
            let code = bw_advance(self.0, report.as_mut_ptr(), alarm.as_mut_ptr());
            if !matches!(code, BwCode::Report | BwCode::Withdrawn) {
                return None;
            }
            (code, report.assume_init(), alarm.assume_init())
        };
        let cause = match alarm {
            BwAlarm { known: true, class_index, .. } => Cause::Class(class_index),
            BwAlarm { fallen: true, coordinate, .. } => Cause::Fallen(coordinate),
            BwAlarm { risen: true, coordinate, .. } => Cause::Coordinate(coordinate),
            _ => Cause::Unknown,
        };
        let fields = Fields {
            verdict: report.verdict,
            class: [report.class_index, report.missing],
            reason: format!("{:?}", report.reason),
            counts: [report.segment, report.rows, report.rejected, report.saturated],
            bits: [report.distance, report.surprise, alarm.score].map(f32::to_bits),
            most: (report.most != u8::MAX).then_some((report.most, report.falls)),
            alarm: alarm.raised.then_some(Alarm { segment: alarm.segment, cause }),
            silence: alarm.silent.then_some(alarm.silent_segments),
        };
        Some(Told::Report(code == BwCode::Withdrawn, fields))
    }

    fn clock(&mut self, milliseconds: u32) -> Option<Told> {
        // SAFETY: as above.
        match unsafe { bw_clock(self.0, milliseconds) } {
            BwCode::Ok => None,
            lapse => Some(Told::Lapse(lapse)),
        }
    }

    fn act(&mut self, action: Action) -> bool {
        let Self(state, memory, model) = self;
        let mut saved = [0; 4096];
        // SAFETY: as above.
        let code = unsafe {
            match action {
                Action::Deny => bw_deny(*state),
                Action::Reset => bw_reset(*state),
                Action::Restart => bw_restart(*state),
                Action::ClearFaults => bw_clear_faults(*state),
                Action::LimitSilence => bw_limit_silence(*state, SILENCE.segments, SILENCE.hours),
                Action::PowerOff => {
                    let mut length = 0;
                    assert_eq!(bw_end_run(*state, saved.as_mut_ptr(), saved.len(), &raw mut length), BwCode::Ok);
                    assert_eq!(bw_stop(*state), BwCode::Ok);
                    *state = memory.drive(model, &for_c(&CONSTANTS, 10, 2)).expect("it starts");
                    bw_restore(*state, saved.as_ptr(), length)
                }
            }
        };
        // A state that was started anew has the usual limits.
        if action == Action::PowerOff {
            self.limit();
        }
        code == BwCode::Ok
    }

    fn end(&mut self) -> ([u32; 3], BwFrontEndFaults, Vec<u8>) {
        let (mut status, mut faults) = (MaybeUninit::<BwStatus>::uninit(), MaybeUninit::<BwFrontEndFaults>::uninit());
        let (mut state, mut length) = (vec![0; 4096], 0);
        // SAFETY: as above.
        let (status, faults) = unsafe {
            assert_eq!(bw_status(self.0, status.as_mut_ptr()), BwCode::Ok);
            assert_eq!(bw_faults(self.0, faults.as_mut_ptr()), BwCode::Ok);
            assert_eq!(bw_end_run(self.0, state.as_mut_ptr(), state.len(), &raw mut length), BwCode::Ok);
            (status.assume_init(), faults.assume_init())
        };
        state.truncate(length);
        assert_eq!((status.failed, status.alignment), (0, faults.alignment));
        ([status.samples, status.lost_samples, status.lost_segments], faults, state)
    }
}
