//! Segments of the detector's length in a trace.

/// Returns start and end of each piece of a trace with `length` samples.
pub(super) fn spans(length: usize, samples: usize) -> impl Iterator<Item = (usize, usize)> {
    let ends = (0..length).step_by(samples.max(1)).map(move |start| (start, (start + samples).min(length)));
    ends.filter(move |(start, end)| 2 * (end - start) > samples)
}
