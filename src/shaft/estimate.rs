//! What a segment says of the shaft, and what its signals say against each other.

use super::balance::Friction;
use super::orders::OrderStrength;
use super::plausibility;
use super::state::{ShaftConstants, ShaftSums, has_load};
use crate::plan::{Array, Cells, ShaftLengths};
use crate::reason::{Implausible, Part, Reason};

/// The shaft in one segment.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftEstimate<P: ShaftLengths> {
    /// Torque balance; zeros if there is a reason.
    pub friction: Friction,
    /// Why there is no torque balance.
    pub friction_reason: Option<Reason>,
    pub(crate) orders: Array<P::Orders, OrderStrength>,
    /// Why there are no orders.
    pub orders_reason: Option<Reason>,
    /// Part of the segment's samples with a residual of measured samples only, 0 … 1.
    pub usable: f32,
    /// The integral of the velocity over the motion of the angle, 1 if rate, unit and sign are right; `None` without a
    /// channel of the velocity, or if the shaft hardly moved.
    pub velocity_ratio: Option<f32>,
    /// Whether the torque balance without a load has the opposite sign.
    pub(super) opposed: bool,
    /// Whether the current changes while the angle never does.
    pub(super) stuck: bool,
}

impl<P: ShaftLengths> ShaftEstimate<P> {
    /// No estimate.
    pub(crate) fn empty(plan: P) -> Self {
        let few = |part| Some(Reason::TooFewRows { part, rows: 0 });
        Self {
            friction: Friction::default(),
            friction_reason: few(Part::TorqueBalance),
            orders: Cells::filled(plan.layout().orders(), OrderStrength::default()),
            orders_reason: few(Part::Orders),
            usable: 0.0,
            velocity_ratio: None,
            opposed: false,
            stuck: false,
        }
    }

    /// Compares velocity and angle by the sums; returns what is wrong with the signals by motion and torque balance,
    /// `None` if nothing is, or nothing is known.
    pub(crate) fn contradiction(
        &mut self,
        plan: P,
        constants: &ShaftConstants<P>,
        sums: &ShaftSums<P>,
    ) -> Option<Implausible> {
        let interval_s = constants.balance.interval_s;
        self.velocity_ratio = sums.travel.ratio(interval_s);
        let friction = self.friction_reason.is_none().then_some(&self.friction);
        if plan.layout().needs_angle() && (sums.travel.stands() || self.stuck) {
            return Some(Implausible::StuckAngle);
        }
        plausibility::of_motion(&sums.travel, interval_s, &sums.usage).or_else(|| {
            let friction = friction?;
            if self.opposed {
                return Some(Implausible::Sign);
            }
            let explained = sums.balance.explained(has_load(plan));
            plausibility::of_balance(&constants.balance, friction, explained)
        })
    }

    /// The bearing orders, in the order of [`Tracking::orders`](crate::model::Tracking::orders), amplitudes in A; zeros
    /// if there is a reason.
    #[must_use]
    pub fn orders(&self) -> &[OrderStrength] {
        self.orders.cells()
    }
}
