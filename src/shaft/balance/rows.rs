//! Torque balance of the shaft → rows of least squares, and the parameters that hold at present.
//!
//! Enters: current i, velocity ω, load torque T. Leaves: [`BalanceSums`], which [`super::solve`] solves once a
//! segment, and the parameters with which [`orders`](crate::shaft::orders) forms the residual of each sample.
//!
//! ```text
//! i = p₀ ω̇ + p₁ ω + p₂ s + p₃ T + p₄ + p₅ |T| s + p₆ s/(1 + (ω/ω_s)²)                                 (1)
//! s = clamp(ω/ω_r, −1, 1)                                                                             (2)
//! p₀ = J/Kt,  p₁ = B/Kt,  p₂ = Tc/Kt,  p₃ = 1/Kt,  p₄: offsets,  p₅ = μ/Kt,  p₆ = (Ts − Tc)/Kt        (3)
//! p₇ = p₂ + p₁ ω₀ + p₅ T₀ + p₆/(1 + (ω₀/ω_s)²),   the drag at a usual velocity ω₀ and load T₀         (4)
//! p₃ cos ψ + p₅ sin ψ  instead of  p₃ T + p₅ |T| s,   W = √(p₃² + p₅²)                                (6)
//! Λ⁻¹ ← Λ⁻¹ + v vᵀ,   v = (p₃, p₅)/2                                                                  (7)
//! ```
//!
//! p₅ is friction in proportion to the load (μ = 1/η − 1 of a screw of efficiency η), p₆ the Stribeck part of friction:
//! the excess of break-away friction Ts over sliding friction Tc. A weight on an axis behind a gear or belt is a sine
//! of the axis' angle ψ, which the motor knows but for where it started: (6) is the load of such a plan, of unknown
//! amplitude W and phase. If the payload changes within a segment, the weight may have changed by half of itself behind
//! each rest (7): Λ is the information of the rows, of which only that on p₃ and p₅ given the other terms is lost. Rows
//! at rest, where a brake or dry friction may carry the weight, are then left out.
//!
//! All signals of (1) pass the same [`StateVariable`] filter, which gives ω̇ without differentiating noise; every n-th
//! filtered sample is a row. The sign (2) is that of the *measured* velocity: under a fluctuating load the velocity
//! reverses when the reference does not, and friction follows the velocity. The current is the output because the load
//! is usually known better; therefore all parameters are in amperes.
//!
//! Each segment starts from a weak prior, the healthy parameters with [`TorqueBalance::prior`] as their deviations,
//! as if earlier rows had given them. A parameter that the motion does not excite keeps its prior: at constant speed
//! p₁ and p₂ cannot be separated, their deviations are large, and their errors cancel in (4). A prior draws its
//! parameter towards the healthy value; for features of a classifier its effect is removed:
//!
//! ```text
//! p′ = n + (p − n)/c,   σ′² = σ²/c,   c = 1 − σ² σ₀²/(prior² s²)                                        (5)
//! ```
//!
//! n is nominal, s² the variance of the residual and σ₀² that of healthy ones: the precision of p is the sum of that of
//! the rows, c/σ², and of its own prior. The priors of the other terms and of p₇ stay. c is at least 1/64.
//!
//! A row is rotated into the sums one pivot a sample, or more if rows are less than eight samples apart, so that the
//! work is distributed. After every [`ROWS_A_REFRESH`] rows the time of one row is used for a back substitution, as
//! many parameters a sample as pivots: the present parameters then follow the segment. If the nominal parameters fit
//! better than an estimate of a part of a segment, they are kept ([`TorqueBalance::adapt_after_rows`]).
//!
//! `cargo xtask measure` prints instructions and state of a detector with it.

use super::friction::{Friction, Parameter};
use super::state_variable::{Cell, StateVariable};
use super::sums::{BalanceSums, columns};
use crate::plan::Load;
use crate::reason::FrictionTerm;
use crate::record::{LONGEST_S, record};
use crate::regression::factor::kernels::pairs;
use crate::unroll::no_unroll;

/// Number of parameters of (1).
pub const TERMS: usize = 7;
pub(super) const COLUMNS: usize = TERMS + 1;
/// Rows between two back substitutions.
const ROWS_A_REFRESH: u8 = 16;
/// Least c of (5): a smaller one consists of rounding errors.
pub const LEAST_FROM_ROWS: f32 = 1.0 / 64.0;
/// Filtered velocity below which a shaft rests before its next move, in parts of the usual one. A controller that holds
/// a weight lets it drift.
pub const RESTING: f32 = 0.15;
/// Rows in a row below it that are a rest.
pub const RESTING_ROWS: u8 = 3;
/// The terms of (1) in a plan without a load.
pub(super) const WITHOUT_LOAD: [usize; 5] = [0, 1, 2, 4, 6];
const WITH_LOAD: [usize; TERMS] = [0, 1, 2, 3, 4, 5, 6];
/// Deviation of what a rest adds to the weight, in parts of the weight.
const PAYLOAD: f32 = 0.5;

