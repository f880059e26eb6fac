//! Torque balance and motion of a segment against the healthy drive → what is wrong with the signals.
//!
//! ```text
//! v = 1 + (p/n − 1)/(1 − ρ),   e = k σ/(|n| (1 − ρ)),   ρ = σ² σ₀²/(prior² s²)   (1)
//! refused:   v + e < min(1/√2, 1 − w)   or   v − e > max(√2, 1 + w),   w = prior/|n|                      (2)
//! refused:   r outside 1/√2 … √2   or   |r − 1| > 0.06 + 3 s_r                                          (3)
//! refused:   s > 5 σ₀   and   2 R/(1 − c) > E + R                                                       (4)
//! refused:   |v − 1| > 0.1   and   |v − 1| > 3/5 e + w   for 1/Kt                                       (5)
//! refused:   the angle stands while the velocity turns, or in all samples while s > 2 σ₀                (6)
//! refused:   steps ≥ 3   and   steps > samples/2048                                                     (7)
//! ```
//!
//! p is J/Kt or 1/Kt with deviation σ, n its nominal value, s² the variance of the residual, and σ₀² that of healthy
//! ones. (1) removes the contribution of the prior to p: a tight prior would keep p near n although the signals are
//! wrong. √2 is the geometric mean of 1 and 2, the errors of a right signal and of one at half or double the sampling
//! rate; the prior is three healthy deviations. A defect of a bearing changes friction, but not J/Kt and 1/Kt. If the
//! ratio r of velocity and angle with its deviation `s_r` ([`TravelSums`](crate::signal::TravelSums)) is wrong, so is
//! the velocity, whatever the balance. An offset of one deviation of its noise is at most 1/12 of the slowest velocity
//! (3). R is the sum of squares of the residual, E that of the current which the terms explain, and c the part of the
//! rows that the terms fit by chance. A current that was transformed at another angle than that of the rotor (pole
//! pairs, phase order, electrical offset) follows neither motion nor load, while a defect adds friction, which the
//! terms explain, and pulses far below the current of the load (4). A load that is not measured may be most of the
//! current, and may change the estimate of the inertia by more than its deviation: without a measured load, (2) only
//! finds wrong signs, and (4) is not applied. There the nominal parameters are also compared with their negatives
//! ([`is_opposed`](super::balance::Estimated::is_opposed)).
//!
//! A gain of all currents, of the load, or of the magnet that changes by a fifth is below the limits of (2), but looks
//! like friction. (5) refuses it where the torque constants of training scatter less. Its error is smaller than that of
//! (2): the residual already contains what the wrong gain leaves.
//!
//! Of an angle that never changes and a velocity made of it (6), the balance explains the mean of the current and what
//! follows the load; a shaft that is held against a load that is not measured looks alike, and has no verdict either.
//! A step is a change of the angle's motion from one sample to the next beyond
//! [`TorqueBalance::largest_change_rad`](super::balance::TorqueBalance), and beyond twice that by which the present
//! current moves the inertia: its sample is refused, and many of them are rows that are lost (7).
//!
//! Not found are a wrong sign without a load if the load that was not measured explains the current of training better
//! than the motion does; scales and rates that are wrong by less than √2, or by less than the healthy values of the
//! model spread; wrong signals of a shaft at constant speed under constant load; wrong scales without a measured load,
//! except by (3); and wrong signals of a plan without a shaft.

use super::balance::{Friction, Parameter, TERMS, TorqueBalance};
use crate::reason::FrictionTerm;
use crate::reason::Implausible::{
    self, AngleSteps, Current, CurrentScale, CurrentSign, LoadScale, LoadSign, MotionScale, MotionSign, Scale, Sign,
    VelocityScale, VelocitySign,
};
use crate::signal::TravelSums;

/// k of (1): the deviation is computed for independent residuals, which those of a real shaft are not.
const DEVIATIONS: f32 = 5.0;
/// Deviations of a healthy residual, for (4), and of a shaft that rests, for (6).
const UNUSUAL: f32 = 5.0;
const ALIVE: f32 = 2.0;
/// The error of the velocity (3) that its offset may be, besides three deviations.
const VELOCITY_OFF: f32 = 0.06;
/// The limits of (5): twice what a magnet of the field loses, and deviations of the estimate.
const OFF: f32 = 0.1;
const OFF_DEVIATIONS: f32 = 3.0;
/// Fewest steps of (7), and samples for each beyond them.
const FEWEST_STEPS: u32 = 3;
const SAMPLES_A_STEP: u32 = 2048;
const LOW: f32 = core::f32::consts::FRAC_1_SQRT_2;
const HIGH: f32 = core::f32::consts::SQRT_2;

