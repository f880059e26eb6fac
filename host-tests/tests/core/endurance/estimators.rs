//! Nothing wears out: fading least squares over 1e9 samples and refined instrumental variables over 1e5 segments,
//! against double precision running beside, at ten checkpoints. The usual run makes a hundredth of it; `cargo xtask
//! long` makes all, and its table is kept in docs/endurance.md.

use bearing_watch::plan::Structure;
use host_tests::Inputs;
use host_tests::oracle::{self, Course, Record};
use host_tests::plants::{Mode, PLANTS, Plant};
use host_tests::streams::{fading, least_squares, outcome, refined, worst};
use nalgebra::{DMatrix, DVector};
use std::collections::VecDeque;

const CHECKPOINTS: usize = 10;

/// No reading above its limit, none that only f64 could give, and the last half no worse than the first.
fn no_drift(what: &str, readings: &[f64], limit: f64) {
    let half = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (early, late) = readings.split_at(readings.len() / 2);
    assert!(readings.iter().all(|x| (1e-6..=limit).contains(x)), "{what}: {readings:?}");
    // The readings scatter by a factor of a few; their rms over five by less.
    assert!(half(late) <= 3.0 * half(early), "{what}: {readings:?}");
}

fn row(what: &str, step: &str, readings: &[f64]) {
    let cells: Vec<_> = readings.iter().map(|x| format!("{x:.1e}")).collect();
    println!("| {what} | {step} | {} |", cells.join(" | "));
}

/// XᵀX and Xᵀy that fade, of scaled rows.
struct Normal {
    sums: DMatrix<f64>,
    lambda: f64,
}

impl Normal {
    fn update(&mut self, row: &[f32]) {
        // Only the upper triangle.
        for (j, xj) in row.iter().enumerate() {
            for (i, xi) in row.iter().enumerate().take(j + 1) {
                let cell = &mut self.sums[(i, j)];
                *cell = *cell * self.lambda + f64::from(*xi) * f64::from(*xj);
            }
        }
    }

    /// √(Δᵀ XᵀX Δ / (n σ²)) of scaled parameters.
    fn rho(&self, theta: &[f32]) -> f64 {
        let n = self.sums.ncols() - 1;
        let mut square = self.sums.clone();
        square.fill_lower_triangle_with_upper_triangle();
        let (gram, right) =
            (square.view((0, 0), (n, n)).into_owned(), square.view((0, n), (n, 1)).column(0).into_owned());
        let exact = gram.clone().cholesky().expect("positive definite").solve(&right);
        let variance = (square[(n, n)] - right.dot(&exact)) * (1.0 - self.lambda);
        let error = DVector::from_iterator(n, theta.iter().map(|x| f64::from(*x)).take(n)) - exact;
        (error.dot(&(gram * &error)) / n as f64 / variance).sqrt()
    }
}

/// The row of the newest of these samples: levels, differences and the target y − y₁, each with its scale. Differences
/// of single precision and powers of two are those of the core.
fn scaled_row(structure: Structure, scale: &[f32], newest_first: &VecDeque<Inputs>) -> Vec<f32> {
    let Structure { na, nb, nc, nkb, nkc, .. } = structure;
    let signals: [fn(&Inputs) -> f32; 3] = [|s| s.y, |s| s.u1, |s| s.u2];
    let columns = signals.into_iter().zip([(1, na), (nkb, nb), (nkc, nc)]).flat_map(|(of, (delay, terms))| {
        let at = move |k: u8| of(&newest_first[usize::from(delay + k)]);
        (0..terms).map(move |k| if k == 0 { at(0) } else { at(k - 1) - at(k) })
    });
    let target = newest_first[0].y - newest_first[1].y;
    columns.chain([target]).zip(scale).map(|(x, scale)| x * scale).collect()
}

