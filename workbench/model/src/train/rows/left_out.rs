//! Training segments that have none of the chosen features: they are counted and left out.

use crate::Error;
use crate::trace::labels::LabelledTrace;
use crate::train::Candidates;

/// Number of segments that were left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Segments without any of the chosen features.
    pub count: usize,
    /// All segments.
    pub of: usize,
    /// Whether a segment is a part of a trace, not a whole one.
    pub in_pieces: bool,
    /// The first of them, and why it has no features, if that is known.
    pub first: Option<String>,
}

impl LeftOut {
    /// Returns the counts in words; `None` if no segment was left out.
    #[must_use]
    pub fn summary(&self) -> Option<String> {
        let Self { count, of, in_pieces, first } = self;
        let what = if *in_pieces { "segments" } else { "traces" };
        let first = first.as_ref().map_or_else(String::new, |first| format!(" (the first: {first})"));
        (*count > 0).then(|| format!("{count} of {of} {what} have none of the features: left out{first}"))
    }
}

/// Rows before any is left out.
pub(crate) struct Estimated {
    /// All features; one row per segment.
    pub(crate) candidates: Candidates,
    /// Trace of each row.
    pub(crate) origins: Vec<usize>,
    /// Why a row has no verdict: place in the trace and reason.
    pub(crate) reasons: Vec<Option<String>>,
}

impl Estimated {
    /// Returns the rows that have at least one of the chosen features and all covariates, the trace of each,
    /// and the count of the others.
    ///
    /// # Errors
    /// A class for which fewer than two rows are left, with the reason of the first that is left out.
    pub(crate) fn usable(
        &self,
        (chosen, covariates): (&[usize], &[usize]),
        traces: &[LabelledTrace],
        in_pieces: bool,
    ) -> Result<(Candidates, Vec<usize>, LeftOut), Error> {
        let table = &self.candidates.table;
        let has = |row: usize, feature: usize| table.variances[row][feature].is_finite();
        let complete = |row: usize| covariates.iter().all(|&feature| has(row, feature));
        let has_any = |row: &usize| chosen.iter().any(|&feature| has(*row, feature)) && complete(*row);
        let (kept, lost): (Vec<usize>, Vec<usize>) = (0..table.rows.len()).partition(has_any);
        let described = |row: usize| {
            let reason = self.reasons[row].as_deref().unwrap_or("no part that they belong to has a result");
            (traces[self.origins[row]].trace.id.clone(), reason.to_string())
        };
        for class in 0..table.names.len() {
            let left = kept.iter().filter(|&&row| table.classes[row] == class).count();
            let first = lost.iter().find(|&&row| table.classes[row] == class);
            if let (true, Some(&row)) = (left < 2, first) {
                let (trace, reason) = described(row);
                return Err(Error::trace(&trace, reason + REMEDY));
            }
        }
        let first = lost.first().map(|&row| described(row)).map(|(trace, reason)| format!("{trace}, {reason}"));
        let left_out = LeftOut { count: lost.len(), of: table.rows.len(), in_pieces, first };
        let mut candidates = self.candidates.rows(&kept);
        candidates.covariates = (!covariates.is_empty()).then(|| candidates.table.select(covariates));
        let origins = kept.into_iter().map(|row| self.origins[row]).collect();
        Ok((candidates, origins, left_out))
    }
}

const REMEDY: &str = "; choose other channels or a lower order, or leave the trace out";

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::trace::Trace;
    use crate::train::FeatureTable;

    /// Traces of classes 0 and 1, of which these have no feature.
    fn usable(classes: &[usize], without: &[usize]) -> Result<(Candidates, Vec<usize>, LeftOut), Error> {
        let labelled = |(k, &class): (usize, &usize)| LabelledTrace {
            trace: Trace { id: format!("trace {k}"), ..Trace::default() },
            class,
        };
        let traces: Vec<LabelledTrace> = classes.iter().enumerate().map(labelled).collect();
        let rows = classes.iter().map(|_| DVector::zeros(1)).collect();
        let mut table = FeatureTable::exact(rows, classes.to_vec(), vec!["a".into(), "b".into()]);
        without.iter().for_each(|&row| table.variances[row][0] = f64::INFINITY);
        let places: Vec<usize> = (0..classes.len()).collect();
        let candidates = Candidates { table, features: vec!["x".into()], groups: places.clone(), covariates: None };
        let reasons = classes.iter().map(|_| Some("too short".to_string())).collect();
        Estimated { candidates, origins: places, reasons }.usable((&[0], &[]), &traces, false)
    }

    #[test]
    fn a_class_keeps_at_least_two_traces() {
        let (kept, origins, left_out) = usable(&[0, 0, 1, 1, 1], &[3]).expect("two of each class");
        assert_eq!((kept.table.classes, origins), (vec![0, 0, 1, 1], vec![0, 1, 2, 4]));
        let summary = left_out.summary().expect("one is left out");
        assert_eq!(summary, "1 of 5 traces have none of the features: left out (the first: trace 3, too short)");
        let error = usable(&[0, 0, 1, 1], &[3]).expect_err("one trace of class b is left").to_string();
        assert!(error.contains("trace 3") && error.contains("too short; choose other channels"), "{error}");
        assert!(usable(&[0, 0, 1, 1], &[]).is_ok_and(|(.., left_out)| left_out.summary().is_none()));
    }
}
