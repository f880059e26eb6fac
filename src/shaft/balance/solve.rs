//! The sums of a torque balance → [`Friction`].
//!
//! What is left of the last row is rotated in, then the parameters are solved. The equations are those of
//! [`super::balance`].

use super::friction::{Friction, LoadTerms, Parameter};
use super::rows::{TERMS, TorqueBalance};
use super::sums::{BalanceSums, columns};
use crate::plan::Load;
use crate::reason::{FrictionTerm, Part, Reason};
use crate::regression::factor::kernels::pairs;
use crate::regression::factor::{EffectiveRows, Problem, Solution, SolveError, Solved, lower};

const COVARIANCE: usize = TERMS * (TERMS + 1) / 2;

/// The parameters that are estimated, in the order of [`TorqueBalance::terms`], and the solve under way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimated {
    delta: [f32; TERMS],
    covariance: [f32; COVARIANCE],
    work: [f32; TERMS],
    /// Of the rows' residual.
    variance: f32,
    solution: Solution,
}

impl Estimated {
    /// Nothing solved yet.
    pub(in crate::shaft) const NONE: Self = Self {
        delta: [0.0; TERMS],
        covariance: [0.0; COVARIANCE],
        work: [0.0; TERMS],
        variance: 0.0,
        solution: Solution::NONE,
    };

    /// Solves the sums for the parameters.
    ///
    /// # Errors
    /// Why there is no result.
    #[inline(never)]
    pub(in crate::shaft) fn solve(
        &mut self,
        balance: &TorqueBalance,
        load: bool,
        sums: &mut BalanceSums,
    ) -> Result<(), Reason> {
        while sums.rotate_small(load) {}
        let count = columns(load).wrapping_sub(1);
        // Rows alike do not determine a variance.
        let few = (sums.rows as f32) < 2.0 * balance.row_spread * count as f32;
        let rows = sums.rows;
        let solution =
            if few { Err(SolveError::TooFewRows) } else { self.with(balance, load, sums, Solution::new::<false>) };
        self.solution = solution.map_err(|error| reason(error, load, rows))?;
        Ok(())
    }

    /// Computes the covariance.
    #[inline(never)]
    pub(in crate::shaft) fn correlate(&mut self, balance: &TorqueBalance, load: bool, sums: &mut BalanceSums) {
        let mut solution = self.solution;
        self.with(balance, load, sums, |problem, solved| while !solution.add_column::<false>(problem, solved) {});
    }

    /// A step of the solve.
    #[inline(always)]
    fn with<R>(
        &mut self,
        balance: &TorqueBalance,
        load: bool,
        sums: &mut BalanceSums,
        step: impl FnOnce(&mut Problem<'_>, &mut Solved<'_>) -> R,
    ) -> R {
        let [k0, k1, k2, _, k4, _, k6, k7] = balance.scale;
        let without = [k0, k1, k2, k4, k6, k7];
        let count = columns(load).wrapping_sub(1);
        let problem = &mut Problem {
            d: sums.d.get_mut(..columns(load)).unwrap_or_default(),
            r: &mut sums.r,
            inputs: count,
            outputs: 0,
            scale: if load { &balance.scale } else { &without },
            base: &[],
            mass: EffectiveRows { rows: sums.rows as f32, spread: balance.row_spread },
            gain: 1.0,
        };
        let solved = &mut Solved {
            delta: self.delta.get_mut(..count).unwrap_or_default(),
            covariance: &mut self.covariance,
            variance: &mut self.variance,
            work: self.work.get_mut(..count).unwrap_or_default(),
        };
        step(problem, solved)
    }

