//! Estimates → features.
//!
//! Enters: the parameters of the regression with their residual variance, the estimate of the shaft, and the averages
//! of channels. Leaves: the chosen features, in order, each with the variance of its error; or the reason why a feature
//! is missing.
//!
//! ```text
//! friction p ± σ:   f = p,  v = σ²;     f = ln m,  v = (σ/m)²,  m = max(p, σ)         (1)
//! ```
//!
//! p and σ are those of the rows alone, without the prior of p, which would draw the friction of a defect towards
//! that of healthy drives ([`TorqueBalance::without_prior`]). Where the rows say nothing of it beside its prior, the
//! feature is missing, and so is an order that the shaft has turned too little for. No deviation is known of the
//! other features, and a score is already relative to its deviation: v = 0. The logarithm (1) suits a friction that
//! varies by a factor between drives. Below its standard deviation a value does not differ from zero; it counts as σ,
//! with v = 1. A missing feature has an infinite variance.
//!
//! Raw parameters a, b, c and physical constants are affine combinations of these features; the projection forms them.
//! The cube root of a mean of squares is nearly normal (Wilson and Hilferty 1931), as discriminant and gate assume.

use crate::logarithm::ln_of_level;
use crate::plan::{Layout, Plan};
use crate::reason::{FrictionTerm, Obstacle, Reason};
use crate::record::{Fault, Field, Input, Output};
use crate::regression::estimate::Estimate;
use crate::shaft::{LEAST_FROM_ROWS, ShaftEstimate, TorqueBalance};
use crate::signal::average::Average;

/// The highest kind of a code that this build knows.
const NEWEST: u8 = 9;
/// Smaller amplitudes count as this value, A.
const LEAST_AMPLITUDE: f32 = 1e-6;

/// The results of a segment that features come from: regression, shaft with the constants of its balance, averages of
/// channels.
pub type Estimates<'a, P> = (Option<&'a Estimate<P>>, Option<(&'a ShaftEstimate<P>, &'a TorqueBalance)>, &'a [Average]);

/// A number of the estimates that a classifier uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Feature {
    /// A δ-parameter of the regression, by its index.
    Parameter(u8),
    /// ln σ² of the regression's residual.
    LogVariance,
    /// A parameter of the torque balance.
    Friction(FrictionTerm),
    /// Its distance from nominal in its standard deviations.
    FrictionScore(FrictionTerm),
    /// ln of it, or of its standard deviation where that is larger.
    LogFriction(FrictionTerm),
    /// ln of the residual variance of the torque balance.
    LogFrictionVariance,
    /// Score of a bearing order, by its index.
    OrderScore(u8),
    /// ln of the amplitude of a bearing order, of at least 1e-6.
    LogOrderAmplitude(u8),
    /// Mean of a channel over the segment, by its index in the sample.
    ChannelMean(u8),
    /// Root mean square of a channel over the segment.
    ChannelRms(u8),
}

/// A feature of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FeatureValue {
    /// Its value.
    pub value: f32,
    /// Variance of its error; 0 if none is known, infinite if the feature is missing.
    pub variance: f32,
}

impl FeatureValue {
    /// A feature without a result.
    pub const MISSING: Self = Self { value: 0.0, variance: f32::INFINITY };

    /// Whether there is no result.
    #[must_use]
    pub const fn is_missing(self) -> bool {
        !self.variance.is_finite()
    }

    /// A value without a known error.
    const fn exact(value: f32) -> Self {
        Self { value, variance: 0.0 }
    }

    /// (1); a deviation that is not a number makes the feature missing.
    fn of((value, variance): (f32, f32)) -> Self {
        if variance < f32::INFINITY { Self { value, variance } } else { Self::MISSING }
    }

    /// (1).
    fn ln_of((value, variance): (f32, f32)) -> Self {
        let deviation = libm::sqrtf(variance);
        let least = deviation.max(f32::MIN_POSITIVE);
        let magnitude = if value < least { least } else { value };
        let ratio = deviation / magnitude;
        Self::of((ln_of_level(magnitude), ratio * ratio))
    }
}

