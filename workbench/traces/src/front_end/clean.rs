//! Recorded rows through the core's front end.

use bearing_watch::drive::{Alignment, By, CleanSample, Factor, FrontEnd, PhaseCounts, Position, RawSample};

use model::trace::front_end::{FrontEndFile, Quantity, Refused, words};

/// Names of the columns that the front end makes.
pub(crate) const OWN: [&str; 3] = ["current_a", "velocity_rad_s", "angle_rad"];

/// Largest number of further columns.
pub const FURTHER: usize = 8;

/// Columns at the rate of identification.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Clean {
    /// Those of [`OWN`], then the further ones.
    pub(crate) columns: Vec<Vec<f64>>,
    /// What was refused, if samples within the record are missing.
    pub(crate) refused: Option<Refused>,
    /// Samples before which a fault was found late.
    pub(crate) found_late: Vec<usize>,
    /// What is known of the wiring from a sample on.
    pub(crate) wiring: Vec<(usize, Alignment)>,
}

/// Takes the columns that the file names and at most [`FURTHER`] further ones. `times_s` tells missed rows; without
/// times there are none. The front end leaves out samples before the first complete one.
pub(crate) fn clean(
    file: &FrontEndFile,
    recorded: &[&[f64]],
    further: &[&[f64]],
    times_s: Option<&[f64]>,
) -> Result<Clean, String> {
    match file.factor {
        1 => by::<1>(file, recorded, further, times_s),
        2 => by::<2>(file, recorded, further, times_s),
        4 => by::<4>(file, recorded, further, times_s),
        8 => by::<8>(file, recorded, further, times_s),
        16 => by::<16>(file, recorded, further, times_s),
        32 => by::<32>(file, recorded, further, times_s),
        6 => by::<6>(file, recorded, further, times_s),
        12 => by::<12>(file, recorded, further, times_s),
        24 => by::<24>(file, recorded, further, times_s),
        48 => by::<48>(file, recorded, further, times_s),
        10 => by::<10>(file, recorded, further, times_s),
        20 => by::<20>(file, recorded, further, times_s),
        40 => by::<40>(file, recorded, further, times_s),
        factor => Err(format!("no filters for the factor {factor}")),
    }
}

fn by<const FACTOR: usize>(
    file: &FrontEndFile,
    recorded: &[&[f64]],
    further: &[&[f64]],
    times_s: Option<&[f64]>,
) -> Result<Clean, String>
where
    By<FACTOR>: Factor,
{
    if further.len() > FURTHER {
        return Err(format!("{} columns besides current, velocity and angle; at most {FURTHER}", further.len()));
    }
    let rows = recorded.first().map_or(0, |column| column.len());
    let mut front_end =
        FrontEnd::<FURTHER, FACTOR>::new(&file.constants()).map_err(|error| error.message().to_string())?;
    let mut columns = vec![vec![]; OWN.len() + further.len()];
    let (mut late, mut wiring) = (Vec::new(), Vec::<(usize, Alignment)>::new());
    for row in (0..rows).filter(|row| is_sampled(file, recorded, times_s, *row)) {
        let raw = raw_sample(file, recorded, further, times_s, row);
        let Some(clean) = front_end.push(&raw) else { continue };
        let CleanSample { current_a, velocity_rad_s, angle, further, found_late, alignment } = clean;
        if wiring.last().is_none_or(|(_, known)| *known != alignment) {
            wiring.push((columns[0].len(), alignment));
        }
        if found_late {
            late.push(columns[0].len());
        }
        let values = [current_a, velocity_rad_s, angle.radians()].into_iter().chain(further);
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(f64::from(value)));
    }
    let missing = columns[0].iter().zip(&columns[1]).filter(|(current, velocity)| (*current + *velocity).is_nan());
    let (missing, samples) = (missing.count(), columns[0].len());
    let faults = front_end.faults();
    if missing == samples {
        return Err(format!("no sample passes the front end: {}", words(&faults)));
    }
    let refused = (missing > 0).then_some(Refused { missing, samples, faults });
    Ok(Clean { columns, refused, found_late: late, wiring })
}

/// Whether a row has what each instant of the control loop has: counts of the currents, and its time. Others are
/// instants that the drive missed, which the numbers of the rows tell.
pub(super) fn is_sampled(file: &FrontEndFile, recorded: &[&[f64]], times_s: Option<&[f64]>, row: usize) -> bool {
    let currents = recorded.iter().take(file.currents.columns.len());
    currents.chain(&times_s).all(|column| column[row].is_finite())
}

/// A recorded row as the drive reads it.
#[expect(clippy::cast_possible_truncation, reason = "signals are single")]
pub(crate) fn raw_sample(
    file: &FrontEndFile,
    recorded: &[&[f64]],
    further: &[&[f64]],
    times_s: Option<&[f64]>,
    row: usize,
) -> RawSample<FURTHER> {
    RawSample {
        number: number(file, times_s, row),
        currents: currents(file, recorded, row),
        position: position(file, recorded, row),
        further: std::array::from_fn(|k| further.get(k).map_or(0.0, |column| column[row] as f32)),
    }
}

/// The number of a row in the control rate.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "numbers wrap around")]
fn number(file: &FrontEndFile, times_s: Option<&[f64]>, row: usize) -> u32 {
    let at = times_s.map_or(row as f64, |times| {
        let first = times.iter().find(|time| time.is_finite()).unwrap_or(&0.0);
        (times[row] - first) * f64::from(file.control_rate_hz)
    });
    at.round() as i64 as u32
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates, as a converter does")]
fn currents(file: &FrontEndFile, recorded: &[&[f64]], row: usize) -> PhaseCounts {
    let constants = &file.currents;
    if constants.quantity == Quantity::Quadrature {
        return PhaseCounts::Quadrature(recorded[0][row] as f32);
    }
    let counts = |phase: usize| {
        let value = recorded[phase][row];
        let counts = match constants.quantity {
            Quantity::Counts | Quantity::Quadrature => value,
            Quantity::Amperes => f64::from(constants.offset_counts[phase]) + value / f64::from(constants.gain_a[phase]),
        };
        counts.round() as u16
    };
    match constants.columns.len() {
        3 => PhaseCounts::Three([0, 1, 2].map(counts)),
        _ => PhaseCounts::Two([0, 1].map(counts)),
    }
}

fn position(file: &FrontEndFile, recorded: &[&[f64]], row: usize) -> Position {
    let first = file.currents.columns.len();
    let value = |column: usize| recorded.get(column).map_or(f64::NAN, |values| values[row]);
    file.position.reading([value(first), value(first + 1)])
}
