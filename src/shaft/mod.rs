//! The shaft: motion → friction and bearing orders.
//!
//! ```text
//! sample ─► delay to the current's instant ─► torque balance: filters, rows ───────────────► Friction
//!    └ angle ─► angle turned ─► delay ─────┐             └─ residual ─► order tracking ─► OrderStrength
//!                                          └──────────────────────────────▲
//! ```
//!
//! A measured current lags behind velocity, load and angle because of its filter and conversion;
//! [`ShaftConstants::current_delay`] gives the lag in samples. The other signals are delayed alike: otherwise the lag
//! times the rate of the load would be estimated as friction. The shaft is fed at every sample of the detector, whether
//! or not the regression averages samples in blocks.

mod balance;
mod balance_solve;
mod bearing;
mod friction;
mod orders;
mod phasor;
mod state_variable;

pub use balance::Balance;
pub use bearing::Bearing;
pub use friction::{Friction, Parameter};
#[cfg(feature = "internals")]
pub use orders::MIN_BLOCKS;
pub use orders::{OrderStrength, TrackedOrder, Tracking};
pub use state_variable::StateVariable;

use crate::drive::Angle;
use crate::plan::{Array, Cells, Plan, ShaftLayout, Signals};
use crate::reason::{Part, Reason};
use crate::regression::read;
use balance::{BalanceState, BalanceSums, Torques};
use balance_solve::BalanceSolve;
use orders::{OrderSums, OrderTracking};

/// Longest lag of the current that can be compensated, samples.
pub const MAX_CURRENT_DELAY: f32 = 2.5;
/// Samples kept for the delay.
const RING: usize = 4;

/// Constants of the shaft.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftConstants<P: Plan> {
    /// Number of samples by which the measured current lags behind the rest, 0 … [`MAX_CURRENT_DELAY`].
    pub current_delay: f32,
    /// The torque balance.
    pub balance: Balance,
    /// The bearing orders.
    pub tracking: Tracking<P>,
}

/// The shaft in one segment.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftEstimate<P: Plan> {
    /// Torque balance; zeros if there is a reason.
    pub friction: Friction,
    /// Why there is no torque balance.
    pub friction_reason: Option<Reason>,
    pub(crate) orders: Array<P::Orders, OrderStrength>,
    /// Why there are no orders.
    pub orders_reason: Option<Reason>,
}

impl<P: Plan> ShaftEstimate<P> {
    /// No estimate.
    pub(crate) fn empty(plan: P) -> Self {
        let few = |part| Some(Reason::TooFewRows { part, rows: 0 });
        Self {
            friction: Friction::default(),
            friction_reason: few(Part::TorqueBalance),
            orders: Cells::filled(plan.layout().orders(), OrderStrength::default()),
            orders_reason: few(Part::Orders),
        }
    }

    /// The bearing orders, in the order of [`Tracking::orders`], amplitudes in A; zeros if there is a reason.
    #[must_use]
    pub fn orders(&self) -> &[OrderStrength] {
        self.orders.cells()
    }
}

/// How far the ring is read back.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Delay {
    /// Whole samples by which velocity, reference and load are delayed, 0 … 2.
    whole: u8,
    /// Whole samples by which the angle is delayed, 1 … 3: (4) of the balance refers to the middle of an interval.
    angle: u8,
    /// The part of a sample beyond the whole ones.
    part: f32,
}

impl Delay {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 … 3 in a validated model")]
    fn of(current_delay: f32) -> Self {
        let whole = (current_delay as u8).min(2);
        Self { whole, angle: ((current_delay + 1.0) as u8).min(3), part: current_delay - f32::from(whole) }
    }
}

/// Velocity, reference and load of a sample, and the angle turned up to it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Moment {
    levels: [f32; 3],
    turned: i32,
}

/// Running state of the shaft.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shaft<P: Plan> {
    ring: [Moment; RING],
    place: u8,
    /// Samples until the ring is full and the filters have started.
    filling: u8,
    delay: Delay,
    /// The last angle. Its start has no effect, since the phases of the orders may start anywhere.
    angle: Angle,
    balance: BalanceState,
    orders: OrderTracking<P>,
}

/// A closed segment's sums of the shaft, separate from the running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftSums<P: Plan> {
    balance: BalanceSums,
    orders: OrderSums<P>,
}

/// The solve of a closed segment under way.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftSolve {
    balance: BalanceSolve,
    balanced: bool,
    /// The next order.
    order: usize,
}

