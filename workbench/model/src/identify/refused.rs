//! Traces from which no parameters follow: too short, constant, not excited, or with missing samples; and the last
//! sample in place of missing ones.

use bearing_watch::plan::Structure;

use super::terms::Terms;
use crate::Error;
use crate::trace::{Trace, bridged};

/// Returns the first row t₀ of a record without missing samples.
pub(super) fn complete_row(structure: Structure, trace: &Trace) -> Result<usize, Error> {
    for (name, signal) in [("y", &trace.y), ("u1", &trace.u1), ("u2", &trace.u2)] {
        if let Some(first) = signal.iter().position(|x| !x.is_finite()) {
            let (count, all) = (signal.iter().filter(|x| !x.is_finite()).count(), signal.len());
            let problem = format!(
                "{name} misses {count} of {all} samples, the first is {first}; only --method ls without --robust leaves \
                 out the rows that miss one; otherwise cut the recording there, or resample it"
            );
            return Err(Error::trace(&trace.id, problem));
        }
    }
    first_row(structure, trace)
}

/// Returns the first usable row t₀ of a record.
pub(super) fn first_row(structure: Structure, trace: &Trace) -> Result<usize, Error> {
    let (t0, n, samples) = (structure.depth(), structure.parameters(), trace.y.len());
    if structure.terms() == 0 {
        return Err(Error::Usage("--order has no terms; give at least one of na, nb, nc".into()));
    }
    if samples <= t0 + n {
        let problem =
            format!("{samples} samples for {n} parameters from sample {t0} on; record more or reduce the order");
        return Err(Error::trace(&trace.id, problem));
    }
    let mut measured = trace.y.iter().filter(|y| y.is_finite());
    let first = measured.next();
    if measured.all(|y| Some(y) == first) {
        return Err(Error::trace(&trace.id, "the output is constant: there is nothing to model; check --y"));
    }
    Ok(t0)
}

/// Error for the parameter whose column is zero or, within rounding, a linear combination of the `partners` before it.
pub(super) fn unexcited(structure: Structure, trace: &Trace, column: usize, partners: &[usize]) -> Error {
    let names = structure.names();
    let reason = match partners {
        [] => "its column is zero".to_string(),
        some => format!("its column depends on {}", some.iter().map(|&k| &names[k][..]).collect::<Vec<_>>().join(", ")),
    };
    let offset = if structure.offset { ", or leave out --offset" } else { "" };
    let column = &names[column];
    let problem = format!(
        "the signals do not excite parameter {column} ({reason}); use a richer command or a lower order{offset}"
    );
    Error::trace(&trace.id, problem)
}

/// Whether no sample of y, u1 and u2 is missing.
pub(crate) fn is_complete(trace: &Trace) -> bool {
    [&trace.y, &trace.u1, &trace.u2].into_iter().flatten().fold(true, |all, x| all & x.is_finite())
}

/// The trace with the last sample in place of missing ones.
pub(crate) fn held(trace: &Trace) -> Trace {
    let [y, u1, u2] = [&trace.y, &trace.u1, &trace.u2].map(|signal| bridged(signal));
    Trace { id: trace.id.clone(), interval_s: trace.interval_s, y, u1, u2, ..Trace::default() }
}
