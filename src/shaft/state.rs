//! The shaft at each sample: constants, running state, and the sums of a segment.

use core::f32::consts::TAU;

use super::balance::{BalanceState, BalanceSums, TorqueBalance, Torques};
use super::delays::{BEFORE, Delay, Delays, FILTERED_RING, Lags, RING, TAPS, half_band};
use super::orders::{OrderSums, OrderTracking, Residual, ResidualState, Taken, Tracking, phasor};
use super::plausibility::Usage;
use crate::plan::{Array, Cells, Load, ShaftLayout, ShaftLengths, Signals};
use crate::signal::{Angle, Travel, TravelSums, read};

/// A count of 2⁻³² turn, rad.
const RAD_A_COUNT: f32 = TAU / 4_294_967_296.0;
/// Velocity from which motion is compared with the angle, in units of [`TorqueBalance::sign_velocity_rad_s`], which
/// is three standard deviations of the velocity's noise: an offset of one deviation is then 1/12 of the velocity.
const SLOWEST: f32 = 4.0;
/// Lost samples in a row that are bridged.
pub const BRIDGE: u8 = 8;

/// Constants of the shaft.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftConstants<P: ShaftLengths> {
    /// Lags of the signals.
    pub lags: Lags,
    /// The torque balance.
    pub balance: TorqueBalance,
    /// The bearing orders.
    pub tracking: Tracking<P>,
}

/// The signals of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Moment {
    torques: Torques,
    angle: Angle,
}

/// Running state of the shaft.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shaft<P: ShaftLengths> {
    /// Of a filter's moments, the first [`BEFORE`] again behind the last, so that those that it reads are in a row.
    ring: Array<P::Moments, Moment>,
    /// Place of the last sample; an odd one is between two steps of a filter.
    index: u8,
    /// The step whose orders are added at the next sample.
    taken: Option<Taken>,
    /// Steps until what is read of the ring is full and the filters have started.
    filling: u8,
    /// Lost samples in a row.
    lost: u8,
    /// Samples until the residual contains measured ones only.
    spoilt: u8,
    delays: Delays,
    /// The motion of the last sample, and its largest change, counts of 2⁻³² turn.
    motion: i32,
    largest_change: u32,
    /// Whether the last change of the motion was too large.
    stepped: bool,
    /// The delayed angle of the last sample. Its start has no effect, since the phases of the orders may start
    /// anywhere.
    angle: Angle,
    /// The angle of an axis with a weight; its start has no effect.
    axis: Angle,
    travel: Travel,
    balance: BalanceState,
    residual: ResidualState,
    orders: OrderTracking<P>,
}

/// A segment's sums of the shaft, separate from the running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftSums<P: ShaftLengths> {
    pub(super) balance: BalanceSums,
    pub(super) orders: OrderSums<P>,
    pub(super) usage: Usage,
    pub(super) travel: TravelSums,
}

impl<P: ShaftLengths> ShaftSums<P> {
    /// Nothing but the prior of the balance.
    pub(crate) fn new(plan: P, constants: &ShaftConstants<P>) -> Self {
        Self {
            balance: BalanceSums::new(&constants.balance, has_load(plan)),
            orders: OrderSums::new(plan),
            usage: Usage::default(),
            travel: TravelSums::default(),
        }
    }

    /// Samples that were refused because the angle made a step that no motor makes.
    pub(crate) const fn steps(&self) -> u32 {
        self.usage.steps
    }

    /// Nothing but the prior again, in place, since new ones would be moved.
    #[inline(always)]
    pub(crate) fn clear(&mut self, plan: P, constants: &ShaftConstants<P>) {
        self.balance.clear(&constants.balance, has_load(plan));
        self.orders.clear();
        (self.usage, self.travel) = (Usage::default(), TravelSums::default());
    }
}

#[inline(always)]
pub(super) fn has_load<P: ShaftLengths>(plan: P) -> bool {
    plan.layout().shaft.is_some_and(|shaft| shaft.load.has_terms())
}

impl<P: ShaftLengths> Shaft<P> {
    /// Nothing sampled yet.
    #[must_use]
    pub fn new(plan: P, constants: &ShaftConstants<P>) -> Self {
        Self {
            ring: Cells::filled(plan.layout().moments(), Moment::default()),
            index: 0,
            taken: None,
            filling: FILLING,
            lost: 0,
            spoilt: 0,
            delays: Delays::of(&constants.lags, plan.layout().shaft.is_some_and(|shaft| shaft.is_halved())),
            motion: 0,
            largest_change: counts(constants.balance.largest_change_rad),
            stepped: false,
            angle: Angle::ZERO,
            axis: Angle::ZERO,
            travel: Travel::default(),
            balance: BalanceState::new(&constants.balance),
            residual: ResidualState::new(),
            orders: OrderTracking::new(plan),
        }
    }