impl<P: Plan> Shaft<P> {
    /// Nothing sampled yet.
    #[must_use]
    pub fn new(plan: P, constants: &ShaftConstants<P>) -> Self {
        Self {
            ring: [Moment { levels: [0.0; 3], turned: 0 }; RING],
            place: 0,
            filling: FILLING,
            delay: Delay::of(constants.current_delay),
            angle: Angle::ZERO,
            balance: BalanceState::new(&constants.balance),
            orders: OrderTracking::new(plan),
        }
    }

    /// Takes a sample; `good` says whether all channels of the shaft may be used.
    #[inline(always)]
    pub fn step(&mut self, plan: P, constants: &ShaftConstants<P>, sample: &P::Sample, good: bool) {
        let Some(ShaftLayout { current, velocity, reference, load, harmonics, .. }) = plan.layout().shaft else {
            return;
        };
        let angle = sample.angle();
        let turned = angle.since(core::mem::replace(&mut self.angle, angle));
        let load_nm = load.map_or(0.0, |load| read(load, sample));
        let levels = [read(velocity, sample), read(reference, sample), load_nm];
        let levels = if good { levels } else { [0.0; 3] };
        self.place = self.place.wrapping_add(1) % 4;
        if let Some(cell) = self.ring.get_mut(self.place as usize) {
            *cell = Moment { levels, turned };
        }
        let Delay { whole, angle, part } = self.delay;
        let [newer, older] = [self.back(whole).levels, self.back(whole.wrapping_add(1)).levels];
        let turned = self.back(angle).turned;
        if !good {
            self.filling = FILLING;
        }
        let ([w, r, t], [w_1, r_1, t_1]) = (newer, older);
        let between = |newer: f32, older: f32| newer + part * (older - newer);
        let torques = Torques {
            current_a: read(current, sample),
            velocity_rad_s: between(w, w_1),
            reference_rad_s: between(r, r_1),
            load_nm: if load.is_some() { between(t, t_1) } else { 0.0 },
        };
        let residual = if self.filling > 0 {
            self.fill(constants, &torques);
            None
        } else {
            Some(self.balance.step(&constants.balance, load.is_some(), &torques))
        };
        if plan.layout().needs_angle() {
            self.orders.step(harmonics, &constants.tracking, turned, residual);
        }
    }

    /// Counts a sample that only fills the ring; with the last of them the filters start.
    #[cold]
    #[inline(never)]
    fn fill(&mut self, constants: &ShaftConstants<P>, torques: &Torques) {
        self.filling = self.filling.saturating_sub(1);
        if self.filling == 0 {
            self.balance.start(&constants.balance, torques);
        }
    }

    #[inline(always)]
    fn back(&self, samples: u8) -> Moment {
        let place = self.place.wrapping_sub(samples) % 4;
        self.ring.get(place as usize).copied().unwrap_or(Moment { levels: [0.0; 3], turned: 0 })
    }

    /// A copy of the sums of the open segment.
    #[inline(always)]
    #[must_use]
    pub fn sums(&self) -> ShaftSums<P> {
        ShaftSums { balance: self.balance.sums().clone(), orders: self.orders.sums() }
    }

    /// Starts a segment; filters and phases continue.
    #[inline(always)]
    pub fn next_segment(&mut self) {
        self.balance.next_segment();
        self.orders.next_segment();
    }
}

/// Samples until the ring is full, and the sample that starts the filters.
const FILLING: u8 = 5;

impl ShaftSolve {
    /// Nothing solved yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { balance: BalanceSolve::new(), balanced: false, order: 0 }
    }

    /// Does about `budget` instructions; `true` once the estimate is complete. Friction and orders do not depend on
    /// each other: at constant speed there are orders only.
    pub fn advance<P: Plan>(
        &mut self,
        plan: P,
        constants: &ShaftConstants<P>,
        sums: &mut ShaftSums<P>,
        estimate: &mut ShaftEstimate<P>,
        budget: usize,
    ) -> bool {
        let Some(layout) = plan.layout().shaft else { return true };
        if !self.balanced {
            let load = layout.load.is_some();
            let friction = &mut estimate.friction;
            match self.balance.advance(&constants.balance, load, &mut sums.balance, friction, budget) {
                None => return false,
                Some(outcome) => estimate.friction_reason = outcome.err(),
            }
            self.balanced = true;
            estimate.orders_reason = None;
            return false;
        }
        let Some(strength) = estimate.orders.cells_mut().get_mut(self.order) else {
            if estimate.orders_reason.is_some() {
                estimate.orders.cells_mut().fill(OrderStrength::default());
            }
            return true;
        };
        match sums.orders.strength(&constants.tracking, self.order) {
            Ok(found) => *strength = found,
            Err(reason) => estimate.orders_reason = estimate.orders_reason.or(Some(reason)),
        }
        self.order = self.order.saturating_add(1);
        false
    }
}

impl Default for ShaftSolve {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
