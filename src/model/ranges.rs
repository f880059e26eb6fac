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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_increases_in_both_coordinates() {
        assert!(is_law(&[[0.0, 0.0], [1.0, 0.5], [4.0, 2.0]]));
        for knots in [
            [[0.0, 0.0], [0.0, 0.5], [4.0, 2.0]],
            [[0.0, 0.0], [1.0, 0.5], [4.0, 0.5]],
            [[0.0, -0.1], [1.0, 0.5], [4.0, 2.0]],
            [[0.0, 0.0], [1.0, f32::NAN], [4.0, 2.0]],
        ] {
            assert!(!is_law(&knots), "{knots:?}");
        }
    }

    #[test]
    fn a_law_reaches_its_limit_at_a_knot_or_on_its_last_line() {
        let law = [[0.0, 0.0], [1.0, 0.5], [4.0, 2.0]];
        // At the knots 2 lies at 4; behind them half of what is added to x: 5 at 10.
        for (limit, most, reached) in [(2.0, 4.0, true), (2.0, 3.9, false), (5.0, 10.0, true), (5.0, 9.9, false)] {
            assert_eq!(reaches(&law, limit, most), reached, "{limit} {most}");
        }
        assert!(!reaches(&law, f32::NAN, 1e9) && !reaches(&[], 1.0, 1e9));
    }

    #[test]
    fn ranges_include_their_ends_and_no_nan() {
        assert!(all_within(&[-1.0, 0.0, 2.0], -1.0, 2.0) && all_within(&[], 0.0, 0.0));
        for x in [-1.1, 2.1, f32::NAN, f32::INFINITY] {
            assert!(!all_within(&[0.0, x], -1.0, 2.0) && !all_within(&[x, 0.0], -1.0, 2.0), "{x}");
        }
    }

    #[test]
    fn a_factor_has_positive_pivots_at_the_starts_of_its_rows() {
        // Rows of 3, 2 and 1 elements, twice.
        let good = [1.0, -9.0, 9.0, 100.0, -9.0, f32::MIN_POSITIVE, 2.0, 0.0, 0.0, 2.0, 0.0, 2.0];
        assert!(are_factors(&good, 3, 10.0));
        for (index, x) in [(0, 0.0), (3, -1.0), (5, 1e-39), (6, f32::NAN), (11, 101.0), (1, -10.1), (8, f32::NAN)] {
            let mut bad = good;
            bad[index] = x;
            assert!(!are_factors(&bad, 3, 10.0), "{index} {x}");
        }
    }

    #[test]
    fn scales_are_powers_of_two_and_one_for_all_differences() {
        assert!(all_powers_of_two(&[1.0, 0.125, 1024.0, libm::exp2f(60.0), libm::exp2f(-60.0)]));
        for x in [3.0, 0.0, -2.0, f32::NAN, f32::INFINITY, libm::exp2f(61.0), libm::exp2f(-61.0)] {
            assert!(!all_powers_of_two(&[1.0, x]), "{x}");
        }
        assert!(differences_alike(&[8.0, 2.0, 2.0, 2.0]) && differences_alike(&[8.0]) && differences_alike(&[]));
        assert!(!differences_alike(&[2.0, 2.0, 2.0, 8.0]) && !differences_alike(&[2.0, 8.0, 2.0]));
        // 1e14 of the unit at most, after the scale.
        assert!(bounded(&[1e12], 100.0) && !bounded(&[1.01e12], 100.0) && !bounded(&[-1.0], 100.0));
    }
}