    /// Takes a sample; `good` says whether all channels of the shaft may be used.
    // A function of its own: inlined into an interrupt, it would take the registers of the front end.
    #[inline(never)]
    pub fn step(
        &mut self,
        sums: &mut ShaftSums<P>,
        plan: P,
        constants: &ShaftConstants<P>,
        (sample, good): (&impl Signals, bool),
    ) {
        let Some(layout) = plan.layout().shaft else {
            return;
        };
        let ShaftLayout { current, velocity, load, .. } = layout;
        let last = self.back(0);
        self.index = self.index.wrapping_add(1) % self.length();
        let moment = if !good {
            self.lose(velocity.is_none());
            last
        } else if self.changes(sample.angle().since(last.angle))
            && self.step_found(&mut sums.usage, sample.angle().since(last.angle), velocity.is_none(), {
                let largest_a = last.torques.current_a.abs().max(read(current, sample).abs());
                accelerated_rad(&constants.balance, layout.is_halved(), largest_a)
            })
        {
            Moment { angle: sample.angle(), ..last }
        } else {
            let interval_s = sample_interval_s(&constants.balance, layout.is_halved());
            let velocity_rad_s = match velocity {
                Some(velocity) => read(velocity, sample),
                None => self.mean_velocity_rad_s(interval_s, sample.angle(), &last),
            };
            self.lost = 0;
            let load_nm = load.measured().map_or(0.0, |load| read(load, sample));
            let current_a = read(current, sample);
            Moment { torques: Torques { current_a, velocity_rad_s, load_nm }, angle: sample.angle() }
        };
        if let Some(cell) = self.ring.cells_mut().get_mut(self.index as usize) {
            *cell = moment;
        }
        if layout.is_halved() {
            self.halved(sums, layout, constants, moment);
        } else {
            let now = self.torques(layout.load.measured().is_some(), Self::between);
            if let Some((turned, residual)) = self.balanced(sums, layout, constants, &now) {
                self.orders.step(&mut sums.orders, &constants.tracking, turned, (layout.harmonics, residual));
            }
        }
    }

    /// Each second sample is a step behind the half-band filter; the sample between steps adds the bearing orders, so
    /// that the work is distributed.
    #[inline(always)]
    fn halved(&mut self, sums: &mut ShaftSums<P>, layout: ShaftLayout, constants: &ShaftConstants<P>, moment: Moment) {
        if let Some(cell) = self.ring.cells_mut().get_mut(self.index.wrapping_add(FILTERED_RING) as usize) {
            *cell = moment;
        }
        let tracking = &constants.tracking;
        if self.index % 2 == 1 {
            if let Some(taken) = self.taken.take() {
                self.orders.leave(&mut sums.orders, tracking, layout.harmonics, taken);
            }
            if self.filling == 0 {
                self.spoilt = self.spoilt.saturating_sub(1);
            }
            return;
        }
        let now = self.torques(layout.load.measured().is_some(), Self::filtered);
        if let Some((turned, residual)) = self.balanced(sums, layout, constants, &now) {
            self.taken = Some(self.orders.take(tracking, turned, residual));
        }
    }

    /// Takes the signals of a step; the angle turned since the last one and the residual, if there are orders,
    /// unless the filters start.
    #[inline(always)]
    fn balanced(
        &mut self,
        sums: &mut ShaftSums<P>,
        layout: ShaftLayout,
        constants: &ShaftConstants<P>,
        now: &Torques,
    ) -> Option<(i32, Residual)> {
        let [.., angle] = self.delays.all();
        let angle = self.angle_back(angle);
        let turned = angle.since(core::mem::replace(&mut self.angle, angle));
        let usage = &mut sums.usage;
        usage.seen = usage.seen.saturating_add(1);
        let balance = &constants.balance;
        self.turn_axis(layout.load, turned);
        if self.filling > 0 {
            self.travel.restart();
            self.orders.turn_unwatched(turned);
            self.fill(&layout, constants, now);
            return None;
        }
        usage.moved |= turned.cast_unsigned();
        let clean = self.spoilt == 0;
        if clean {
            usage.used = usage.used.saturating_add(1);
        } else {
            self.spoilt = self.spoilt.wrapping_sub(1);
            self.travel.restart();
        }
        // A velocity of the angle agrees with it.
        let interval_s = balance.interval_s;
        if layout.velocity.is_some() && clean && self.travel.step_or_stand(turned, now.velocity_rad_s, interval_s) {
            let slowest = SLOWEST * balance.sign_velocity_rad_s * interval_s;
            self.travel.close_any(&mut sums.travel, slowest, interval_s);
        }
        let regressors = &balance.regressors(now, self.weight(layout.load));
        self.balance.step(&mut sums.balance, (balance, layout.load), now, regressors, clean);
        if layout.orders == 0 {
            return None;
        }
        let (blocks, p) = (&constants.tracking.blocks, self.balance.present());
        let known = clean && (!matches!(layout.load, Load::Weight { .. }) || self.balance.knows_weight());
        Some((turned, self.residual.step(balance, blocks, p, now, regressors, known)))
    }

