//! Order tracking that tolerates slip: the whitened residual → products of block phasors at the orders of a bearing.
//!
//! Enters: the angle, the whitened residual y and the excitation g of [`super::residual`]. Leaves: [`OrderSums`], from
//! which [`super::slip`] finds the strength and the slip of each order.
//!
//! ```text
//! φ = O_q Θ,   O_q = 2¹⁶ O, wrapping 64 bits: 2⁻⁴⁸ turns;   Θ: angle turned since the start            (1)
//! c(h) = Σ_block y g sgn(ω) e^{−j h φ},   G = Σ_block g²,   θ = O_q Σ_block g² Δ/G                    (2)
//! b(h) = H*(h θ) c(h),   W(h) = |H(h θ)|² G                                                           (3)
//! R(h, d) = Σ b_n(h) b_m*(h)  over pairs of blocks, n at most six blocks later, at cells d apart      (4)
//! V(d) = Σ W_n W_m over the same pairs, of the first harmonic                                         (5)
//! e^{2jφ}: c₂ = 1 − 2 s², s₂ = 2 s c;      e^{3jφ}: c₃ = (2 c₂ − 1) c, s₃ = (2 c₂ + 1) s               (6)
//! ```
//!
//! Δ is the angle turned in a sample. The signal that a defect causes in y has passed the filters of the residual, with
//! the response H at the speed of the shaft. In a part of a block the speed varies little, so that (3), with H at its
//! mean, is the matched filter, and a sample only multiplies y by a phasor. A block is one passage through a cell of
//! the shaft's angle, 2ⁿ turns wide, or as much motion to and fro within it. Blocks are therefore equal in turns at
//! any speed and end at the same angles after a reversal, and slip turns the phase of (4) by an angle that depends on
//! d only. Where the shaft reverses within a cell, or its speed differs by half from the mean so far, a part ends: (3)
//! holds for it, and it is kept as a block that grows by the next part. Products of blocks of backward motion are
//! conjugated. The noise is estimated from the blocks of the control orders ([`super::noise`]).
//!
//! After the end of a part, one order and harmonic a step closes its block, so that the work is distributed.
//! `cargo xtask measure` prints instructions and state.

use super::blocks::{CONTROLS, LAGS, MIN_BLOCKS, PLACES, Tracking};
use super::line::{self, Harmonics, LINE, Last, Line, LineSums, accumulate};
use super::noise::Noise;
use super::phasor::phasor;
use super::residual::Residual;
use super::response::Response;
use crate::plan::{Array, Cells, Plan};
use crate::reason::{Part, Reason};
use crate::unroll::no_unroll;

/// b and W of a control order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Control {
    block: [f32; 2],
    weight: f32,
}

/// The excitation of a part of a block: G of (2), and Σ g² Δ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Excited {
    square: f32,
    turned: f32,
}

/// c of (2) for a part of a block.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Passage<P: Plan> {
    lines: Array<P::Orders, Harmonics>,
    controls: [[f32; 2]; CONTROLS],
}

impl<P: Plan> Passage<P> {
    fn new(plan: P) -> Self {
        let lines = Cells::filled(plan.layout().orders(), Harmonics::default());
        Self { lines, controls: [[0.0; 2]; CONTROLS] }
    }

    fn clear(&mut self) {
        for line in self.lines.cells_mut() {
            *line = Harmonics::default();
        }
        self.controls = [[0.0; 2]; CONTROLS];
    }

    /// Adds a step at Θ to the orders.
    #[inline(always)]
    fn add_lines(&mut self, tracking: &Tracking<P>, harmonics: u8, turned: i64, product: f32) {
        let (mut lines, mut orders) = (self.lines.cells_mut(), tracking.orders.cells());
        while let ([harmonic, rest @ ..], [order, later @ ..]) = (lines, orders) {
            line::add(harmonic, harmonics, phase(order.order_q16, turned), product);
            (lines, orders) = (rest, later);
        }
    }

