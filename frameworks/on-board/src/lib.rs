//! What the tests need of a board: change it for yours.

#![no_std]

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Cycles of the processor a second.
pub const CLOCK_HZ: u32 = 168_000_000;

/// Cycles that `WATCH.sample` and `WATCH.collect` may take at most: those of the table in `book/src/target.md` with 5
/// wait states, and a third more for flash whose cache other code uses.
pub const MOST_CYCLES: [u32; 2] = [2640 * 4 / 3, 4530 * 4 / 3];

/// The flash for records, and the address of two sectors that the program does not use; `None` leaves its test out. On
/// a board, the driver of its support crate, such as `embassy_stm32::flash::Flash`.
pub fn flash() -> Option<(Memory, u32, u32)> {
    Some((Memory([0xFF; SECTORS]), 0, SECTOR))
}

const SECTOR: u32 = 2048;
const SECTORS: usize = 2 * SECTOR as usize;

/// Memory that behaves as flash, in the place of a driver: bits are cleared by writing, and set by erasing.
pub struct Memory([u8; SECTORS]);

impl ErrorType for Memory {
    type Error = core::convert::Infallible;
}

impl ReadNorFlash for Memory {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        let cells = self.0.get(offset as usize..).unwrap_or_default();
        bytes.iter_mut().zip(cells).for_each(|(byte, cell)| *byte = *cell);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTORS
    }
}

impl NorFlash for Memory {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.0.get_mut(from as usize..to as usize).unwrap_or_default().fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        let cells = self.0.get_mut(offset as usize..).unwrap_or_default();
        cells.iter_mut().zip(bytes).for_each(|(cell, byte)| *cell &= byte);
        Ok(())
    }
}
