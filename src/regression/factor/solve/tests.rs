use super::*;
use crate::regression::factor::{EffectiveRows, Triangle};

type Answer = Result<([f32; 2], [f32; 3], f32), SolveError>;

/// A problem whose factor is kept.
#[derive(Clone, Copy)]
struct Case<'a> {
    d: &'a [f32],
    r: &'a [f32],
    inputs: usize,
    outputs: usize,
    scale: &'a [f32],
    mass: EffectiveRows,
}

fn run(case: &Case<'_>) -> Answer {
    let Case { inputs, outputs, scale, mass, .. } = *case;
    let (d, r) = (&mut case.d.to_vec(), &mut case.r.to_vec());
    let problem = &mut Problem { d, r, inputs, outputs, scale, base: &[], mass, gain: 1.0 };
    let (mut delta, mut covariance, mut variance, mut work) = ([0.0; 2], [0.0; 3], 0.0, [0.0; 2]);
    let solved =
        &mut Solved { delta: &mut delta, covariance: &mut covariance, variance: &mut variance, work: &mut work };
    let mut solution = Solution::new::<true>(problem, solved)?;
    while !solution.add_column::<true>(problem, solved) {}
    Ok((delta, covariance, variance))
}

const fn problem<'a>(d: &'a [f32], r: &'a [f32], rows: f32) -> Case<'a> {
    Case { d, r, inputs: 2, outputs: 0, scale: &[1.0, 1.0, 1.0], mass: EffectiveRows { rows, spread: 1.0 } }
}

#[test]
fn two_parameters_by_hand() {
    // XᵀX = [2 1; 1 2], XᵀY = [3; 0] → θ = [2, −1], RSS = 9 − 6 = 3 over one degree of freedom, and the covariance
    // 3 [2 −1; −1 2]/3.
    let mut triangle = Triangle::<[f32; 3], [f32; 3]>::new(3);
    for row in [[1.0, 0.0, 3.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]] {
        triangle.update(&row);
    }
    let (d, r) = triangle.parts();
    let (theta, covariance, variance) = run(&problem(d, r, 3.0)).unwrap();
    let close = |x: f32, y: f32| (x - y).abs() < 1e-5; // roundings of numbers near three
    assert!(close(theta[0], 2.0) && close(theta[1], -1.0) && close(variance, 3.0), "{theta:?} {variance}");
    assert!(close(covariance[0], 2.0) && close(covariance[1], -1.0) && close(covariance[2], 2.0));
}

#[test]
fn scales_convert_parameters_and_covariance() {
    let mut triangle = Triangle::<[f32; 3], [f32; 3]>::new(3);
    for [a, b, y] in [[1.0, 0.0, 3.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]] {
        triangle.update(&[2.0 * a, 0.5 * b, 4.0 * y]);
    }
    let (d, r) = triangle.parts();
    let scaled = Case { scale: &[2.0, 0.5, 4.0], ..problem(d, r, 3.0) };
    let (theta, covariance, variance) = run(&scaled).unwrap();
    let close = |x: f32, y: f32| (x - y).abs() < 1e-5;
    assert!(close(theta[0], 2.0) && close(theta[1], -1.0) && close(variance, 3.0), "{theta:?} {variance}");
    assert!(close(covariance[0], 2.0) && close(covariance[1], -1.0) && close(covariance[2], 2.0));
}

#[test]
fn few_rows_and_dependent_columns_are_errors() {
    let mut triangle = Triangle::<[f32; 3], [f32; 3]>::new(3);
    assert_eq!(run(&problem(triangle.parts().0, triangle.parts().1, 9.0)), Err(SolveError::NotExcited(0)));
    for x in [1.0, -2.0, 0.5, 3.0] {
        triangle.update(&[x, 2.0 * x, x * x]);
    }
    let (d, r) = triangle.parts();
    assert_eq!(run(&problem(d, r, 4.0)), Err(SolveError::NotExcited(1)));
    assert_eq!(run(&problem(d, r, 2.0)), Err(SolveError::TooFewRows));
    assert_eq!(run(&problem(d, r, f32::NAN)), Err(SolveError::TooFewRows));
}

