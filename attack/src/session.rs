//! Calls of a detector, and of all that belongs to it, in any order.

use bearing_watch::drive::RotorFrame;
use bearing_watch::plan::{Plan, Signals};
use bearing_watch::{Angle, Detector, Evidence, Exchange, Model, Monitor, Report, Segment, Verdict};

use crate::input::Input;
use crate::models::numbers::Numbers;
use crate::{checksum, finite};

/// Most channels of a sample.
const CHANNELS: usize = 16;
/// Ordinary samples of an attack, so that a long input is not a slow one.
const ORDINARY: usize = 400;
/// Bytes for a saved state.
const STATE: usize = 512;

/// A detector in use.
struct Session<'m, 's, P: Plan> {
    model: &'m Model<P>,
    detector: Detector<'m, P, &'s mut Segment<P>>,
    spare: Option<&'s mut Segment<P>>,
    evidence: Evidence<P>,
    /// Of ordinary samples.
    numbers: Numbers,
    angle: Angle,
    /// Ordinary samples that are left.
    left: usize,
}

/// Makes the calls of an input. Every result is finite; nothing panics.
pub fn run<P: Plan>(model: &Model<P>, input: &mut Input<'_>) {
    let [mut first, mut second] = [(); 2].map(|()| Segment::new(model));
    let mut session = Session {
        model,
        detector: Detector::with_place(model, &mut first),
        spare: Some(&mut second),
        evidence: Evidence::new(model),
        numbers: Numbers(u32::from(input.byte())),
        angle: Angle::ZERO,
        left: ORDINARY,
    };
    while !input.is_empty() && session.left > 0 {
        session.call(input);
    }
    let mut last = session.detector.finish();
    session.report(&mut last);
}

impl<P: Plan> Session<'_, '_, P> {
    fn call(&mut self, input: &mut Input<'_>) {
        match input.byte() % 16 {
            0 | 1 => {
                let sample = wild::<P>(input);
                if let Some(mut report) = self.detector.step(&sample) {
                    self.report(&mut report);
                }
            }
            2..=4 => {
                for _ in 0..self.some(input) {
                    let sample = self.ordinary();
                    if let Some(mut report) = self.detector.step(&sample) {
                        self.report(&mut report);
                    }
                }
            }
            5..=7 => {
                let how = input.byte();
                for _ in 0..self.some(input) {
                    let sample = self.ordinary();
                    self.collect(&sample, || how);
                }
            }
            8 => {
                let sample = wild::<P>(input);
                self.collect(&sample, || input.byte());
            }
            9 => {
                let report = self.detector.preview();
                finite::report(&report);
                let _late = self.detector.adopt(&report);
            }
            10 => {
                let mut report = self.detector.finish();
                self.report(&mut report);
            }
            11 => {
                self.detector.discard();
            }
            12 => self.detector.restart(),
            13 => {
                let limit = self.model.constants().sampling.segment_samples;
                assert!(self.detector.pending() < limit, "an open segment is not full");
                let _counts = self.detector.counts();
                self.evidence.end_run();
                if input.byte().is_multiple_of(4) {
                    self.evidence.reset();
                }
            }
            14 => self.save(input),
            _ => self.about(input),
        }
    }

    /// A number of ordinary samples.
    fn some(&mut self, input: &mut Input<'_>) -> usize {
        let count = usize::from(input.byte()).min(self.left);
        self.left -= count;
        count
    }

    /// A sample of noise over the channels, with a shaft that turns.
    fn ordinary(&mut self) -> P::Sample {
        let values = self.numbers.array::<CHANNELS>();
        self.angle = self.angle.plus(Angle::from_bits(200_000_000));
        P::Sample::of(self.channels(&values), self.angle)
    }

    fn channels<'v>(&self, values: &'v [f32]) -> &'v [f32] {
        values.get(..usize::from(self.model.plan().layout().channels)).unwrap_or(values)
    }

    /// Gives the detector a sample, and concludes the segment that it closes in any way. Pieces give the same bits as
    /// the whole.
    fn collect(&mut self, sample: &P::Sample, how: impl FnOnce() -> u8) {
        let Exchange::Closed(place) = self.detector.exchange(sample, &mut self.spare) else { return };
        let how = how();
        let mut monitor = Monitor::new(self.model);
        monitor.take_from(place);
        self.spare = Some(place);
        if how & 1 != 0 {
            for _ in 0..how {
                if let Some(now) = monitor.advance() {
                    finite::report(now.report);
                }
            }
        }
        monitor.complete();
        let Some(mut report) = monitor.report().cloned() else { return };
        if how & 2 != 0 {
            let _late = self.detector.adopt(&report);
        }
        self.report(&mut report);
    }

    fn report(&mut self, report: &mut Report<P>) {
        finite::report(report);
        if let Verdict::Class(class) = report.verdict {
            assert!(!self.model.label(class).is_empty(), "class {class} has a name");
        }
        self.evidence.observe(report.decision.as_ref());
        finite::evidence(&self.evidence);
    }

    /// Saves and restores the state, also with changed bytes under a right checksum.
    fn save(&mut self, input: &mut Input<'_>) {
        let mut buffer = [0; STATE];
        let Ok(length) = self.evidence.save(self.model, &mut buffer) else { return };
        let bytes = &mut buffer[..length];
        let before = (self.evidence.score().to_bits(), self.evidence.segments(), self.evidence.alarm());
        let restored = self.evidence.restore(self.model, bytes);
        assert_eq!(restored, Ok(()), "what was saved is restored");
        assert_eq!(before, (self.evidence.score().to_bits(), self.evidence.segments(), self.evidence.alarm()));
        for _ in 0..input.byte() % 8 {
            bytes[usize::from(input.half()) % length] = input.byte();
        }
        if input.byte().is_multiple_of(2) {
            checksum::put(bytes);
        }
        let kept = self.evidence.clone();
        if self.evidence.restore(self.model, bytes).is_err() {
            assert!(self.evidence == kept, "nothing changes in case of an error");
        }
        finite::evidence(&self.evidence);
    }

    /// Checks and resets with any values.
    fn about(&mut self, input: &mut Input<'_>) {
        let _refused = self.model.check_interval(input.number());
        let pole_pairs = input.word();
        let frame = RotorFrame { pole_pairs, electrical_offset: Angle::ZERO, park: bearing_watch::Park::Thesis };
        let _refused = self.model.check_rotor_frame(&frame);
        let _empty = self.model.label(input.byte());
    }
}

/// A sample of any bits.
pub fn wild<P: Plan>(input: &mut Input<'_>) -> P::Sample {
    let values: [f32; CHANNELS] = match input.byte() % 4 {
        0 => [input.number(); CHANNELS],
        _ => {
            let mut values = [0.0; CHANNELS];
            values.iter_mut().take(5).for_each(|value| *value = input.number());
            values
        }
    };
    // More or fewer values than channels are harmless too.
    let count = 1 + input.below(CHANNELS);
    P::Sample::of(&values[..count], Angle::from_bits(input.word()))
}
