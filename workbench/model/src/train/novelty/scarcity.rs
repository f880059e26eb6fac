//! Whether there are enough segments or runs for the rate of a gate.

use super::least_rows::fewest;
use super::runs;

/// What must suffice for the rate of a gate.
pub(super) enum Counted {
    Runs(usize),
    /// Rows that have the coordinate which is missing most often, and this coordinate.
    Rows((usize, Option<usize>)),
}

/// Says why there are too few segments or runs for a gate at this rate.
pub(super) fn scarcity(counted: Counted, fitted: usize, names: &[String], rate: f64) -> Option<String> {
    let (rows, scarce) = match counted {
        Counted::Runs(count) => {
            let count = count.saturating_sub(fitted);
            return (count < runs::fewest(names.len(), rate)).then(|| runs::refusal(names.len(), count, rate));
        }
        Counted::Rows(own) => own,
    };
    let least = fewest(names.len(), rate);
    let with = scarce.map_or_else(String::new, |k| format!(" with {}", names[k]));
    (rows.saturating_sub(fitted) < least).then(|| {
        format!(
            "{rows} healthy segments{with} are too few for a novelty gate of {} coordinates at a false-alarm rate of \
             {rate}; give at least {least}, shorter segments, fewer features, or a higher rate",
            names.len()
        )
    })
}