/// Samples seen and used in a segment, the bits of all motions of the angle, and steps that no motor makes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Usage {
    pub(super) seen: u32,
    pub(super) used: u32,
    pub(super) steps: u32,
    pub(super) moved: u32,
}

/// The result of (2) for a parameter; an index of [`CAUSES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fit {
    /// Within 1/√2 … √2 with its error.
    Plausible,
    Above,
    Below,
    Negative,
    Unknown,
}

/// What explains inertia (row) and torque constant (column) together, in the order of [`Fit`].
const CAUSES: [[Option<Implausible>; 5]; 5] = [
    [None, Some(LoadScale), Some(LoadScale), Some(LoadSign), None],
    [Some(MotionScale), Some(CurrentScale), Some(Scale), Some(Sign), Some(Scale)],
    [Some(MotionScale), Some(Scale), Some(CurrentScale), Some(Sign), Some(Scale)],
    [Some(MotionSign), Some(Sign), Some(Sign), Some(CurrentSign), Some(Sign)],
    [None, Some(Scale), Some(Scale), Some(Sign), None],
];

impl Fit {
    /// (2)
    fn of(parameter: Parameter, nominal: f32, prior: f32, spread: f32) -> Self {
        let Some((value, error)) = estimate(parameter, nominal, prior, spread) else { return Self::Unknown };
        let width = (prior / nominal).abs();
        let (low, high) = (value - error, value + error);
        if high < LOW.min(1.0 - width) {
            if high < 0.0 { Self::Negative } else { Self::Below }
        } else if low > HIGH.max(1.0 + width) {
            Self::Above
        } else if low > LOW && high < HIGH {
            Self::Plausible
        } else {
            Self::Unknown
        }
    }
}

/// v and e of (1); `spread` is s²/σ₀². `None` if the rows say too little.
#[inline(never)]
fn estimate(parameter: Parameter, nominal: f32, prior: f32, spread: f32) -> Option<(f32, f32)> {
    let ratio = parameter.deviation / prior;
    let left = 1.0 - ratio * ratio / spread;
    // Written so that a value that is not a number is not determined.
    let determined = left > 0.5 && nominal != 0.0;
    let value = 1.0 + (parameter.value / nominal - 1.0) / left; // (1)
    determined.then(|| (value, (DEVIATIONS * parameter.deviation / (left * nominal)).abs()))
}

/// (5)
fn is_off(parameter: Parameter, nominal: f32, prior: f32, spread: f32) -> bool {
    estimate(parameter, nominal, prior, spread).is_some_and(|(value, error)| {
        let limit = OFF_DEVIATIONS / DEVIATIONS * error + (prior / nominal).abs();
        (value - 1.0).abs() > limit.max(OFF)
    })
}

/// What is wrong with the velocity or the angle by the motion alone.
#[inline(never)]
pub fn of_motion(travel: &TravelSums, interval_s: f32, usage: &Usage) -> Option<Implausible> {
    if usage.steps >= FEWEST_STEPS && usage.steps > usage.seen / SAMPLES_A_STEP {
        return Some(AngleSteps); // (7)
    }
    let ratio = travel.ratio(interval_s)?;
    if ratio < 0.0 {
        return Some(VelocitySign);
    }
    let within = (ratio - 1.0).abs() <= VELOCITY_OFF + OFF_DEVIATIONS * travel.deviation(interval_s);
    (!within || !(LOW..=HIGH).contains(&ratio)).then_some(VelocityScale) // (3)
}

/// Whether the current changes while the angle does not (6).
pub fn is_stuck(balance: &TorqueBalance, friction: &Friction, usage: &Usage) -> bool {
    let alive = ALIVE * balance.deviation;
    usage.used > 0 && usage.moved == 0 && friction.variance > alive * alive
}

