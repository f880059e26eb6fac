//! Calls of the drive's front end for the example `panic_free`, which is too long for them.

use core::fmt;
use core::hint::black_box as opaque;

use bearing_watch::drive::*;
use bearing_watch::*;

use super::raw::{CONSTANTS, Motor, Sensors};

/// Every public function; `show` writes an error.
pub fn front_end(mut show: impl FnMut(&dyn fmt::Display)) {
    let mut constants = opaque(CONSTANTS);
    if let Err(error) = FrontEndConstants::check(&constants) {
        opaque(FrontEndError::message(error));
        show(&error);
    }
    let limits = CalibrationLimits { samples: opaque(100), offset_counts: [0.0, 4096.0], deviation_counts: [0.1, 8.0] };
    let mut calibration = opaque(OffsetCalibration::new(limits));
    let mut motor = Motor::<2>::new(opaque(Sensors::Resolver));
    for _ in 0..opaque(100) {
        opaque(OffsetCalibration::push(&mut calibration, &opaque(motor.sample().currents)));
    }
    match OffsetCalibration::finish(&calibration, opaque(constants.sensors)) {
        Ok(sensors) => constants.sensors = sensors,
        Err(error) => {
            opaque(CalibrationError::message(&error));
            show(&error);
        }
    }
    parts(&constants, &mut motor);
    wiring(&constants, &mut motor, &mut show);
    match FrontEnd::<2, 8>::new(&opaque(constants)) {
        Ok(front_end) => chain(opaque(front_end), &mut motor),
        Err(error) => show(&error),
    }
    match FrontEnd::<0, 10>::new(&opaque(constants)) {
        Ok(front_end) => chain(opaque(front_end), &mut Motor::<0>::new(opaque(Sensors::Converter))),
        Err(error) => show(&error),
    }
}

fn parts(constants: &FrontEndConstants, motor: &mut Motor<2>) {
    let [sensor, ..] = constants.sensors;
    opaque(PhaseSensor::amperes(&sensor, opaque(5)));
    opaque(PhaseCounts::as_slice(&opaque(motor.sample()).currents));
}

fn wiring(constants: &FrontEndConstants, motor: &mut Motor<2>, show: &mut impl FnMut(&dyn fmt::Display)) {
    let Ok(mut front_end) = FrontEnd::<2, 8>::new(&opaque(*constants)) else { return };
    let limits = WiringLimits {
        least_current_a: opaque(0.5),
        offset_rad: 0.1,
        delay_s: 1e-4,
        velocity_tolerance: 0.05,
        slowest_rad_s: 5.0,
    };
    let mut check = opaque(WiringCheck::new(constants.frame, constants.control_rate_hz, limits));
    for _ in 0..opaque(500) {
        FrontEnd::check_wiring(&mut front_end, &opaque(motor.sample()), opaque(40.0), &mut check);
    }
    WiringCheck::push(&mut check, opaque(AlphaBeta::default()), opaque(Angle::ZERO), opaque(f32::NAN));
    WiringCheck::skip(&mut check);
    let faults = [opaque(WiringCheck::conclude(&check)).err(), opaque(Some(WiringFault::PhaseOrder))];
    for fault in faults.into_iter().flatten() {
        opaque(WiringFault::message(&fault));
        show(&fault);
    }
}

fn chain<const FURTHER: usize, const FACTOR: usize>(
    mut front_end: FrontEnd<FURTHER, FACTOR>,
    motor: &mut Motor<FURTHER>,
) where
    By<FACTOR>: Factor,
{
    for _ in 0..opaque(500) {
        opaque(FrontEnd::push(&mut front_end, &opaque(motor.sample())));
    }
    opaque(Faults::is_clear(&opaque(FrontEnd::faults(&front_end))));
    opaque(RotorFrame::electrical(FrontEnd::frame(&front_end), opaque(Angle::ZERO)));
    FrontEnd::clear_faults(opaque(&mut front_end));
}
