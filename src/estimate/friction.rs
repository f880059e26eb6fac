//! Torque balance of the shaft → inertia, viscous and Coulomb friction, torque constant.
//!
//! Enters: current i, velocity ω, its reference r, load torque T. Leaves, once a segment, [`Friction`]; each sample, the
//! residual that [`super::order_tracking`] listens to.
//!
//! ```text
//! i = p₀ ω̇ + p₁ ω + p₂ s(r) + p₃ T + p₄,   s(r) = clamp(r/r₀, −1, 1)                                  (1)
//! p₀ = J/Kt,   p₁ = B/Kt,   p₂ = Tc/Kt,   p₃ = 1/Kt,   p₄: offsets                                   (2)
//! instruments: ṙ for ω̇, r for ω; s, T and 1 for themselves                                            (3)
//! ρ(k) = (e(k) + e(k−1))/2 − p₀ (ω(k) − ω(k−1))/Ts,   e = i − p₁ ω − p₂ s − p₃ T − p₄               (4)
//! p₅ = p₂ + p₁ ω₀,   the drag at a usual velocity ω₀                                                  (5)
//! ```
//!
//! All signals of (1) pass the same [`StateVariable`] filter, which gives ω̇ without differentiating noise, and every n-th filtered
//! sample is a row of the triangle. The reference knows nothing of the velocity's noise, so (3) is consistent where least squares
//! takes that noise for friction. The current is the output, since the load is as a rule what is known best; all parameters are so
//! in amperes. The rows are those of instrumental variables, `[s T 1 | ṙ r | ω̇ ω | i]`: factor, solve and checks are shared with
//! the estimator. A drive that knows but one speed cannot tell viscous from Coulomb friction. Then a tenth of a row that holds the
//! nominal p₁ decides, and where even that is too weak, ten times all rows of it; (5) is what such a drive can tell: p₁ and p₂ err
//! against each other, p₅ does not. (4) is (1) by the trapezoidal rule over one interval with the *nominal* parameters: it keeps every frequency.

use super::solve::{Head, Solution};
use super::state_variable::{Cell, StateVariable};
use super::{AnyShape, Counts, Estimate, Mass, Method, Order, Reason, Regression, Triangle};

/// Parameters of (1), and the drag (5).
pub const FRICTION_PARAMETERS: usize = 6;
/// Parameters that are estimated.
const ESTIMATED: usize = 5;
/// Rows of full excitation that the nominal viscous friction is worth, unless the velocity says too little.
const PRIOR_ROWS: f32 = 0.1;
const COLUMNS: usize = 8;
const PACKED: usize = 28;

/// Constants of the torque balance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Balance {
    /// Interval of the samples Ts.
    pub interval_s: f32,
    /// The low-pass before the rows of (1).
    pub filter: StateVariable,
    /// Every so many samples give a row.
    pub row_interval: u8,
    /// Samples withheld until the filters have settled.
    pub settle: u16,
    /// r₀ of (1).
    pub sign_velocity_rad_s: f32,
    /// ω₀ of (5).
    pub usual_velocity_rad_s: f32,
    /// Whether the load torque is measured; if not, p₃ is zero and the load must be in the residual.
    pub load: bool,
    /// Power-of-two factors of the columns ω̇, ω, T and i that bring them to rms ≈ 1.
    pub scale: [f32; 4],
    /// p of the healthy drive.
    pub nominal: [f32; ESTIMATED],
}

/// What a segment says about the torque balance. Parameters in the order of (2), all in amperes by the unit of their signal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Friction {
    /// p₀ … p₅.
    pub parameters: [f32; FRICTION_PARAMETERS],
    /// Their standard deviations, as if the rows' residuals were independent.
    pub deviations: [f32; FRICTION_PARAMETERS],
    /// (p − nominal)/deviation: comparable between segments that tell more and less.
    pub scores: [f32; FRICTION_PARAMETERS],
    /// Residual variance of the filtered balance, A².
    pub variance: f32,
    /// Rows of the triangle.
    pub rows: u32,
}

impl Friction {
    /// Kt in N·m/A; infinite where no load is measured.
    #[must_use]
    pub fn torque_constant_nm_a(&self) -> f32 {
        let [_, _, _, load, ..] = self.parameters;
        1.0 / load
    }

    /// J, from the torque constant that is estimated beside it.
    #[must_use]
    pub fn inertia_kg_m2(&self) -> f32 {
        let [inertia, ..] = self.parameters;
        inertia * self.torque_constant_nm_a()
    }