#[test]
fn instruments_by_hand() {
    // Columns [u | x̂ | y | target] with x̂ = z: θ of y and u from Zᵀ e = 0, here exactly target = 2 y − u.
    let rows = [[1.0, 0.5, 0.7], [-0.5, 1.0, 0.9], [0.25, -1.0, -1.2], [1.0, 1.0, 1.3], [-1.0, 0.5, 0.2]];
    let mut triangle = Triangle::<[f32; 4], [f32; 6]>::new(4);
    for [u, z, y] in rows {
        triangle.update(&[u, z, y, 2.0 * y - u]);
    }
    let (d, r) = triangle.parts();
    let instrumental = Case { inputs: 1, outputs: 1, ..problem(d, r, 50.0) };
    let (theta, _, variance) = run(&instrumental).unwrap();
    assert!((theta[0] - 2.0).abs() < 1e-5 && (theta[1] + 1.0).abs() < 1e-5 && variance < 1e-9, "{theta:?}");
    // An output that its instrument does not explain.
    let mut unrelated = Triangle::<[f32; 4], [f32; 6]>::new(4);
    for (k, [u, z, _]) in rows.into_iter().cycle().take(40).enumerate() {
        let y = if k % 2 == 0 { 1.0 } else { -1.0 };
        unrelated.update(&[u, z, y, y]);
    }
    let (d, r) = unrelated.parts();
    let weak = Case { d, r, mass: EffectiveRows { rows: 40.0, spread: 1.0 }, ..instrumental };
    assert_eq!(run(&weak), Err(SolveError::WeakInstruments));
}

#[test]
fn the_variance_with_instruments_is_that_of_all_rows() {
    let rows = [[1.0, 0.5, 0.7], [-0.5, 1.0, 0.9], [0.25, -1.0, -1.2], [1.0, 1.0, 1.3], [-1.0, 0.5, 0.2]];
    let errors = [0.3, -0.2, 0.4, -0.1, 0.25];
    let mut triangle = Triangle::<[f32; 4], [f32; 6]>::new(4);
    // Zᵀ X = [z·y z·u; u·y u·u] and Zᵀ t in double precision.
    let (mut zy, mut zu, mut uy, mut uu, mut zt, mut ut) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for ([u, z, y], e) in rows.into_iter().zip(errors) {
        let t = 2.0 * y - u + e;
        triangle.update(&[u as f32, z as f32, y as f32, t as f32]);
        (zy, zu, uy) = (zy + z * y, zu + z * u, uy + u * y);
        (uu, zt, ut) = (uu + u * u, zt + z * t, ut + u * t);
    }
    let determinant: f64 = zy * uu - zu * uy;
    let (a, b) = ((zt * uu - zu * ut) / determinant, (zy * ut - uy * zt) / determinant);
    let squares = rows.into_iter().zip(errors).map(|([u, _, y], e)| ((2.0 - a) * y - (1.0 + b) * u + e).powi(2));
    let (d, r) = triangle.parts();
    let (theta, _, variance) = run(&Case { inputs: 1, outputs: 1, ..problem(d, r, 50.0) }).unwrap();
    let expected = [a, b, squares.sum::<f64>() / 48.0];
    for (value, expected) in [theta[0], theta[1], variance].into_iter().zip(expected) {
        // Roundings of numbers near three.
        assert!((f64::from(value) - expected).abs() < 1e-5, "{theta:?} {variance}: {expected}");
    }
}

#[test]
fn instruments_are_judged_by_their_angle_and_not_by_their_size() {
    let solved = |size: f32, apart: f32| {
        let mut triangle = Triangle::<[f32; 5], [f32; 10]>::new(5);
        for k in 0..40_u8 {
            let (p, q) = (if k % 2 == 0 { 1.0 } else { -1.0 }, if k % 4 < 2 { 1.0 } else { -1.0 });
            let (p, q) = (size * p, size * (p + apart * q));
            triangle.update(&[p, q, p, q, 2.0 * p - q]);
        }
        let (d, r) = triangle.parts();
        run(&Case { inputs: 0, outputs: 2, ..problem(d, r, 40.0) }).map(|(theta, ..)| theta)
    };
    for size in [3e-4, 1.0, 3e3] {
        let theta = solved(size, 1.0).unwrap();
        // Roundings of numbers near three.
        assert!((theta[0] - 2.0).abs() < 1e-4 && (theta[1] + 1.0).abs() < 1e-4, "{size}: {theta:?}");
        assert!(solved(size, 1e-6).is_err(), "{size}: nearly the same instrument twice");
    }
}
