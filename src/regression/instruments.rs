//! Streaming simplified refined instrumental variables: samples → one row of instruments and regressors, in δ-form.
//!
//! The auxiliary model t, β, γ, k is that of the last accepted segment. Every signal is kept as its level and its
//! first differences; with `in` a new sample, one step of each is
//!
//! ```text
//! Δf = t₀ (f − in) + Σ_{k≥1} t_k Δf_k,   f ← f + Δf           prefilter A(1)/A of y, u1, u2 (unit gain at rest)  (1)
//! Δx̂ = t₀ x̂ + Σ_{k≥1} t_k Δx̂_k + Σ β_j u_j + Σ γ_j w_j + k    simulated output, from the filtered inputs u, w   (2)
//! ```
//!
//! Filtering the simulated output equals simulating from filtered inputs, which saves a filter. The row is
//!
//! ```text
//! [ u₁, u₁−u₂, …, w₁, w₁−w₂, …, (1) | x̂₁, x̂₁−x̂₂, … | y₁, y₁−y₂, … | Δy − Δŷ ]   na + n + 1 columns, all filtered (3)
//! ```
//!
//! Δŷ is the prediction of Δy by the auxiliary model, so a segment estimates the *difference* from that model: at 10
//! kHz the filtered residual is 1e-4 of Δy, and the target Δy itself would cost the estimate these digits (an error of
//! 0.9 standard deviations with three poles, instead of 0.001). A fading memory contains rows of many auxiliary models,
//! so its target is Δy itself.
//!
//! Without the prefilter recursive instrumental variables are useless at high sampling rates. Source: Young, *Recursive
//! Estimation and Time-Series Analysis*, simplified refined instrumental variables, one pass a segment.
//!
//! Filters and simulation continue across segments; only the parameters change, after which rows are withheld until
//! transients have decayed ([`Regression::settle`]). A refused sample restarts all of them, at rest on the next
//! accepted sample. The simulated output restarts also if it exceeds a hundred times the limit of the output.
//!
//! Cost: 3 na + n multiply-adds more than least squares, and the larger triangle.

use super::auxiliary::Auxiliary;
use super::constants::Regression;
use super::delays::Delays;
use super::inputs::{Inputs, Reference, carry_on, dot};
use crate::plan::{Array, Cells, MAX_OUTPUT_TERMS, Memory, Plan, RegressionLayout, Structure, filter_cells};
use crate::regression::factor::Row;
use crate::unroll::unrolled;

/// The simulated output may exceed the limit of the measured output by this factor.
const BOUND: f32 = 100.0;

/// Rows of instrumental variables.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Instruments<P: Plan> {
    row: Array<P::Columns, f32>,
    /// The auxiliary model; its constant applies to levels from zero.
    pub(super) auxiliary: Auxiliary<P>,
    /// That constant for levels from the origin.
    constant: f32,
    /// Values that are subtracted from the levels if there is a constant; else zero.
    origin: [f32; 3],
    /// Whether the origin has been taken: it moves while the sums are empty, not when a sample restarts the filters.
    placed: bool,
    y: [f32; MAX_OUTPUT_TERMS],
    /// Level and differences of the simulated output, of filtered u1, of filtered u2; as many as filter and row need.
    cells: Array<P::Filters, f32>,
    delays: Delays<P>,
    /// Samples until the filters start: the delayed inputs must be valid.
    filling: u16,
    /// Samples until rows are given.
    settling: u16,
}

impl<P: Plan> Instruments<P> {
    pub(super) fn new(plan: P, constants: &Regression<P>) -> Self {
        let layout = plan.layout();
        Self {
            row: Cells::filled(layout.columns(), 0.0),
            auxiliary: Auxiliary::new(nominal(plan, constants)),
            constant: 0.0,
            origin: [0.0; 3],
            placed: false,
            y: [0.0; MAX_OUTPUT_TERMS],
            cells: Cells::filled(layout.filters(), 0.0),
            delays: Delays::new(plan),
            filling: filling(plan),
            settling: 0,
        }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, plan: P, constants: &Regression<P>, inputs: Inputs, y_limit: f32) -> Option<Row<'_>> {
        let RegressionLayout { structure, memory, .. } = plan.layout().regression?;
        let Structure { offset, nkb, nkc, .. } = structure;
        let (na, nb, nc) = (structure.na as usize, structure.nb as usize, structure.nc as usize);
        if self.auxiliary.tick(|| nominal(plan, constants)) {
            self.take_over(structure, memory);
        }
        let [u1, u2] = self.delays.push([inputs.u1, inputs.u2], [nkb, nkc]);
        if self.filling > 0 {
            self.fill(structure, constants, [inputs.y, u1, u2]);
            return None;
        }
        let [y0, u1_0, u2_0] = self.origin;
        let (t, gains) = self.auxiliary.now.cells().split_at_checked(na)?;
        let (x, rest) = self.cells.cells_mut().split_at_mut_checked(na)?;
        let (u1_cells, rest) = rest.split_at_mut_checked(filter_cells(structure.nb, structure.na))?;
        let u2_cells = rest.get_mut(..filter_cells(structure.nc, structure.na))?;
        let (du1, du2) = (increment(u1_cells, t, u1 - u1_0), increment(u2_cells, t, u2 - u2_0)); // (1)
        advance(u1_cells, du1);
        advance(u2_cells, du2);

