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
//! Filtering the simulated output is simulating from filtered inputs, which saves a filter. The row is
//!
//! ```text
//! [ u₁, u₁−u₂, …, w₁, w₁−w₂, …, (1) | x̂₁, x̂₁−x̂₂, … | y₁, y₁−y₂, … | Δy − Δŷ ]   na + n + 1 columns, all filtered (3)
//! ```
//!
//! Δŷ is what the auxiliary model expects of Δy, so that a segment estimates the *difference* from it: at 10 kHz the
//! filtered residual is a ten-thousandth of Δy, and the target itself would cost the estimate these digits (0.9 of its
//! standard deviation with three poles, instead of 0.001). Fading memory sees many auxiliary models and has Δy itself.
//!
//! The prefilter decides: without it recursive instrumental variables are useless at high sampling rates. Source:
//! Young, *Recursive Estimation and Time-Series Analysis*, simplified refined IV, a segment a pass.
//!
//! Filters and simulation go on over segments; only the parameters change, after which rows are withheld until
//! transients have died out ([`Regression::settle`]). A rejected sample restarts all of them, at rest on the next good
//! one. The simulated output is bounded: beyond a hundred times the output's limit it starts anew.
//!
//! Cost: 3 na + n multiply-adds more than least squares, and the larger triangle.

use super::reference::{self, Candidate, Reference};
use super::regression::MAX_OUTPUT_TERMS;
use super::rows::{AnyShape, Delays, Form, Row, Rows, Shape};
use super::{Estimate, Memory, Method, Order, Regression};
use crate::detector::Sample;

/// The simulated output may exceed the limit of the measured one by this factor.
const BOUND: f32 = 100.0;

/// Rows of instrumental variables. `L` is the capacity in delays, at least the larger of nkb and nkc; `S` the
/// structure.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Instruments<const M: usize, const L: usize, S = AnyShape> {
    /// Auxiliary model, with its constant as seen from zero.
    reference: Reference<M>,
    /// That constant as seen from the origin.
    constant: f32,
    /// What levels are taken from where there is a constant; else zero.
    origin: [f32; 3],
    /// Whether the origin has been taken: it moves where the sums are empty, never with a sample that restarts filters.
    placed: bool,
    y: [f32; MAX_OUTPUT_TERMS],
    /// Level and differences of the simulated output, of filtered u1, of filtered u2; as many as filter and row need.
    cells: [f32; M],
    delays: Delays<L>,
    /// Samples until the filters start: the delayed inputs must be clean.
    filling: u8,
    /// Samples until rows are given.
    settling: u16,
    shape: core::marker::PhantomData<S>,
}

impl<const M: usize, const L: usize, S: Shape> Rows<M> for Instruments<M, L, S> {
    type Shape = S;

    fn new(regression: &Regression<M>) -> Self {
        Self {
            reference: Reference::new(nominal(regression)),
            constant: 0.0,
            origin: [0.0; 3],
            placed: false,
            y: [0.0; MAX_OUTPUT_TERMS],
            cells: [0.0; M],
            delays: Delays::new(),
            filling: filling(regression),
            settling: 0,
            shape: core::marker::PhantomData,
        }
    }

    fn fits(regression: &Regression<M>) -> bool {
        regression.method == Method::Instruments
            && (1..=MAX_OUTPUT_TERMS).contains(&(regression.order.na as usize))
            && regression.capacity() <= M
            && regression.order.largest_delay() <= L.min(254)
            && S::fits(regression)
    }

