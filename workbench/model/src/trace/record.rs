//! A record of signals, and the names of its columns.

use bearing_watch::drive::Alignment;
use serde::de::{Deserialize as _, Deserializer, Error as _};
use serde_json::Value;

use super::front_end::{FrontEndFile, Refused};
use super::{Missing, TextForm};

/// Signals of the shaft; each column is as long as the trace.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionTrace {
    /// Quadrature or armature current.
    pub current_a: Vec<f64>,
    /// Measured velocity; zeros if it is not measured.
    pub velocity_rad_s: Vec<f64>,
    /// Load torque; zeros if it is not measured.
    pub load_nm: Vec<f64>,
    /// Angle of the shaft, wrapped or not.
    pub angle_rad: Vec<f64>,
    /// Reference of the velocity; empty if it is not given.
    pub reference_rad_s: Vec<f64>,
}

impl MotionTrace {
    /// Number of turns, both directions counted; a step of more than half a turn is one of a wrapped angle.
    #[must_use]
    pub fn turns(&self) -> f64 {
        let steps = self.angle_rad.windows(2).map(|w| (w[1] - w[0]).abs());
        steps.filter(|step| *step < std::f64::consts::PI).sum::<f64>() / std::f64::consts::TAU
    }

    /// The columns from sample `start` to `end`, excluding `end`.
    #[must_use]
    pub fn cut(&self, start: usize, end: usize) -> Self {
        let part = |column: &[f64]| column[start..end].to_vec();
        Self {
            current_a: part(&self.current_a),
            velocity_rad_s: part(&self.velocity_rad_s),
            load_nm: part(&self.load_nm),
            angle_rad: part(&self.angle_rad),
            reference_rad_s: if self.reference_rad_s.is_empty() { vec![] } else { part(&self.reference_rad_s) },
        }
    }
}

/// One record: output and two inputs at a constant rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Name of its file, or the `trace` cell of a tidy table.
    pub id: String,
    /// Median step of the time column, or one over the rate that was given instead, s.
    pub interval_s: Option<f64>,
    /// Number of steps of the time that differ from the median by more than a tenth of it.
    pub irregular_steps: usize,
    /// Output.
    pub y: Vec<f64>,
    /// First input.
    pub u1: Vec<f64>,
    /// Second input.
    pub u2: Vec<f64>,
    /// The shaft's signals, if its channels are requested.
    pub motion: Option<MotionTrace>,
    /// Further columns, in the order of [`Channels::further`].
    pub further: Vec<Vec<f64>>,
    /// What the front end refused, if anything; these samples are NaN.
    pub refused: Option<Refused>,
    /// What is missing in the recording; these samples are NaN.
    pub missing: Missing,
    /// Samples before which the front end found that a fault had begun earlier, in their order.
    pub found_late: Vec<usize>,
    /// What the front end knew of the wiring from a sample on, in their order; empty without a front end.
    pub wiring: Vec<(usize, Alignment)>,
}

impl Trace {
    /// Other signals of the regression with the same identity and interval, and nothing beside them.
    #[must_use]
    pub fn with_signals(&self, [y, u1, u2]: [Vec<f64>; 3]) -> Self {
        Self {
            id: self.id.clone(),
            y,
            u1,
            u2,
            motion: None,
            further: vec![],
            found_late: vec![],
            wiring: vec![],
            ..*self
        }
    }

    /// Its first rows, or all of a shorter one.
    pub(crate) fn first_rows(&self, rows: usize) -> Self {
        let rows = rows.min(self.y.len());
        let part = |column: &Vec<f64>| column[..rows].to_vec();
        Self {
            y: part(&self.y),
            u1: part(&self.u1),
            u2: part(&self.u2),
            motion: self.motion.as_ref().map(|motion| motion.cut(0, rows)),
            further: self.further.iter().map(part).collect(),
            found_late: self.found_late.iter().copied().filter(|row| *row < rows).collect(),
            wiring: self.wiring.iter().copied().filter(|(row, _)| *row < rows).collect(),
            ..self.clone()
        }
    }
}