/// λ = 0.9999 on the closed loops of `delta_form`: δ-form conditions 5 and 100.
fn fading_squares(samples: usize) {
    let two: &[Mode] = &[Mode::Lag(0.05), Mode::Lag(0.003)];
    let three: &[Mode] = &[Mode::Lag(0.05), Mode::Lag(0.003), Mode::Lag(0.001)];
    let (short, long): (&[f64], &[f64]) = (&[0.6, 0.4], &[0.5, 0.3, 0.2]);
    for (name, modes, taps, colour_s, smooth) in
        [("mid", two, short, [0.03, 0.02], false), ("bad", three, long, [0.04, 0.04], true)]
    {
        let plant = Plant { modes, b: (taps, 1.0), c: (taps, -0.8), colour_s, smooth, ..PLANTS[9].clone() };
        let mut source = plant.source(0.0, 21).disturbed(1e-4);
        let start: Vec<Inputs> = source.clone().take(100_000).collect();
        let structure = plant.structure();
        let setup = fading(&least_squares(structure, &start), 1e-9);
        let (mut stream, scale) = (setup.stream(300_007), &setup.constants.scale);
        let lambda = f64::from(setup.constants.forgetting.lambda);
        let mut normal = Normal { sums: DMatrix::zeros(scale.len(), scale.len()), lambda };
        let (mut history, mut readings) = (VecDeque::new(), vec![]);
        for _ in 0..CHECKPOINTS {
            for sample in source.by_ref().take(samples / CHECKPOINTS) {
                stream.step(&sample);
                history.push_front(sample);
                if history.len() > structure.depth() {
                    normal.update(&scaled_row(structure, scale, &history));
                    history.pop_back();
                }
            }
            let estimate = outcome(stream.open()).expect("an estimate");
            let theta = estimate.delta().iter().zip(scale).map(|(x, own)| x * scale[scale.len() - 1] / own);
            readings.push(normal.rho(&theta.collect::<Vec<f32>>()));
        }
        row(
            &format!("least squares, λ = 0.9999, {name}: ρ"),
            &format!("{:.0e} samples", (samples / CHECKPOINTS) as f64),
            &readings,
        );
        no_drift(name, &readings, 0.02);
    }
}

/// Refined instrumental variables: at each checkpoint the arithmetic error of a segment in σ, and the mean deviation
/// from the truth over all segments since the last one.
fn segments(count: usize) {
    const LENGTH: usize = 2_000;
    let plant = &PLANTS[4];
    let (structure, noise) = (plant.structure(), plant.noise(20.0));
    let mut source = plant.source(noise, 22);
    let start: Vec<Inputs> = source.clone().take(100_000).collect();
    let setup = refined(plant, &start);
    let mut stream = setup.stream(LENGTH);
    let truth = oracle::delta(structure, &plant.truth());
    let (mut readings, mut biases, mut refused) = (vec![], vec![], 0);
    for _ in 0..CHECKPOINTS {
        let block = count / CHECKPOINTS;
        // The last segments of a block are kept for the oracle, whose filters then start long before the one compared.
        let (mut tail, mut auxiliaries) = (vec![], vec![]);
        let (mut sum, mut deviations, mut used) = (0.0, 0.0, 0.0);
        for number in 0..block {
            let keep = number + 6 >= block;
            for sample in source.by_ref().take(LENGTH) {
                stream.step(&sample);
                if keep {
                    tail.push(sample);
                }
            }
            let Ok(estimate) = outcome(stream.closed()) else {
                refused += 1;
                continue;
            };
            if keep {
                auxiliaries.push((tail.len(), oracle::raw(structure, estimate.delta())));
            }
            let sd = f64::from(estimate.covariance(0, 0)).sqrt();
            sum += (f64::from(estimate.delta()[0]) - truth[0]) / sd;
            deviations += 1.0;
            used = f64::from(estimate.rows);
            if number + 1 == block {
                let (_, _) = auxiliaries.pop().expect("kept");
                auxiliaries[0].0 = 0;
                let course = Course { auxiliaries: auxiliaries.clone(), rest_on: None };
                let rows = tail.len() - estimate.rows as usize..tail.len();
                let exact = oracle::one_pass(&Record::new(&tail), structure, &course, rows).delta(structure);
                readings.push(worst(estimate.delta(), &exact));
            }
        }
        assert!(used > 1000.0);
        biases.push(sum / deviations);
    }
    let step = format!("{} segments of {LENGTH}", count / CHECKPOINTS);
    row("refined iv: f32 − f64, worst parameter in σ", &step, &readings);
    row("refined iv: mean deviation of t₀ from the truth in σ", &step, &biases);
    no_drift("refined", &readings, 0.05);
    // The mean of a block scatters by 1/√(its segments), a tenth of a hundred and a hundredth of ten thousand; the rest
    // is the bias of 2000 samples.
    let scatter = 4.0 / ((count / CHECKPOINTS) as f64).sqrt() + 0.05;
    assert!(biases.iter().all(|bias| bias.abs() < scatter), "{biases:?}");
    assert_eq!(refused, 0, "of {count} segments");
}

#[test]
fn fading_least_squares_short() {
    fading_squares(10_000_000);
}

#[test]
fn refined_segments_short() {
    segments(1_000);
}

#[test]
#[ignore = "1e9 samples: minutes"]
fn fading_least_squares_long() {
    fading_squares(1_000_000_000);
}

#[test]
#[ignore = "1e5 segments: minutes"]
fn refined_segments_long() {
    segments(100_000);
}
