//! One update of every rival on the same rows, and how near its parameters come to the truth.

use core::hint::black_box;

use bearing_watch::recursive::Triangle;
use bearing_watch::model::Forgetting;
use nalgebra::{SMatrix, SVector};
use oxictl::adaptive::Rls;
use oxictl::core::adaptive_filters::RlsFilter;

use crate::count::Counter;
use crate::numbers::Numbers;

pub const ROWS: usize = 200;
/// Forgetting factor of all.
const LAMBDA: f32 = 0.999;
/// Diagonal of the first P: a weak prior beside 200 rows of unit size.
const P0: f32 = 1e4;
/// Standard deviation of the noise, times √3.
const NOISE: f32 = 0.01;

/// A recursive least-squares estimator of `N` parameters; a row is `N` regressors and the target, `M` = N + 1.
pub trait Rival<const N: usize, const M: usize> {
    const NAME: &'static str;
    fn start() -> Self;
    fn update(&mut self, row: &[f32; M]);
    fn theta(&self) -> [f32; N];
}

/// Rows of y = θᵀx + noise.
pub fn rows<const N: usize, const M: usize>() -> [[f32; M]; ROWS] {
    let mut numbers = Numbers(1);
    core::array::from_fn(|_| {
        let mut row: [f32; M] = numbers.array();
        let y: f32 = row.iter().zip(truth::<N>()).map(|(x, theta)| x * theta).sum();
        row[N] = y + NOISE * numbers.draw();
        row
    })
}

fn truth<const N: usize>() -> [f32; N] {
    core::array::from_fn(|i| if i % 2 == 0 { 1.0 } else { -0.5 } / (1 + i / 2) as f32)
}

/// Counts one rival over all rows and prints its line; the error is what those same updates arrived at.
pub fn run<R: Rival<N, M>, const N: usize, const M: usize>(counter: &mut Counter, rows: &[[f32; M]; ROWS]) {
    let row = |k: u32| black_box(rows.get(k as usize));
    let source = counter.instructions_per_call(ROWS as u32, |k| {
        black_box(row(k));
    });
    let mut rival = R::start();
    let update = counter.instructions_per_call(ROWS as u32, |k| {
        if let Some(row) = row(k) {
            step(&mut rival, row);
        }
    });
    let off = rival.theta().into_iter().zip(truth::<N>()).map(|(theta, true_theta)| (theta - true_theta).abs());
    // Not `f32::max`, which would drop a NaN.
    let error = off.fold(0.0_f32, |most, e| if most.is_nan() || e <= most { most } else { e });
    let (who, instructions, bytes) = (R::NAME, update - source, size_of::<R>());
    say!(
        r#"{{"work":"RLS update, n = {N}","who":"{who}","instructions":{instructions},"bytes":{bytes},"error":"{error:.1e}"}}"#
    );
}

/// One call for every rival, whatever its language.
#[inline(never)]
fn step<R: Rival<N, M>, const N: usize, const M: usize>(rival: &mut R, row: &[f32; M]) {
    rival.update(row);
}

fn split<const N: usize, const M: usize>(row: &[f32; M]) -> (&[f32; N], f32) {
    const { assert!(M == N + 1) };
    match row.split_first_chunk() {
        Some((x, [y])) => (x, *y),
        _ => (&[0.0; N], 0.0),
    }
}

fn diagonal<const N: usize>() -> [[f32; N]; N] {
    core::array::from_fn(|i| core::array::from_fn(|j| if i == j { P0 } else { 0.0 }))
}

pub struct Ours<const M: usize, const P: usize>(Triangle<[f32; M], [f32; P]>, Forgetting);

/// The same, with θ read out after every row as the covariance forms do.
pub struct OursSolved<const N: usize, const M: usize, const P: usize>(Ours<M, P>, [f32; M]);

impl<const N: usize, const M: usize, const P: usize> Rival<N, M> for Ours<M, P> {
    const NAME: &'static str = "bearing-watch";

    fn start() -> Self {
        Self(Triangle::new(M), black_box(Forgetting { lambda: LAMBDA, floor: 1e-3 }))
    }

    fn update(&mut self, row: &[f32; M]) {
        self.0.update_forgetting(row, self.1);
    }

    fn theta(&self) -> [f32; N] {
        solve(&self.0).first_chunk().copied().unwrap_or([f32::NAN; N])
    }
}

impl<const N: usize, const M: usize, const P: usize> Rival<N, M> for OursSolved<N, M, P> {
    const NAME: &'static str = "bearing-watch, parameters solved for after every row";

    fn start() -> Self {
        Self(<Ours<M, P> as Rival<N, M>>::start(), [0.0; M])
    }

    fn update(&mut self, row: &[f32; M]) {
        <Ours<M, P> as Rival<N, M>>::update(&mut self.0, row);
        self.1 = solve(&self.0.0);
    }

    fn theta(&self) -> [f32; N] {
        self.1.first_chunk().copied().unwrap_or([f32::NAN; N])
    }
}

