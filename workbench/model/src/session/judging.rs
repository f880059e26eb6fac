//! Traces prepared as a model requires, and its verdicts on them.

use super::log::Log;
use crate::Error;
use crate::core::Embedded;
use crate::evaluate::{self, TraceVerdict};
use crate::trace::labels::LabelledTrace;
use crate::trace::{Preparation, Trace, same_interval};

/// Returns an error if the sampling rate of a trace differs from that of the model. The model's interval is the one
/// after the preparation on the host.
///
/// # Errors
/// It differs.
pub fn check_rate<'a>(
    model: &Embedded,
    host: Preparation,
    traces: impl Iterator<Item = &'a Trace>,
) -> Result<(), Error> {
    let fed = f64::from(model.sampling().interval_s);
    let recorded = fed / host.factor()? as f64;
    for trace in traces {
        if let Some(step) = trace.interval_s.filter(|step| fed > 0.0 && !same_interval(*step, recorded)) {
            // Single precision prints without the digits of rounding errors.
            let (step, recorded) = (step as f32, recorded as f32);
            let problem = format!("sampled every {step} s, but the model wants {recorded} s; resample or train again");
            return Err(Error::trace(&trace.id, problem));
        }
    }
    Ok(())
}

/// Prepares every trace.
///
/// # Errors
/// A trace that is too short.
pub fn prepare(traces: &[LabelledTrace], preparation: Preparation) -> Result<Vec<LabelledTrace>, Error> {
    let each = |t: &LabelledTrace| Ok(LabelledTrace { trace: preparation.apply(&t.trace)?, class: t.class });
    traces.iter().map(each).collect()
}

/// Prepares traces and runs them through a model, if their rate is its rate.
///
/// # Errors
/// Another rate, or a trace that is too short.
pub fn judge(
    model: &Embedded,
    traces: &[LabelledTrace],
    host: Preparation,
    log: &Log<'_>,
) -> Result<Vec<TraceVerdict>, Error> {
    check_rate(model, host, traces.iter().map(|t| &t.trace))?;
    let steps = log.steps("evaluating", traces.len());
    evaluate::run(model, &prepare(traces, host)?, || steps(1))
}
