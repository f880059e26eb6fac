//! Estimates → feature vector.
//!
//! Enters: the parameters, their residual variance, and what the shaft says. Leaves: the chosen features, in order.
//!
//! | index | feature |
//! |---|---|
//! | k < n | δ-parameter k of n |
//! | n | ln σ² of the regression's residual |
//! | 128 + k | parameter k of the torque balance: J/Kt, B/Kt, Tc/Kt, 1/Kt, offset, drag ([`Friction`](crate::Friction)) |
//! | 136 + k | its score: distance from nominal in standard deviations of this segment |
//! | 144 | ln of the balance's residual variance |
//! | 160 + k | cube root of the prominence of order k ([`OrderStrength`](crate::OrderStrength)) |
//! | 192 + k | ln of the amplitude of order k, of at least 1e-6 |
//!
//! Raw parameters a, b, c, grey-box quantities and scores are affine combinations, done by the projection. The cube root makes a mean
//! of squares nearly normal (Wilson and Hilferty 1931), which the discriminant and the gate count on.

use crate::estimate::{Estimate, FRICTION_PARAMETERS, Reason, ShaftEstimate};

/// First index of the shaft's features.
pub const SHAFT_FEATURES: u8 = 128;
const SCORES: u8 = 136;
const BALANCE_VARIANCE: u8 = 144;
const PROMINENCES: u8 = 160;
const AMPLITUDES: u8 = 192;
/// Orders that have an index.
const MAX_ORDERS: u8 = 32;
/// Amplitudes below this are zero to a drive.
const LEAST_AMPLITUDE: f32 = 1e-6;

/// Which features are used: at most `F`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Features<const F: usize> {
    /// Indices as in the table above.
    pub index: [u8; F],
    /// Features in use.
    pub count: u8,
}

impl<const F: usize> Features<F> {
    /// Picks the features; places not in use are zero.
    ///
    /// # Errors
    /// Where a feature of the shaft is asked for that says nothing, its reason; [`Reason::TooFewRows`] where no shaft is watched.
    pub fn extract<const M: usize, const P: usize, const K: usize>(
        &self,
        estimate: &Estimate<M, P>,
        shaft: Option<&ShaftEstimate<K>>,
    ) -> Result<[f32; F], Reason> {
        let n = estimate.parameters();
        let mut out = [0.0; F];
        for (cell, &index) in out.iter_mut().zip(&self.index).take(self.count as usize) {
            *cell = if index >= SHAFT_FEATURES {
                // Known when compiling: what watches no shaft carries none of this.
                if K == 0 {
                    return Err(Reason::TooFewRows);
                }
                let shaft = shaft.ok_or(Reason::TooFewRows)?;
                let reason = if index >= PROMINENCES { shaft.orders_reason } else { shaft.reason };
                reason.map_or(Ok(()), Err)?;
                of_shaft(shaft, index)
            } else {
                of_regression(&estimate.delta, estimate.variance, (n, index as usize))
            };
        }
        Ok(out)
    }
}

/// Feature `index` of `n` parameters and the variance. Not inlined, where it would be unrolled: flash is dear.
#[inline(never)]
fn of_regression(delta: &[f32], variance: f32, (n, index): (usize, usize)) -> f32 {
    if index == n { ln(variance) } else { delta.get(index).copied().unwrap_or(0.0) }
}

fn of_shaft<const K: usize>(shaft: &ShaftEstimate<K>, index: u8) -> f32 {
    let friction = &shaft.friction;
    let order = |first: u8| shaft.orders.get((index - first) as usize).copied().unwrap_or_default();
    let value = match index {
        AMPLITUDES.. => return libm::logf(order(AMPLITUDES).amplitude.max(LEAST_AMPLITUDE)),
        PROMINENCES.. => return libm::expf(ln(order(PROMINENCES).prominence) / 3.0),
        BALANCE_VARIANCE.. => return ln(friction.variance),
        SCORES.. => friction.scores.get((index - SCORES) as usize),
        _ => friction.parameters.get((index - SHAFT_FEATURES) as usize),
    };
    value.copied().unwrap_or(0.0)
}

