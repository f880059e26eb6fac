//! What a solve reads: the triangular factor R, D of the regression, wherever its elements lie, and the sums over it.
//!
//! By least squares it is the segment's own factor. By instrumental variables the segment's columns are
//! `[U | x̂ | y | target]`, and with T the rows of U and x̂ and the columns of U, y and target
//!
//! ```text
//! T = [ R_uu  R_uy  r_u ; 0  G  r_x ],   weights D        T θ = r  ⇔  (ZᵀX) θ = Zᵀ y                  (1)
//! ```
//!
//! The rows of G are rotated into a small triangle like any other rows; with it in their place T is triangular, and what
//! follows is least squares: Tᵀ D T = (XᵀZ)(ZᵀZ)⁻¹(ZᵀX).
//!
//! Each sum has a loop and straight-line code made by a macro, of the same operations in the same order. The latter
//! runs where the number of parameters is known when compiling; then places of elements are constants too.

use super::kernels::{self, packed};
use super::regression::MAX_OUTPUT_TERMS;
use super::rows::Shape;
use super::triangle::{DEPENDENT, NEVER, PRIOR};

/// det² G beside its row norms, below which instruments are weak: a determinant of 1e-5.
const WEAK: f32 = 1e-10;
/// F of a first stage below which instruments count as weak, by Staiger and Stock's rule. Rows that are prefiltered or
/// carry coloured noise are not independent, so that chance reaches it more often than the F distribution says.
const CHANCE: f32 = 10.0;

/// The rotated rows of G, target last.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Outputs {
    d: [f32; MAX_OUTPUT_TERMS + 1],
    r: [f32; MAX_OUTPUT_TERMS * (MAX_OUTPUT_TERMS + 1) / 2],
}

impl Outputs {
    pub(super) const NONE: Self = Self { d: [PRIOR; 5], r: [0.0; 10] };

    /// Rotates in the first `columns` of a row.
    #[inline(always)]
    fn rotate(&mut self, columns: usize, row: [f32; MAX_OUTPUT_TERMS + 1], weight: f32) {
        macro_rules! run {
            ($($m:literal)+) => {
                match columns {
                    $($m => {
                        let (d, r) = (self.d.first_chunk_mut::<$m>(), self.r.first_chunk_mut::<{ $m * ($m - 1) / 2 }>());
                        if let (Some(d), Some(r), Some(row)) = (d, r, row.first_chunk::<$m>()) {
                            kernels::rotate::<$m, { $m * ($m - 1) / 2 }, false>(d, r, row, weight, NEVER);
                        }
                    })+
                    _ => {}
                }
            };
        }
        run!(2 3 4 5);
    }
}

/// Where the elements lie.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Factor<'a> {
    pub(super) d: &'a [f32],
    pub(super) r: &'a [f32],
    /// Columns of the segment's factor.
    pub(super) columns: usize,
    /// Parameters of columns that are their own instruments.
    pub(super) inputs: usize,
    /// Parameters with an instrument of their own.
    pub(super) outputs: usize,
    pub(super) rotated: &'a Outputs,
    /// What the inverse is brought to units with: a scale for each place of the estimate (none is 1), and for all.
    pub(super) scale: &'a [f32],
    pub(super) common: f32,
}

