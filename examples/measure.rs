//! Instructions and bytes of the kernels, one JSON object a line: run it by `cargo xtask measure`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "support/standard_rig/model.rs"]
mod model;

use core::hint::black_box;

use bearing_watch::decide::{Discriminant, Kind, Projection};
use bearing_watch::estimate::{Forgetting, Form, Method, Nominal, Rows, Shape, Triangle, Watch};
use bearing_watch::{
    AlphaBeta, Angle, Estimator, FrontEnd, Guard, Instruments, Motion, Order, Park, Regression, Regressor, Sample,
    Segment, Shaft,
};

use support::count::Counter;
use support::decimation;
use support::numbers::Numbers;

/// Calls a kernel is averaged over.
const CALLS: u32 = 200;

main!(run);

fn run() {
    let Some(mut counter) = Counter::new() else {
        say!("instructions are counted on the target only: cargo xtask measure");
        return;
    };
    front_end(&mut counter);
    updates::<6, 15>(&mut counter, "LS update", 5);
    updates::<9, 36>(&mut counter, "LS update", 8);
    updates::<13, 78>(&mut counter, "LS update", 12);
    updates::<16, 120>(&mut counter, "LS update", 15);
    // With two and three output terms, each of which has a column for its instrument.
    updates::<11, 55>(&mut counter, "IV update", 8);
    updates::<19, 171>(&mut counter, "IV update", 15);
    theta(&mut counter);
    estimators(&mut counter);
    decision(&mut counter);
    monitor(&mut counter);
    shaft::<4>(&mut counter, "shaft, 4 orders", 1);
    shaft::<1>(&mut counter, "shaft, 1 order of 3 harmonics", 3);
    decimation::measure(&mut counter, |name, factor, instructions, bytes| {
        report(name, factor, instructions, bytes);
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
    let front = FrontEnd { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard };
    let whole = counter.instructions_per_call(CALLS, |k| {
        let (a, b) = black_box((1.5_f32, -0.25_f32));
        let shaft = Angle::from_bits(black_box(k.wrapping_mul(0x1234_5678)));
        black_box(front.transform(AlphaBeta::from_two(a, b), shaft));
    });
    report("sin_cos + Clarke + Park", None, whole, size_of_val(&front));
}

fn updates<const M: usize, const P: usize>(counter: &mut Counter, name: &str, n: usize) {
    let mut numbers = Numbers(1);
    let rows: [[f32; M]; 8] = core::array::from_fn(|_| numbers.array());
    let mut triangle = Triangle::<M, P>::new(M);
    let mut next = rows.iter().cycle();
    // The row source is not part of the kernel: count it alone and take it off.
    let mut source = rows.iter().cycle();
    let overhead = counter.instructions_per_call(CALLS, |_| {
        black_box(source.next());
    });
    let forgetting = black_box(Forgetting { lambda: 0.9999, floor: 100.0 });
    let with = counter.instructions_per_call(CALLS, |_| {
        if let Some(row) = black_box(next.next()) {
            triangle.update_forgetting(row, 1.0, forgetting);
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
    say!(
        r#"{{"name":"{name}, lambda 1","n":{n},"instructions":{},"bytes":{}}}"#,
        plain - overhead,
        size_of_val(&triangle)
    );
}

/// Parameters read from a factor whose capacity is used up, as fading memory allows after any row.
fn theta(counter: &mut Counter) {
    let mut numbers = Numbers(1);
    let mut triangle = Triangle::<9, 36>::new(9);
    (0..50).for_each(|_| triangle.update(&numbers.array()));
    let solve = counter.instructions_per_call(CALLS, |_| {
        black_box(black_box(&triangle).solve());
    });
    report("LS theta read", 8, solve, 0);
}

/// Two output terms and three of each input, known when compiling, by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Squares;

/// The same by instrumental variables.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Refined;

const EIGHT: Form = Form { order: Order::new(2, 3, 3, 1, 1), offset: false, method: Method::LeastSquares };

impl Shape for Squares {
    const FIXED: Option<Form> = Some(EIGHT);
}

impl Shape for Refined {
    const FIXED: Option<Form> = Some(Form { method: Method::Instruments, ..EIGHT });
}

/// Estimators around the kernel: gate, lags, row, update; and the solve at the end of a segment.
fn estimators(counter: &mut Counter) {
    let guard = Guard { stuck_samples: [1000, 0, 0], huber: 6.0, ..Guard::within([100.0; 3]) };
    let least = Regression::<9> { guard, settle: 20, ..Regression::new(Order::new(2, 3, 3, 1, 1), false) };
    let plain = Regression::<9> { guard: Guard::within([100.0; 3]), ..least };
    estimator::<9, 36, Regressor<9, 1>>(counter, "LS sample, order at run time", &plain);
    estimator::<9, 36, Regressor<9, 1, Squares>>(counter, "LS sample", &plain);
    estimator::<9, 36, Regressor<9, 1, Squares>>(counter, "LS sample, stuck sensor and outliers told", &least);
    let nominal = Nominal { delta: [-0.1, 0.4, 0.1, 0.05, -0.02, 0.1, 0.05, -0.02, 0.0, 0.0, 0.0], deviation: 0.5 };
    let base = Regression::<11>::new(Order::new(2, 3, 3, 1, 1), false);
    let instruments = Regression { guard, nominal, settle: 20, method: Method::Instruments, ..base };
    let plain = Regression { guard: Guard::within([100.0; 3]), ..instruments };
    estimator::<11, 55, Instruments<11, 1>>(counter, "SRIV sample, order at run time", &plain);
    estimator::<11, 55, Instruments<11, 1, Refined>>(counter, "SRIV sample", &plain);
    estimator::<11, 55, Instruments<11, 1, Refined>>(
        counter,
        "SRIV sample, stuck sensor and outliers told",
        &instruments,
    );
}

fn estimator<const M: usize, const P: usize, R: Rows<M>>(
    counter: &mut Counter,
    name: &str,
    regression: &Regression<M>,
) {
    let mut numbers = Numbers(2);
    let mut estimator = Estimator::<M, P, 1, R>::new(black_box(regression));
    // An output that follows its inputs, or instruments would be refused.
    let (mut y1, mut y2, mut last) = (0.0, 0.0, [0.0; 2]);
    let samples: [Sample; 256] = core::array::from_fn(|_| {
        let [u1, u2, e] = numbers.array();
        let y = 1.3 * y1 - 0.4 * y2 + 0.1 * last[0] + 0.1 * last[1];
        (y2, y1, last) = (y1, y, [u1, u2]);
        Sample { y: y + 0.01 * e, u1, u2 }
    });
    for sample in samples.iter().cycle().take(300) {
        estimator.step(sample);
    }
    let mut next = samples.iter().cycle();
    let mut worst = 0;
    for _ in 0..64 {
        let sample = next.next().copied().unwrap_or_default();
        let one = counter.instructions_per_call(1, |_| black_box(&mut estimator).step(black_box(&sample)));
        worst = one.max(worst);
    }
    let sample = Sample { y: 0.5, u1: -0.25, u2: 0.75 };
    let step = counter.instructions_per_call(CALLS, |_| black_box(&mut estimator).step(black_box(&sample)));
    let n = regression.parameters();
    report(name, n, step, size_of_val(&estimator));
    say!(r#"{{"name":"{name}, worst of 64","n":{n},"instructions":{worst},"bytes":null}}"#);
    if !name.ends_with("told") {
        return;
    }
    let solve = counter.instructions_per_call(20, |_| {
        let _ = black_box(black_box(&estimator).estimate());
    });
    let name = match regression.method {
        Method::LeastSquares => "LS solve + covariance",
        Method::Instruments => "SRIV solve + covariance",
    };
    report(name, n, solve, size_of::<Segment<M, P>>());
    if let Err(reason) = estimator.estimate() {
        say!("no estimate: {reason}");
    }
}

fn decision(counter: &mut Counter) {
    let mut numbers = Numbers(3);
    let projection =
        Projection::<9, 3> { matrix: core::array::from_fn(|_| numbers.array()), mean: numbers.array(), count: 3 };
    let discriminant = Discriminant::<3, 3> {
        kind: Kind::Quadratic,
        classes: 3,
        mean: core::array::from_fn(|_| numbers.array()),
        whitening: core::array::from_fn(|_| core::array::from_fn(|_| numbers.array())),
        log_normaliser: [0.0; 3],
        log_prior: [-1.098_612_3; 3],
        cost: [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]],
        reject_cost: f32::INFINITY,
    };
    let features: [f32; 9] = numbers.array();
    let project = counter.instructions_per_call(CALLS, |_| {
        black_box(black_box(&projection).project(black_box(&features)));
    });
    report("projection 9 to 3", None, project, size_of_val(&projection));
    let both = counter.instructions_per_call(CALLS, |_| {
        let z = black_box(&projection).project(black_box(&features));
        black_box(black_box(&discriminant).log_likelihoods(&z));
    });
    report("projection 9 to 3 + quadratic discriminant 3 classes", None, both, size_of_val(&discriminant));
    let z = projection.project(&features);
    let posteriors = counter.instructions_per_call(CALLS, |_| {
        black_box(black_box(&discriminant).decide(black_box(&z)));
    });
    report("quadratic discriminant with posteriors and costs", None, posteriors, 0);
}

/// The detector of the example `monitor`: a sample inside a segment, and what closing a segment adds.
fn monitor(counter: &mut Counter) {
    let Ok(mut monitor) = model::Monitor::new(black_box(&model::MODEL)) else {
        say!("the model is refused");
        return;
    };
    let mut numbers = Numbers(4);
    for _ in 0..100 {
        let [y, u1, u2] = numbers.array();
        let _ = monitor.step(Sample { y, u1, u2 });
    }
    let close = counter.instructions_per_call(20, |_| {
        black_box(black_box(&monitor).preview());
    });
    let sample = Sample { y: 0.5, u1: -0.25, u2: 0.75 };
    let step = counter.instructions_per_call(CALLS, |_| {
        black_box(black_box(&mut monitor).step(black_box(sample)).is_some());
    });
    let n = model::MODEL.regression.columns() - 1;
    report("detector sample, monitor", n, step, size_of_val(&monitor));
    report("detector segment end, monitor", n, close, 0);
}

/// What watching the shaft adds to a sample, and to the end of a segment.
fn shaft<const K: usize>(counter: &mut Counter, name: &str, harmonics: u8) {
    let mut plant = support::shaft::Plant::new(6);
    let motions: [Motion; 600] = core::array::from_fn(|_| plant.motion());
    // In blocks of a usual length; in blocks that do not end; and where a row and the end of a block meet.
    let mut figures = [(100, 0, 0), (u16::MAX, 0, 0), (20, 0, 0)];
    for (block_samples, mean, worst) in &mut figures {
        let model = support::shaft::model::<K>(harmonics, *block_samples);
        let mut shaft = Shaft::new(Some(&model));
        let mut step = |motion: &Motion| black_box(&mut shaft).step(Some(black_box(&model)), black_box(motion));
        // The filling of the filters and of the ring.
        motions.iter().take(200).for_each(&mut step);
        for motion in &motions[200..] {
            let one = counter.instructions_per_call(1, |_| step(motion));
            (*mean, *worst) = (*mean + one, one.max(*worst));
        }
        *mean = (*mean + 200) / 400;
    }
    let [(_, mean, _), (_, _, row), (_, _, worst)] = figures;
    let model = support::shaft::model::<K>(harmonics, 20);
    let mut shaft = Shaft::new(Some(&model));
    motions.iter().for_each(|motion| shaft.step(Some(&model), motion));
    let Some(sums) = shaft.sums() else { return };
    let estimate = model.conclude(&sums);
    if let Some(reason) = estimate.reason {
        say!("no estimate of the shaft: {reason}");
    }
    let conclude = counter.instructions_per_call(20, |_| {
        black_box(black_box(&model).conclude(black_box(&sums)));
    });
    let line = |what: &str, instructions: u32, bytes: usize| {
        say!(r#"{{"name":"{name}, {what}","n":{K},"instructions":{instructions},"bytes":{bytes}}}"#);
    };
    line("mean sample", mean, size_of_val(&shaft));
    line("sample with a row", row, size_of_val(&model));
    line("sample with a row that ends a block", worst, size_of_val(&sums));
    line("segment end", conclude, size_of_val(&estimate));
}

/// One line: the kernel, its size n where it has one, instructions a call, bytes of state.
fn report(name: &str, n: impl Into<Option<usize>>, instructions: u32, bytes: usize) {
    let tail = format_args!(r#""instructions":{instructions},"bytes":{bytes}}}"#);
    match n.into() {
        Some(n) => say!(r#"{{"name":"{name}","n":{n},{tail}"#),
        None => say!(r#"{{"name":"{name}","n":null,{tail}"#),
    }
}
