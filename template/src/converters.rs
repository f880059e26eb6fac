//! Stands for the converters of a board: `rows.bin`, a recording that `bearing-watch replay --rows` wrote, in flash.
//! A drive reads its own converters instead.

use core::slice::ChunksExact;

use crate::detector::Reading;

static RECORDING: &[u8] = include_bytes!("../rows.bin");

/// Bytes before the first row.
const HEAD: usize = 8;
/// Bytes of a row with two further channels.
const ROW: usize = 24;

/// The readings of the recording, one after another.
pub struct Converters {
    rows: ChunksExact<'static, u8>,
}

impl Converters {
    pub fn new() -> Self {
        Self { rows: RECORDING.get(HEAD..).unwrap_or_default().chunks_exact(ROW) }
    }
}

impl Iterator for Converters {
    type Item = Reading;

    fn next(&mut self) -> Option<Reading> {
        let row = self.rows.next()?;
        let half = |place| row.get(place..place + 2).and_then(|b| b.try_into().ok()).map_or(0, u16::from_le_bytes);
        let word = |place| row.get(place..place + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes);
        Some(Reading {
            number: word(0),
            phases: [half(4), half(6), half(8)],
            position: (word(12) >> 18) as u16, // the angle as a fraction of 2³²; the converter has 14 bits
            load_torque_nm: f32::from_bits(word(16)),
            velocity_ref_rad_s: f32::from_bits(word(20)),
        })
    }
}
