//! `bearing-watch grey-box cogging`

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::{Value, json};

use crate::command_line::options::Taken;
use crate::command_line::{jobs, output};
use crate::recordings::reading::{self, balanced};
use model::Error;
use model::cogging::{
    Line, Lines, LinesSettings, Recording, Residual, RotorChange, Wave, fit, map, odrive, residuals, since, told,
};
use model::grey_box::motor::{Load, MotorRecord, MotorSettings};
use model::trace::{Channels, MotionTrace, ShaftChannels, Trace};
use pages::cogging::{HEADER, cells, page};
use pages::page::counted;
use traces::resample::unwrapped;

/// What turns with the rotor: cogging, ripple of the torque constant and unbalance by whole orders, the drive's map of
/// it, and what has changed since earlier recordings
#[derive(Debug, clap::Args)]
#[command(after_help = "The angle must be absolute, and the shaft turn slowly in both directions.\n\n\
Examples:\n  bearing-watch grey-box cogging slow --angle angle_rad --out map.csv --report page.html\n  \
bearing-watch grey-box cogging slow --load none --kt 0.05 --out cogging_map.c --format odrive\n  \
bearing-watch grey-box cogging june --since january")]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) taken: Taken<jobs::Cogging>,
    /// Torque constant, N·m/A, if it is known; needed if the load torque is not measured
    #[arg(long, value_name = "KT", value_parser = reading::rate)]
    kt: Option<f64>,
    /// Highest order that is looked for
    #[arg(long, value_name = "ORDER", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=1000))]
    highest_order: u32,
    /// Earlier recordings of the same drive, files or folders: says what has changed
    #[arg(long, value_name = "TRACES")]
    since: Vec<PathBuf>,
    /// Write the map: the current, or torque, to add at each angle
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Format of the map
    #[arg(long, value_enum, default_value = "csv")]
    format: Format,
    /// Angles of a turn in a map of the format csv
    #[arg(long, value_name = "N", default_value_t = 360, value_parser = clap::value_parser!(u32).range(8..=65536))]
    points: u32,
    /// Write a page with the map and the lines
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Format of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Columns angle_rad, current_a and deviation_a
    Csv,
    /// C array cogging_map of the firmware of the ODrive v3: torque, N·m, at 3600 angles
    Odrive,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let outputs = [&args.out, &args.report];
    let inputs: Vec<PathBuf> = args.taken.settings.data.traces.iter().chain(&args.since).cloned().collect();
    output::plan(&outputs.iter().filter_map(|file| file.as_deref()).collect::<Vec<_>>(), &inputs)?;
    let settings = LinesSettings { highest_order: args.highest_order, ..LinesSettings::default() };
    let now = args.residuals(&args.taken.settings.data.traces)?;
    let lines = fit(&now, &settings)?;
    let change = if args.since.is_empty() {
        None
    } else {
        let before = args.residuals(&args.since)?;
        Some(since((&before, &fit(&before, &settings)?), (&now, &lines))?)
    };
    if !lines.knows_lag {
        output::warn(
            "the delay of the current is only known with a measured load; turn slowly, so that it has no effect",
        );
    }
    args.write(&lines, now.len(), change.as_ref())?;
    if args.json {
        return output::json("cogging", to_json(&lines, change.as_ref()));
    }
    output::say(table(&lines))?;
    change.map_or(Ok(()), |change| output::say(format!("since the earlier recordings: {}", told(&change))))
}

impl Args {
    /// Reads recordings and forms their residuals.
    fn residuals(&self, paths: &[PathBuf]) -> Result<Vec<Residual>, Error> {
        let signals = &self.taken.settings.channels;
        let [current, velocity, load] = balanced(signals);
        let angle = signals.angle.clone().unwrap_or_else(|| "angle_rad".into());
        if angle.contains("integrate(") {
            let problem =
                format!("--angle {angle}: an integral is not absolute; give the angle of the position sensor");
            return Err(Error::Usage(problem));
        }
        let reference = signals.velocity_ref.clone().unwrap_or_else(|| "velocity_ref_rad_s".into());
        let is_measured = !matches!(load.as_str(), "constant" | "none");
        let data = &self.taken.settings.data;
        let shaft = ShaftChannels {
            current: current.clone(),
            velocity: Some(velocity.clone()),
            load: is_measured.then(|| load.clone()),
            angle,
            reference: Some(reference.clone()),
        };
        let channels = Channels {
            shaft: Some(shaft),
            time: data.time.clone(),
            rate_hz: data.rate_hz,
            text: data.text_form(),
            ..Channels::new(current, velocity, reference)
        };
        let traces = reading::read(paths, &channels)?;
        let angles: Vec<Vec<f64>> = traces.iter().map(angle_of).collect();
        let recordings = traces.iter().zip(&angles).filter_map(|(trace, angle_rad)| {
            let motor = motor_record(trace, trace.motion.as_ref()?, &load);
            Some(motor.map(|motor| Recording { motor, angle_rad }))
        });
        let settings = MotorSettings { torque_constant_nm_a: self.kt, ..MotorSettings::default() };
        residuals(&recordings.collect::<Result<Vec<_>, Error>>()?, &settings)
    }

