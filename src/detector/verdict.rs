//! The verdict of a solved segment.

use super::segment::Segment;
use crate::model::{Model, Most};
use crate::plan::{Cells, Plan};
use crate::reason::{FrictionTerm, Obstacle, Reason};
use crate::regression::factor::pairs;
use crate::report::{Report, Verdict};
use crate::unroll::no_unroll;

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

/// The verdict of a classified segment, and whether it would have shown an acceptable friction.
pub(super) fn judge<P: Plan>(
    model: &Model<P>,
    segment: &Segment<P>,
    report: &mut Report<P>,
    (result, friction): (Result<(), Reason>, bool),
) {
    let constants = model.constants();
    // The model knows the spread of whole segments only.
    let short = segment.whole && report.rows < constants.sampling.segment_samples / 2;
    let result = if short { result.and(Err(Reason::ShortSegment { rows: report.rows })) } else { result };
    conclude(model, report, result);
    if report.verdict == Verdict::Novel {
        name_order(model, report);
    }
    let healthy = constants.classifier.novelty.class.map(Verdict::Class);
    if Some(report.verdict) == healthy
        && let Some(reason) = unseen(model, report, friction)
    {
        (report.verdict, report.decision) = (Verdict::Undetermined(reason), None);
    }
}

/// Names the strongest bearing order as what departs most, if one has the score that a defect needs: a defect of a race
/// raises friction too, and often by more deviations.
#[inline(never)]
fn name_order<P: Plan>(model: &Model<P>, report: &mut Report<P>) {
    let (classifier, shaft) = (&model.constants().classifier, model.constants().shaft.part());
    let parts = (shaft, report.shaft.part(), report.decision.as_mut());
    let (Some(constants), Some(shaft), Some(decision)) = parts else { return };
    let orders = constants.tracking.orders.cells();
    let mut strongest = f32::NEG_INFINITY;
    for k in 0..no_unroll(classifier.novelty.mean.cells().len()) {
        let only = classifier.projection.only(k).and_then(|(index, _)| classifier.features.cells().get(index)?.order());
        let Some(index) = only else { continue };
        let Some((own, order)) = shaft.orders().get(index as usize).zip(orders.get(index as usize)) else { continue };
        if !own.unseen && own.score >= order.needed_score && own.score > strongest {
            strongest = own.score;
            decision.most = u8::try_from(k).ok().map(|coordinate| Most { coordinate, falls: false });
        }
    }
}

/// Why a segment that seems healthy would not have shown a defect: of the bearing orders, if the model has some, none
/// shows an acceptable amplitude; of a model without orders, no friction is determined well enough.
#[inline(never)]
fn unseen<P: Plan>(model: &Model<P>, report: &Report<P>, friction: bool) -> Option<Reason> {
    let (constants, shaft) = (model.constants(), report.shaft()?);
    let (classifier, orders) = (&constants.classifier, &constants.shaft.part()?.tracking.orders);
    let missing = report.decision.as_ref()?.missing();
    // Of orders and of frictions: whether the model has such features, and whether one has seen enough.
    let (mut of_orders, mut of_frictions) = ([false; 2], [false; 2]);
    for (feature, missing) in pairs(no_unroll(classifier.features.cells()), no_unroll(missing)) {
        let (seen, good) = if let Some(index) = feature.order() {
            let pair = shaft.orders().get(index as usize).zip(orders.cells().get(index as usize));
            (&mut of_orders, pair.is_some_and(|(own, order)| own.smallest <= order.most_a))
        } else if feature.friction().is_some() {
            (&mut of_frictions, friction)
        } else {
            continue;
        };
        let [_, before] = *seen;
        *seen = [true, before || (good && !*missing)];
    }
    match (of_orders, of_frictions) {
        ([true, true], _) | ([false, _], [true, true] | [false, _]) => None,
        ([true, false], _) => {
            let turned = shaft.orders().iter().any(|order| !order.unseen);
            let obstacle = if turned { Obstacle::TooNoisy } else { Obstacle::TooLittleMotion };
            Some(shaft.orders_reason.unwrap_or(Reason::Unseen(obstacle)))
        }
        ([false, _], [true, false]) => {
            Some(shaft.friction_reason.unwrap_or(Reason::TermNotExcited(FrictionTerm::Drag)))
        }
    }
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

#[cfg(test)]
mod tests;