    #[inline]
    fn push(&mut self, regression: &Regression<M>, sample: &Sample) -> Option<Row<M>> {
        let Form { order, offset, .. } = S::of(regression);
        let Order { na, nb, nc, nkb, nkc } = order;
        let (na, nb, nc) = (na as usize, nb as usize, nc as usize);
        if self.reference.tick(|| nominal(regression)) {
            self.take_over(regression);
        }
        let [u1, u2] = self.delays.push([sample.u1, sample.u2], [nkb, nkc]);
        if self.filling > 0 {
            self.fill(regression, [sample.y, u1, u2]);
            return None;
        }
        let [y0, u1_0, u2_0] = self.origin;
        let (t, gains) = self.reference.now.split_at_checked(na)?;
        let (x, rest) = self.cells.split_at_mut_checked(na)?;
        let (u1_cells, rest) = rest.split_at_mut_checked(used(order.nb, order.na))?;
        let u2_cells = rest.get_mut(..used(order.nc, order.na))?;
        let (du1, du2) = (increment(u1_cells, t, u1 - u1_0), increment(u2_cells, t, u2 - u2_0)); // (1)
        advance(u1_cells, du1);
        advance(u2_cells, du2);

        let y = self.y.get_mut(..na)?;
        let dy = increment(y, t, sample.y - y0);
        let (u1_used, u2_used) = (u1_cells.get(..nb)?, u2_cells.get(..nc)?);
        let (beta, gamma) = gains.split_at_checked(nb)?;
        let driven = dot(dot(self.constant, u1_used, beta), u2_used, gamma);
        let (dx, expected) = (dot(driven, x, t), dot(driven, y, t)); // (2)

        let mut row = Row { cells: [0.0; M], weight: 1.0, motion: 0.0 };
        let (own, scale) = regression.scale.split_at_checked(na)?;
        let (u1_scale, scale) = scale.split_at_checked(nb)?;
        let (u2_scale, scale) = scale.split_at_checked(nc)?;
        let mut cells = put(&mut row.cells, u1_used, u1_scale); // (3)
        cells = put(cells, u2_used, u2_scale);
        let scale = match (offset, scale) {
            (true, [constant, rest @ ..]) => {
                cells = put(cells, &[1.0], &[*constant]);
                rest
            }
            _ => scale,
        };
        cells = put(put(cells, x, own), y, own);
        let target = if predicts(regression) { dy - expected } else { dy };
        put(cells, &[target], scale);
        row.weight = reference::weight(dy - expected, self.reference.threshold);
        let moved = |change: f32, scale: &[f32]| scale.first().map_or(0.0, |scale| change * scale);
        let (du1, du2) = (moved(du1, u1_scale), moved(du2, u2_scale));
        row.motion = du1 * du1 + du2 * du2;

        advance(y, dy);
        advance(x, dx);
        // Written so that NaN starts anew too.
        let bounded = self.cells.iter().take(1).all(|x| x.abs() <= BOUND * regression.guard.limit[0]);
        if !bounded {
            self.filling = 1;
        }
        if self.settling > 0 {
            self.settling -= 1;
            return None;
        }
        Some(row)
    }

    fn flush(&mut self, regression: &Regression<M>) {
        self.filling = filling(regression);
    }

    fn next_segment(&mut self, regression: &Regression<M>) {
        self.settling = regression.handover.saturating_add(regression.settle);
        if self.reference.next_segment(regression.handover, || nominal(regression)) {
            self.take_over(regression);
        }
    }

    fn adopt<const P: usize>(&mut self, regression: &Regression<M>, estimate: &Estimate<M, P>) {
        self.reference.offer(candidate(regression, &estimate.delta, libm::sqrtf(estimate.variance)));
    }

    fn awaits(&self) -> bool {
        self.reference.awaits()
    }

    fn origin(&self) -> [f32; 3] {
        self.origin
    }

    fn gain(&self) -> f32 {
        self.reference.now.first().map_or(0.0, |t| t.abs())
    }

    fn base(&self, regression: &Regression<M>) -> [f32; M] {
        if !predicts(regression) {
            return [0.0; M];
        }
        let mut base = self.reference.now;
        // The constant's own place is the last; without one there is nothing behind the parameters.
        let constant = base.iter_mut().skip(regression.order.parameters()).take(usize::from(regression.offset));
        constant.for_each(|cell| *cell = self.constant);
        base
    }

    fn refused(&self) -> u8 {
        self.reference.refused
    }
}

impl<const M: usize, const L: usize, S: Shape> Instruments<M, L, S> {
    /// Counts a sample that only fills the delays; with the last of them all filters start, at rest on it.
    #[cold]
    fn fill(&mut self, regression: &Regression<M>, levels: [f32; 3]) {
        self.filling -= 1;
        if self.filling > 0 {
            return;
        }
        self.settling = self.settling.max(regression.settle);
        (self.y, self.cells) = ([0.0; MAX_OUTPUT_TERMS], [0.0; M]);
        if regression.offset && !self.placed {
            (self.origin, self.placed) = (levels, true);
        }
        self.refer(regression);
        let ([y, u1, u2], [y0, u1_0, u2_0]) = (levels, self.origin);
        let [x_level, u1_level, u2_level] = levels_of(&regression.order);
        self.y.first_mut().into_iter().for_each(|level| *level = y - y0);
        for (place, value) in [(x_level, y - y0), (u1_level, u1 - u1_0), (u2_level, u2 - u2_0)] {
            if let Some(level) = place.and_then(|place| self.cells.get_mut(place)) {
                *level = value;
            }
        }
    }

