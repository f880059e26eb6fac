//! Traces of the DC-motor rig.

use super::conditions::Chosen;
use super::experiment::{Experiment, Simulated, table};
use super::options::Simulation;
use model::Error;
use model::trace::FrontEndFile;
use rig::{Condition, Defect, DefectKind, Duty, Scenario, Waveform, simulate};

/// What the options choose on the DC-motor rig.
#[derive(Debug)]
pub(super) struct Dc {
    chosen: Chosen,
    condition: Condition,
    severity: f64,
    waveform: Option<Waveform>,
    angle_bits: Option<u32>,
}

impl Dc {
    pub(super) fn new(args: &Simulation) -> Result<Self, Error> {
        let refused = |option: &str| {
            Err(Error::Usage(format!("{option} belongs to the EMA rig; add --rig ema, or leave {option} out")))
        };
        if args.race.is_some() {
            return refused("--race");
        }
        if args.log_every.is_some() {
            return refused("--log-every");
        }
        let chosen = Chosen::new(args)?;
        let Some(condition) = Condition::named(chosen.rig) else {
            return Err(Error::Usage(format!("--condition {} belongs to the EMA rig; add --rig ema", chosen.rig)));
        };
        let moves = condition.reference_waveform.is_some() || condition.duty.is_some();
        chosen.refuse_rivals(condition.axis, moves)?;
        let name = &chosen.name;
        if (moves || chosen.has_motion()) && args.waveform.is_some() {
            return Err(Error::Usage(format!("--condition {name} sets the reference already; leave out --waveform")));
        }
        Ok(Self { chosen, condition, severity: args.severity, waveform: args.waveform, angle_bits: args.angle_bits })
    }

    fn scenario(&self, kind: DefectKind, seed: u64) -> Scenario {
        let rig = Scenario { angle_bits: self.angle_bits, ..Scenario::STANDARD };
        let standard = rig.with_defect(Defect { kind, severity: self.severity });
        let scenario = self.condition.apply(standard, seed);
        let Chosen { parts, axis, .. } = &self.chosen;
        let scenario = if parts.is_empty() { scenario } else { scenario.on_axis(parts, *axis) };
        Scenario { reference_waveform: self.waveform.unwrap_or(scenario.reference_waveform), ..scenario }
    }
}

impl Experiment for Dc {
    fn validate(&self, kind: DefectKind) -> Result<(), Error> {
        self.scenario(kind, 0).validate().map_err(Error::other)
    }

    fn condition(&self) -> &str {
        &self.chosen.name
    }

    fn prefix(&self, _kind: DefectKind) -> Option<&'static str> {
        None
    }

    fn suffix(&self) -> Option<&'static str> {
        self.waveform.filter(|shape| *shape != Waveform::Sine).map(Waveform::name)
    }

    fn front_end(&self) -> Option<FrontEndFile> {
        None
    }

    fn simulate(&self, kind: DefectKind, seed: u64) -> Result<Simulated, Error> {
        let scenario = self.scenario(kind, seed);
        let table = table(simulate(&scenario, seed).map_err(Error::other)?.recorded());
        Ok(Simulated { table, shape: reference_name(&scenario, seed) })
    }
}

/// Returns the name of the velocity reference of a trace.
fn reference_name(scenario: &Scenario, seed: u64) -> &'static str {
    match scenario.duty.of_record(seed) {
        Duty::Waveform => scenario.reference_waveform.name(),
        duty => duty.name(),
    }
}
