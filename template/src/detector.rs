use bearing_watch::drive::{FrontEndError, PhaseCounts, RawSample};
use bearing_watch::{Detector, Kernel, Monitor, Segment, Verdict, known_answer_test};

use super::model::{Drive, DriveFrontEnd, FRONT_END, MODEL, position};

/// What the drive reads at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    pub number: u32, // of the instant: a missed interrupt leaves a gap
    pub phases: [u16; 3],
    pub position: u16,
    pub load_torque_nm: f32,
    pub velocity_ref_rad_s: f32,
}

/// At boot.
pub fn start() -> Result<(DriveFrontEnd, Detector<'static, Drive>, Monitor<'static, Drive>), &'static str> {
    known_answer_test().map_err(Kernel::message)?; // this chip computes what the host computed in training
    let front_end = DriveFrontEnd::new(&FRONT_END).map_err(FrontEndError::message)?;
    // Refuses a model that was trained with the other Park convention.
    MODEL.check_rotor_frame(front_end.frame()).map_err(|error| error.message())?;
    Ok((front_end, Detector::new(&MODEL), Monitor::new(&MODEL)))
}

/// In the interrupt, once before its first sample and before the power stage is on: an interrupt has settings of the
/// processor of its own (FPDSCR), which `main` does not see. Later the detector tests them with each segment.
pub fn test() -> Result<(), &'static str> {
    known_answer_test().map_err(Kernel::message)
}

/// The interrupt of the control loop: counts of the converters in; a closed segment once in a few seconds.
pub fn interrupt(
    front_end: &mut DriveFrontEnd,
    detector: &mut Detector<'static, Drive>,
    reading: &Reading,
) -> Option<Segment<Drive>> {
    let clean = front_end.push(&RawSample {
        number: reading.number,
        currents: PhaseCounts::Three(reading.phases),
        position: position(reading.position.into()),
        further: [reading.load_torque_nm, reading.velocity_ref_rad_s], // in the order that `model.rs` says
    })?;
    if clean.found_late {
        // A fault that shows only after a window of samples: those before were wrong.
        detector.discard();
    }
    detector.collect(&clean.into())
}

/// The name of a verdict.
pub fn name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Class(class) => MODEL.label(class),
        Verdict::Novel => "novel",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Undetermined(_reason) => "undetermined",
    }
}