    /// B.
    #[must_use]
    pub fn viscous_nm_s_rad(&self) -> f32 {
        let [_, viscous, ..] = self.parameters;
        viscous * self.torque_constant_nm_a()
    }

    /// Tc.
    #[must_use]
    pub fn coulomb_nm(&self) -> f32 {
        let [_, _, coulomb, ..] = self.parameters;
        coulomb * self.torque_constant_nm_a()
    }
}

/// One sample of the balance's signals, brought to one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Torques {
    pub(super) current_a: f32,
    pub(super) velocity_rad_s: f32,
    pub(super) reference_rad_s: f32,
    pub(super) load_nm: f32,
}

impl Balance {
    /// Terms of (1) that the estimator's structures know: two with an instrument apart, one or two others, and a constant.
    const fn order(&self) -> Order {
        Order::new(2, 1, self.load as u8, 1, 1)
    }

    /// (1) as a regression: its parameters are p without what is not estimated.
    fn regression(&self) -> Regression<COLUMNS> {
        let [acceleration, velocity, load, current] = self.scale;
        let scale = if self.load {
            [acceleration, velocity, 1.0, load, 1.0, current, 1.0, 1.0]
        } else {
            [acceleration, velocity, 1.0, 1.0, current, 1.0, 1.0, 1.0]
        };
        Regression { method: Method::Instruments, scale, ..Regression::new(self.order(), true) }
    }

    /// A row that holds the nominal p₁ and nothing else.
    fn prior(&self) -> [f32; COLUMNS] {
        let ([_, velocity, _, current], [_, viscous, ..]) = (self.scale, self.nominal);
        let target = viscous * current / velocity;
        if self.load {
            [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, target]
        } else {
            [0.0, 0.0, 0.0, 1.0, 0.0, 1.0, target, 0.0]
        }
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

/// Running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct FrictionState {
    current: Cell,
    velocity: Cell,
    reference: Cell,
    load: Cell,
    sign: Cell,
    sums: Triangle<COLUMNS, PACKED>,
    rows: u32,
    /// Samples until the next row.
    due: u32,
    /// e and ω of the last sample.
    last: (f32, f32),
}

impl FrictionState {
    pub(super) fn new(balance: &Balance) -> Self {
        let cell = Cell::at(0.0);
        Self {
            current: cell,
            velocity: cell,
            reference: cell,
            load: cell,
            sign: cell,
            sums: Triangle::new(if balance.load { COLUMNS } else { COLUMNS - 1 }),
            rows: 0,
            due: 0,
            last: (0.0, 0.0),
        }
    }

    /// The first sample, or the first one after others were missing: all filters at rest on it.
    #[cold]
    pub(super) fn start(&mut self, balance: &Balance, now: &Torques) {
        let sign = balance.sign(now.reference_rad_s);
        self.current = Cell::at(now.current_a);
        self.velocity = Cell::at(now.velocity_rad_s);
        self.reference = Cell::at(now.reference_rad_s);
        self.load = Cell::at(now.load_nm);
        self.sign = Cell::at(sign);
        self.due = u32::from(balance.settle) + 1;
        self.last = (balance.unexplained(now, sign), now.velocity_rad_s);
    }

    /// Takes the next sample; gives ρ of (4).
    // One caller, at every sample: a call would cost a seventh of it.
    #[inline(always)]
    pub(super) fn step(&mut self, balance: &Balance, now: &Torques) -> f32 {
        let Torques { current_a, velocity_rad_s, reference_rad_s, load_nm } = *now;
        let sign = balance.sign(reference_rad_s);
        let e = balance.unexplained(now, sign);
        let (e_1, velocity_1) = core::mem::replace(&mut self.last, (e, velocity_rad_s));
        let bank = &balance.filter;
        let (i, _) = self.current.step(bank, current_a);
        let (w, slope) = self.velocity.step(bank, velocity_rad_s);
        let (r, r_slope) = self.reference.step(bank, reference_rad_s);
        let (t, _) = self.load.step(bank, load_nm);
        let (s, _) = self.sign.step(bank, sign);
        if self.due > 1 {
            self.due -= 1;
        } else {
            self.due = u32::from(balance.row_interval);
            self.row(balance, [i, w, slope * bank.rate_per_s, r, r_slope * bank.rate_per_s, t, s]);
        }
        let [p0, ..] = balance.nominal;
        0.5 * (e + e_1) - p0 * (velocity_rad_s - velocity_1) / balance.interval_s // (4)
    }

