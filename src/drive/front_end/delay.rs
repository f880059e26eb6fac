//! The delay of an angle behind a decimator.
//!
//! An output needs the angle of one sample only, the centre of its taps. Of every F samples the one at that place is
//! kept, so a delay of D samples takes D/F cells.

use crate::signal::Angle;

/// The delay of every chain of filters is below 16.5 outputs; one more cell holds the newest angle.
pub(super) const CELLS: u8 = 17;

/// The angles at the centres of the last and the next outputs.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Centres {
    cells: [Angle; CELLS as usize],
    newest: u8,
}

impl Centres {
    pub(super) const NEW: Self = Self { cells: [Angle::ZERO; CELLS as usize], newest: 0 };

    #[inline(always)]
    pub(super) fn put(&mut self, angle: Angle) {
        self.newest = if self.newest < CELLS - 1 { self.newest.wrapping_add(1) } else { 0 };
        if let Some(cell) = self.cells.get_mut(self.newest as usize) {
            *cell = angle;
        }
    }

    /// The angle that was put `back` calls of [`Self::put`] ago, below [`CELLS`].
    #[inline(always)]
    pub(super) fn get(&self, back: u8) -> Angle {
        let index = self.newest.wrapping_sub(back);
        // A place below zero has wrapped.
        let index = if index < CELLS { index } else { index.wrapping_add(CELLS) };
        self.cells.get(index as usize).copied().unwrap_or(Angle::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_return_in_their_order() {
        let mut centres = Centres::NEW;
        for k in 0..100_u32 {
            centres.put(Angle::from_bits(k));
            for back in 0..CELLS {
                let expected = k.saturating_sub(u32::from(back));
                assert_eq!(centres.get(back), Angle::from_bits(expected), "{back} before {k}");
            }
        }
    }
}
