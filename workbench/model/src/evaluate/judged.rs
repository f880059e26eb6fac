//! Verdicts with what is needed to count them: classes, and the groups in which they are alike.

use std::collections::HashMap;

use super::{Confusion, Rate, TraceVerdict};
use crate::core::Finding;

/// Verdicts on labelled traces, some of classes that the model was not trained on.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// The verdicts; their classes are indices into `classes`.
    pub verdicts: &'a [TraceVerdict],
    /// Names of the trained classes, then of the others.
    pub classes: &'a [String],
    /// Number of trained classes.
    pub trained: usize,
    /// Index of the healthy class, if there is one.
    pub healthy: Option<usize>,
    /// The group (run, drive) of each verdict, if it is known.
    pub groups: Option<&'a [String]>,
    /// Whether segments are counted instead of traces.
    pub per_segment: bool,
}

impl Judged<'_> {
    /// Whether a finding on a trace is right: its own class, or for a class that was not trained anything but healthy.
    pub(crate) fn is_right(&self, class: usize, finding: Option<Finding>) -> bool {
        let healthy = self.healthy.map(Finding::Class);
        if class < self.trained { finding == Some(Finding::Class(class)) } else { finding != healthy }
    }

    /// The number of each verdict's group, and how many groups there are. Without groups, traces are independent and
    /// segments of a trace are alike.
    pub(super) fn places(&self) -> (Vec<usize>, usize) {
        self.groups.map_or_else(|| ((0..self.verdicts.len()).collect(), self.verdicts.len()), numbered)
    }

    /// The rate of right findings on the traces that `chosen` accepts, by their places; `None` if there are none. The
    /// interval considers the groups.
    #[must_use]
    pub fn right(&self, chosen: impl Fn(usize) -> bool) -> Option<Rate> {
        let (places, count) = self.places();
        let mut groups = vec![(0, 0); count];
        for (k, verdict) in self.verdicts.iter().enumerate().filter(|(k, _)| chosen(*k)) {
            for finding in verdict.findings(self.per_segment) {
                groups[places[k]].0 += usize::from(self.is_right(verdict.class, finding));
                groups[places[k]].1 += 1;
            }
        }
        groups.iter().any(|group| group.1 > 0).then(|| Rate::clustered(&groups))
    }

    /// The counts of the trained classes.
    #[must_use]
    pub fn confusion(&self) -> Confusion {
        let (places, count) = self.places();
        let mut confusion =
            Confusion { healthy: self.healthy, ..Confusion::of_groups(&self.classes[..self.trained], count) };
        for (verdict, group) in self.verdicts.iter().zip(places).filter(|(verdict, _)| verdict.class < self.trained) {
            for finding in verdict.findings(self.per_segment) {
                confusion.add_of_group(group, verdict.class, finding);
            }
        }
        confusion
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_untrained_class_is_right_by_anything_but_healthy() {
        let classes = ["healthy", "spall", "wear"].map(String::from);
        let judged =
            Judged { verdicts: &[], classes: &classes, trained: 2, healthy: Some(0), groups: None, per_segment: false };
        let found = [Some(Finding::Class(0)), Some(Finding::Class(1)), Some(Finding::Novel), None];
        assert_eq!(found.map(|finding| judged.is_right(1, finding)), [false, true, false, false]);
        assert_eq!(found.map(|finding| judged.is_right(2, finding)), [false, true, true, true]);
        assert_eq!(judged.right(|_| true), None, "of no traces");
    }
}