    /// Writes the files.
    fn write(&self, lines: &Lines, traces: usize, change: Option<&RotorChange>) -> Result<(), Error> {
        let mut written: Vec<(&Path, String)> = vec![];
        if let Some(path) = &self.out {
            let text = match self.format {
                Format::Csv => output::csv(&rows(lines, self.points as usize))?,
                Format::Odrive => odrive(lines),
            };
            written.push((path, text));
        }
        if let Some(path) = &self.report {
            let [forward, backward] = lines.turns;
            let traces = counted(traces, "trace");
            let lead = format!("{traces} with {forward:.0} turns forward and {backward:.0} backward.");
            let page = page(lines, &lead, change.map(told).as_deref()).render();
            written.push((path, self.taken.on_page(page)));
        }
        output::write_all(&written.iter().map(|(path, text)| (*path, text.as_bytes())).collect::<Vec<_>>())
    }
}

/// The angle of a trace without jumps.
fn angle_of(trace: &Trace) -> Vec<f64> {
    trace.motion.as_ref().map_or_else(Vec::new, |motion| unwrapped(&motion.angle_rad, std::f64::consts::TAU))
}

/// The signals of the torque balance of a trace; `load` is its channel, or a word for what is not measured.
fn motor_record<'a>(trace: &'a Trace, motion: &'a MotionTrace, load: &str) -> Result<MotorRecord<'a>, Error> {
    let unknown = || Error::trace(&trace.id, "its sampling interval is unknown; give --rate-hz");
    Ok(MotorRecord {
        id: &trace.id,
        interval_s: trace.interval_s.filter(|step| *step > 0.0).ok_or_else(unknown)?,
        current_a: &motion.current_a,
        velocity_rad_s: &motion.velocity_rad_s,
        velocity_ref_rad_s: &motion.reference_rad_s,
        load: match load {
            "none" => Load::Absent,
            "constant" => Load::Constant,
            _ => Load::Measured(&motion.load_nm),
        },
    })
}

/// The rows of a map.
fn rows(lines: &Lines, points: usize) -> Vec<Vec<String>> {
    let header = ["angle_rad", "current_a", "deviation_a"].map(String::from).to_vec();
    let row = map(lines, points)
        .into_iter()
        .map(|point| [point.angle_rad, point.current_a, point.deviation_a].map(|value| format!("{value:.7}")).to_vec());
    std::iter::once(header).chain(row).collect()
}

/// The lines as a table of text.
fn table(lines: &Lines) -> String {
    let rows: Vec<Vec<String>> = lines.lines.iter().map(|line| cells(line, lines.torque_constant_nm_a)).collect();
    let header = HEADER.map(String::from).to_vec();
    let all: Vec<&Vec<String>> = std::iter::once(&header).chain(&rows).collect();
    let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let text = |row: &&Vec<String>| {
        let padded = row.iter().enumerate().map(|(column, cell)| format!("{cell:>0$}", width(column)));
        padded.collect::<Vec<_>>().join("  ")
    };
    let [before, after] = lines.residual_nm.map(|rms| 1e3 * rms);
    let [forward, backward] = lines.turns;
    let summary = format!(
        "{forward:.0} turns forward, {backward:.0} backward; residual {before:.2} mN·m rms, {after:.2} without the lines; \
         intervals of 95 %"
    );
    let table = all.iter().map(text).collect::<Vec<_>>().join("\n");
    if rows.is_empty() { format!("no line stands out\n{summary}") } else { format!("{table}\n{summary}") }
}

fn to_json(lines: &Lines, change: Option<&RotorChange>) -> Value {
    let wave = |wave: &Wave| {
        json!({
            "amplitude": wave.amplitude(),
            "amplitude_interval": wave.amplitude_interval(),
            "phase_rad": wave.phase_rad(),
            "phase_interval_rad": wave.phase_interval_rad(),
        })
    };
    let line = |line: &Line| {
        json!({
            "order": line.order,
            "torque_nm": line.torque_nm.as_ref().map(wave),
            "ripple": line.ripple.as_ref().map(wave),
        })
    };
    json!({
        "torque_constant_nm_a": lines.torque_constant_nm_a,
        "turns": lines.turns,
        "residual_nm": lines.residual_nm,
        "lines": lines.lines.iter().map(line).collect::<Vec<_>>(),
        "change": change.map(of_change),
    })
}

fn of_change(change: &RotorChange) -> Value {
    let mut value = match change {
        RotorChange::Unchanged => json!({ "kind": "unchanged" }),
        RotorChange::Unbalance { before_a, now_a } => {
            json!({ "kind": "unbalance", "before_a": before_a, "now_a": now_a })
        }
        RotorChange::Slipped { angle_rad, deviation_rad } => {
            json!({ "kind": "slipped", "angle_rad": angle_rad, "deviation_rad": deviation_rad })
        }
        RotorChange::Other { order } => json!({ "kind": "other", "order": order }),
    };
    value["text"] = told(change).into();
    value
}
