//! The demo's model, and recorded traces of the rig as the converter's counts.

pub mod model;

use bearing_watch::Sample;

use model::MODEL;

/// Three traces of 5000 samples, held out from training; three 16-bit counts a sample.
static RECORDING: &[u8] = include_bytes!("held_out.bin");

/// The recorded samples, one trace after another.
pub fn samples() -> impl Iterator<Item = Sample> {
    RECORDING.chunks_exact(6).map(measured)
}

/// Counts of the converter, which spans the model's limits, as physical values.
fn measured(sample: &[u8]) -> Sample {
    let mut values = [0.0; 3];
    for ((value, count), limit) in values.iter_mut().zip(sample.chunks_exact(2)).zip(MODEL.regression.guard.limit) {
        if let [low, high] = count {
            *value = f32::from(i16::from_le_bytes([*low, *high])) * (limit / 32_768.0);
        }
    }
    let [y, u1, u2] = values;
    Sample { y, u1, u2 }
}
