use super::*;
use crate::plan::{Cells, Memory, Method, RunTime, RunTimeSample, Structure, testing};
use crate::reason::Part;
use crate::regression::factor::Forgetting;
use std::vec;
use std::vec::Vec;

fn plan() -> RunTime {
    let structure = Structure::new(2, 1, 1, 1, 1).with_offset();
    RunTime::of(testing::regression(structure, Method::LeastSquares, Memory::Segment)).unwrap()
}

fn constants() -> Regression<RunTime> {
    Regression { scale: vec![1.0, 4.0, 1.0, 0.5, 1.0, 2.0], ..Regression::new(plan()) }
}

fn channels() -> Vec<Channel> {
    ["y", "u1", "u2"].map(|name| Channel::within(name, "", 1e3)).to_vec()
}

fn step(stream: &mut RecursiveEstimator<'_, RunTime>, y: f32, u1: f32, u2: f32) {
    stream.step(&RunTimeSample { values: vec![y, u1, u2], ..RunTimeSample::default() });
}

/// y = 1.2 y₁ − 0.4 y₂ + 0.5 u1₁ − 0.25 u2₁ + 0.1 with two square waves.
fn feed(stream: &mut RecursiveEstimator<'_, RunTime>, count: u32) {
    let [mut y1, mut y2, mut u1, mut u2] = [0.0_f32; 4];
    for t in 0..count {
        let y = 1.2 * y1 - 0.4 * y2 + 0.5 * u1 - 0.25 * u2 + 0.1;
        u1 = if t % 7 < 3 { 1.0 } else { -1.0 };
        u2 = if t % 11 < 5 { 2.0 } else { 0.0 };
        step(stream, y, u1, u2);
        (y2, y1) = (y1, y);
    }
}

#[test]
fn exact_data_give_the_exact_model() {
    let (channels, constants) = (channels(), constants());
    let mut stream = RecursiveEstimator::new(plan(), &channels, &constants);
    feed(&mut stream, 300);
    let estimate = stream.estimate();
    let expected = [-1.2, 0.4, 0.5, -0.25, 0.1];
    for (got, want) in estimate.raw().into_iter().zip(expected) {
        // A few hundred roundings of f32.
        assert!((got - want).abs() < 2e-5, "{got} {want}");
    }
    assert_eq!((estimate.rows, estimate.delta().len(), estimate.reason), (298, 5, None));
    assert!(estimate.variance < 1e-9 && (0..5).all(|i| estimate.covariance(i, i) > 0.0));
}

#[test]
fn few_rows_constant_signals_and_nan_are_reasons() {
    let (channels, constants) = (channels(), constants());
    let mut stream = RecursiveEstimator::new(plan(), &channels, &constants);
    let few = |rows| Some(Reason::TooFewRows { part: Part::Regression, rows });
    assert_eq!(stream.estimate().reason, few(0));
    feed(&mut stream, 7); // 5 rows for 5 parameters
    assert_eq!(stream.estimate().reason, few(5));
    stream.restart();
    (0..100).for_each(|_| step(&mut stream, 1.0, 2.0, 3.0));
    assert_eq!(stream.estimate().reason, Some(Reason::ParameterNotExcited(0)));
    stream.restart();
    (0..10).for_each(|_| step(&mut stream, f32::NAN, 0.0, 0.0));
    assert_eq!(stream.counts().rejected, 10);
    feed(&mut stream, 300);
    assert_eq!(stream.estimate().rows, 298, "back to work after the burst");
}

