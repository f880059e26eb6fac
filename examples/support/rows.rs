//! Rows of a recording, as `bearing-watch replay --rows` writes them, from the file `rows.bin`.

#[path = "file.rs"]
mod file;

use bearing_watch::Angle;
use bearing_watch::drive::{PhaseCounts, Position, RawSample};

use self::file::File;

/// Name of the file, with the zero that semihosting wants behind it.
const NAME: &str = "rows.bin\0";
/// Bytes of a row without further channels.
const FIXED: usize = 16;
/// Bytes of the longest row: 16 further channels.
const LONGEST: usize = FIXED + 64;
/// Bytes of one call to the host.
const BLOCK: usize = 4096;

/// The rows of the recording, one after another.
pub struct Rows<const FURTHER: usize> {
    file: File<BLOCK>,
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
        let currents = match (flags & 4 != 0, flags & 2 != 0) {
            (true, _) => PhaseCounts::Quadrature(f32::from_bits(word(row, 4))),
            (false, true) => PhaseCounts::Two([a, b]),
            (false, false) => PhaseCounts::Three([a, b, c]),
        };
        let missing = flags & 1 != 0;
        Some(RawSample {
            number: word(row, 0),
            currents,
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
