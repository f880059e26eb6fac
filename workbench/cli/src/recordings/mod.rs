//! Commands on recordings: what they are, what they are worth, other formats, and simulated ones.

pub(crate) mod audit;
pub(crate) mod convert;
pub(crate) mod init;
pub(crate) mod reading;
pub(crate) mod simulate;
