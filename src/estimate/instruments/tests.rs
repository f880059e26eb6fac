use super::*;
use crate::estimate::{Estimator, Guard, Nominal, Solver};

/// y = 1.5 y₁ − 0.56 y₂ + 0.04 u₁ + 0.02 u₂ − 0.1 w₁: poles 0.8 and 0.7. t = [−0.06, 0.56], β = [0.06, −0.02].
const TRUTH: [f32; 5] = [-0.06, 0.56, 0.06, -0.02, -0.1];

fn regression(start: f32) -> Regression<8> {
    Regression {
        method: Method::Instruments,
        nominal: Nominal { delta: core::array::from_fn(|k| start * TRUTH.get(k).unwrap_or(&0.0)), deviation: 0.0 },
        guard: Guard::within([100.0; 3]),
        ..Regression::new(Order::new(2, 2, 1, 1, 2), false)
    }
}

/// Two inputs held for a few samples, and the output with white noise of that deviation.
fn samples(count: u32, noise: f32, level: [f32; 3]) -> impl Iterator<Item = Sample> {
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
        Sample { y: y + e + level[0], u1: u + level[1], u2: w + level[2] }
    })
}

#[test]
fn exact_data_give_the_exact_model_from_a_wrong_start() {
    let regression = regression(0.7);
    let mut estimator = Estimator::<8, 28, 2, Instruments<8, 2>>::new(&regression);
    samples(2000, 0.0, [0.0; 3]).for_each(|sample| estimator.step(&sample));
    let estimate = estimator.close().unwrap();
    assert_eq!(estimate.rows, 2000 - 3 - 100, "delays, start, settling");
    for (got, want) in estimate.delta.iter().zip(TRUTH) {
        assert!((got - want).abs() < 2e-5, "{got} {want}"); // a few hundred roundings
    }
}

#[test]
fn noise_biases_least_squares_and_not_instruments() {
    let start = regression(1.2);
    let plain = Regression { method: Method::LeastSquares, ..start };
    let mut by_rows = Estimator::<8, 28, 2, Instruments<8, 2>>::new(&start);
    let mut by_squares = Estimator::<8, 28, 2>::new(&plain);
    for sample in samples(60_000, 0.05, [0.0; 3]) {
        by_rows.step(&sample);
        by_squares.step(&sample);
        if by_rows.rows() == 20_000 {
            by_rows.close().unwrap();
        }
    }
    let (iv, ls) = (by_rows.close().unwrap(), by_squares.close().unwrap());
    for (k, truth) in TRUTH.iter().enumerate() {
        let sd = iv.covariance_matrix()[(k, k)].sqrt();
        assert!((iv.delta[k] - truth).abs() < 4.0 * sd, "{k}: {} {truth} {sd}", iv.delta[k]);
        assert!(sd < 0.03 * truth.abs() + 1e-3, "{k}: {sd}");
    }
    assert!((iv.variance.sqrt() / 0.05 - 1.0).abs() < 0.02, "{}", iv.variance.sqrt());
    let sd = iv.covariance_matrix()[(0, 0)].sqrt();
    assert!((ls.delta[0] - TRUTH[0]).abs() > 10.0 * sd, "{} {sd}", ls.delta[0]);
}

#[test]
fn an_operating_point_moves_the_constant_only() {
    const FAR: Regression<9> = Regression {
        method: Method::Instruments,
        nominal: Nominal { delta: [-0.05, 0.5, 0.05, -0.02, -0.1, 0.0, 0.0, 0.0, 0.0], deviation: 0.0 },
        ..Regression::new(Order::new(2, 2, 1, 1, 2), true)
    };
    let near = regression(0.9);
    let mut plain = Estimator::<8, 28, 2, Instruments<8, 2>>::new(&near);
    let mut lifted = Estimator::<9, 36, 2, Instruments<9, 2>>::new(&FAR);
    let mut last = None;
    for segment in 0..3 {
        let range = samples(9000, 0.01, [0.0; 3]).skip(3000 * segment).take(3000);
        range.for_each(|sample| plain.step(&sample));
        let range = samples(9000, 0.01, [500.0, 300.0, -200.0]).skip(3000 * segment).take(3000);
        range.for_each(|sample| lifted.step(&sample));
        last = Some((plain.close().unwrap(), lifted.close().unwrap()));
    }
    let (plain, lifted) = last.unwrap();
    for k in 0..5 {
        let sd = plain.covariance_matrix()[(k, k)].sqrt();
        // Samples near 500 carry 3e-5 each, the noise is 0.01; the constant costs the estimate one degree.
        assert!((lifted.delta[k] - plain.delta[k]).abs() < 0.3 * sd, "{k}: {} {}", lifted.delta[k], plain.delta[k]);
    }
    let expected = -lifted.delta[0] * 500.0 - lifted.delta[2] * 300.0 + lifted.delta[4] * 200.0;
    let sd = lifted.covariance_matrix()[(5, 5)].sqrt();
    assert!((lifted.delta[5] - expected).abs() < 0.5 * sd, "{} {expected} {sd}", lifted.delta[5]);
}

