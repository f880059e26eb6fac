//! From the rate of the signals to the rate of identification.
//!
//! Input: samples of `CH` channels. Output: one sample of the same channels every `B`, `F` or 2ˢ samples.
//!
//! | decimator | factor | gain of aliased components | work of a sample |
//! |---|---|---|---|
//! | [`BlockMean`](super::BlockMean) | any | −13 dB and less | additions; one sample of a block divides |
//! | [`HalfBandDecimator`] | 2ˢ | −80 dB, up to 0.8 of the new Nyquist frequency | 2K₁ + 1 or at most K₂ + 1 multiply-adds a channel |
//! | [`FirDecimator`] | any | depends on its taps | at most `TAPS`/`FACTOR`, rounded up, a channel |
//!
//! All are causal with a constant delay and do not output the start-up transient. [`By`] names the chain of a factor
//! that [`FrontEnd`](super::FrontEnd) uses. With a long filter of one's own, an odd factor can be the last:
//!
//! ```
//! use bearing_watch::drive::{FirDecimator, HalfBandDecimator, HalfBandTaps};
//! // 20 kHz → 5 kHz → 1 kHz. The taps of 1/5 stand for a low-pass from `workbench::trace::prepare::anti_alias(5)`.
//! let mut by_4 = HalfBandDecimator::<3, 1, 4, 4>::new();
//! let mut by_5 = FirDecimator::<3, 5, 5, 1>::new();
//! let mut push = |sample| by_4.push(&HalfBandTaps::GENTLE, sample).and_then(|x| by_5.push(&[0.2; 5], x));
//! let outputs = (0..20_000).filter_map(|_| push([1.0, 2.0, 3.0])).count();
//! assert_eq!(outputs, 997); // a second of signals, less the start
//! ```
//!
//! `cargo xtask firmware measure_decimate` prints the instructions of a sample, mean and worst, of both filters for the
//! same bands.

mod factor;
mod fir;
mod half_band;
mod stage;

pub use factor::{By, Decimate, Factor};
pub use fir::FirDecimator;
pub use half_band::{HalfBandDecimator, HalfBandTaps};
