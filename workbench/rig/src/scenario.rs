//! One experiment: what the rig is made of and how it is driven.
//!
//! A [`Scenario`] is a plain struct literal; [`simulate`](super::simulate) runs it with a seed.

use core::f64::consts::TAU;

use super::axis::Axis;
use super::field::{Drive, Duty, Field};
use super::{
    BearingGeometry, Defect, MotorParameters, NoiseSource, RigError, Stream, TABLE_2_3, Waveform, finite, not_negative,
    positive, within,
};

/// One experiment on the DC-motor rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scenario {
    /// Kind of the velocity reference.
    pub duty: Duty,
    /// Shape of the velocity reference, if the duty is [`Duty::Waveform`].
    pub reference_waveform: Waveform,
    /// Amplitude (peak) of the velocity reference.
    pub reference_amplitude_rad_s: f64,
    /// Frequency of the velocity reference.
    pub reference_frequency_hz: f64,
    /// Amplitude of the sinusoidal load torque.
    pub load_amplitude_nm: f64,
    /// Frequency of the load torque.
    pub load_frequency_hz: f64,
    /// Root mean square of the load fluctuation.
    pub load_fluctuation_nm: f64,
    /// AR(1) pole of the load fluctuation at the sampling interval.
    pub load_fluctuation_pole: f64,
    /// Kp of the velocity controller.
    pub proportional_gain_v_s_per_rad: f64,
    /// Ki of the velocity controller.
    pub integral_gain_v_per_rad: f64,
    /// Ts, the interval of control and recording.
    pub sample_time_s: f64,
    /// Number of rows of the trace.
    pub samples: usize,
    /// The motor without defect; [`Defect::motor`] returns the motor with the defect.
    pub motor: MotorParameters,
    /// Standard deviation of the current noise, outside the loop, after the filter.
    pub current_noise_a: f64,
    /// Standard deviation of the velocity noise, inside the loop.
    pub velocity_noise_rad_s: f64,
    /// Bits of a turn of the recorded angle; `None` for the exact angle. A resolver of [`Field`] has its own.
    pub angle_bits: Option<u32>,
    /// The bearing's dimensions.
    pub bearing: BearingGeometry,
    /// Defect.
    pub defect: Defect,
    /// Effects of the field.
    pub field: Field,
    /// The axis of a machine that the motor moves; `None` if the load acts on the shaft.
    pub axis: Option<Axis>,
    /// The drive and the day, if several records belong to one drive; `None` if each record is a drive of its own.
    pub drive: Option<Drive>,
}

impl Scenario {
    /// The standard rig; it was calibrated so that the fit of a healthy trace is as high as in the thesis.
    pub const STANDARD: Self = Self {
        duty: Duty::Waveform,
        reference_waveform: Waveform::Sine,
        reference_amplitude_rad_s: 40.0,
        reference_frequency_hz: 0.2,
        load_amplitude_nm: 0.15,
        load_frequency_hz: 0.5,
        load_fluctuation_nm: 0.06,
        load_fluctuation_pole: 0.2,
        proportional_gain_v_s_per_rad: 0.25,
        integral_gain_v_per_rad: 0.5,
        sample_time_s: 0.002,
        samples: 5000,
        motor: TABLE_2_3,
        current_noise_a: 0.130,
        velocity_noise_rad_s: 0.55,
        angle_bits: None,
        bearing: BearingGeometry::THESIS,
        defect: Defect::HEALTHY,
        field: Field::NONE,
        axis: None,
        drive: None,
    };

    /// The standard rig with the angle of a usual resolver, of which no detector learns more than a drive can know.
    pub const WITH_RESOLVER: Self = Self { angle_bits: Some(14), ..Self::STANDARD };

    /// This scenario with the given defect.
    #[must_use]
    pub const fn with_defect(self, defect: Defect) -> Self {
        Self { defect, ..self }
    }