record! {
    /// Constants of the torque balance.
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[cfg_attr(feature = "defmt", derive(defmt::Format))]
    pub struct TorqueBalance: BalanceInterval {
        /// Sampling interval Ts.
        pub interval_s: f32 in [f32::MIN_POSITIVE, LONGEST_S],
        /// The low-pass before the rows of (1).
        pub filter: StateVariable,
        /// Samples from row to row.
        pub row_interval: u8 in [1, u8::MAX] or RowInterval,
        /// Samples withheld until the filters have settled.
        pub settle: u16,
        /// `ω_r` of (2): about three standard deviations of the velocity's noise.
        pub sign_velocity_rad_s: f32 in [1e-6, 1e6] or BalanceVelocity,
        /// `ω_s` of (1).
        pub stribeck_velocity_rad_s: f32 in [1e-6, 1e6] or BalanceVelocity,
        /// ω₀ of (4).
        pub usual_velocity_rad_s: f32 in [1e-6, 1e6] or BalanceVelocity,
        /// T₀ of (4).
        pub usual_load_nm: f32 in [0.0, 1e6] or BalanceVelocity,
        /// Rows per independent row: the filter makes neighbouring rows alike.
        pub row_spread: f32 in [1.0, 1e3] or RowInterval,
        /// Standard deviation of a healthy row's residual, A.
        pub deviation: f32 in [1e-9, 1e9] or BalancePrior,
        /// Number of rows of a segment after which the residual of the orders is formed with the segment's own
        /// parameters; until then it is formed with those of the segment before. With 65535 it is always formed with
        /// the nominal ones.
        pub adapt_after_rows: u16,
        /// Power-of-two factors of the columns of (1) and of i that scale them to rms ≈ 1.
        pub scale: [f32; COLUMNS],
        /// p₀ … p₆ of the healthy drive.
        pub nominal: [f32; TERMS] in [-1e12, 1e12] or BalanceNominal,
        /// Prior deviations of p₀ … p₆.
        pub prior: [f32; TERMS] in [1e-12, 1e12] or BalancePrior,
        /// Largest change of the angle's motion from one sample to the next, rad: a larger one is no motion of the
        /// shaft. Infinite if it is not checked.
        pub largest_change_rad: f32 in [f32::MIN_POSITIVE, f32::INFINITY] or LargestChange,
    }
}

/// The signals of the balance at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Torques {
    /// Current.
    pub current_a: f32,
    /// Velocity.
    pub velocity_rad_s: f32,
    /// Load torque.
    pub load_nm: f32,
}

/// The terms of (1) besides velocity and offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::shaft) struct Regressors {
    pub sign: f32,
    pub stribeck: f32,
    /// T and |T| s, or those of (6).
    pub load: [f32; 2],
}

impl TorqueBalance {
    /// n of a parameter, or of the drag (4).
    pub(crate) fn nominal_of(&self, term: FrictionTerm) -> f32 {
        let drag = || pairs(self.in_drag(), &self.nominal).map(|(weight, nominal)| weight * nominal).sum();
        self.nominal.get(term as usize).copied().unwrap_or_else(drag)
    }

    /// By how much a parameter, or the drag, rises with a rise of another by one; that of the drag itself is one of dry
    /// friction.
    pub(crate) fn rises_with(&self, own: FrictionTerm, other: FrictionTerm) -> f32 {
        match (own, other) {
            _ if own == other => 1.0,
            (FrictionTerm::Coulomb, FrictionTerm::Drag) => 1.0,
            (FrictionTerm::Drag, _) => self.in_drag().get(other as usize).copied().unwrap_or(0.0),
            _ => 0.0,
        }
    }

    /// The part of the information on a parameter that is of the rows and not of its prior: c of (5), 0 … 1. That of
    /// the drag is relative to what the priors of its terms say of it.
    #[must_use]
    pub fn part_of_rows(&self, friction: &Friction, term: FrictionTerm) -> f32 {
        let deviation = friction.of(term).map_or(0.0, |parameter| parameter.deviation);
        let prior = match self.prior.get(term as usize) {
            Some(prior) => prior * prior,
            None => pairs(self.in_drag(), &self.prior).map(|(weight, prior)| weight * prior * weight * prior).sum(),
        };
        let ratio = self.deviation * self.deviation / friction.variance.max(f32::MIN_POSITIVE);
        (1.0 - ratio * deviation * deviation / prior).max(0.0)
    }

