//! Reduces a long series to one that looks the same at the width of the plot.
//!
//! Neighbouring points in the same pixel column are replaced by the lowest and the highest of them, in
//! their original order. The line covers the same pixels to within one column, and no peak is lost, however
//! narrow: a mean or every n-th point would hide the narrow peaks that a bearing fault causes.

use super::numbers::usable;

/// Splits `points` at non-finite coordinates, and reduces each run to at most two points per column
/// (plus its first and last point).
pub(in crate::plot) fn runs(points: &[(f64, f64)], x_lo: f64, x_hi: f64, columns: f64) -> Vec<Vec<(f64, f64)>> {
    let column = |x: f64| ((x - x_lo) / (x_hi - x_lo) * columns).floor();
    points
        .split(|&(x, y)| !usable(x) || !usable(y))
        .filter(|run| !run.is_empty())
        .map(|run| {
            let mut kept = Vec::new();
            for group in run.chunk_by(|a, b| column(a.0) == column(b.0)) {
                push_extremes(&mut kept, group);
            }
            keep_ends(&mut kept, run);
            kept
        })
        .collect()
}

/// Appends the lowest and the highest point of a column; one or two points are appended unchanged.
fn push_extremes(kept: &mut Vec<(f64, f64)>, group: &[(f64, f64)]) {
    if group.len() <= 2 {
        kept.extend_from_slice(group);
        return;
    }
    let (mut lowest, mut highest) = (0, 0);
    for (i, point) in group.iter().enumerate() {
        if point.1 < group[lowest].1 {
            lowest = i;
        }
        if point.1 > group[highest].1 {
            highest = i;
        }
    }
    kept.push(group[lowest.min(highest)]);
    if lowest != highest {
        kept.push(group[lowest.max(highest)]);
    }
}

/// The line must begin and end with the first and the last data point.
fn keep_ends(kept: &mut Vec<(f64, f64)>, run: &[(f64, f64)]) {
    if let (Some(&first), Some(&last)) = (run.first(), run.last()) {
        if kept.first() != Some(&first) {
            kept.insert(0, first);
        }
        if kept.last() != Some(&last) {
            kept.push(last);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_and_ends_survive() {
        let mut points: Vec<(f64, f64)> = (0..5000).map(|i| (f64::from(i), (f64::from(i) * 0.01).sin())).collect();
        points[1234].1 = 9.0;
        points[4321].1 = -7.0;
        let kept = runs(&points, 0.0, 4999.0, 100.0).concat();
        assert!(kept.len() <= 206, "{} points", kept.len());
        assert!(kept.contains(&(1234.0, 9.0)) && kept.contains(&(4321.0, -7.0)));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[4999]));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0), "order is kept");
    }

    #[test]
    fn gaps_split_the_line() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 2.0), (3.0, 3.0), (f64::INFINITY, 1.0)];
        assert_eq!(runs(&points, 0.0, 3.0, 100.0), vec![vec![(0.0, 1.0)], vec![(2.0, 2.0), (3.0, 3.0)]]);
        assert!(runs(&[], 0.0, 1.0, 100.0).is_empty());
    }

    #[test]
    fn short_series_pass_unchanged() {
        let points = [(0.0, 1.0), (5.0, -1.0), (10.0, 4.0)];
        assert_eq!(runs(&points, 0.0, 10.0, 680.0).concat(), points);
    }
}
