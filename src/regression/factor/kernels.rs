//! The update of the triangular factor by one row: a loop for any number of columns, and straight-line code for the
//! sizes that models have.
//!
//! LLVM stops unrolling the loop at nine columns, which makes it much slower. The straight-line code applies the same
//! operations in the same order, so both give the same bits.

use super::weight::{Forgetting, NEVER};

/// Equation (1) of [`super::triangle`]: updates d(i) and the weight w; returns s.
#[inline(always)]
pub fn pivot<const FORGET: bool>(di: &mut f32, xi: f32, w: &mut f32, forgetting: Forgetting) -> f32 {
    let l = if FORGET { forgetting.lambda * *di } else { *di };
    let q = *w * xi;
    let mut d = l + q * xi;
    if FORGET && d < forgetting.floor {
        d = forgetting.floor;
    }
    *di = d;
    *w = *w * l / d;
    q / d
}

/// Index of R(i, j), j > i, in the packed rows of m columns.
#[inline(always)]
pub const fn packed(m: usize, i: usize, j: usize) -> usize {
    // Wrapping, so that a build with overflow checks has no panic here; no sum wraps for i < j < m.
    let before = i.wrapping_mul(m.wrapping_mul(2).wrapping_sub(i).wrapping_sub(1)) / 2;
    before.wrapping_add(j).wrapping_sub(i).wrapping_sub(1)
}

/// Pairs up to the end of the shorter list. The compiler does not unroll a loop over them, since it has two exits: code
/// that runs once a segment stays small.
#[inline(always)]
pub fn pairs<A, B>(a: impl IntoIterator<Item = A>, b: impl IntoIterator<Item = B>) -> impl Iterator<Item = (A, B)> {
    let (mut a, mut b) = (a.into_iter(), b.into_iter());
    core::iter::from_fn(move || Some((a.next()?, b.next()?)))
}

/// Elements with their indices. A count as by `enumerate` would be checked for overflow in a build with such checks.
#[inline(always)]
pub fn numbered<T>(list: impl IntoIterator<Item = T>) -> impl Iterator<Item = (usize, T)> {
    let mut next = 0_usize;
    list.into_iter().map(move |element| {
        let index = next;
        next = index.wrapping_add(1);
        (index, element)
    })
}

/// Rotates pivot i of a row of the element `xi` there and `later` elements right of it; `ri` is row i of R right of the
/// diagonal.
#[inline(always)]
pub fn rotate_pivot<const FORGET: bool>(
    di: &mut f32,
    ri: &mut [f32],
    xi: f32,
    later: &mut [f32],
    w: &mut f32,
    forgetting: Forgetting,
) {
    // Nothing is divided by the residual sum of squares, so it needs no floor; a floor would look like noise.
    let floor = if later.is_empty() { 0.0 } else { forgetting.floor };
    let s = pivot::<FORGET>(di, xi, w, Forgetting { floor, ..forgetting });
    for (xj, rij) in later.iter_mut().zip(ri) {
        *xj -= xi * *rij; // (2)
        *rij += s * *xj;
    }
}

/// [`rotate_pivot`] without forgetting, in small code.
#[inline(never)]
pub fn rotate_pivot_small(di: &mut f32, ri: &mut [f32], xi: f32, later: &mut [f32], w: &mut f32) {
    let s = pivot::<false>(di, xi, w, NEVER);
    for (xj, rij) in pairs(later, ri) {
        *xj -= xi * *rij; // (2)
        *rij += s * *xj;
    }
}

/// Rotates a row of any number of columns.
pub fn rotate_loop<const FORGET: bool>(d: &mut [f32], r: &mut [f32], x: &mut [f32], forgetting: Forgetting) {
    let (mut x, mut r, mut w) = (x, r, 1.0);
    for di in d {
        let Some((xi, later)) = x.split_first_mut() else { return };
        let Some((ri, below)) = r.split_at_mut_checked(later.len()) else { return };
        rotate_pivot::<FORGET>(di, ri, *xi, later, &mut w, forgetting);
        (x, r) = (later, below);
    }
}

/// One kernel for each size; every index is a constant below its array's length. `pivots!` walks the list of columns:
/// the head is i, the tail all j > i.
macro_rules! straight_line {
    ($($name:ident $m:literal: $($i:literal)+;)+) => {
        $(
            #[inline]
            fn $name<const FORGET: bool>(
                d: &mut [f32; $m],
                r: &mut [f32; $m * ($m - 1) / 2],
                row: &[f32; $m],
                forgetting: Forgetting,
            ) {
                let mut x = *row;
                let mut w = 1.0;
                pivots!($m d r x w forgetting; $($i)+);
            }
        )+

        /// Runs the kernel for `d.len()` columns; returns `false` if there is none. With the length known at compile
        /// time, one branch is left.
        #[inline(always)]
        pub fn rotate_straight<const FORGET: bool>(
            d: &mut [f32],
            r: &mut [f32],
            row: &[f32],
            forgetting: Forgetting,
        ) -> bool {
            match d.len() {
                $($m => {
                    let (Ok(d), Ok(r), Ok(row)) = (d.try_into(), r.try_into(), row.try_into()) else {
                        return false;
                    };
                    $name::<FORGET>(d, r, row, forgetting);
                    true
                })+
                _ => false,
            }
        }
    };
}

macro_rules! pivots {
    ($m:literal $d:ident $r:ident $x:ident $w:ident $f:ident; $i:literal) => {
        // The last row only accumulates the residual sum of squares: it divides nothing and needs no floor.
        pivot::<FORGET>(&mut $d[$i], $x[$i], &mut $w, Forgetting { floor: 0.0, ..$f });
    };
    ($m:literal $d:ident $r:ident $x:ident $w:ident $f:ident; $i:literal $($j:literal)+) => {
        let xi = $x[$i];
        let s = pivot::<FORGET>(&mut $d[$i], xi, &mut $w, $f);
        $(
            $x[$j] -= xi * $r[const { packed($m, $i, $j) }];
            $r[const { packed($m, $i, $j) }] += s * $x[$j];
        )+
        pivots!($m $d $r $x $w $f; $($j)+);
    };
}

straight_line! {
    rotate_2 2: 0 1;
    rotate_3 3: 0 1 2;
    rotate_4 4: 0 1 2 3;
    rotate_5 5: 0 1 2 3 4;
    rotate_6 6: 0 1 2 3 4 5;
    rotate_7 7: 0 1 2 3 4 5 6;
    rotate_8 8: 0 1 2 3 4 5 6 7;
    rotate_9 9: 0 1 2 3 4 5 6 7 8;
    rotate_10 10: 0 1 2 3 4 5 6 7 8 9;
    rotate_11 11: 0 1 2 3 4 5 6 7 8 9 10;
    rotate_12 12: 0 1 2 3 4 5 6 7 8 9 10 11;
    rotate_13 13: 0 1 2 3 4 5 6 7 8 9 10 11 12;
    rotate_14 14: 0 1 2 3 4 5 6 7 8 9 10 11 12 13;
    rotate_15 15: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14;
    rotate_16 16: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15;
    rotate_17 17: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16;
    rotate_18 18: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17;
    rotate_19 19: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18;
    rotate_20 20: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19;
}