    /// A parameter as the rows of a segment alone determine it, and its variance: without its prior, by (5), for
    /// features of a classifier. The drag keeps the priors of its terms; a parameter that was not estimated is 0
    /// without error.
    #[inline(never)]
    #[must_use]
    pub fn without_prior(&self, friction: &Friction, term: FrictionTerm) -> (f32, f32) {
        let Parameter { value, deviation, score } = *friction.of(term).unwrap_or(&Parameter::NONE);
        let variance = deviation * deviation;
        if self.prior.get(term as usize).is_none() {
            return (value, variance);
        }
        // f32::max returns the limit if the part is not a number.
        let part = self.part_of_rows(friction, term).max(LEAST_FROM_ROWS);
        // The score is p − n in deviations.
        (value + score * deviation * (1.0 / part - 1.0), variance / part)
    }

    /// The terms at an instant; `weight` are cosine and sine of (6) in a plan with a weight.
    #[inline(always)]
    pub(in crate::shaft) fn regressors(&self, now: &Torques, weight: Option<[f32; 2]>) -> Regressors {
        let sign = (now.velocity_rad_s / self.sign_velocity_rad_s).clamp(-1.0, 1.0); // (2)
        let ratio = now.velocity_rad_s / self.stribeck_velocity_rad_s;
        let load = weight.unwrap_or([now.load_nm, now.load_nm.abs() * sign]);
        Regressors { sign, stribeck: sign / (1.0 + ratio * ratio), load }
    }

    /// The terms that a plan estimates, in the order of the columns.
    #[inline(always)]
    pub(in crate::shaft) const fn terms(load: bool) -> &'static [usize] {
        if load { &WITH_LOAD } else { &WITHOUT_LOAD }
    }

    /// The coefficient of each of p₀ … p₆ in the drag (4).
    pub(in crate::shaft) fn in_drag(&self) -> [f32; TERMS] {
        let ratio = self.usual_velocity_rad_s / self.stribeck_velocity_rad_s;
        [0.0, self.usual_velocity_rad_s, 1.0, 0.0, 0.0, self.usual_load_nm, 1.0 / (1.0 + ratio * ratio)]
    }

    pub(in crate::shaft) fn scale_of(&self, term: usize) -> f32 {
        self.scale.get(term).copied().unwrap_or(1.0)
    }
}

/// Running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BalanceState {
    current: Cell,
    velocity: Cell,
    sign: Cell,
    stribeck: Cell,
    load: [Cell; 2],
    /// Samples until the next row.
    due: u16,
    /// Pivots rotated in at each sample, and parameters of a back substitution.
    pivots: u8,
    /// Rows until the next back substitution.
    refresh: u8,
    /// Rows in a row at rest, of a plan with a weight that changes.
    resting: u8,
    /// Parameters left in the present back substitution.
    left: usize,
    /// Its scaled parameters.
    scaled: [f32; TERMS],
    /// p₀ … p₆ that hold at present.
    present: [f32; TERMS],
}

impl BalanceState {
    pub(in crate::shaft) fn new(balance: &TorqueBalance) -> Self {
        let cell = Cell::at(0.0);
        Self {
            current: cell,
            velocity: cell,
            sign: cell,
            stribeck: cell,
            load: [cell; 2],
            due: 0,
            pivots: 8_u8.div_ceil(balance.row_interval.max(1)),
            refresh: ROWS_A_REFRESH,
            resting: 0,
            left: 0,
            scaled: [0.0; TERMS],
            present: balance.nominal,
        }
    }

    /// The first sample, or the first after a long gap: all filters start at rest on it.
    #[cold]
    #[inline(never)]
    pub(in crate::shaft) fn start(&mut self, balance: &TorqueBalance, now: &Torques, regressors: &Regressors) {
        let Regressors { sign, stribeck, load } = *regressors;
        self.current = Cell::at(now.current_a);
        self.velocity = Cell::at(now.velocity_rad_s);
        self.sign = Cell::at(sign);
        self.stribeck = Cell::at(stribeck);
        self.load = load.map(Cell::at);
        self.due = balance.settle.saturating_add(1);
    }

