//! `bearing-watch grey-box`

use std::path::{Path, PathBuf};

use clap::Subcommand;
use rayon::prelude::*;
use serde_json::json;

use crate::command_line::jobs::{Balanced, Recordings};
use crate::command_line::options::Taken;
use crate::command_line::output;
use crate::identification::cogging;
use crate::recordings::reading::{balanced, complete};
use model::Error;
use model::grey_box::linear::{self, Asymmetry, Friction, LinearRecord, LinearSettings};
use model::grey_box::motor::{self, Load, MotorRecord, MotorSettings};
use model::grey_box::physical::{self, ElectricalRecord};
use model::grey_box::{GreyBox, Quantity};
use model::session::irregular;
use model::settings::DriveFile;
use model::trace::{Channels, Trace};

/// Physical constants of a drive, with standard deviations
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch grey-box linear trace.csv --position qm_m --force vir_V --force-gain 35.15 \
--asymmetric"
)]
pub(crate) struct Args {
    #[command(subcommand)]
    drive: Drive,
}

#[derive(Debug, Subcommand)]
enum Drive {
    Linear(LinearArgs),
    Motor(MotorArgs),
    Electrical(ElectricalArgs),
    Cogging(cogging::Args),
}

/// Mass, friction and offset of a linear drive from position and force, or of a rotary one from angle and torque
#[derive(Debug, clap::Args)]
struct LinearArgs {
    #[command(flatten)]
    taken: Taken<Recordings>,
    /// The drive is rotary: position is its angle, rad, and force its torque, N·m
    #[arg(long)]
    rotary: bool,
    /// Measured position, m
    #[arg(long, value_name = "CHANNEL")]
    position: String,
    /// Force, N, or a signal proportional to it
    #[arg(long, value_name = "CHANNEL")]
    force: String,
    /// Newtons per unit of the force channel
    #[arg(long, value_name = "GAIN", default_value_t = 1.0)]
    force_gain: f64,
    /// Separate friction for each direction, without offset, and the difference of the two directions: a sign of wear
    #[arg(long)]
    asymmetric: bool,
    /// Cut-off of the position filter, Hz
    #[arg(long, value_name = "HZ", default_value_t = LinearSettings::default().cutoff_hz)]
    cutoff: f64,
    /// Samples per row of the regression
    #[arg(long, value_name = "N", default_value_t = LinearSettings::default().decimate)]
    decimate: usize,
    /// Also report the error of the constants on this trace
    #[arg(long, value_name = "TRACE")]
    validate: Option<PathBuf>,
    #[command(flatten)]
    shown: Shown,
}

/// Inertia, friction and torque constant of a motor from its torque balance
///
/// The load torque must be measured, or the torque constant be known.
#[derive(Debug, clap::Args)]
struct MotorArgs {
    #[command(flatten)]
    taken: Taken<Balanced>,
    /// Velocity reference, rad/s
    #[arg(long, value_name = "CHANNEL", default_value = "velocity_ref_rad_s")]
    reference: String,
    /// Torque constant, N·m/A, if it is known, for example from the data sheet
    #[arg(long, value_name = "KT", value_parser = crate::recordings::reading::rate)]
    kt: Option<f64>,
    /// Cut-off of the state-variable filter, Hz
    #[arg(long, value_name = "HZ", default_value_t = MotorSettings::default().cutoff_hz)]
    cutoff: f64,
    #[command(flatten)]
    shown: Shown,
}

/// R, L, Kt and, assuming Ke = Kt, J and B from the five-parameter model of the current (thesis Eq. 2.41)
#[derive(Debug, clap::Args)]
struct ElectricalArgs {
    #[command(flatten)]
    taken: Taken<Balanced>,
    /// Terminal voltage, V
    #[arg(long, value_name = "CHANNEL", default_value = "voltage_v")]
    voltage: String,
    #[command(flatten)]
    shown: Shown,
}

#[derive(Debug, clap::Args)]
struct Shown {
    /// Sampling interval, s, if the traces have no t_s column
    #[arg(long, value_name = "SECONDS")]
    interval: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The constants of one trace, and their error in percent on other traces.
struct Row {
    id: String,
    found: GreyBox,
    validation: Vec<(String, f64)>,
}

impl Args {
    /// Puts the settings of the command over those of a drive file.
    pub(crate) fn join(&mut self, drive: Option<&DriveFile>) -> Result<(), Error> {
        match &mut self.drive {
            Drive::Linear(args) => args.taken.join(drive),
            Drive::Motor(args) => args.taken.join(drive),
            Drive::Electrical(args) => args.taken.join(drive),
            Drive::Cogging(args) => args.taken.join(drive),
        }
    }

