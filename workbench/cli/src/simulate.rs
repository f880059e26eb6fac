//! `bearing-watch simulate`

mod choices;
mod dc;
mod ema;
mod files;

use std::path::PathBuf;

use clap::ValueEnum;
use rayon::prelude::*;

use super::output;
use model::Error;
use model::trace::{Cells, FrontEndFile, Recorded};
use rig::ema::Race;
use rig::{DefectKind, Waveform, trace_seed};

/// Simulate traces of a rig: one CSV a trace, and labels.csv
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch simulate --rig dc --class healthy,spall,roughness --count 20 --seed 1 --out traces
  bearing-watch simulate --class spall,weak-magnet --severity 0.5 --condition frequency-2 --seed 2 --out other
  bearing-watch simulate --class healthy --condition mix --waveform square --seed 3 --out traces
  bearing-watch simulate --class healthy,spall --condition field-duties --seed 4 --out field
  bearing-watch simulate --rig ema --class healthy,spall-and-roughness --condition moog-1-mix --out moog

Names of traces tell class, severity (unless 1), condition (unless standard), waveform (where it is not a sine) and \
seed. Missing samples are NaN in all columns but t_s; without a load sensor there is no column \
load_torque_nm, and only with an effect of the temperature is there temperature_c. \
The same seed draws the same noise under every condition; take another one for traces to validate on.

Traces of the EMA rig start with ema (ema-outer for a spall of the outer race). They have the position command and the \
measured position, the velocity command, the q and d currents from the phase currents and the resolver (current_a, \
current_d_a; positive drives forward), the phase currents, resolver_counts, load_n, and the commanded dq voltages. \
With rows at 1 kHz or more and no held values (--log-every 1) there is front_end.toml, for --front-end. \
standard and mix are those of the chosen rig. roughness is lost lubrication, and spall-and-roughness is the degraded \
actuator of the thesis.")]
pub(super) struct Args {
    #[command(flatten)]
    choice: Choice,
    /// Folder for the traces; created if absent. Traces and labels of the same name are replaced, others are kept
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Which traces are simulated.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct Choice {
    /// Which rig
    #[arg(long, value_enum, default_value = "dc")]
    rig: Rig,
    /// Class of each trace: the defect, or healthy; several separated by commas
    #[arg(long, value_name = "NAMES", value_delimiter = ',', required = true, value_parser = choices::classes())]
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
    #[arg(long, value_name = "NAME", default_value = "standard", hide_default_value = true,
        value_parser = choices::conditions())]
    condition: &'static str,
    /// Shape of the velocity reference [default: sine, or that of the condition]
    #[arg(long, value_name = "SHAPE", value_parser = choices::waveforms())]
    waveform: Option<Waveform>,
    /// Resolution of the recorded angle, bits of a turn [default: exact, or that of the condition]
    #[arg(long, value_name = "BITS")]
    angle_bits: Option<u32>,
    /// Race with the spall, EMA rig only [default: inner]
    #[arg(long, value_name = "RACE", value_parser = choices::races())]
    race: Option<Race>,
    /// Record every Nth control interval (1/12 000 s; of the RIT rig 1/10 000 s) for the same time, without holding
    /// values; EMA rig only [default: that of the condition]
    #[arg(long, value_name = "N")]
    log_every: Option<u32>,
    /// Short for --condition mix
    #[arg(long, conflicts_with = "condition")]
    mix: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Rig {
    /// PM DC motor under velocity control (thesis Fig. 3.1)
    Dc,
    /// Electromechanical actuator under position control (thesis chapter 5)
    Ema,
}

/// A simulated trace.
struct Simulated {
    table: files::Table,
    /// Shape of the reference.
    shape: &'static str,
}

