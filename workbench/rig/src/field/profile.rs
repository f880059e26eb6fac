//! The velocity reference of one record, drawn by its [`Duty`].

use super::draws::between;
use super::duty::Duty;
use crate::axis::cycle;
use crate::{NoiseSource, Scenario, Stream};

/// Modulation of the one-way duty.
const MODULATION: f64 = 0.3;

/// The reference of one record.
#[derive(Debug, Clone)]
pub(crate) enum Profile {
    /// The waveform of the scenario.
    Waveform,
    /// Straight lines between points of time and velocity; two points of one time are a step.
    Lines(Vec<[f64; 2]>),
    /// The one-way duty.
    OneWay,
    /// The constant velocity.
    Constant,
}

impl Profile {
    pub(crate) fn draw(scenario: &Scenario, seed: u64) -> Self {
        let mut source = NoiseSource::new(seed, Stream::Duty);
        let duty = scenario.duty.drawn(&mut source);
        let end_s = scenario.samples as f64 * scenario.sample_time_s;
        let mut lines = Lines { source, points: vec![[0.0, 0.0]] };
        let peak = scenario.reference_amplitude_rad_s;
        match duty {
            Duty::RandomSteps => lines.until(end_s, |lines| lines.step(peak)),
            Duty::SetPoints => lines.until(end_s, |lines| lines.set_point(peak)),
            Duty::Trapezoids => {
                let mut peak = if lines.source.uniform(-1.0, 1.0) < 0.0 { -peak } else { peak };
                lines.until(end_s, |lines| {
                    lines.trapezoid(peak);
                    peak = -peak;
                });
            }
            Duty::Cycle(motion) => {
                let scale = cycle::Scale { peak, reach: cycle::REACH_S * peak };
                return Self::Lines(cycle::velocities(motion, scale, end_s, seed));
            }
            Duty::OneWay => return Self::OneWay,
            Duty::ConstantSpeed => return Self::Constant,
            Duty::Waveform | Duty::Any | Duty::AnyReversing => return Self::Waveform,
        }
        Self::Lines(lines.points)
    }

    /// The reference at time `t_s` of the record.
    pub(crate) fn at(&self, scenario: &Scenario, t_s: f64) -> f64 {
        match self {
            Self::Waveform => scenario.reference_at(t_s),
            Self::Lines(points) => on_lines(points, t_s),
            Self::OneWay => {
                let wave = libm::sin(core::f64::consts::TAU * scenario.reference_frequency_hz * t_s);
                scenario.reference_amplitude_rad_s * (1.0 + MODULATION * wave)
            }
            Self::Constant => scenario.reference_amplitude_rad_s,
        }
    }

    /// Intervals of time in which the reference is zero; only straight lines have any.
    pub(crate) fn rests_s(&self) -> Vec<[f64; 2]> {
        if let Self::Lines(points) = self { cycle::rests(points) } else { vec![] }
    }

    /// The velocity of the shaft at the start of the record.
    pub(crate) fn initial_rad_s(&self, scenario: &Scenario) -> f64 {
        match self {
            Self::Waveform | Self::Lines(_) => 0.0,
            Self::OneWay | Self::Constant => self.at(scenario, 0.0),
        }
    }
}

/// Points of a reference, drawn one after the other.
struct Lines {
    source: NoiseSource,
    points: Vec<[f64; 2]>,
}

impl Lines {
    fn until(&mut self, end_s: f64, mut more: impl FnMut(&mut Self)) {
        while self.last()[0] <= end_s {
            more(self);
        }
    }

    fn last(&self) -> [f64; 2] {
        self.points.last().copied().unwrap_or_default()
    }

    /// A straight line to `velocity_rad_s`, whose duration is uniform over the range.
    fn line(&mut self, velocity_rad_s: f64, duration_s: [f64; 2]) {
        let time_s = self.last()[0] + between(&mut self.source, duration_s);
        self.points.push([time_s, velocity_rad_s]);
    }

    fn step(&mut self, peak: f64) {
        let level = self.source.uniform(-peak, peak);
        self.points.push([self.last()[0], level]);
        self.line(level, [0.5, 1.5]);
    }

    fn set_point(&mut self, peak: f64) {
        let level = self.source.uniform(-peak, peak);
        self.line(level, [0.2, 0.6]);
        self.line(level, [0.3, 1.0]);
    }

