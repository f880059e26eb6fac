//! Estimates → features.
//!
//! Enters: the parameters of the regression with their residual variance, and the estimate of the shaft. Leaves: the
//! chosen features, in order.
//!
//! Raw parameters a, b, c and physical constants are affine combinations of these features; the projection forms them.
//! The cube root of a mean of squares is nearly normal (Wilson and Hilferty 1931), as discriminant and gate assume.

use crate::estimate::Estimate;
use crate::plan::{Layout, Plan};
use crate::reason::{FrictionTerm, Reason};
use crate::shaft::ShaftEstimate;

/// Smaller amplitudes count as this value, A.
const LEAST_AMPLITUDE: f32 = 1e-6;

/// A number of the estimates that a classifier uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Feature {
    /// A δ-parameter of the regression, by its place.
    Parameter(u8),
    /// ln σ² of the regression's residual.
    LogVariance,
    /// A parameter of the torque balance.
    Friction(FrictionTerm),
    /// Its distance from nominal in its standard deviations.
    FrictionScore(FrictionTerm),
    /// ln of the residual variance of the torque balance.
    LogFrictionVariance,
    /// Cube root of the prominence of a bearing order, by its place.
    OrderProminence(u8),
    /// ln of the amplitude of a bearing order, of at least 1e-6.
    LogOrderAmplitude(u8),
}

impl Feature {
    /// The value of the feature.
    ///
    /// # Errors
    /// The reason why the part that it belongs to has no result.
    #[inline(never)]
    pub fn value<P: Plan>(
        self,
        plan: P,
        estimate: Option<&Estimate<P>>,
        shaft: Option<&ShaftEstimate<P>>,
    ) -> Result<f32, Reason> {
        // Known at compile time: a plan carries no code for features of parts that it does not have.
        let shaft = if plan.layout().shaft.is_some() { shaft } else { None };
        let estimate = if plan.layout().regression.is_some() { estimate } else { None };
        let order = |place: u8| {
            let order = shaft.and_then(|shaft| shaft.orders().get(place as usize)).copied();
            order.unwrap_or_default()
        };
        let reason = match self {
            Self::Parameter(_) | Self::LogVariance => estimate.and_then(|estimate| estimate.reason),
            Self::Friction(_) | Self::FrictionScore(_) | Self::LogFrictionVariance => {
                shaft.and_then(|shaft| shaft.friction_reason)
            }
            Self::OrderProminence(_) | Self::LogOrderAmplitude(_) => shaft.and_then(|shaft| shaft.orders_reason),
        };
        if let Some(reason) = reason {
            return Err(reason);
        }
        let term = |term| shaft.and_then(|shaft| shaft.friction.parameter(term)).unwrap_or_default();
        let none = shaft.is_none();
        let value = match self {
            Self::Parameter(place) => estimate.and_then(|e| e.delta().get(place as usize)).copied().unwrap_or(0.0),
            Self::LogVariance => ln(estimate.map_or(0.0, |estimate| estimate.variance)),
            _ if none => 0.0,
            Self::Friction(name) => term(name).value,
            Self::FrictionScore(name) => term(name).score,
            Self::LogFrictionVariance => ln(shaft.map_or(0.0, |shaft| shaft.friction.variance)),
            Self::OrderProminence(place) => libm::expf(ln(order(place).prominence) / 3.0),
            Self::LogOrderAmplitude(place) => ln(order(place).amplitude.max(LEAST_AMPLITUDE)),
        };
        Ok(value)
    }

    /// Whether a layout has this feature.
    #[must_use]
    pub const fn exists(self, layout: &Layout) -> bool {
        match (self, &layout.shaft) {
            (Self::Parameter(place), _) => (place as usize) < layout.parameters(),
            (Self::LogVariance, _) => layout.regression.is_some(),
            (_, None) => false,
            (Self::Friction(term) | Self::FrictionScore(term), Some(shaft)) => {
                shaft.load.is_some() || !matches!(term, FrictionTerm::InverseTorqueConstant)
            }
            (Self::LogFrictionVariance, Some(_)) => true,
            (Self::OrderProminence(place) | Self::LogOrderAmplitude(place), Some(shaft)) => place < shaft.orders,
        }
    }
}

/// A perfect fit has no logarithm; the smallest normal number replaces it.
fn ln(x: f32) -> f32 {
    libm::logf(x.max(f32::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Memory, Method, RunTime, ShaftLayout, Signal, Structure, testing};
    use crate::shaft::{OrderStrength, Parameter};
    use std::vec;

    fn plan() -> RunTime {
        let plain = testing::regression(Structure::new(1, 1, 1, 1, 1), Method::LeastSquares, Memory::Segment).layout();
        let signal = Signal::channel;
        let shaft = ShaftLayout {
            current: signal(0),
            velocity: signal(1),
            reference: signal(1),
            load: None,
            orders: 2,
            harmonics: 3,
        };
        RunTime::of(Layout { shaft: Some(shaft), ..plain }).unwrap()
    }

    #[test]
    fn parameters_and_variance_of_the_regression() {
        let mut estimate = Estimate::empty(plan());
        assert_eq!(Feature::Parameter(0).value(plan(), Some(&estimate), None), Err(estimate.reason.unwrap()));
        (estimate.delta, estimate.variance, estimate.reason) = (vec![0.5, 2.0, 3.0], 0.0, None);
        assert_eq!(Feature::Parameter(2).value(plan(), Some(&estimate), None), Ok(3.0));
        assert!(Feature::LogVariance.value(plan(), Some(&estimate), None).unwrap().is_finite());
    }

    #[test]
    fn the_shaft_or_its_reason() {
        let mut shaft = ShaftEstimate::empty(plan());
        shaft.friction_reason = Some(Reason::TermNotExcited(FrictionTerm::Inertia));
        let value = |feature: Feature, shaft: &ShaftEstimate<RunTime>| feature.value(plan(), None, Some(shaft));
        let drag = Feature::FrictionScore(FrictionTerm::Drag);
        assert_eq!(value(drag, &shaft), Err(Reason::TermNotExcited(FrictionTerm::Inertia)));
        (shaft.friction_reason, shaft.orders_reason) = (None, None);
        shaft.friction.drag = Parameter { value: 1.0, deviation: 0.5, score: 8.0 };
        shaft.orders = vec![OrderStrength::default(), OrderStrength { prominence: 27.0, amplitude: 0.0 }];
        assert_eq!(value(drag, &shaft), Ok(8.0));
        // A logarithm and an exponential near three, and the least amplitude.
        assert!((value(Feature::OrderProminence(1), &shaft).unwrap() - 3.0).abs() < 1e-6);
        assert!((value(Feature::LogOrderAmplitude(1), &shaft).unwrap() + 13.815_511).abs() < 1e-5);
    }

    #[test]
    fn only_what_the_layout_estimates_exists() {
        let layout = plan().layout();
        assert!(Feature::Parameter(2).exists(&layout) && !Feature::Parameter(3).exists(&layout));
        assert!(Feature::OrderProminence(1).exists(&layout) && !Feature::OrderProminence(2).exists(&layout));
        assert!(!Feature::Friction(FrictionTerm::InverseTorqueConstant).exists(&layout), "no load is measured");
        let without = Layout { shaft: None, ..layout };
        assert!(Feature::LogVariance.exists(&without) && !Feature::LogFrictionVariance.exists(&without));
    }
}
