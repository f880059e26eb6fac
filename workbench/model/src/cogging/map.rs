//! The current that a drive adds at each angle against cogging and unbalance.
//!
//! ```text
//! i(θ) = Σ (a_k cos kθ + b_k sin kθ)/Kt                                                        (1)
//! ```
//!
//! The ripple of the torque constant is not in it, since it is in proportion to the current.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use nalgebra::Vector2;

use super::lines::Lines;

/// Entries of the map of an ODrive.
const ODRIVE: usize = 3600;

/// One point of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPoint {
    /// Angle of the shaft.
    pub angle_rad: f64,
    /// (1).
    pub current_a: f64,
    /// Its standard deviation.
    pub deviation_a: f64,
}

/// The map at so many angles of a turn, from zero.
#[must_use]
pub fn map(lines: &Lines, points: usize) -> Vec<MapPoint> {
    let at = |point: usize| {
        let angle_rad = TAU * point as f64 / points as f64;
        let terms = lines.lines.iter().filter_map(|line| Some((f64::from(line.order) * angle_rad, line.torque_nm?)));
        let (mut torque, mut variance) = (0.0, 0.0);
        for (phase, wave) in terms {
            let unit = Vector2::new(phase.cos(), phase.sin());
            torque += wave.value.dot(&unit);
            // Orders are nearly orthogonal, so their errors are added as independent ones.
            variance += unit.dot(&(wave.covariance * unit));
        }
        let kt = lines.torque_constant_nm_a;
        MapPoint { angle_rad, current_a: torque / kt, deviation_a: variance.sqrt() / kt }
    };
    (0..points).map(at).collect()
}

/// The map as the firmware of the ODrive v3 keeps it, `controller.config.anticogging.cogging_map`: torque in N·m, which
/// is added at k/3600 turns of the encoder.
#[must_use]
pub fn odrive(lines: &Lines) -> String {
    let mut text = format!(
        "// Torque, N·m, that is added at k/{ODRIVE} turns of the encoder: controller.config.anticogging.cogging_map\n\
         float cogging_map[{ODRIVE}] = {{\n"
    );
    for point in map(lines, ODRIVE) {
        let _ = writeln!(text, "    {:.6e}f,", point.current_a * lines.torque_constant_nm_a);
    }
    text + "};\n"
}