/// θ of R θ = r, in the first M − 1 cells.
fn solve<const M: usize, const P: usize>(triangle: &Triangle<[f32; M], [f32; P]>) -> [f32; M] {
    let (_, mut r) = triangle.parts();
    let mut theta = [0.0; M];
    for i in (0..M - 1).rev() {
        // The last row is the shortest: the target alone.
        let (above, row) = r.split_at(r.len() - (M - 1 - i));
        let (target, row) = row.split_last().expect("a row has its target");
        theta[i] = row.iter().zip(&theta[i + 1..]).fold(*target, |value, (r, theta)| value - r * theta);
        r = above;
    }
    theta
}

pub struct HandC<const N: usize> {
    p: [[f32; N]; N],
    theta: [f32; N],
}

pub struct Cmsis<const N: usize>(HandC<N>);

mod c {
    unsafe extern "C" {
        pub fn rls_8(p: *mut f32, theta: *mut f32, x: *const f32, y: f32, lambda: f32);
        pub fn rls_15(p: *mut f32, theta: *mut f32, x: *const f32, y: f32, lambda: f32);
        pub fn cmsis_rls(n: u32, p: *mut f32, theta: *mut f32, x: *const f32, y: f32, lambda: f32);
    }
}

impl<const N: usize, const M: usize> Rival<N, M> for HandC<N> {
    const NAME: &'static str = "C by hand, symmetric P";

    fn start() -> Self {
        const { assert!(N == 8 || N == 15) };
        Self { p: diagonal(), theta: [0.0; N] }
    }

    fn update(&mut self, row: &[f32; M]) {
        let (p, theta, (x, y)) = (self.p.as_mut_ptr().cast(), self.theta.as_mut_ptr(), split::<N, M>(row));
        // SAFETY: p has N² cells, theta and x have N, as the function of that size takes them.
        unsafe {
            if N == 8 {
                c::rls_8(p, theta, x.as_ptr(), y, LAMBDA);
            } else {
                c::rls_15(p, theta, x.as_ptr(), y, LAMBDA);
            }
        }
    }

    fn theta(&self) -> [f32; N] {
        self.theta
    }
}

impl<const N: usize, const M: usize> Rival<N, M> for Cmsis<N> {
    const NAME: &'static str = "CMSIS-DSP 1.10.3 matrix kernels";

    fn start() -> Self {
        const { assert!(N <= 15) };
        Self(HandC { p: diagonal(), theta: [0.0; N] })
    }

    fn update(&mut self, row: &[f32; M]) {
        let (x, y) = split::<N, M>(row);
        // SAFETY: p has N² cells, theta and x have N ≤ 15.
        unsafe {
            c::cmsis_rls(N as u32, self.0.p.as_mut_ptr().cast(), self.0.theta.as_mut_ptr(), x.as_ptr(), y, LAMBDA);
        }
    }

    fn theta(&self) -> [f32; N] {
        self.0.theta
    }
}

/// By operators; the rank-one change of P by the call that does it in place.
pub struct Nalgebra<const N: usize> {
    p: SMatrix<f32, N, N>,
    theta: SVector<f32, N>,
}

impl<const N: usize, const M: usize> Rival<N, M> for Nalgebra<N> {
    const NAME: &'static str = "nalgebra 0.35, static sizes";

    fn start() -> Self {
        Self { p: SMatrix::identity() * P0, theta: SVector::zeros() }
    }

    fn update(&mut self, row: &[f32; M]) {
        let (x, y) = split::<N, M>(row);
        let x = SVector::from_column_slice(x);
        let px = self.p * x;
        let gain = px * (1.0 / (LAMBDA + x.dot(&px)));
        self.theta += gain * (y - x.dot(&self.theta));
        self.p.ger(-1.0 / LAMBDA, &gain, &px, 1.0 / LAMBDA);
    }

    fn theta(&self) -> [f32; N] {
        self.theta.into()
    }
}

impl<const N: usize, const M: usize> Rival<N, M> for RlsFilter<f32, N> {
    const NAME: &'static str = "oxictl 0.1.1 RlsFilter";

    fn start() -> Self {
        Self::new(LAMBDA, P0).expect("valid settings")
    }

    fn update(&mut self, row: &[f32; M]) {
        let (x, y) = split::<N, M>(row);
        black_box(RlsFilter::update(self, x, y).is_ok());
    }

    fn theta(&self) -> [f32; N] {
        *self.weights()
    }
}

impl<const N: usize, const M: usize> Rival<N, M> for Rls<f32, N> {
    const NAME: &'static str = "oxictl 0.1.1 Rls";

    fn start() -> Self {
        Self::new(LAMBDA, P0)
    }

    fn update(&mut self, row: &[f32; M]) {
        let (x, y) = split::<N, M>(row);
        Rls::update(self, x, y);
    }

    fn theta(&self) -> [f32; N] {
        self.theta
    }
}