        let y = self.y.get_mut(..na)?;
        let dy = increment(y, t, inputs.y - y0);
        let (u1_used, u2_used) = (u1_cells.get(..nb)?, u2_cells.get(..nc)?);
        let (beta, gamma) = gains.split_at_checked(nb)?;
        let driven = dot(dot(self.constant, u1_used, beta), u2_used, gamma);
        let (dx, expected) = (dot(driven, x, t), dot(driven, y, t)); // (2)

        let (y_scale, scale) = constants.scale.cells().split_at_checked(na)?;
        let (u1_scale, scale) = scale.split_at_checked(nb)?;
        let (u2_scale, scale) = scale.split_at_checked(nc)?;
        let mut cells = put(self.row.cells_mut(), u1_used, u1_scale); // (3)
        cells = put(cells, u2_used, u2_scale);
        let scale = match (offset, scale) {
            (true, [constant, rest @ ..]) => {
                cells = put(cells, &[1.0], &[*constant]);
                rest
            }
            _ => scale,
        };
        cells = put(put(cells, x, y_scale), y, y_scale);
        let target = if predicts(memory) { dy - expected } else { dy };
        put(cells, &[target], scale);
        let motion = squared(du1, u1_scale) + squared(du2, u2_scale);

        advance(y, dy);
        advance(x, dx);
        // Written so that NaN restarts too.
        let bounded = self.cells.cells().first().is_none_or(|x| x.abs() <= BOUND * y_limit);
        if !bounded {
            self.filling = 1;
        }
        if self.settling > 0 {
            self.settling = self.settling.wrapping_sub(1);
            return None;
        }
        Some(Row { cells: self.row.cells(), motion })
    }

    pub(super) fn flush(&mut self, plan: P) {
        self.filling = filling(plan);
    }

    pub(super) fn next_segment(&mut self, plan: P, constants: &Regression<P>) {
        self.settling = constants.handover.saturating_add(constants.settle);
        let swapped = self.auxiliary.next_segment(constants.handover, || nominal(plan, constants));
        if let (true, Some(RegressionLayout { structure, memory, .. })) = (swapped, plan.layout().regression) {
            self.take_over(structure, memory);
        }
    }

    #[inline(always)]
    pub(super) fn frame(&self, plan: P) -> Reference<P> {
        let theta = &self.auxiliary.now;
        let mut base = Array::<P::Parameters, f32>::from_fn(theta.cells().len(), |_| 0.0);
        if let Some(RegressionLayout { structure, memory, .. }) = plan.layout().regression
            && predicts(memory)
        {
            base.clone_from(theta);
            let constant = base.cells_mut().iter_mut().skip(structure.terms()).take(usize::from(structure.offset));
            constant.for_each(|cell| *cell = self.constant);
        }
        let gain = theta.cells().first().map_or(0.0, |t| t.abs());
        Reference { origin: self.origin, base, gain }
    }

    /// Counts a sample that only fills the delays; with the last of them all filters start, at rest on it.
    #[cold]
    #[inline(never)]
    fn fill(&mut self, structure: Structure, constants: &Regression<P>, levels: [f32; 3]) {
        self.filling = self.filling.saturating_sub(1);
        if self.filling > 0 {
            return;
        }
        self.settling = self.settling.max(constants.settle);
        self.y = [0.0; MAX_OUTPUT_TERMS];
        self.cells.cells_mut().fill(0.0);
        if structure.offset && !self.placed {
            (self.origin, self.placed) = (levels, true);
        }
        self.refer(structure);
        let ([y, u1, u2], [y0, u1_0, u2_0]) = (levels, self.origin);
        let [x_level, u1_level, u2_level] = levels_of(structure);
        self.y.first_mut().into_iter().for_each(|level| *level = y - y0);
        for (index, value) in [(x_level, y - y0), (u1_level, u1 - u1_0), (u2_level, u2 - u2_0)] {
            if let Some(level) = index.and_then(|index| self.cells.cells_mut().get_mut(index)) {
                *level = value;
            }
        }
    }

    /// Another auxiliary model is in use from here on. Levels are taken from the present values of the signals, unless
    /// earlier rows were taken from others.
    #[cold]
    #[inline(never)]
    fn take_over(&mut self, structure: Structure, memory: Memory) {
        if structure.offset && self.filling == 0 && memory != Memory::Fading {
            self.recentre(structure);
        }
        self.refer(structure);
    }

    /// The auxiliary model's constant for levels from the origin.
    fn refer(&mut self, structure: Structure) {
        let Structure { na, nb, nc, offset, .. } = structure;
        let (na, nb) = (na as usize, nb as usize);
        let theta = self.auxiliary.now.cells();
        let gain = |used: bool, index: usize| if used { theta.get(index).copied().unwrap_or(0.0) } else { 0.0 };
        let [y0, u1_0, u2_0] = self.origin;
        let constant = gain(offset, structure.terms());
        let second = na.saturating_add(nb);
        self.constant = constant + gain(true, 0) * y0 + gain(nb > 0, na) * u1_0 + gain(nc > 0, second) * u2_0;
    }

    /// Moves the origin to the present levels: with unit gain at rest, filtering and moving commute.
    fn recentre(&mut self, structure: Structure) {
        let [x_level, u1_level, u2_level] = levels_of(structure);
        let [y0, u1_0, u2_0] = &mut self.origin;
        let cells = self.cells.cells_mut();
        let level = self.y.first_mut().map_or(0.0, core::mem::take);
        *y0 += level;
        if let Some(x) = x_level.and_then(|index| cells.get_mut(index)) {
            *x -= level;
        }
        for (index, origin) in [(u1_level, u1_0), (u2_level, u2_0)] {
            if let Some(level) = index.and_then(|index| cells.get_mut(index)) {
                *origin += core::mem::take(level);
            }
        }
    }
}

