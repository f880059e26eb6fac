//! What gives a [`Watch`](super::Watch) its samples.

use crate::drive::{Alignment, By, CleanSample, Factor, Faults, FrontEnd, RawSample, WiringCheck};

/// Makes clean samples of what the current loop reads: a [`FrontEnd`], or what another program has in its place.
pub trait Source {
    /// What the current loop reads.
    type Reading;
    /// What becomes a sample of the plan.
    type Clean;

    /// Takes a reading; returns a clean sample if one is due.
    fn push(&mut self, reading: &Self::Reading) -> Option<Sampled<Self::Clean>>;

    /// Takes a reading at commissioning, for a check of the wiring instead of the detector.
    fn check_wiring(&mut self, reading: &Self::Reading, velocity_rad_s: f32, check: &mut WiringCheck);

    /// What was refused; `None` if nothing is known of it, nor of the wiring.
    fn faults(&self) -> Option<Faults>;

    /// Counts refusals from zero.
    fn clear_faults(&mut self);
}

/// A clean sample, and what is known with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled<C> {
    /// The sample.
    pub clean: C,
    /// Whether a fault was found that began before it.
    pub found_late: bool,
    /// Whether the currents turn with the rotor.
    pub alignment: Alignment,
}

impl<const FURTHER: usize, const FACTOR: usize> Source for FrontEnd<FURTHER, FACTOR>
where
    By<FACTOR>: Factor,
{
    type Reading = RawSample<FURTHER>;
    type Clean = CleanSample<FURTHER>;

    #[inline(always)]
    fn push(&mut self, reading: &RawSample<FURTHER>) -> Option<Sampled<CleanSample<FURTHER>>> {
        let clean = Self::push(self, reading)?;
        Some(Sampled { clean, found_late: clean.found_late, alignment: clean.alignment })
    }

    fn check_wiring(&mut self, reading: &RawSample<FURTHER>, velocity_rad_s: f32, check: &mut WiringCheck) {
        Self::check_wiring(self, reading, velocity_rad_s, check);
    }

    fn faults(&self) -> Option<Faults> {
        Some(Self::faults(self))
    }

    fn clear_faults(&mut self) {
        Self::clear_faults(self);
    }
}
