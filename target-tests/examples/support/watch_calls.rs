//! Calls of `Watch` for the example `panic_free`, which is too long for them.

use core::fmt;
use core::hint::black_box as opaque;

use bearing_watch::LivenessLimits;
use bearing_watch::drive::*;
use bearing_watch::model::Sampling;
use bearing_watch::plan::{Plan, Signals as _};
use bearing_watch::watch::*;

use super::model::{Drive, MODEL, Sample};
use super::raw::{CONSTANTS, Motor, Sensors};

static DIRECT: Watch<Drive> = Watch::new();
static RAW: Watch<Drive, FrontEnd<1, 20>> = Watch::new();

impl From<CleanSample<1>> for Sample {
    fn from(clean: CleanSample<1>) -> Self {
        let [load_torque_nm] = clean.further;
        Self { current_a: clean.current_a, velocity_ref_rad_s: clean.velocity_rad_s, load_torque_nm }
    }
}

/// Every public function; `show` writes an error.
pub fn run(mut show: impl FnMut(&dyn fmt::Display)) {
    let mut motor = Motor::<1>::new(opaque(Sensors::Converter));
    if let Err(error) = Watch::<Drive>::start(opaque(&DIRECT), &MODEL) {
        opaque(StartError::message(error));
        show(&error);
    }
    if let Err(error) = Watch::<Drive, FrontEnd<1, 20>>::start(opaque(&RAW), &MODEL, &opaque(CONSTANTS)) {
        show(&error);
    }
    // Another model and other constants without a reboot.
    if Watch::<Drive, FrontEnd<1, 20>>::stop(&RAW)
        && let Ok(front_end) = FrontEnd::<1, 20>::new(&opaque(CONSTANTS))
        && let Err(error) = Watch::<Drive, FrontEnd<1, 20>>::start_around(opaque(&RAW), &MODEL, front_end)
    {
        show(&error);
    }
    let limits = WiringLimits {
        least_current_a: opaque(0.5),
        offset_rad: 0.1,
        delay_s: 1e-4,
        velocity_tolerance: 0.05,
        slowest_rad_s: 5.0,
    };
    let mut check = opaque(WiringCheck::new(CONSTANTS.frame, CONSTANTS.control_rate_hz, limits));
    Watch::<Drive, FrontEnd<1, 20>>::check_wiring(&RAW, motor.sample(), opaque(1.0), &mut check);
    Watch::<Drive, FrontEnd<1, 20>>::clear_faults(&RAW);
    for number in 0..opaque(5_u16) {
        opaque(Watch::<Drive, FrontEnd<1, 20>>::sample(&RAW, opaque(motor.sample())));
        let current_a = f32::from(opaque(number));
        let sample = Sample { current_a, velocity_ref_rad_s: 1.0, load_torque_nm: 0.0 };
        opaque((Watch::<Drive>::sample(&DIRECT, sample), Watch::<Drive>::sample_signals(&DIRECT, sample)));
        below(&DIRECT, &mut show);
        below(&RAW, &mut show);
    }
}

fn below<P: Plan, F>(watch: &'static Watch<P, F>, show: &mut impl FnMut(&dyn fmt::Display)) {
    opaque(Watch::collect(watch));
    opaque(Watch::collect_with(watch, |sample, missed| _ = opaque((opaque(sample).angle(), missed))));
    opaque(Watch::advance(watch, |now| now.alarm.is_some() || now.withdrawn));
    if let Some(lapse) = Watch::clock(watch, opaque(12_345)) {
        opaque(Lapse::message(lapse));
        show(&lapse);
    }
    let [sample_s, segment_s, verdict_s] = opaque([1.0, 30.0, 1e9]);
    Watch::limit_liveness(watch, LivenessLimits { sample_s, segment_s, verdict_s });
    opaque(Sampling::segment_s(&MODEL.constants().sampling));
    opaque(Watch::monitor(watch, |monitor| monitor.evidence().alarm()));
    let mut bytes = opaque([0; 2048]);
    if let Err(error) = Watch::end_run(watch, &mut bytes) {
        show(&error);
    }
    if let Err(error) = Watch::restore(watch, &bytes) {
        show(&error);
    }
    opaque((Watch::restart(watch), Watch::reset(watch), Watch::status(watch)));
}
