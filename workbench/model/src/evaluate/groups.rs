//! Names of groups → numbers.

use std::collections::HashMap;

/// The number of each name in the order of first appearance, and how many different ones there are.
pub(super) fn numbered(names: &[String]) -> (Vec<usize>, usize) {
    let mut known: HashMap<&str, usize> = HashMap::new();
    let mut places = Vec::with_capacity(names.len());
    for name in names {
        let next = known.len();
        places.push(*known.entry(name).or_insert(next));
    }
    (places, known.len())
}
