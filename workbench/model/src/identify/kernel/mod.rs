//! Numerical kernels for single estimates ([`crate::identify`]) and for searches ([`crate::structure`]).
//!
//! * [`sums`]: sums of products and of squared differences.
//! * [`filter`]: weighted sums of columns, FIR filters and the filter 1/A.
//! * [`free_run`]: simulation of a model from its inputs.
//! * [`triangle`]: the triangular factor of columns, computed in blocks of rows.
//!
//! On x86-64 processors with AVX2 or AVX-512 the loops use these instructions; the order of the operations, and
//! therefore the result, is the same.

pub(crate) mod filter;
pub(crate) mod free_run;
pub(crate) mod sums;
pub(crate) mod triangle;
