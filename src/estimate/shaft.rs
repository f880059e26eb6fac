//! The shaft's side of the second wing: motion in, friction and bearing orders out.
//!
//! ```text
//! Motion ─► gate ─► delay to the current's instant ─► friction: filters, rows ─────────────► Friction
//!    └ angle ─► way turned ─► delay ───────┐             └─ residual ─► order tracking ─► OrderStrength
//!                                          └──────────────────────────────▲
//! ```
//!
//! A measured current lags behind velocity, load and angle by its filter and conversion; [`ShaftModel::current_delay`] says by how
//! many samples. Unless the others are delayed alike, the lag times the rate of the load is taken for friction. State: 336 + 72 K
//! bytes; [`Shaft`] is fed at every sample of the detector, block means or not.

use super::friction::{FrictionState, FrictionSums, Torques};
use super::gate::Gate;
use super::order_tracking::OrderTracking;
use super::{Balance, Counts, Friction, Guard, OrderStrength, Reason, Tracking};
use crate::detector::Sample;
use crate::drive::Angle;

/// Longest delay that can be made up for, samples.
pub const MAX_CURRENT_DELAY: f32 = 2.5;
const RING: u8 = 4;

/// One sample of the shaft, as the drive has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// Quadrature or armature current: positive drives forwards.
    pub current_a: f32,
    /// Measured velocity.
    pub velocity_rad_s: f32,
    /// Velocity reference.
    pub reference_rad_s: f32,
    /// Load torque against positive motion; 0 where it is not measured.
    pub load_nm: f32,
    /// Mechanical angle of the shaft.
    pub angle: Angle,
}

/// Constants of the shaft's side, at most `K` orders.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftModel<const K: usize> {
    /// Believable samples, in the order current, velocity (and its reference), load.
    pub guard: Guard,
    /// By how many samples the measured current lags behind the rest, 0 … [`MAX_CURRENT_DELAY`].
    pub current_delay: f32,
    /// The torque balance.
    pub balance: Balance,
    /// The orders.
    pub tracking: Tracking<K>,
}

/// What a segment says about the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftEstimate<const K: usize> {
    /// Torque balance; zeros where there is a reason.
    pub friction: Friction,
    /// Orders, in the order of [`Tracking::orders`], amplitudes in A; zeros where there is a reason.
    pub orders: [OrderStrength; K],
    /// Samples that were refused.
    pub counts: Counts,
    /// Why the torque balance says nothing, if so.
    pub reason: Option<Reason>,
    /// Why the orders say nothing, if so.
    pub orders_reason: Option<Reason>,
}

impl<const K: usize> ShaftEstimate<K> {
    /// An estimate that says nothing, and why.
    #[must_use]
    pub fn empty(reason: Reason) -> Self {
        let orders = [OrderStrength::default(); K];
        Self {
            friction: Friction::default(),
            orders,
            counts: Counts::default(),
            reason: Some(reason),
            orders_reason: Some(reason),
        }
    }
}

/// What a detector does with the shaft: watch it ([`Shaft`]), or nothing ([`NoShaft`]).
pub trait Watch<const K: usize>: Clone + core::fmt::Debug + PartialEq {
    /// Whether a model of this shape can be watched.
    fn fits(model: Option<&ShaftModel<K>>) -> bool;
    /// Nothing seen yet.
    fn new(model: Option<&ShaftModel<K>>) -> Self;
    /// Takes a sample.
    fn step(&mut self, model: Option<&ShaftModel<K>>, motion: &Motion);
    /// The sums so far; nothing where nothing is watched.
    fn sums(&self) -> Option<ShaftSums<K>>;
    /// Starts a segment.
    fn next_segment(&mut self);
}

/// Watches nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoShaft;

impl<const K: usize> Watch<K> for NoShaft {
    fn fits(model: Option<&ShaftModel<K>>) -> bool {
        model.is_none()
    }

    fn new(_model: Option<&ShaftModel<K>>) -> Self {
        Self
    }

    fn step(&mut self, _model: Option<&ShaftModel<K>>, _motion: &Motion) {}

    fn sums(&self) -> Option<ShaftSums<K>> {
        None
    }

    fn next_segment(&mut self) {}
}

/// Running state of the shaft's side.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shaft<const K: usize> {
    gate: Gate,
    /// Velocity, reference and load of the last samples, and the way turned to them.
    ring: [([f32; 3], i32); RING as usize],
    place: u8,
    /// Samples until the ring is filled and the filters have started.
    filling: u8,
    delay: Delay,
    /// The last angle. Before the first sample any will do: where phases start does not count.
    angle: Angle,
    friction: FrictionState,
    orders: OrderTracking<K>,
    /// Whether a model is watched at all.
    watching: bool,
}

/// How far the ring is looked back into: made once, not at every sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Delay {
    /// Whole samples that velocity, reference and load are delayed by, 0 … 2.
    whole: u8,
    /// Those of the angle, 1 … 3: (4) of the friction speaks of the middle of an interval.
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

