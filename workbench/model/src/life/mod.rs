//! Angle and torque of a shaft → load collective and nominal life of its bearing by ISO 281.
//!
//! ```text
//! P   = F₀ + f |T|                                    equivalent dynamic load, N                            (1)
//! P_m = (Σ n_i P_iᵖ/Σ n_i)^(1/p)                      n_i: turns at P_i, of either direction               (2)
//! L₁₀ = (C/P_m)ᵖ · 10⁶ turns                          p = 3 of balls, 10/3 of rollers                      (3)
//! D   = Σ n_i/L₁₀(P_i) = Σ n_i/L₁₀                    part that is used, by Palmgren and Miner             (4)
//! A   = 180°/ψ,   L_osc = A L₁₀ swings to and fro     of a shaft that swings by ψ, Harris                  (5)
//! ψ_c = 360°/e_o,   e_o = Z (1 − γ)/2                 swing in which a ball reaches its neighbour's place  (6)
//! ```
//!
//! C is the basic dynamic load rating of the catalogue. T is the torque, of the load sensor or of the current, f the
//! bearing load per torque (of a gear, belt or screw; with the factors X and Y of ISO 281 in it), and F₀ a load that
//! does not change. (5) is (3) with the travelled angle of both directions as turns, as a swing to and fro travels 2 ψ:
//! so all motion is counted alike. It holds for swings of at least (6); e_o are the events per turn of an outer race.
//! In shorter ones the paths of neighbouring balls do not overlap, and the lubricant is not renewed. The bearing then
//! fails by false brinelling or fretting, and (3) does not apply. `rainflow` counts such motion.
//!
//! Nine of ten bearings reach L₁₀; it is a figure of the population of equal bearings under this load, with usual
//! lubrication and cleanliness (a₁ = a_ISO = 1), and does not tell the state of this one. (3) holds for P up to C/2.

mod rainflow;
mod words;

use std::f64::consts::TAU;

use rainflow::Rainflow;

use crate::trace::{MotionTrace, Trace};

/// Play by which the angle is followed, turns: noise of the angle at rest is no motion. A swing counts less by twice
/// this, 0.36°.
const PLAY: f64 = 0.0005;
/// Part of a turn a sample from which the direction is no longer certain.
const FAST: f64 = 0.4;
/// Classes of the collective; the borders are C, C/2, C/4, ….
pub const CLASSES: usize = 8;

/// The rolling elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rolling {
    /// Balls.
    #[default]
    Balls,
    /// Rollers.
    Rollers,
}

/// What the torque is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Torque {
    /// The load sensor.
    Sensor,
    /// The current, by this torque constant, N·m/A.
    Current(f64),
}

/// A bearing, and what loads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadedBearing {
    /// C, N.
    pub rating_n: f64,
    /// The rolling elements.
    pub rolling: Rolling,
    /// F₀ of (1), N.
    pub constant_n: f64,
    /// f of (1), N/(N·m), and where T is from; `None` if the load is F₀ alone.
    pub by_torque: Option<(f64, Torque)>,
    /// e_o of (6), if the geometry is known.
    pub outer_order: Option<f64>,
}

impl LoadedBearing {
    const fn exponent(&self) -> f64 {
        match self.rolling {
            Rolling::Balls => 3.0,
            Rolling::Rollers => 10.0 / 3.0,
        }
    }

    /// (1) at a sample; NaN if the torque is missing.
    fn load(&self, motion: &MotionTrace, k: usize) -> f64 {
        let torque = match self.by_torque {
            None => return self.constant_n,
            Some((factor, Torque::Sensor)) => factor * motion.load_nm[k],
            Some((factor, Torque::Current(constant))) => factor * constant * motion.current_a[k],
        };
        self.constant_n + torque.abs()
    }
}

/// Turns and loads so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Collective {
    bearing: LoadedBearing,
    /// Σ n and Σ n (P/C)ᵖ.
    turns: f64,
    weighted: f64,
    /// Turns by class, the lightest load first.
    by_class: [f64; CLASSES],
    /// Turns without a load, as the torque was missing.
    without_load: f64,
    /// Swings below (6), and their turns.
    short: (f64, f64),
    /// Samples with a step that is too large to be certain.
    fast: usize,
    /// Time of the recordings, s; `None` if one has none.
    time_s: Option<f64>,
}

/// The nominal life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalLife {
    /// P_m of (2), N.
    pub mean_load_n: f64,
    /// (3), turns.
    pub turns: f64,
    /// (3) at the recorded mean speed with its rests, hours; `None` without a time.
    pub hours: Option<f64>,
    /// (4).
    pub used: f64,
}