impl Factor<'_> {
    #[inline(always)]
    const fn parameters(&self) -> usize {
        self.inputs + self.outputs
    }

    /// R(i, j) for i < j; column n is the target.
    #[inline(always)]
    fn element(&self, i: usize, j: usize) -> f32 {
        let cell = if i < self.inputs {
            // Between inputs and outputs lie the columns of the instruments.
            let column = if j < self.inputs { j } else { j + self.outputs };
            self.r.get(packed(self.columns, i, column))
        } else {
            self.rotated.r.get(packed(self.outputs + 1, i - self.inputs, j - self.inputs))
        };
        cell.copied().unwrap_or(0.0)
    }

    #[inline(always)]
    fn diagonal(&self, i: usize) -> f32 {
        let cell = if i < self.inputs { self.d.get(i) } else { self.rotated.d.get(i - self.inputs) };
        cell.copied().unwrap_or(PRIOR)
    }

    /// Place in the estimate of the parameter of column i: outputs come first.
    #[inline(always)]
    pub(super) const fn place(&self, i: usize) -> usize {
        if i < self.inputs { self.outputs + i } else { i - self.inputs }
    }

    /// The scale of the parameter of column i.
    #[inline(always)]
    fn scale_of(&self, i: usize) -> f32 {
        self.scale.get(self.place(i)).map_or(1.0, |scale| scale * self.common)
    }

    /// Adds to element (i, j) of the inverse, which is in the order of the estimate.
    #[inline(always)]
    fn add(&self, inverse: &mut [f32], (i, j): (usize, usize), value: f32) {
        let (i, j) = (self.place(i), self.place(j));
        if let Some(cell) = inverse.get_mut(if i >= j { lower(i, j) } else { lower(j, i) }) {
            *cell += value;
        }
    }

    /// Rotates the rows of G; gives them, and whether the instruments follow the output: det² G over the squares of its
    /// row norms is not too small (it is 1 for orthogonal rows), and of each output column they explain more than chance
    /// would, F > 10 over so many rows.
    #[inline(always)]
    pub(super) fn rotate_outputs(&self, rows: f32) -> (Outputs, bool) {
        let mut rotated = Outputs::NONE;
        let mut strength = 1.0;
        for i in 0..self.outputs {
            let element = |j: usize| {
                let place = packed(self.columns, self.inputs + i, self.parameters() + j);
                if j > self.outputs { 0.0 } else { self.r.get(place).copied().unwrap_or(0.0) }
            };
            let row = [element(0), element(1), element(2), element(3), element(4)];
            let norm = row.iter().take(self.outputs).fold(0.0, |sum, x| sum + x * x);
            let weight = self.d.get(self.inputs + i).copied().unwrap_or(PRIOR);
            strength /= weight * norm;
            rotated.rotate(self.outputs + 1, row, weight);
        }
        rotated.d.iter().take(self.outputs).for_each(|d| strength *= d);
        let n = self.parameters();
        let own = |i: usize| self.d.get(n + i).copied().unwrap_or(0.0);
        // Written so that NaN is weak.
        let mut strong = strength > WEAK;
        for j in 0..self.outputs {
            let unexplained = (0..j).fold(own(j), |sum, i| {
                let r = self.r.get(packed(self.columns, n + i, n + j)).copied().unwrap_or(0.0);
                sum + own(i) * r * r
            });
            let explained = rotated.d.get(j).copied().unwrap_or(0.0);
            strong &= explained * rows > CHANCE * unexplained && explained > 4.0 * PRIOR;
        }
        (rotated, strong)
    }

    /// Whether column j is, to rounding, no combination of the columns before it (nor zero), from Σ_{i<j} d(i) R(i, j)².
    #[inline(always)]
    fn excited(&self, j: usize, above: f32) -> bool {
        let own = self.diagonal(j);
        // Written so that NaN counts as dependent.
        own > DEPENDENT * above && own > 4.0 * PRIOR
    }

    /// The first column that depends on those before it.
    pub(super) fn dependent(&self) -> Option<usize> {
        (0..self.parameters()).find(|&j| {
            let above = (0..j).fold(0.0, |sum, i| sum + self.diagonal(i) * self.element(i, j) * self.element(i, j));
            !self.excited(j, above)
        })
    }

    /// θ of R θ = r(:, target).
    pub(super) fn solve(&self, theta: &mut [f32]) {
        let n = self.parameters();
        for i in (0..n).rev() {
            let mut value = self.element(i, n);
            for (j, later) in theta.iter().enumerate().take(n).skip(i + 1) {
                value -= self.element(i, j) * later;
            }
            if let Some(cell) = theta.get_mut(i) {
                *cell = value;
            }
        }
    }

    /// Σ d e² over all rows of the segment's factor, e being a row's residual under θ (in the order of columns).
    #[inline(always)]
    pub(super) fn residual_sum(&self, theta: &[f32]) -> f32 {
        let (columns, n) = (self.columns, self.parameters());
        let mut squares = self.d.get(columns - 1).copied().unwrap_or(0.0);
        // The first n rows are solved exactly; then come those of the outputs' own columns.
        for i in 0..self.outputs {
            let element = |j: usize| self.r.get(packed(columns, n + i, n + j)).copied().unwrap_or(0.0);
            let mut e = element(self.outputs) - theta.get(self.inputs + i).copied().unwrap_or(0.0);
            for j in i + 1..self.outputs {
                e -= element(j) * theta.get(self.inputs + j).copied().unwrap_or(0.0);
            }
            squares += self.d.get(n + i).copied().unwrap_or(0.0) * e * e;
        }
        squares
    }

    /// What column k of R⁻¹ gives to the covariance, lower triangle packed by rows in the order of the estimate: v with
    /// R v = e(k) and S the scales, then σ² (S R⁻¹ D⁻¹ R⁻ᵀ S)(i, j) = Σₖ σ² s(i) v(i) s(j) v(j) / d(k). `v` is room to work
    /// in.
    pub(super) fn add_covariance(&self, k: usize, variance: f32, v: &mut [f32], inverse: &mut [f32]) {
        v.iter_mut().skip(k).take(1).for_each(|own| *own = 1.0);
        for i in (0..k).rev() {
            let mut value = 0.0;
            for (j, later) in v.iter().enumerate().take(k + 1).skip(i + 1) {
                value -= self.element(i, j) * later;
            }
            v.iter_mut().skip(i).take(1).for_each(|cell| *cell = value);
        }
        v.iter_mut().enumerate().take(k + 1).for_each(|(i, v)| *v *= self.scale_of(i));
        let weight = variance / self.diagonal(k);
        for (i, vi) in v.iter().enumerate().take(k + 1) {
            let scaled = vi * weight;
            for (j, vj) in v.iter().enumerate().take(i + 1) {
                self.add(inverse, (i, j), scaled * vj);
            }
        }
    }
}

