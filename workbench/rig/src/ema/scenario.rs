//! One experiment on the actuator.
//!
//! An [`EmaScenario`] is a plain struct literal; [`simulate`](super::simulate) runs it with a seed.

use super::super::axis::cycle::{Path, REACH_S, Scale, velocities};
use super::super::axis::{Axis, Motion};
use super::super::within;
use super::super::{BearingGeometry, NoiseSource, RigError, Stream, Waveform, finite, not_negative};
use super::{Actuator, DriveSettings, EmaDefect, EmaLoad, SensorErrors};

/// Largest distance of the position command from mid-stroke; the stroke of thesis Table 5.1 is ± 76.2 mm.
pub const STROKE_M: f64 = 0.07;
/// Largest frequency of the position command: a sine of the full stroke then reaches 4156 rpm.
pub const FREQUENCY_HZ: f64 = 0.6;

/// What a recording contains of the samples of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Logging {
    /// A row is recorded every so many control intervals.
    pub every: u32,
    /// Every value but the time is held for so many rows, as in the recordings of the Moog rig.
    pub hold: u32,
}

/// One experiment on the EMA rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmaScenario {
    /// Shape of the position command.
    pub command: Waveform,
    /// Amplitude (peak) of the position command.
    pub amplitude_m: f64,
    /// Frequency of the position command.
    pub frequency_hz: f64,
    /// Mean of the position command, and position at the start.
    pub offset_m: f64,
    /// Load.
    pub load: EmaLoad,
    /// Root mean square of the fluctuation of the external force.
    pub load_fluctuation_n: f64,
    /// Temperature of winding and magnet, 0 for cold and 1 for hot: R + 40 %, λ − 5 %. The controller does not know it.
    pub temperature: f64,
    /// The actuator without defect, cold.
    pub actuator: Actuator,
    /// Gains and limits of the drive.
    pub drive: DriveSettings,
    /// Errors of the sensors.
    pub sensors: SensorErrors,
    /// Dimensions of the bearing.
    pub bearing: BearingGeometry,
    /// Defects.
    pub defect: EmaDefect,
    /// The axis of a machine that the nut moves; `None` if it moves the load alone.
    pub axis: Option<Axis>,
    /// Cycles of a machine instead of the waveform of the command; the amplitude is their reach.
    pub cycle: Option<Motion>,
    /// Recorded rows.
    pub logging: Logging,
    /// Number of rows of the trace.
    pub rows: usize,
}

impl EmaScenario {
    /// A sine of 40 mm at 0.4 Hz against a load sine of 4 kN at 0.8 Hz, recorded at 1200 Hz for 10 s. The thesis
    /// publishes neither amplitude nor frequency of a command: with these, all draws of [`EmaScenario::mixed`] stay
    /// within stroke, frequency and voltage of the actuator.
    pub const STANDARD: Self = Self {
        command: Waveform::Sine,
        amplitude_m: 0.04,
        frequency_hz: 0.4,
        offset_m: 0.0,
        load: EmaLoad::Sine { amplitude_n: 4e3, frequency_hz: 0.8 },
        load_fluctuation_n: 60.0,
        temperature: 0.0,
        actuator: Actuator::MAXFORCE,
        drive: DriveSettings::MAXFORCE,
        sensors: SensorErrors::STANDARD,
        bearing: BearingGeometry::THESIS,
        defect: EmaDefect::HEALTHY,
        axis: None,
        cycle: None,
        logging: Logging { every: 10, hold: 1 },
        rows: 12_000,
    };

    /// The rig of Moog: 1200 Hz, every value held for three rows.
    pub const MOOG: Self = Self { logging: Logging { every: 10, hold: 3 }, ..Self::STANDARD };

    /// The rig of RIT: two springs, recorded at 10 kHz for 5 s, which is also the control rate: 12 kHz is not a
    /// multiple of it. The stroke is such that the springs stay below the rated force in all draws of
    /// [`EmaScenario::mixed`].
    pub const RIT: Self = Self {
        amplitude_m: 0.025,
        load: EmaLoad::Springs { stiffness_n_per_m: 2.4e5 },
        load_fluctuation_n: 0.0,
        drive: DriveSettings { interval_s: 1e-4, ..DriveSettings::MAXFORCE },
        logging: Logging { every: 1, hold: 1 },
        rows: 50_000,
        ..Self::STANDARD
    };

    /// This scenario with the given defect.
    #[must_use]
    pub const fn with_defect(self, defect: EmaDefect) -> Self {
        Self { defect, ..self }
    }

    /// This scenario with random conditions: amplitude × 0.5–1.5, frequency × 0.6–1.2, load × 0.5–1.5, temperature
    /// 0–1, start position ± 5 mm, each uniform and drawn from [`Stream::Conditions`] of `seed`.
    #[must_use]
    pub fn mixed(self, seed: u64) -> Self {
        let mut source = NoiseSource::new(seed, Stream::Conditions);
        Self {
            amplitude_m: self.amplitude_m * source.uniform(0.5, 1.5),
            frequency_hz: self.frequency_hz * source.uniform(0.6, 1.2),
            load: self.load.times(source.uniform(0.5, 1.5)),
            temperature: source.uniform(0.0, 1.0),
            offset_m: self.offset_m + source.uniform(-0.005, 0.005),
            ..self
        }
    }

