//! The columns of raw samples, as `--front-end` of `train` reads them.

use bearing_watch::drive::{PhaseCounts, Position};
use bearing_watch::telemetry::RawBlock;

/// Names of the phases' columns.
const PHASES: [&str; 3] = ["phase_a_counts", "phase_b_counts", "phase_c_counts"];
const QUADRATURE: &str = "iq_a";
/// Names of the position's: counts of 32 bits, or sine and cosine.
const ANGLE: [&str; 1] = ["angle_counts"];
const RESOLVER: [&str; 2] = ["sin", "cos"];

/// Names of the further channels, as they are given or by their numbers.
///
/// # Errors
/// Names of more or fewer channels than there are.
pub(super) fn further(block: &RawBlock<'_>, given: &[String]) -> Result<Vec<String>, String> {
    let count = usize::from(block.further);
    if given.is_empty() {
        return Ok((1..=count).map(|place| format!("further_{place}")).collect());
    }
    if given.len() == count {
        return Ok(given.to_vec());
    }
    Err(format!("--further names {} channels; the raw samples have {count}", given.len()))
}

/// Names of all columns.
pub(super) fn columns(block: &RawBlock<'_>, further: &[String]) -> Vec<String> {
    let position: &[&str] = if block.resolver { &RESOLVER } else { &ANGLE };
    let currents = if quadrature(block, 0).is_some() { &[QUADRATURE][..] } else { &PHASES[..phases(block)] };
    let own = currents.iter().chain(position).map(|name| (*name).to_string());
    own.chain(further.iter().cloned()).collect()
}

/// The quadrature current, if the drive sends it instead of counts.
fn quadrature(block: &RawBlock<'_>, place: usize) -> Option<f32> {
    match block.currents(place) {
        Some(PhaseCounts::Quadrature(current_a)) => Some(current_a),
        _ => None,
    }
}

/// Number of current sensors.
fn phases(block: &RawBlock<'_>) -> usize {
    block.currents(0).map_or(0, |counts| counts.as_slice().len())
}

/// The values of a sample; what is missing is NaN.
pub(super) fn values(block: &RawBlock<'_>, place: usize) -> Vec<f64> {
    let counts = block.currents(place).unwrap_or(PhaseCounts::Three([0; 3]));
    let own = counts.as_slice().iter().copied().map(f64::from).chain([f64::NAN; 3]).take(phases(block));
    let mut values: Vec<f64> = quadrature(block, place).map(f64::from).into_iter().chain(own).collect();
    match block.position(place).unwrap_or(Position::Missing) {
        Position::Absolute(angle) => values.push(angle.bits().into()),
        Position::Resolver { sin, cos } => values.extend([sin, cos].map(f64::from)),
        Position::Missing => values.extend(vec![f64::NAN; if block.resolver { 2 } else { 1 }]),
    }
    let further = (0..usize::from(block.further)).filter_map(|channel| block.further(place, channel));
    values.extend(further.map(f64::from));
    values
}