/// Whether the target is the prediction error of the auxiliary model: that model must be the same for all rows.
#[inline(always)]
const fn predicts(memory: Memory) -> bool {
    !matches!(memory, Memory::Fading)
}

/// Places of the levels of x̂, u1, u2; `None` for an input without terms.
fn levels_of(structure: Structure) -> [Option<usize>; 3] {
    let Structure { na, nb, nc, .. } = structure;
    let first = na as usize;
    let second = first.saturating_add(filter_cells(nb, na));
    [Some(0), (nb > 0).then_some(first), (nc > 0).then_some(second)]
}

/// Samples until every delayed input is valid, and the sample that starts the filters.
fn filling<P: Plan>(plan: P) -> u16 {
    let delay = plan.layout().regression.map_or(0, |r| r.structure.nkb.max(r.structure.nkc));
    u16::from(delay).saturating_add(1)
}

#[cold]
#[inline(never)]
fn nominal<P: Plan>(plan: P, constants: &Regression<P>) -> Array<P::Parameters, f32> {
    parameters(plan, constants.nominal.cells())
}

/// The δ-parameters of an auxiliary model.
pub(super) fn parameters<P: Plan>(plan: P, delta: &[f32]) -> Array<P::Parameters, f32> {
    Cells::from_fn(plan.layout().parameters(), |k| delta.get(k).copied().unwrap_or(0.0))
}

/// Δf of (1) of the filter with this level and these differences.
#[inline(always)]
fn increment(cells: &[f32], t: &[f32], input: f32) -> f32 {
    let (Some((level, differences)), Some((t0, later))) = (cells.split_first(), t.split_first()) else { return 0.0 };
    dot(t0 * (level - input), differences, later)
}

/// Moves level and differences on by Δf.
#[inline(always)]
fn advance(cells: &mut [f32], change: f32) {
    if let Some((level, differences)) = cells.split_first_mut() {
        carry_on(differences, change);
        *level += change;
    }
}

/// The square of a scaled change of an input; zero if the input has no terms.
#[inline(always)]
fn squared(change: f32, scale: &[f32]) -> f32 {
    let scaled = scale.first().map_or(0.0, |scale| change * scale);
    scaled * scaled
}

/// Writes scaled values into the first cells; returns the cells after them.
#[inline(always)]
fn put<'c>(cells: &'c mut [f32], values: &[f32], scale: &[f32]) -> &'c mut [f32] {
    let Some((mut section, rest)) = cells.split_at_mut_checked(values.len()) else { return &mut [] };
    let (mut values, mut scale) = (values, scale);
    unrolled!(let ([cell, cells @ ..], [value, later @ ..], [factor, factors @ ..]) = (section, values, scale) => {
        *cell = value * factor;
        (section, values, scale) = (cells, later, factors);
    });
    rest
}

#[cfg(test)]
mod tests;
