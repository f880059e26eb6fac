//! The demo's model, and recorded traces of the rig as the converter's counts.

pub mod model;

use model::{MODEL, Sample};

/// Three traces of 5000 samples, held out from training; three 16-bit counts a sample.
static RECORDING: &[u8] = include_bytes!("held_out.bin");

/// The recorded samples, one trace after another.
pub fn samples() -> impl Iterator<Item = Sample> {
    RECORDING.chunks_exact(6).map(measured)
}

/// Counts of the converter, which spans the limits of the model's channels, as physical values.
fn measured(sample: &[u8]) -> Sample {
    let mut values = [0.0; 3];
    let channels = &MODEL.constants().channels;
    for ((value, count), channel) in values.iter_mut().zip(sample.chunks_exact(2)).zip(channels) {
        if let [low, high] = count {
            *value = f32::from(i16::from_le_bytes([*low, *high])) * (channel.limit / 32_768.0);
        }
    }
    let [current_a, velocity_ref_rad_s, load_torque_nm] = values;
    Sample { current_a, velocity_ref_rad_s, load_torque_nm }
}