/// A closed segment's sums of the shaft, apart from the state that goes on.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftSums<const K: usize> {
    friction: FrictionSums,
    orders: OrderTracking<K>,
    counts: Counts,
}

impl<const K: usize> ShaftModel<K> {
    /// The estimate from a segment's sums. Friction and orders stand each for itself: at constant speed there are but orders.
    #[must_use]
    pub fn conclude(&self, sums: &ShaftSums<K>) -> ShaftEstimate<K> {
        let mut estimate = ShaftEstimate::empty(Reason::TooFewRows);
        estimate.counts = sums.counts;
        if let Some(signal) = sums.counts.stuck.iter().position(|stuck| *stuck) {
            let stuck = Some(Reason::Stuck(u8::try_from(signal).unwrap_or(u8::MAX)));
            (estimate.reason, estimate.orders_reason) = (stuck, stuck);
            return estimate;
        }
        match sums.friction.solve(&self.balance) {
            Ok(friction) => (estimate.friction, estimate.reason) = (friction, None),
            Err(reason) => estimate.reason = Some(reason),
        }
        match sums.orders.strengths(&self.tracking) {
            Ok(orders) => (estimate.orders, estimate.orders_reason) = (orders, None),
            Err(reason) => estimate.orders_reason = Some(reason),
        }
        estimate
    }
}

impl<const K: usize> Watch<K> for Shaft<K> {
    fn fits(_model: Option<&ShaftModel<K>>) -> bool {
        true
    }

    fn new(model: Option<&ShaftModel<K>>) -> Self {
        const NOTHING: Balance = Balance {
            interval_s: 1.0,
            filter: super::StateVariable::new(0.1, 1.0),
            row_interval: 1,
            settle: 0,
            sign_velocity_rad_s: 1.0,
            usual_velocity_rad_s: 1.0,
            load: true,
            scale: [1.0; 4],
            nominal: [0.0; 5],
        };
        Self {
            gate: Gate::new(true),
            ring: [([0.0; 3], 0); RING as usize],
            place: 0,
            filling: RING + 1,
            delay: Delay::of(model.map_or(0.0, |model| model.current_delay)),
            angle: Angle::ZERO,
            friction: FrictionState::new(model.map_or(&NOTHING, |model| &model.balance)),
            orders: OrderTracking::new(),
            watching: model.is_some(),
        }
    }

    #[inline]
    fn step(&mut self, model: Option<&ShaftModel<K>>, motion: &Motion) {
        let Some(model) = model else { return };
        let turned = motion.angle.since(core::mem::replace(&mut self.angle, motion.angle));
        let Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, .. } = *motion;
        let sample = Sample { y: current_a, u1: velocity_rad_s, u2: load_nm };
        let [_, most, _] = model.guard.limit;
        let good = self.gate.admits(&model.guard, &sample) && self.admits_reference(reference_rad_s, most);
        let levels = if good { [velocity_rad_s, reference_rad_s, load_nm] } else { [0.0; 3] };
        self.place = (self.place + 1) % RING;
        if let Some(cell) = self.ring.get_mut(self.place as usize) {
            *cell = (levels, turned);
        }
        let ([newer, older], turned) = self.delayed();
        if !good {
            self.filling = RING + 1;
        }
        let ([w, r, t], [w_1, r_1, t_1]) = (newer, older);
        let between = |newer: f32, older: f32| newer + self.delay.part * (older - newer);
        let torques = Torques {
            current_a,
            velocity_rad_s: between(w, w_1),
            reference_rad_s: between(r, r_1),
            load_nm: between(t, t_1),
        };
        if self.filling > 0 {
            self.filling -= 1;
            if self.filling == 0 {
                self.friction.start(&model.balance, &torques);
            }
            self.orders.step(&model.tracking, turned, None);
            return;
        }
        let residual = self.friction.step(&model.balance, &torques);
        self.orders.step(&model.tracking, turned, Some(residual));
    }

    fn sums(&self) -> Option<ShaftSums<K>> {
        self.watching.then(|| ShaftSums {
            friction: self.friction.sums(),
            orders: self.orders.clone(),
            counts: self.gate.counts,
        })
    }

    fn next_segment(&mut self) {
        self.gate.next_segment();
        self.friction.next_segment();
        self.orders.next_segment();
    }
}

impl<const K: usize> Shaft<K> {
    /// The reference has the velocity's range; the gate knows three signals only. NaN is in no range.
    #[inline(always)]
    fn admits_reference(&mut self, reference_rad_s: f32, most: f32) -> bool {
        let good = reference_rad_s.abs() <= most;
        if !good {
            self.gate.counts.rejected = self.gate.counts.rejected.saturating_add(1);
        }
        good
    }

    /// Levels of the two samples around the current's instant, and the way turned then.
    #[inline(always)]
    fn delayed(&self) -> ([[f32; 3]; 2], i32) {
        let back = |samples: u8| {
            let place = self.place.wrapping_sub(samples) % RING;
            self.ring.get(place as usize).copied().unwrap_or_default()
        };
        let Delay { whole, angle, .. } = self.delay;
        ([back(whole).0, back(whole + 1).0], back(angle).1)
    }
}