    /// Turns the axis of a weight with the motor.
    #[inline(always)]
    fn turn_axis(&mut self, load: Load, turned: i32) {
        if let Load::Weight { axis_q32, .. } = load {
            self.axis = self.axis.plus(Angle::from_bits(of_axis(turned, axis_q32)));
        }
    }

    /// Cosine and sine of the angle of the axis of a weight.
    #[inline(always)]
    fn weight(&self, load: Load) -> Option<[f32; 2]> {
        let Load::Weight { .. } = load else { return None };
        let (cos, sin) = phasor(self.axis.bits());
        Some([cos, sin])
    }

    /// The mean velocity since the last good sample. Over lost samples the shaft may turn more than half a turn: the
    /// velocity is that next to the last one.
    #[inline(always)]
    fn mean_velocity_rad_s(&self, interval_s: f32, angle: Angle, last: &Moment) -> f32 {
        let turned_rad = angle.since(last.angle) as f32 * RAD_A_COUNT;
        if self.lost == 0 {
            return turned_rad / interval_s;
        }
        let passed_s = interval_s * f32::from(self.lost.saturating_add(1));
        let turns = (last.torques.velocity_rad_s * passed_s - turned_rad) / TAU;
        (turned_rad + libm::rintf(turns) * TAU) / passed_s
    }

    /// Takes the motion since the last sample; whether it has changed by more than the motor of training changes it.
    #[inline(always)]
    fn changes(&mut self, turned: i32) -> bool {
        let changes = turned.wrapping_sub(self.motion).unsigned_abs() > self.largest_change;
        if !changes {
            self.motion = turned;
        }
        changes
    }

    /// Refuses the sample of a step, with those that its motion reaches. A change that the present current explains is
    /// none, a motion that stays is one of the shaft, and the first one behind lost samples is that of several.
    #[cold]
    #[inline(never)]
    fn step_found(&mut self, usage: &mut Usage, turned: i32, differenced: bool, accelerated_rad: f32) -> bool {
        let accelerated = turned.wrapping_sub(self.motion).unsigned_abs() <= counts(accelerated_rad);
        let stays = core::mem::take(&mut self.stepped) && self.spoilt > 0 || accelerated;
        if self.filling > 0 || stays {
            self.motion = turned;
        }
        if self.filling > 0 || stays || self.lost > 0 {
            return false;
        }
        self.stepped = true;
        usage.steps = usage.steps.saturating_add(u32::from(self.spoilt == 0));
        self.spoilt = self.delays.spoilt.saturating_add(u8::from(differenced));
        true
    }

    /// Counts a lost sample; too many in a row are not bridged. A velocity that is `differenced` is that between a
    /// sample and the last one, so that a lost sample spoils one more.
    #[cold]
    #[inline(never)]
    fn lose(&mut self, differenced: bool) {
        self.lost = self.lost.saturating_add(1);
        self.spoilt = self.delays.spoilt.saturating_add(u8::from(differenced));
        if self.lost > BRIDGE {
            self.filling = FILLING;
        }
    }

    /// Counts a step that only fills the ring; with the last of them the filters start.
    #[cold]
    #[inline(never)]
    fn fill(&mut self, layout: &ShaftLayout, constants: &ShaftConstants<P>, now: &Torques) {
        self.filling = self.filling.saturating_sub(1);
        if self.filling == 0 {
            let regressors = constants.balance.regressors(now, self.weight(layout.load));
            self.balance.start(&constants.balance, now, &regressors);
            self.residual = ResidualState::new();
            // A sample lost meanwhile is still in the delays.
            self.spoilt = self.spoilt.max(layout.decimation);
        }
    }

