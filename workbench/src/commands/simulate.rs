//! `bearing-watch simulate`

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use rayon::prelude::*;

use super::output;
use crate::Error;
use crate::rig::{Defect, DefectKind, RigTrace, Scenario, simulate, trace_seed};

/// Simulate traces of a rig: one CSV a trace, and labels.csv
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch simulate --rig dc --class healthy,spall,roughness --count 20 --seed 1 --out traces"
)]
pub(super) struct Args {
    /// Which rig
    #[arg(long, value_enum, default_value = "dc")]
    rig: Rig,
    /// Condition of the bearing; several separated by commas
    #[arg(long, value_name = "NAMES", value_delimiter = ',', required = true)]
    class: Vec<Class>,
    /// Traces of each class
    #[arg(long, default_value_t = 20)]
    count: u32,
    /// Seed; sets of different seeds never share a trace
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Size of the defect, 1 for full size
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    severity: f64,
    /// Draw reference, load, resistance and inertia anew for each trace
    #[arg(long)]
    mix: bool,
    /// Folder for the traces; made if absent. Traces and labels of the same name are replaced, others stay
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Rig {
    /// PM DC motor under velocity control (thesis Fig. 3.1)
    Dc,
}

/// Names as the labels carry them.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Class {
    Healthy,
    /// Single-point defect of the outer race
    Spall,
    /// Raised viscous friction: lost lubrication
    Roughness,
    /// Coulomb friction of a spall's mean torque: the control for isolation
    Coulomb,
}

impl Class {
    fn kind(self) -> DefectKind {
        match self {
            Self::Healthy => DefectKind::Healthy,
            Self::Spall => DefectKind::Spall,
            Self::Roughness => DefectKind::Roughness,
            Self::Coulomb => DefectKind::Coulomb,
        }
    }
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let Rig::Dc = args.rig;
    let jobs: Vec<(Class, u32)> =
        args.class.iter().flat_map(|&class| (0..args.count).map(move |k| (class, k))).collect();
    if jobs.is_empty() {
        return Err(Error::Usage("--count 0 makes no traces; give at least 1".into()));
    }
    for (k, class) in args.class.iter().enumerate() {
        if args.class[..k].iter().any(|other| other.kind() == class.kind()) {
            return Err(Error::Usage(format!("--class names {} twice", class.kind().name())));
        }
        args.scenario(*class).validate()?;
    }
    let labels = args.out.join("labels.csv");
    let old = old_labels(&labels)?;
    std::fs::create_dir_all(&args.out).map_err(Error::io(&args.out))?;
    let bar = output::progress("simulating", jobs.len());
    let rows = jobs
        .par_iter()
        .map(|&(class, k)| {
            let kind = class.kind();
            let seed = trace_seed(args.seed, kind, k);
            let scenario = args.scenario(class);
            let scenario = if args.mix { scenario.mixed(seed) } else { scenario };
            let name = format!("{}_{}_{k:03}.csv", kind.name(), args.seed);
            output::write(&args.out.join(&name), csv(&simulate(&scenario, seed)?))?;
            bar.inc(1);
            let severity = if kind == DefectKind::Healthy { 0.0 } else { args.severity };
            Ok([name, kind.name().into(), severity.to_string(), args.seed.to_string()])
        })
        .collect::<Result<Vec<_>, Error>>()?;
    bar.finish_and_clear();
    write_labels(&labels, &old, &rows)?;
    output::say(format!("{} traces and labels.csv in {}", rows.len(), args.out.display()))
}

impl Args {
    fn scenario(&self, class: Class) -> Scenario {
        Scenario::STANDARD.with_defect(Defect { kind: class.kind(), severity: self.severity })
    }
}

/// Nine significant digits: far below the noise, and small files.
fn csv(trace: &RigTrace) -> String {
    let mut out = String::from("t_s,velocity_ref_rad_s,velocity_rad_s,current_a,load_torque_nm,angle_rad\n");
    let columns = [
        &trace.t_s,
        &trace.velocity_ref_rad_s,
        &trace.velocity_rad_s,
        &trace.current_a,
        &trace.load_torque_nm,
        &trace.angle_rad,
    ];
    for k in 0..trace.len() {
        let cells = columns.map(|column| {
            let digits = format!("{:.8e}", column[k]);
            digits.parse::<f64>().map_or(digits, |rounded| rounded.to_string())
        });
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    out
}

const HEADER: &str = "trace,class_name,severity,seed";

/// Rows of the labels that are there already.
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
fn write_labels(path: &Path, old: &[String], rows: &[[String; 4]]) -> Result<(), Error> {
    let replaced = |line: &str| rows.iter().any(|row| line.split(',').next() == Some(row[0].as_str()));
    let kept = old.iter().filter(|line| !replaced(line)).cloned();
    let lines: Vec<String> =
        std::iter::once(HEADER.to_string()).chain(kept).chain(rows.iter().map(|row| row.join(","))).collect();
    output::write(path, lines.join("\n") + "\n")
}
