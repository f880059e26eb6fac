//! Reversals of the angle → swings, by rainflow counting (ASTM E1049-85, 5.4.4).
//!
//! ```text
//! of the last three points a, b, c:   y = |b − a|,  x = |c − b|
//! x < y            wait for the next point
//! a is the first   y is half a cycle, a is dropped
//! otherwise        y is a cycle, a and b are dropped
//! ```
//!
//! At the end what is left is counted as half cycles. A cycle of range y travels 2 y and half a cycle y: the travels of
//! all of them add up to that of the angle.

/// Points that are not yet counted.
#[derive(Clone, Debug, Default)]
pub(super) struct Rainflow {
    points: Vec<f64>,
}

impl Rainflow {
    /// Takes the next reversal; `count` gets range and number of each cycle that is complete.
    pub(super) fn push(&mut self, point: f64, mut count: impl FnMut(f64, f64)) {
        self.points.push(point);
        while let &[.., a, b, c] = self.points.as_slice() {
            let (before, last) = ((b - a).abs(), (c - b).abs());
            if last < before {
                return;
            }
            let first = self.points.len() == 3;
            count(before, if first { 0.5 } else { 1.0 });
            self.points.truncate(self.points.len() - 3);
            self.points.extend(if first { vec![b, c] } else { vec![c] });
        }
    }

    /// Counts what is left.
    pub(super) fn end(&mut self, mut count: impl FnMut(f64, f64)) {
        for pair in self.points.windows(2) {
            count((pair[1] - pair[0]).abs(), 0.5);
        }
        self.points.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the standard, figure 6.
    #[test]
    fn the_example_of_the_standard() {
        let mut cycles = std::collections::BTreeMap::new();
        let mut count = |range: f64, number: f64| *cycles.entry(range as u8).or_insert(0.0) += number;
        let mut rainflow = Rainflow::default();
        let points = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0];
        points.iter().for_each(|point| rainflow.push(*point, &mut count));
        rainflow.end(&mut count);
        assert_eq!(cycles.into_iter().collect::<Vec<_>>(), [(3, 0.5), (4, 1.5), (6, 0.5), (8, 1.0), (9, 0.5)]);
    }

    #[test]
    fn cycles_travel_as_far_as_the_angle() {
        let points: Vec<f64> =
            (0..200).map(|k| f64::from(k * k * 7919 % 1009) * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let travelled: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
        let (mut counted, mut rainflow) = (0.0, Rainflow::default());
        let mut count = |range: f64, number: f64| counted += 2.0 * number * range;
        points.iter().for_each(|point| rainflow.push(*point, &mut count));
        rainflow.end(&mut count);
        assert!((counted - travelled).abs() < 1e-6, "{counted} {travelled}");
    }
}