/// What is wrong with the signals of a torque balance; `explained` is E/R.
#[inline(never)]
pub fn of_balance(balance: &TorqueBalance, friction: &Friction, explained: f32) -> Option<Implausible> {
    let unusual = UNUSUAL * balance.deviation;
    let left = 1.0 - balance.row_spread * TERMS as f32 / friction.rows as f32;
    let inverse = friction.parameter(FrictionTerm::InverseTorqueConstant);
    let loaded = inverse.is_some();
    if loaded && friction.variance > unusual * unusual && (explained + 1.0) * left < 2.0 {
        return Some(Current); // (4)
    }
    let ([n0, _, _, n3, ..], [w0, _, _, w3, ..]) = (balance.nominal, balance.prior);
    let spread = friction.variance / (balance.deviation * balance.deviation);
    let inertia = Fit::of(friction.inertia, n0, w0, spread);
    let inertia = if loaded || inertia == Fit::Negative { inertia } else { Fit::Unknown };
    let torque = inverse.map_or(Fit::Unknown, |parameter| Fit::of(parameter, n3, w3, spread));
    let cause = CAUSES.get(inertia as usize).and_then(|row| row.get(torque as usize)).copied().flatten();
    let off = || inverse.is_some_and(|parameter| is_off(parameter, n3, w3, spread));
    cause.or_else(|| off().then_some(Implausible::TorqueConstant))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaft::LoadTerms;
    use crate::signal::Travel;

    /// A measured load with this 1/Kt.
    fn loaded(inverse_torque_constant: Parameter) -> LoadTerms {
        LoadTerms::Measured { inverse_torque_constant, load_friction: Parameter::NONE }
    }

    /// With a nominal value of 2 and a prior of 0.2; a deviation of 0.02 leaves 0.99 to the rows.
    fn fit(value: f32, deviation: f32) -> Fit {
        let [one, other] = [1.0, -1.0].map(|sign| {
            let parameter = Parameter { value: sign * value, deviation, score: 0.0 };
            Fit::of(parameter, sign * 2.0, 0.2, 1.0)
        });
        assert_eq!(one, other, "a negative nominal value");
        one
    }

    #[test]
    fn a_parameter_is_refused_beyond_its_limits_only() {
        // v ± e of (1): 1 + (p/2 − 1)/0.99 ± 0.0505.
        let cases = [(2.0, Fit::Plausible), (4.0, Fit::Above), (1.0, Fit::Below), (-2.0, Fit::Negative)];
        assert_eq!(cases.map(|(value, _)| fit(value, 0.02)), cases.map(|(_, fit)| fit));
        // 0.707 and 1.414 with their errors.
        assert_eq!(
            [1.30, 1.33, 2.91, 2.95].map(|p| fit(p, 0.02)),
            [Fit::Below, Fit::Unknown, Fit::Unknown, Fit::Above]
        );
        assert_eq!([0.15, 0.3, f32::NAN].map(|deviation| fit(-2.0, deviation)), [Fit::Unknown; 3]);
        let zero = Parameter { value: -2.0, deviation: 0.02, score: 0.0 };
        assert_eq!(Fit::of(zero, 0.0, 0.2, 1.0), Fit::Unknown);
        // A model whose healthy values spread by 0.6 about 2 knows no limit at √2, but 1.6.
        for sign in [1.0, -1.0] {
            let spread = |value: f32| {
                Fit::of(Parameter { value: sign * value, deviation: 0.02, score: 0.0 }, sign * 2.0, 1.2, 1.0)
            };
            assert_eq!(
                [0.6, 1.0, 3.1, 3.5, -1.0].map(spread),
                [Fit::Below, Fit::Unknown, Fit::Unknown, Fit::Above, Fit::Negative],
                "{sign}"
            );
        }
    }

    #[test]
    fn what_the_prior_contributes_is_removed() {
        // Rows alone say −2 ± 0.02, the prior 2 ± 0.02: together 0 ± 0.014, half of it from the prior.
        let half = Parameter { value: 0.08, deviation: 0.0138, score: 0.0 };
        assert_eq!(Fit::of(half, 2.0, 0.02, 1.0), Fit::Negative);
    }

    /// The sums of blocks of 16 samples and 1/8 turn, with these ratios of the velocity.
    fn travelled(blocks: u32, ratio: impl Fn(u32) -> f32) -> TravelSums {
        let (mut travel, mut sums) = (Travel::default(), TravelSums::default());
        for k in 0..blocks {
            for _ in 0..16 {
                let _ = travel.step(1 << 25, ratio(k) * core::f32::consts::FRAC_PI_4 / 16.0);
            }
            travel.close(&mut sums, 0.0);
        }
        sums
    }

    #[test]
    fn the_velocity_is_that_of_the_angle() {
        let of = |sums: &TravelSums| of_motion(sums, 1.0, &Usage::default());
        let of_ratio = |ratio: f32| of(&travelled(100, |_| ratio));
        assert_eq!(of(&TravelSums::default()), None);
        assert_eq!([1.0, 0.941, 1.059].map(of_ratio), [None; 3]);
        assert_eq!([0.939, 1.061, 0.7153, 0.5, 2.0].map(of_ratio), [Some(VelocityScale); 5]);
        assert_eq!([-1.0, f32::NAN].map(of_ratio), [Some(VelocitySign), Some(VelocityScale)]);
        // 100 blocks of 0.72 ± 1 have a deviation of 0.1: only beyond √2 nothing explains them.
        let scattered = |ratio: f32| of(&travelled(100, |k| ratio + if k % 2 == 0 { 1.0 } else { -1.0 }));
        assert_eq!([0.72, 1.35, 0.70, 1.42].map(scattered), [None, None, Some(VelocityScale), Some(VelocityScale)]);
    }

    #[test]
    fn an_angle_that_stands_and_many_steps_are_refused() {
        let balance = TorqueBalance { deviation: 1.0, ..crate::shaft::state::tests::balance() };
        let stuck = |variance, moved, used| {
            is_stuck(
                &balance,
                &Friction { variance, ..Friction::default() },
                &Usage { moved, used, ..Usage::default() },
            )
        };
        assert_eq!(
            [stuck(4.1, 0, 9), stuck(3.9, 0, 9), stuck(4.1, 1, 9), stuck(4.1, 0, 0)],
            [true, false, false, false]
        );
        let stepped = |steps, seen| of_motion(&travelled(9, |_| 1.0), 1.0, &Usage { steps, seen, ..Usage::default() });
        let steps = Some(AngleSteps);
        assert_eq!([stepped(2, 9), stepped(3, 9), stepped(3, 8000), stepped(4, 8191)], [None, steps, None, steps]);
    }

    #[test]
    fn inertia_and_torque_constant_name_the_signal() {
        // The usual residual is the unit of the deviations: one of any size with its residual tells the same.
        [1.0, 0.1].into_iter().for_each(names_the_signal);
    }

    fn names_the_signal(deviation: f32) {
        let balance = TorqueBalance {
            nominal: [2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0],
            prior: [0.2; 7],
            deviation,
            ..crate::shaft::state::tests::balance()
        };
        let parameter = |value| Parameter { value, deviation: 0.02, score: 0.0 };
        let cause = |inertia, torque: Option<f32>| {
            let (inertia, load) =
                (parameter(inertia), torque.map_or(LoadTerms::Unknown, |value| loaded(parameter(value))));
            let variance = deviation * deviation;
            of_balance(&balance, &Friction { inertia, load, variance, ..Friction::default() }, 10.0)
        };
        assert_eq!(cause(2.0, Some(2.0)), None);
        assert_eq!([cause(2.0, Some(-2.0)), cause(-2.0, Some(-2.0))], [Some(LoadSign), Some(CurrentSign)]);
        assert_eq!([cause(-2.0, Some(2.0)), cause(-2.0, None)], [Some(MotionSign), Some(Sign)]);
        assert_eq!([cause(4.0, Some(4.0)), cause(1.0, Some(1.0))], [Some(CurrentScale); 2]);
        assert_eq!([cause(2.0, Some(4.0)), cause(4.0, Some(2.0))], [Some(LoadScale), Some(MotionScale)]);
        assert_eq!([cause(0.5, Some(4.0)), cause(4.0, None), cause(2.0, None)], [Some(Scale), None, None]);
        // w is 0.1, three deviations 0.03.
        let off = Some(Implausible::TorqueConstant);
        assert_eq!([2.25, 2.28, 1.75, 1.72].map(|inverse| cause(2.0, Some(inverse))), [None, off, None, off]);
    }

    #[test]
    fn a_current_that_nothing_explains_is_refused_if_the_residual_is_unusual() {
        let balance = TorqueBalance { deviation: 1.0, ..crate::shaft::state::tests::balance() };
        let load = loaded(Parameter { value: 0.0, deviation: f32::INFINITY, score: 0.0 });
        let cause = |variance, explained, load| {
            let friction = Friction { variance, load, rows: 1_000_000, ..Friction::default() };
            of_balance(&balance, &friction, explained) == Some(Current)
        };
        assert_eq!([cause(26.0, 0.9, load), cause(24.0, 0.9, load), cause(26.0, 1.1, load)], [true, false, false]);
        assert!(!cause(26.0, 0.9, LoadTerms::Unknown), "the load may be most of the current");
        // Seven terms fit half of fourteen independent rows by chance.
        let balance = TorqueBalance { row_spread: 1.0, ..balance };
        let cause = |explained| {
            let friction = Friction { variance: 26.0, rows: 14, load, ..Friction::default() };
            of_balance(&balance, &friction, explained) == Some(Current)
        };
        assert_eq!([cause(2.9), cause(3.1)], [true, false]);
    }
}
