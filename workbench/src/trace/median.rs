//! The median of a list.

use std::borrow::Cow;

/// The median, of an even number of values the larger of the middle two; NaN of an empty list.
pub(crate) fn median<'a>(values: impl Into<Cow<'a, [f64]>>) -> f64 {
    let mut values = values.into().into_owned();
    let middle = values.len() / 2;
    if values.is_empty() { f64::NAN } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