    /// Adds a step at Θ to the control orders.
    #[inline(always)]
    fn add_controls(&mut self, tracking: &Tracking<P>, turned: i64, product: f32) {
        for (control, order) in self.controls.iter_mut().zip(tracking.blocks.controls) {
            let (cos, sin) = phasor(phase(order, turned));
            accumulate(control, product, cos, sin);
        }
    }
}

/// The `second` part, or the first. Hidden from the compiler, which would choose the place of each sum again.
#[inline(always)]
fn part<P: Plan>([one, other]: &mut [Passage<P>; 2], second: bool) -> &mut Passage<P> {
    no_unroll(if second { other } else { one })
}

/// A step of which the orders are still to be added.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Taken {
    /// `y g` of (2).
    product: f32,
    /// g with the sign of ω, and Δ.
    excitation: f32,
    turned: i32,
}

/// Running state.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OrderTracking<P: Plan> {
    lines: Array<P::Orders, Line>,
    /// The part that goes on and the one that closes, in turns.
    parts: [Passage<P>; 2],
    /// Whether the part that goes on is the second one.
    second: bool,
    /// b and W of the control orders' parts that have closed.
    open: [Control; CONTROLS],
    excited: Excited,
    /// The last excitation that is not zero.
    excitation: f32,
    /// Θ of (1), counts of 2⁻³² turn.
    turned: i64,
    /// The cell of Θ, and the angle turned in it, forwards or backwards, counts of 2⁻³² turn.
    cell: i32,
    travelled: u64,
    /// The cells of the last blocks, and how many there are.
    cells: [i32; LAGS],
    held: u8,
    /// Place of the next block among them.
    index: u8,
    /// Whether the newest of them grows by the next part.
    continues: bool,
    /// The cell that closes, G and mean Δ, whether the cell goes on, and the next item to close: orders times
    /// harmonics, then controls; `IDLE` if none.
    closing_cell: i32,
    closing_square: f32,
    closing_turned: i32,
    goes_on: bool,
    closing: u8,
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
    pub(in crate::shaft) fn new(plan: P) -> Self {
        let lines = Cells::filled(plan.layout().orders(), LineSums::EMPTY);
        Self { lines, noise: Noise::default(), blocks: 0 }
    }

    /// Nothing yet; in place, since a new one would be moved.
    #[inline(always)]
    pub(in crate::shaft) fn clear(&mut self) {
        for line in self.lines.cells_mut() {
            *line = LineSums::EMPTY;
        }
        (self.noise, self.blocks) = (Noise::default(), 0);
    }

    /// Why there are no orders.
    pub(in crate::shaft) fn reason(&self) -> Option<Reason> {
        let few = self.blocks < MIN_BLOCKS || self.noise.is_unknown();
        few.then_some(Reason::TooFewRows { part: Part::Orders, rows: self.blocks })
    }
}

const IDLE: u8 = u8::MAX;
/// Ratio of speeds, of a sample and of a part's mean, from which a part ends.
const FASTER: f32 = 1.5;

impl<P: Plan> OrderTracking<P> {
    pub(in crate::shaft) fn new(plan: P) -> Self {
        Self {
            lines: Cells::filled(plan.layout().orders(), LINE),
            parts: [Passage::new(plan), Passage::new(plan)],
            second: false,
            open: [Control::default(); CONTROLS],
            excited: Excited::default(),
            excitation: 0.0,
            turned: 0,
            cell: 0,
            travelled: 0,
            cells: [0; LAGS],
            held: 0,
            index: 0,
            continues: false,
            closing_cell: 0,
            closing_square: 0.0,
            closing_turned: 0,
            goes_on: false,
            closing: IDLE,
        }
    }