    /// Deviations and scores.
    ///
    /// # Errors
    /// [`Reason::NotFinite`].
    #[inline(never)]
    pub(in crate::shaft) fn friction(
        &self,
        balance: &TorqueBalance,
        known: Load,
        rows: u32,
    ) -> Result<Friction, Reason> {
        let load = known.has_terms();
        let at = |k: usize| self.parameter(balance, load, k);
        let friction = Friction {
            inertia: at(0),
            viscous: at(1),
            coulomb: at(2),
            offset: at(if load { 4 } else { 3 }),
            load: match known {
                Load::Unknown => LoadTerms::Unknown,
                Load::Measured(_) => LoadTerms::Measured { inverse_torque_constant: at(3), load_friction: at(5) },
                Load::Weight { .. } => LoadTerms::Weight(self.weight()),
            },
            stribeck: at(if load { 6 } else { 4 }),
            drag: self.drag(balance, load),
            variance: self.variance,
            rows,
        };
        if friction.scores().is_finite() { Ok(friction) } else { Err(Reason::NotFinite(Part::TorqueBalance)) }
    }

    /// Whether the rows fit the negated nominal parameters far better than the nominal ones, where no load is measured:
    /// a signal has the opposite sign, also where a tight prior keeps the estimates near the nominal values.
    ///
    /// ```text
    /// J(n) − J(−n) = −4 s² m Σₖ (pₖ − qₖ) wₖ nₖ,   qₖ = Σⱼ Cₖⱼ wⱼ nⱼ,   wₖ = σ₀²/(prior² s²)
    /// N ln(J(n)/J(−n)) > 25,   J(n) = N m s²,   N = rows/m − terms
    /// ```
    ///
    /// J is the sum of squares of residual and prior, C the covariance, m the rows per independent row, and 25 five
    /// standard deviations of a likelihood ratio.
    #[inline(never)]
    pub(in crate::shaft) fn is_opposed(&self, balance: &TorqueBalance, load: bool, rows: u32) -> bool {
        let terms = TorqueBalance::terms(load);
        let pull = |k: usize| {
            let term = terms.get(k).copied().unwrap_or(0);
            let of = |list: &[f32; TERMS]| list.get(term).copied().unwrap_or(1.0);
            let ratio = balance.deviation / of(&balance.prior);
            ratio * ratio / self.variance * of(&balance.nominal)
        };
        let mut difference = 0.0;
        for k in 0..terms.len() {
            let mut rest = self.delta.get(k).copied().unwrap_or(0.0);
            for j in 0..terms.len() {
                let (low, high) = if j < k { (j, k) } else { (k, j) };
                rest -= self.covariance.get(lower(high, low)).copied().unwrap_or(0.0) * pull(j);
            }
            difference -= 4.0 * rest * pull(k);
        }
        let independent = rows as f32 / balance.row_spread - terms.len() as f32;
        1.0 - difference / independent < libm::expf(-25.0 / independent)
    }

    /// The k-th parameter that is estimated.
    #[inline(never)]
    fn parameter(&self, balance: &TorqueBalance, load: bool, k: usize) -> Parameter {
        let term = TorqueBalance::terms(load).get(k).copied().unwrap_or(0);
        let nominal = balance.nominal.get(term).copied().unwrap_or(1.0);
        let variance = self.covariance.get(lower(k, k)).copied().unwrap_or(0.0);
        parameter(self.delta.get(k).copied().unwrap_or(0.0), variance, nominal)
    }

    /// The amplitude W of (6), with its deviation by the covariance of its two parameters.
    #[inline(never)]
    fn weight(&self) -> Parameter {
        let [.., p3, _, p5, _] = self.delta;
        let of = |row: usize, column: usize| self.covariance.get(lower(row, column)).copied().unwrap_or(0.0);
        let amplitude = libm::sqrtf(p3 * p3 + p5 * p5).max(f32::MIN_POSITIVE);
        let (c, s) = (p3 / amplitude, p5 / amplitude);
        parameter(amplitude, c * c * of(3, 3) + 2.0 * c * s * of(5, 3) + s * s * of(5, 5), 0.0)
    }

