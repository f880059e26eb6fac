//! Bytes of stack that the detector takes, one JSON object a line: run it by `cargo xtask measure`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[cfg(target_os = "none")]
#[path = "support/standard_rig/model.rs"]
mod model;

#[cfg(target_os = "none")]
#[path = "support/paint.rs"]
mod paint;

#[cfg(target_os = "none")]
use core::hint::black_box;

#[cfg(target_os = "none")]
use bearing_watch::estimate::Watch;
#[cfg(target_os = "none")]
use bearing_watch::{Sample, Shaft, Verdict};
#[cfg(target_os = "none")]
use paint::stack_of;
#[cfg(target_os = "none")]
use support::refined;

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

    let least = least_squares();
    report("stack, detector", model::MODEL.regression.parameters(), least);
    let refined = refined();
    report("stack, SRIV detector", refined::MODEL.regression.parameters(), refined);
    shaft();
}

/// A shaft of four orders, by itself.
#[cfg(target_os = "none")]
fn shaft() {
    let model = black_box(support::shaft::model::<4>(1, 50));
    let mut plant = support::shaft::Plant::new(16);
    let mut shaft = Shaft::new(Some(&model));
    let mut inside = 0;
    for _ in 0..1000 {
        let motion = black_box(plant.motion());
        inside = stack_of(|| shaft.step(Some(&model), &motion)).max(inside);
    }
    let mut silent = true;
    let end = stack_of(|| {
        let estimate = shaft.sums().map(|sums| model.conclude(black_box(&sums)));
        silent = black_box(&estimate).as_ref().is_none_or(|estimate| estimate.reason.is_some());
    });
    assert!(!silent, "the shaft said nothing");
    report("stack, shaft of 4 orders,", 4, Depths { inside, end, deferred: None });
}

/// Bytes of a sample inside a segment, and of the one that ends it; by `collect`, and of `conclude`.
#[cfg(target_os = "none")]
struct Depths {
    inside: usize,
    end: usize,
    deferred: Option<(usize, usize)>,
}

#[cfg(target_os = "none")]
fn report(name: &str, n: usize, depths: Depths) {
    let line = |what: &str, bytes: usize| {
        say!(r#"{{"name":"{name} {what}","n":{n},"instructions":null,"bytes":{bytes}}}"#);
    };
    line("sample", depths.inside);
    line("segment end", depths.end);
    if let Some((collect, conclude)) = depths.deferred {
        line("collect", collect);
        line("conclude", conclude);
    }
}

#[cfg(target_os = "none")]
fn least_squares() -> Depths {
    let mut monitor = match model::Monitor::new(black_box(&model::MODEL)) {
        Ok(monitor) => monitor,
        Err(error) => panic!("the model is refused: {error}"),
    };
    let mut numbers = support::numbers::Numbers(4);
    let mut sample = || {
        let [y, u1, u2] = numbers.array();
        Sample { y, u1, u2 }
    };
    // The filling of the lags and the first rows are among these.
    let mut inside = 0;
    for _ in 0..100 {
        let sample = black_box(sample());
        let bytes = stack_of(|| {
            black_box(&monitor.step(sample));
        });
        inside = inside.max(bytes);
    }
    while monitor.pending() + 1 < model::MODEL.sampling.segment_samples {
        let _inside = black_box(monitor.step(sample()));
    }
    let last = black_box(sample());
    let mut classified = false;
    let end = stack_of(|| {
        let report = monitor.step(last);
        let verdict = black_box(&report).as_ref().map(|report| report.verdict);
        classified = matches!(verdict, Some(Verdict::Class(_)));
    });
    assert!(classified, "the last sample brought no class");
    Depths { inside, end, deferred: None }
}

#[cfg(target_os = "none")]
fn refined() -> Depths {
    let mut monitor = match refined::Monitor::new(black_box(&refined::MODEL)) {
        Ok(monitor) => monitor,
        Err(error) => panic!("the model is refused: {error}"),
    };
    let mut plant = refined::Plant::new(4);
    let mut depths = Depths { inside: 0, end: 0, deferred: None };
    let mut classified = 0;
    // Twice, since the first auxiliary model is the nominal one.
    for _ in 0..2 * refined::MODEL.sampling.segment_samples {
        let sample = black_box(plant.sample());
        let closes = monitor.pending() + 1 == refined::MODEL.sampling.segment_samples;
        let bytes = stack_of(|| {
            let report = monitor.step(sample);
            let verdict = black_box(&report).as_ref().map(|report| report.verdict);
            classified += u32::from(matches!(verdict, Some(Verdict::Class(_))));
        });
        let deepest = if closes { &mut depths.end } else { &mut depths.inside };
        *deepest = bytes.max(*deepest);
    }
    let mut collect = 0;
    for _ in 0..refined::MODEL.sampling.segment_samples {
        let sample = black_box(plant.sample());
        let bytes = stack_of(|| {
            let segment = monitor.collect(sample);
            black_box(&segment);
        });
        collect = bytes.max(collect);
    }
    let mut segment = None;
    while segment.is_none() {
        segment = monitor.collect(plant.sample());
    }
    let conclude = stack_of(|| {
        if let Some(segment) = segment.take() {
            let report = refined::MODEL.conclude(segment);
            classified += u32::from(matches!(black_box(&report).verdict, Verdict::Class(_)));
        }
    });
    assert_eq!(classified, 3, "a segment brought no class");
    depths.deferred = Some((collect, conclude));
    depths
}
