//! Checks of lists of numbers. They are `const`, so they walk slices by patterns.

/// Whether both coordinates of the knots increase. NaN does not.
const fn increase(knots: &[[f32; 2]]) -> bool {
    let mut rest = knots;
    while let [[x0, s0], later @ ..] = rest {
        if let [[x1, s1], ..] = later
            && !(*x0 < *x1 && *s0 < *s1)
        {
            return false;
        }
        rest = later;
    }
    true
}

/// Whether the knots are those of a law: both coordinates increase, and none is negative.
pub(super) const fn is_law(knots: &[[f32; 2]]) -> bool {
    increase(knots) && all_within(knots.as_flattened(), 0.0, f32::MAX)
}

/// Whether the law, or the straight line beyond its last knots, has the surprise `limit` at an x of at most `most`.
pub(super) const fn reaches(knots: &[[f32; 2]], limit: f32, most: f32) -> bool {
    let mut rest = knots;
    while let [[x0, s0], later @ ..] = rest {
        if *s0 >= limit {
            return *x0 <= most;
        }
        if let [[x1, s1]] = later
            && *s1 < limit
        {
            return *x1 + (limit - *s1) * ((*x1 - *x0) / (*s1 - *s0)) <= most;
        }
        rest = later;
    }
    false
}

/// Whether every value is within the range. NaN is not.
pub(super) const fn all_within(values: &[f32], least: f32, most: f32) -> bool {
    let mut rest = values;
    while let [x, later @ ..] = rest {
        if !(*x >= least && *x <= most) {
            return false;
        }
        rest = later;
    }
    true
}

/// Whether the pivots are above zero and at most the square of `largest`, and the others within ±`largest`, in factors
/// of this number of rows: of each row the pivot first, then what is right of it.
pub(super) const fn are_factors(values: &[f32], rows: usize, largest: f32) -> bool {
    let (mut rest, mut left) = (values, rows);
    while let [pivot, later @ ..] = rest {
        let (row, below) = split(later, left.saturating_sub(1));
        if !(*pivot >= f32::MIN_POSITIVE && *pivot <= largest * largest && all_within(row, -largest, largest)) {
            return false;
        }
        rest = below;
        left = if left > 1 { left.saturating_sub(1) } else { rows };
    }
    true
}

/// Whether sums of squares of a signal within its limit, so scaled, stay far inside the range of f32.
pub(super) const fn bounded(scale: &[f32], limit: f32) -> bool {
    // Only level and first difference can be large; differences share one scale.
    all_within(scale, 0.0, 1e14 / limit)
}

/// Whether every value is a power of two within 2^±60.
pub(super) const fn all_powers_of_two(values: &[f32]) -> bool {
    let mut rest = values;
    while let [x, later @ ..] = rest {
        if !(*x >= 8.67e-19 && *x <= 1.16e18 && x.to_bits() & 0x007F_FFFF == 0) {
            return false;
        }
        rest = later;
    }
    true
}

/// Whether all differences of a signal, the columns after its level, have one scale.
pub(super) const fn differences_alike(scale: &[f32]) -> bool {
    let mut rest = match scale {
        [_level, differences @ ..] => differences,
        [] => return true,
    };
    while let [one, other, ..] = rest {
        if one.to_bits() != other.to_bits() {
            return false;
        }
        rest = match rest {
            [_, later @ ..] => later,
            [] => return true,
        };
    }
    true
}

/// The first `count` values, and the rest; all of them if there are fewer.
pub(super) const fn split(values: &[f32], count: usize) -> (&[f32], &[f32]) {
    match values.split_at_checked(count) {
        Some(parts) => parts,
        None => (values, &[]),
    }
}
