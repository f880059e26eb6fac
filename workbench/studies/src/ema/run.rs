//! Trains and judges one draw of the campaign's experiments with the embedded detector.

use rayon::prelude::*;

use super::experiments::{Counted, Experiment, Group};
use super::recipe;
use super::record::cleaned;
use super::sets::{CLASSES, FACTOR, class_names, recorded_on};
use super::source;
use crate::campaign::{Purpose, SeedKey};
use crate::literal::Judged;
use crate::tables::chapter5::published::{CHAPTER_5, Published};
use model::Error;
use model::core::{Embedded, Finding};
use model::trace::Trace;
use model::trace::labels::LabelledTrace;
use model::train::train;
use rig::ema::{EmaCondition, Race};
use rig::{Defect, DefectKind};

/// Size of the campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Number of draws of training and validation sets.
    pub draws: u32,
    /// Number of the first draw; other numbers give other records.
    pub first: u32,
    /// Number of records per class and set.
    pub records: u32,
    /// The detector of a user who names no features, instead of [`super::recipe`]; without the source's method.
    pub default: bool,
}

/// The source's models of Tables 5.2 and 5.3: sine command against a load sine, as in MIX.
pub const MODELS: [Published; 2] = [CHAPTER_5[0], CHAPTER_5[1]];

/// Number of records with the counted outcome, and of all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// With the outcome.
    pub counted: usize,
    /// All.
    pub judged: usize,
}

/// One draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// One count for each experiment.
    pub counts: Vec<Count>,
    /// Decisions of the source's method in MIX on the same records, one for each of [`MODELS`]; none beside the
    /// default.
    pub source: Vec<Judged>,
}

/// A record for our method and for the source's, with u1 of each of [`MODELS`].
#[derive(Clone, Debug)]
struct Record {
    group: Group,
    ours: Trace,
    source: Vec<Trace>,
}

impl Record {
    /// Place of its class in [`CLASSES`]; that of healthy if it is none of them.
    fn class(&self) -> usize {
        self.group.class().unwrap_or(0)
    }
}

/// Verdict on a record.
#[derive(Clone, Copy, Debug)]
struct Verdict {
    /// `None` if undetermined.
    finding: Option<Finding>,
    /// The most plausible class.
    likeliest: Option<usize>,
}

const MIX: EmaCondition = EmaCondition::MIX;

/// Number of the first record of a spall of the outer race: its seeds are not those of the inner race.
const OUTER: u32 = 1 << 20;

/// Runs the experiments for one draw; `done` is called once per experiment.
///
/// # Errors
/// Returns an error if simulation, training or embedding fails.
pub fn draw(experiments: &[Experiment], (draw, settings): (u32, &Settings), done: impl Fn()) -> Result<Draw, Error> {
    let count = settings.records;
    let set = |condition: EmaCondition, purpose: Purpose| {
        records(&CLASSES.map(|defect| Group::new(condition, defect)), (purpose, draw, count))
    };
    let [training, validation] = [Purpose::Training, Purpose::Validation].map(|purpose| set(MIX, purpose));
    let (training, validation) = (training?, validation?);
    let judge = |trained_on: EmaCondition, set: &[Record]| -> Result<Judge<'_>, Error> {
        Ok(Judge { trained: trained_on, model: trained(set, settings)?, known: &validation, verdicts: vec![] })
    };
    let mut judges = vec![judge(MIX, &training)?];
    let mut counts = vec![];
    for experiment in experiments {
        if !judges.iter().any(|own| own.trained == experiment.trained) {
            judges.push(judge(experiment.trained, &set(experiment.trained, Purpose::Training)?)?);
        }
        if let Some(own) = judges.iter_mut().find(|own| own.trained == experiment.trained) {
            counts.push(own.count(experiment, (draw, count))?);
        }
        done();
    }
    let of = |set: &[Record], k: usize| -> Vec<(usize, Trace)> {
        set.iter().map(|record| (record.class(), record.source[k].clone())).collect()
    };
    let source = |(k, model): (usize, &Published)| {
        source::judge([&of(&training, k), &of(&validation, k)], &class_names(), model)
    };
    let models = MODELS.iter().enumerate().filter(|_| !settings.default);
    Ok(Draw { counts, source: models.map(source).collect::<Result<_, _>>()? })
}

/// The detector trained on these records.
fn trained(set: &[Record], settings: &Settings) -> Result<Embedded, Error> {
    let labelled = |record: &Record| LabelledTrace { trace: record.ours.clone(), class: record.class() };
    let set: Vec<LabelledTrace> = set.iter().map(labelled).collect();
    let recipe = if settings.default { recipe::by_default()? } else { recipe::recipe() };
    train(&set, &class_names(), &recipe)?.embed()
}

