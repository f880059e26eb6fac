//! What the main loop calls: a closed segment → its report.

use core::sync::atomic::Ordering;

use bearing_watch::{Report, Solver};

use crate::code::{BwCode, Outcome, code};
use crate::memory::at;
use crate::plan::Own;
use crate::state::{BwState, Solving, Work};

/// Does a bounded piece of the solve of the closed segment; call it again and again in the main loop. The first piece
/// takes the segment, so that the interrupt can close the next one. The alarm takes account of the report, unless
/// `bw_discard` has withdrawn it.
///
/// Returns `BW_CODE_OK` if there is more to do, `BW_CODE_REPORT` with the last piece, or `BW_CODE_IDLE` if there is no
/// closed segment.
///
/// # Safety
/// `state` is NULL, or was given by `bw_init` or has as many readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_advance(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| state.settled(|solving| advance(state, solving)).flatten()))
}

/// Solves the closed segment as a whole, or what `bw_advance` has left of it, with the same bits.
///
/// Returns `BW_CODE_REPORT`, or `BW_CODE_IDLE` if there is no closed segment.
///
/// # Safety
/// As `bw_advance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_conclude(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| state.settled(|solving| all(state, solving)).flatten()))
}

/// Takes the closed segment, if none is being solved.
fn take(state: &'static BwState, solving: &mut Solving) {
    if !matches!(solving.work, Work::Solving(_)) {
        // SAFETY: the caller holds the solving half of the state.
        unsafe {
            state.closed.empty(|segment| {
                solving.number = state.closed_number.load(Ordering::Relaxed);
                solving.work = Work::Solving(Solver::new(&state.model, segment));
            });
        }
    }
}

fn advance(state: &'static BwState, solving: &mut Solving) -> Outcome {
    take(state, solving);
    let Work::Solving(solver) = &mut solving.work else { return Ok(BwCode::Idle) };
    // Nothing is left to be solved then: the rest only moves the report.
    if solver.advance().is_some() { finish(state, solving) } else { Ok(BwCode::Ok) }
}

fn all(state: &'static BwState, solving: &mut Solving) -> Outcome {
    take(state, solving);
    finish(state, solving)
}

fn finish(state: &BwState, solving: &mut Solving) -> Outcome {
    match core::mem::replace(&mut solving.work, Work::Empty) {
        Work::Solving(solver) => conclude(state, solving, solver.finish()),
        other => {
            solving.work = other;
            return Ok(BwCode::Idle);
        }
    }
    Ok(BwCode::Report)
}

/// Keeps a report, after the evidence has taken its outcome. One that is in doubt already is withdrawn at once.
pub(crate) fn conclude(state: &BwState, solving: &mut Solving, report: Report<Own>) {
    solving.before.clone_from(&solving.evidence);
    solving.evidence.observe_outcome(report.outcome());
    solving.work = Work::Concluded(report);
    solving.withdraw(&state.doubted);
}

/// Makes the estimate of the report the auxiliary model of instrumental variables, or of least squares with less weight
/// for outliers (`train --huber`); other models need no call. It must come before `handover` samples (`bw_info`) of the
/// next segment have been taken, with the interrupt masked. A model whose `handover` is 0 adopts by `bw_step` only.
///
/// Returns `BW_CODE_OK`, `BW_CODE_NOT_ADOPTED`, or `BW_CODE_NO_REPORT`.
///
/// # Safety
/// As `bw_advance`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_adopt(state: *mut BwState) -> BwCode {
    // SAFETY: the same contract.
    code(unsafe { at(state) }.and_then(|state| state.settled(|solving| adopt(state, solving)).flatten()))
}

fn adopt(state: &BwState, solving: &Solving) -> Outcome {
    let Work::Concluded(report) = &solving.work else { return Err(BwCode::NoReport) };
    let adopted = state.sampling.with(|detector| detector.adopt(report))?;
    Ok(if adopted { BwCode::Ok } else { BwCode::NotAdopted })
}
