//! Order tracking that tolerates slip: the whitened residual → products of block phasors at the orders of a bearing.
//!
//! Enters: the angle, the whitened residual y and the excitation g of [`super::residual`]. Leaves: [`OrderSums`], from
//! which [`super::slip`] finds the strength and the slip of each order.
//!
//! ```text
//! φ = O_q Θ,   O_q = 2¹⁶ O, wrapping 64 bits: 2⁻⁴⁸ turns;   Θ: angle turned since the start            (1)
//! u(h) = g sgn(ω) e^{j h φ},   x(h) ← u(h) + α x(h),   t(h) = x(h) − v(h),   v(h) ← v(h) + γ t(h)     (2)
//! b(h) = Σ_block y t*(h),   W(h) = Σ_block |t(h)|²                                                    (3)
//! R(h, d) = Σ b_n(h) b_m*(h)  over pairs of blocks, n at most six blocks later, at cells d apart      (4)
//! V(d) = Σ W_n W_m over the same pairs, of the first harmonic                                         (5)
//! e^{2jφ}: c₂ = 1 − 2 s², s₂ = 2 s c;      e^{3jφ}: c₃ = (2 c₂ − 1) c, s₃ = (2 c₂ + 1) s               (6)
//! ```
//!
//! The signal that a defect causes in y has passed the filters of the residual; (2) passes the same filters, so (3) is
//! the matched filter. A block is one passage through a cell of the shaft's angle, 2ⁿ turns wide, or as much motion to
//! and fro within it. Blocks are therefore equal in turns at any speed and end at the same angles after a reversal, and
//! slip turns the phase of (4) by an angle that depends on d only. Products of blocks of backward motion are
//! conjugated. The noise is estimated from the blocks of the control orders ([`super::noise`]).
//!
//! After the end of a cell, one order and harmonic a sample closes its block, so that the work is distributed.
//! `cargo xtask measure` prints instructions and state.

use super::blocks::{CONTROLS, LAGS, MIN_BLOCKS, PLACES, Tracking};
use super::line::{LINE, Line, LineSums, Template};
use super::noise::Noise;
use super::phasor::phasor;
use super::residual::Residual;
use crate::plan::{Array, Cells, Plan, Size};
use crate::reason::{Part, Reason};

/// One control order: t, b and W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Control {
    template: Template,
    block: [f32; 2],
    weight: f32,
}

/// Running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderTracking<P: Plan> {
    lines: Array<P::Orders, Line>,
    controls: [Control; CONTROLS],
    noise: Noise,
    /// Θ of (1), counts of 2⁻³² turn.
    turned: i64,
    /// The cell of Θ, and the angle turned in it, forwards or backwards, counts of 2⁻³² turn.
    cell: i32,
    travelled: u64,
    /// The cells of the last blocks, and how many there are.
    cells: [i32; LAGS],
    held: u8,
    /// Place of the next block among them.
    place: u8,
    /// The cell that closes, and the next item to close: orders times harmonics, then controls; `IDLE` if none.
    closing_cell: i32,
    closing: u8,
    blocks: u32,
}

/// The sums of a segment, separate from the running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderSums<P: Plan> {
    pub(in crate::shaft) lines: Array<P::Orders, LineSums>,
    pub(in crate::shaft) noise: Noise,
    pub(in crate::shaft) blocks: u32,
}

impl<P: Plan> OrderSums<P> {
    /// Why there are no orders.
    pub(in crate::shaft) fn reason(&self) -> Option<Reason> {
        let few = self.blocks < MIN_BLOCKS || self.noise.is_unknown();
        few.then_some(Reason::TooFewRows { part: Part::Orders, rows: self.blocks })
    }
}

const IDLE: u8 = u8::MAX;

impl<P: Plan> OrderTracking<P> {
    pub(in crate::shaft) fn new(plan: P) -> Self {
        Self {
            lines: Cells::filled(plan.layout().orders(), LINE),
            controls: [Control::default(); CONTROLS],
            noise: Noise::default(),
            turned: 0,
            cell: 0,
            travelled: 0,
            cells: [0; LAGS],
            held: 0,
            place: 0,
            closing_cell: 0,
            closing: IDLE,
            blocks: 0,
        }
    }