#[test]
fn a_bad_sample_restarts_the_filters() {
    let regression = regression(1.0);
    let mut rows = Instruments::<8, 2>::new(&regression);
    let mut given = 0;
    for (t, sample) in samples(500, 0.0, [0.0; 3]).enumerate() {
        if t == 250 {
            rows.flush(&regression);
        }
        given += usize::from(rows.push(&regression, &sample).is_some());
    }
    assert_eq!(given, 500 - 2 * 103);
}

#[test]
fn a_regression_that_does_not_fit_gives_no_rows() {
    let wide = Regression { order: Order::new(2, 2, 2, 1, 1), ..regression(1.0) };
    let plain = Regression { method: Method::LeastSquares, ..regression(1.0) };
    for wrong in [wide, plain] {
        assert!(!Instruments::<8, 2>::fits(&wrong));
    }
    assert!(!Instruments::<8, 1>::fits(&regression(1.0)), "delays");
}

const HANDOVER: u16 = 50;

/// Five segments of noisy data: closed on the spot, detached and solved whole, and by pieces between samples.
#[test]
fn a_deferred_solve_gives_the_same_bits() {
    let regression = Regression { handover: HANDOVER, ..regression(1.2) };
    type Refined<'m> = Estimator<'m, 8, 28, 2, Instruments<8, 2>>;
    let mut inline = Refined::new(&regression);
    let (mut whole, mut pieces) = (inline.clone(), inline.clone());
    let (mut segment, mut solver) = (None, None);
    let mut taken_over = 0;
    for (t, sample) in samples(10_000, 0.05, [0.0; 3]).enumerate() {
        for estimator in [&mut inline, &mut whole, &mut pieces] {
            estimator.step(&sample);
        }
        if t % 2000 == 30 {
            // The last moment is HANDOVER samples after the close.
            let solved = segment.take().map(|closed| Solver::new(&regression, closed).finish().unwrap());
            taken_over += u32::from(solved.is_some_and(|estimate| whole.adopt(&estimate)));
        }
        if let Some(Ok(estimate)) = solver.as_mut().and_then(Solver::advance) {
            assert!(pieces.adopt(&estimate));
            solver = None;
        }
        if t % 2000 == 1999 {
            let estimate = inline.close().unwrap();
            segment = Some(whole.detach());
            solver = Some(Solver::new(&regression, pieces.detach()));
            let other = Solver::new(&regression, segment.clone().unwrap()).finish().unwrap();
            assert_eq!(estimate, other, "segment ending at {t}");
        }
    }
    assert_eq!((taken_over, inline.rows()), (4, 0));
    assert_eq!(whole, pieces);
}

#[test]
fn a_late_estimate_is_refused_and_three_missing_ones_bring_the_nominal_model_back() {
    let regression = Regression { handover: HANDOVER, ..regression(1.2) };
    let mut estimator = Estimator::<8, 28, 2, Instruments<8, 2>>::new(&regression);
    let mut stream = samples(20_000, 0.05, [0.0; 3]);
    let mut run = |estimator: &mut Estimator<'_, 8, 28, 2, Instruments<8, 2>>, count: usize| {
        stream.by_ref().take(count).for_each(|sample| estimator.step(&sample));
    };
    run(&mut estimator, 2000);
    let first = estimator.close().unwrap();
    run(&mut estimator, 2000);
    let second = Solver::new(&regression, estimator.detach()).finish().unwrap();
    run(&mut estimator, usize::from(HANDOVER));
    assert!(!estimator.adopt(&second), "one sample too late");
    assert_eq!(estimator.counts().refused, 1);
    let base = estimator.source().base(&regression);
    assert_eq!(base[..5], first.delta[..5], "the first model stays");
    for refused in [1, 2] {
        run(&mut estimator, 2000);
        assert_eq!(estimator.counts().refused, refused);
        let _lost = estimator.detach();
    }
    run(&mut estimator, 2000);
    assert_eq!(estimator.source().base(&regression)[..5], regression.nominal.delta[..5]);
}

#[test]
fn an_exploding_simulation_starts_anew() {
    // Stable, but the gain of u1 is absurd: the simulated output leaves every bound.
    let mut wild = regression(1.0);
    wild.nominal.delta = [-0.06, 0.56, 1e30, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut rows = Instruments::<8, 2>::new(&wild);
    for sample in samples(2000, 0.0, [0.0; 3]) {
        let row = rows.push(&wild, &sample);
        assert!(row.is_none_or(|row| row.cells.iter().all(|x| x.abs() < 1e5)));
        assert!(rows.cells.iter().all(|x| x.is_finite()));
    }
}
