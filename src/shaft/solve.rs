//! The solve of the shaft's sums, in pieces: torque balance, then one order after the other.

use super::balance::BalanceSolve;
use super::orders::{NoiseLine, OrderStrength, SlipRange, SlipSearch};
use super::state::{ShaftConstants, ShaftEstimate, ShaftSums, Usage};
use crate::plan::{Cells, Plan};
use crate::reason::{Part, Reason};

/// The solve of a closed segment under way.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftSolve {
    balance: BalanceSolve,
    balanced: bool,
    noise: NoiseLine,
    /// The next order, and the search for its slip.
    order: usize,
    search: SlipSearch,
}

/// 2ⁿ, n from −126 to 127.
const fn power_of_two(n: i8) -> f32 {
    f32::from_bits((n as i32).wrapping_add(127).cast_unsigned() << 23)
}

impl ShaftSolve {
    /// Nothing solved yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            balance: BalanceSolve::new(),
            balanced: false,
            noise: NoiseLine::new(),
            order: 0,
            search: SlipSearch::new(),
        }
    }

    /// Does about `budget` instructions; `true` once the estimate is complete. Friction and orders do not depend on
    /// each other: at constant speed there are orders only. But if gaps leave too few rows for the friction, there are
    /// no orders either.
    // In the caller's frame: one of its own takes more stack.
    #[inline(always)]
    pub fn advance<P: Plan>(
        &mut self,
        plan: P,
        constants: &ShaftConstants<P>,
        sums: &mut ShaftSums<P>,
        estimate: &mut ShaftEstimate<P>,
        budget: usize,
    ) -> bool {
        let Some(layout) = plan.layout().shaft else { return true };
        let Usage { seen, used } = sums.usage;
        if !self.balanced {
            estimate.usable = used as f32 / seen.max(1) as f32;
            if used < seen / 2 {
                let reason = Some(Reason::ShortSegment { rows: used });
                (estimate.friction_reason, estimate.orders_reason) = (reason, reason);
                return true;
            }
            let load = layout.load.is_some();
            let friction = &mut estimate.friction;
            match self.balance.advance(&constants.balance, load, &mut sums.balance, friction, budget) {
                None => return false,
                Some(outcome) => estimate.friction_reason = outcome.err(),
            }
            self.balanced = true;
            // The residual is that of parameters which gaps left undetermined: the error of the friction is in it.
            let gaps = used < seen.wrapping_sub(seen / 16);
            let undetermined = matches!(estimate.friction_reason, Some(Reason::TooFewRows { .. }));
            estimate.orders_reason = if gaps && undetermined { estimate.friction_reason } else { sums.orders.reason() };
            return false;
        }
        let tracking = &constants.tracking;
        if estimate.orders_reason.is_none() && !self.noise.take(&sums.orders.noise, &tracking.blocks.controls) {
            return false;
        }
        let orders = (tracking.orders.cells().get(self.order), sums.orders.lines.cells().get(self.order));
        let (Some(cell), (Some(order), Some(line)), None) =
            (estimate.orders.cells_mut().get_mut(self.order), orders, estimate.orders_reason)
        else {
            if estimate.orders_reason.is_some() {
                estimate.orders.cells_mut().fill(OrderStrength::default());
            }
            return true;
        };
        let range = SlipRange { cell_turns: power_of_two(tracking.blocks.cell_turns_log2), slip: tracking.blocks.slip };
        let mut spent = 0_usize;
        while spent < budget {
            if let Some(strength) = self.search.step(line, &self.noise, order, &range) {
                let sum = strength.score + strength.amplitude + strength.slip_deviation;
                if sum.is_finite() {
                    *cell = strength;
                } else {
                    estimate.orders_reason = Some(Reason::NotFinite(Part::Orders));
                }
                self.search = SlipSearch::new();
                self.order = self.order.saturating_add(1);
                break;
            }
            spent = spent.saturating_add(SEARCH);
        }
        false
    }
}

/// Instructions of one slip, about.
const SEARCH: usize = 250;

impl Default for ShaftSolve {
    fn default() -> Self {
        Self::new()
    }
}
