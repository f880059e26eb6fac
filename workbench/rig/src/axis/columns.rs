//! Columns of a record that say what its axis was. A drive knows the ratio and, behind an absolute encoder, the
//! position; weight and payload are the truth beside it.

use super::AxisLoad;

/// Columns of the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AxisColumns {
    /// Turns of the motor per turn of the axis, the same in all rows.
    pub ratio: Vec<f64>,
    /// Angle of a rotary axis; empty for a linear one, whose position is recorded.
    pub axis_rad: Vec<f64>,
    /// Weight at the motor.
    pub weight_nm: Vec<f64>,
    /// Payload, 1 nominal.
    pub payload: Vec<f64>,
    /// 1 while the holding brake is closed.
    pub brake_closed: Vec<f64>,
}

impl AxisColumns {
    pub(crate) fn push(&mut self, ratio: f64, axis: &AxisLoad, angle_rad: f64, closed: bool) {
        self.ratio.push(ratio);
        if !axis.is_linear() {
            self.axis_rad.push(axis.phi(angle_rad));
        }
        self.weight_nm.push(axis.weight_nm(angle_rad));
        self.payload.push(axis.payload());
        self.brake_closed.push(f64::from(u8::from(closed)));
    }

    /// The columns with their names, in the order of a file; none if the rig has no axis.
    #[must_use]
    pub fn recorded(&self) -> Vec<(&'static str, &[f64])> {
        let mut columns: Vec<(&'static str, &[f64])> = vec![
            ("ratio", &self.ratio),
            ("axis_rad", &self.axis_rad),
            ("weight_nm", &self.weight_nm),
            ("payload", &self.payload),
            ("brake_closed", &self.brake_closed),
        ];
        columns.retain(|(_, column)| !column.is_empty());
        columns
    }
}
