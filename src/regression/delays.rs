//! Two signals as they were some samples ago.

use crate::plan::{Array, Cells, Plan};

/// Delay lines of both inputs in one array: nkb samples of the first, then nkc of the second.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Delays<P: Plan> {
    ring: Array<P::Delays, f32>,
    indices: [u8; 2],
}

impl<P: Plan> Delays<P> {
    /// All samples zero.
    pub fn new(plan: P) -> Self {
        Self { ring: Cells::filled(plan.layout().delays(), 0.0), indices: [0; 2] }
    }

    /// Takes both inputs; returns the first as it was nkb samples ago, the second as it was nkc samples ago.
    #[inline(always)]
    pub fn push(&mut self, [u1, u2]: [f32; 2], [nkb, nkc]: [u8; 2]) -> [f32; 2] {
        let [place_1, place_2] = &mut self.indices;
        let Some((first, second)) = self.ring.cells_mut().split_at_mut_checked(nkb as usize) else { return [u1, u2] };
        [exchange(first, place_1, u1, nkb), exchange(second, place_2, u2, nkc)]
    }
}

#[inline(always)]
fn exchange(ring: &mut [f32], index: &mut u8, newest: f32, delay: u8) -> f32 {
    let Some(cell) = ring.get_mut(*index as usize) else { return newest };
    let next = index.wrapping_add(1);
    *index = if next >= delay { 0 } else { next };
    core::mem::replace(cell, newest)
}
