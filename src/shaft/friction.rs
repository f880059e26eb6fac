//! Torque balance of the shaft → inertia, viscous and Coulomb friction, torque constant.
//!
//! Enters: current i, velocity ω, its reference r, load torque T. Leaves: [`Friction`] once a segment, and at each sample
//! the residual in which [`super::orders`] looks for bearing orders.
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
//! parameters are in amperes. The rows are those of instrumental variables, `[s T 1 | ṙ r | ω̇ ω | i]`; sums and solve are
//! shared with the regression. A row is rotated into the sums one pivot a sample, so that no sample pays for all of it.
//!
//! If the velocity hardly varies, viscous and Coulomb friction cannot be separated. A weak prior then holds p₁ at its
//! nominal value (weight: 0.1 row); if the instruments are too weak even so, a strong one (ten times the number of rows).
//! The errors of p₁ and p₂ then cancel in p₅, so (5) is still estimated well. (4) is (1) by the trapezoidal rule over one
//! interval with the *nominal* parameters; it attenuates no frequency.
//!
//! State: 60 words. Cost: `cargo xtask measure` prints it.

use super::state_variable::{Cell, StateVariable};
use crate::factor::kernels::{packed, rotate_pivot, rotate_pivot_small};
use crate::factor::{Mass, NEVER, PRIOR, Problem, Solution, SolveError, Solved, lower};
use crate::reason::{FrictionTerm, Part, Reason};

/// Estimated parameters of (1), p₀ … p₄.
const ESTIMATED: usize = 5;
/// Weight of the prior of the viscous friction, in rows of full excitation.
const PRIOR_ROWS: f32 = 0.1;
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

/// An estimated parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameter {
    /// Its value.
    pub value: f32,
    /// Its standard deviation, as if the residuals of the rows were independent.
    pub deviation: f32,
    /// (value − nominal)/deviation: comparable between segments with much and little excitation.
    pub score: f32,
}

/// The torque balance of a segment. All parameters are in amperes per unit of their signal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Friction {
    /// J/Kt, A·s²/rad.
    pub inertia: Parameter,
    /// B/Kt, A·s/rad.
    pub viscous: Parameter,
    /// Tc/Kt, A.
    pub coulomb: Parameter,
    /// 1/Kt, A/(N·m); `None` if the load is not measured.
    pub inverse_torque_constant: Option<Parameter>,
    /// Offset of current and load, A.
    pub offset: Parameter,
    /// Friction at the usual velocity (5), A.
    pub drag: Parameter,
    /// Residual variance of the filtered balance, A².
    pub variance: f32,
    /// Number of rows.
    pub rows: u32,
}

impl Friction {
    /// A parameter by its name; `None` for the torque constant if the load is not measured.
    #[must_use]
    pub const fn parameter(&self, term: FrictionTerm) -> Option<Parameter> {
        match term {
            FrictionTerm::Inertia => Some(self.inertia),
            FrictionTerm::Viscous => Some(self.viscous),
            FrictionTerm::Coulomb => Some(self.coulomb),
            FrictionTerm::InverseTorqueConstant => self.inverse_torque_constant,
            FrictionTerm::Offset => Some(self.offset),
            FrictionTerm::Drag => Some(self.drag),
        }
    }

    /// Torque constant Kt, N·m/A, with its standard deviation; `None` if the load is not measured.
    #[must_use]
    pub fn torque_constant_nm_a(&self) -> Option<(f32, f32)> {
        let inverse = self.inverse_torque_constant?;
        let value = 1.0 / inverse.value;
        Some((value, inverse.deviation * value * value))
    }

    /// Moment of inertia J, kg·m², by the estimated torque constant.
    #[must_use]
    pub fn inertia_kg_m2(&self) -> Option<f32> {
        self.torque_constant_nm_a().map(|(kt, _)| self.inertia.value * kt)
    }

    /// Viscous friction B, N·m·s/rad, by the estimated torque constant.
    #[must_use]
    pub fn viscous_nm_s_rad(&self) -> Option<f32> {
        self.torque_constant_nm_a().map(|(kt, _)| self.viscous.value * kt)
    }

