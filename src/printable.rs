//! What can be printed.

use core::fmt::Debug;

/// `Debug`, and with the feature `defmt` also `defmt::Format`.
#[cfg(feature = "defmt")]
pub trait Printable: Debug + defmt::Format {}
#[cfg(feature = "defmt")]
impl<T: Debug + defmt::Format> Printable for T {}

/// `Debug`, and with the feature `defmt` also `defmt::Format`.
#[cfg(not(feature = "defmt"))]
pub trait Printable: Debug {}
#[cfg(not(feature = "defmt"))]
impl<T: Debug> Printable for T {}
