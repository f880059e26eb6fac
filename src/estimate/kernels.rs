//! Straight-line code of the row update for the sizes a model uses: LLVM stops unrolling the plain loops at nine columns, and they
//! then cost about twice as much.

use super::Forgetting;

/// (1): updates d(i) and w, gives s.
#[inline(always)]
pub(super) fn pivot<const FORGET: bool>(di: &mut f32, xi: f32, w: &mut f32, forgetting: Forgetting) -> f32 {
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

/// Place of R(i, j), j > i, in the packed rows of m columns.
pub(super) const fn packed(m: usize, i: usize, j: usize) -> usize {
    i * (2 * m - i - 1) / 2 + j - i - 1
}

/// One kernel a size, every index a constant below its array's length. `pivots!` walks the column list: the head is i, the tail all j > i.
macro_rules! straight_line {
    ($($name:ident $m:literal: $($i:literal)+;)+) => {
        $(
            #[inline]
            fn $name<const FORGET: bool>(
                d: &mut [f32; $m],
                r: &mut [f32; $m * ($m - 1) / 2],
                row: &[f32; $m],
                weight: f32,
                forgetting: Forgetting,
            ) {
                let mut x = *row;
                let mut w = weight;
                pivots!($m d r x w forgetting; $($i)+);
            }
        )+

        /// Runs the kernel of size `M`; `false` if there is none.
        #[inline(always)]
        pub(super) fn rotate<const M: usize, const P: usize, const FORGET: bool>(
            d: &mut [f32; M],
            r: &mut [f32; P],
            row: &[f32; M],
            weight: f32,
            forgetting: Forgetting,
        ) -> bool {
            match M {
                $($m => {
                    // The conversions cannot fail where M is $m; they compile to nothing.
                    let (Ok(d), Ok(r), Ok(row)) =
                        (d.as_mut_slice().try_into(), r.as_mut_slice().try_into(), row.as_slice().try_into())
                    else {
                        return false;
                    };
                    $name::<FORGET>(d, r, row, weight, forgetting);
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