    /// Coulomb friction Tc, N·m, by the estimated torque constant.
    #[must_use]
    pub fn coulomb_nm(&self) -> Option<f32> {
        self.torque_constant_nm_a().map(|(kt, _)| self.coulomb.value * kt)
    }
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
    fn prior(&self, load: bool, rows: f32) -> [f32; COLUMNS] {
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
    d: [f32; COLUMNS],
    r: [f32; PACKED],
    row: [f32; COLUMNS],
    weight: f32,
    /// The next pivot of the row; all are done from `COLUMNS` on.
    pivot: usize,
    rows: u32,
}

impl BalanceSums {
    const fn new() -> Self {
        Self { d: [PRIOR; COLUMNS], r: [0.0; PACKED], row: [0.0; COLUMNS], weight: 0.0, pivot: COLUMNS, rows: 0 }
    }

    /// Takes a row, to be rotated in by [`BalanceSums::rotate`].
    #[inline(always)]
    fn start(&mut self, row: [f32; COLUMNS]) {
        (self.row, self.weight, self.pivot) = (row, 1.0, 0);
    }

    /// Rotates in the next pivot; returns whether one was left.
    #[inline(always)]
    fn rotate(&mut self, load: bool) -> bool {
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
    fn rotate_some(&mut self, load: bool, budget: usize) -> bool {
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
const fn columns(load: bool) -> usize {
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

/// What the next step of a solve does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Stage {
    /// Rotate in what is left of the last row.
    Last,
    /// Rotate in the prior.
    Prior,
    /// Solve.
    Solve,
    /// Parameters with deviations and scores.
    Results,
}

/// A solve of the torque balance under way.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BalanceSolve {
    stage: Stage,
    /// Whether the strong prior is in.
    strong: bool,
    solution: Solution,
    delta: [f32; ESTIMATED],
    covariance: [f32; ESTIMATED * (ESTIMATED + 1) / 2],
    work: [f32; ESTIMATED],
    variance: f32,
    /// Number of calls of [`BalanceSolve::results`].
    results: u8,
}

impl BalanceSolve {
    pub(super) const fn new() -> Self {
        Self {
            stage: Stage::Last,
            strong: false,
            solution: Solution::new(),
            delta: [0.0; ESTIMATED],
            covariance: [0.0; ESTIMATED * (ESTIMATED + 1) / 2],
            work: [0.0; ESTIMATED],
            variance: 0.0,
            results: 0,
        }
    }

    /// Does about `budget` instructions; the result once `friction` is complete.
    #[inline(never)]
    pub(super) fn advance(
        &mut self,
        balance: &Balance,
        load: bool,
        sums: &mut BalanceSums,
        friction: &mut Friction,
        budget: usize,
    ) -> Option<Result<(), Reason>> {
        match self.stage {
            Stage::Last => {
                if !sums.rotate_some(load, budget) {
                    sums.start(balance.prior(load, PRIOR_ROWS));
                    self.stage = Stage::Prior;
                }
                None
            }
            Stage::Prior => {
                if !sums.rotate_some(load, budget) {
                    self.stage = Stage::Solve;
                }
                None
            }
            Stage::Solve => match self.solve(balance, load, sums, budget) {
                Ok(false) => None,
                Ok(true) => {
                    friction.rows = sums.rows;
                    self.stage = Stage::Results;
                    None
                }
                Err(SolveError::WeakInstruments) if !self.strong => {
                    *self = Self { stage: Stage::Prior, strong: true, ..Self::new() };
                    sums.start(balance.prior(load, 10.0 * sums.rows as f32));
                    None
                }
                Err(error) => Some(Err(reason(error, load, sums.rows))),
            },
            Stage::Results => {
                if !self.results(balance, load, friction) {
                    return None;
                }
                if friction.is_finite() {
                    return Some(Ok(()));
                }
                *friction = Friction::default();
                Some(Err(Reason::NotFinite(Part::TorqueBalance)))
            }
        }
    }

    fn solve(
        &mut self,
        balance: &Balance,
        load: bool,
        sums: &mut BalanceSums,
        budget: usize,
    ) -> Result<bool, SolveError> {
        let [acceleration, velocity, load_scale, current] = balance.scale;
        let scale = if load {
            [acceleration, velocity, 1.0, load_scale, 1.0, current]
        } else {
            [acceleration, velocity, 1.0, 1.0, current, 1.0]
        };
        let estimated = if load { ESTIMATED } else { ESTIMATED - 1 };
        let problem = &mut Problem {
            d: sums.d.get_mut(..columns(load)).unwrap_or_default(),
            r: &mut sums.r,
            inputs: estimated - 2,
            outputs: 2,
            scale: &scale,
            base: &[],
            mass: Mass { rows: sums.rows as f32, spread: 1.0 },
            gain: 1.0,
        };
        let solved = &mut Solved {
            delta: self.delta.get_mut(..estimated).unwrap_or_default(),
            covariance: &mut self.covariance,
            variance: &mut self.variance,
            work: self.work.get_mut(..estimated).unwrap_or_default(),
        };
        self.solution.advance::<true>(problem, solved, budget)
    }

    /// The next two parameters of the result; whether all are there.
    #[inline(never)]
    fn results(&mut self, balance: &Balance, load: bool, friction: &mut Friction) -> bool {
        let diagonal = |k: usize| self.covariance.get(lower(k, k)).copied().unwrap_or(0.0);
        let [n0, n1, n2, n3, n4] = balance.nominal;
        let at = |k: usize, nominal: f32| parameter(self.delta.get(k).copied().unwrap_or(0.0), diagonal(k), nominal);
        match self.results {
            0 => (friction.inertia, friction.viscous) = (at(0, n0), at(1, n1)),
            1 => {
                friction.coulomb = at(2, n2);
                friction.inverse_torque_constant = load.then(|| at(3, n3));
            }
            _ => {
                let speed = balance.usual_velocity_rad_s;
                let [_, _, v11, _, v12, v22, ..] = self.covariance;
                let variance = v22 + speed * (2.0 * v12 + speed * v11);
                let drag = friction.coulomb.value + friction.viscous.value * speed; // (5)
                friction.drag = parameter(drag, variance, n2 + n1 * speed);
                friction.offset = at(if load { 4 } else { 3 }, n4);
                friction.variance = self.variance;
                return true;
            }
        }
        self.results = self.results.wrapping_add(1);
        false
    }
}

impl Friction {
    fn is_finite(&self) -> bool {
        let Self { inertia, viscous, coulomb, offset, drag, .. } = self;
        let scores = [inertia, viscous, coulomb, offset, drag].into_iter().chain(&self.inverse_torque_constant);
        scores.fold(0.0, |sum, parameter| sum + parameter.score).is_finite()
    }
}

fn parameter(value: f32, variance: f32, nominal: f32) -> Parameter {
    let deviation = libm::sqrtf(variance.max(f32::MIN_POSITIVE));
    Parameter { value, deviation, score: (value - nominal) / deviation }
}

/// The error with the term that it concerns.
fn reason(error: SolveError, load: bool, rows: u32) -> Reason {
    match error {
        SolveError::TooFewRows => Reason::TooFewRows { part: Part::TorqueBalance, rows },
        SolveError::WeakInstruments => Reason::WeakInstruments(Part::TorqueBalance),
        SolveError::NotExcited(place) => Reason::TermNotExcited(match (place, load) {
            (0, _) => FrictionTerm::Inertia,
            (1, _) => FrictionTerm::Viscous,
            (2, _) => FrictionTerm::Coulomb,
            (3, true) => FrictionTerm::InverseTorqueConstant,
            _ => FrictionTerm::Offset,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn balance(row_interval: u8) -> Balance {
        Balance {
            interval_s: 0.001,
            filter: StateVariable::new(0.05, 0.001),
            row_interval,
            settle: 50,
            sign_velocity_rad_s: 1.0,
            usual_velocity_rad_s: 20.0,
            scale: [0.015_625, 0.062_5, 8.0, 1.0],
            nominal: [0.005, 0.002, 0.1, 20.0, 0.05],
        }
    }

    /// A shaft with the parameters p under two sines and a load; one solve after 4000 samples.
    fn run(row_interval: u8, load: bool, p: [f32; 5]) -> Result<Friction, Reason> {
        let balance = balance(row_interval);
        let mut state = BalanceState::new(&balance);
        for k in 0..4000_u16 {
            let t = f64::from(k) * 0.001;
            let (w, dw) =
                (30.0 * (4.0 * t).sin() + 8.0 * (17.0 * t).sin(), 120.0 * (4.0 * t).cos() + 136.0 * (17.0 * t).cos());
            let torque = if load { 0.1 * (9.0 * t).sin() } else { 0.0 };
            let sign = w.clamp(-1.0, 1.0);
            let [p0, p1, p2, p3, p4] = p.map(f64::from);
            let current = p0 * dw + p1 * w + p2 * sign + p3 * torque + p4;
            let now = Torques {
                current_a: current as f32,
                velocity_rad_s: w as f32,
                reference_rad_s: w as f32,
                load_nm: torque as f32,
            };
            if k == 0 {
                state.start(&balance, &now);
            } else {
                let _ = state.step(&balance, load, &now);
            }
        }
        solve(&balance, load, &mut state.sums().clone())
    }

    fn solve(balance: &Balance, load: bool, sums: &mut BalanceSums) -> Result<Friction, Reason> {
        let (mut solve, mut friction) = (BalanceSolve::new(), Friction::default());
        loop {
            if let Some(outcome) = solve.advance(balance, load, sums, &mut friction, 1) {
                return outcome.map(|()| friction);
            }
        }
    }

    #[test]
    fn exact_signals_give_the_exact_balance() {
        let friction = run(8, true, [0.006, 0.003, 0.15, 18.0, 0.02]).unwrap();
        let close = |got: f32, want: f32| assert!((got / want - 1.0).abs() < 5e-3, "{got} {want}");
        // The filter's derivative is the bilinear one: (ω Ts)²/12 at 17 rad/s is 2e-5; the sign's corners cost more.
        close(friction.inertia.value, 0.006);
        close(friction.coulomb.value + 20.0 * friction.viscous.value, 0.21);
        close(friction.drag.value, 0.21);
        close(friction.torque_constant_nm_a().unwrap().0, 1.0 / 18.0);
        close(friction.inertia_kg_m2().unwrap(), 0.006 / 18.0);
        assert_eq!(friction.rows, (4000_u32 - 1 - 51).div_ceil(8));
    }

    #[test]
    fn without_a_load_its_term_is_missing() {
        let friction = run(8, false, [0.006, 0.003, 0.15, 0.0, 0.02]).unwrap();
        assert!(
            (friction.offset.value - 0.02).abs() < 1e-3 && (friction.drag.value - 0.21).abs() < 1e-3,
            "{friction:?}"
        );
        assert_eq!((friction.inverse_torque_constant, friction.torque_constant_nm_a()), (None, None));
    }

    #[test]
    fn rows_may_come_at_every_sample() {
        let (often, seldom) = (run(1, true, balance(1).nominal).unwrap(), run(8, true, balance(8).nominal).unwrap());
        assert!(often.rows > 7 * seldom.rows);
        assert!((often.inertia.value - seldom.inertia.value).abs() < 1e-5);
    }

    #[test]
    fn a_motionless_shaft_names_the_term() {
        let balance = balance(8);
        let mut sums = BalanceSums::new();
        for _ in 0..100 {
            sums.start([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.5]);
            while sums.rotate(true) {}
            sums.rows += 1;
        }
        assert_eq!(solve(&balance, true, &mut sums), Err(Reason::TermNotExcited(FrictionTerm::Coulomb)));
    }
}