    /// This scenario with random conditions: reference amplitude × 0.6–1.5 and frequency × 0.6–1.8, load
    /// amplitude × 0.6–1.4 and frequency × 0.6–1.8, R ± 10 %, J ± 3 %, each uniform and drawn from
    /// [`Stream::Conditions`] of `seed`.
    #[must_use]
    pub fn mixed(mut self, seed: u64) -> Self {
        let mut source = NoiseSource::new(seed, Stream::Conditions);
        self.reference_amplitude_rad_s *= source.uniform(0.6, 1.5);
        self.reference_frequency_hz *= source.uniform(0.6, 1.8);
        self.load_amplitude_nm *= source.uniform(0.6, 1.4);
        self.load_frequency_hz *= source.uniform(0.6, 1.8);
        self.motor.r_ohm *= source.uniform(0.9, 1.1);
        self.motor.j_kg_m2 *= source.uniform(0.97, 1.03);
        self
    }

    /// Returns an error with the name of the field if the scenario cannot be simulated.
    pub fn validate(&self) -> Result<(), RigError> {
        finite("reference_amplitude_rad_s", self.reference_amplitude_rad_s)?;
        not_negative("reference_frequency_hz", self.reference_frequency_hz)?;
        finite("load_amplitude_nm", self.load_amplitude_nm)?;
        not_negative("load_frequency_hz", self.load_frequency_hz)?;
        not_negative("load_fluctuation_nm", self.load_fluctuation_nm)?;
        let pole = finite("load_fluctuation_pole", self.load_fluctuation_pole)?;
        if pole.abs() >= 1.0 {
            return Err(RigError::UnstableFluctuation(pole));
        }
        finite("proportional_gain_v_s_per_rad", self.proportional_gain_v_s_per_rad)?;
        finite("integral_gain_v_per_rad", self.integral_gain_v_per_rad)?;
        positive("sample_time_s", self.sample_time_s)?;
        if self.samples == 0 {
            return Err(RigError::NoSamples);
        }
        not_negative("defect.severity", self.defect.severity)?;
        self.defect.motor(&self.motor).validate()?;
        not_negative("current_noise_a", self.current_noise_a)?;
        not_negative("velocity_noise_rad_s", self.velocity_noise_rad_s)?;
        if let Some(bits) = self.angle_bits {
            within("angle_bits", f64::from(bits), [1.0, 30.0])?;
        }
        self.bearing.validate()?;
        self.axis.map_or(Ok(()), |axis| axis.validate())?;
        self.field.validate(self.sample_time_s)
    }

    /// The waveform of the reference.
    pub(super) fn reference_at(&self, t_s: f64) -> f64 {
        self.reference_amplitude_rad_s * self.reference_waveform.at(self.reference_frequency_hz, t_s)
    }

    /// The sinusoidal part of the load.
    pub(super) fn load_at(&self, t_s: f64) -> f64 {
        self.load_amplitude_nm * libm::sin(TAU * self.load_frequency_hz * t_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate;

    #[test]
    fn refuses_what_cannot_be_simulated() {
        let refused = |scenario: Scenario| simulate(&scenario, 0).expect_err("invalid");
        let standard = Scenario::STANDARD;
        assert_eq!(refused(Scenario { samples: 0, ..standard }), RigError::NoSamples);
        for sample_time_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            refused(Scenario { sample_time_s, ..standard });
        }
        refused(Scenario { reference_amplitude_rad_s: f64::NAN, ..standard });
        refused(Scenario { current_noise_a: -0.1, ..standard });
        refused(Scenario { load_fluctuation_pole: 1.0, ..standard });
        let message = refused(Scenario { sample_time_s: -1.0, ..standard }).to_string();
        assert_eq!(message, "sample_time_s must be positive, got -1");
    }

    #[test]
    fn mixed_conditions_leave_noise_and_defect_alone() {
        let mixed = Scenario::STANDARD.mixed(5);
        assert_ne!(mixed, Scenario::STANDARD.mixed(6));
        assert_ne!(mixed.motor.r_ohm, TABLE_2_3.r_ohm);
        assert_eq!(mixed.current_noise_a, Scenario::STANDARD.current_noise_a);
        assert_eq!(mixed.defect, Scenario::STANDARD.defect);
    }
}