/// The columns of the three signals: a column's name, or a formula of columns such as `a-b`, `0.5*(a + b)`,
/// `speed_rpm rad/s` or `integrate(speed_rpm) rad`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Channels {
    /// Output.
    pub y: String,
    /// First input.
    pub u1: String,
    /// Second input.
    pub u2: String,
    /// The columns of the shaft, if it is watched.
    #[serde(default)]
    pub shaft: Option<ShaftChannels>,
    /// Columns that are used for their averages alone.
    #[serde(default)]
    pub further: Vec<String>,
    /// The time column; by its usual names if none is given, and no time at all if it is `none`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Rows a second, for files without a time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// The parts of the layout of text files that the user gives.
    #[serde(default, skip_serializing_if = "TextForm::is_empty")]
    pub text: TextForm,
    /// Makes the columns of recordings at the control rate; `None` if they are recorded as they are used.
    #[serde(default)]
    pub front_end: Option<FrontEndFile>,
}

/// The columns of the shaft's signals, in the same format.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct ShaftChannels {
    /// Current, A.
    pub current: String,
    /// Measured velocity, rad/s; `None` if it is not measured.
    pub velocity: Option<String>,
    /// Load torque, N·m; `None` if it is not measured.
    pub load: Option<String>,
    /// Angle, rad.
    pub angle: String,
    /// Reference of the velocity, rad/s, if it is given. Only training without a load sensor uses it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
}

impl ShaftChannels {
    /// The columns of the DC-motor rig.
    #[must_use]
    pub fn rig() -> Self {
        Self {
            current: "current_a".into(),
            velocity: Some("velocity_rad_s".into()),
            load: Some("load_torque_nm".into()),
            angle: "angle_rad".into(),
            reference: None,
        }
    }
}

impl Channels {
    /// Without names: the place of channels that are read beside other fields.
    #[must_use]
    pub fn unknown() -> Self {
        Self::new("", "", "")
    }

    /// Reads channels and the fields beside them, which `others` reads. Not as a flattened field, which loses numbers
    /// where a program asks `serde_json` for all their digits.
    ///
    /// # Errors
    /// Missing or wrong fields.
    pub fn beside<'de, D: Deserializer<'de>, T>(
        deserializer: D,
        others: impl FnOnce(&Value) -> Result<T, serde_json::Error>,
    ) -> Result<(Self, T), D::Error> {
        let value = Value::deserialize(deserializer)?;
        let channels = Self::deserialize(&value).map_err(D::Error::custom)?;
        Ok((channels, others(&value).map_err(D::Error::custom)?))
    }

    /// Three signals, no shaft.
    #[must_use]
    pub fn new(y: impl Into<String>, u1: impl Into<String>, u2: impl Into<String>) -> Self {
        Self {
            y: y.into(),
            u1: u1.into(),
            u2: u2.into(),
            shaft: None,
            further: vec![],
            time: None,
            rate_hz: None,
            text: TextForm::default(),
            front_end: None,
        }
    }

    /// All names, columns and differences.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        [&self.y, &self.u1, &self.u2]
            .into_iter()
            .map(String::as_str)
            .chain(self.of_shaft())
            .chain(self.others())
            .collect()
    }

    /// The same in the order in which a reader takes them: y, u1, u2, the further ones, then those of the shaft.
    #[must_use]
    pub fn in_order(&self) -> Vec<&str> {
        [&self.y, &self.u1, &self.u2]
            .into_iter()
            .map(String::as_str)
            .chain(self.others())
            .chain(self.of_shaft())
            .collect()
    }

    fn others(&self) -> impl Iterator<Item = &str> {
        self.further.iter().map(String::as_str)
    }

    /// Current, angle, and what else of the shaft has a column: velocity, load, reference.
    fn of_shaft(&self) -> impl Iterator<Item = &str> {
        self.shaft.iter().flat_map(|shaft| {
            let ShaftChannels { current, velocity, load, angle, reference } = shaft;
            [current, angle].into_iter().chain(velocity).chain(load).chain(reference).map(String::as_str)
        })
    }
}

/// Whether two sampling intervals are equal except for rounding of the recorded times.
#[must_use]
pub fn same_interval(one_s: f64, other_s: f64) -> bool {
    (one_s - other_s).abs() <= 0.02 * one_s.abs().max(other_s.abs())
}

/// Returns the signal with the last value in place of missing ones.
#[must_use]
pub fn bridged(signal: &[f64]) -> Vec<f64> {
    let mut last = signal.iter().copied().find(|x| x.is_finite()).unwrap_or(0.0);
    let hold = |&x: &f64| {
        if x.is_finite() {
            last = x;
        }
        last
    };
    signal.iter().map(hold).collect()
}