impl Feature {
    /// Kind and index, as models and identities have them.
    pub(crate) const fn code(self) -> [u8; 2] {
        match self {
            Self::Parameter(index) => [0, index],
            Self::LogVariance => [1, 0],
            Self::Friction(term) => [2, term as u8],
            Self::FrictionScore(term) => [3, term as u8],
            Self::LogFrictionVariance => [4, 0],
            Self::OrderScore(index) => [5, index],
            Self::LogOrderAmplitude(index) => [6, index],
            Self::LogFriction(term) => [7, term as u8],
            Self::ChannelMean(channel) => [8, channel],
            Self::ChannelRms(channel) => [9, channel],
        }
    }

    /// The feature of a code; `None` if this build does not know its kind, or the kind has no such index.
    pub(crate) fn of_code([kind, index]: [u8; 2]) -> Option<Self> {
        let term = FrictionTerm::ALL.get(index as usize).copied();
        Some(match kind {
            0 => Self::Parameter(index),
            1 => Self::LogVariance,
            2 => Self::Friction(term?),
            3 => Self::FrictionScore(term?),
            4 => Self::LogFrictionVariance,
            5 => Self::OrderScore(index),
            6 => Self::LogOrderAmplitude(index),
            7 => Self::LogFriction(term?),
            8 => Self::ChannelMean(index),
            9 => Self::ChannelRms(index),
            _ => return None,
        })
    }

    /// Appends the code.
    pub(crate) const fn put(self, output: &mut Output<'_>) {
        let [kind, index] = self.code();
        output.u8(kind);
        output.u8(index);
    }

    /// The feature of the next code.
    pub(crate) fn get(input: &mut Input<'_>) -> Self {
        let [kind, index] = input.array();
        Self::of_code([kind, index]).unwrap_or_else(|| {
            let newer = kind > NEWEST;
            input.refuse(if newer { Fault::Newer } else { Fault::OutOfRange(Field::Feature) });
            Self::LogVariance
        })
    }

    /// The term of the torque balance that it measures, if it does.
    pub(crate) const fn friction(self) -> Option<FrictionTerm> {
        match self {
            Self::Friction(term) | Self::FrictionScore(term) | Self::LogFriction(term) => Some(term),
            _ => None,
        }
    }

    /// The index of the bearing order that it measures, if it does.
    pub(crate) const fn order(self) -> Option<u8> {
        match self {
            Self::OrderScore(index) | Self::LogOrderAmplitude(index) => Some(index),
            _ => None,
        }
    }

