//! Where an estimator must refuse, wait or start anew: dead and noisy outputs, a memory that fills, a drive that never
//! moved, estimates of other segments, types that do not fit.

use bearing_watch::estimate::{Fading, Forgetting, Guard, Instruments, Memory, Method, Nominal, Regressor, Solver};
use bearing_watch::{Estimator, Order, Reason, Regression, Sample};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// y = 1.5 y₁ − 0.56 y₂ + 0.04 u₁ + 0.02 u₂ − 0.1 w₂ + noise in the equation, inputs held for a while; then white noise on
/// the output.
fn stream(seed: u64, count: usize, equation: f64, output: f64) -> Vec<Sample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let [mut y1, mut y2, mut u1, mut u2, mut w1, mut w2] = [0.0_f64; 6];
    let (mut u, mut w) = (0.0, 0.0);
    let mut sample = |t: usize| {
        let mut gauss = || -> f64 { rng.sample(StandardNormal) };
        let y = 1.5 * y1 - 0.56 * y2 + 0.04 * u1 + 0.02 * u2 - 0.1 * w2 + equation * gauss();
        let measured = y + output * gauss();
        u = if t.is_multiple_of(50) { gauss() } else { u };
        w = if t.is_multiple_of(30) { gauss() } else { w };
        (y2, y1, u2, u1, w2, w1) = (y1, y, u1, u, w1, w);
        Sample { y: measured as f32, u1: u as f32, u2: w as f32 }
    };
    (0..count).map(&mut sample).collect()
}

const TRUTH: [f32; 5] = [-0.06, 0.56, 0.06, -0.02, -0.1];

const fn least<const M: usize>(offset: bool) -> Regression<M> {
    Regression { guard: Guard::within([100.0; 3]), ..Regression::new(Order::new(2, 2, 1, 1, 2), offset) }
}

fn refined() -> Regression<8> {
    let mut delta = [0.0; 8];
    delta[..5].copy_from_slice(&TRUTH);
    Regression { method: Method::Instruments, nominal: Nominal { delta, deviation: 0.0 }, ..least(false) }
}

type Refined<'m> = Estimator<'m, 8, 28, 2, Instruments<8, 2>>;

#[test]
fn fading_memory_keeps_its_origin_over_segments() {
    let fading = Regression { memory: Memory::Fading(Forgetting { lambda: 0.9999, floor: 1e-6 }), ..least::<7>(true) };
    let data = stream(3, 20_000, 0.003, 0.0);
    let last = |length: usize| {
        let mut estimator = Estimator::<7, 21, 2, Regressor<7, 2>, Fading<7, 21>>::new(&fading);
        let closed = data.chunks(length).map(|segment| {
            segment.iter().for_each(|sample| estimator.step(sample));
            estimator.close()
        });
        closed.last().expect("a segment").expect("an estimate")
    };
    let whole = last(20_000);
    for length in [500, 1000] {
        let pieces = last(length);
        for (k, truth) in TRUTH.iter().enumerate() {
            let sd = whole.covariance_matrix()[(k, k)].sqrt();
            // Three parameters in a hundred thousand leave four deviations; segments change nothing but the report.
            assert!((whole.delta[k] - truth).abs() < 4.0 * sd, "{k}: {} {sd}", whole.delta[k]);
            assert!(
                (pieces.delta[k] - whole.delta[k]).abs() < 1e-3 * sd,
                "{k}: {} {}",
                pieces.delta[k],
                whole.delta[k]
            );
        }
    }
}

#[test]
fn dead_and_noisy_outputs_are_no_models() {
    let regression = refined();
    let result = |samples: &[Sample], change: &dyn Fn(usize, Sample) -> Sample| {
        let mut estimator = Refined::new(&regression);
        samples.iter().enumerate().for_each(|(t, sample)| estimator.step(&change(t, *sample)));
        estimator.close()
    };
    let dead = result(&stream(5, 3000, 0.0, 0.0), &|_, sample| Sample { y: 0.0, ..sample });
    assert!(dead.is_err(), "{dead:?}");
    let [mut weak, mut good] = [0; 2];
    for seed in 0..100 {
        let samples = stream(100 + seed, 3000, 0.0, 0.3);
        let mut rng = ChaCha8Rng::seed_from_u64(300 + seed);
        let noise: Vec<f32> = (0..3000).map(|_| rng.sample(StandardNormal)).collect();
        let drowned = result(&samples, &|t, sample| Sample { y: noise[t], ..sample });
        weak += u32::from(matches!(drowned, Err(Reason::WeakInstruments)));
        good += u32::from(result(&samples, &|_, sample| sample).is_ok());
    }
    println!("noise refused {weak} of 100, data of a deviation of 0.3 accepted {good} of 100");
    assert!((90..=100).contains(&weak) && good >= 99, "F > 10 on prefiltered rows: white noise passes now and then");
}