    /// Samples in the ring; a plan of a fixed length knows it when compiled.
    #[inline(always)]
    fn length(&self) -> u8 {
        if self.ring.cells().len() > RING as usize { FILTERED_RING } else { RING }
    }

    #[inline(always)]
    fn back(&self, samples: u8) -> Moment {
        let index = self.index.wrapping_sub(samples) % self.length();
        self.ring.cells().get(index as usize).copied().unwrap_or_default()
    }

    /// The signals at the instant of a step, each read back by its delay.
    #[inline(always)]
    fn torques(&self, has_load: bool, at: impl Fn(&Self, Delay, fn(&Moment) -> f32) -> f32) -> Torques {
        let [current, velocity, load, _] = self.delays.all();
        Torques {
            current_a: at(self, current, |moment| moment.torques.current_a),
            velocity_rad_s: at(self, velocity, |moment| moment.torques.velocity_rad_s),
            load_nm: if has_load { at(self, load, |moment| moment.torques.load_nm) } else { 0.0 },
        }
    }

    #[inline(always)]
    fn between(&self, delay: Delay, pick: fn(&Moment) -> f32) -> f32 {
        let (newer, older) = (pick(&self.back(delay.whole)), pick(&self.back(delay.whole.wrapping_add(1))));
        newer + delay.part * (older - newer)
    }

    /// The signal behind the half-band filter.
    #[inline(always)]
    fn filtered(&self, delay: Delay, pick: fn(&Moment) -> f32) -> f32 {
        let oldest = self.index.wrapping_sub(delay.whole).wrapping_sub(BEFORE) % FILTERED_RING;
        let moments = self.ring.cells().get(oldest as usize..).and_then(<[Moment]>::first_chunk::<TAPS>);
        let Some([m7, m6, m5, m4, m3, m2, m1, m0]) = moments else { return 0.0 };
        let samples = [pick(m7), pick(m6), pick(m5), pick(m4), pick(m3), pick(m2), pick(m1), pick(m0)];
        half_band(samples, delay.part)
    }

    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "a part of the angle between two samples, which is an i32")]
    fn angle_back(&self, delay: Delay) -> Angle {
        let (newer, older) = (self.back(delay.whole).angle, self.back(delay.whole.wrapping_add(1)).angle);
        let part = delay.part * older.since(newer) as f32;
        newer.plus(Angle::from_bits((part as i32).cast_unsigned()))
    }

    /// Starts a segment; filters and phases continue.
    #[inline(always)]
    pub fn next_segment(&mut self) {
        self.balance.next_segment();
        self.orders.next_segment();
        self.taken = None;
    }

    /// Starts afresh as if nothing had been sampled, in place: a new one would be moved.
    #[inline(always)]
    pub fn renew(&mut self, constants: &ShaftConstants<P>) {
        self.next_segment();
        self.balance.renew(&constants.balance);
        self.orders.renew();
        // The last sample is not trusted: one that is lost next would be replaced by it. Those before it are not read.
        self.index = 0;
        if let Some(last) = self.ring.cells_mut().first_mut() {
            *last = Moment::default();
        }
        // Steps that fill the ring start filters and travel.
        (self.filling, self.lost, self.spoilt) = (FILLING, 0, 0);
    }
}

/// The turn of an axis with one of the motor, 2⁻³² turns, rounded: what is lost in a segment is nothing.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "the turn of an axis is less than that of the motor")]
const fn of_axis(turned: i32, axis_q32: u32) -> u32 {
    ((turned as i64).wrapping_mul(axis_q32 as i64).wrapping_add(1 << 31) >> 32).cast_unsigned() as u32
}

/// An angle in counts of 2⁻³² turn; all of them for one that is larger, or infinite.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive, and `as` saturates")]
fn counts(angle_rad: f32) -> u32 {
    (angle_rad / RAD_A_COUNT) as u32
}

/// The interval of the samples, of which the shaft may take each second one.
fn sample_interval_s(balance: &TorqueBalance, halved: bool) -> f32 {
    if halved { 0.5 * balance.interval_s } else { balance.interval_s }
}

/// Twice the change of the motion in a sample by which this current accelerates the nominal inertia, rad.
fn accelerated_rad(balance: &TorqueBalance, halved: bool, current_a: f32) -> f32 {
    let interval_s = sample_interval_s(balance, halved);
    2.0 * current_a * interval_s * interval_s / balance.nominal[0].abs()
}

/// Steps until all that is read of the ring is measured, and the step that starts the filters: 8 samples of the longest
/// lag, or 16 of it behind the half-band filter.
const FILLING: u8 = 9;

#[cfg(test)]
pub(crate) mod tests;
