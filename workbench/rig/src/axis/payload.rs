//! The payload of an axis: one of a record, or one that changes within it.
//!
//! A payload that changes is drawn anew from 0.4 to 1.3 at every second rest of the motion, amid the rest; in a motion
//! without rests after each 2 to 4 s.

use super::Axis;
use crate::field::draws::between;
use crate::{NoiseSource, Stream};

/// Range of a payload that changes, 1 nominal.
const STEPS: [f64; 2] = [0.4, 1.3];

/// Time between changes if the motion has no rests.
const APART_S: [f64; 2] = [2.0, 4.0];

/// The payload over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Payloads(Vec<[f64; 2]>);

impl Payloads {
    /// The payloads of a record of `end_s` whose motion rests in these intervals of time.
    #[must_use]
    pub fn draw(axis: &Axis, rests_s: &[[f64; 2]], end_s: f64, seed: u64) -> Self {
        let mut source = NoiseSource::new(seed, Stream::AxisPayload);
        let range = axis.gravity.map_or(0.0, |gravity| gravity.payload);
        let mut steps = vec![[0.0, source.uniform(1.0 - range, 1.0 + range)]];
        if axis.payload_steps {
            let mut times: Vec<f64> = rests_s.iter().skip(1).step_by(2).map(|[from, to]| 0.5 * (from + to)).collect();
            if rests_s.is_empty() {
                let mut t_s = 0.0;
                while t_s < end_s {
                    t_s += between(&mut source, APART_S);
                    times.push(t_s);
                }
            }
            steps.extend(times.into_iter().map(|t_s| [t_s, between(&mut source, STEPS)]));
        }
        Self(steps)
    }

    /// The payload at time `t_s`.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        let next = self.0.partition_point(|[time_s, _]| *time_s <= t_s);
        self.0[..next].last().map_or(1.0, |[_, payload]| *payload)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_payload_is_constant_or_changes_at_every_second_rest() {
        let axis = Axis::with_weight(0.15);
        let steps = Axis { payload_steps: true, ..axis };
        let rests = [[1.0, 2.0], [3.0, 3.4], [5.0, 6.0], [7.0, 7.2]];
        for seed in 0..200 {
            let constant = Payloads::draw(&axis, &rests, 10.0, seed);
            assert!((0.7..1.3).contains(&constant.at(0.0)) && constant.at(9.9) == constant.at(0.0));
            let changing = Payloads::draw(&steps, &rests, 10.0, seed);
            assert_eq!(changing.at(3.19), constant.at(0.0));
            let [second, third] = [changing.at(3.21), changing.at(7.11)];
            assert!(second != third && second == changing.at(7.09) && (0.4..1.3).contains(&second), "{seed}");
            let restless = Payloads::draw(&steps, &[], 10.0, seed);
            assert!(restless.at(1.9) == constant.at(0.0) && restless.at(4.1) != constant.at(0.0));
        }
        assert_eq!(Payloads::draw(&Axis::LEVEL, &rests, 10.0, 1).at(5.0), 1.0);
    }
}