/// A perfect fit has no logarithm; the smallest normal number stands for it.
fn ln(x: f32) -> f32 {
    libm::logf(x.max(f32::MIN_POSITIVE))
}

/// Whether there is such a feature in a model of so many parameters, and so many orders where a shaft is watched.
pub(crate) fn exists(index: u8, parameters: usize, orders: Option<u8>) -> bool {
    let Some(orders) = orders.map(|orders| orders.min(MAX_ORDERS)) else {
        return index as usize <= parameters && index < SHAFT_FEATURES;
    };
    let friction = |place: u8| (place as usize) < FRICTION_PARAMETERS;
    match index {
        ..SHAFT_FEATURES => index as usize <= parameters,
        AMPLITUDES.. => index - AMPLITUDES < orders,
        PROMINENCES.. => index - PROMINENCES < orders,
        BALANCE_VARIANCE.. => index == BALANCE_VARIANCE,
        SCORES.. => friction(index - SCORES),
        SHAFT_FEATURES.. => friction(index - SHAFT_FEATURES),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::{Counts, Friction, Order, OrderStrength};

    const ESTIMATE: Estimate<4, 6> = Estimate {
        order: Order::new(1, 1, 1, 1, 1),
        offset: false,
        delta: [0.5, 2.0, 3.0, 0.0],
        covariance: [0.0; 6],
        variance: 1.0,
        rows: 10,
        counts: Counts { rejected: 0, saturated: 0, downweighted: 0, still: 0, stuck: [false; 3], refused: 0 },
        stable: true,
        segment: 0,
    };

    #[test]
    fn picks_parameters_and_log_variance_in_any_order() {
        let features = Features { index: [2, 3, 0, 0], count: 3 };
        let none = None::<&ShaftEstimate<0>>;
        assert_eq!(features.extract(&ESTIMATE, none), Ok([3.0, 0.0, 0.5, 0.0]));
        let perfect = Estimate { variance: 0.0, ..ESTIMATE };
        assert!(features.extract(&perfect, none).unwrap()[1].is_finite());
    }

    #[test]
    fn picks_what_the_shaft_says_or_gives_its_reason() {
        let features = Features { index: [129, 138, 144, 161, 193], count: 5 };
        assert_eq!(features.extract(&ESTIMATE, None::<&ShaftEstimate<2>>), Err(Reason::TooFewRows));
        let silent = ShaftEstimate::<2>::empty(Reason::WeakInstruments);
        assert_eq!(features.extract(&ESTIMATE, Some(&silent)), Err(Reason::WeakInstruments));
        let shaft = ShaftEstimate {
            friction: Friction {
                parameters: [1.0, 2.0, 3.0, 4.0, 5.0, 0.0],
                scores: [6.0, 7.0, 8.0, 9.0, 10.0, 0.0],
                variance: 1.0,
                ..Friction::default()
            },
            orders: [OrderStrength::default(), OrderStrength { prominence: 27.0, amplitude: 0.0 }],
            reason: None,
            orders_reason: None,
            ..silent
        };
        let [viscous, coulomb, variance, prominence, amplitude] = features.extract(&ESTIMATE, Some(&shaft)).unwrap();
        assert_eq!((viscous, coulomb, variance), (2.0, 8.0, 0.0));
        // A logarithm and an exponential near three, and the floor of the amplitude.
        assert!((prominence - 3.0).abs() < 1e-6 && (amplitude - (-13.815_511)).abs() < 1e-5);
        assert!([0, 3, 128, 133, 136, 141, 144, 160, 161, 192].iter().all(|&k| exists(k, 3, Some(2))));
        assert!([4, 127, 134, 142, 145, 162, 194, 255].iter().all(|&k| !exists(k, 3, Some(2))));
        assert!(!exists(128, 3, None) && exists(3, 3, None) && !exists(130, 200, None));
    }
}
