//! Whole records behind the filter of the core's torque balance, in double precision: what looks for constants of the
//! balance over many records sees the rows that the core will see.

use std::f64::consts::TAU;

use bearing_watch::model::{RESTING, RESTING_ROWS, TorqueBalance};

use crate::grey_box::filter::LowPass;
use crate::trace::bridged;

/// Cut-off of the balance's filter, Hz, and samples a step.
pub(crate) type Rates = (f64, u8);

/// Number of columns of a velocity.
pub(crate) const COLUMNS: usize = 4;

/// The filter of the core's torque balance, over whole records.
pub(crate) struct Filtered<'a> {
    balance: &'a TorqueBalance,
    filter: LowPass,
    interval_s: f64,
    decimation: usize,
}

impl<'a> Filtered<'a> {
    pub(crate) fn new(balance: &'a TorqueBalance, (cutoff_hz, decimation): Rates) -> Self {
        let interval_s = f64::from(balance.interval_s) / f64::from(decimation);
        Self {
            balance,
            filter: LowPass::butterworth(1, cutoff_hz * interval_s),
            interval_s,
            decimation: decimation.into(),
        }
    }

    pub(crate) fn signal(&self, signal: &[f64]) -> Vec<f64> {
        self.filter.forward(signal)
    }

    /// The columns of a velocity: ω̇, ω, s(ω), s(ω)/(1 + (ω/ω_s)²).
    pub(crate) fn columns(&self, velocity: &[f64]) -> [Vec<f64>; COLUMNS] {
        let term = |each: fn(&TorqueBalance, f64) -> f64| {
            self.signal(&velocity.iter().map(|w| each(self.balance, *w)).collect::<Vec<_>>())
        };
        let slope = self.filter.derivative(velocity).into_iter().map(|x| x / self.interval_s).collect();
        [slope, term(|_, w| w), term(sign), term(stribeck)]
    }

    /// The samples of a record that are rows.
    pub(crate) fn rows(&self, length: usize) -> impl Iterator<Item = usize> + use<> {
        let samples = |steps: u16| usize::from(steps) * self.decimation;
        (samples(self.balance.settle)..length).step_by(samples(self.balance.row_interval.into()).max(1))
    }

    /// The rows between rests, as the core finds rests by its filtered velocity.
    pub(crate) fn stretches(&self, velocity: &[f64], rows: &[usize]) -> Vec<Vec<usize>> {
        let slowest = f64::from(RESTING * self.balance.usual_velocity_rad_s);
        let (mut stretches, mut resting) = (vec![vec![]], 0);
        for &row in rows {
            resting = if velocity[row].abs() < slowest { resting + 1 } else { 0 };
            if resting == RESTING_ROWS {
                stretches.push(vec![]);
            }
            if let (true, Some(stretch)) = (resting < RESTING_ROWS, stretches.last_mut()) {
                stretch.push(row);
            }
        }
        stretches.retain(|stretch| !stretch.is_empty());
        stretches
    }
}

pub(crate) fn sign(balance: &TorqueBalance, velocity: f64) -> f64 {
    (velocity / f64::from(balance.sign_velocity_rad_s)).clamp(-1.0, 1.0)
}

fn stribeck(balance: &TorqueBalance, velocity: f64) -> f64 {
    let ratio = velocity / f64::from(balance.stribeck_velocity_rad_s);
    sign(balance, velocity) / (1.0 + ratio * ratio)
}

/// Turns of the motor since the first sample of an angle, wrapped or not; missing ones are held.
pub(crate) fn turned(angle_rad: &[f64]) -> Vec<f64> {
    let held = bridged(angle_rad);
    let mut sum = 0.0;
    let mut last = held.first().copied().unwrap_or(0.0);
    held.into_iter()
        .map(|angle| {
            let step = (angle - last) / TAU;
            sum += step - step.round();
            last = angle;
            sum
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_an_angle_that_wraps() {
        let turns = turned(&[6.2, 0.1, f64::NAN, 0.3, -2.6, 3.1]);
        let expected = [0.0, 0.0292, 0.0292, 0.061, -0.4006, -0.4934];
        assert!(turns.iter().zip(expected).all(|(own, expected)| (own - expected).abs() < 2e-3), "{turns:?}");
    }
}
