//! Torque balance and motion of a segment against the healthy drive → what is wrong with the signals.
//!
//! ```text
//! implausible:   p + k σ < n − w₋   or   p − k σ > n + w₊,   n ± w: [n/√2, √2 n], or n ± prior if that is wider  (1)
//!                velocity/angle outside 1/√2 … √2                                                               (2)
//!
//! J/Kt  \  1/Kt    plausible     beyond a limit   negative       not determined
//! plausible        –             LoadScale        LoadSign       –
//! beyond a limit   MotionScale   CurrentScale     LoadSign       Scale
//! negative         MotionSign    MotionSign       CurrentSign    Sign
//! not determined   –             Scale            Sign           –
//! ```
//!
//! p is J/Kt or 1/Kt with deviation σ, n > 0 its nominal value, else both change their sign. √2 is the geometric mean of
//! a right signal and one that is wrong by two, as at half or double the sampling rate; the prior is three healthy
//! deviations. p is not determined if k σ exceeds w. A defect of a bearing changes friction, not J/Kt and 1/Kt. The
//! ratio (2), of [`Travel`](crate::drive::travel), names the velocity whatever the balance.
//!
//! Not seen: a rate that is wrong by less than √2; signals of a shaft that turns at constant speed under constant load,
//! except for (2); the load in a plan that does not measure it; all signals of a plan without a shaft.

use super::balance::Balance;
use super::friction::{Friction, Parameter};
use crate::reason::Implausible;

/// k of (1): the deviation takes the residuals of the rows as independent, which those of a real shaft are not.
const DEVIATIONS: f32 = 5.0;
/// 1 − 1/√2 and √2 − 1.
const BELOW: f32 = 1.0 - core::f32::consts::FRAC_1_SQRT_2;
const ABOVE: f32 = core::f32::consts::SQRT_2 - 1.0;

/// What (1) says of a parameter; a number, since it is the place in the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fit {
    Plausible,
    Beyond,
    Negative,
    Unknown,
}

impl Fit {
    fn of(parameter: Parameter, nominal: f32, prior: f32) -> Self {
        let sign = if nominal < 0.0 { -1.0 } else { 1.0 };
        let (value, nominal) = (sign * parameter.value, sign * nominal);
        let error = DEVIATIONS * parameter.deviation;
        let (below, above) = (prior.max(BELOW * nominal), prior.max(ABOVE * nominal));
        let (low, high) = (value - error, value + error);
        if high < nominal - below {
            if high < 0.0 { Self::Negative } else { Self::Beyond }
        } else if low > nominal + above {
            Self::Beyond
        } else if error <= below {
            Self::Plausible
        } else {
            Self::Unknown
        }
    }
}

/// What is wrong with the signals of a segment; `None` if nothing is, or nothing is known. `friction` is `None` without
/// a torque balance, `ratio` without enough motion.
#[inline(never)]
pub fn implausible(balance: &Balance, friction: Option<&Friction>, ratio: Option<f32>) -> Option<Implausible> {
    if let Some(ratio) = ratio {
        if ratio < 0.0 {
            return Some(Implausible::VelocitySign);
        }
        if !(1.0 - BELOW..=1.0 + ABOVE).contains(&ratio) {
            return Some(Implausible::VelocityScale);
        }
    }
    let friction = friction?;
    let ([n0, _, _, n3, ..], [w0, _, _, w3, ..]) = (balance.nominal, balance.prior);
    let inertia = Fit::of(friction.inertia, n0, w0);
    let torque = friction.inverse_torque_constant.map_or(Fit::Unknown, |own| Fit::of(own, n3, w3));
    match (inertia, torque) {
        (Fit::Plausible, Fit::Plausible | Fit::Unknown) | (Fit::Unknown, Fit::Plausible | Fit::Unknown) => None,
        (Fit::Negative, Fit::Negative) => Some(Implausible::CurrentSign),
        (Fit::Negative, Fit::Unknown) | (Fit::Unknown, Fit::Negative) => Some(Implausible::Sign),
        (Fit::Negative, _) => Some(Implausible::MotionSign),
        (_, Fit::Negative) => Some(Implausible::LoadSign),
        (Fit::Beyond, Fit::Beyond) => Some(Implausible::CurrentScale),
        (Fit::Beyond, Fit::Unknown) | (Fit::Unknown, Fit::Beyond) => Some(Implausible::Scale),
        (Fit::Beyond, Fit::Plausible) => Some(Implausible::MotionScale),
        (Fit::Plausible, Fit::Beyond) => Some(Implausible::LoadScale),
    }
}
