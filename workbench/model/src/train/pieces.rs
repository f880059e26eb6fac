//! Traces cut into segments of the detector's length.

use crate::trace::Trace;
use crate::trace::labels::LabelledTrace;

/// Cuts traces into segments of `samples`, the detector's segment length. A remainder is kept if it is longer than half
/// a segment.
#[must_use]
pub fn cut(traces: &[LabelledTrace], samples: usize) -> Vec<LabelledTrace> {
    let pieces = traces.iter().flat_map(|labelled| {
        let trace = &labelled.trace;
        spans(trace.y.len(), samples).map(|(start, end)| {
            let piece = Trace {
                id: format!("{}[{start}..{end}]", trace.id),
                y: trace.y[start..end].to_vec(),
                u1: trace.u1[start..end].to_vec(),
                u2: trace.u2[start..end].to_vec(),
                motion: trace.motion.as_ref().map(|motion| motion.cut(start, end)),
                further: trace.further.iter().map(|column| column[start..end].to_vec()).collect(),
                found_late: inside(&trace.found_late, start, end),
                ..*trace
            };
            LabelledTrace { trace: piece, class: labelled.class }
        })
    });
    pieces.collect()
}

/// The samples of a list that are in a piece, counted from its start.
fn inside(rows: &[usize], start: usize, end: usize) -> Vec<usize> {
    rows.iter().filter(|row| (start..end).contains(row)).map(|row| row - start).collect()
}

/// Returns start and end of each piece of a trace with `length` samples.
pub(super) fn spans(length: usize, samples: usize) -> impl Iterator<Item = (usize, usize)> {
    let ends = (0..length).step_by(samples.max(1)).map(move |start| (start, (start + samples).min(length)));
    ends.filter(move |(start, end)| 2 * (end - start) > samples)
}