    /// The feature of a segment.
    ///
    /// # Errors
    /// The feature is missing, since the part that it belongs to has no result for this reason.
    #[inline(never)]
    pub fn value<P: Plan>(
        self,
        plan: P,
        (estimate, shaft, averages): Estimates<'_, P>,
    ) -> Result<FeatureValue, Reason> {
        // Known at compile time: a plan carries no code for features of parts that it does not have.
        let (shaft, balance) = if plan.layout().shaft.is_some() { shaft.unzip() } else { (None, None) };
        let estimate = if plan.layout().regression.is_some() { estimate } else { None };
        let order = |index: u8| {
            let order = shaft.and_then(|shaft| shaft.orders().get(index as usize)).copied();
            order.unwrap_or_default()
        };
        let reason = match self {
            Self::Parameter(_) | Self::LogVariance => estimate.and_then(|estimate| estimate.reason),
            Self::Friction(_) | Self::FrictionScore(_) | Self::LogFriction(_) | Self::LogFrictionVariance => {
                shaft.and_then(|shaft| shaft.friction_reason)
            }
            Self::OrderScore(_) | Self::LogOrderAmplitude(_) => shaft.and_then(|shaft| shaft.orders_reason),
            Self::ChannelMean(_) | Self::ChannelRms(_) => None,
        };
        if let Some(reason) = reason {
            return Err(reason);
        }
        if let Some(reason) = unseen(self, shaft, balance) {
            return Err(reason);
        }
        let term = |term| {
            let pair = shaft.zip(balance);
            pair.map_or((0.0, 0.0), |(shaft, balance)| balance.without_prior(&shaft.friction, term))
        };
        let none = shaft.is_none();
        let averaged = plan.layout().averaged != 0;
        let value = match self {
            Self::Parameter(index) => estimate.and_then(|e| e.delta().get(index as usize)).copied().unwrap_or(0.0),
            Self::LogVariance => ln_of_level(estimate.map_or(0.0, |estimate| estimate.variance)),
            Self::ChannelMean(channel) if averaged => return channel_value(averages, channel, Average::mean),
            Self::ChannelRms(channel) if averaged => return channel_value(averages, channel, Average::rms),
            Self::ChannelMean(_) | Self::ChannelRms(_) => 0.0,
            _ if none => 0.0,
            Self::Friction(name) => return Ok(FeatureValue::of(term(name))),
            Self::LogFriction(name) => return Ok(FeatureValue::ln_of(term(name))),
            Self::FrictionScore(name) => {
                shaft.and_then(|shaft| shaft.friction.of(name)).map_or(0.0, |parameter| parameter.score)
            }
            Self::LogFrictionVariance => ln_of_level(shaft.map_or(0.0, |shaft| shaft.friction.variance)),
            Self::OrderScore(index) => order(index).score,
            Self::LogOrderAmplitude(index) => ln_of_level(order(index).amplitude.max(LEAST_AMPLITUDE)),
        };
        Ok(FeatureValue::exact(value))
    }

    /// Whether a layout has this feature.
    #[must_use]
    pub const fn exists(self, layout: &Layout) -> bool {
        match (self, &layout.shaft) {
            (Self::Parameter(index), _) => (index as usize) < layout.parameters(),
            (Self::LogVariance, _) => layout.regression.is_some(),
            (Self::ChannelMean(channel) | Self::ChannelRms(channel), _) => {
                channel < 16 && (layout.averaged >> channel) & 1 == 1
            }
            (_, None) => false,
            (Self::Friction(term) | Self::FrictionScore(term) | Self::LogFriction(term), Some(shaft)) => {
                shaft.load.measured().is_some() || !term.needs_load()
            }
            (Self::LogFrictionVariance, Some(_)) => true,
            (Self::OrderScore(index) | Self::LogOrderAmplitude(index), Some(shaft)) => index < shaft.orders,
        }
    }
}

/// Why a feature of the shaft says nothing of this segment, although there is an estimate.
fn unseen<P: Plan>(
    feature: Feature,
    shaft: Option<&ShaftEstimate<P>>,
    balance: Option<&TorqueBalance>,
) -> Option<Reason> {
    let shaft = shaft?;
    if let Some(term) = feature.friction() {
        let known = balance?.part_of_rows(&shaft.friction, term) >= LEAST_FROM_ROWS;
        return (!known).then_some(Reason::TermNotExcited(term));
    }
    let order = shaft.orders().get(feature.order()? as usize)?;
    order.unseen.then_some(Reason::Unseen(Obstacle::TooLittleMotion))
}

