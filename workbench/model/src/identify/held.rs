//! A trace with the last sample in place of missing ones.

use crate::trace::{Trace, bridged};

/// Whether no sample of y, u1 and u2 is missing.
pub(super) fn is_complete(trace: &Trace) -> bool {
    [&trace.y, &trace.u1, &trace.u2].into_iter().flatten().fold(true, |all, x| all & x.is_finite())
}

/// The trace with the last sample in place of missing ones.
pub(super) fn held(trace: &Trace) -> Trace {
    let [y, u1, u2] = [&trace.y, &trace.u1, &trace.u2].map(|signal| bridged(signal));
    Trace { id: trace.id.clone(), interval_s: trace.interval_s, y, u1, u2, ..Trace::default() }
}
