//! Traces of the EMA rig.

use super::conditions::Chosen;
use super::experiment::{Experiment, Simulated, table};
use super::options::Simulation;
use model::Error;
use model::trace::FrontEndFile;
use model::trace::front_end::FACTORS;
use rig::DefectKind;
use rig::ema::{EmaCondition, EmaDefect, EmaScenario, Logging, Race, simulate};

/// What the options choose on the EMA rig.
#[derive(Debug)]
pub(super) struct Ema {
    chosen: Chosen,
    condition: EmaCondition,
    severity: f64,
    race: Race,
    log_every: Option<u32>,
}

impl Ema {
    pub(super) fn new(args: &Simulation) -> Result<Self, Error> {
        let refused = |message: String| Err(Error::Usage(message));
        if args.waveform.is_some() {
            return refused("--rig ema takes its command from --condition; leave out --waveform".into());
        }
        if args.angle_bits.is_some() {
            return refused("--rig ema has a resolver of 14 bits; leave out --angle-bits".into());
        }
        if args.log_every == Some(0) {
            return refused("--log-every 0 records nothing; give at least 1".into());
        }
        let chosen = Chosen::new(args)?;
        let name = chosen.rig;
        let Some(condition) = EmaCondition::named(name) else {
            let names = EmaCondition::ALL.map(|condition| condition.name).join(", ");
            return refused(format!("--condition {name} belongs to the DC-motor rig; the EMA rig has {names}"));
        };
        let race = args.race.unwrap_or(Race::Inner);
        Ok(Self { chosen, condition, severity: args.severity, race, log_every: args.log_every })
    }

    fn scenario(&self, kind: DefectKind, seed: u64) -> EmaScenario {
        let scenario = self.condition.scenario(seed).with_defect(EmaDefect::of(kind, self.severity, self.race));
        let Chosen { parts, axis, .. } = &self.chosen;
        let scenario = if parts.is_empty() { scenario } else { scenario.on_axis(parts, *axis) };
        match self.log_every {
            Some(every) => scenario.logged(Logging { every, hold: 1 }),
            None => scenario,
        }
    }
}

impl Experiment for Ema {
    fn validate(&self, kind: DefectKind) -> Result<(), Error> {
        self.scenario(kind, 0).validate().map_err(Error::other)
    }

    fn condition(&self) -> &str {
        &self.chosen.name
    }

    fn prefix(&self, kind: DefectKind) -> Option<&'static str> {
        let spalled = matches!(kind, DefectKind::Spall | DefectKind::SpallAndRoughness);
        Some(if spalled && self.race == Race::Outer { "ema-outer" } else { "ema" })
    }

    fn suffix(&self) -> Option<&'static str> {
        None
    }

    fn front_end(&self) -> Option<FrontEndFile> {
        let text = self.scenario(DefectKind::Healthy, 0).front_end_toml(&FACTORS)?;
        FrontEndFile::parse(&text).ok()
    }

    fn simulate(&self, kind: DefectKind, seed: u64) -> Result<Simulated, Error> {
        let scenario = self.scenario(kind, seed);
        let table = table(simulate(&scenario, seed).map_err(Error::other)?.recorded());
        Ok(Simulated { table, shape: scenario.shape() })
    }
}
