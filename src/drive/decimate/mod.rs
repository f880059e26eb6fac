//! From the rate of the signals to the rate of identification.
//!
//! Enters: samples of `CH` channels. Leaves: one sample of the same channels every `B`, `F` or 2ˢ samples.
//!
//! | decimator | factor | what folds back into the band kept | instructions a sample, 3 channels, typical / worst |
//! |---|---|---|---|
//! | [`BlockMean`] | any | −13 dB | a few |
//! | [`HalfBandDecimator`] | 2ˢ | −80 dB, up to 0.8 of the new Nyquist frequency | TYPICAL8 / WORST8 by 8 |
//! | [`FirDecimator`] | any | what its taps let through | FIR8 / FIRW8 by 8, same bands |
//!
//! All are causal with a constant delay, and hand on no start-up transient. `cargo xtask measure` counts.

pub mod block_mean;
pub mod fir;
pub mod half_band;

pub use block_mean::BlockMean;
pub use fir::FirDecimator;
pub use half_band::{HalfBandDecimator, HalfBandTaps};
