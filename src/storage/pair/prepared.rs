//! Erasing ahead of the next store.
//!
//! ```text
//! slot    erased | mark        "BWER", in the last unit of the slot
//! ```
//!
//! A chip that runs from the bank that it erases stands still meanwhile, up to seconds for a large sector. A drive has
//! that time at boot or at rest, and not where power fails. The mark is written once the erasure is complete: cells of
//! one that was cut off may read as erased, and fail later.

use embedded_storage::nor_flash::NorFlash;

use super::{ERASED, Found, SlotPair, offset, rounded, step, unit};
use crate::storage::error::StorageError;

const MARK: &[u8] = b"BWER";

impl<const PAGE: usize> SlotPair<PAGE> {
    /// Erases the slot that the next store takes, so that this store only writes; returns whether it had to. Until then
    /// the newest record is the only one: if it is damaged, there is none to fall back on.
    ///
    /// # Errors
    /// [`StorageError::Flash`], [`StorageError::NotWritten`]; the next store then erases.
    pub fn prepare<F: NorFlash>(&self, flash: &mut F) -> Result<bool, StorageError<F::Error>> {
        let second = match self.newest_slot(flash)? {
            Found::Record { second, .. } => !second,
            Found::Nothing { second } => second,
        };
        if self.is_prepared(flash, second, 0) {
            return Ok(false);
        }
        let at = self.address(second);
        flash.erase(at, at.saturating_add(self.slot_bytes)).map_err(StorageError::Flash)?;
        Self::write(flash, self.mark::<F>(second), MARK)?;
        Ok(true)
    }

    /// Whether a slot was erased ahead, and a payload of this length and its header leave the mark.
    pub(super) fn is_prepared<F: NorFlash>(&self, flash: &mut F, second: bool, length: usize) -> bool {
        let (from, end) = (self.address(second), self.mark::<F>(second));
        let used = rounded(Self::header::<F>().saturating_add(length), unit::<F>());
        let leaves = from.saturating_add(offset(used)) <= end;
        leaves && Self::reads(flash, end, MARK) && Self::is_erased(flash, from, used)
    }

    /// Where the mark is.
    fn mark<F: NorFlash>(&self, second: bool) -> u32 {
        let room = rounded(MARK.len(), unit::<F>());
        self.address(second).saturating_add(self.slot_bytes).saturating_sub(offset(room))
    }

    /// Whether these bytes are there.
    fn reads<F: NorFlash>(flash: &mut F, at: u32, bytes: &[u8]) -> bool {
        let mut page = [0; PAGE];
        let cells = page.get_mut(..rounded(bytes.len(), unit::<F>())).unwrap_or_default();
        flash.read(at, cells).is_ok() && cells.starts_with(bytes)
    }

    /// Whether so many bytes are erased.
    fn is_erased<F: NorFlash>(flash: &mut F, from: u32, length: usize) -> bool {
        let (mut page, mut done, step) = ([0; PAGE], 0_usize, step::<F>(PAGE).max(1));
        while done < length {
            let part = length.saturating_sub(done).min(step);
            let Some(cells) = page.get_mut(..part) else { return false };
            let read = flash.read(from.saturating_add(offset(done)), cells);
            if read.is_err() || cells.iter().any(|byte| *byte != ERASED) {
                return false;
            }
            done = done.saturating_add(part);
        }
        true
    }
}
