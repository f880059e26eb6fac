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

main!(run);

#[cfg(not(target_os = "none"))]
fn run() {
    say!("stack is measured on the target only: cargo xtask measure");
}

#[cfg(target_os = "none")]
fn run() {
    use core::hint::black_box;

    use bearing_watch::{Sample, Verdict};
    use paint::stack_of;

    // A known depth first: a painter that sees nothing would give plausible, small figures.
    let known = stack_of(|| {
        black_box([1_u8; 1024]);
    });
    assert!((1024..1280).contains(&known), "1024 bytes measured as {known}");

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
            black_box(monitor.step(sample));
        });
        inside = inside.max(bytes);
    }
    while monitor.pending() + 1 < model::MODEL.sampling.segment_samples {
        let _inside = black_box(monitor.step(sample()));
    }
    let last = black_box(sample());
    let mut classified = false;
    let end = stack_of(|| {
        let report = black_box(monitor.step(last));
        classified = report.is_some_and(|report| matches!(report.verdict, Verdict::Class(_)));
    });
    assert!(classified, "the last sample brought no class");
    let n = model::MODEL.regression.columns() - 1;
    for (name, bytes) in [("stack, detector sample", inside), ("stack, detector segment end", end)] {
        say!(r#"{{"name":"{name}","n":{n},"instructions":null,"bytes":{bytes}}}"#);
    }
}
