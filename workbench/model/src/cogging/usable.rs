//! Whether recordings show what turns with the rotor.

use std::f64::consts::TAU;

use nalgebra::Vector2;

use super::residual::Residual;
use super::wave::Wave;
use crate::Error;

/// Fewest turns.
const TURNS: f64 = 10.0;
/// Least part of the turns in each direction.
const DIRECTION: f64 = 0.1;
/// Least length of the mean of the waves of all recordings, relative to their mean length: waves of equal phase have 1,
/// two of any phase 0.64 on average, more of them less.
const IN_PHASE: f64 = 0.7;
/// χ² with two degrees of freedom from which a line of one recording has a phase: one in a hundred by noise.
const SEEN: f64 = 9.21;

/// Returns the turns forward and backward.
///
/// # Errors
/// Too few, or of one direction.
pub(super) fn turns(residuals: &[Residual]) -> Result<[f64; 2], Error> {
    let steps = || residuals.iter().flat_map(|residual| residual.angle_rad.windows(2).map(|pair| pair[1] - pair[0]));
    let [forward, backward] = [1.0, -1.0].map(|sign| steps().map(|step| (sign * step).max(0.0)).sum::<f64>() / TAU);
    let all = forward + backward;
    if all.is_nan() || all < TURNS {
        let problem = format!("the shaft makes {all:.1} turns in all recordings; record at least {TURNS:.0} turns");
        return Err(Error::Usage(problem));
    }
    if forward.min(backward) < DIRECTION * all {
        let problem = format!(
            "the shaft makes {forward:.1} turns forward and {backward:.1} backward; record at least a tenth of the turns \
             in each direction, since otherwise a delay of the current looks like a turned line"
        );
        return Err(Error::Usage(problem));
    }
    Ok([forward, backward])
}

/// Refuses an angle with another zero in each recording. `waves` has the line of an order in each recording.
///
/// # Errors
/// A line that most recordings show has another phase in each.
pub(super) fn absolute(order: u32, waves: &[(&str, Wave)]) -> Result<(), Error> {
    let seen: Vec<&(&str, Wave)> = waves.iter().filter(|(_, wave)| wave.significance() > SEEN).collect();
    if seen.len() < 2 || 2 * seen.len() < waves.len() {
        return Ok(());
    }
    let sum = seen.iter().fold(Vector2::zeros(), |sum, (_, wave)| sum + wave.value);
    let lengths: f64 = seen.iter().map(|(_, wave)| wave.amplitude()).sum();
    if sum.norm() >= IN_PHASE * lengths {
        return Ok(());
    }
    let phases = seen.iter().take(3).map(|(id, wave)| format!("{:.0}° in {id}", wave.phase_rad().to_degrees()));
    Err(Error::Usage(format!(
        "the angle is not absolute, or the drives differ: the line of order {order} has the phase {}; give \
         recordings of one drive, with the angle of its resolver or of an encoder with index, not one that starts at \
         zero",
        phases.collect::<Vec<_>>().join(", ")
    )))
}

/// The lines of an order cannot be told apart.
pub(super) fn undetermined() -> Error {
    Error::Usage("the recordings do not determine the lines; record more turns".into())
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix2;

    use super::*;

    #[test]
    fn phases_that_differ_are_not_of_one_angle() {
        let wave = |degrees: f64| Wave {
            value: Vector2::new(degrees.to_radians().cos(), degrees.to_radians().sin()),
            covariance: Matrix2::identity() * 0.01,
        };
        assert!(absolute(6, &[("a", wave(10.0)), ("b", wave(25.0)), ("c", wave(-20.0))]).is_ok());
        let refused = absolute(6, &[("a", wave(10.0)), ("b", wave(130.0)), ("c", wave(250.0))]);
        let problem = refused.expect_err("three thirds of a period").to_string();
        assert!(problem.contains("not absolute") && problem.contains("130° in b"), "{problem}");
        // A wave within the noise has no phase.
        let noise = Wave { covariance: Matrix2::identity(), ..wave(190.0) };
        assert!(absolute(6, &[("a", wave(10.0)), ("b", noise)]).is_ok());
    }
}
