//! The surprise as a piecewise linear function with few knots, which the core interpolates.

use bearing_watch::model::KNOTS;

use super::law::DistanceLaw;

/// Surprise up to which the knots approximate the law, nats.
pub const FOLLOWED: f64 = 25.0;
/// Below this surprise the error is absolute, in nats; above it relative.
const SMALL: f64 = 1.0;
const GRID: usize = 200;

/// Returns the knots (d², surprise) from (0, 0) to 25 nats and beyond, one of them at the gate's `limit`; the largest
/// error of the interpolation is about the same in every interval.
#[must_use]
pub fn knots(law: &DistanceLaw, limit: f64) -> [[f64; 2]; KNOTS] {
    knots_of(|surprise| law.squared_at(surprise), 0.0, limit)
}

/// Returns the knots of a curve from its `least` surprise on, as [`knots`]. The surprises that `at` is called with
/// increase.
pub(crate) fn knots_of(mut at: impl FnMut(f64) -> f64, least: f64, limit: f64) -> [[f64; 2]; KNOTS] {
    // Denser at the start, where the curvature is largest.
    let part = |k: usize| (k as f64 / GRID as f64).powi(2);
    let mut surprises: Vec<f64> = (0..=GRID).map(|k| least + (FOLLOWED - least) * part(k)).collect();
    let gate = surprises.iter().position(|s| *s >= limit).unwrap_or(GRID);
    surprises[gate] = limit.clamp(least, FOLLOWED);
    let curve: Vec<[f64; 2]> = surprises.iter().map(|s| [at(*s), *s]).collect();
    let (mut fine, mut coarse) = (1e-6_f64, 1.0_f64);
    for _ in 0..40 {
        let middle = (fine * coarse).sqrt();
        if walk(&curve, gate, middle).len() <= KNOTS { coarse = middle } else { fine = middle }
    }
    let mut chosen = walk(&curve, gate, coarse);
    let mut further = FOLLOWED;
    while chosen.len() < KNOTS {
        further += 1.0;
        chosen.push([at(further), further]);
    }
    std::array::from_fn(|k| chosen[k])
}

/// Returns the fewest knots for which the error of every line is at most `error`.
fn walk(curve: &[[f64; 2]], gate: usize, error: f64) -> Vec<[f64; 2]> {
    let mut chosen = vec![curve[0]];
    let mut at = 0;
    while at + 1 < curve.len() {
        let end = if at < gate { gate } else { curve.len() - 1 };
        // The error grows with the length of the line: the first line with too large an error ends the search.
        let reach = (at + 2..=end).take_while(|&to| worst(&curve[at..=to]) <= error).last();
        at = reach.unwrap_or(at + 1);
        chosen.push(curve[at]);
    }
    chosen
}

/// Returns the largest error of the line from the first to the last point.
fn worst(points: &[[f64; 2]]) -> f64 {
    let ([x0, s0], [x1, s1]) = (points[0], points[points.len() - 1]);
    let each = |[x, s]: &[f64; 2]| (s0 + (x - x0) * (s1 - s0) / (x1 - x0) - s).abs() / s.max(SMALL);
    points.iter().map(each).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_follow_the_curve_within_two_percent() {
        for (p, n) in [(1, 5), (1, 20), (1, 1000), (3, 20), (6, 12), (6, 200), (20, 60), (60, 1000)] {
            let law = DistanceLaw::gaussian(p, n);
            let limit = 100_f64.ln();
            let knots = knots(&law, limit);
            assert!(knots.iter().any(|[_, s]| (s - limit).abs() < 1e-12));
            for k in 1..500 {
                let surprise = 0.05 * f64::from(k);
                let squared = law.squared_at(surprise);
                let to = knots.iter().position(|[x, _]| *x >= squared).expect("beyond the last");
                let ([x0, s0], [x1, s1]) = (knots[to - 1], knots[to]);
                let line = s0 + (squared - x0) * (s1 - s0) / (x1 - x0);
                assert!((line - surprise).abs() < 0.02 * surprise.max(1.0), "{p} {n}: {surprise} {line}");
            }
        }
    }
}
