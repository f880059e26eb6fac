//! What has changed between two sets of recordings.

use super::change::{RotorChange, RotorLimits, RotorLine};
use super::lines::{Line, Lines, fit_of};
use super::residual::Residual;
use super::wave::Wave;
use crate::Error;

/// Lines that are compared: those that stand out most.
const COMPARED: usize = 16;

/// Compares the lines that stand out in either set, from those of before to those of now.
///
/// # Errors
/// The errors of [`fit_of`].
pub fn since(
    (residuals_before, before): (&[Residual], &Lines),
    (residuals, now): (&[Residual], &Lines),
) -> Result<RotorChange, Error> {
    let orders = |wave: fn(&Line) -> Option<Wave>| {
        let both = before.lines.iter().chain(&now.lines);
        let mut seen: Vec<(u32, f64)> =
            both.filter_map(|line| Some((line.order, wave(line)?.significance()))).collect();
        seen.sort_by(|(_, one), (_, other)| other.total_cmp(one));
        let mut orders: Vec<u32> = vec![];
        seen.iter().for_each(|(order, _)| {
            if !orders.contains(order) {
                orders.push(*order);
            }
        });
        orders.truncate(COMPARED);
        orders.sort_unstable();
        orders
    };
    let (torques, ripples) = (orders(|line| line.torque_nm), orders(|line| line.ripple));
    let of = |residuals: &[Residual]| Ok(in_amperes(&fit_of(residuals, &torques, &ripples)?));
    Ok(RotorChange::between(&of(residuals_before)?, &of(residuals)?, &RotorLimits::USUAL))
}

/// The torques as lines in amperes.
fn in_amperes(lines: &Lines) -> Vec<RotorLine> {
    let line = |line: &Line| {
        let wave = line.torque_nm?.times(1.0 / lines.torque_constant_nm_a);
        Some(RotorLine {
            order: u16::try_from(line.order).ok()?,
            cosine_a: wave.value.x as f32,
            sine_a: wave.value.y as f32,
            deviation_a: wave.deviation() as f32,
        })
    };
    lines.lines.iter().filter_map(line).collect()
}

/// A change in words.
#[must_use]
pub fn told(change: &RotorChange) -> String {
    match change {
        RotorChange::Unchanged => "nothing has changed".into(),
        RotorChange::Unbalance { before_a, now_a } => {
            format!("the unbalance has grown: order 1 from {before_a:.4} A to {now_a:.4} A")
        }
        RotorChange::Slipped { angle_rad, deviation_rad } => format!(
            "the angle has slipped by {:.2}° ± {:.2}°: magnet or resolver has turned on the shaft",
            angle_rad.to_degrees(),
            1.96 * deviation_rad.to_degrees()
        ),
        RotorChange::Other { order } => format!("lines have changed in another way, most of all order {order}"),
    }
}
