//! `bearing-watch simulate`

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rayon::prelude::*;

use super::output;
use crate::Error;
use crate::rig::{Condition, Defect, DefectKind, Duty, RigTrace, Scenario, Waveform, simulate, trace_seed};

/// Simulate traces of a rig: one CSV a trace, and labels.csv
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch simulate --rig dc --class healthy,spall,roughness --count 20 --seed 1 --out traces
  bearing-watch simulate --class spall,weak-magnet --severity 0.5 --condition frequency-2 --seed 2 --out other
  bearing-watch simulate --class healthy --condition mix --waveform square --seed 3 --out traces
  bearing-watch simulate --class healthy,spall --condition field-duties --seed 4 --out field

Names of traces tell class, severity (unless 1), condition (unless standard), waveform (where it is not a sine) and \
seed. Missing samples are NaN in all columns but t_s; without a load sensor there is no column load_torque_nm, and only with an effect of the temperature is there \
temperature_c. \
The same seed draws the same noise under every condition; take another one for traces to validate on.")]
pub(super) struct Args {
    /// Which rig
    #[arg(long, value_enum, default_value = "dc")]
    rig: Rig,
    /// Class of each trace: the defect, or healthy; several separated by commas
    #[arg(long, value_name = "NAMES", value_delimiter = ',', required = true, value_parser = classes())]
    class: Vec<DefectKind>,
    /// Traces of each class
    #[arg(long, default_value_t = 20)]
    count: u32,
    /// Seed; sets of different seeds never share a trace
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Size of the defect, 1 for full size
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    severity: f64,
    /// Condition that differs from the standard rig
    #[arg(long, value_name = "NAME", default_value = "standard", hide_default_value = true, value_parser = conditions())]
    condition: Condition,
    /// Shape of the velocity reference [default: sine, or that of the condition]
    #[arg(long, value_name = "SHAPE", value_parser = waveforms())]
    waveform: Option<Waveform>,
    /// Resolution of the recorded angle, bits of a turn [default: exact, or that of the condition]
    #[arg(long, value_name = "BITS")]
    angle_bits: Option<u32>,
    /// Short for --condition mix
    #[arg(long, conflicts_with = "condition")]
    mix: bool,
    /// Folder for the traces; created if absent. Traces and labels of the same name are replaced, others are kept
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Rig {
    /// PM DC motor under velocity control (thesis Fig. 3.1)
    Dc,
}

/// Returns a parser for the name of one of `choices`: name, note for the help, value.
fn one_of<T>(choices: Vec<(&'static str, &'static str, T)>) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    let values = choices.iter().map(|(name, about, _)| PossibleValue::new(*name).help(*about));
    PossibleValuesParser::new(values).try_map(move |given| {
        let choice = choices.iter().find(|(name, _, _)| *name == given);
        choice.map(|(_, _, value)| *value).ok_or_else(|| format!("no such choice: {given}"))
    })
}

fn classes() -> impl TypedValueParser<Value = DefectKind> {
    one_of(DefectKind::ALL.map(|kind| (kind.name(), kind.about(), kind)).to_vec())
}

fn conditions() -> impl TypedValueParser<Value = Condition> {
    one_of(Condition::all().map(|condition| (condition.name, condition.about, condition)).collect())
}

fn waveforms() -> impl TypedValueParser<Value = Waveform> {
    one_of(Waveform::ALL.map(|shape| (shape.name(), shape.about(), shape)).to_vec())
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let Rig::Dc = args.rig;
    let jobs: Vec<(DefectKind, u32)> =
        args.class.iter().flat_map(|&kind| (0..args.count).map(move |k| (kind, k))).collect();
    if jobs.is_empty() {
        return Err(Error::Usage("--count 0 makes no traces; give at least 1".into()));
    }
    let condition = args.condition();
    let shaped = condition.reference_waveform.is_some() || condition.duty.is_some();
    if shaped && args.waveform.is_some() {
        let name = condition.name;
        return Err(Error::Usage(format!("--condition {name} sets the reference already; leave out --waveform")));
    }
    for (k, kind) in args.class.iter().enumerate() {
        if args.class[..k].contains(kind) {
            return Err(Error::Usage(format!("--class names {} twice", kind.name())));
        }
        args.scenario(*kind, 0).validate()?;
    }
    let labels = args.out.join("labels.csv");
    let old = old_labels(&labels)?;
    std::fs::create_dir_all(&args.out).map_err(Error::io(&args.out))?;
    let bar = output::progress("simulating", jobs.len());
    let rows = jobs
        .par_iter()
        .map(|&(kind, k)| {
            let seed = trace_seed(args.seed, kind, k);
            let scenario = args.scenario(kind, seed);
            let name = format!("{}_{}_{k:03}.csv", args.stem(kind), args.seed);
            output::write(&args.out.join(&name), csv(&simulate(&scenario, seed)?))?;
            bar.inc(1);
            let severity = if kind == DefectKind::Healthy { 0.0 } else { args.severity };
            let shape = reference_name(&scenario, seed);
            let [severity, seed] = [severity.to_string(), args.seed.to_string()];
            Ok([name, kind.name().into(), severity, seed, condition.name.into(), shape.into()])
        })
        .collect::<Result<Vec<_>, Error>>()?;
    bar.finish_and_clear();
    write_labels(&labels, &old, &rows)?;
    output::say(format!("{} traces and labels.csv in {}", rows.len(), args.out.display()))
}

/// Returns the name of the velocity reference of a trace.
fn reference_name(scenario: &Scenario, seed: u64) -> &'static str {
    match scenario.duty.of_record(seed) {
        Duty::Waveform => scenario.reference_waveform.name(),
        duty => duty.name(),
    }
}

impl Args {
    fn condition(&self) -> Condition {
        if self.mix { Condition::MIX } else { self.condition }
    }

    fn scenario(&self, kind: DefectKind, seed: u64) -> Scenario {
        let rig = Scenario { angle_bits: self.angle_bits, ..Scenario::STANDARD };
        let standard = rig.with_defect(Defect { kind, severity: self.severity });
        let scenario = self.condition().apply(standard, seed);
        Scenario { reference_waveform: self.waveform.unwrap_or(scenario.reference_waveform), ..scenario }
    }

    /// Returns the file name of the traces of one class, without seed and number.
    fn stem(&self, kind: DefectKind) -> String {
        let mut parts = vec![kind.name().to_string()];
        if kind != DefectKind::Healthy && self.severity != 1.0 {
            parts.push(self.severity.to_string());
        }
        let condition = self.condition();
        if condition != Condition::STANDARD {
            parts.push(condition.name.into());
        }
        parts.extend(self.waveform.filter(|shape| *shape != Waveform::Sine).map(|shape| shape.name().into()));
        parts.join("_")
    }
}

/// Returns the trace as CSV. Nine significant digits are far finer than the noise, and keep the files small.
fn csv(trace: &RigTrace) -> String {
    let columns = trace.recorded();
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let mut out = names.join(",") + "\n";
    for k in 0..trace.len() {
        let cells = columns.iter().map(|(_, column)| {
            let digits = format!("{:.8e}", column[k]);
            digits.parse::<f64>().map_or(digits, |rounded| rounded.to_string())
        });
        let cells: Vec<String> = cells.collect();
        out.push_str(&cells.join(","));
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
