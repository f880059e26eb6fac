//! The recorded trace of the actuator.

use super::super::axis::AxisColumns;

/// One recording: columns of the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EmaTrace {
    /// Time of the row.
    pub t_s: Vec<f64>,
    /// Position command.
    pub position_ref_m: Vec<f64>,
    /// Measured position of the mass.
    pub position_m: Vec<f64>,
    /// Velocity command, the output of the position loop.
    pub velocity_ref_rad_s: Vec<f64>,
    /// Measured shaft velocity.
    pub velocity_rad_s: Vec<f64>,
    /// Measured q current (peak): Park transform of the measured phase currents at the angle of the resolver, positive
    /// drives forward.
    pub current_a: Vec<f64>,
    /// Measured d current, transformed in the same way.
    pub current_d_a: Vec<f64>,
    /// Command of the q current.
    pub current_ref_a: Vec<f64>,
    /// Measured current of phase a.
    pub phase_a_a: Vec<f64>,
    /// Measured current of phase b.
    pub phase_b_a: Vec<f64>,
    /// Measured current of phase c.
    pub phase_c_a: Vec<f64>,
    /// Counts of the resolver.
    pub resolver_counts: Vec<u32>,
    /// Shaft angle from the counts, not wrapped.
    pub angle_rad: Vec<f64>,
    /// True force of the load; positive opposes positive motion.
    pub load_n: Vec<f64>,
    /// Torque of this force on the shaft without friction, F · lead/2π.
    pub load_torque_nm: Vec<f64>,
    /// Commanded d voltage, held until the next control interval.
    pub voltage_d_v: Vec<f64>,
    /// Commanded q voltage.
    pub voltage_q_v: Vec<f64>,
    /// What the axis was; empty without an axis. A recording then has no columns of the load.
    pub axis: AxisColumns,
}

/// One row of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    pub(super) position_ref_m: f64,
    pub(super) position_m: f64,
    pub(super) velocity_ref_rad_s: f64,
    pub(super) velocity_rad_s: f64,
    pub(super) current_a: f64,
    pub(super) current_d_a: f64,
    pub(super) current_ref_a: f64,
    pub(super) phases_a: [f64; 3],
    pub(super) resolver_counts: u32,
    pub(super) angle_rad: f64,
    pub(super) load_n: f64,
    pub(super) load_torque_nm: f64,
    pub(super) voltage_d_v: f64,
    pub(super) voltage_q_v: f64,
}

impl EmaTrace {
    pub(super) fn push(&mut self, t_s: f64, row: &Row) {
        let [a, b, c] = row.phases_a;
        self.t_s.push(t_s);
        self.position_ref_m.push(row.position_ref_m);
        self.position_m.push(row.position_m);
        self.velocity_ref_rad_s.push(row.velocity_ref_rad_s);
        self.velocity_rad_s.push(row.velocity_rad_s);
        self.current_a.push(row.current_a);
        self.current_d_a.push(row.current_d_a);
        self.current_ref_a.push(row.current_ref_a);
        self.phase_a_a.push(a);
        self.phase_b_a.push(b);
        self.phase_c_a.push(c);
        self.resolver_counts.push(row.resolver_counts);
        self.angle_rad.push(row.angle_rad);
        self.load_n.push(row.load_n);
        self.load_torque_nm.push(row.load_torque_nm);
        self.voltage_d_v.push(row.voltage_d_v);
        self.voltage_q_v.push(row.voltage_q_v);
    }

    /// The recorded columns with their names, in the order of a file.
    #[must_use]
    pub fn recorded(&self) -> Vec<(&'static str, Vec<f64>)> {
        let columns: [(&'static str, &[f64]); 11] = [
            ("t_s", &self.t_s),
            ("position_ref_m", &self.position_ref_m),
            ("position_m", &self.position_m),
            ("velocity_ref_rad_s", &self.velocity_ref_rad_s),
            ("velocity_rad_s", &self.velocity_rad_s),
            ("current_a", &self.current_a),
            ("current_d_a", &self.current_d_a),
            ("current_ref_a", &self.current_ref_a),
            ("phase_a_a", &self.phase_a_a),
            ("phase_b_a", &self.phase_b_a),
            ("phase_c_a", &self.phase_c_a),
        ];
        let last: [(&'static str, &[f64]); 5] = [
            ("angle_rad", &self.angle_rad),
            ("load_n", &self.load_n),
            ("load_torque_nm", &self.load_torque_nm),
            ("voltage_d_v", &self.voltage_d_v),
            ("voltage_q_v", &self.voltage_q_v),
        ];
        let own = |(name, column): (&'static str, &[f64])| (name, column.to_vec());
        let counts = self.resolver_counts.iter().copied().map(f64::from).collect();
        let mut all: Vec<(&'static str, Vec<f64>)> = columns.into_iter().map(own).collect();
        all.push(("resolver_counts", counts));
        let no_sensor = !self.axis.ratio.is_empty();
        let recorded = last.into_iter().filter(|(name, _)| !(no_sensor && name.starts_with("load_")));
        all.extend(recorded.chain(self.axis.recorded()).map(own));
        all
    }

    /// Number of rows.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether there are no rows.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }
}