    /// Takes a sample: the angle turned since the last one in counts of 2⁻³² turn
    /// ([`Angle::since`](crate::Angle::since)), and the residual, which must be finite.
    #[inline(always)]
    pub(in crate::shaft) fn step(&mut self, harmonics: u8, tracking: &Tracking<P>, turned: i32, residual: Residual) {
        self.turned = self.turned.wrapping_add(i64::from(turned));
        self.travelled = self.travelled.wrapping_add(u64::from(turned.unsigned_abs()));
        let (mut lines, mut orders) = (self.lines.cells_mut(), tracking.orders.cells());
        while let ([line, rest @ ..], [order, later @ ..]) = (lines, orders) {
            line.add(harmonics, phase(order.order_q16, self.turned), &tracking.blocks, residual);
            (lines, orders) = (rest, later);
        }
        self.add_controls(tracking, residual);
        if self.closing == IDLE {
            self.watch_cell(tracking.blocks.cell_turns_log2);
        } else {
            self.close_next(harmonics);
        }
    }

    /// Takes the angle turned while there is no residual: blocks before and after a gap keep their phases.
    #[cold]
    #[inline(never)]
    pub(in crate::shaft) fn turn_unwatched(&mut self, turned: i32) {
        if self.held > 0 {
            self.turned = self.turned.wrapping_add(i64::from(turned));
            self.travelled = self.travelled.wrapping_add(u64::from(turned.unsigned_abs()));
        }
    }

    /// Adds the sample to the blocks of the control orders, as to those of the tracked ones.
    #[inline(always)]
    fn add_controls(&mut self, tracking: &Tracking<P>, residual: Residual) {
        for (control, order) in self.controls.iter_mut().zip(tracking.blocks.controls) {
            let Control { template, block, weight } = control;
            template.add(&tracking.blocks, residual, phasor(phase(order, self.turned)), (block, weight));
        }
    }

    /// Starts to close the block if the cell has changed, or if its width was turned to and fro in it.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "the cell is counted modulo 2³²")]
    fn watch_cell(&mut self, cell_turns_log2: i8) {
        let shift = i32::from(cell_turns_log2).wrapping_add(32) & 63;
        let cell = (self.turned >> shift) as i32;
        if cell != self.cell || self.travelled >> shift != 0 {
            (self.closing_cell, self.closing) = (self.cell, 0);
            (self.cell, self.travelled) = (cell, 0);
        }
    }

    /// Closes one item.
    #[inline(never)]
    fn close_next(&mut self, harmonics: u8) {
        let (item, harmonics) = (self.closing as usize, harmonics as usize);
        let lines = self.lines.cells().len();
        let items = lines.wrapping_mul(harmonics);
        self.closing = self.closing.wrapping_add(1);
        if item < items {
            let (line, h) = (item.checked_div(harmonics).unwrap_or(0), item.checked_rem(harmonics).unwrap_or(0));
            let held = (self.held as usize).min(LAGS);
            if let Some(line) = self.lines.cells_mut().get_mut(line) {
                line.close(h, self.closing_cell, &self.cells, (held, self.place as usize));
            }
        } else if let Some(control) = self.controls.get_mut(item.wrapping_sub(items)) {
            let Control { template, block, weight } = *control;
            *control = Control { template, ..Control::default() };
            self.noise.add(item.wrapping_sub(items), block, weight);
        } else {
            if let Some(cell) = self.cells.get_mut(self.place as usize) {
                *cell = self.closing_cell;
            }
            self.place = self.place.wrapping_add(1) % PLACES;
            self.held = self.held.saturating_add(1).min(PLACES);
            self.blocks = self.blocks.saturating_add(1);
            self.closing = IDLE;
        }
    }

    /// A copy of the sums.
    #[inline(always)]
    pub(in crate::shaft) fn sums(&self) -> OrderSums<P> {
        OrderSums { noise: self.noise, blocks: self.blocks, lines: P::Orders::map(&self.lines, |line| line.sums) }
    }

    /// Starts a segment; phases continue.
    #[inline(always)]
    pub(in crate::shaft) fn next_segment(&mut self) {
        for line in self.lines.cells_mut() {
            // History beyond `held` is not read.
            (line.block, line.weight, line.sums) = (LINE.block, LINE.weight, LineSums::EMPTY);
        }
        self.controls = [Control::default(); CONTROLS];
        self.noise = Noise::default();
        (self.blocks, self.held, self.closing) = (0, 0, IDLE);
    }
}

/// The fraction of a turn of (1).
#[inline(always)]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "takes the fraction of a turn")]
fn phase(order_q16: i32, turned: i64) -> u32 {
    (i64::from(order_q16).wrapping_mul(turned) >> 16) as u32
}

#[cfg(test)]
mod tests;
