//! The front end of the simulated actuator, as the file that describes it to the reader of its traces.

use super::EmaScenario;

/// Samples are to come at least this often, 1/s.
const LEAST_RATE_HZ: f64 = 999.0;

impl EmaScenario {
    /// The description (TOML) of the front end for traces of this scenario, with a decimation by one of these factors:
    /// to the lowest rate of at least 1 kHz. `None` if a row does not contain values of its own, or if there are fewer
    /// rows than that.
    #[must_use]
    pub fn front_end_toml(&self, factors: &[usize]) -> Option<String> {
        let rate_hz = 1.0 / self.row_interval_s();
        let reaches = |factor: &usize| rate_hz / *factor as f64 >= LEAST_RATE_HZ;
        let factor = factors.iter().copied().filter(reaches).max().filter(|_| self.logging.hold == 1)?;
        let sensors = &self.sensors;
        // Noise and offsets of three sensors, twice: draws of the offsets differ.
        let noise_a = 3_f64.sqrt() * (sensors.current_noise_a + 2.0 * sensors.current_offset_a);
        let noise_a = (100.0 * noise_a).ceil() / 100.0;
        // Below a tenth of the rate, the limit of the loop.
        let bandwidth_hz = (0.09 * rate_hz).min(300.0);
        // The converter: 12 bits over 1.3 times the limit of the drive.
        Some(format!(
            "control_rate_hz = {rate_hz:?}
factor = {factor}

[currents]
columns = [\"phase_a_a\", \"phase_b_a\", \"phase_c_a\"]
quantity = \"amperes\"
offset_counts = [2048.0, 2048.0, 2048.0]
gain_a = [0.025, 0.025, 0.025]
usable_counts = [16, 4079]
stuck_samples = 0

[balance]
noise_a = {noise_a:?}
gain_tolerance = 0.02
window = 400

[position]
counts = \"resolver_counts\"
bits = {bits}

[tracking]
bandwidth_hz = {bandwidth_hz:?}
damping = 0.7
error_limit_rad = 0.1
lost_samples = 20
settle_samples = 20

[motor]
pole_pairs = {pole_pairs}
electrical_offset_rad = 0.0
park = \"standard\"
",
            bits = sensors.resolver_bits,
            pole_pairs = self.actuator.pole_pairs,
        ))
    }
}