    /// Another auxiliary model runs from here on; levels are taken from where the signals are now, unless there are rows
    /// that are taken from elsewhere.
    #[cold]
    fn take_over(&mut self, regression: &Regression<M>) {
        if regression.offset && self.filling == 0 && regression.memory == Memory::Segment {
            self.recentre(regression);
        }
        self.refer(regression);
    }

    /// The auxiliary model's constant as seen from the origin.
    fn refer(&mut self, regression: &Regression<M>) {
        let Order { na, nb, nc, .. } = regression.order;
        let (na, nb, nc) = (na as usize, nb as usize, nc as usize);
        let gain =
            |used: bool, place: usize| if used { self.reference.now.get(place).copied().unwrap_or(0.0) } else { 0.0 };
        let [y0, u1_0, u2_0] = self.origin;
        let constant = gain(regression.offset, na + nb + nc);
        self.constant = constant + gain(true, 0) * y0 + gain(nb > 0, na) * u1_0 + gain(nc > 0, na + nb) * u2_0;
    }

    /// Moves the origin to the present levels: with unit gain at rest, filtering and moving commute.
    fn recentre(&mut self, regression: &Regression<M>) {
        let [x_level, u1_level, u2_level] = levels_of(&regression.order);
        let [y0, u1_0, u2_0] = &mut self.origin;
        let level = self.y.first_mut().map_or(0.0, core::mem::take);
        *y0 += level;
        if let Some(x) = x_level.and_then(|place| self.cells.get_mut(place)) {
            *x -= level;
        }
        for (place, origin) in [(u1_level, u1_0), (u2_level, u2_0)] {
            if let Some(level) = place.and_then(|place| self.cells.get_mut(place)) {
                *origin += core::mem::take(level);
            }
        }
    }
}

/// Whether the target is the auxiliary model's prediction error: that model must be one and the same for all rows.
fn predicts<const M: usize>(regression: &Regression<M>) -> bool {
    regression.memory == Memory::Segment
}

/// Level and differences an input needs: for its terms in the row and for the filter's memory.
const fn used(terms: u8, na: u8) -> usize {
    if terms == 0 {
        0
    } else if terms > na {
        terms as usize
    } else {
        na as usize
    }
}

/// Cells of the simulated output and both inputs.
pub(super) const fn cells(order: &Order) -> usize {
    order.na as usize + used(order.nb, order.na) + used(order.nc, order.na)
}

/// Places of the levels of x̂, u1, u2; nothing for an input without terms.
fn levels_of(&Order { na, nb, nc, .. }: &Order) -> [Option<usize>; 3] {
    let first = na as usize;
    [Some(0), (nb > 0).then_some(first), (nc > 0).then_some(first + used(nb, na))]
}

/// Samples until every delayed input is clean, and the one that starts the filters.
fn filling<const M: usize>(regression: &Regression<M>) -> u8 {
    regression.order.nkb.max(regression.order.nkc).saturating_add(1)
}

fn nominal<const M: usize>(regression: &Regression<M>) -> Candidate<M> {
    candidate(regression, &regression.nominal.delta, regression.nominal.deviation)
}

/// The output error becomes the row's residual through the gain |A(1)| = |t₀|.
fn candidate<const M: usize>(regression: &Regression<M>, delta: &[f32; M], deviation: f32) -> Candidate<M> {
    let gain = delta.first().map_or(0.0, |t| t.abs());
    (*delta, reference::threshold(regression, deviation * gain))
}

/// Δf of (1) for the filter whose level and differences these are.
#[inline]
fn increment(cells: &[f32], t: &[f32], input: f32) -> f32 {
    let (Some((level, differences)), Some((t0, later))) = (cells.split_first(), t.split_first()) else { return 0.0 };
    dot(t0 * (level - input), differences, later)
}

/// Moves level and differences on by Δf.
#[inline]
fn advance(cells: &mut [f32], change: f32) {
    if let Some((level, differences)) = cells.split_first_mut() {
        let mut carried = change;
        for cell in differences {
            carried = core::mem::replace(cell, carried);
        }
        *level += change;
    }
}

#[inline]
fn dot(start: f32, values: &[f32], gains: &[f32]) -> f32 {
    values.iter().zip(gains).fold(start, |sum, (value, gain)| sum + gain * value)
}

/// Writes scaled values into the first cells; gives the cells behind them.
#[inline]
fn put<'c>(cells: &'c mut [f32], values: &[f32], scale: &[f32]) -> &'c mut [f32] {
    let Some((own, rest)) = cells.split_at_mut_checked(values.len()) else { return &mut [] };
    for (cell, (value, scale)) in own.iter_mut().zip(values.iter().zip(scale)) {
        *cell = value * scale;
    }
    rest
}

#[cfg(test)]
mod tests;