    /// The text of a drive file at this path with the settings of the command.
    pub(crate) fn text(&self, path: &Path) -> Result<String, Error> {
        match &self.drive {
            Drive::Linear(args) => args.taken.text(path),
            Drive::Motor(args) => args.taken.text(path),
            Drive::Electrical(args) => args.taken.text(path),
            Drive::Cogging(args) => args.taken.text(path),
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    match &args.drive {
        Drive::Linear(args) => linear(args),
        Drive::Motor(args) => motor(args),
        Drive::Electrical(args) => electrical(args),
        Drive::Cogging(args) => cogging::run(args),
    }
}

fn linear(args: &LinearArgs) -> Result<(), Error> {
    if !(args.force_gain.is_finite() && args.force_gain != 0.0) {
        return Err(Error::Usage("--force-gain takes a number other than zero".into()));
    }
    let friction = if args.asymmetric { Friction::OneSided } else { Friction::Symmetric };
    let settings = LinearSettings { friction, cutoff_hz: args.cutoff, decimate: args.decimate, rotary: args.rotary };
    let channels = Channels::new(args.position.clone(), args.force.clone(), args.force.clone());
    let read = |paths: &[PathBuf]| -> Result<Vec<Trace>, Error> {
        let mut traces = traces::read(paths, &channels)?;
        traces.iter_mut().flat_map(|trace| &mut trace.u1).for_each(|force| *force *= args.force_gain);
        irregular(traces.iter()).iter().for_each(output::warn);
        complete(&traces)?;
        Ok(traces)
    };
    let elsewhere = match &args.validate {
        Some(path) => read(std::slice::from_ref(path))?,
        None => vec![],
    };
    let each = |trace: &Trace| {
        let found = linear::estimate(&linear_record(trace, &args.shown)?, &settings)?;
        let score = |other: &Trace| linear::cross_validate(&linear_record(other, &args.shown)?, &settings, &found);
        let validation = elsewhere.iter().map(|other| Ok((other.id.clone(), score(other)?)));
        let validation = validation.collect::<Result<Vec<_>, Error>>()?;
        Ok(Row { id: trace.id.clone(), found, validation })
    };
    args.shown.print(&read(&args.taken.settings.data.traces)?.iter().map(each).collect::<Result<Vec<_>, Error>>()?)
}

fn linear_record<'a>(trace: &'a Trace, shown: &Shown) -> Result<LinearRecord<'a>, Error> {
    let interval_s = shown.interval_of(trace)?;
    Ok(LinearRecord { id: &trace.id, interval_s, position_m: &trace.y, force_n: &trace.u1 })
}

/// Reads four channels by two reads of three channels each: the first, the last, and one of the two middle channels.
fn read_four(paths: &[PathBuf], [y, first, second, u2]: [&String; 4]) -> Result<Vec<(Trace, Vec<f64>)>, Error> {
    let read = |u1: &String| traces::read(paths, &Channels::new(y.clone(), u1, u2));
    let (traces, other) = (read(first)?, read(second)?);
    irregular(traces.iter()).iter().for_each(output::warn);
    complete(&traces)?;
    complete(&other)?;
    // Skips files of a folder that lack one of the columns; the files of both reads must then match.
    let mut pairs = Vec::new();
    for trace in traces {
        let Some(partner) = other.iter().find(|other| other.id == trace.id) else {
            return Err(Error::trace(&trace.id, format!("no column {second}; name the traces that have it")));
        };
        pairs.push((trace, partner.u1.clone()));
    }
    Ok(pairs)
}

fn motor(args: &MotorArgs) -> Result<(), Error> {
    let settings = MotorSettings { cutoff_hz: args.cutoff, torque_constant_nm_a: args.kt, ..MotorSettings::default() };
    let [current, velocity, load] = &balanced(&args.taken.settings.channels);
    let is_measured = !matches!(load.as_str(), "constant" | "none");
    let torque = if is_measured { load } else { current };
    let traces = read_four(&args.taken.settings.data.traces, [current, velocity, &args.reference, torque])?;
    let each = |(trace, reference): &(Trace, Vec<f64>)| {
        let record = MotorRecord {
            id: &trace.id,
            interval_s: args.shown.interval_of(trace)?,
            current_a: &trace.y,
            velocity_rad_s: &trace.u1,
            velocity_ref_rad_s: reference,
            load: match load.as_str() {
                "none" => Load::Absent,
                "constant" => Load::Constant,
                _ => Load::Measured(&trace.u2),
            },
        };
        Ok(Row { id: trace.id.clone(), found: motor::estimate(&record, &settings)?, validation: vec![] })
    };
    args.shown.print(&traces.par_iter().map(each).collect::<Vec<_>>().into_iter().collect::<Result<Vec<_>, Error>>()?)
}

fn electrical(args: &ElectricalArgs) -> Result<(), Error> {
    let [current, velocity, load] = &balanced(&args.taken.settings.channels);
    let traces = read_four(&args.taken.settings.data.traces, [current, velocity, &args.voltage, load])?;
    let each = |(trace, voltage): &(Trace, Vec<f64>)| {
        let record = ElectricalRecord {
            id: &trace.id,
            interval_s: args.shown.interval_of(trace)?,
            current_a: &trace.y,
            voltage_v: voltage,
            velocity_rad_s: &trace.u1,
            load_torque_nm: &trace.u2,
        };
        let found = physical::five_parameters(&record)?.physical(&trace.id)?;
        Ok(Row { id: trace.id.clone(), found, validation: vec![] })
    };
    args.shown.print(&traces.iter().map(each).collect::<Result<Vec<_>, Error>>()?)
}

impl Shown {
    fn interval_of(&self, trace: &Trace) -> Result<f64, Error> {
        let given = self.interval.or(trace.interval_s).filter(|step| *step > 0.0 && step.is_finite());
        given.ok_or_else(|| Error::trace(&trace.id, "its sampling interval is unknown; give --interval SECONDS"))
    }