/// u2 = c·u1, whatever c, initial value and length of the memory: nothing tells their parameters apart.
#[test]
fn dependent_inputs_have_no_estimate_by_any_memory() {
    for (memory, lambda, rows) in
        [(Memory::Segment, 1.0, 5000), (Memory::Fading, 0.99, 5000), (Memory::Fading, 0.999, 20_000)]
    {
        let structure = Structure::new(1, 1, 1, 1, 1);
        let plan = RunTime::of(testing::regression(structure, Method::LeastSquares, memory)).unwrap();
        let (channels, mut regression) = (channels(), Regression::new(plan));
        (regression.forgetting, regression.rest) = (Forgetting { lambda, floor: 0.01 / (1.0 - lambda + 1e-9) }, 1e-4);
        for c in [1.0_f32, -0.7, 3.3, 1e-2] {
            let mut stream = RecursiveEstimator::new(plan, &channels, &regression);
            let mut reasons = Vec::new();
            let (mut y, mut state) = (0.3_f32, 7_u32);
            for t in 1..=rows {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let u = (state >> 8) as f32 / 8_388_608.0 - 1.0;
                step(&mut stream, y, u, c * u);
                y = 0.8 * y + 0.5 * u + 0.1 * c * u;
                if t % (rows / 10) == 0 {
                    reasons.push(stream.estimate().reason);
                }
            }
            assert_eq!(reasons, [Some(Reason::ParameterNotExcited(2)); 10], "{memory:?} {lambda} {c}");
            // Inputs that become independent are known after a memory of them; a segment that has both too.
            for t in 0..rows {
                let (u1, u2) = (if t % 7 < 3 { 1.0 } else { -1.0 }, if t % 11 < 5 { 1.0 } else { -1.0 });
                step(&mut stream, y, u1, u2);
                y = 0.8 * y + 0.5 * u1 + 0.1 * u2;
            }
            let estimate = stream.estimate();
            assert_eq!(estimate.reason, None, "{memory:?} {lambda} {c}");
            // The segment has roundings of u2 − c u1 in its first half, fading memory a part of its old rows.
            assert!((estimate.delta()[2] - 0.1).abs() < 1e-3, "{memory:?} {lambda} {c}: {estimate:?}");
        }
    }
}

#[test]
fn next_segment_keeps_the_lags() {
    let (channels, constants) = (channels(), constants());
    let mut stream = RecursiveEstimator::new(plan(), &channels, &constants);
    feed(&mut stream, 50);
    stream.next_segment();
    feed(&mut stream, 50);
    assert_eq!(stream.rows(), 50);
    stream.restart();
    feed(&mut stream, 50);
    assert_eq!(stream.rows(), 48);
}

#[test]
fn a_level_far_from_zero_costs_no_digits() {
    let (channels, constants) = (channels(), constants());
    // The model of `feed`, seen from an operating point of y + 900, u1 + 500, u2 − 300.
    let run = |shift: [f32; 3]| {
        let mut stream = RecursiveEstimator::new(plan(), &channels, &constants);
        let [mut y1, mut y2, mut u1, mut u2] = [0.0_f32; 4];
        for t in 0..2000_u32 {
            let noise = if t % 5 < 2 { 0.015_625 } else { -0.015_625 };
            let y = 1.25 * y1 - 0.5 * y2 + 0.5 * u1 - 0.25 * u2 + noise;
            (u1, u2) = (if t % 7 < 3 { 1.0 } else { -1.0 }, if t % 11 < 5 { 2.0 } else { 0.0 });
            step(&mut stream, y + shift[0], u1 + shift[1], u2 + shift[2]);
            (y2, y1) = (y1, y);
        }
        stream.estimate()
    };
    let (near, far) = (run([0.0; 3]), run([900.0, 500.0, -300.0]));
    for k in 0..4 {
        let sd = near.deviation(k);
        // Samples near 900 carry 6e-5 each, a two-hundredth of the noise.
        let (a, b) = (near.delta()[k], far.delta()[k]);
        assert!((a - b).abs() < 0.1 * sd, "{k}: {a} {b}");
        assert!((far.deviation(k) / sd - 1.0).abs() < 0.01);
    }
    // k = k₀ − t₀ y₀ − β₀ u1₀ − γ₀ u2₀ of the shifted signals.
    let g = [-900.0, 0.0, -500.0, 300.0, 1.0];
    let expected: f32 = near.delta().iter().zip(g).map(|(delta, g)| delta * g).sum();
    let sd = far.deviation(4);
    assert!((far.delta()[4] - expected).abs() < 0.1 * sd, "{} {expected} {sd}", far.delta()[4]);
    let mut variance = 0.0;
    for (i, gi) in g.iter().enumerate() {
        variance += g.iter().enumerate().map(|(j, gj)| gi * gj * near.covariance(i, j)).sum::<f32>();
    }
    assert!((sd / variance.sqrt() - 1.0).abs() < 0.01, "{sd} {variance}");
}

const HANDOVER: u16 = 50;
/// y = 1.5 y₁ − 0.56 y₂ + 0.04 u₁ + 0.02 u₂ − 0.1 w₂: poles 0.8 and 0.7. t = [−0.06, 0.56], β = [0.06, −0.02].
const TRUTH: [f32; 5] = [-0.06, 0.56, 0.06, -0.02, -0.1];

