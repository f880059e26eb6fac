//! The solve of the shaft's sums in steps: torque balance, noise, then one order after the other.

use super::balance::Estimated;
use super::estimate::ShaftEstimate;
use super::orders::{NoiseLine, OrderStrength, Search, SlipRange};
use super::plausibility::{self, Usage};
use super::state::{ShaftConstants, ShaftSums};
use crate::plan::{Cells, Load, ShaftLengths};
use crate::reason::{Part, Reason};

/// The solve of a closed segment under way.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftSolve {
    next: Step,
    estimated: Estimated,
    noise: NoiseLine,
}

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Step {
    /// Solve the torque balance.
    TorqueBalance,
    /// Compute the covariance of its parameters.
    Covariance,
    /// Compute the friction with its deviations.
    Friction,
    /// Find the noise at all orders.
    Noise,
    /// Look for the slip of this order.
    Search(usize),
    /// Compute its strength.
    Strength(usize, Search),
}

/// 2ⁿ, n from −126 to 127.
const fn power_of_two(n: i8) -> f32 {
    f32::from_bits((n as i32).wrapping_add(127).cast_unsigned() << 23)
}

impl ShaftSolve {
    /// Nothing solved yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { next: Step::TorqueBalance, estimated: Estimated::NONE, noise: NoiseLine::NONE }
    }

    /// Does the next step; `true` once the estimate is complete. Friction and orders do not depend on each other: at
    /// constant speed there are orders only. But if gaps leave too few rows for the friction, there are no orders
    /// either.
    // In the caller's frame: one of its own takes more stack.
    #[inline(always)]
    pub fn advance<P: ShaftLengths>(
        &mut self,
        plan: P,
        constants: &ShaftConstants<P>,
        sums: &mut ShaftSums<P>,
        estimate: &mut ShaftEstimate<P>,
    ) -> bool {
        let known = plan.layout().shaft.map_or(Load::Unknown, |layout| layout.load);
        let load = known.has_terms();
        self.next = match self.next {
            Step::TorqueBalance => {
                if let Some(reason) = short(sums, estimate) {
                    (estimate.friction_reason, estimate.orders_reason) = (Some(reason), Some(reason));
                    return true;
                }
                match self.estimated.solve(&constants.balance, load, &mut sums.balance) {
                    Ok(()) => Step::Covariance,
                    Err(reason) => {
                        let rests = sums.balance.is_at_rest(&constants.balance, load);
                        estimate.friction_reason = Some(if rests { Reason::AtRest } else { reason });
                        Step::Noise
                    }
                }
            }
            Step::Covariance => {
                self.estimated.correlate(&constants.balance, load, &mut sums.balance);
                Step::Friction
            }
            Step::Friction => {
                match self.estimated.friction(&constants.balance, known, sums.balance.rows) {
                    Ok(friction) => {
                        estimate.stuck = plausibility::is_stuck(&constants.balance, &friction, &sums.usage);
                        if sums.balance.is_at_rest(&constants.balance, load) {
                            estimate.friction_reason = Some(Reason::AtRest);
                        } else {
                            (estimate.friction, estimate.friction_reason) = (friction, None);
                            let rows = sums.balance.rows;
                            estimate.opposed =
                                known.measured().is_none() && self.estimated.is_opposed(&constants.balance, load, rows);
                        }
                    }
                    Err(reason) => estimate.friction_reason = Some(reason),
                }
                Step::Noise
            }
            Step::Noise => {
                estimate.orders_reason = without_orders(sums, estimate.friction_reason);
                if estimate.orders_reason.is_some() {
                    return true;
                }
                self.noise = NoiseLine::new(&sums.orders.noise, &constants.tracking.blocks.controls);
                Step::Search(0)
            }
            Step::Search(k) => match self.search(constants, sums, k) {
                Some(search) => Step::Strength(k, search),
                None => return true,
            },
            Step::Strength(k, search) => {
                if !take_strength(constants, sums, k, search, estimate) {
                    return true;
                }
                Step::Search(k.wrapping_add(1))
            }
        };
        false
    }

    /// The search for the slip of order k; `None` behind the last one.
    #[inline(always)]
    fn search<P: ShaftLengths>(&self, constants: &ShaftConstants<P>, sums: &ShaftSums<P>, k: usize) -> Option<Search> {
        let tracking = &constants.tracking;
        let (order, line) = tracking.orders.cells().get(k).zip(sums.orders.lines.cells().get(k))?;
        Some(Search::new(line, &self.noise, order, &slip_range(constants)))
    }
}

/// Puts the strength of order k into the estimate; `false` if it is not finite, for which there are then no orders.
#[inline(always)]
fn take_strength<P: ShaftLengths>(
    constants: &ShaftConstants<P>,
    sums: &ShaftSums<P>,
    k: usize,
    search: Search,
    estimate: &mut ShaftEstimate<P>,
) -> bool {
    let of_order = constants.tracking.orders.cells().get(k).zip(sums.orders.lines.cells().get(k));
    let Some(((order, line), cell)) = of_order.zip(estimate.orders.cells_mut().get_mut(k)) else { return false };
    let strength = search.strength(line, order, &slip_range(constants));
    let sum = strength.score + strength.amplitude + strength.slip_deviation;
    if !sum.is_finite() {
        estimate.orders_reason = Some(Reason::NotFinite(Part::Orders));
        estimate.orders.cells_mut().fill(OrderStrength::default());
        return false;
    }
    *cell = strength;
    true
}

/// The slips that are searched.
#[inline(always)]
fn slip_range<P: ShaftLengths>(constants: &ShaftConstants<P>) -> SlipRange {
    let blocks = &constants.tracking.blocks;
    SlipRange { cell_turns: power_of_two(blocks.cell_turns_log2), slip: blocks.slip }
}

/// The usable part of the segment; the reason if it is less than half.
fn short<P: ShaftLengths>(sums: &ShaftSums<P>, estimate: &mut ShaftEstimate<P>) -> Option<Reason> {
    let Usage { seen, used, .. } = sums.usage;
    estimate.usable = used as f32 / seen.max(1) as f32;
    (used < seen / 2).then_some(Reason::ShortSegment { rows: used })
}

/// Why there are no orders: a shaft at rest has too few blocks. The residual is that of parameters which gaps may have
/// left undetermined: the error of the friction is in it.
fn without_orders<P: ShaftLengths>(sums: &ShaftSums<P>, friction: Option<Reason>) -> Option<Reason> {
    let Usage { seen, used, .. } = sums.usage;
    let gaps = used < seen.wrapping_sub(seen / 16);
    let undetermined = matches!(friction, Some(Reason::TooFewRows { .. }));
    if gaps && undetermined {
        return friction;
    }
    let few = sums.orders.reason()?;
    Some(if friction == Some(Reason::AtRest) { Reason::AtRest } else { few })
}

impl Default for ShaftSolve {
    fn default() -> Self {
        Self::new()
    }
}
