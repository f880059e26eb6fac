//! Bytes of stack that the detector takes, one JSON object a line: run it by `cargo xtask measure`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[cfg(target_os = "none")]
#[path = "../../examples/support/standard_rig/model.rs"]
mod model;

#[cfg(target_os = "none")]
use core::hint::black_box;

#[cfg(target_os = "none")]
use bearing_watch::plan::Plan;
#[cfg(target_os = "none")]
use bearing_watch::{Detector, Exchange, Model, Monitor, Segment, Verdict};
#[cfg(target_os = "none")]
use support::paint::stack_of;
#[cfg(target_os = "none")]
use support::{refined, shaft};

main!(run);

#[cfg(not(target_os = "none"))]
fn run() {
    say!("stack is measured on the target only: cargo xtask measure");
}

#[cfg(target_os = "none")]
fn run() {
    // A known depth first: a painter that sees nothing would give plausible, small figures.
    let known = stack_of(|| {
        black_box([1_u8; 1024]);
    });
    assert!((1024..1280).contains(&known), "1024 bytes measured as {known}");

    let mut numbers = support::numbers::Numbers(4);
    depths("stack, detector", &model::MODEL, || {
        let [current_a, velocity_ref_rad_s, load_torque_nm] = numbers.array();
        model::Sample { current_a, velocity_ref_rad_s, load_torque_nm }
    });
    let mut plant = refined::Plant::new(4);
    depths("stack, SRIV detector", &refined::MODEL, || plant.sample());
    let mut plant = shaft::Plant::new(16);
    depths("stack, detector with shaft of 4 orders", &shaft::MODEL, || plant.motion().into());
    depths("stack, shaft alone of 2 orders", &shaft::CHOSEN, || plant.motion().into());
}

/// Prints bytes of a sample inside a segment, and of the one that ends it; by `exchange`, of a whole solve, and of a
/// step of the solve.
#[cfg(target_os = "none")]
fn depths<P: Plan>(name: &str, model: &Model<P>, mut sample: impl FnMut() -> P::Sample) {
    let model = black_box(model);
    let mut detector = Detector::new(model);
    let length = model.constants().sampling.segment_samples;
    let (mut inside, mut end, mut classified, mut last) = (0, 0, 0, None);
    // Twice, since the first segment fills lags and filters, and has the nominal auxiliary model.
    for _ in 0..2 * length {
        let sample = black_box(sample());
        let closes = detector.pending() + 1 == length;
        let bytes = stack_of(|| {
            let report = detector.step(&sample);
            let verdict = black_box(&report).as_ref().map(|report| report.verdict);
            classified += u32::from(matches!(verdict, Some(Verdict::Class(_))));
            last = verdict.or(last);
        });
        let deepest = if closes { &mut end } else { &mut inside };
        *deepest = bytes.max(*deepest);
    }
    assert_eq!(classified, 2, "a segment brought no class: {last:?}");
    let [mut one, mut other] = [(); 2].map(|()| Segment::new(model));
    let (mut detector, mut spare) = (Detector::with_place(model, &mut one), Some(&mut other));
    let (mut collect, mut segments) = (0, 0);
    let segment = loop {
        let (sample, mut closed) = (black_box(sample()), Exchange::Open);
        let bytes = stack_of(|| closed = black_box(detector.exchange(&sample, &mut spare)));
        collect = bytes.max(collect);
        if let Exchange::Closed(place) = closed {
            segments += 1;
            if segments == 2 {
                break place;
            }
            spare = Some(place);
        }
    };
    let mut monitor = Monitor::new(model);
    let mut again = segment.clone();
    monitor.take_from(segment);
    let mut step = 0;
    while monitor.is_solving() {
        step = stack_of(|| {
            black_box(monitor.advance().is_some());
        })
        .max(step);
    }
    let conclude = stack_of(|| {
        monitor.take_from(&mut again);
        let verdict = black_box(monitor.complete()).map(|now| now.report.verdict);
        classified += u32::from(matches!(verdict, Some(Verdict::Class(_))));
    });
    assert_eq!(classified, 3, "a segment brought no class");
    let calls = [
        ("sample", inside),
        ("segment end", end),
        ("collect", collect),
        ("conclude", conclude),
        ("step of the solve", step),
    ];
    let n = model.plan().layout().parameters();
    for (call, bytes) in calls {
        say!(r#"{{"name":"{name} {call}","n":{n},"instructions":null,"bytes":{bytes}}}"#);
    }
}