fn records(groups: &[Group], (purpose, draw, count): (Purpose, u32, u32)) -> Result<Vec<Record>, Error> {
    let jobs: Vec<(Group, u32)> = groups.iter().flat_map(|group| (0..count).map(move |k| (*group, k))).collect();
    jobs.par_iter().map(|(group, k)| record(group, seed(group, (purpose, draw, *k))?)).collect()
}

fn seed(group: &Group, (purpose, repetition, number): (Purpose, u32, u32)) -> Result<u64, Error> {
    let key = SeedKey { purpose, repetition, condition: group.condition.number, defect: group.defect };
    key.seed(if group.race == Race::Outer { OUTER + number } else { number })
}

fn record(group: &Group, seed: u64) -> Result<Record, Error> {
    let (scenario, recorded) = recorded_on(&group.condition, group.ema_defect(), seed)?;
    let ours = cleaned::<FACTOR>(&scenario, &recorded)?.into_trace(format!("{seed:016x}"));
    let source = MODELS.iter().map(|model| source::logged(&recorded, model.input)).collect();
    Ok(Record { group: *group, ours, source })
}

/// Verdicts of one trained detector on groups of records, each computed once.
struct Judge<'a> {
    trained: EmaCondition,
    model: Embedded,
    /// Records that exist already.
    known: &'a [Record],
    verdicts: Vec<(Group, Vec<Verdict>)>,
}

impl Judge<'_> {
    /// Counts the outcome over the groups of an experiment.
    fn count(&mut self, experiment: &Experiment, numbers: (u32, u32)) -> Result<Count, Error> {
        let mut sum = Count::default();
        for group in &experiment.judged {
            let verdicts = self.of(group, numbers)?;
            sum.judged += verdicts.len();
            sum.counted += verdicts.iter().filter(|own| is_counted(experiment.counted, **own, group.class())).count();
        }
        Ok(sum)
    }

    fn of(&mut self, group: &Group, (draw, count): (u32, u32)) -> Result<Vec<Verdict>, Error> {
        if let Some((_, verdicts)) = self.verdicts.iter().find(|(own, _)| own == group) {
            return Ok(verdicts.clone());
        }
        let known: Vec<&Record> = self.known.iter().filter(|record| record.group == *group).collect();
        let each = |k: u32| -> Result<Verdict, Error> {
            match known.get(k as usize) {
                Some(own) => Ok(verdict(&self.model, &own.ours)),
                None => Ok(verdict(&self.model, &record(group, seed(group, (Purpose::Validation, draw, k))?)?.ours)),
            }
        };
        let verdicts = (0..count).into_par_iter().map(each).collect::<Result<Vec<_>, _>>()?;
        self.verdicts.push((*group, verdicts.clone()));
        Ok(verdicts)
    }
}

fn verdict(model: &Embedded, trace: &Trace) -> Verdict {
    let (finding, posteriors) = model.combine(&model.run(trace)).unzip();
    let likeliest = posteriors.and_then(|all| (0..all.len()).max_by(|&i, &j| all[i].total_cmp(&all[j])));
    Verdict { finding, likeliest }
}

/// Whether a record has the counted outcome; without a verdict it is an error and detected.
fn is_counted(counted: Counted, Verdict { finding, likeliest }: Verdict, class: Option<usize>) -> bool {
    let healthy = finding == Some(Finding::Class(0));
    match counted {
        Counted::Error => likeliest != class,
        Counted::Misnamed => !healthy && finding.and_then(Finding::class).is_some_and(|found| Some(found) != class),
        Counted::CalledHealthy => healthy,
        Counted::Detected => !healthy,
    }
}

/// Decisions of the source's method by the size of the defects, under a condition whose log is that of Moog; the noise
/// of a record is the same at every size.
///
/// # Errors
/// Returns an error if simulation or estimation fails.
pub fn calibration(condition: &EmaCondition, severity: f64, (draw, count): (u32, u32)) -> Result<Judged, Error> {
    let set = |purpose: Purpose| -> Result<Vec<(usize, Trace)>, Error> {
        let kinds = CLASSES.iter().enumerate();
        let jobs: Vec<_> = kinds.flat_map(|class| (0..count).map(move |k| (class, k))).collect();
        let each = |&((class, defect), k): &((usize, &Defect), u32)| {
            let group = Group::new(*condition, *defect);
            let seed = seed(&group, (purpose, draw, k))?;
            let severity = if defect.kind == DefectKind::Healthy { 0.0 } else { severity };
            let sized = Group::new(*condition, Defect { severity, ..*defect });
            let (_, recorded) = recorded_on(condition, sized.ema_defect(), seed)?;
            Ok((class, source::logged(&recorded, MODELS[0].input)))
        };
        jobs.par_iter().map(each).collect()
    };
    source::judge([&set(Purpose::Selection)?, &set(Purpose::Reference)?], &class_names(), &MODELS[0])
}