/// The experiment that the options choose on one rig.
trait Experiment: Sync {
    /// Returns an error if traces of this class cannot be simulated.
    fn validate(&self, kind: DefectKind) -> Result<(), Error>;
    /// Name of the condition.
    fn condition(&self) -> &'static str;
    /// First part of the file names of a class, before its name.
    fn prefix(&self, kind: DefectKind) -> Option<&'static str>;
    /// Last part of the file names of a class.
    fn suffix(&self) -> Option<&'static str>;
    /// The front end of the traces, if they are raw samples.
    fn front_end(&self) -> Option<FrontEndFile>;
    /// Simulates one trace.
    fn simulate(&self, kind: DefectKind, seed: u64) -> Result<Simulated, Error>;
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let (choice, experiment) = (&args.choice, args.choice.experiment()?);
    let labels = args.out.join("labels.csv");
    let old = files::old_labels(&labels)?;
    std::fs::create_dir_all(&args.out).map_err(Error::io(&args.out))?;
    let bar = output::progress("simulating", choice.jobs().len());
    let each = |(kind, k)| {
        let (name, simulated) = choice.simulate(experiment.as_ref(), kind, k)?;
        let name = format!("{name}.csv");
        output::write(&args.out.join(&name), files::csv(&simulated.table))?;
        bar.inc(1);
        let severity = if kind == DefectKind::Healthy { 0.0 } else { choice.severity };
        let [severity, seed] = [severity.to_string(), choice.seed.to_string()];
        Ok([name, kind.name().into(), severity, seed, experiment.condition().into(), simulated.shape.into()])
    };
    let rows = choice.jobs().into_par_iter().map(each).collect::<Result<Vec<_>, Error>>()?;
    bar.finish_and_clear();
    files::write_labels(&labels, &old, &rows)?;
    if let Some(front_end) = experiment.front_end() {
        let text = front_end.to_text().map_err(|error| Error::Usage(format!("front_end.toml: {error}")))?;
        output::write(&args.out.join("front_end.toml"), text)?;
    }
    output::say(format!("{} traces and labels.csv in {}", rows.len(), args.out.display()))
}

impl Choice {
    /// The experiment, once every class can be simulated.
    fn experiment(&self) -> Result<Box<dyn Experiment>, Error> {
        if self.jobs().is_empty() {
            return Err(Error::Usage("--count 0 makes no traces; give at least 1".into()));
        }
        let experiment: Box<dyn Experiment> = match self.rig {
            Rig::Dc => Box::new(dc::Dc::new(self)?),
            Rig::Ema => Box::new(ema::Ema::new(self)?),
        };
        for (k, kind) in self.class.iter().enumerate() {
            if self.class[..k].contains(kind) {
                return Err(Error::Usage(format!("--class names {} twice", kind.name())));
            }
            experiment.validate(*kind)?;
        }
        Ok(experiment)
    }

    /// Class and number of each trace.
    fn jobs(&self) -> Vec<(DefectKind, u32)> {
        self.class.iter().flat_map(|&kind| (0..self.count).map(move |k| (kind, k))).collect()
    }

    /// Simulates one trace, and returns its name.
    fn simulate(&self, experiment: &dyn Experiment, kind: DefectKind, k: u32) -> Result<(String, Simulated), Error> {
        let simulated = experiment.simulate(kind, trace_seed(self.seed, kind, k))?;
        Ok((format!("{}_{}_{k:03}", self.stem(experiment, kind), self.seed), simulated))
    }

    /// Simulates all traces in memory, and returns their classes too.
    pub(super) fn tables(&self) -> Result<Vec<(Recorded, &'static str)>, Error> {
        let experiment = self.experiment()?;
        let each = |(kind, k): (DefectKind, u32)| {
            let (name, simulated) = self.simulate(experiment.as_ref(), kind, k)?;
            let column = |(name, column): (&str, Vec<f64>)| (name.to_string(), Cells::Numbers(column));
            Ok((Recorded::new(name, simulated.table.into_iter().map(column).collect())?, kind.name()))
        };
        self.jobs().into_par_iter().map(each).collect()
    }

    const fn condition_name(&self) -> &'static str {
        if self.mix { "mix" } else { self.condition }
    }

    /// Returns the file name of the traces of one class, without seed and number.
    fn stem(&self, experiment: &dyn Experiment, kind: DefectKind) -> String {
        let mut parts: Vec<String> = experiment.prefix(kind).map(String::from).into_iter().collect();
        parts.push(kind.name().into());
        if kind != DefectKind::Healthy && self.severity != 1.0 {
            parts.push(self.severity.to_string());
        }
        if experiment.condition() != "standard" {
            parts.push(experiment.condition().into());
        }
        parts.extend(experiment.suffix().map(String::from));
        parts.join("_")
    }
}