    /// The drag (4). Its variance has the covariances of all terms, whose errors cancel in it.
    fn drag(&self, balance: &TorqueBalance, load: bool) -> Parameter {
        let (weights, terms) = (balance.in_drag(), TorqueBalance::terms(load));
        let weight = |term: usize| weights.get(term).copied().unwrap_or(0.0);
        let (mut value, mut nominal, mut variance) = (0.0, 0.0, 0.0);
        for (k, (&term, delta)) in pairs(0..usize::MAX, pairs(terms, &self.delta)) {
            let w = weight(term);
            if w == 0.0 {
                continue;
            }
            value += w * delta;
            nominal += w * balance.nominal.get(term).copied().unwrap_or(0.0);
            let row = self.covariance.get(lower(k, 0)..).unwrap_or_default();
            let before = terms.get(..k).unwrap_or_default();
            let with: f32 = pairs(before, row).map(|(&other, covariance)| weight(other) * covariance).sum();
            variance += w * (2.0 * with + w * row.get(k).copied().unwrap_or(0.0));
        }
        parameter(value, variance, nominal)
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
        SolveError::NotExcited(index) => {
            let term = TorqueBalance::terms(load).get(index).and_then(|&term| FrictionTerm::ALL.get(term));
            Reason::TermNotExcited(term.copied().unwrap_or(FrictionTerm::Offset))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Signal;
    use crate::shaft::balance::{BalanceState, StateVariable, Torques};

    fn known(load: bool) -> Load {
        if load { Load::Measured(Signal::channel(0)) } else { Load::Unknown }
    }

    fn solve(balance: &TorqueBalance, load: bool, sums: &mut BalanceSums) -> Result<Friction, Reason> {
        let mut estimated = Estimated::NONE;
        estimated.solve(balance, load, sums)?;
        estimated.correlate(balance, load, sums);
        estimated.friction(balance, known(load), sums.rows)
    }

    /// p₀ … p₄ of the healthy shaft.
    const HEALTHY: [f32; 5] = [0.005, 0.002, 0.1, 20.0, 0.05];

    const fn balance(row_interval: u8) -> TorqueBalance {
        TorqueBalance {
            interval_s: 0.001,
            filter: StateVariable::new(0.05, 0.001),
            row_interval,
            settle: 50,
            sign_velocity_rad_s: 1.0,
            stribeck_velocity_rad_s: 4.0,
            usual_velocity_rad_s: 20.0,
            usual_load_nm: 0.0,
            row_spread: 1.0,
            scale: [0.015_625, 0.062_5, 1.0, 8.0, 1.0, 8.0, 1.0, 1.0],
            nominal: [0.005, 0.002, 0.1, 20.0, 0.05, 0.0, 0.0],
            prior: [0.05, 0.02, 1.0, 200.0, 1.0, 20.0, 1.0],
            deviation: 0.001,
            adapt_after_rows: 48,
            largest_change_rad: f32::INFINITY,
        }
    }

    /// A shaft with the parameters p under two sines and a load; one solve after 4000 samples.
    fn run(row_interval: u8, load: bool, p: [f32; 5]) -> Result<Friction, Reason> {
        let balance = balance(row_interval);
        let (mut state, mut sums) = (BalanceState::new(&balance), BalanceSums::new(&balance, load));
        for k in 0..4000_u16 {
            let t = f64::from(k) * 0.001;
            let (w, dw) =
                (30.0 * (4.0 * t).sin() + 8.0 * (17.0 * t).sin(), 120.0 * (4.0 * t).cos() + 136.0 * (17.0 * t).cos());
            let torque = if load { 0.1 * (9.0 * t).sin() } else { 0.0 };
            let sign = w.clamp(-1.0, 1.0);
            let [p0, p1, p2, p3, p4] = p.map(f64::from);
            let current = p0 * dw + p1 * w + p2 * sign + p3 * torque + p4;
            let now = Torques { current_a: current as f32, velocity_rad_s: w as f32, load_nm: torque as f32 };
            if k == 0 {
                state.start(&balance, &now, &balance.regressors(&now, None));
            } else {
                state.step(&mut sums, (&balance, known(load)), &now, &balance.regressors(&now, None), true);
            }
        }
        solve(&balance, load, &mut sums)
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
        let [coulomb, viscous] = [friction.coulomb_nm(), friction.viscous_nm_s_rad()].map(Option::unwrap);
        close(coulomb + 20.0 * viscous, 0.21 / 18.0);
        // Every sixteenth row is left out for the present parameters.
        let rows = (4000_u32 - 1 - 51).div_ceil(8);
        assert_eq!(friction.rows, rows - rows / 16);
    }

    #[test]
    fn without_a_load_its_term_is_missing() {
        let friction = run(8, false, [0.006, 0.003, 0.15, 0.0, 0.02]).unwrap();
        assert!(
            (friction.offset.value - 0.02).abs() < 1e-3 && (friction.drag.value - 0.21).abs() < 1e-3,
            "{friction:?}"
        );
        assert_eq!((friction.load, friction.torque_constant_nm_a()), (LoadTerms::Unknown, None));
    }

    #[test]
    fn rows_may_come_at_every_sample() {
        let (often, seldom) = (run(1, true, HEALTHY).unwrap(), run(8, true, HEALTHY).unwrap());
        assert!(often.rows > 7 * seldom.rows);
        assert!((often.inertia.value - seldom.inertia.value).abs() < 1e-5);
    }

    /// Viscous friction without its prior, and its deviation, of rows ω, i = p₁ ω + p₄ with alternating errors, of a
    /// velocity that hardly varies.
    fn hardly_moving(viscous: f32, spread_rad_s: f32) -> (f32, f32) {
        let balance = TorqueBalance { scale: [1.0; 8], deviation: 0.01, ..balance(8) };
        let mut sums = BalanceSums::new(&balance, true);
        for k in 0..400_u16 {
            let sign = |bit: u16| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let (velocity, error) = (spread_rad_s * sign(0), 0.01 * sign(1));
            sums.start([0.0, velocity, 0.0, 0.0, 1.0, 0.0, 0.0, viscous * velocity + 0.5 + error]);
            while sums.rotate(true) {}
            sums.rows += 1;
        }
        let friction = solve(&balance, true, &mut sums).unwrap();
        let (value, variance) = balance.without_prior(&friction, FrictionTerm::Viscous);
        (value, variance.sqrt())
    }

    #[test]
    fn a_weak_motion_leaves_no_bias_towards_the_healthy_value() {
        // 400 rows of 0.01 A and 0.02 rad/s: a deviation of 0.025 beside a prior of 0.02, whose weight would be 0.6.
        let (value, deviation) = hardly_moving(0.042, 0.02);
        assert!((value - 0.042).abs() < 1e-4 && (deviation - 0.025).abs() < 5e-4, "{value} {deviation}");
        // What the rows do not determine is nominal, with eight prior deviations.
        let (value, deviation) = hardly_moving(0.042, 0.0);
        assert!((value - 0.002).abs() < 1e-6 && (deviation / 0.16 - 1.0).abs() < 0.1, "{value} {deviation}");
    }

    /// A solve of rows of both directions: ω = ±20 rad/s but for 1 %, and a current of 0.5 A of drag with alternating
    /// errors of 0.01 A.
    fn both_ways(rows: u16, load: bool) -> Result<Friction, Reason> {
        let prior = [0.05, 0.02, 1.0, 200.0, 1.0, 20.0, 1e-3];
        let balance = TorqueBalance { scale: [1.0; 8], deviation: 0.01, row_spread: 2.0, prior, ..balance(8) };
        let mut sums = BalanceSums::new(&balance, load);
        for k in 0..rows {
            let sign = |bit: u16| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let velocity = sign(0) * (20.0 + 0.2 * sign(1));
            let current = 0.5 * sign(0) + 0.01 * sign(2);
            let row = if load {
                [0.0, velocity, sign(0), 0.1 * sign(3), 1.0, 0.0, 0.0, current]
            } else {
                [0.0, velocity, sign(0), 1.0, 0.0, current, 0.0, 0.0]
            };
            sums.start(row);
            while sums.rotate(load) {}
            sums.rows += 1;
        }
        solve(&balance, load, &mut sums)
    }

    #[test]
    fn errors_of_terms_that_depend_on_each_other_cancel_in_the_drag() {
        let friction = both_ways(1600, true).unwrap();
        // 1600 rows, two to an independent one: 0.01 A/√800. Coulomb friction alone is the current at no velocity,
        // which is 100 deviations of the velocity away.
        let mean = 0.01 / 800.0_f32.sqrt();
        assert!((friction.drag.value - 0.5).abs() < 1e-4, "{friction:?}");
        assert!((friction.drag.deviation / mean - 1.0).abs() < 0.05, "{mean} {friction:?}");
        assert!(friction.coulomb.deviation > 30.0 * mean, "{friction:?}");
        // The healthy drag is 0.1 A and 20 rad/s of 0.002.
        let score = (friction.drag.value - 0.14) / friction.drag.deviation;
        assert!((friction.drag.score / score - 1.0).abs() < 1e-5, "{score} {friction:?}");
    }

    #[test]
    fn fewer_rows_than_two_independent_ones_a_parameter_are_refused() {
        // Seven parameters with a load, five without; a row in two is independent.
        for (load, least) in [(true, 28), (false, 20)] {
            let few = Reason::TooFewRows { part: Part::TorqueBalance, rows: u32::from(least) - 1 };
            assert_eq!(both_ways(least - 1, load).unwrap_err(), few);
            assert_eq!(both_ways(least, load).unwrap().rows, u32::from(least));
        }
    }

    #[test]
    fn a_drag_that_overflows_is_refused() {
        // Each term is finite, and twenty times the viscous one is not.
        let mut estimated = Estimated::NONE;
        estimated.delta[1] = 1e38;
        estimated.covariance[lower(1, 1)] = 1e38;
        assert_eq!(estimated.friction(&balance(8), known(true), 100), Err(Reason::NotFinite(Part::TorqueBalance)));
        estimated.delta[1] = 1.0;
        assert!(estimated.friction(&balance(8), known(true), 100).is_ok());
    }

    #[test]
    fn the_drag_keeps_its_priors_and_no_estimate_is_none() {
        let parameter = Parameter { value: 3.0, deviation: 0.5, score: 2.0 };
        let friction = Friction { drag: parameter, viscous: parameter, variance: 1e-6, ..Friction::default() };
        let values = [FrictionTerm::Drag, FrictionTerm::InverseTorqueConstant, FrictionTerm::LoadFriction]
            .map(|term| balance(8).without_prior(&friction, term));
        assert_eq!(values, [(3.0, 0.25), (0.0, 0.0), (0.0, 0.0)]);
    }

    #[test]
    fn a_motionless_shaft_keeps_its_prior() {
        let balance = balance(8);
        let mut sums = BalanceSums::new(&balance, true);
        for _ in 0..100 {
            sums.start([0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5]);
            while sums.rotate(true) {}
            sums.rows += 1;
        }
        let friction = solve(&balance, true, &mut sums).unwrap();
        assert!((friction.offset.value - 0.5).abs() < 1e-3, "{friction:?}");
        // The variance of the rows' residual is nearly zero here, so deviations are compared with each other.
        let [viscous, offset] = [friction.viscous, friction.offset];
        assert!((viscous.value - 0.002).abs() < 1e-6 && viscous.deviation > offset.deviation * 0.01, "{friction:?}");
    }
}