fn refined(offset: bool) -> RunTime {
    let structure = Structure { offset, ..Structure::new(2, 2, 1, 1, 2) };
    RunTime::of(testing::regression(structure, Method::Instruments, Memory::Segment)).unwrap()
}

fn start(plan: RunTime, factor: f32) -> Regression<RunTime> {
    let mut constants = Regression::new(plan);
    constants.nominal.cells_mut().iter_mut().zip(TRUTH).for_each(|(cell, truth)| *cell = factor * truth);
    constants
}

/// Two inputs held for a few samples, and the output with white noise of that deviation.
fn samples(count: u32, noise: f32, level: [f32; 3]) -> impl Iterator<Item = [f32; 3]> {
    let mut state = 7_u32;
    let mut uniform = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from((state >> 16) as i16) / 32_768.0
    };
    let [mut y1, mut y2, mut u1, mut u2, mut w1, mut w2] = [0.0_f32; 6];
    let (mut u, mut w) = (0.0, 0.0);
    (0..count).map(move |t| {
        let y = 1.5 * y1 - 0.56 * y2 + 0.04 * u1 + 0.02 * u2 - 0.1 * w2;
        u = if t % 5 == 0 { uniform() } else { u };
        w = if t % 3 == 0 { uniform() } else { w };
        (y2, y1, u2, u1, w2, w1) = (y1, y, u1, u, w1, w);
        let e = noise * (uniform() + uniform() + uniform()); // deviation 1 of three uniforms
        [y + e + level[0], u + level[1], w + level[2]]
    })
}

#[test]
fn instruments_give_the_exact_model_from_a_wrong_start() {
    let (channels, constants) = (channels(), start(refined(false), 0.7));
    let mut stream = RecursiveEstimator::new(refined(false), &channels, &constants);
    samples(2000, 0.0, [0.0; 3]).for_each(|[y, u1, u2]| step(&mut stream, y, u1, u2));
    let estimate = stream.close();
    assert_eq!(estimate.rows, 2000 - 3 - 100, "delays, start, settling");
    for (got, want) in estimate.delta().iter().zip(TRUTH) {
        assert!((got - want).abs() < 2e-5, "{got} {want}"); // a few hundred roundings
    }
}

#[test]
fn noise_biases_least_squares_and_not_instruments() {
    let squares = testing::regression(Structure::new(2, 2, 1, 1, 2), Method::LeastSquares, Memory::Segment);
    let squares = RunTime::of(squares).unwrap();
    let (channels, by_iv, by_ls) = (channels(), start(refined(false), 1.2), start(squares, 1.2));
    let mut instruments = RecursiveEstimator::new(refined(false), &channels, &by_iv);
    let mut least = RecursiveEstimator::new(squares, &channels, &by_ls);
    for [y, u1, u2] in samples(60_000, 0.05, [0.0; 3]) {
        step(&mut instruments, y, u1, u2);
        step(&mut least, y, u1, u2);
        if instruments.rows() == 20_000 {
            instruments.close();
        }
    }
    let (iv, ls) = (instruments.close(), least.close());
    for (k, truth) in TRUTH.iter().enumerate() {
        let sd = iv.deviation(k);
        assert!((iv.delta()[k] - truth).abs() < 4.0 * sd, "{k}: {} {truth} {sd}", iv.delta()[k]);
        assert!(sd < 0.03 * truth.abs() + 1e-3, "{k}: {sd}");
    }
    assert!((iv.variance.sqrt() / 0.05 - 1.0).abs() < 0.02, "{}", iv.variance.sqrt());
    assert!((ls.delta()[0] - TRUTH[0]).abs() > 10.0 * iv.deviation(0), "{}", ls.delta()[0]);
}

#[test]
fn an_operating_point_moves_the_constant_only() {
    let (channels, near, far) = (channels(), start(refined(false), 0.9), start(refined(true), 0.9));
    let mut plain = RecursiveEstimator::new(refined(false), &channels, &near);
    let mut lifted = RecursiveEstimator::new(refined(true), &channels, &far);
    let mut last = None;
    for segment in 0..3 {
        let range = samples(9000, 0.01, [0.0; 3]).skip(3000 * segment).take(3000);
        range.for_each(|[y, u1, u2]| step(&mut plain, y, u1, u2));
        let range = samples(9000, 0.01, [500.0, 300.0, -200.0]).skip(3000 * segment).take(3000);
        range.for_each(|[y, u1, u2]| step(&mut lifted, y, u1, u2));
        last = Some((plain.close(), lifted.close()));
    }
    let (plain, lifted) = last.unwrap();
    let delta = lifted.delta();
    for (k, (lifted, plain_delta)) in delta.iter().zip(plain.delta()).enumerate().take(5) {
        let sd = plain.deviation(k);
        // Samples near 500 carry 3e-5 each, the noise is 0.01; the constant costs the estimate one degree.
        assert!((lifted - plain_delta).abs() < 0.3 * sd, "{k}: {lifted} {plain_delta}");
    }
    let expected = -delta[0] * 500.0 - delta[2] * 300.0 + delta[4] * 200.0;
    assert!((delta[5] - expected).abs() < 0.5 * lifted.deviation(5), "{} {expected}", delta[5]);
}

