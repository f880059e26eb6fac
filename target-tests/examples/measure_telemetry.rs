//! Counts the instructions of frames, as lines of JSON; `bytes` are those of the frame.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "../../examples/support/standard_rig/mod.rs"]
mod standard_rig;

use core::hint::black_box;

use bearing_watch::drive::{PhaseCounts, Position, RawSample};
use bearing_watch::telemetry::{Decoder, Encoder, RawRecorder, Recorder, SegmentFrame, Source};
use bearing_watch::{Angle, Detector, Evidence, Report};

use standard_rig::model::{Drive, MODEL};
use support::count::Counter;
use support::directed;

const CALLS: u32 = 20;

main!(run);

fn run() {
    let Some(mut counter) = Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask firmware measure_telemetry");
        return;
    };
    let mut monitor = Detector::new(&MODEL);
    let Some(report) = standard_rig::samples().find_map(|sample| monitor.step(&sample)) else { return };
    frames(&mut counter, &report);
    risen(&mut counter);
    samples(&mut counter);
    raw(&mut counter);
}

fn frames(counter: &mut Counter, report: &Report<Drive>) {
    let mut evidence = Evidence::new(&MODEL);
    evidence.observe(report.decision.as_ref());
    let mut buffer = [0; 512];
    let mut encoder = Encoder::new(&MODEL, Source::default());
    let new = counter.instructions_per_call(CALLS, |_| {
        black_box(Encoder::new(black_box(&MODEL), Source::default()));
    });
    line("new encoder", new, size_of_val(&encoder));
    let mut bytes = 0;
    let hello = counter.instructions_per_call(CALLS, |_| {
        bytes = black_box(&mut encoder).hello(black_box(&mut buffer)).map_or(0, <[u8]>::len);
    });
    line("hello, 3 channels, 3 classes", hello, bytes);
    let whole = counter.instructions_per_call(CALLS, |_| {
        let frame = black_box(&mut encoder).report(black_box(report), black_box(&evidence), black_box(&mut buffer));
        bytes = frame.map_or(0, <[u8]>::len);
    });
    line("report, 3 classes, 5 features", whole, bytes);
    let mut decoder = Decoder::<512>::new();
    let frame = buffer.get(..bytes).unwrap_or_default();
    // The first call only: others would find a repeated frame.
    let mut found = false;
    let received = counter.instructions_per_call(1, |_| {
        for byte in black_box(frame) {
            found |= black_box(&mut decoder).push(*byte).is_some();
        }
    });
    line("decoding that report", received, if found { bytes } else { 0 });
}

/// A report with contributions, and reports as CAN frames.
fn risen(counter: &mut Counter) {
    let (mut evidence, mut report) = (Evidence::new(&directed::MODEL), Detector::new(&directed::MODEL).finish());
    report.decision = directed::decision([0.5; directed::DIRECTIONS]);
    evidence.observe(report.decision.as_ref());
    evidence.end_run();
    let mut encoder = Encoder::new(&directed::MODEL, Source::default());
    let (mut buffer, mut bytes) = ([0; 512], 0);
    let whole = counter.instructions_per_call(CALLS, |_| {
        let frame = black_box(&mut encoder).report(black_box(&report), black_box(&evidence), black_box(&mut buffer));
        bytes = frame.map_or(0, <[u8]>::len);
    });
    line("report, 1 class, 5 features, 5 directions", whole, bytes);
    let can = counter.instructions_per_call(CALLS, |_| {
        black_box(SegmentFrame::of(black_box(&directed::MODEL), black_box(&report), black_box(&evidence)).to_bytes());
    });
    line("CAN frame of a report", can, 8);
}

fn samples(counter: &mut Counter) {
    let mut recorder = Recorder::<_, 480>::new(MODEL.plan());
    let mut buffer = [0; 512];
    let mut encoder = Encoder::new(&MODEL, Source::default());
    let mut next = standard_rig::samples();
    let Some(sample) = next.next() else { return };
    let push = counter.instructions_per_call(39, |_| {
        black_box(black_box(&mut recorder).push(black_box(&sample)));
    });
    line("recorder, a sample of 3 channels", push, 12);
    recorder.push(&sample);
    let taken = counter.instructions_per_call(1, |_| {
        black_box(black_box(&mut recorder).clone());
    });
    line("recorder, copy of a block of 40 samples", taken, size_of_val(&recorder));
    let mut bytes = 0;
    let block = counter.instructions_per_call(CALLS, |_| {
        let frame = black_box(&mut encoder).samples(&black_box(&recorder).block(), black_box(&mut buffer));
        bytes = frame.map_or(0, <[u8]>::len);
    });
    line("block of 40 samples of 3 channels", block, bytes);
}

fn raw(counter: &mut Counter) {
    let mut recorder = RawRecorder::<2, 480>::new(10_000.0);
    let position = Position::Absolute(Angle::from_bits(0x1234_5678));
    let currents = PhaseCounts::Three([2048, 2148, 1948]);
    let push = counter.instructions_per_call(23, |number| {
        let sample = RawSample { number, currents, position, further: [40.0, 0.1] };
        black_box(black_box(&mut recorder).push(black_box(&sample)));
    });
    line("raw recorder, a sample of 3 currents, an angle, 2 further channels", push, 20);
    let (mut buffer, mut bytes) = ([0; 512], 0);
    let mut encoder = Encoder::new(&MODEL, Source::default());
    let block = counter.instructions_per_call(CALLS, |_| {
        let frame = black_box(&mut encoder).raw(&black_box(&recorder).block(), black_box(&mut buffer));
        bytes = frame.map_or(0, <[u8]>::len);
    });
    line("block of 23 of these samples", block, bytes);
}

fn line(name: &str, instructions: u32, bytes: usize) {
    say!(r#"{{"name":"telemetry, {name}","n":null,"instructions":{instructions},"bytes":{bytes}}}"#);
}