    /// Takes a step: the angle turned since the last one in counts of 2⁻³² turn
    /// ([`Angle::since`](crate::Angle::since)), and the residual, which must be finite.
    #[inline(always)]
    pub(in crate::shaft) fn step(
        &mut self,
        sums: &mut OrderSums<P>,
        tracking: &Tracking<P>,
        turned: i32,
        (harmonics, residual): (u8, Residual),
    ) {
        let taken = self.advance(turned, residual);
        let part = part(&mut self.parts, self.second);
        part.add_lines(tracking, harmonics, self.turned, taken.product);
        part.add_controls(tracking, self.turned, taken.product);
        self.close(sums, tracking, (harmonics, false), taken);
    }

    /// The first half of a step, at its sample: the control orders.
    #[inline(always)]
    pub(in crate::shaft) fn take(&mut self, tracking: &Tracking<P>, turned: i32, residual: Residual) -> Taken {
        let taken = self.advance(turned, residual);
        part(&mut self.parts, self.second).add_controls(tracking, self.turned, taken.product);
        taken
    }

    /// Its second half, at the sample after it: the orders, and what is to be closed.
    #[inline(always)]
    pub(in crate::shaft) fn leave(
        &mut self,
        sums: &mut OrderSums<P>,
        tracking: &Tracking<P>,
        harmonics: u8,
        taken: Taken,
    ) {
        part(&mut self.parts, self.second).add_lines(tracking, harmonics, self.turned, taken.product);
        self.close(sums, tracking, (harmonics, true), taken);
    }

    #[inline(always)]
    fn advance(&mut self, turned: i32, Residual { white, excitation }: Residual) -> Taken {
        self.turned = self.turned.wrapping_add(i64::from(turned));
        self.travelled = self.travelled.wrapping_add(u64::from(turned.unsigned_abs()));
        let square = excitation * excitation;
        self.excited.square += square;
        self.excited.turned += square * turned as f32;
        Taken { product: white * excitation, excitation, turned }
    }