/// Five segments of noisy data: closed on the spot, detached and solved whole, and in steps between samples.
#[test]
fn a_deferred_solve_gives_the_same_bits() {
    let (channels, mut constants) = (channels(), start(refined(false), 1.2));
    (constants.handover, constants.settle) = (300, 100);
    let mut inline = RecursiveEstimator::new(refined(false), &channels, &constants);
    let (mut whole, mut steps) = (inline.clone(), inline.clone());
    let (mut segment, mut solver) = (None, None::<ClosedSegment<RunTime>>);
    let mut taken_over = 0;
    for (t, [y, u1, u2]) in samples(10_000, 0.05, [0.0; 3]).enumerate() {
        for stream in [&mut inline, &mut whole, &mut steps] {
            step(stream, y, u1, u2);
        }
        if t % 2000 == 30 {
            let solved = segment.take().map(|closed: ClosedSegment<_>| closed.finish(&constants));
            taken_over += u32::from(solved.is_some_and(|estimate| whole.adopt(&estimate)));
        }
        if let Some(estimate) = solver.as_mut().and_then(|solver| solver.advance(&constants)) {
            assert!(steps.adopt(estimate));
            solver = None;
        }
        if t % 2000 == 1999 {
            let estimate = inline.close();
            segment = Some(whole.detach());
            solver = Some(steps.detach());
            let other = segment.clone().unwrap().finish(&constants);
            assert_eq!(estimate, other, "segment ending at {t}");
        }
    }
    assert_eq!((taken_over, inline.rows()), (4, 0));
    assert_eq!(whole, steps);
}

#[test]
fn a_late_estimate_is_refused_and_three_missing_ones_bring_the_nominal_model_back() {
    let (channels, mut constants) = (channels(), start(refined(false), 1.2));
    constants.handover = HANDOVER;
    let mut stream = RecursiveEstimator::new(refined(false), &channels, &constants);
    let mut all = samples(20_000, 0.05, [0.0; 3]);
    let mut run = |stream: &mut RecursiveEstimator<'_, RunTime>, count: usize| {
        all.by_ref().take(count).for_each(|[y, u1, u2]| step(stream, y, u1, u2));
    };
    let base = |stream: &RecursiveEstimator<'_, RunTime>| stream.segment().sums.base().to_vec();
    run(&mut stream, 2000);
    let first = stream.close();
    run(&mut stream, 2000);
    let second = stream.detach().finish(&constants);
    run(&mut stream, usize::from(HANDOVER));
    assert!(!stream.adopt(&second), "one sample too late");
    assert_eq!(stream.counts().refused, 1);
    assert_eq!(base(&stream), first.delta(), "the first model stays");
    for refused in [1, 2] {
        run(&mut stream, 2000);
        assert_eq!(stream.counts().refused, refused);
        let _lost = stream.detach();
    }
    run(&mut stream, 2000);
    assert_eq!(base(&stream), constants.nominal);
}

#[test]
fn sums_go_on_in_another_place_as_in_their_own() {
    for memory in [Memory::Segment, Memory::Fading] {
        let structure = Structure::new(2, 1, 1, 1, 1).with_offset();
        let plan = RunTime::of(testing::regression(structure, Method::LeastSquares, memory)).unwrap();
        let constants = Regression { scale: constants().scale, ..Regression::new(plan) };
        let channels = channels();
        let mut stream = RecursiveEstimator::new(plan, &channels, &constants);
        feed(&mut stream, 700);
        let mut other = RegressionSums::new(plan);
        other.follow(plan, &stream.sums);
        let filled = stream.sums.clone();
        stream.next_segment();
        assert_eq!(other, stream.sums, "{memory:?}");
        assert!(filled != other);
        stream.sums.clear();
        assert_eq!(stream.sums, RegressionSums::new(plan), "{memory:?}");
    }
}
