//! Torque balance of the shaft → inertia, viscous and Coulomb friction, torque constant.
//!
//! Enters: current i, velocity ω, its reference r, load torque T. Leaves: [`BalanceSums`], which
//! [`super::balance_solve`] solves once a segment, and at each sample the residual in which [`super::orders`] looks for
//! bearing orders.
//!
//! ```text
//! i = p₀ ω̇ + p₁ ω + p₂ s(r) + p₃ T + p₄,   s(r) = clamp(r/r₀, −1, 1)                                  (1)
//! p₀ = J/Kt,   p₁ = B/Kt,   p₂ = Tc/Kt,   p₃ = 1/Kt,   p₄: offsets                                   (2)
//! instruments: ṙ for ω̇, r for ω; s, T and 1 for themselves                                            (3)
//! ρ(k) = (e(k) + e(k−1))/2 − p₀ (ω(k) − ω(k−1))/Ts,   e = i − p₁ ω − p₂ s − p₃ T − p₄               (4)
//! p₅ = p₂ + p₁ ω₀,   the drag at a usual velocity ω₀                                                  (5)
//! ```
//!
//! All signals of (1) pass the same [`StateVariable`] filter, which gives ω̇ without differentiating noise; every n-th
//! filtered sample is a row. The reference contains no velocity noise, so (3) is consistent, while least squares would
//! attribute that noise to friction. The current is the output because the load is usually known better; therefore all
//! parameters are in amperes. The rows are those of instrumental variables, `[s T 1 | ṙ r | ω̇ ω | i]`; sums and solve
//! are shared with the regression. A row is rotated into the sums one pivot a sample, so that no sample pays for all of
//! it.
//!
//! If the velocity hardly varies, viscous and Coulomb friction cannot be separated. A weak prior then holds p₁ at its
//! nominal value (weight: 0.1 row); if the instruments are too weak even so, a strong one (ten times the number of
//! rows). The errors of p₁ and p₂ then cancel in p₅, so (5) is still estimated well. (4) is (1) by the trapezoidal rule
//! over one interval with the *nominal* parameters; it attenuates no frequency.
//!
//! State: 60 words. Cost: `cargo xtask measure` prints it.

use super::state_variable::{Cell, StateVariable};
use crate::factor::kernels::{packed, rotate_pivot, rotate_pivot_small};
use crate::factor::{NEVER, PRIOR};

/// Estimated parameters of (1), p₀ … p₄.
pub(super) const ESTIMATED: usize = 5;
const COLUMNS: usize = 8;
const PACKED: usize = 28;

/// Constants of the torque balance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Balance {
    /// Sampling interval Ts.
    pub interval_s: f32,
    /// The low-pass before the rows of (1).
    pub filter: StateVariable,
    /// Samples from row to row.
    pub row_interval: u8,
    /// Samples withheld until the filters have settled.
    pub settle: u16,
    /// r₀ of (1).
    pub sign_velocity_rad_s: f32,
    /// ω₀ of (5).
    pub usual_velocity_rad_s: f32,
    /// Power-of-two factors of the columns ω̇, ω, T and i that scale them to rms ≈ 1.
    pub scale: [f32; 4],
    /// p₀ … p₄ of the healthy drive.
    pub nominal: [f32; ESTIMATED],
}

/// The signals of the balance at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Torques {
    /// Current.
    pub current_a: f32,
    /// Velocity.
    pub velocity_rad_s: f32,
    /// Velocity reference.
    pub reference_rad_s: f32,
    /// Load torque.
    pub load_nm: f32,
}

impl Balance {
    /// A row with the nominal p₁ and nothing else.
    pub(super) fn prior(&self, load: bool, rows: f32) -> [f32; COLUMNS] {
        let ([_, velocity, _, current], [_, viscous, ..]) = (self.scale, self.nominal);
        let target = viscous * current / velocity;
        let row = if load {
            [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, target]
        } else {
            [0.0, 0.0, 0.0, 1.0, 0.0, 1.0, target, 0.0]
        };
        let weight = libm::sqrtf(rows);
        row.map(|cell| cell * weight)
    }

    #[inline(always)]
    fn sign(&self, reference_rad_s: f32) -> f32 {
        (reference_rad_s / self.sign_velocity_rad_s).clamp(-1.0, 1.0)
    }

    /// e of (4).
    #[inline(always)]
    fn unexplained(&self, now: &Torques, sign: f32) -> f32 {
        let [_, p1, p2, p3, p4] = self.nominal;
        now.current_a - p1 * now.velocity_rad_s - p2 * sign - p3 * now.load_nm - p4
    }
}

/// The sums of the balance, and the row that is being rotated into them. Without a load there is one column less.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BalanceSums {
    pub(super) d: [f32; COLUMNS],
    pub(super) r: [f32; PACKED],
    row: [f32; COLUMNS],
    weight: f32,
    /// The next pivot of the row; all are done from `COLUMNS` on.
    pivot: usize,
    pub(super) rows: u32,
}

impl BalanceSums {
    pub(super) const fn new() -> Self {
        Self { d: [PRIOR; COLUMNS], r: [0.0; PACKED], row: [0.0; COLUMNS], weight: 0.0, pivot: COLUMNS, rows: 0 }
    }

    /// Takes a row, to be rotated in by [`BalanceSums::rotate`].
    #[inline(always)]
    pub(super) fn start(&mut self, row: [f32; COLUMNS]) {
        (self.row, self.weight, self.pivot) = (row, 1.0, 0);
    }

