//! `bearing-watch simulate`

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::command_line::options::Own;
use crate::command_line::output;
use model::Error;
use rig::DefectKind;
use studies::simulation::{Set, Simulation, Table};

/// Simulate traces of a rig: one CSV a trace, and labels.csv
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch simulate --rig dc --class healthy,spall,roughness --count 20 --seed 1 --out traces
  bearing-watch simulate --class spall,weak-magnet --severity 0.5 --condition frequency-2 --seed 2 --out other
  bearing-watch simulate --class healthy --condition mix --waveform square --seed 3 --out traces
  bearing-watch simulate --class healthy,spall --condition field-duties --seed 4 --out field
  bearing-watch simulate --class healthy,spall --condition gravity,gear,brake,cycle --ratio 100 --seed 5 --out arm
  bearing-watch simulate --rig ema --class healthy,spall-and-roughness --condition moog-1-mix --out moog

Names of traces tell class, severity (unless 1), condition (unless standard), waveform (where it is not a sine) and \
seed. Missing samples are NaN in all columns but t_s; without a load sensor there is no column \
load_torque_nm, and only with an effect of the temperature is there temperature_c. \
Parts of an axis (gravity, gear, belt, brake, payload-steps, cycle, any-cycle) combine, on top of mix or of one other \
condition. They have no load sensor, unless the other condition has one with errors, and the columns ratio, axis_rad, \
weight_nm (at the motor), payload (1 nominal) and brake_closed say what the axis was; a drive knows the first two. \
The same seed draws the same noise under every condition; take another one for traces to validate on.

Traces of the EMA rig start with ema (ema-outer for a spall of the outer race). They have the position command and the \
measured position, the velocity command, the q and d currents from the phase currents and the resolver (current_a, \
current_d_a; positive drives forward), the phase currents, resolver_counts, load_n, and the commanded dq voltages. \
With rows at 1 kHz or more and no held values (--log-every 1) there is front_end.toml, for --front-end. \
standard and mix are those of the chosen rig. roughness is lost lubrication, and spall-and-roughness is the degraded \
actuator of the thesis.")]
pub(crate) struct Args {
    #[command(flatten)]
    options: Own<Simulation>,
    /// Folder for the traces; created if absent. Traces and labels of the same name are replaced, others are kept
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let options = &args.options.0;
    let set = Set::new(options)?;
    let labels = args.out.join("labels.csv");
    let old = old_labels(&labels)?;
    std::fs::create_dir_all(&args.out).map_err(Error::io(&args.out))?;
    let bar = output::progress("simulating", set.jobs().len());
    let each = |(kind, k)| {
        let (name, simulated) = set.simulate(kind, k)?;
        let name = format!("{name}.csv");
        output::write(&args.out.join(&name), csv(&simulated.table))?;
        bar.inc(1);
        let severity = if kind == DefectKind::Healthy { 0.0 } else { options.severity };
        let [severity, seed] = [severity.to_string(), options.seed.to_string()];
        Ok([name, kind.name().into(), severity, seed, set.condition().to_string(), simulated.shape.into()])
    };
    let rows = set.jobs().into_par_iter().map(each).collect::<Result<Vec<_>, Error>>()?;
    bar.finish_and_clear();
    write_labels(&labels, &old, &rows)?;
    if let Some(front_end) = set.front_end() {
        let text = front_end.to_text().map_err(|error| Error::Usage(format!("front_end.toml: {error}")))?;
        output::write(&args.out.join("front_end.toml"), text)?;
    }
    output::say(format!("{} traces and labels.csv in {}", rows.len(), args.out.display()))
}

/// Usual length of a cell with its comma.
const CELL: usize = 13;

/// Returns columns of the same length as CSV.
fn csv(columns: &Table) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let rows = columns.first().map_or(0, |(_, column)| column.len());
    let mut out = names.join(",");
    out.push('\n');
    // Without a string for each cell, which would take half the time of a simulation.
    out.reserve(CELL * columns.len() * rows);
    for k in 0..rows {
        for (place, (_, column)) in columns.iter().enumerate() {
            if place > 0 {
                out.push(',');
            }
            let _string_grows = write!(out, "{}", column[k]);
        }
        out.push('\n');
    }
    out
}

const HEADER: &str = "trace,class_name,severity,seed,condition,waveform";

/// Returns the rows of an existing labels file; none if the file is absent.
fn old_labels(path: &Path) -> Result<Vec<String>, Error> {
    if !path.exists() {
        return Ok(vec![]);
    }
    let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
    let mut lines = text.lines();
    if lines.next() != Some(HEADER) {
        return Err(Error::content(path, "line 1", "not labels of simulated traces; choose another --out"));
    }
    Ok(lines.filter(|line| !line.is_empty()).map(String::from).collect())
}

/// Writes the labels of a folder; old rows of the same traces are replaced.
fn write_labels(path: &Path, old: &[String], rows: &[[String; 6]]) -> Result<(), Error> {
    let replaced = |line: &str| rows.iter().any(|row| line.split(',').next() == Some(row[0].as_str()));
    let kept = old.iter().filter(|line| !replaced(line)).cloned();
    let lines: Vec<String> =
        std::iter::once(HEADER.to_string()).chain(kept).chain(rows.iter().map(|row| row.join(","))).collect();
    output::write(path, lines.join("\n") + "\n")
}