    fn trapezoid(&mut self, peak: f64) {
        let level = peak * self.source.uniform(0.5, 1.0);
        self.line(0.0, [0.3, 1.0]);
        self.line(level, [0.1, 0.4]);
        self.line(level, [0.4, 1.2]);
        self.line(0.0, [0.1, 0.4]);
    }
}

/// The value at `t_s`; after a step at this time, if there is one.
fn on_lines(points: &[[f64; 2]], t_s: f64) -> f64 {
    let next = points.partition_point(|[time_s, _]| *time_s <= t_s);
    match (points[..next].last(), points.get(next)) {
        (Some([from_s, from]), Some([to_s, to])) => from + (to - from) * (t_s - from_s) / (to_s - from_s),
        (Some([_, end]), None) => *end,
        (None, _) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Condition;
    use crate::field::tests::run;

    fn reference(duty: Duty, seed: u64) -> Vec<f64> {
        let scenario = Scenario { duty, ..Scenario::STANDARD };
        let profile = Profile::draw(&scenario, seed);
        (0..5000).map(|k| profile.at(&scenario, 0.002 * f64::from(k))).collect()
    }

    /// Lengths of the runs of samples for which `holds` is true.
    fn runs(x: &[f64], holds: impl Fn(f64) -> bool) -> Vec<usize> {
        x.split(|v| !holds(*v)).map(<[f64]>::len).filter(|length| *length > 0).collect()
    }

    #[test]
    fn one_way_never_reverses_and_a_constant_is_constant() {
        let expected = |k: i32| 40.0 * (1.0 + 0.3 * (core::f64::consts::TAU * 0.2 * 0.002 * f64::from(k)).sin());
        // Rounding only.
        assert!(reference(Duty::OneWay, 1).iter().zip(0..).all(|(v, k)| (v - expected(k)).abs() < 1e-12));
        assert!(reference(Duty::ConstantSpeed, 1).iter().all(|v| *v == 40.0));
        for condition in ["duty-one-way", "duty-constant"] {
            let condition = Condition::named(condition).expect("known");
            for seed in 0..5 {
                let trace = run(&condition.apply(Scenario::STANDARD, seed), seed);
                assert!(trace.angle_rad.windows(2).all(|pair| pair[1] > pair[0]), "{} {seed}", condition.name);
            }
        }
    }

    #[test]
    fn steps_hold_each_level() {
        let x = reference(Duty::RandomSteps, 3);
        let mut held = vec![1];
        for pair in x.windows(2) {
            if pair[1] == pair[0] {
                *held.last_mut().expect("not empty") += 1;
            } else {
                held.push(1);
            }
        }
        held.pop();
        // 0.5–1.5 s of 2 ms, give or take a sample at both ends.
        assert!(held.len() >= 6 && held.iter().all(|count| (249..=751).contains(count)), "{held:?}");
        assert!(x.iter().all(|v| v.abs() <= 40.0));
    }

    #[test]
    fn trapezoids_stand_still_and_go_both_ways() {
        for seed in 0..5 {
            let x = reference(Duty::Trapezoids, seed);
            let still = runs(&x, |v| v == 0.0);
            // 0.3–1 s of 2 ms, give or take a sample at both ends; the last run may be cut.
            assert!(still[..still.len() - 1].iter().all(|count| (149..=501).contains(count)), "{still:?}");
            assert!(still.len() >= 4);
            for side in [runs(&x, |v| v >= 20.0), runs(&x, |v| v <= -20.0)] {
                // The plateau alone lasts 0.4–1.2 s; the parts of the ramps above 20 rad/s are at most 0.4 s.
                assert!(!side.is_empty() && side.iter().all(|count| *count <= 801), "{side:?}");
            }
        }
    }

    #[test]
    fn set_points_are_ramps_without_jumps() {
        let x = reference(Duty::SetPoints, 6);
        // At most from −40 to 40 rad/s in 0.2 s: 0.8 rad/s a sample; rounding.
        assert!(x.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.8 + 1e-12));
        assert_eq!(x[0], 0.0);
        let held = x.windows(2).filter(|pair| pair[1] == pair[0]).count();
        // Held for 0.65 s and moved for 0.4 s on average.
        assert!((2200..4000).contains(&held), "{held}");
    }
}
