//! Instructions and bytes of the kernels, one JSON object a line: run it by `cargo xtask measure`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "../../examples/support/standard_rig/model.rs"]
mod model;

use core::hint::black_box;

use bearing_watch::drive::{AlphaBeta, RotorFrame};
use bearing_watch::model::{Channel, FeatureValue, Forgetting, Regression};
use bearing_watch::plan::{Cells, Plan};
use bearing_watch::recursive::{RecursiveEstimator, Triangle};
use bearing_watch::{Angle, Detector, Evidence, Exchange, Model, Monitor, Park, Segment};

use support::count::Counter;
use support::numbers::Numbers;
use support::{decimation, directed, refined, shaft, squares};

/// Number of calls over which a kernel is averaged.
const CALLS: u32 = 200;

/// Samples of a record, which repeats.
const SEGMENT: usize = 600;

main!(run);

fn run() {
    let Some(mut counter) = Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask measure");
        return;
    };
    let counter = &mut counter;
    front_end(counter);
    updates::<6, 15>(counter, "LS update", 5);
    updates::<9, 36>(counter, "LS update", 8);
    updates::<13, 78>(counter, "LS update", 12);
    updates::<16, 120>(counter, "LS update", 15);
    // With two and three output terms, each of which has a column for its instrument.
    updates::<11, 55>(counter, "IV update", 8);
    updates::<19, 171>(counter, "IV update", 15);
    estimator(counter, "LS", &squares::MODEL, sample_of_squares);
    estimator(counter, "SRIV", &refined::MODEL, |sample| sample);
    decision(counter);
    monitor(counter);
    let mut plant = refined::Plant::new(5);
    let records: [refined::Sample; SEGMENT] = core::array::from_fn(|_| plant.sample());
    detector(counter, "SRIV detector", 8, &refined::MODEL, &records);
    let records = records.map(sample_of_squares);
    detector(counter, "LS detector", 8, &squares::MODEL, &records);
    watched(counter, "LS and shaft, 4 orders of 3 harmonics", 4, &shaft::MODEL);
    watched(counter, "shaft alone, 2 orders of 3 harmonics", 2, &shaft::CHOSEN);
    watched(counter, "shaft alone, 1 order, no load", 1, &shaft::LOADLESS);
    watched(counter, "shaft alone, 1 order, a weight that changes on an axis", 1, &shaft::WEIGHING);
    runs(counter);
    decimation::measure(counter, |name, factor, instructions, bytes| {
        report(name, factor, instructions, bytes);
    });
    support::front_end::measure(counter, |name, factor, instructions, bytes| {
        line(format_args!("front end, {name}"), factor, instructions, Some(bytes));
    });
}

fn front_end(counter: &mut Counter) {
    let angle = counter.instructions_per_call(CALLS, |k| {
        black_box(Angle::from_bits(black_box(k.wrapping_mul(0x1234_5678))).sin_cos());
    });
    report("sin_cos", None, angle, 0);
    let sc = Angle::from_bits(0x2345_6789).sin_cos();
    let given = counter.instructions_per_call(CALLS, |_| {
        let (a, b) = black_box((1.5_f32, -0.25_f32));
        black_box(Park::Standard.forward(AlphaBeta::from_two(a, b), black_box(sc)));
    });
    report("Clarke + Park, sin_cos given", None, given, 0);
    let frame = RotorFrame { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard };
    let whole = counter.instructions_per_call(CALLS, |k| {
        let (a, b) = black_box((1.5_f32, -0.25_f32));
        let shaft = Angle::from_bits(black_box(k.wrapping_mul(0x1234_5678)));
        black_box(frame.transform(AlphaBeta::from_two(a, b), shaft));
    });
    report("sin_cos + Clarke + Park", None, whole, size_of_val(&frame));
}

fn updates<const M: usize, const P: usize>(counter: &mut Counter, name: &str, n: usize) {
    let mut numbers = Numbers(1);
    let rows: [[f32; M]; 8] = core::array::from_fn(|_| numbers.array());
    let mut triangle = Triangle::<[f32; M], [f32; P]>::new(M);
    let mut next = rows.iter().cycle();
    // The row source is not part of the kernel: its count is subtracted.
    let mut source = rows.iter().cycle();
    let overhead = counter.instructions_per_call(CALLS, |_| {
        black_box(source.next());
    });
    let forgetting = black_box(Forgetting { lambda: 0.9999, floor: 100.0 });
    let with = counter.instructions_per_call(CALLS, |_| {
        if let Some(row) = black_box(next.next()) {
            triangle.update_forgetting(row, forgetting);
        }
        black_box(&mut triangle);
    });
    report(name, n, with - overhead, size_of_val(&triangle));
    let plain = counter.instructions_per_call(CALLS, |_| {
        if let Some(row) = black_box(next.next()) {
            triangle.update(row);
        }
        black_box(&mut triangle);
    });
    line(format_args!("{name}, lambda 1"), n, plain - overhead, Some(size_of_val(&triangle)));
}