#[test]
fn a_memory_that_fills_is_not_held_by_its_floor() {
    let forgetting = Forgetting { lambda: 0.9999, floor: 100.0 };
    // Powers of two to rms ≈ 1, as training would find them.
    let scale = [1.0, 8.0, 1.0, 4.0, 1.0, 8.0];
    let fading = Regression { scale, memory: Memory::Fading(forgetting), still: 1e-9, ..least::<6>(false) };
    let mut estimator = Estimator::<6, 15, 2, Regressor<6, 2>, Fading<6, 15>>::new(&fading);
    stream(3, 20_000, 0.003, 0.0).iter().for_each(|sample| estimator.step(sample));
    let estimate = estimator.estimate().expect("an estimate");
    for (k, truth) in TRUTH.iter().enumerate() {
        let sd = estimate.covariance_matrix()[(k, k)].sqrt();
        // With the floor from the first row on, twelve deviations.
        assert!((estimate.delta[k] - truth).abs() < 4.0 * sd, "{k}: {} {sd}", estimate.delta[k]);
    }
}

#[test]
fn standstill_from_power_up_teaches_nothing() {
    let order = Order::new(1, 1, 1, 1, 1);
    let memory = Memory::Fading(Forgetting { lambda: 0.9999, floor: 1.0 });
    let fading =
        Regression::<4> { memory, still: 1e-3, guard: Guard::within([100.0; 3]), ..Regression::new(order, false) };
    let mut estimator = Estimator::<4, 6, 1, Regressor<4, 1>, Fading<4, 6>>::new(&fading);
    for sample in stream(1, 1000, 0.0, 0.01) {
        estimator.step(&Sample { y: sample.y, u1: 2.0, u2: 3.0 });
    }
    assert_eq!((estimator.rows(), estimator.close()), (0, Err(Reason::AtRest)));
    let segments = Regression { memory: Memory::Segment, ..fading };
    let mut estimator = Estimator::<4, 6, 1>::new(&segments);
    for sample in stream(1, 1000, 0.0, 0.01) {
        estimator.step(&Sample { y: sample.y, u1: 2.0 + 1e-3 * sample.u1, u2: 3.0 });
    }
    assert_eq!(estimator.close(), Err(Reason::AtRest));
}

#[test]
fn estimates_of_other_segments_are_refused_and_errors_stay() {
    let regression = Regression { handover: 50, ..refined() };
    let data = stream(5, 6000, 0.0, 0.05);
    let mut estimator = Refined::new(&regression);
    let run = |estimator: &mut Refined<'_>, segment: usize| {
        data[2000 * segment..2000 * (segment + 1)].iter().for_each(|sample| estimator.step(sample));
    };
    run(&mut estimator, 0);
    let first = Solver::new(&regression, estimator.detach()).finish().expect("first");
    run(&mut estimator, 1);
    let second = Solver::new(&regression, estimator.detach()).finish().expect("second");
    assert!(!estimator.adopt(&first) && estimator.adopt(&second));

    let guard = Guard { stuck_samples: [3, 0, 0], ..regression.guard };
    let watching = Regression { guard, ..regression };
    let mut estimator = Refined::new(&watching);
    run(&mut estimator, 0);
    (0..5).for_each(|_| estimator.step(&Sample { y: 1.0, u1: 0.0, u2: 0.0 }));
    let mut solver = Solver::new(&watching, estimator.detach());
    assert_eq!(solver.advance(), Some(Err(Reason::Stuck(0))));
    assert_eq!(solver.finish(), Err(Reason::Stuck(0)));
}

#[test]
fn poisoned_sums_are_dropped_with_the_segment() {
    let memory = Memory::Fading(Forgetting { lambda: 0.999, floor: 1e-3 });
    let fading = Regression { memory, still: 1e-9, ..least::<6>(false) };
    let mut estimator = Estimator::<6, 15, 2, Regressor<6, 2>, Fading<6, 15>>::new(&fading);
    let data = stream(4, 6000, 0.01, 0.0);
    data[..2000].iter().for_each(|sample| estimator.step(sample));
    // `take` is for samples that have passed the gate; this one has not.
    estimator.take(&Sample { y: f32::NAN, u1: 0.0, u2: 0.0 });
    assert!(estimator.close().is_err());
    estimator.skip();
    data[2000..].iter().for_each(|sample| estimator.step(sample));
    assert!(estimator.close().is_ok());
}

#[test]
fn types_that_do_not_fit_give_no_rows() {
    let data = stream(6, 2000, 0.01, 0.0);
    let fading = Regression { memory: Memory::Fading(Forgetting { lambda: 0.999, floor: 1e-3 }), ..least::<8>(false) };
    let squares = least::<8>(false);
    let instruments = refined();
    let mut wrong_rows = Refined::new(&squares);
    let mut short_delays = Estimator::<8, 28, 1, Instruments<8, 1>>::new(&instruments);
    let mut wrong_memory = Estimator::<8, 28, 2>::new(&fading);
    for sample in &data {
        wrong_rows.step(sample);
        short_delays.step(sample);
        wrong_memory.step(sample);
    }
    assert_eq!((wrong_rows.rows(), short_delays.rows(), wrong_memory.rows()), (0, 0, 0));
    let narrow =
        Regression::<11> { order: Order::new(4, 1, 1, 1, 1), ..Regression::new(Order::new(1, 1, 1, 1, 1), false) };
    let narrow = Regression { method: Method::Instruments, ..narrow };
    assert_eq!((narrow.columns(), narrow.capacity()), (11, 12), "filters need more cells than the row has columns");
}
