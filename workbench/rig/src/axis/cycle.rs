//! Cycles of a machine: five moves, each followed by a rest.
//!
//! A move is a trapezoid of the velocity between two stops; its ramps last 0.12 s, and a short move is a triangle.
//! Times and positions vary from move to move, but errors of position do not add up: each move starts where the last
//! one has ended. One of twelve moves is interrupted: it stops on its way, waits, and continues.

use super::{NoiseSource, Stream};
use crate::field::draws::between;

/// Which motions a cycle consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Motion {
    /// The same five moves in each cycle and each record.
    Same,
    /// Other moves in each cycle.
    Any,
}

impl Motion {
    /// Name in labels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Same => "cycle",
            Self::Any => "any-cycle",
        }
    }
}

/// Where a move ends, as a part of the reach, its velocity as a part of the peak, and the rest after it.
type Stop = (f64, f64, f64);

/// The cycle of [`Motion::Same`], which ends where it starts.
const MACHINE: [Stop; 5] = [(0.7, 1.0, 0.3), (0.25, 0.6, 0.2), (-0.45, 0.85, 0.4), (-0.9, 0.7, 0.25), (0.0, 1.0, 0.35)];

/// Reach of the rigs' cycles, in seconds at the peak velocity.
pub(crate) const REACH_S: f64 = 0.75;
/// Duration of a ramp from rest.
const RAMP_S: f64 = 0.12;
/// Relative variation of a rest.
const TIME_JITTER: f64 = 0.1;
/// Largest error of a stop, as a part of the reach.
const POSITION_JITTER: f64 = 0.005;
/// Probability of an interruption of a move.
const INTERRUPTED: f64 = 1.0 / 12.0;
/// Wait of an interruption.
const WAIT_S: [f64; 2] = [0.3, 1.0];
/// Rest at the start of a record.
const START_S: [f64; 2] = [0.15, 0.6];

/// Scale of a motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    /// Largest velocity.
    pub(crate) peak: f64,
    /// Largest distance from the start, in the unit of the velocity times seconds.
    pub(crate) reach: f64,
}

/// Points of time and velocity of a motion of at least `end_s`, between which it is linear.
pub(crate) fn velocities(motion: Motion, scale: Scale, end_s: f64, seed: u64) -> Vec<[f64; 2]> {
    let mut lines = Lines { source: NoiseSource::new(seed, Stream::Cycle), points: vec![[0.0, 0.0]], at: 0.0, scale };
    let rest_s = between(&mut lines.source, START_S);
    lines.rest(rest_s);
    while lines.last_s() <= end_s {
        let stops = match motion {
            Motion::Same => MACHINE,
            Motion::Any => [0; 5].map(|_| {
                let mut draw = |range| between(&mut lines.source, range);
                (draw([-1.0, 1.0]), draw([0.4, 1.0]), draw([0.15, 0.45]))
            }),
        };
        for stop in stops {
            lines.go(stop);
        }
    }
    lines.points
}

struct Lines {
    source: NoiseSource,
    points: Vec<[f64; 2]>,
    /// Position, as a part of the reach.
    at: f64,
    scale: Scale,
}

impl Lines {
    fn last_s(&self) -> f64 {
        self.points.last().map_or(0.0, |[t_s, _]| *t_s)
    }

    fn line(&mut self, velocity: f64, duration_s: f64) {
        self.points.push([self.last_s() + duration_s, velocity]);
    }

    fn rest(&mut self, rest_s: f64) {
        let varied = self.source.uniform(1.0 - TIME_JITTER, 1.0 + TIME_JITTER);
        self.line(0.0, rest_s * varied);
    }

    fn go(&mut self, (to, speed, rest_s): Stop) {
        let to = to + self.source.uniform(-POSITION_JITTER, POSITION_JITTER);
        let [chance, part] = [self.source.uniform(0.0, 1.0), self.source.uniform(0.2, 0.8)];
        if chance < INTERRUPTED {
            let halt = self.at + part * (to - self.at);
            self.travel(halt, speed);
            let wait_s = between(&mut self.source, WAIT_S);
            self.rest(wait_s);
        }
        self.travel(to, speed);
        self.rest(rest_s);
    }

