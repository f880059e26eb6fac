//! Recordings are known again by their content: a name may be given twice, and a file be copied.

use crate::trace::Trace;
use crate::trace::labels::LabelledTrace;
use crate::trace::trace_name;

/// A number of the output of a trace, which every model reads: equal recordings have equal ones, and two different ones
/// agree by a chance of 2⁻³².
#[must_use]
pub fn content(trace: &Trace) -> u32 {
    // FNV-1a, 64 bits, over the numbers.
    let each = |hash: u64, x: &f64| (hash ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3);
    let hash = trace.y.iter().fold(0xcbf2_9ce4_8422_2325, each);
    (hash ^ hash >> 32) as u32
}

/// How many of these traces a model was trained on, and in words how that is known; none if there are none.
pub(super) fn seen(traces: &[LabelledTrace], (ids, contents): (&[String], &[u32])) -> (usize, Option<String>) {
    let is_id = |t: &&LabelledTrace| ids.iter().any(|id| *id == trace_name(&t.trace.id));
    let (count, what) = if contents.is_empty() {
        (traces.iter().filter(is_id).count(), "have the names of traces that the model was trained on")
    } else {
        let is_known = |t: &&LabelledTrace| contents.contains(&content(&t.trace));
        (traces.iter().filter(is_known).count(), "were trained on")
    };
    let words = || format!("{count} of {} traces {what}: the rates flatter the model", traces.len());
    (count, (count > 0).then(words))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_tells_and_the_name_only_without_it() {
        let labelled = |id: &str, y: &[f64]| LabelledTrace {
            trace: Trace { id: id.into(), y: y.to_vec(), ..Trace::default() },
            class: 0,
        };
        let (one, copy, other) =
            (labelled("a.csv", &[1.0, 2.0]), labelled("b.csv", &[1.0, 2.0]), labelled("a", &[2.0, 1.0]));
        let contents = [content(&one.trace)];
        let (ids, all) = (["a".to_string()], [one, copy, other]);
        let (count, words) = seen(&all, (&ids, &contents));
        assert_eq!((count, words.as_deref()), (2, Some("2 of 3 traces were trained on: the rates flatter the model")));
        let (count, words) = seen(&all, (&ids, &[]));
        assert!(count == 2 && words.is_some_and(|words| words.contains("have the names of")));
        assert_eq!(seen(&all[2..], (&ids, &contents)), (0, None));
        assert_ne!(content(&labelled("", &[0.0, 1.0]).trace), content(&labelled("", &[1.0, 0.0]).trace));
    }
}
