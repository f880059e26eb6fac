//! Calls of the main loop's half for the example `panic_free`.

use core::hint::black_box as opaque;

use bearing_watch::alarm::{Growth, Interval, SilenceLimits};
use bearing_watch::drive::Alignment;
use bearing_watch::model::Directions;
use bearing_watch::plan::Plan;
use bearing_watch::{
    Detector, Evidence, Exchange, Implausible, Liveness, LivenessLimits, Model, Monitor, Obstacle, RateCheck, Segment,
};

/// Every public function of a monitor.
pub fn run<P: Plan>(model: &Model<P>, detector: &mut Detector<'_, P>, mut sample: impl FnMut() -> P::Sample) {
    let mut monitor = opaque(Monitor::new(model));
    let mut segment = opaque(Segment::new(model));
    for _ in 0..opaque(50) {
        if let Some(now) = Monitor::step(&mut monitor, detector, &sample()) {
            opaque((now.alarm, now.silence, Detector::adopt(detector, now.report)));
            opaque(Detector::is_in_first_half(detector));
        }
        Monitor::take_from(&mut monitor, &mut segment);
        opaque((Monitor::complete(&mut monitor).is_some(), Monitor::withdraw(&mut monitor, opaque(3))));
        for _ in 0..opaque(50) {
            opaque((Monitor::advance(&mut monitor).is_some(), Monitor::is_solving(&monitor)));
        }
    }
    let mut other = opaque(Monitor::new(model));
    opaque(Monitor::step(&mut other, detector, &sample()).is_some());
    opaque(Monitor::finish(&mut other, detector).alarm);
    Monitor::refuse(&mut other, opaque(Some(Implausible::Rate)));
    opaque(RateCheck::of_milliseconds(opaque(0.002)));
    let mut rate = opaque(RateCheck::new(opaque(500.0), 1000.0, 0.02, opaque(2000)));
    opaque((RateCheck::push(&mut rate, opaque(1), opaque(2)), RateCheck::ratio(&rate)));
    RateCheck::restart(&mut rate);
    alive();
    Monitor::begin_trial(&mut other);
    Monitor::tell_alignment(&mut other, opaque(Alignment::Misaligned));
    opaque((Alignment::message(opaque(Alignment::Unknown)), Obstacle::message(opaque(Obstacle::TooNoisy))));
    let mut bytes = opaque([0; 1000]);
    opaque((Monitor::end_run(&mut monitor), Monitor::report(&monitor).is_some()));
    opaque((Monitor::save(&mut monitor, &mut bytes).is_ok(), Monitor::restore(&mut monitor, &bytes).is_ok()));
    opaque(Evidence::segments(Monitor::evidence(&monitor)));
    of_directions(model, Monitor::evidence(&monitor));
    Monitor::limit_silence(&mut monitor, SilenceLimits { segments: opaque(3), hours: opaque(1.0) });
    opaque(Monitor::deny(&mut monitor));
    Monitor::reset(&mut monitor);
}

/// The clock of the firmware.
fn alive() {
    let mut liveness = opaque(Liveness::new(opaque(LivenessLimits::of_segments(opaque(10.0)))));
    opaque((Liveness::push(&mut liveness, opaque([1, 2, 3]), opaque(4)), Liveness::lapsed(&liveness)));
    Liveness::restart(&mut liveness);
}

/// What an alarm by directions says.
fn of_directions<P: Plan>(model: &Model<P>, evidence: &Evidence<P>) {
    opaque((Evidence::main_contribution(evidence), Evidence::contribution(evidence, opaque(1))));
    opaque((Evidence::learned_runs(evidence), Evidence::unlike_the_fleet(evidence)));
    let growth =
        opaque(Evidence::growth(evidence, opaque(1)).or(Evidence::growth_to(evidence, opaque(1), opaque(9.0))));
    if let Some(growth) = growth {
        opaque((Growth::is_growing(&growth), Growth::left_hours(&growth), Growth::slope_per_hour(&growth)));
        opaque(Interval::times(growth.size, opaque(2.0)));
    }
    opaque(Directions::none(opaque(model.plan())).most_runs);
}

/// Places that are exchanged.
pub fn exchange<P: Plan>(model: &Model<P>, mut sample: impl FnMut() -> P::Sample) {
    let [mut first, mut second] = opaque([(); 2].map(|()| Segment::new(opaque(model))));
    let (mut detector, mut spare) = (Detector::with_place(model, &mut first), Some(&mut second));
    let mut monitor = opaque(Monitor::new(model));
    for _ in 0..opaque(50) {
        match Detector::exchange(&mut detector, &opaque(sample()), &mut spare) {
            Exchange::Open | Exchange::Lost => {}
            Exchange::Closed(place) => {
                Monitor::take_from(&mut monitor, opaque(place));
                spare = opaque(Some(place));
            }
        }
    }
    opaque(Monitor::step(&mut monitor, &mut detector, &sample()).is_some());
    opaque(Monitor::finish(&mut monitor, &mut detector).alarm);
}