    /// A trapezoid of this velocity, or a triangle of a lower one, whose area is the distance.
    fn travel(&mut self, to: f64, speed: f64) {
        let distance = (to - self.at) * self.scale.reach;
        let velocity = (speed * self.scale.peak).min(distance.abs() / RAMP_S).copysign(distance);
        self.at = to;
        if velocity == 0.0 {
            return;
        }
        self.line(velocity, RAMP_S);
        self.line(velocity, distance / velocity - RAMP_S);
        self.line(0.0, RAMP_S);
    }
}

/// Intervals of time in which a motion rests.
pub(crate) fn rests(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let pairs = points.windows(2).filter(|pair| pair[0][1] == 0.0 && pair[1][1] == 0.0 && pair[0][0] < pair[1][0]);
    pairs.map(|pair| [pair[0][0], pair[1][0]]).collect()
}

/// The position over time of a motion between points of velocity.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    points: Vec<[f64; 2]>,
    /// Position at each point.
    positions: Vec<f64>,
}

impl Path {
    pub(crate) fn new(points: Vec<[f64; 2]>) -> Self {
        let mut positions = vec![0.0; points.len()];
        for k in 1..points.len() {
            let [[from_s, from], [to_s, to]] = [points[k - 1], points[k]];
            positions[k] = positions[k - 1] + 0.5 * (from + to) * (to_s - from_s);
        }
        Self { points, positions }
    }

    /// The position at time `t_s`, zero at the start.
    pub(crate) fn at(&self, t_s: f64) -> f64 {
        let next = self.points.partition_point(|[time_s, _]| *time_s <= t_s);
        let Some(last) = next.checked_sub(1) else { return 0.0 };
        let [from_s, from] = self.points[last];
        let elapsed = t_s - from_s;
        let slope = self.points.get(next).map_or(0.0, |[to_s, to]| (to - from) / (to_s - from_s));
        self.positions[last] + (from + 0.5 * slope * elapsed) * elapsed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCALE: Scale = Scale { peak: 40.0, reach: 30.0 };

    /// Positions of the rests but the first one, as parts of the reach.
    fn stops(points: &[[f64; 2]]) -> Vec<f64> {
        let path = Path::new(points.to_vec());
        rests(points).iter().skip(1).map(|[from, to]| path.at(0.5 * (from + to)) / SCALE.reach).collect()
    }

    #[test]
    fn the_same_cycle_comes_back_to_its_stops_unless_it_is_interrupted() {
        let mut interrupted = 0;
        for seed in 0..400 {
            let points = velocities(Motion::Same, SCALE, 3.5, seed);
            assert!(points.iter().all(|[_, v]| v.abs() <= SCALE.peak));
            assert!(points.windows(2).all(|pair| pair[1][0] >= pair[0][0]), "{seed}");
            let stops = stops(&points);
            // Rounding beside the jitter.
            let near = |stop: &f64| MACHINE.iter().any(|(at, ..)| (stop - at).abs() < POSITION_JITTER + 1e-9);
            interrupted += stops.iter().filter(|stop| !near(stop)).count();
            assert!(MACHINE.iter().all(|(at, ..)| stops.iter().any(|stop| (stop - at).abs() < 0.0051)), "{seed}");
        }
        // One cycle of five moves lasts 4.5 s: one of twelve of 2000 is 167, four deviations of a binomial are 50; an
        // interruption within 0.005 of another stop is rare.
        assert!((110..220).contains(&interrupted), "{interrupted}");
    }

    #[test]
    fn other_motions_are_others_each_time() {
        let points = velocities(Motion::Any, SCALE, 60.0, 3);
        let stops = stops(&points);
        // Twelve cycles; no two of 60 uniform stops are equal.
        assert!(stops.len() >= 50);
        let pairs = stops.iter().enumerate().flat_map(|(k, a)| stops[..k].iter().map(move |b| (a, b)));
        assert!(pairs.filter(|(a, b)| (*a - *b).abs() < 1e-9).count() == 0);
        assert!(stops.iter().all(|stop| stop.abs() <= 1.0 + POSITION_JITTER));
    }

    #[test]
    fn the_position_is_the_area_under_the_velocity() {
        let path = Path::new(vec![[0.0, 0.0], [1.0, 0.0], [2.0, 4.0], [3.0, 4.0], [5.0, 0.0]]);
        for (t_s, position) in [(0.5, 0.0), (1.5, 0.5), (2.0, 2.0), (2.5, 4.0), (4.0, 9.0), (5.0, 10.0), (9.0, 10.0)] {
            assert_eq!(path.at(t_s), position, "{t_s}");
        }
    }
}