    /// Takes the next sample with its terms; a sample that is not `good` gives no row.
    #[inline(always)]
    pub(in crate::shaft) fn step(
        &mut self,
        sums: &mut BalanceSums,
        (balance, known): (&TorqueBalance, Load),
        now: &Torques,
        regressors: &Regressors,
        good: bool,
    ) {
        let (bank, load) = (&balance.filter, known.has_terms());
        let (i, _) = self.current.step(bank, now.current_a);
        let (w, slope) = self.velocity.step(bank, now.velocity_rad_s);
        let (s, _) = self.sign.step(bank, regressors.sign);
        let (b, _) = self.stribeck.step(bank, regressors.stribeck);
        let (t, q) = if load {
            let ([first, second], [t, q]) = (&mut self.load, regressors.load);
            (first.step(bank, t).0, second.step(bank, q).0)
        } else {
            (0.0, 0.0)
        };
        if self.left > 0 {
            self.substitute(sums, balance, load);
        }
        for _ in 0..self.pivots {
            if !sums.rotate(load) {
                break;
            }
        }
        if self.due > 1 {
            self.due = self.due.wrapping_sub(1);
            return;
        }
        self.due = u16::from(balance.row_interval);
        self.refresh = self.refresh.wrapping_sub(1);
        if self.refresh == 0 {
            self.refresh = ROWS_A_REFRESH;
            if sums.rows >= u32::from(balance.adapt_after_rows) && balance.adapt_after_rows < u16::MAX {
                self.left = columns(load).wrapping_sub(1);
            }
        } else if good && !(matches!(known, Load::Weight { changes: true, .. }) && self.rests(sums, balance, w)) {
            let [k0, k1, k2, k3, k4, k5, k6, k7] = balance.scale;
            let (a, w, s, b, i) = (slope * bank.rate_per_s * k0, w * k1, s * k2, b * k6, i * k7);
            let row = if load { [a, w, s, t * k3, k4, q * k5, b, i] } else { [a, w, s, k4, b, i, 0.0, 0.0] };
            sums.start(row);
            sums.rows = sums.rows.saturating_add(1);
        }
    }

    /// Whether the shaft rests by its filtered velocity. The first row behind it finds the weight loosened.
    #[inline(never)]
    fn rests(&mut self, sums: &mut BalanceSums, balance: &TorqueBalance, velocity_rad_s: f32) -> bool {
        let rested = self.resting >= RESTING_ROWS;
        if velocity_rad_s.abs() < RESTING * balance.usual_velocity_rad_s {
            self.resting = self.resting.saturating_add(1);
            return rested;
        }
        self.resting = 0;
        if rested {
            let [_, _, _, cos, _, sin, _] = self.present;
            let unit = PAYLOAD / (balance.deviation * libm::sqrtf(balance.row_spread));
            sums.loosen([unit * cos / balance.scale_of(3), unit * sin / balance.scale_of(5)]);
        }
        false
    }

    /// A parameter of the back substitution, or more where rows are close; with the last one they hold.
    #[inline(never)]
    fn substitute(&mut self, sums: &BalanceSums, balance: &TorqueBalance, load: bool) {
        for _ in 0..self.pivots {
            if self.left > 0 {
                self.substitute_one(sums, balance, load);
            }
        }
    }

    #[inline(always)]
    fn substitute_one(&mut self, sums: &BalanceSums, balance: &TorqueBalance, load: bool) {
        let (columns, terms) = (columns(load), TorqueBalance::terms(load));
        let k = self.left.wrapping_sub(1);
        let value = sums.substitute(columns, k, self.scaled.get(self.left..terms.len()).unwrap_or(&[]));
        if let Some(cell) = self.scaled.get_mut(k) {
            *cell = value;
        }
        self.left = k;
        if k == 0 {
            let target = balance.scale_of(TERMS);
            for (&term, scaled) in pairs(no_unroll(terms), &self.scaled) {
                if let Some(cell) = self.present.get_mut(term) {
                    *cell = scaled * balance.scale_of(term) / target;
                }
            }
        }
    }

    /// p₀ … p₆ that hold at present.
    #[inline(always)]
    pub(in crate::shaft) const fn present(&self) -> &[f32; TERMS] {
        &self.present
    }

    /// Whether they know the phase of (6), which the nominal ones do not.
    #[inline(always)]
    pub(in crate::shaft) const fn knows_weight(&self) -> bool {
        let [.., cos, _, sin, _] = self.present;
        cos != 0.0 || sin != 0.0
    }

    #[inline(always)]
    pub(in crate::shaft) const fn next_segment(&mut self) {
        (self.left, self.refresh) = (0, ROWS_A_REFRESH);
    }

    /// Lets a new segment start afresh, with the nominal parameters.
    #[inline(always)]
    pub(in crate::shaft) const fn renew(&mut self, balance: &TorqueBalance) {
        (self.due, self.present) = (0, balance.nominal);
    }
}
