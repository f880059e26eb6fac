//! The verdict of a solved segment.

use super::segment::Segment;
use crate::model::Model;
use crate::plan::{Cells, Plan};
use crate::reason::Reason;
use crate::report::{Report, Verdict};

/// Whether the signals contradict the model or each other; then that is the reason for no verdict.
// Out of line, so that it takes no stack during the solve.
#[inline(never)]
pub(super) fn contradicts<P: Plan>(model: &Model<P>, segment: &Segment<P>, report: &mut Report<P>) -> bool {
    let sums = (segment.shaft.part(), model.constants().shaft.part());
    let (Some(estimate), (Some(sums), Some(constants))) = (report.shaft.part_mut(), sums) else { return false };
    let Some(error) = estimate.contradiction(model.plan(), constants, sums) else { return false };
    report.verdict = Verdict::Undetermined(Reason::Implausible(error));
    report.decision = None;
    true
}

/// The verdict of a classified segment.
pub(super) fn judge<P: Plan>(
    model: &Model<P>,
    segment: &Segment<P>,
    report: &mut Report<P>,
    result: Result<(), Reason>,
) {
    let constants = model.constants();
    // The model knows the spread of whole segments only.
    let short = segment.whole && report.rows < constants.sampling.segment_samples / 2;
    let result = if short { result.and(Err(Reason::ShortSegment { rows: report.rows })) } else { result };
    conclude(model, report, result);
}

/// The verdict of a decision.
#[inline(always)]
pub(super) fn conclude<P: Plan>(model: &Model<P>, report: &mut Report<P>, result: Result<(), Reason>) {
    report.verdict = match (result, &report.decision) {
        (Ok(()), Some(decision)) => model.constants().classifier.verdict(decision),
        (Err(reason), _) => Verdict::Undetermined(reason),
        // Never: a classified segment has a decision.
        (Ok(()), None) => return,
    };
    if result.is_err() {
        report.decision = None;
    }
}

/// With the feature `defmt`, logs each closed segment on a chip; host programs have no logger.
pub(super) fn log<P: Plan>(model: &Model<P>, report: &Report<P>) {
    #[cfg(all(feature = "defmt", target_os = "none"))]
    {
        let Report { rows, counts, .. } = report;
        match report.verdict {
            Verdict::Class(class) => {
                if counts.rejected > 0 || counts.saturated > 0 {
                    defmt::warn!(
                        "samples refused: {=u32} rejected, {=u32} saturated",
                        counts.rejected,
                        counts.saturated
                    );
                }
                let label = model.label(class);
                defmt::info!("{=u32} rows, {}, class {=u8}, verdict: {=str}", rows, counts, class, label);
            }
            Verdict::Novel => defmt::warn!("{=u32} rows, {}, verdict: novel", rows, counts),
            Verdict::Ambiguous => defmt::info!("{=u32} rows, {}, verdict: ambiguous", rows, counts),
            Verdict::Undetermined(reason) => defmt::warn!("{=u32} rows, {}, no verdict: {}", rows, counts, reason),
        }
    }
    #[cfg(not(all(feature = "defmt", target_os = "none")))]
    let _ = (model, report);
}
