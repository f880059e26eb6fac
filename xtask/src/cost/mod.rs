//! What calls and programs cost on the chip: instructions, cycles, bytes, and the bounds that must be kept.

pub mod bounds;
mod cycles;
pub mod measure;
pub mod rivals;
