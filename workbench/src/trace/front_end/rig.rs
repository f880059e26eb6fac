//! The front end of the simulated actuator.

use super::{Balance, Columns, Convention, Currents, FACTORS, FrontEndFile, Motor, Quantity, Tracking};
use crate::rig::ema::EmaScenario;

/// Samples are to come at least this often, 1/s.
const LEAST_RATE_HZ: f64 = 999.0;

impl FrontEndFile {
    /// The front end for traces of a scenario: to the lowest rate of at least 1 kHz. `None` if a row does not contain
    /// values of its own, or if there are fewer rows than that.
    #[must_use]
    pub fn of_rig(scenario: &EmaScenario) -> Option<Self> {
        let rate_hz = 1.0 / scenario.row_interval_s();
        let reaches = |factor: &usize| rate_hz / *factor as f64 >= LEAST_RATE_HZ;
        let factor = FACTORS.into_iter().filter(reaches).max().filter(|_| scenario.logging.hold == 1)?;
        let sensors = &scenario.sensors;
        // Noise and offsets of three sensors, twice: draws of the offsets differ.
        let noise_a = 3_f64.sqrt() * (sensors.current_noise_a + 2.0 * sensors.current_offset_a);
        Some(Self {
            control_rate_hz: rate_hz as f32,
            factor,
            currents: Currents {
                columns: ["phase_a_a", "phase_b_a", "phase_c_a"].map(String::from).to_vec(),
                quantity: Quantity::Amperes,
                // 12 bits over 1.3 times the limit of the drive.
                offset_counts: vec![2048.0; 3],
                gain_a: vec![0.025; 3],
                usable_counts: [16, 4079],
                stuck_samples: 0,
            },
            balance: Balance { noise_a: (100.0 * noise_a).ceil() as f32 / 100.0, gain_tolerance: 0.02, window: 400 },
            position: Columns::Counts { counts: "resolver_counts".into(), bits: sensors.resolver_bits },
            tracking: Tracking {
                // Below a tenth of the rate, the limit of the loop.
                bandwidth_hz: (0.09 * rate_hz).min(300.0) as f32,
                damping: 0.7,
                error_limit_rad: 0.1,
                lost_samples: 20,
                settle_samples: 20,
            },
            motor: Motor {
                pole_pairs: scenario.actuator.pole_pairs,
                electrical_offset_rad: 0.0,
                park: Convention::Standard,
            },
        })
    }

    /// The text of a file that [`FrontEndFile::read`] reads.
    ///
    /// # Errors
    /// None for values that were read or made here; those of the serialiser otherwise.
    pub fn to_text(&self) -> Result<String, toml::ser::Error> {
        Ok(format!("# The front end of these traces, for --front-end.\n{}", toml::to_string(self)?))
    }
}