    /// One sample in a few.
    #[inline(never)]
    fn row(&mut self, balance: &Balance, [i, w, dw, r, dr, t, s]: [f32; 7]) {
        let [acceleration, velocity, load, current] = balance.scale;
        let (w, dw, r, dr, i) = (w * velocity, dw * acceleration, r * velocity, dr * acceleration, i * current);
        let row = if balance.load { [s, t * load, 1.0, dr, r, dw, w, i] } else { [s, 1.0, dr, r, dw, w, i, 0.0] };
        self.sums.update(&row);
        self.rows = self.rows.saturating_add(1);
    }

    /// The sums, for who solves them elsewhere.
    pub(super) fn sums(&self) -> FrictionSums {
        FrictionSums { sums: self.sums.clone(), rows: self.rows }
    }

    pub(super) const fn next_segment(&mut self) {
        self.sums.reset();
        self.rows = 0;
    }
}

/// A segment's sums of the torque balance.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct FrictionSums {
    sums: Triangle<COLUMNS, PACKED>,
    rows: u32,
}

impl FrictionSums {
    /// # Errors
    /// As those of the estimator: too few rows, not excited (parameters in the order p₀ p₁ p₂ p₃ p₄ without what is not
    /// estimated), weak instruments, not finite.
    pub(super) fn solve(&self, balance: &Balance) -> Result<Friction, Reason> {
        let mut estimate = Estimate::<COLUMNS, PACKED>::empty(balance.order(), true, self.rows, Counts::default());
        self.estimate_into(balance, &mut estimate)?;
        let mut friction = Friction { variance: estimate.variance, rows: self.rows, ..Friction::default() };
        // Without a load its place is left out.
        let places = (0..ESTIMATED).filter(|&place| balance.load || place != 3);
        for (from, place) in places.enumerate() {
            let value = estimate.delta.get(from).copied().unwrap_or(0.0);
            let variance = estimate.covariance.get(from * (from + 3) / 2).copied().unwrap_or(0.0);
            let deviation = libm::sqrtf(variance.max(f32::MIN_POSITIVE));
            let cells = (friction.parameters.get_mut(place), friction.deviations.get_mut(place));
            let nominal = balance.nominal.get(place).copied().unwrap_or(0.0);
            if let ((Some(parameter), Some(own)), Some(score)) = (cells, friction.scores.get_mut(place)) {
                (*parameter, *own, *score) = (value, deviation, (value - nominal) / deviation);
            }
        }
        // (5)
        let ([_, p1, p2, ..], [_, n1, n2, ..], speed) =
            (friction.parameters, balance.nominal, balance.usual_velocity_rad_s);
        let [_, _, v11, _, v12, v22, ..] = estimate.covariance;
        let deviation = libm::sqrtf((v22 + speed * (2.0 * v12 + speed * v11)).max(f32::MIN_POSITIVE));
        let (drag, nominal) = (p2 + p1 * speed, n2 + n1 * speed);
        let ([.., parameter], [.., own], [.., score]) =
            (&mut friction.parameters, &mut friction.deviations, &mut friction.scores);
        (*parameter, *own, *score) = (drag, deviation, (drag - nominal) / deviation);
        let sum: f32 = friction.scores.iter().sum();
        if sum.is_finite() { Ok(friction) } else { Err(Reason::NotFinite) }
    }

    /// Solves with a little of the nominal p₁, and with much of it where the instruments are too weak without.
    // Out of line: its sums have left the stack when the rest begins.
    #[inline(never)]
    fn estimate_into(&self, balance: &Balance, estimate: &mut Estimate<COLUMNS, PACKED>) -> Result<(), Reason> {
        let regression = balance.regression();
        let head = Head {
            mass: Mass { rows: self.rows as f32, spread: 1.0 },
            origin: [0.0; 3],
            base: [0.0; COLUMNS],
            gain: 1.0,
            counts: Counts::default(),
            at_rest: false,
            segment: 0,
        };
        let mut sums = self.sums.clone();
        let mut result = Err(Reason::WeakInstruments);
        for held in [PRIOR_ROWS, 10.0 * head.mass.rows] {
            if result != Err(Reason::WeakInstruments) {
                break;
            }
            let mut row = balance.prior();
            row.iter_mut().for_each(|cell| *cell *= libm::sqrtf(held));
            sums.update(&row);
            *estimate = Estimate::empty(balance.order(), true, self.rows, head.counts);
            result = Solution::new().finish::<AnyShape, COLUMNS, PACKED>((&regression, &head), &sums, estimate);
        }
        result
    }
}
