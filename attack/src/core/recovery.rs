//! A bad interval in a stream: verdicts after it are those of a detector that never saw it.
//!
//! Samples of the interval have any bits. The segment in which the interval ends, and the next one, may differ: filters
//! and lags hold what they took. With instruments two more may: a disturbed estimate that is stable becomes the
//! auxiliary model, and the nominal one returns after three segments without a successor. All later segments have the
//! same verdict, by least squares and without a shaft to the last bit.

use std::sync::LazyLock;

use bearing_watch::plan::Plan;
use bearing_watch::{Detector, Model, Report};

use crate::input::Input;
use crate::models::{RIG, refined, shaft, standard_rig};
use crate::{finite, session};

/// Segments of a stream.
const SEGMENTS: usize = 6;

/// A model, a stream for it, and what a detector says of the undisturbed stream.
struct Stream<P: Plan + 'static> {
    model: &'static Model<P>,
    samples: Vec<P::Sample>,
    reports: Vec<Report<P>>,
    /// Segments after the one in which the interval ends that may differ.
    unsettled: usize,
    /// Whether segments share nothing: then equal ones have equal bits.
    separate: bool,
}

impl<P: Plan> Stream<P> {
    fn new(
        model: &'static Model<P>,
        samples: impl Iterator<Item = P::Sample>,
        unsettled: usize,
        separate: bool,
    ) -> Self {
        let length = SEGMENTS * model.constants().sampling.segment_samples as usize;
        let samples: Vec<P::Sample> = samples.take(length).collect();
        let mut detector = Detector::new(model);
        let reports = samples.iter().filter_map(|sample| detector.step(sample)).collect();
        Self { model, samples, reports, unsettled, separate }
    }

    fn attack(&self, input: &mut Input<'_>) {
        let segment = self.model.constants().sampling.segment_samples as usize;
        let from = usize::from(input.half()) % (2 * segment);
        let length = 1 + usize::from(input.half()) % segment.min(64);
        let mut detector = Detector::new(self.model);
        // The sample before repeats itself where the input has ended: a sensor that is stuck.
        let mut bad = self.samples[from].clone();
        let mut place = 0;
        for (k, sample) in self.samples.iter().enumerate() {
            let spoilt = (from..from + length).contains(&k);
            if spoilt && !input.is_empty() {
                bad = session::wild::<P>(input);
            }
            let Some(report) = detector.step(if spoilt { &bad } else { sample }) else { continue };
            finite::report(&report);
            if place > (from + length - 1) / segment + self.unsettled {
                self.compare(place, &report);
            }
            place += 1;
        }
        assert_eq!(place, SEGMENTS, "segments close where they would have");
    }

    fn compare(&self, place: usize, report: &Report<P>) {
        let expected = &self.reports[place];
        assert_eq!(report.verdict, expected.verdict, "segment {place}");
        // Debug output tells equal bits apart from NaN.
        let same = !self.separate || report == expected || format!("{report:?}") == format!("{expected:?}");
        assert!(same, "segment {place}: {report:?} instead of {expected:?}");
    }
}

static OF_RIG: LazyLock<Stream<standard_rig::model::Drive>> =
    LazyLock::new(|| Stream::new(&RIG, standard_rig::samples(), 1, true));
static OF_REFINED: LazyLock<Stream<refined::Refined>> = LazyLock::new(|| {
    let mut plant = refined::Plant::new(5);
    Stream::new(&refined::MODEL, std::iter::repeat_with(move || plant.sample()), 3, false)
});
static OF_WATCHED: LazyLock<Stream<shaft::Watched>> = LazyLock::new(|| {
    let mut plant = shaft::Plant::new(5);
    Stream::new(&shaft::MODEL, std::iter::repeat_with(move || plant.motion().into()), 1, false)
});
static OF_LOADLESS: LazyLock<Stream<shaft::Loadless>> = LazyLock::new(|| {
    let mut plant = shaft::Plant::new(5);
    Stream::new(&shaft::LOADLESS, std::iter::repeat_with(move || plant.motion().into()), 1, false)
});

/// A stream with a bad interval.
pub fn attack(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    // Segments of the others are longer.
    match input.byte() % 32 {
        3.. => OF_RIG.attack(&mut input),
        0 => OF_REFINED.attack(&mut input),
        1 => OF_WATCHED.attack(&mut input),
        2 => OF_LOADLESS.attack(&mut input),
    }
}
