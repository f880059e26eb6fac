//! Both halves of a detector, as a drive has them: segments in two places, which go to and fro.

use bearing_watch::plan::Plan;
use bearing_watch::{Detector, Exchange, Model, Monitor, Report, Segment};

/// The interrupt's half.
#[derive(Debug)]
pub struct Interrupt<'m, P: Plan> {
    /// The detector; its open segment is in one of the places.
    pub detector: Detector<'m, P, &'static mut Segment<P>>,
    spare: Option<&'static mut Segment<P>>,
}

impl<'m, P: Plan> Interrupt<'m, P> {
    /// Nothing sampled yet.
    #[must_use]
    pub fn new(model: &'m Model<P>) -> Self {
        let place = || Box::leak(Box::new(Segment::new(model)));
        Self { detector: Detector::with_place(model, place()), spare: Some(place()) }
    }

    /// Takes one sample; returns a copy of the sums with the sample that closes a segment.
    pub fn collect(&mut self, sample: &P::Sample) -> Option<Segment<P>> {
        let Exchange::Closed(place) = self.detector.exchange(sample, &mut self.spare) else { return None };
        let segment = place.clone();
        self.spare = Some(place);
        Some(segment)
    }
}

/// The report of a segment by a main loop that solves it at once.
///
/// # Panics
/// If there is nothing to solve.
#[must_use]
pub fn conclude<P: Plan>(model: &Model<P>, mut segment: Segment<P>) -> Report<P> {
    let mut monitor = Monitor::new(model);
    monitor.take_from(&mut segment);
    monitor.complete().expect("a segment").report.clone()
}
