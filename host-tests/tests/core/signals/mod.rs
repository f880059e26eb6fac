//! From converters to samples: the resolver-to-digital converter, frames, decimation.

mod ad2s1210;
mod decimation;
mod frames;
mod resampling;
