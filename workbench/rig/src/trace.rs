//! The recorded trace.

use super::axis::AxisColumns;

/// One recording: columns of the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RigTrace {
    /// Time of the sample.
    pub t_s: Vec<f64>,
    /// Velocity reference.
    pub velocity_ref_rad_s: Vec<f64>,
    /// Measured velocity.
    pub velocity_rad_s: Vec<f64>,
    /// Measured current.
    pub current_a: Vec<f64>,
    /// Measured load torque; the true load if there is no load sensor.
    pub load_torque_nm: Vec<f64>,
    /// Shaft angle, not wrapped.
    pub angle_rad: Vec<f64>,
    /// Voltage that the controller commands at the sample and holds until the next sample.
    pub voltage_v: Vec<f64>,
    /// Measured temperature of the lubricant; empty if the rig has no temperature effect.
    pub temperature_c: Vec<f64>,
    /// What the axis was; empty without an axis.
    pub axis: AxisColumns,
    /// Whether there is no load sensor: a recording then has no column of the load.
    pub no_load_sensor: bool,
}

/// One row of a trace.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) t_s: f64,
    pub(super) velocity_ref_rad_s: f64,
    pub(super) velocity_rad_s: f64,
    pub(super) current_a: f64,
    pub(super) load_torque_nm: f64,
    pub(super) angle_rad: f64,
    pub(super) voltage_v: f64,
}

impl RigTrace {
    pub(super) fn with_capacity(samples: usize) -> Self {
        let column = || Vec::with_capacity(samples);
        Self {
            t_s: column(),
            velocity_ref_rad_s: column(),
            velocity_rad_s: column(),
            current_a: column(),
            load_torque_nm: column(),
            angle_rad: column(),
            voltage_v: column(),
            temperature_c: Vec::new(),
            axis: AxisColumns::default(),
            no_load_sensor: false,
        }
    }

    pub(super) fn push(&mut self, row: Row) {
        self.t_s.push(row.t_s);
        self.velocity_ref_rad_s.push(row.velocity_ref_rad_s);
        self.velocity_rad_s.push(row.velocity_rad_s);
        self.current_a.push(row.current_a);
        self.load_torque_nm.push(row.load_torque_nm);
        self.angle_rad.push(row.angle_rad);
        self.voltage_v.push(row.voltage_v);
    }

    /// Makes these samples NaN in all columns but the time.
    pub(super) fn lose(&mut self, samples: &[usize]) {
        let columns = [
            &mut self.velocity_ref_rad_s,
            &mut self.velocity_rad_s,
            &mut self.current_a,
            &mut self.load_torque_nm,
            &mut self.angle_rad,
            &mut self.voltage_v,
        ];
        for column in columns.into_iter().chain([&mut self.temperature_c]) {
            for &sample in samples {
                if let Some(cell) = column.get_mut(sample) {
                    *cell = f64::NAN;
                }
            }
        }
    }

    /// The load as a recording has it: zeros if there is no load sensor.
    #[must_use]
    pub fn recorded_load_nm(&self) -> Vec<f64> {
        if self.no_load_sensor { vec![0.0; self.len()] } else { self.load_torque_nm.clone() }
    }

    /// The recorded columns with their names, in the order of a file.
    #[must_use]
    pub fn recorded(&self) -> Vec<(&'static str, &[f64])> {
        let mut columns: Vec<(&'static str, &[f64])> = vec![
            ("t_s", &self.t_s),
            ("velocity_ref_rad_s", &self.velocity_ref_rad_s),
            ("velocity_rad_s", &self.velocity_rad_s),
            ("current_a", &self.current_a),
            ("load_torque_nm", &self.load_torque_nm),
            ("angle_rad", &self.angle_rad),
            ("voltage_v", &self.voltage_v),
            ("temperature_c", &self.temperature_c),
        ];
        columns.retain(|(name, _)| !(self.no_load_sensor && *name == "load_torque_nm"));
        columns.retain(|(name, column)| !(column.is_empty() && *name == "temperature_c"));
        columns.extend(self.axis.recorded());
        columns
    }

    /// Number of samples.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether there are no samples.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }
}