impl Collective {
    /// Before the first recording.
    #[must_use]
    pub const fn new(bearing: LoadedBearing) -> Self {
        Self {
            bearing,
            turns: 0.0,
            weighted: 0.0,
            by_class: [0.0; CLASSES],
            without_load: 0.0,
            short: (0.0, 0.0),
            fast: 0,
            time_s: Some(0.0),
        }
    }

    /// Adds a recording. A trace without the signals of the shaft adds nothing.
    pub fn take(&mut self, trace: &Trace) {
        let Some(motion) = &trace.motion else { return };
        let step = trace.interval_s.map(|step| step * motion.angle_rad.len() as f64);
        self.time_s = self.time_s.zip(step).map(|(all, more)| all + more);
        let mut path = Path::default();
        let mut load = f64::NAN;
        for (k, angle) in motion.angle_rad.iter().enumerate() {
            let before = std::mem::replace(&mut load, self.bearing.load(motion, k));
            let (moved, fast) = path.follow(angle / TAU);
            self.fast += usize::from(fast);
            if moved > 0.0 {
                self.add(moved, if before.is_nan() { load } else { f64::midpoint(before, load) });
            }
            if let Some(reversal) = path.reversal.take() {
                path.rainflow.push(reversal, |range, number| count(&mut self.short, self.bearing, range, number));
            }
        }
        path.rainflow.push(path.place, |range, number| count(&mut self.short, self.bearing, range, number));
        path.rainflow.end(|range, number| count(&mut self.short, self.bearing, range, number));
    }

    fn add(&mut self, turns: f64, load: f64) {
        if load.is_nan() {
            self.without_load += turns;
            return;
        }
        let part = load / self.bearing.rating_n;
        self.turns += turns;
        self.weighted += turns * part.powf(self.bearing.exponent());
        self.by_class[class(part)] += turns;
    }

    /// The life by all that was taken; `None` without a loaded turn.
    #[must_use]
    pub fn life(&self) -> Option<NominalLife> {
        let mean = self.weighted / self.turns; // (P_m/C)ᵖ
        (mean > 0.0).then(|| {
            let turns = 1e6 / mean;
            NominalLife {
                mean_load_n: self.bearing.rating_n * mean.powf(1.0 / self.bearing.exponent()),
                turns,
                hours: self.time_s.filter(|time| *time > 0.0).map(|time| turns / self.turns * time / 3600.0),
                used: self.weighted / 1e6,
            }
        })
    }

    /// The collective: from and to which load, N, and turns; the lightest first.
    pub fn classes(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let border = |k: usize| self.bearing.rating_n * 0.5_f64.powi(CLASSES as i32 - 2 - k as i32);
        (0..CLASSES).map(move |k| {
            let from = if k == 0 { 0.0 } else { border(k - 1) };
            (from, if k + 1 == CLASSES { f64::INFINITY } else { border(k) }, self.by_class[k])
        })
    }
}

/// Counts a swing that is shorter than (6).
fn count(short: &mut (f64, f64), bearing: LoadedBearing, range: f64, number: f64) {
    if range > 0.0 && bearing.outer_order.is_some_and(|order| range * order < 1.0) {
        short.0 += number;
        short.1 += 2.0 * number * range;
    }
}

/// The class of P/C: the last from 1, the one before from 1/2, ….
fn class(part: f64) -> usize {
    let octave = part.log2().floor();
    (octave + (CLASSES - 1) as f64).clamp(0.0, (CLASSES - 1) as f64) as usize
}

/// The way of the angle, turns.
#[derive(Default)]
struct Path {
    /// Angle of the last sample, and the unwrapped one.
    last: Option<f64>,
    angle: f64,
    /// The place that follows it with play, and the direction of its last move.
    place: f64,
    forward: Option<bool>,
    /// Where it has turned round.
    reversal: Option<f64>,
    rainflow: Rainflow,
}

impl Path {
    /// Follows the next angle, wrapped or not; how far the place has moved, and whether the step is too large.
    fn follow(&mut self, turns: f64) -> (f64, bool) {
        if turns.is_nan() {
            return (0.0, false);
        }
        let Some(last) = self.last.replace(turns) else {
            self.reversal = Some(0.0);
            return (0.0, false);
        };
        // Wrapped once a turn: the nearest of all angles that look alike.
        let step = (turns - last) - (turns - last).round();
        self.angle += step;
        let place = self.place.clamp(self.angle - PLAY, self.angle + PLAY);
        let moved = place - self.place;
        if moved != 0.0 {
            let forward = Some(moved > 0.0);
            if self.forward.is_some() && self.forward != forward {
                self.reversal = Some(self.place);
            }
            self.forward = forward;
        }
        self.place = place;
        (moved.abs(), step.abs() > FAST)
    }
}

#[cfg(test)]
mod tests;