    /// Closes an item, or finds the end of a part.
    #[inline(always)]
    fn close(&mut self, sums: &mut OrderSums<P>, tracking: &Tracking<P>, lines: (u8, bool), taken: Taken) {
        if self.closing != IDLE {
            self.close_next(sums, lines, tracking);
            return;
        }
        let Taken { excitation, turned, .. } = taken;
        let reversed = excitation * self.excitation < 0.0;
        if excitation != 0.0 {
            self.excitation = excitation;
        }
        let (now, mean) = ((turned as f32).abs() * self.excited.square, self.excited.turned.abs());
        let changed = excitation != 0.0 && (now > FASTER * mean || mean > FASTER * now);
        self.watch_cell(tracking.blocks.cell_turns_log2, reversed || changed);
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

    /// Starts to close the block if the cell has changed or if its width was turned to and fro in it, and a part of it
    /// if the speed has changed.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "the cell is counted modulo 2³², and Δ is an i32")]
    fn watch_cell(&mut self, cell_turns_log2: i8, changed: bool) {
        let shift = i32::from(cell_turns_log2).wrapping_add(32) & 63;
        let cell = (self.turned >> shift) as i32;
        let ends = cell != self.cell || self.travelled >> shift != 0;
        if ends || changed {
            let Excited { square, turned } = core::mem::take(&mut self.excited);
            (self.closing_cell, self.closing, self.goes_on) = (self.cell, 0, !ends);
            self.second = !self.second;
            self.closing_square = square;
            self.closing_turned = if square > 0.0 { (turned / square) as i32 } else { 0 };
            if ends {
                (self.cell, self.travelled) = (cell, 0);
            }
        }
    }

    /// Closes one item.
    #[inline(never)]
    fn close_next(&mut self, sums: &mut OrderSums<P>, (harmonics, halved): (u8, bool), tracking: &Tracking<P>) {
        let (item, harmonics) = (self.closing as usize, harmonics as usize);
        let lines = self.lines.cells().len();
        let control = item.wrapping_sub(lines.wrapping_mul(harmonics));
        self.closing = self.closing.wrapping_add(1);
        let (line, h) = (item.checked_div(harmonics).unwrap_or(0), item.checked_rem(harmonics).unwrap_or(0));
        let (order, times) = match tracking.orders.cells().get(line) {
            Some(order) => (order.order_q16, h.wrapping_add(1)),
            None => (tracking.blocks.controls.get(control).copied().unwrap_or(0), 1),
        };
        let turned = i64::from(self.closing_turned).wrapping_mul(times as i64);
        let response = Response::at(&tracking.blocks, phase(order, turned), halved);
        let weight = response.power * self.closing_square; // (3)
        let (held, index) = ((self.held as usize).min(LAGS), self.place_of_block());
        let part = part(&mut self.parts, !self.second);
        if let Some(sum) = part.lines.cells_mut().get_mut(line).and_then(|line| line.get_mut(h)) {
            let block = response.correct(core::mem::take(sum));
            let last = Last { cells: &self.cells, held, index, continues: self.continues };
            let lines = (self.lines.cells_mut().get_mut(line), sums.lines.cells_mut().get_mut(line));
            if let (Some(line), Some(sums)) = lines {
                line.close(sums, h, (block, weight), (self.closing_cell, last));
            }
        } else if let Some(sum) = part.controls.get_mut(control) {
            let block = response.correct(core::mem::take(sum));
            self.close_control(&mut sums.noise, control, (block, weight));
        } else {
            self.keep_block(&mut sums.blocks);
        }
    }

    /// Closes the part of a control order, and its block if the cell does not go on.
    #[inline(always)]
    fn close_control(&mut self, noise: &mut Noise, control: usize, ([x, y], weight): ([f32; 2], f32)) {
        let Some(open) = self.open.get_mut(control) else { return };
        let [sum_x, sum_y] = open.block;
        *open = Control { block: [sum_x + x, sum_y + y], weight: open.weight + weight };
        if !self.goes_on {
            let Control { block, weight } = core::mem::take(open);
            noise.add(control, block, weight);
        }
    }

    /// Where the block that closes is kept.
    #[inline(always)]
    fn place_of_block(&self) -> usize {
        let newest = if self.index == 0 { PLACES.wrapping_sub(1) } else { self.index.wrapping_sub(1) };
        if self.continues { newest as usize } else { self.index as usize }
    }

    /// Ends the closing of a block.
    #[inline(always)]
    fn keep_block(&mut self, blocks: &mut u32) {
        if !self.continues {
            if let Some(cell) = self.cells.get_mut(self.index as usize) {
                *cell = self.closing_cell;
            }
            self.index = self.index.wrapping_add(1) % PLACES;
            self.held = self.held.saturating_add(1).min(PLACES);
            *blocks = blocks.saturating_add(1);
        }
        (self.continues, self.closing) = (self.goes_on, IDLE);
    }

    /// Starts a segment; phases continue.
    #[inline(never)]
    pub(in crate::shaft) fn next_segment(&mut self) {
        // History is written and read from its start; what lies beyond `held` is not read.
        for part in &mut self.parts {
            part.clear();
        }
        (self.open, self.excited) = ([Control::default(); CONTROLS], Excited::default());
        (self.held, self.index, self.continues, self.closing) = (0, 0, false, IDLE);
    }

    /// Lets a new segment start afresh: the phases of the orders may start anywhere.
    #[inline(always)]
    pub(in crate::shaft) const fn renew(&mut self) {
        (self.second, self.excitation, self.turned) = (false, 0.0, 0);
        (self.cell, self.travelled) = (0, 0);
    }
}

/// The fraction of a turn of (1); no order is negative.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "takes the fraction of a turn")]
const fn phase(order_q16: i32, turned: i64) -> u32 {
    ((order_q16.cast_unsigned() as u64).wrapping_mul(turned.cast_unsigned()) >> 16) as u32
}

#[cfg(test)]
mod tests;
