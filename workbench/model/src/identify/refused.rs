//! Traces from which no parameters follow: too short, constant, or not excited.

use bearing_watch::Structure;

use super::terms::Terms;
use crate::Error;
use crate::trace::Trace;

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
    if trace.y.iter().all(|y| *y == trace.y[0]) {
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
