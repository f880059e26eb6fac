//! A flash in RAM with the traits of `embedded-storage`, whose power can fail.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

/// Number of bytes.
const SIZE: usize = 8192;

/// Words of 4 bytes and sectors of 2 kB.
pub struct Flash {
    bytes: [u8; SIZE],
    /// Number of words that are still written before the power fails.
    left: u32,
    erasures: u32,
}

impl Flash {
    /// Erased, with power.
    pub const fn new() -> Self {
        Self { bytes: [0xFF; SIZE], left: u32::MAX, erasures: 0 }
    }

    /// The power fails after so many words.
    pub const fn fail_after(&mut self, words: u32) {
        self.left = words;
    }

    /// The power comes back.
    pub const fn power_up(&mut self) {
        self.left = u32::MAX;
    }

    /// Number of erasures.
    #[allow(dead_code, reason = "only tests count them")]
    pub const fn erasures(&self) -> u32 {
        self.erasures
    }

    fn cells(&mut self, at: u32, length: usize) -> Result<&mut [u8], NorFlashErrorKind> {
        let end = (at as usize).saturating_add(length);
        self.bytes.get_mut(at as usize..end).ok_or(NorFlashErrorKind::OutOfBounds)
    }
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        let cells = self.cells(offset, bytes.len())?;
        bytes.iter_mut().zip(cells).for_each(|(byte, cell)| *byte = *cell);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SIZE
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 2048;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.erasures = self.erasures.saturating_add(1);
        self.cells(from, to.saturating_sub(from) as usize)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        let mut at = offset;
        for word in bytes.chunks_exact(4) {
            if self.left == 0 {
                return Err(NorFlashErrorKind::Other);
            }
            self.left = self.left.saturating_sub(1);
            // A bit is written from 1 to 0 only.
            self.cells(at, 4)?.iter_mut().zip(word).for_each(|(cell, byte)| *cell &= byte);
            at = at.saturating_add(4);
        }
        Ok(())
    }
}
