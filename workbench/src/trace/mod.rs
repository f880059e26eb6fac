//! Recorded or simulated signals, from files to what identification takes.

mod csv_reader;
pub mod half_band;
pub mod labels;
pub mod prepare;

use std::path::{Path, PathBuf};

use crate::Error;
use crate::rig::RigTrace;

pub use labels::{Condition, Labels};
pub use prepare::Preparation;

/// What the drive knows of its shaft: columns as long as the trace.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionTrace {
    /// Quadrature or armature current.
    pub current_a: Vec<f64>,
    /// Measured velocity.
    pub velocity_rad_s: Vec<f64>,
    /// Velocity reference.
    pub reference_rad_s: Vec<f64>,
    /// Load torque; zeros where it is not measured.
    pub load_nm: Vec<f64>,
    /// Angle of the shaft, wrapped or not.
    pub angle_rad: Vec<f64>,
}

impl From<&RigTrace> for MotionTrace {
    fn from(recorded: &RigTrace) -> Self {
        Self {
            current_a: recorded.current_a.clone(),
            velocity_rad_s: recorded.velocity_rad_s.clone(),
            reference_rad_s: recorded.velocity_ref_rad_s.clone(),
            load_nm: recorded.load_torque_nm.clone(),
            angle_rad: recorded.angle_rad.clone(),
        }
    }
}

impl MotionTrace {
    /// The same columns from `start` up to `end`.
    #[must_use]
    pub fn cut(&self, start: usize, end: usize) -> Self {
        let part = |column: &[f64]| column[start..end].to_vec();
        Self {
            current_a: part(&self.current_a),
            velocity_rad_s: part(&self.velocity_rad_s),
            reference_rad_s: part(&self.reference_rad_s),
            load_nm: part(&self.load_nm),
            angle_rad: part(&self.angle_rad),
        }
    }
}

/// One record: output and two inputs at a constant rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Name of its file, or the `trace` cell of a tidy table.
    pub id: String,
    /// Median step of the `t_s` column, s, where there is one.
    pub interval_s: Option<f64>,
    /// Steps of `t_s` that differ from the median by more than a tenth of it.
    pub irregular_steps: usize,
    /// Output.
    pub y: Vec<f64>,
    /// First input.
    pub u1: Vec<f64>,
    /// Second input.
    pub u2: Vec<f64>,
    /// The shaft, where its channels are wanted.
    pub motion: Option<MotionTrace>,
}

/// Which columns the three signals come from: a column's name, or a difference `a-b` of two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channels {
    /// Output.
    pub y: String,
    /// First input.
    pub u1: String,
    /// Second input.
    pub u2: String,
    /// The shaft's, where it is watched.
    pub shaft: Option<ShaftChannels>,
}

/// Which columns the shaft's signals come from, likewise.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct ShaftChannels {
    /// Current, A.
    pub current: String,
    /// Measured velocity, rad/s.
    pub velocity: String,
    /// Velocity reference, rad/s.
    pub reference: String,
    /// Load torque, N·m; nothing where it is not measured.
    pub load: Option<String>,
    /// Angle, rad.
    pub angle: String,
}

impl ShaftChannels {
    /// The columns of the DC-motor rig.
    #[must_use]
    pub fn rig() -> Self {
        Self {
            current: "current_a".into(),
            velocity: "velocity_rad_s".into(),
            reference: "velocity_ref_rad_s".into(),
            load: Some("load_torque_nm".into()),
            angle: "angle_rad".into(),
        }
    }
}

impl Channels {
    /// Three signals, no shaft.
    #[must_use]
    pub fn new(y: impl Into<String>, u1: impl Into<String>, u2: impl Into<String>) -> Self {
        Self { y: y.into(), u1: u1.into(), u2: u2.into(), shaft: None }
    }
}

/// The id of a trace without the `.csv` of its file, for comparing.
#[must_use]
pub fn stem(id: &str) -> &str {
    id.strip_suffix(".csv").or_else(|| id.strip_suffix(".CSV")).unwrap_or(id)
}

/// Whether two sample intervals are the same but for rounding of the recorded times.
#[must_use]
pub fn same_interval(one_s: f64, other_s: f64) -> bool {
    (one_s - other_s).abs() <= 0.02 * one_s.abs().max(other_s.abs())
}

/// Reads every trace of the given files and folders.
///
/// A folder stands for its `.csv` files that hold the wanted columns (others, such as labels or parameter tables,
/// are passed over); a file named outright must hold them.
///
/// # Errors
/// Unreadable files; missing columns; ragged, non-numeric or non-finite cells; an id that comes twice; no trace.
pub fn read(paths: &[PathBuf], channels: &Channels) -> Result<Vec<Trace>, Error> {
    read_files(paths, channels, None)
}

/// Reads the traces whose id (without `.csv`) is wanted; others are passed over unread, whatever they hold. A wanted
/// trace must hold the columns.
///
/// # Errors
/// As [`read`].
pub fn read_wanted(paths: &[PathBuf], channels: &Channels, wanted: &dyn Fn(&str) -> bool) -> Result<Vec<Trace>, Error> {
    read_files(paths, channels, Some(wanted))
}

fn read_files(
    paths: &[PathBuf],
    channels: &Channels,
    wanted: Option<&dyn Fn(&str) -> bool>,
) -> Result<Vec<Trace>, Error> {
    let asked_for = |file: &Path| {
        let name = file.file_name().map(|name| name.to_string_lossy());
        wanted.zip(name).is_some_and(|(wanted, name)| wanted(stem(&name)))
    };
    let mut traces: Vec<Trace> = Vec::new();
    let mut origin = std::collections::HashMap::new();
    for path in paths {
        let mut files = vec![path.clone()];
        if path.is_dir() {
            files = csv_files(path)?;
            files.retain(|file| asked_for(file) || csv_reader::has_columns(file, channels));
        }
        for file in files {
            for trace in csv_reader::read(&file, channels, wanted.unwrap_or(&|_| true))? {
                if let Some(first) = origin.insert(stem(&trace.id).to_string(), file.clone()) {
                    let (first, second) = (first.display(), file.display());
                    let problem = format!("comes twice, in {first} and {second}; give each id once");
                    return Err(Error::trace(&trace.id, problem));
                }
                traces.push(trace);
            }
        }
    }
    if traces.is_empty() {
        let names: Vec<_> = paths.iter().map(|path| path.display().to_string()).collect();
        let Channels { y, u1, u2, .. } = channels;
        return Err(Error::Usage(format!(
            "no trace with the columns of {y}, {u1}, {u2} in {}; check the path and --y, --u1, --u2",
            names.join(", ")
        )));
    }
    Ok(traces)
}

fn csv_files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = std::fs::read_dir(folder).map_err(Error::io(folder))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    files.retain(|file| file.is_file() && file.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")));
    files.sort();
    Ok(files)
}
