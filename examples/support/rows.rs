//! Rows of a recording, as `bearing-watch replay --rows` writes them, from the file `rows.bin`.

use bearing_watch::Angle;
use bearing_watch::drive::{PhaseCounts, Position, RawSample};

use self::file::File;

/// Name of the file, with the zero that semihosting wants behind it.
const NAME: &str = "rows.bin\0";
/// Bytes of a row without further channels.
const FIXED: usize = 16;
/// Bytes of the longest row: 16 further channels.
const LONGEST: usize = FIXED + 64;

/// The rows of the recording, one after another.
pub struct Rows<const FURTHER: usize> {
    file: File,
}

impl<const FURTHER: usize> Rows<FURTHER> {
    /// Opens the file; `None` if there is none. Rows with another number of further channels end the program.
    pub fn open() -> Option<Self> {
        const { assert!(FIXED + 4 * FURTHER <= LONGEST) };
        let mut file = File::open(NAME)?;
        let mut head = [0; 8];
        let right = file.fill(&mut head) && head.starts_with(b"BWR1") && word(&head, 4) as usize == FURTHER;
        assert!(right, "rows.bin is not made for this model");
        Some(Self { file })
    }
}

impl<const FURTHER: usize> Iterator for Rows<FURTHER> {
    type Item = RawSample<FURTHER>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut bytes = [0; LONGEST];
        let row = bytes.get_mut(..FIXED + 4 * FURTHER)?;
        if !self.file.fill(row) {
            return None;
        }
        let half = |place: usize| (word(row, place) & 0xffff) as u16;
        let (a, b, c, flags) = (half(4), half(6), half(8), half(10));
        let two = flags & 2 != 0;
        let missing = flags & 1 != 0;
        Some(RawSample {
            number: word(row, 0),
            currents: if two { PhaseCounts::Two([a, b]) } else { PhaseCounts::Three([a, b, c]) },
            position: if missing { Position::Missing } else { Position::Absolute(Angle::from_bits(word(row, 12))) },
            further: core::array::from_fn(|k| f32::from_bits(word(row, FIXED + 4 * k))),
        })
    }
}

/// The little-endian word at a place; bytes beyond the end are zero.
fn word(bytes: &[u8], place: usize) -> u32 {
    let byte = |k: usize| u32::from(bytes.get(place + k).copied().unwrap_or_default());
    byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24
}

#[cfg(not(target_os = "none"))]
mod file {
    use std::io::{BufReader, Read as _};

    pub struct File(BufReader<std::fs::File>);

    impl File {
        pub fn open(name: &str) -> Option<Self> {
            std::fs::File::open(name.trim_end_matches('\0')).ok().map(|file| Self(BufReader::new(file)))
        }

        /// Whether all of `bytes` was read.
        pub fn fill(&mut self, bytes: &mut [u8]) -> bool {
            self.0.read_exact(bytes).is_ok()
        }
    }
}

/// Files of the host by semihosting.
#[cfg(target_os = "none")]
mod file {
    use cortex_m_semihosting::syscall;

    /// Bytes of one call to the host.
    const BLOCK: usize = 4096;
    /// Mode `rb` of `fopen`.
    const READ_BINARY: usize = 1;

    pub struct File {
        handle: usize,
        block: [u8; BLOCK],
        used: usize,
        filled: usize,
    }

    impl File {
        pub fn open(name: &str) -> Option<Self> {
            // SAFETY: the arguments are those of SYS_OPEN: text that ends with a zero, a mode, the length without it.
            let handle = unsafe { syscall!(OPEN, name.as_ptr(), READ_BINARY, name.len() - 1) };
            (handle != usize::MAX).then_some(Self { handle, block: [0; BLOCK], used: 0, filled: 0 })
        }

        /// Whether all of `bytes` was read.
        pub fn fill(&mut self, bytes: &mut [u8]) -> bool {
            bytes.iter_mut().all(|byte| self.next().map(|next| *byte = next).is_some())
        }

        fn next(&mut self) -> Option<u8> {
            if self.used == self.filled {
                // SAFETY: SYS_READ writes at most BLOCK bytes to the block, which lives until the call returns.
                let left = unsafe { syscall!(READ, self.handle, self.block.as_mut_ptr(), BLOCK) };
                (self.used, self.filled) = (0, BLOCK.checked_sub(left)?);
            }
            let byte = self.block.get(..self.filled)?.get(self.used).copied()?;
            self.used += 1;
            Some(byte)
        }
    }
}