/// Mean or root mean square of a channel; missing if it is not finite.
fn channel_value(
    averages: &[Average],
    channel: u8,
    of: fn(&Average) -> Result<f32, Reason>,
) -> Result<FeatureValue, Reason> {
    let average =
        averages.iter().find(|average| average.channel() == channel).ok_or(Reason::LostSamples { channel })?;
    let value = of(average)?;
    Ok(if value.is_finite() { FeatureValue::exact(value) } else { FeatureValue::MISSING })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Load, Memory, Method, RunTime, ShaftLayout, Signal, Structure, testing};
    use crate::shaft::state::tests;
    use crate::shaft::{OrderStrength, Parameter};
    use std::vec;

    /// Without priors.
    fn balance() -> TorqueBalance {
        TorqueBalance { deviation: 0.0, ..tests::balance() }
    }

    fn plan() -> RunTime {
        let plain = testing::regression(Structure::new(1, 1, 1, 1, 1), Method::LeastSquares, Memory::Segment);
        let signal = Signal::channel;
        let shaft = ShaftLayout {
            current: signal(0),
            velocity: Some(signal(1)),
            load: Load::Unknown,
            orders: 2,
            harmonics: 3,
            decimation: 1,
        };
        RunTime::of(Layout { shaft: Some(shaft), ..plain }).unwrap()
    }

    #[test]
    fn parameters_and_variance_of_the_regression() {
        let mut estimate = Estimate::empty(plan());
        assert_eq!(Feature::Parameter(0).value(plan(), (Some(&estimate), None, &[])), Err(estimate.reason.unwrap()));
        (estimate.delta, estimate.variance, estimate.reason) = (vec![0.5, 2.0, 3.0], 0.0, None);
        assert_eq!(Feature::Parameter(2).value(plan(), (Some(&estimate), None, &[])), Ok(FeatureValue::exact(3.0)));
        assert!(Feature::LogVariance.value(plan(), (Some(&estimate), None, &[])).unwrap().value.is_finite());
    }

    #[test]
    fn the_shaft_or_its_reason() {
        let mut shaft = ShaftEstimate::empty(plan());
        shaft.friction_reason = Some(Reason::TermNotExcited(FrictionTerm::Inertia));
        let value = |feature: Feature, shaft: &ShaftEstimate<RunTime>| {
            feature.value(plan(), (None, Some((shaft, &balance())), &[]))
        };
        let drag = Feature::FrictionScore(FrictionTerm::Drag);
        assert_eq!(value(drag, &shaft), Err(Reason::TermNotExcited(FrictionTerm::Inertia)));
        (shaft.friction_reason, shaft.orders_reason) = (None, None);
        shaft.friction.drag = Parameter { value: 1.0, deviation: 0.5, score: 8.0 };
        shaft.orders = vec![OrderStrength::default(), OrderStrength { score: 3.0, ..OrderStrength::default() }];
        assert_eq!(value(drag, &shaft), Ok(FeatureValue::exact(8.0)));
        assert_eq!(value(Feature::OrderScore(1), &shaft), Ok(FeatureValue::exact(3.0)));
        // The least amplitude, by a logarithm.
        assert!((value(Feature::LogOrderAmplitude(1), &shaft).unwrap().value + 13.815_511).abs() < 1e-5);
    }

    #[test]
    fn friction_has_a_variance_and_a_logarithm() {
        let found = |value: f32, deviation: f32| {
            let mut shaft = ShaftEstimate::empty(plan());
            shaft.friction_reason = None;
            shaft.friction.viscous = Parameter { value, deviation, score: 0.0 };
            [Feature::Friction(FrictionTerm::Viscous), Feature::LogFriction(FrictionTerm::Viscous)]
                .map(|feature| feature.value(plan(), (None, Some((&shaft, &balance())), &[])))
        };
        let of = |value: f32, deviation: f32| found(value, deviation).map(Result::unwrap);
        let [plain, log] = of(4.0, 0.5);
        assert_eq!(plain, FeatureValue { value: 4.0, variance: 0.25 });
        assert_eq!(log, FeatureValue { value: libm::logf(4.0), variance: 1.0 / 64.0 });
        for small in [0.25, 0.0, -3.0] {
            assert_eq!(of(small, 0.5)[1], FeatureValue { value: libm::logf(0.5), variance: 1.0 }, "{small}");
        }
        assert_eq!(of(-1.0, 0.0)[1], FeatureValue::exact(libm::logf(f32::MIN_POSITIVE)));
        for deviation in [f32::NAN, f32::INFINITY] {
            assert_eq!(found(4.0, deviation), [Err(Reason::TermNotExcited(FrictionTerm::Viscous)); 2], "{deviation}");
        }
        assert!(of(4.0, 1e30)[0].is_missing());
        // Half of the precision is that of a prior at 3, whose deviation is that of the rows, √½.
        let mut shaft = ShaftEstimate::empty(plan());
        shaft.friction.viscous = Parameter { value: 4.0, deviation: 0.5, score: 2.0 };
        (shaft.friction.variance, shaft.friction_reason) = (1.0, None);
        let viscous = |prior: f32, shaft: &ShaftEstimate<RunTime>| {
            let balance = TorqueBalance { prior: [prior; 7], deviation: 1.0, ..balance() };
            Feature::Friction(FrictionTerm::Viscous).value(plan(), (None, Some((shaft, &balance)), &[]))
        };
        let half = viscous(0.708, &shaft).unwrap();
        // c = 1 − 0.25/0.708² = 0.50125.
        assert!((half.value - 4.994_97).abs() < 1e-4 && (half.variance - 0.498_75).abs() < 1e-4, "{half:?}");
        // c is 0.018, and 0.014: the rows say nothing.
        assert!(viscous(0.504_5, &shaft).is_ok());
        assert_eq!(viscous(0.503_5, &shaft), Err(Reason::TermNotExcited(FrictionTerm::Viscous)));
        // The drag at 20 rad/s of priors of 0.1: (20² + 1² + 1/26²) 0.01 = 4.01.
        shaft.friction.drag = Parameter { value: 4.0, deviation: 1.41, score: 0.0 };
        let drag = |deviation: f32| {
            let balance = TorqueBalance {
                prior: [0.1; 7],
                deviation,
                usual_velocity_rad_s: 20.0,
                usual_load_nm: 0.0,
                stribeck_velocity_rad_s: 4.0,
                ..balance()
            };
            Feature::Friction(FrictionTerm::Drag).value(plan(), (None, Some((&shaft, &balance)), &[]))
        };
        // 1.41² · 1.4² of 4.01 is 97 %, and that of 1.42 all.
        assert!(drag(1.4).is_ok() && drag(1.42).is_err());
    }

    #[test]
    fn an_order_that_the_shaft_has_turned_too_little_for_is_missing() {
        let mut shaft = ShaftEstimate::empty(plan());
        shaft.orders_reason = None;
        shaft.orders = vec![OrderStrength { unseen: true, score: 9.0, ..OrderStrength::default() }; 2];
        for feature in [Feature::OrderScore(1), Feature::LogOrderAmplitude(0)] {
            let value = feature.value(plan(), (None, Some((&shaft, &balance())), &[]));
            assert_eq!(value, Err(Reason::Unseen(Obstacle::TooLittleMotion)));
        }
    }

    #[test]
    fn only_what_the_layout_estimates_exists() {
        let layout = plan().layout();
        assert!(Feature::Parameter(2).exists(&layout) && !Feature::Parameter(3).exists(&layout));
        assert!(Feature::OrderScore(1).exists(&layout) && !Feature::OrderScore(2).exists(&layout));
        assert!(!Feature::Friction(FrictionTerm::InverseTorqueConstant).exists(&layout), "no load is measured");
        let without = Layout { shaft: None, ..layout };
        assert!(Feature::LogVariance.exists(&without) && !Feature::LogFrictionVariance.exists(&without));
    }

    #[test]
    fn a_layout_has_as_many_parameters_as_its_structure() {
        let layout = testing::regression(Structure::new(2, 1, 1, 1, 1), Method::LeastSquares, Memory::Segment);
        assert_eq!(layout.parameters(), 4);
        assert!(Feature::Parameter(3).exists(&layout) && !Feature::Parameter(4).exists(&layout));
    }
}
