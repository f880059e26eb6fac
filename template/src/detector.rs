use bearing_watch::drive::{FrontEndError, PhaseCounts, RawSample};
use bearing_watch::{Detector, Exchange, Kernel, Monitor, Segment, Verdict, known_answer_test};

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

/// Room for a segment: the interrupt fills one while the main loop reads another.
pub type Place = &'static mut Segment<Drive>;

/// The interrupt's half.
pub struct Sampler {
    pub front_end: DriveFrontEnd,
    pub detector: Detector<'static, Drive, Place>,
    /// The place that the main loop has given back.
    pub spare: Option<Place>,
}

/// At boot, with two clear places.
pub fn start(first: Place, second: Place) -> Result<(Sampler, Monitor<'static, Drive>), &'static str> {
    known_answer_test().map_err(Kernel::message)?; // this chip computes what the host computed in training
    let front_end = DriveFrontEnd::new(&FRONT_END).map_err(FrontEndError::message)?;
    // Refuses a model that was trained with the other Park convention.
    MODEL.check_rotor_frame(front_end.frame()).map_err(|error| error.message())?;
    let detector = Detector::with_place(&MODEL, first);
    Ok((Sampler { front_end, detector, spare: Some(second) }, Monitor::new(&MODEL)))
}

/// In the interrupt, once before its first sample and before the power stage is on: an interrupt has settings of the
/// processor of its own (FPDSCR), which `main` does not see. Later the detector tests them with each segment.
pub fn test() -> Result<(), &'static str> {
    known_answer_test().map_err(Kernel::message)
}

/// The interrupt of the control loop: counts of the converters in; a closed segment once in a few seconds.
pub fn interrupt(sampler: &mut Sampler, reading: &Reading) -> Option<Place> {
    let clean = sampler.front_end.push(&RawSample {
        number: reading.number,
        currents: PhaseCounts::Three(reading.phases),
        position: position(reading.position.into()),
        further: [reading.load_torque_nm, reading.velocity_ref_rad_s], // in the order that `model.rs` says
    })?;
    if clean.found_late {
        // A fault that shows only after a window of samples: those before were wrong.
        sampler.detector.discard();
    }
    match sampler.detector.exchange(&clean.into(), &mut sampler.spare) {
        Exchange::Closed(place) => Some(place),
        // Lost: the main loop has not given the other place back. The next segment begins in this one.
        Exchange::Open | Exchange::Lost => None,
    }
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