    /// Rotates in the next pivot; returns whether one was left.
    #[inline(always)]
    pub(super) fn rotate(&mut self, load: bool) -> bool {
        self.rotate_by(load, |d, r, x, later, weight| rotate_pivot::<false>(d, r, x, later, weight, NEVER))
    }

    #[inline(always)]
    fn rotate_by(&mut self, load: bool, pivot: impl Fn(&mut f32, &mut [f32], f32, &mut [f32], &mut f32)) -> bool {
        let (i, columns) = (self.pivot, columns(load));
        if i >= columns {
            return false;
        }
        self.pivot = i.wrapping_add(1);
        let start = packed(columns, i, i.wrapping_add(1));
        let (d, r) = (self.d.get_mut(i), self.r.get_mut(start..));
        let row = self.row.get_mut(i..columns).and_then(<[f32]>::split_first_mut);
        if let (Some(d), Some(r), Some((x, later))) = (d, r, row) {
            pivot(d, r, *x, later, &mut self.weight);
        }
        true
    }

    /// Rotates in the next pivots for about `budget` instructions; returns whether one was left.
    #[inline(never)]
    pub(super) fn rotate_some(&mut self, load: bool, budget: usize) -> bool {
        let before = self.pivot;
        let mut spent = 0_usize;
        while spent < budget && self.rotate_by(load, rotate_pivot_small) {
            spent = spent.saturating_add(PIVOT);
        }
        self.pivot > before
    }
}

/// Instructions of the longest pivot, about.
const PIVOT: usize = 160;

#[inline(always)]
pub(super) const fn columns(load: bool) -> usize {
    if load { COLUMNS } else { COLUMNS - 1 }
}

/// Running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BalanceState {
    current: Cell,
    velocity: Cell,
    reference: Cell,
    load: Cell,
    sign: Cell,
    sums: BalanceSums,
    /// Samples until the next row.
    due: u16,
    /// Pivots rotated in at each sample.
    pivots: u8,
    /// e and ω of the last sample.
    last: (f32, f32),
}

impl BalanceState {
    pub(super) fn new(balance: &Balance) -> Self {
        let cell = Cell::at(0.0);
        Self {
            current: cell,
            velocity: cell,
            reference: cell,
            load: cell,
            sign: cell,
            sums: BalanceSums::new(),
            due: 0,
            pivots: 8_u8.div_ceil(balance.row_interval.max(1)),
            last: (0.0, 0.0),
        }
    }

    /// The first sample, or the first after a gap: all filters start at rest on it.
    #[cold]
    #[inline(never)]
    pub(super) fn start(&mut self, balance: &Balance, now: &Torques) {
        let sign = balance.sign(now.reference_rad_s);
        self.current = Cell::at(now.current_a);
        self.velocity = Cell::at(now.velocity_rad_s);
        self.reference = Cell::at(now.reference_rad_s);
        self.load = Cell::at(now.load_nm);
        self.sign = Cell::at(sign);
        self.due = balance.settle.saturating_add(1);
        self.last = (balance.unexplained(now, sign), now.velocity_rad_s);
    }

    /// Takes the next sample; returns ρ of (4).
    #[inline(always)]
    pub(super) fn step(&mut self, balance: &Balance, load: bool, now: &Torques) -> f32 {
        let Torques { current_a, velocity_rad_s, reference_rad_s, load_nm } = *now;
        let sign = balance.sign(reference_rad_s);
        let e = balance.unexplained(now, sign);
        let (e_1, velocity_1) = core::mem::replace(&mut self.last, (e, velocity_rad_s));
        let bank = &balance.filter;
        let (i, _) = self.current.step(bank, current_a);
        let (w, slope) = self.velocity.step(bank, velocity_rad_s);
        let (r, r_slope) = self.reference.step(bank, reference_rad_s);
        let (t, _) = if load { self.load.step(bank, load_nm) } else { (0.0, 0.0) };
        let (s, _) = self.sign.step(bank, sign);
        for _ in 0..self.pivots {
            if !self.sums.rotate(load) {
                break;
            }
        }
        if self.due > 1 {
            self.due = self.due.wrapping_sub(1);
        } else {
            self.due = u16::from(balance.row_interval);
            let [acceleration, velocity, load_scale, current] = balance.scale;
            let rate = bank.rate_per_s;
            let (w, dw, i) = (w * velocity, slope * rate * acceleration, i * current);
            let (r, dr) = (r * velocity, r_slope * rate * acceleration);
            let row = if load { [s, t * load_scale, 1.0, dr, r, dw, w, i] } else { [s, 1.0, dr, r, dw, w, i, 0.0] };
            self.sums.start(row);
            self.sums.rows = self.sums.rows.saturating_add(1);
        }
        let [p0, ..] = balance.nominal;
        0.5 * (e + e_1) - p0 * (velocity_rad_s - velocity_1) / balance.interval_s // (4)
    }

    /// The sums so far.
    #[inline(always)]
    pub(super) const fn sums(&self) -> &BalanceSums {
        &self.sums
    }

    #[inline(always)]
    pub(super) fn next_segment(&mut self) {
        (self.sums.d, self.sums.r) = ([PRIOR; COLUMNS], [0.0; PACKED]);
        (self.sums.pivot, self.sums.rows) = (COLUMNS, 0);
    }
}