fn sample_of_squares(refined::Sample { y, u1, u2 }: refined::Sample) -> squares::Sample {
    squares::Sample { y, u1, u2 }
}

/// A sample of an estimator with its gate, and the solve at the end of a segment.
fn estimator<P: Plan>(
    counter: &mut Counter,
    name: &str,
    model: &Model<P>,
    convert: impl Fn(refined::Sample) -> P::Sample,
) {
    let plan = model.plan();
    let Some(own) = model.constants().regression.part() else { return };
    let constants: Regression<P> = own.clone();
    let mut channels = model.constants().channels.clone();
    let [with, without] = [1000, 0].map(|stuck_samples| {
        if let Some(first) = channels.cells_mut().first_mut() {
            *first = Channel { stuck_samples, ..*first };
        }
        channels.clone()
    });
    let mut plant = refined::Plant::new(2);
    let samples: [P::Sample; 256] = core::array::from_fn(|_| convert(plant.sample()));
    for (channels, what) in [(&without, "sample"), (&with, "sample, stuck sensor told")] {
        let mut alone = RecursiveEstimator::new(plan, black_box(channels), black_box(&constants));
        samples.iter().cycle().take(300).for_each(|sample| alone.step(sample));
        let mut next = samples.iter().cycle();
        let mut worst = 0;
        for _ in 0..64 {
            let Some(sample) = next.next() else { return };
            let one = counter.instructions_per_call(1, |_| black_box(&mut alone).step(black_box(sample)));
            worst = one.max(worst);
        }
        let sample = convert(refined::Sample { y: 0.5, u1: -0.25, u2: 0.75 });
        let step = counter.instructions_per_call(CALLS, |_| black_box(&mut alone).step(black_box(&sample)));
        line(format_args!("{name} {what}"), 8, step, Some(size_of_val(&alone)));
        line(format_args!("{name} {what}, worst of 64"), 8, worst, None);
    }
    let mut alone = RecursiveEstimator::new(plan, &with, &constants);
    samples.iter().cycle().take(500).for_each(|sample| alone.step(sample));
    let mut closed = alone.clone().detach();
    let solve = counter.instructions_once(|| while black_box(&mut closed).advance(black_box(&constants)).is_none() {});
    line(format_args!("{name} solve + covariance"), 8, solve, None);
    if let Some(reason) = alone.estimate().reason {
        say!("no estimate: {reason}");
    }
}

fn decision(counter: &mut Counter) {
    let model = &squares::MODEL;
    let (plan, classifier) = (model.plan(), &model.constants().classifier);
    let features = Numbers(3).array::<9>().map(|value| FeatureValue { value, variance: 0.0 });
    let project = || [0, 1, 2].map(|k| black_box(&classifier.projection).coordinate(black_box(&features), k));
    let count = counter.instructions_per_call(CALLS, |_| {
        black_box(project());
    });
    report("projection 9 to 3", None, count, size_of_val(&classifier.projection));
    let z = project().map(|z| z.value);
    let mut decide = |name: &str, variances: &[f32]| {
        let both = counter.instructions_per_call(CALLS, |_| {
            black_box(black_box(classifier).decide_at(black_box(plan), black_box(&z), black_box(variances)));
        });
        report(name, None, both, size_of_val(&classifier.discriminant));
    };
    decide("quadratic discriminant with posteriors and costs", &[0.0; 3]);
    decide("quadratic discriminant of coordinates with errors", &[0.1, f32::INFINITY, 0.2]);
}

/// The detector of the example `monitor`: a sample inside a segment, and what closing a segment adds.
fn monitor(counter: &mut Counter) {
    let mut monitor = Detector::new(black_box(&model::MODEL));
    let mut numbers = Numbers(4);
    let mut sample = || {
        let [current_a, velocity_ref_rad_s, load_torque_nm] = numbers.array();
        model::Sample { current_a, velocity_ref_rad_s, load_torque_nm }
    };
    for _ in 0..100 {
        let _ = monitor.step(&sample());
    }
    let close = counter.instructions_per_call(20, |_| {
        black_box(black_box(&monitor).preview());
    });
    let one = sample();
    let step = counter.instructions_per_call(CALLS, |_| {
        black_box(black_box(&mut monitor).step(black_box(&one)).is_some());
    });
    let n = model::MODEL.plan().layout().parameters();
    report("detector sample, monitor", n, step, size_of_val(&monitor));
    report("detector segment end, monitor", n, close, 0);
}

