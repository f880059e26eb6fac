//! The work of interrupt and main loop of a drive on a recording, without what connects them: `drive` and the crates of
//! `frameworks` share it.

use bearing_watch::drive::RawSample;
use bearing_watch::{Conclusion, Detector, Exchange, Monitor, Report, Segment, Verdict};

use crate::model::{Drive, DriveFrontEnd, FRONT_END, FURTHER, MODEL};
use crate::support::hash::Hash;

/// Room for a segment.
pub type Place = &'static mut Segment<Drive>;

/// What the interrupt works on.
pub struct Sampler {
    pub front_end: DriveFrontEnd,
    pub detector: Detector<'static, Drive, Place>,
    /// The place that the main loop has given back.
    pub spare: Option<Place>,
    /// Closed segments whose next one had no spare place.
    lost: u32,
}

impl Sampler {
    /// Returns the text of the error if the constants of the front end are not valid.
    pub fn new() -> Result<Self, &'static str> {
        let front_end = DriveFrontEnd::new(&FRONT_END).map_err(|error| error.message())?;
        let Some((first, second)) = places!(&MODEL, Drive) else { return Err("the places are taken") };
        let detector = Detector::with_place(&MODEL, first);
        Ok(Self { front_end, detector, spare: Some(second), lost: 0 })
    }

    /// Takes a row of the recording; returns a closed segment once in seconds. The main loop gives its place back to
    /// `spare`.
    pub fn sample(&mut self, raw: &RawSample<FURTHER>) -> Option<Place> {
        let clean = self.front_end.push(raw)?;
        if clean.found_late {
            // A fault that shows only after a window of samples: those before were wrong.
            self.detector.discard();
        }
        match self.detector.exchange(&clean.into(), &mut self.spare) {
            Exchange::Open => None,
            Exchange::Closed(place) => Some(place),
            Exchange::Lost => {
                self.lost += 1;
                None
            }
        }
    }
}

/// What the main loop works on.
pub struct Watch {
    pub monitor: Monitor<'static, Drive>,
    segments: u32,
}

impl Watch {
    pub fn new() -> Self {
        Self { monitor: Monitor::new(&MODEL), segments: 0 }
    }

    /// Does a step of the solve of a segment. The last step gives the report to `adopt` and prints it, where a drive
    /// sends it.
    pub fn advance<T>(&mut self, adopt: impl FnOnce(&Report<Drive>) -> T) {
        if let Some(now) = self.monitor.advance() {
            let _in_time = adopt(now.report);
            print(self.segments, now);
            self.segments += 1;
        }
    }

    /// Prints the last line.
    pub fn end(&self, sampler: &Sampler) {
        let (segments, lost, clear) = (self.segments, sampler.lost, sampler.front_end.faults().is_clear());
        say!("{segments} segments, {lost} lost, front end clear: {clear}");
    }
}

/// Prints a report with the bits of its log-likelihoods and the hash of all its numbers.
fn print(number: u32, Conclusion { report, alarm, .. }: Conclusion<'_, Drive>) {
    let rows = report.rows;
    let end = if alarm.is_some() { ", ALARM" } else { "" };
    match report.verdict {
        Verdict::Class(class) => say!("segment {number}: {rows} rows, {}{end}", MODEL.label(class)),
        Verdict::Novel => say!("segment {number}: {rows} rows, novel{end}"),
        Verdict::Ambiguous => say!("segment {number}: {rows} rows, ambiguous{end}"),
        Verdict::Undetermined(reason) => say!("segment {number}: {rows} rows, {reason}{end}"),
    }
    let mut hash = Hash::new();
    report.estimate().into_iter().for_each(|estimate| hash.add_estimate(estimate));
    report.shaft().into_iter().for_each(|shaft| hash.add_shaft(shaft));
    for (class, value) in report.decision.iter().flat_map(|decision| decision.log_likelihoods()).enumerate() {
        hash.add(&[*value]);
        say!("  log-likelihood {class} {:08x}", value.to_bits());
    }
    say!("  all numbers {:08x}", hash.bits());
}
