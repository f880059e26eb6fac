//! A NOR flash in memory whose power can fail at any byte.

use std::cell::Cell;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// A flash with these sizes of reads, writes and erasures.
#[derive(Clone, Debug)]
pub struct Flash<const READ: usize, const WRITE: usize, const ERASE: usize> {
    /// The cells.
    pub bytes: Vec<u8>,
    /// Number of erasures of each sector.
    pub erasures: Vec<u32>,
    /// Number of bytes that are still erased or written before the power fails; `None` if it does not fail.
    left: Option<u64>,
    /// Number of bytes erased and written so far.
    pub worked: u64,
    state: Cell<u64>,
}

impl<const READ: usize, const WRITE: usize, const ERASE: usize> Flash<READ, WRITE, ERASE> {
    /// So many sectors of random content, as a drive may find them.
    #[must_use]
    pub fn new(sectors: usize, seed: u64) -> Self {
        let mut flash =
            Self { bytes: vec![], erasures: vec![0; sectors], left: None, worked: 0, state: Cell::new(seed) };
        flash.bytes = (0..sectors * ERASE).map(|_| flash.random()).collect();
        flash
    }

    /// Power fails after so many bytes; what is interrupted is random from there on.
    pub fn fail_after(&mut self, bytes: u64) {
        self.left = Some(bytes);
    }

    /// Power comes back; returns whether it had failed.
    pub fn power_up(&mut self) -> bool {
        self.left.take() == Some(0)
    }

    /// A byte (Steele, Lea and Flood 2014).
    fn random(&self) -> u8 {
        let state = self.state.get().wrapping_add(0x9E37_79B9_7F4A_7C15);
        self.state.set(state);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (mixed >> 56) as u8
    }

    /// Takes a byte's worth of power; returns whether there was any.
    fn power(&mut self) -> bool {
        match &mut self.left {
            Some(0) => return false,
            Some(left) => *left -= 1,
            None => {}
        }
        self.worked += 1;
        true
    }
}

impl<const READ: usize, const WRITE: usize, const ERASE: usize> ErrorType for Flash<READ, WRITE, ERASE> {
    type Error = NorFlashErrorKind;
}

impl<const READ: usize, const WRITE: usize, const ERASE: usize> ReadNorFlash for Flash<READ, WRITE, ERASE> {
    const READ_SIZE: usize = READ;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        if self.left == Some(0) {
            return Err(NorFlashErrorKind::Other);
        }
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const READ: usize, const WRITE: usize, const ERASE: usize> NorFlash for Flash<READ, WRITE, ERASE> {
    const WRITE_SIZE: usize = WRITE;
    const ERASE_SIZE: usize = ERASE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        for sector in from as usize / ERASE..to as usize / ERASE {
            if self.left == Some(0) {
                return Err(NorFlashErrorKind::Other);
            }
            self.erasures[sector] += 1;
            let cells = sector * ERASE..(sector + 1) * ERASE;
            if cells.clone().all(|_| self.power()) {
                self.bytes[cells].fill(0xFF);
                continue;
            }
            // Cells of the sector are anywhere between their old content and erased.
            for place in cells {
                self.bytes[place] |= self.random();
            }
            return Err(NorFlashErrorKind::Other);
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        for (place, word) in (offset as usize..).step_by(WRITE).zip(bytes.chunks(WRITE)) {
            if self.left == Some(0) {
                return Err(NorFlashErrorKind::Other);
            }
            let cells = place..place + WRITE;
            assert!(self.bytes[cells.clone()].iter().all(|byte| *byte == 0xFF), "a word is written only once erased");
            if word.iter().all(|_| self.power()) {
                self.bytes[cells].copy_from_slice(word);
                continue;
            }
            // Some of the bits that should become 0 have done so.
            for (place, byte) in cells.zip(word) {
                self.bytes[place] = byte | self.random();
            }
            return Err(NorFlashErrorKind::Other);
        }
        Ok(())
    }
}