    fn print(&self, rows: &[Row]) -> Result<(), Error> {
        if self.json {
            return output::json("grey-box", json!(rows.iter().map(Row::to_json).collect::<Vec<_>>()));
        }
        rows.iter().try_for_each(|row| output::say(row.to_text()))
    }
}

impl Row {
    fn to_json(&self) -> serde_json::Value {
        let quantity = |q: &Quantity| (q.name.to_string(), json!({ "value": q.value, "sd": q.sd, "unit": q.unit }));
        let elsewhere = self.validation.iter().map(|(id, error)| (id.clone(), json!(error)));
        let asymmetry =
            |d: &Asymmetry| (d.name.to_string(), json!({ "value": d.value, "sd": d.sd, "z": d.z(), "unit": d.unit }));
        json!({
            "trace": self.id,
            "quantities": self.found.quantities.iter().map(quantity).collect::<serde_json::Map<_, _>>(),
            "relative_error_percent": self.found.relative_error_percent,
            "validation_error_percent": elsewhere.collect::<serde_json::Map<_, _>>(),
            "asymmetry": linear::asymmetries(&self.found).iter().map(asymmetry).collect::<serde_json::Map<_, _>>(),
            "rows": self.found.rows,
            "notes": self.found.notes,
        })
    }

    fn to_text(&self) -> String {
        let quantities = self.found.quantities.iter().map(|q| {
            let (name, value, sd, unit) = (q.name, Short(q.value), Short(q.sd), q.unit);
            format!("  {name:<7} {value:>12} ± {sd} {unit}")
        });
        let asymmetries = linear::asymmetries(&self.found).into_iter().map(|d| {
            let (value, sd) = (Short(d.value), Short(d.sd));
            let name = format!("{0}- − {0}+", d.name);
            format!("  {name:<9} {value:>10} ± {sd} {}, {:.1} standard deviations from even", d.unit, d.z())
        });
        let error =
            format!("  relative error {:.3} % over {} rows", self.found.relative_error_percent, self.found.rows);
        let elsewhere = self.validation.iter().map(|(id, error)| format!("  on {id}: {error:.3} %"));
        let notes = self.found.notes.iter().map(|note| format!("  note: {note}"));
        let lines = quantities.chain(asymmetries).chain([error]).chain(elsewhere).chain(notes);
        std::iter::once(self.id.clone()).chain(lines).collect::<Vec<_>>().join("\n")
    }
}

/// A number in a readable format: decimal if its magnitude is near one, with an exponent otherwise.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let plain = self.0 == 0.0 || (0.1..1e5).contains(&self.0.abs());
        f.pad(&if plain { format!("{:.4}", self.0) } else { format!("{:.4e}", self.0) })
    }
}
