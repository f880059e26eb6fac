//! Torque balance and motion of a segment against the healthy drive → what is wrong with the signals.
//!
//! ```text
//! v = 1 + (p/n − 1)/(1 − ρ),   e = k σ/(|n| (1 − ρ)),   ρ = σ² σ₀²/(prior² s²)   (1)
//! refused:   v + e < 1 − max(w, 1 − 1/√2)   or   v − e > 1 + max(w, √2 − 1),   w = prior/|n|             (2)
//! refused:   velocity/angle outside 1/√2 … √2                                                           (3)
//! ```
//!
//! p is J/Kt or 1/Kt with deviation σ, n its nominal value, s² the variance of the residual, and σ₀² that of healthy
//! ones. (1) removes what the prior contributes to p: a tight one would hold it near n whatever the signals say. √2 is
//! the geometric mean of a right signal and one that is wrong by two, as at half or double the sampling rate; the prior
//! is three healthy deviations. A defect of a bearing changes friction, but not J/Kt and 1/Kt. The ratio (3) of
//! [`Travel`](crate::drive::travel) names the velocity whatever the balance.
//!
//! Not seen: scales and rates that are wrong by less than √2, or less than the model's own spread; signals of a shaft
//! at constant speed under constant load, and of one whose load is not measured, except for (3); all signals of a plan
//! without a shaft.

use super::balance::Balance;
use super::friction::{Friction, Parameter};
use crate::reason::Implausible;

/// k of (1): the deviation takes the residuals of the rows as independent, which those of a real shaft are not.
const DEVIATIONS: f32 = 5.0;
const LOW: f32 = core::f32::consts::FRAC_1_SQRT_2;
const HIGH: f32 = core::f32::consts::SQRT_2;

/// What (2) says of a parameter; a place in [`CAUSES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fit {
    /// Within 1/√2 … √2 with its error.
    Plausible,
    Above,
    Below,
    Negative,
    Unknown,
}

use Implausible::{CurrentScale, CurrentSign, LoadScale, LoadSign, MotionScale, MotionSign, Scale, Sign};

/// What explains inertia (row) and torque constant (column) together, in the order of [`Fit`].
const CAUSES: [[Option<Implausible>; 5]; 5] = [
    [None, Some(LoadScale), Some(LoadScale), Some(LoadSign), None],
    [Some(MotionScale), Some(CurrentScale), Some(Scale), Some(Sign), Some(Scale)],
    [Some(MotionScale), Some(Scale), Some(CurrentScale), Some(Sign), Some(Scale)],
    [Some(MotionSign), Some(Sign), Some(Sign), Some(CurrentSign), Some(Sign)],
    [None, Some(Scale), Some(Scale), Some(Sign), None],
];

impl Fit {
    /// (2); `spread` is s²/σ₀².
    #[inline(never)]
    fn of(parameter: Parameter, nominal: f32, prior: f32, spread: f32) -> Self {
        let ratio = parameter.deviation / prior;
        let left = 1.0 - ratio * ratio / spread;
        // Also if it is not a number, as without a nominal value.
        if !(left > 0.5) || nominal == 0.0 {
            return Self::Unknown;
        }
        let value = 1.0 + (parameter.value / nominal - 1.0) / left; // (1)
        let error = (DEVIATIONS * parameter.deviation / (left * nominal)).abs();
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

/// What is wrong with the velocity; `ratio` is `None` without enough motion.
#[inline(always)]
pub fn of_motion(ratio: Option<f32>) -> Option<Implausible> {
    let ratio = ratio?;
    if ratio < 0.0 {
        return Some(Implausible::VelocitySign);
    }
    let agrees = (LOW..=HIGH).contains(&ratio); // (3)
    (!agrees).then_some(Implausible::VelocityScale)
}

/// What is wrong with the signals of a torque balance.
#[inline(never)]
pub fn of_balance(balance: &Balance, friction: &Friction) -> Option<Implausible> {
    let ([n0, _, _, n3, ..], [w0, _, _, w3, ..]) = (balance.nominal, balance.prior);
    let spread = friction.variance / (balance.deviation * balance.deviation);
    let inertia = Fit::of(friction.inertia, n0, w0, spread);
    let torque = friction.inverse_torque_constant.map_or(Fit::Unknown, |own| Fit::of(own, n3, w3, spread));
    CAUSES.get(inertia as usize).and_then(|row| row.get(torque as usize)).copied().flatten()
}