/// Place of element (i, j ≤ i) of a symmetric matrix, lower triangle packed by rows.
pub(super) const fn lower(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

/// A number of parameters that is a constant of a type, so that only the code of that number is compiled.
pub(super) trait Size {
    /// The number; 0 where it is not known when compiling.
    const N: usize;
}

/// Of a triangle whose capacity `M` is used up.
pub(super) struct Full<const M: usize>;

impl<const M: usize> Size for Full<M> {
    const N: usize = M.saturating_sub(1);
}

/// Of a form.
pub(super) struct Of<S>(core::marker::PhantomData<S>);

impl<S: Shape> Size for Of<S> {
    const N: usize = match S::FIXED {
        Some(form) => form.order.columns(form.offset) - 1,
        None => 0,
    };
}

/// The same sums in straight-line code, for as many parameters as `T` says: `None` or `false` where there is none.
pub(super) mod unrolled {
    use super::{Factor, Size};

    /// Σ_{i<j} d(i) R(i, j)² for each j, ascending.
    macro_rules! dependent {
        ($f:ident; [$($seen:literal)*]) => { None };
        ($f:ident; [$($seen:literal)*] $j:literal $($rest:literal)*) => {{
            let above = 0.0_f32 $(+ $f.diagonal($seen) * $f.element($seen, $j) * $f.element($seen, $j))*;
            if $f.excited($j, above) { dependent!($f; [$($seen)* $j] $($rest)*) } else { Some($j) }
        }};
    }

    /// Rows i descending, from the list of all i reversed.
    macro_rules! solve {
        ($f:ident $n:literal $x:ident; [$($later:literal)*]) => {};
        ($f:ident $n:literal $x:ident; [$($later:literal)*] $i:literal $($rest:literal)*) => {
            $x[$i] = $f.element($i, $n) $(- $f.element($i, $later) * $x[$later])*;
            solve!($f $n $x; [$i $($later)*] $($rest)*);
        };
    }

    /// A branch for each column k, walking the list: the columns before it ascending, and descending.
    macro_rules! columns {
        ($f:ident $n:literal $k:ident $s:ident $c:ident; [$($seen:literal)*] [$($reversed:literal)*]) => {};
        ($f:ident $n:literal $k:ident $s:ident $c:ident; [$($seen:literal)*] [$($reversed:literal)*] $own:literal $($rest:literal)*) => {
            if $k == $own {
                let mut x = [0.0_f32; $n];
                x[$own] = 1.0;
                back!($f x; [$own] $($reversed)*);
                $(x[$seen] *= $f.scale_of($seen);)*
                x[$own] *= $f.scale_of($own);
                let weight = $s / $f.diagonal($own);
                outer!($f $c x weight; [] $($seen)* $own);
            }
            columns!($f $n $k $s $c; [$($seen)* $own] [$own $($reversed)*] $($rest)*);
        };
    }

    /// x(i) = −Σ_{j>i} R(i, j) x(j), i descending.
    macro_rules! back {
        ($f:ident $x:ident; [$($later:literal)+]) => {};
        ($f:ident $x:ident; [$($later:literal)+] $i:literal $($rest:literal)*) => {
            $x[$i] = 0.0 $(- $f.element($i, $later) * $x[$later])+;
            back!($f $x; [$i $($later)+] $($rest)*);
        };
    }

    /// C(i, j) += w x(i) x(j), j ≤ i.
    macro_rules! outer {
        ($f:ident $c:ident $x:ident $w:ident; [$($seen:literal)*]) => {};
        ($f:ident $c:ident $x:ident $w:ident; [$($seen:literal)*] $i:literal $($rest:literal)*) => {
            let scaled = $x[$i] * $w;
            $($f.add($c, ($i, $seen), scaled * $x[$seen]);)*
            $f.add($c, ($i, $i), scaled * $x[$i]);
            outer!($f $c $x $w; [$($seen)* $i] $($rest)*);
        };
    }

    /// The sizes: n, then the columns ascending and descending.
    macro_rules! sizes {
        ($with:ident) => {
            $with! {
                1: 0; 0,
                2: 0 1; 1 0,
                3: 0 1 2; 2 1 0,
                4: 0 1 2 3; 3 2 1 0,
                5: 0 1 2 3 4; 4 3 2 1 0,
                6: 0 1 2 3 4 5; 5 4 3 2 1 0,
                7: 0 1 2 3 4 5 6; 6 5 4 3 2 1 0,
                8: 0 1 2 3 4 5 6 7; 7 6 5 4 3 2 1 0,
                9: 0 1 2 3 4 5 6 7 8; 8 7 6 5 4 3 2 1 0,
                10: 0 1 2 3 4 5 6 7 8 9; 9 8 7 6 5 4 3 2 1 0,
                11: 0 1 2 3 4 5 6 7 8 9 10; 10 9 8 7 6 5 4 3 2 1 0,
                12: 0 1 2 3 4 5 6 7 8 9 10 11; 11 10 9 8 7 6 5 4 3 2 1 0,
                13: 0 1 2 3 4 5 6 7 8 9 10 11 12; 12 11 10 9 8 7 6 5 4 3 2 1 0,
                14: 0 1 2 3 4 5 6 7 8 9 10 11 12 13; 13 12 11 10 9 8 7 6 5 4 3 2 1 0,
                15: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14; 14 13 12 11 10 9 8 7 6 5 4 3 2 1 0,
                16: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; 15 14 13 12 11 10 9 8 7 6 5 4 3 2 1 0,
            }
        };
    }

    /// As [`Factor::dependent`].
    #[inline(always)]
    pub(in super::super) fn dependent<T: Size>(f: &Factor<'_>) -> Option<Option<usize>> {
        macro_rules! run {
            ($($n:literal: $($k:literal)+; $($r:literal)+,)+) => {
                match T::N {
                    $($n => Some(dependent!(f; [] $($k)+)),)+
                    _ => None,
                }
            };
        }
        sizes!(run)
    }

    /// As [`Factor::solve`].
    #[inline(always)]
    pub(in super::super) fn solve<T: Size>(f: &Factor<'_>, theta: &mut [f32]) -> bool {
        macro_rules! run {
            ($($n:literal: $($k:literal)+; $($r:literal)+,)+) => {
                match T::N {
                    $($n => {
                        let Some(x) = theta.first_chunk_mut::<$n>() else { return false };
                        solve!(f $n x; [] $($r)+);
                        true
                    })+
                    _ => false,
                }
            };
        }
        sizes!(run)
    }

    /// As [`Factor::add_covariance`].
    #[inline(always)]
    pub(in super::super) fn add_covariance<T: Size>(
        f: &Factor<'_>,
        k: usize,
        variance: f32,
        inverse: &mut [f32],
    ) -> bool {
        macro_rules! run {
            ($($n:literal: $($k:literal)+; $($r:literal)+,)+) => {
                match T::N {
                    $($n => {
                        let Some(c) = inverse.first_chunk_mut::<{ $n * ($n + 1) / 2 }>() else { return false };
                        columns!(f $n k variance c; [] [] $($k)+);
                        true
                    })+
                    _ => false,
                }
            };
        }
        sizes!(run)
    }

    /// Hands every i to `each`, ascending.
    #[inline(always)]
    pub(in super::super) fn every<T: Size>(mut each: impl FnMut(usize)) -> bool {
        macro_rules! run {
            ($($n:literal: $($k:literal)+; $($r:literal)+,)+) => {
                match T::N {
                    $($n => { $(each($k);)+ true })+
                    _ => false,
                }
            };
        }
        sizes!(run)
    }
}
