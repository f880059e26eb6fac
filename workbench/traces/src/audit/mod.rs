//! What recordings are worth: rate, gaps, held and saturated samples, lags, equal traces, smallest line of an order.

mod asked;
mod audited;
mod findings;
mod looked;
mod words;
mod work;

pub use asked::{Audit, USE};
pub use audited::{Audited, Finding, Line, Outcome};
