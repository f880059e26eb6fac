//! A drive whose firmware is in Rust.

use bearing_watch::drive::RawSample;
use bearing_watch::watch::{Lapse, Watch};
use bearing_watch::{Conclusion, Model, Monitor, Reason, Verdict};
use bearing_watch_c::{BwCode, BwFrontEndFaults, BwVerdict};

use crate::actuator::{Drive, DriveFrontEnd};
use crate::cases::{Action, Fields, Told};
use crate::drive::CONSTANTS;
use crate::{LIMITS, SILENCE, Side};

pub type Own = Watch<Drive, DriveFrontEnd>;

pub struct Rust(&'static Own, &'static Model<Drive>);

impl Rust {
    pub fn new(model: &'static Model<Drive>) -> Self {
        let watch: &'static Own = Box::leak(Box::default());
        watch.start(model, &CONSTANTS).expect("it starts");
        watch.limit_liveness(LIMITS);
        Self(watch, model)
    }
}

impl Side for Rust {
    fn sample(&mut self, reading: &RawSample<2>) {
        let _waits = self.0.sample(*reading);
    }

    fn collect(&mut self) {
        self.0.collect();
    }

    fn advance(&mut self) -> Option<Told> {
        self.0.advance(|now| Told::Report(now.withdrawn, fields(&now)))
    }

    fn clock(&mut self, milliseconds: u32) -> Option<Told> {
        self.0.clock(milliseconds).map(|lapse| {
            Told::Lapse(match lapse {
                Lapse::NoSample => BwCode::NoSample,
                Lapse::NotCollected => BwCode::NotCollected,
                Lapse::Arithmetic(_) => BwCode::Arithmetic,
                Lapse::NoSegment => BwCode::NoSegment,
                Lapse::Rate => BwCode::WrongRate,
                _ => BwCode::NoVerdict,
            })
        })
    }

    fn act(&mut self, action: Action) -> bool {
        let Self(watch, model) = self;
        match action {
            Action::Deny => watch.monitor(Monitor::deny) == Some(true),
            Action::Reset => watch.reset(),
            Action::Restart => watch.restart(),
            Action::ClearFaults => {
                watch.clear_faults();
                true
            }
            Action::LimitSilence => watch.monitor(|own| own.limit_silence(SILENCE)).is_some(),
            Action::PowerOff => {
                let mut state = [0; 4096];
                let length = watch.end_run(&mut state).unwrap();
                let stopped = watch.stop();
                watch.start(model, &CONSTANTS).unwrap();
                watch.limit_liveness(LIMITS);
                stopped && watch.restore(&state[..length]).is_ok()
            }
        }
    }

    fn end(&mut self) -> ([u32; 3], BwFrontEndFaults, Vec<u8>) {
        let (status, mut state) = (self.0.status(), vec![0; 4096]);
        let length = self.0.end_run(&mut state).unwrap();
        state.truncate(length);
        let lost = [status.rows, status.lost_samples, status.lost_segments];
        (lost, status.faults.unwrap().into(), state)
    }
}

fn fields(now: &Conclusion<'_, Drive>) -> Fields {
    let (report, decision) = (now.report, now.report.decision.as_ref());
    let (verdict, reason) = match report.verdict {
        Verdict::Class(_) => (BwVerdict::Class, "None".into()),
        Verdict::Novel => (BwVerdict::Novel, "None".into()),
        Verdict::Ambiguous => (BwVerdict::Ambiguous, "None".into()),
        Verdict::Undetermined(reason) => (BwVerdict::Undetermined, name(reason)),
    };
    let missing = decision.map_or(0, |own| own.missing_count() as u8);
    Fields {
        verdict,
        class: [decision.map_or(0, |own| own.class), missing],
        reason,
        counts: [now.evidence.segments().0, report.rows, report.counts.rejected, report.counts.saturated],
        bits: [
            decision.map_or(0.0, |own| own.distance),
            decision.map_or(0.0, |own| own.surprise),
            now.evidence.score(),
        ]
        .map(f32::to_bits),
        most: decision.and_then(|own| own.most).map(|most| (most.coordinate, most.falls)),
        alarm: now.alarm,
        silence: now.silence.map(|own| own.segments),
    }
}

/// The name of a reason, which is the same in both.
fn name(reason: Reason) -> String {
    let text = format!("{reason:?}");
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().into()
}