/// What a drive calls: a sample that collects, the sample that closes a segment, its solve at once and in steps, and
/// reading the model.
fn detector<P: Plan>(counter: &mut Counter, name: &str, n: usize, model: &Model<P>, samples: &[P::Sample]) {
    let [mut one, mut other] = [(); 2].map(|()| Segment::new(model));
    let (mut detector, mut spare) = (Detector::with_place(black_box(model), &mut one), Some(&mut other));
    let length = model.constants().sampling.segment_samples;
    let (mut monitor, mut segment) = (Monitor::new(model), None);
    let (mut total, mut longest, mut close) = (0, 0, 0);
    let mut next = samples.iter().cycle();
    // The first segment fills lags and filters.
    for number in 0..2 * length {
        let Some(sample) = next.next() else { return };
        let mut closed = Exchange::Open;
        let one = counter.instructions_per_call(1, |_| {
            closed = black_box(&mut detector).exchange(black_box(sample), black_box(&mut spare));
        });
        if let Exchange::Closed(place) = closed {
            close = one;
            segment = Some(place.clone());
            monitor.take_from(place);
            monitor.complete();
            spare = Some(place);
        } else if number >= length {
            (total, longest) = (total + one, one.max(longest));
        }
    }
    let Some(mut segment) = segment else { return };
    line(format_args!("{name}, collect, mean sample"), n, total / (length - 1), Some(size_of_val(&detector)));
    line(format_args!("{name}, collect, longest sample"), n, longest, None);
    line(format_args!("{name}, collect, sample that closes"), n, close, Some(size_of_val(&segment)));
    let (mut verdict, mut place) = (None, segment.clone());
    let whole = counter.instructions_once(|| {
        black_box(&mut monitor).take_from(black_box(&mut place));
        verdict = black_box(&mut monitor).complete().map(|now| now.report.verdict);
    });
    line(format_args!("{name}, conclude"), n, whole, None);
    if let Some(bearing_watch::Verdict::Undetermined(reason)) = verdict {
        say!("no verdict: {reason}");
    }
    monitor.take_from(&mut segment);
    let (mut steps, mut largest) = (0, 0);
    while monitor.is_solving() {
        let step = counter.instructions_once(|| {
            black_box(black_box(&mut monitor).advance().is_some());
        });
        (steps, largest) = (steps + 1, step.max(largest));
    }
    line(format_args!("{name}, longest step"), n, largest, Some(size_of_val(&monitor)));
    say!(r#"{{"name":"{name}, number of steps","n":{steps},"instructions":null,"bytes":null}}"#);
    let mut buffer = [0; 2048];
    let Ok(written) = model.to_bytes("", &mut buffer) else { return };
    let bytes = buffer.get(..written).unwrap_or_default();
    let mut read = false;
    let reading =
        counter.instructions_per_call(1, |_| read = black_box(Model::<P>::from_bytes(black_box(bytes))).is_ok());
    line(format_args!("{name}, reading and checking its model"), n, reading, Some(written));
    if !read {
        say!("the model cannot be read back");
    }
}

/// A detector that watches the shaft.
fn watched<P: Plan<Sample: From<shaft::Motion>>>(counter: &mut Counter, name: &str, n: usize, model: &Model<P>) {
    let mut plant = shaft::Plant::new(6);
    let samples: [P::Sample; 1000] = core::array::from_fn(|_| plant.motion().into());
    detector(counter, name, n, model, &samples);
}

/// The evidence of runs of six segments: a segment, the end of a run, and what a growth takes.
fn runs(counter: &mut Counter) {
    let mut evidence = Evidence::new(black_box(&directed::MODEL));
    let mut numbers = Numbers(7);
    let (mut segment, mut end) = (0, 0);
    for number in 0..60 {
        for _ in 0..6 {
            let values = numbers.array().map(|value| value + 0.06 * number as f32);
            let Some(decision) = directed::decision(values) else { return };
            let one = counter.instructions_per_call(1, |_| {
                black_box(black_box(&mut evidence).observe(black_box(Some(&decision))));
            });
            segment = one.max(segment);
        }
        let one = counter.instructions_per_call(1, |_| {
            black_box(black_box(&mut evidence).end_run());
        });
        end = one.max(end);
    }
    let mut grows = false;
    let growth = counter.instructions_per_call(1, |_| {
        grows = black_box(black_box(&evidence).growth(0)).is_some_and(|growth| growth.is_growing());
    });
    if !grows {
        say!("the directions do not grow");
    }
    let (n, bytes) = (directed::DIRECTIONS, size_of_val(&evidence));
    line(format_args!("evidence of runs, longest segment"), n, segment, Some(bytes));
    line(format_args!("evidence of runs, longest end of a run"), n, end, None);
    line(format_args!("evidence of runs, growth of a direction"), n, growth, None);
}

/// One line: the kernel, its size n where it has one, instructions a call, bytes of state.
fn report(name: &str, n: impl Into<Option<usize>>, instructions: u32, bytes: usize) {
    let tail = format_args!(r#""instructions":{instructions},"bytes":{bytes}}}"#);
    match n.into() {
        Some(n) => say!(r#"{{"name":"{name}","n":{n},{tail}"#),
        None => say!(r#"{{"name":"{name}","n":null,{tail}"#),
    }
}

fn line(name: core::fmt::Arguments<'_>, n: usize, instructions: u32, bytes: Option<usize>) {
    match bytes {
        Some(bytes) => say!(r#"{{"name":"{name}","n":{n},"instructions":{instructions},"bytes":{bytes}}}"#),
        None => say!(r#"{{"name":"{name}","n":{n},"instructions":{instructions},"bytes":null}}"#),
    }
}