    /// This scenario with another logging for the same time; at least one row.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a positive number of rows, at most that of control intervals of a record"
    )]
    pub fn logged(self, logging: Logging) -> Self {
        let rows = self.rows as f64 * f64::from(self.logging.every) / f64::from(logging.every);
        Self { logging, rows: rows.round().max(1.0) as usize, ..self }
    }

    /// The interval between rows.
    #[must_use]
    pub fn row_interval_s(&self) -> f64 {
        f64::from(self.logging.every) * self.drive.interval_s
    }

    /// Returns an error with the name of the field if the scenario cannot be simulated.
    pub fn validate(&self) -> Result<(), RigError> {
        finite("amplitude_m", self.amplitude_m)?;
        finite("offset_m", self.offset_m)?;
        within("amplitude_m with offset_m", self.amplitude_m.abs() + self.offset_m.abs(), [0.0, STROKE_M])?;
        within("frequency_hz", self.frequency_hz, [0.0, FREQUENCY_HZ])?;
        self.load.validate()?;
        not_negative("load_fluctuation_n", self.load_fluctuation_n)?;
        within("temperature", self.temperature, [0.0, 1.0])?;
        self.actuator.validate()?;
        self.drive.validate()?;
        self.sensors.validate()?;
        self.bearing.validate()?;
        self.defect.validate()?;
        self.axis.map_or(Ok(()), |axis| axis.validate())?;
        self.defect.actuator(&self.actuator.at_temperature(self.temperature)).validate()?;
        within("logging.every", f64::from(self.logging.every), [1.0, 1e6])?;
        within("logging.hold", f64::from(self.logging.hold), [1.0, 1e6])?;
        if self.rows == 0 {
            return Err(RigError::NoSamples);
        }
        Ok(())
    }

    /// Points of time and velocity of the cycles, if the command is cycles.
    pub(super) fn cycles(&self, seed: u64) -> Option<Vec<[f64; 2]>> {
        let scale = Scale { peak: self.amplitude_m / REACH_S, reach: self.amplitude_m };
        let end_s = self.rows as f64 * self.row_interval_s();
        self.cycle.map(|motion| velocities(motion, scale, end_s, seed))
    }

    /// The position command; `path` is that of the cycles.
    pub(super) fn position_ref_m(&self, path: Option<&Path>, t_s: f64) -> f64 {
        let moved_m = path.map(|path| path.at(t_s));
        self.offset_m + moved_m.unwrap_or_else(|| self.amplitude_m * self.command.at(self.frequency_hz, t_s))
    }

    /// Name of the shape of the command.
    #[must_use]
    pub const fn shape(&self) -> &'static str {
        match self.cycle {
            Some(motion) => motion.name(),
            None => self.command.name(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_outside_the_actuator_is_refused_by_name() {
        let refused = |scenario: EmaScenario| scenario.validate().expect_err("invalid").to_string();
        let standard = EmaScenario::STANDARD;
        assert!(standard.validate().is_ok());
        let message = refused(EmaScenario { amplitude_m: 0.06, offset_m: -0.02, ..standard });
        assert!(message.starts_with("amplitude_m with offset_m must lie between 0 and 0.07"), "{message}");
        assert!(refused(EmaScenario { frequency_hz: 0.61, ..standard }).contains("frequency_hz"));
        assert!(refused(EmaScenario { temperature: 1.1, ..standard }).contains("temperature"));
        assert!(refused(EmaScenario { load_fluctuation_n: f64::NAN, ..standard }).contains("load_fluctuation_n"));
        assert!(refused(EmaScenario { logging: Logging { every: 0, hold: 1 }, ..standard }).contains("logging.every"));
        assert_eq!(EmaScenario { rows: 0, ..standard }.validate(), Err(RigError::NoSamples));
        let demagnetised = EmaDefect { weak_magnet: 20.0, ..EmaDefect::HEALTHY };
        assert!(refused(standard.with_defect(demagnetised)).contains("actuator.flux_wb"));
    }

    #[test]
    fn every_draw_stays_within_stroke_frequency_and_rated_force() {
        for base in [EmaScenario::STANDARD, EmaScenario::MOOG, EmaScenario::RIT] {
            for seed in 0..2000 {
                let mixed = base.mixed(seed);
                assert!(mixed.validate().is_ok());
                let reach_m = mixed.amplitude_m + mixed.offset_m.abs();
                // 3700 lbf.
                assert!(mixed.load.springs_n_per_m() * reach_m < 16_458.0);
                assert_eq!((mixed.sensors, mixed.defect, mixed.drive), (base.sensors, base.defect, base.drive));
            }
            assert_ne!(base.mixed(1), base.mixed(2));
        }
    }
}
