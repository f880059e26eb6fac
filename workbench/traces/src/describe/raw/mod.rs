//! The front end of a recording at the control rate, as the text of its file: what the counts themselves tell.
//!
//! ```text
//! columns ─► signals: phases, position ─► phases: offsets, converter ────────┐
//!                                      └► position: counts a turn ───────────┴─► motor: pole pairs, offset ─► noise
//! ```
//!
//! What no recording tells, such as the amperes of a count, is written with the word *set* behind it, and said.

mod motor;
mod noise;
mod phases;
mod position;
mod signals;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use model::settings::literal;
use model::trace::front_end::{FACTORS, FrontEndFile};

use crate::front_end::clean;
use motor::Motor;
pub(super) use phases::Extremes;
use phases::Phases;
use position::Position;
use signals::Signals;

/// Least rate of identification, Hz: third harmonics of bearing orders stay below it in most drives.
const LEAST_RATE_HZ: f64 = 900.0;

/// A front end that was found.
#[derive(Debug)]
pub(super) struct RawFrontEnd {
    /// The text of the file.
    pub(super) text: String,
    /// The same as read.
    pub(super) file: FrontEndFile,
    /// What must be said with it.
    pub(super) said: Vec<String>,
}

/// The names of the phases.
///
/// # Errors
/// There are none, or no position.
pub(super) fn phase_names(names: &[String], columns: &[Vec<f64>]) -> Result<Vec<String>, String> {
    Ok(Signals::of(names, columns)?.phases.into_iter().map(|place| names[place].clone()).collect())
}

/// Looks at a recording, with its names, columns and rows a second, and at the extremes of all.
///
/// # Errors
/// What the recording lacks.
pub(super) fn front_end(
    (names, columns): (&[String], &[Vec<f64>]),
    rate_hz: Option<f64>,
    others: Extremes,
) -> Result<RawFrontEnd, String> {
    let rate_hz = rate_hz.ok_or("a front end needs the control rate: the file has no time; give --rate-hz")?;
    let Signals { phases: mut phase_places, position: position_places, first } = Signals::of(names, columns)?;
    let column = |place: &usize| columns[*place].as_slice();
    let position = Position::of(&position_places.iter().map(column).collect::<Vec<_>>())?;
    let of_phases = |places: &[usize]| Phases::of(&places.iter().map(column).collect::<Vec<_>>(), rate_hz, others);
    let mut phases = of_phases(&phase_places);
    let mut motor = Motor::of(&phases.amperes, &position.angles_rad, rate_hz)?;
    let mut said = Vec::new();
    if motor.reversed && !position.can_be_reversed() {
        let last = phase_places.len() - 1;
        phase_places.swap(last - 1, last);
        phases = of_phases(&phase_places);
        motor = Motor::of(&phases.amperes, &position.angles_rad, rate_hz)?;
        said.push("the resolver turns against the order of the phases: two of their columns are exchanged".into());
    }
    // The mean of a current that stops at one angle is not its offset.
    phases.shift(&motor.offsets(&phases.amperes, &position.angles_rad));
    motor = Motor::of(&phases.amperes, &position.angles_rad, rate_hz)?;
    said.extend([phases.said(), motor.said()].concat());
    let factor = FACTORS.iter().copied().filter(|factor| rate_hz / *factor as f64 >= LEAST_RATE_HZ).max().unwrap_or(1);
    let name = |place: &usize| literal(&names[*place]);
    let quoted = |places: &[usize]| places.iter().map(name).collect::<Vec<_>>();
    let mut text = String::from("# The front end of a drive, found in a recording by `bearing-watch init`.\n");
    let mut line = |what: &str| _ = writeln!(text, "{what}");
    line(&format!("control_rate_hz = {rate_hz:.3}"));
    line(&format!("factor = {factor}  # to {:.0} Hz", rate_hz / factor as f64));
    line("\n[currents]");
    let noise = noise::of_sum(&phases.amperes, &motor.electrical(&position.angles_rad));
    phases.lines(&quoted(&phase_places), first, noise).iter().for_each(|own| line(own));
    line("\n[position]");
    position.lines(&quoted(&position_places), motor.reversed).iter().for_each(|own| line(own));
    line("\n[tracking]");
    // Below a tenth of the rate, the limit of the loop.
    line(&format!("bandwidth_hz = {:?}", (0.09 * rate_hz).min(300.0).floor()));
    line("damping = 0.7\nerror_limit_rad = 0.1\nlost_samples = 20\nsettle_samples = 20");
    line("\n[motor]");
    motor.lines(first).iter().for_each(|own| line(own));
    let file = FrontEndFile::parse(&text).map_err(|(place, problem)| format!("{place}: {problem}"))?;
    let recorded: Vec<&[f64]> = phase_places.iter().chain(&position_places).map(column).collect();
    let passed = clean(&file, &recorded, &[], None)?;
    said.extend(passed.refused.map(|refused| refused.to_string()));
    Ok(RawFrontEnd { text, file, said })
}
