//! `bearing-watch train`

use std::path::PathBuf;

use bearing_watch::Park;
use bearing_watch::model::MAX_BLOCK_MEAN;
use bearing_watch::plan::Kind;
use bearing_watch::plan::Method;
use clap::ValueEnum;
use serde_json::json;

use super::args::alarms::AlarmArgs;
use super::args::estimation::EstimationArgs;
use super::args::odds::{costs, priors};
use super::args::shaft::ShaftArgs;
use super::args::traces::{
    ChannelArgs, Groups, PreparationArgs, Selection, SelectionArgs, StructureArgs, ValidationArgs, warn_irregular,
    warn_refused,
};
use super::description::{self, estimated_by, method_word};
use super::evidence::{self, Orders};
use super::model_file::{Notes, check_rate, prepare};
use super::output;
use crate::Error;
use crate::core::features;
use crate::evaluate::{self, Confusion, FalseAlarms, Rate};
use crate::report::pages::model::{self, Worth};
use crate::trace::labels::LabelledTrace;
use crate::trace::{Channels, Condition, FrontEndFile, Preparation};
use crate::train::c_header::c_header;
use crate::train::commissioning_source::commissioning_source;
use crate::train::front_end_source::front_end_source;
use crate::train::{
    Choice, Explained, Forward, Keep, ProjectionKind, Ranking, Recipe, Scores, ShaftPlan, Shrink, Shrinkage, Trained,
    Validation, VelocitySource, export,
};

/// Train a model from labelled traces, for the detector in firmware
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch train --labels traces/labels.csv --y current_a --u1 velocity_ref_rad_s \
--u2 load_torque_nm --order 2,1,2,1,1 --model model.bwm --rust model.rs"
)]
pub(super) struct Args {
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    channels: ChannelArgs,
    #[command(flatten)]
    structure: StructureArgs,
    #[command(flatten)]
    estimation: EstimationArgs,
    #[command(flatten)]
    shaft: ShaftArgs,
    #[command(flatten)]
    preparation: PreparationArgs,
    /// Train on the rows with this, e.g. 'run<=4'; may be repeated, all must hold
    #[arg(long, value_name = "CONDITION")]
    train_where: Vec<Condition>,
    /// Then evaluate on the rows with this, e.g. 'run>4'
    #[arg(long, value_name = "CONDITION")]
    test_where: Vec<Condition>,
    /// a, b, c, offset, log_variance, friction, friction_scores, friction_logs, orders, or single ones such as a1,
    /// viscous_score, viscous_log or order_outer; mean_CHANNEL or rms_CHANNEL of any column; every parameter if not
    /// given
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    features: Vec<String>,
    /// Features that explain a part of the others in healthy traces, e.g. mean_temperature_c: that part is subtracted;
    /// outside the range of the healthy traces, what they explain is missing
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    covariates: Vec<String>,
    /// Features that a defect only raises, e.g. viscous: the gate judges them upwards only, given the others, as it
    /// does with the scores of orders
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    rising: Vec<String>,
    /// Projection of the features
    #[arg(long, value_enum, default_value = "none")]
    projection: Projection,
    /// Components to keep (pca, pca-raw, fisher)
    #[arg(long, value_name = "N")]
    components: Option<usize>,
    /// Part of the variance to keep if --components is not given (pca, pca-raw)
    #[arg(long, value_name = "PART", default_value_t = 0.99)]
    variance: f64,
    /// Class covariances: shared, separate, or between the two
    #[arg(long, value_enum, default_value = "linear")]
    discriminant: DiscriminantKind,
    /// Fixed shrinkage of class covariances instead: towards the shared one, and of their correlations, each 0 to 1
    #[arg(long, value_name = "SHARED,DIAGONAL", value_delimiter = ',', num_args = 1, conflicts_with = "discriminant")]
    shrinkage: Vec<f64>,
    /// Relative deviation of a defect's size from that in training, e.g. 0.25: classes reach towards the healthy one,
    /// so that smaller defects keep their name; needs --healthy and separate covariances
    #[arg(long, value_name = "PART", default_value_t = 0.0)]
    size_spread: f64,
    /// Priors, e.g. healthy=0.98,spall=0.01,roughness=0.01; equal if not given
    #[arg(long, value_name = "CLASS=P", value_delimiter = ',')]
    priors: Vec<String>,
    /// Cost of deciding a class when another is true, e.g. healthy:spall=50; 1 if not given
    #[arg(long, value_name = "DECIDED:TRUE=COST", value_delimiter = ',')]
    cost: Vec<String>,
    /// Sign convention of the quadrature current in the recordings; the model then refuses a front end that differs
    #[arg(long, value_enum)]
    park: Option<ParkConvention>,
    #[command(flatten)]
    validation: ValidationArgs,
    /// Rank the features (those of --features, or all): Fisher ratios, cross-validated gains, and what to drop
    #[arg(long)]
    rank: bool,
    #[command(flatten)]
    alarms: AlarmArgs,
    /// The binary model
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// The model as Rust constants
    #[arg(long, value_name = "FILE")]
    rust: Option<PathBuf>,
    /// With --rust, also the constants for `Model::commissioning` with so many healthy segments of a drive
    #[arg(long, value_name = "SEGMENTS", requires = "rust", value_parser = clap::value_parser!(u32).range(2..=10_000))]
    commissioning: Option<u32>,
    /// The model as a C header, for the library of `c-api`
    #[arg(long, value_name = "FILE")]
    c: Option<PathBuf>,
    /// A page with the features, the decision regions and the held-out result
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Projection {
    /// Every feature, scaled
    None,
    /// Principal components of the standardised features
    Pca,
    /// Principal components of the centred features, as in the source
    PcaRaw,
    /// Fisher's directions: largest spread between classes relative to the spread within them
    Fisher,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ParkConvention {
    /// With the angle on the magnet axis, positive q current produces positive torque
    Standard,
    /// The +sin row of the source's Eq. 5.1
    Thesis,
}

impl ParkConvention {
    const fn core(self) -> Park {
        match self {
            Self::Standard => Park::Standard,
            Self::Thesis => Park::Thesis,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum DiscriminantKind {
    /// One covariance for all classes
    Linear,
    /// A separate covariance for each class
    Quadratic,
    /// Between the two and a diagonal, by the best cross-validated log score
    Shrunk,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    args.channels.require(args.structure.structure())?;
    let mut channels = args.channels.channels()?;
    let (shaft_channels, plan) = args.shaft.shaft(&channels.y)?.unzip();
    channels.shaft = shaft_channels;
    let preparation = args.preparation.preparation()?;
    channels = args.with_averaged_columns(channels, plan.as_ref(), preparation)?;
    if args.variance.is_nan() || args.variance <= 0.0 || args.variance > 1.0 {
        return Err(Error::Usage("--variance is a part of the whole: above 0, at most 1".into()));
    }
    let selection = args.selection.read(&channels)?;
    let files = [Some(args.model.as_path()), args.rust.as_deref(), args.c.as_deref(), args.report.as_deref()];
    output::plan(&files.into_iter().flatten().collect::<Vec<_>>(), &selection.inputs(&args.selection.labels))?;
    let (classes, training) = selection.rows(&args.train_where)?;
    warn_irregular(training.iter().map(|t| &t.trace));
    warn_refused(training.iter().map(|t| &t.trace));
    let validation = args.validation.validation(&selection, &training)?;
    let held_out = args.held_out(&selection, (&classes, &training), &validation.units)?;
    let park = args.park(&channels)?;
    let mut recipe = Recipe { validation, park, columns: channels.clone(), ..args.recipe(&classes, plan)? };
    recipe.alarms.by_run = !recipe.validation.groups.is_empty();
    let prepared = prepare(&training, preparation)?;
    let mut trained = crate::train::train(&prepared, &classes, &recipe)?;
    // On the traces as the shaft was trained, before block means move into the detector.
    let orders = Orders::of(&trained, &prepared)?;
    let host = embed_block_mean(&mut trained, preparation, &training);
    let channels = read_by(&trained, channels);
    let description = description::lines(&trained, &channels, host);
    if host != Preparation::NONE {
        output::warn(format!("the detector does not decimate: {}", description[3]));
    }
    let notes = Notes::new(
        &channels,
        host,
        (&trained.feature_names, trained.recipe.catalogue().orders.unwrap_or_default()),
        &training,
        &trained.recipe.validation.units,
    );
    let bytes = trained.to_bytes(&notes.to_text())?;
    let rust = args.rust.as_ref().map(|_| args.rust_source(&trained, &description, &channels)).transpose()?;
    let c = args.c.as_ref().map(|_| c_header(&trained.to_core()?, &description, Some(&channels))).transpose()?;

    let held_out = held_out.map(|held_out| Args::evaluate(held_out, &trained, host)).transpose()?;
    let found = Found {
        cross_validated: held_out.is_none().then(|| trained.cross_validated()),
        forward: if held_out.is_none() { trained.forward() } else { vec![] },
        ranking: args.rank.then(|| trained.rank()).transpose()?,
        held_out,
        orders,
    };
    let report = args.report.as_ref().map(|_| {
        let examples: Vec<_> =
            (0..classes.len()).filter_map(|k| prepared.iter().find(|t| t.class == k).map(|t| (&t.trace, k))).collect();
        model::training(&trained, &channels, &examples, found.worth())
    });
    let report = report.transpose()?.map(super::drive::on_page);
    let texts = [(&args.rust, &rust), (&args.c, &c), (&args.report, &report)];
    let texts = texts.into_iter().filter_map(|(path, text)| Some((path.as_deref()?, text.as_ref()?.as_bytes())));
    output::write_all(&texts.chain([(args.model.as_path(), bytes.as_slice())]).collect::<Vec<_>>())?;
    args.print(&trained, &training, bytes.len(), &found)
}

impl Args {
    /// The sign convention of the recordings: that of the front end, if there is one.
    fn park(&self, channels: &Channels) -> Result<Option<Park>, Error> {
        let asked = self.park.map(ParkConvention::core);
        match (asked, channels.front_end.as_ref().map(FrontEndFile::park)) {
            (Some(asked), Some(own)) if asked != own => {
                Err(Error::Usage("--park differs from the convention of --front-end".into()))
            }
            (asked, own) => Ok(own.or(asked)),
        }
    }

    /// Adds the columns that averages name and no other part uses.
    fn with_averaged_columns(
        &self,
        columns: Channels,
        shaft: Option<&ShaftPlan>,
        preparation: Preparation,
    ) -> Result<Channels, Error> {
        let names = || self.features.iter().chain(&self.covariates);
        if preparation != Preparation::NONE && names().any(|name| name.starts_with(features::RMS)) {
            let problem =
                "a root mean square is that of the recorded samples: --block-mean and --decimate do not go with it";
            return Err(Error::Usage(problem.into()));
        }
        let (features, covariates) = (self.features.clone(), self.covariates.clone());
        let plain = Recipe { features, covariates, columns, ..Recipe::new(self.structure.structure()) };
        Ok(Recipe { shaft: shaft.cloned(), ..plain }.with_averaged_columns().columns)
    }

    /// The model as Rust source, with the front end that its recordings passed and the constants of a commissioning.
    fn rust_source(&self, trained: &Trained, notes: &[String], channels: &Channels) -> Result<String, Error> {
        let mut source = export::rust_source(trained, notes)?;
        if let Some(front_end) = &channels.front_end {
            source = format!("{source}\n{}", front_end_source(&trained.to_core()?, channels, front_end)?);
        }
        if let Some(segments) = self.commissioning {
            source = format!("{source}\n{}", commissioning_source(trained, segments)?);
        }
        Ok(source)
    }

    fn recipe(&self, classes: &[String], shaft: Option<ShaftPlan>) -> Result<Recipe, Error> {
        let keep = self.components.map_or(Keep::Variance(self.variance), Keep::Components);
        let projection = match self.projection {
            Projection::None if self.components.is_some() => {
                return Err(Error::Usage("--components goes with --projection pca, pca-raw or fisher".into()));
            }
            Projection::None => ProjectionKind::None,
            Projection::Pca => ProjectionKind::Pca { keep, standardised: true },
            Projection::PcaRaw => ProjectionKind::Pca { keep, standardised: false },
            Projection::Fisher => ProjectionKind::Fisher { components: self.components },
        };
        let structure = self.structure.structure();
        Ok(Recipe {
            columns: Channels::new("", "", ""),
            park: None,
            structure,
            shaft,
            estimation: self.estimation.estimation(structure, classes, self.alarms.healthy_class(classes)?)?,
            features: self.features.clone(),
            covariates: self.covariates.clone(),
            rising: self.rising.clone(),
            projection,
            discriminant: match self.discriminant {
                DiscriminantKind::Linear | DiscriminantKind::Shrunk => Kind::Linear,
                DiscriminantKind::Quadratic => Kind::Quadratic,
            },
            shrink: match (&self.shrinkage[..], self.discriminant) {
                (&[lambda, gamma], _) if [lambda, gamma].iter().all(|x| (0.0..=1.0).contains(x)) => {
                    Shrink::To(Shrinkage { lambda, gamma })
                }
                ([_, ..], _) => {
                    return Err(Error::Usage("--shrinkage takes two numbers from 0 to 1, e.g. 0,0.5".into()));
                }
                (_, DiscriminantKind::Shrunk) => Shrink::Chosen,
                (_, DiscriminantKind::Linear | DiscriminantKind::Quadratic) => Shrink::Not,
            },
            size_spread: if (0.0..=1.0).contains(&self.size_spread) {
                self.size_spread
            } else {
                return Err(Error::Usage("--size-spread takes a number from 0 to 1, e.g. 0.25".into()));
            },
            validation: Validation::default(),
            priors: priors(&self.priors, classes)?,
            cost: costs(&self.cost, classes)?,
            alarms: self.alarms.alarms(classes)?,
        })
    }

    /// Reads the traces of `--test-where`; those of training, and units of theirs, are refused.
    fn held_out(
        &self,
        selection: &Selection,
        (classes, training): (&[String], &[LabelledTrace]),
        units: &[String],
    ) -> Result<Option<(Vec<LabelledTrace>, Groups)>, Error> {
        if self.test_where.is_empty() {
            return Ok(None);
        }
        let (names, mut traces) = selection.rows(&self.test_where)?;
        for held_out in &mut traces {
            let name = &names[held_out.class];
            held_out.class = classes.iter().position(|class| class == name).ok_or_else(|| {
                Error::Usage(format!("--test-where selects class {name}, which has no training traces"))
            })?;
        }
        if let Some(both) = traces.iter().find(|t| training.iter().any(|s| s.trace.id == t.trace.id)) {
            let id = &both.trace.id;
            return Err(Error::Usage(format!(
                "trace {id} is in both --train-where and --test-where; make them disjoint"
            )));
        }
        let groups = self.validation.groups.read(selection, &traces)?;
        groups.refuse_known(units)?;
        Ok(Some((traces, groups)))
    }

    fn evaluate(
        (traces, groups): (Vec<LabelledTrace>, Groups),
        trained: &Trained,
        host: Preparation,
    ) -> Result<HeldOut, Error> {
        let model = trained.embed()?;
        check_rate(&model, host, traces.iter().map(|t| &t.trace))?;
        let bar = output::progress("evaluating", traces.len());
        let verdicts = evaluate::run(&model, &prepare(&traces, host)?, || bar.inc(1))?;
        bar.finish_and_clear();
        let scores = Scores::of_verdicts(&verdicts, &model.priors(), false);
        let confusion = evaluate::count(&trained.classes, &verdicts, groups.clusters(), false);
        let confusion = Confusion { healthy: model.healthy(), ..confusion };
        let by_run = groups.runs.zip(model.healthy());
        let false_alarms = by_run.map(|(runs, healthy)| FalseAlarms::of(&verdicts, &runs, healthy, false));
        Ok(HeldOut { confusion, verdicts, scores, false_alarms })
    }

    fn print(&self, trained: &Trained, training: &[LabelledTrace], bytes: usize, found: &Found) -> Result<(), Error> {
        let counts: Vec<usize> =
            (0..trained.classes.len()).map(|k| training.iter().filter(|t| t.class == k).count()).collect();
        let rotor = description::rotor_warnings(trained);
        trained.left_out.summary().iter().chain(&trained.watch.warning).chain(&rotor).for_each(output::warn);
        if self.json {
            return output::json(&json!({
                "model": self.model,
                "bytes": bytes,
                "classes": trained.classes,
                "training_traces": counts,
                "left_out": trained.left_out.count,
                "features": trained.feature_names,
                "method": method_word(trained.recipe.estimation.method),
                "settle_samples": trained.parts.regression.as_ref().and_then(|(layout, regression)| {
                    (layout.method == Method::Instruments).then_some(regression.settle)
                }),
                "segment_samples": trained.segment_samples,
                "covariates": description::covariates_to_json(trained),
                "shrinkage": trained.choice.as_ref().map(Choice::to_json),
                "held_out": found.held_out.as_ref().map(HeldOut::to_json),
                "cross_validated": found.cross_validated.as_ref().and_then(|v| v.as_ref().ok()).map(Scores::to_json),
                "forward": found.forward.iter().map(Forward::to_json).collect::<Vec<_>>(),
                "ranking": found.ranking.as_ref().map(Ranking::to_json),
                "order_noise": evidence::to_json(found.orders.as_ref()),
                "novelty": description::gate_to_json(trained),
            }));
        }
        let traces: Vec<String> = trained.classes.iter().zip(counts).map(|(name, n)| format!("{n} {name}")).collect();
        output::say(format!("trained on {} traces; features {}", traces.join(", "), trained.feature_names.join(", ")))?;
        output::say(format!("estimated by {}", estimated_by(trained)))?;
        output::say(format!(
            "{} discriminant, coordinates: {}, segments of {} samples; {} bytes in {}",
            trained.kind_name(),
            trained.core_projection.matrix.nrows(),
            trained.segment_samples,
            bytes,
            self.model.display()
        ))?;
        trained.explained.iter().flat_map(Explained::lines).try_for_each(output::say)?;
        description::gate(trained).map_or(Ok(()), output::say)?;
        evidence::text(trained, found.orders.as_ref()).map_or(Ok(()), output::say)?;
        match &found.cross_validated {
            Some(Ok(scores)) => {
                let error = 100.0 * scores.error;
                let interval = scores.error_by_group.map_or_else(String::new, |Rate { low, high, .. }| {
                    format!(" [{:.1}, {:.1}]", 100.0 * low, 100.0 * high)
                });
                output::say(format!("cross-validated: error {error:.1} %{interval}, {}", scores.summary()))?;
            }
            Some(Err(reason)) => output::say(format!("not cross-validated: {reason}"))?,
            None => {}
        }
        found.forward.iter().try_for_each(|one| output::say(one.to_string()))?;
        if let Some(HeldOut { confusion, scores, false_alarms, .. }) = &found.held_out {
            let scores = scores.summary();
            output::say(format!("held-out traces, through the embedded detector:\n{confusion}\n{scores}"))?;
            false_alarms.as_ref().map_or(Ok(()), |found| output::say(format!("false alarms {found}")))?;
        }
        found.ranking.as_ref().map_or(Ok(()), |ranking| output::say(ranking.to_string()))
    }
}

/// Traces that were not used in training, with their verdicts.
struct HeldOut {
    confusion: Confusion,
    verdicts: Vec<evaluate::TraceVerdict>,
    scores: Scores,
    /// False alarms by run, if the runs are known.
    false_alarms: Option<FalseAlarms>,
}

impl HeldOut {
    fn to_json(&self) -> serde_json::Value {
        let mut value = self.confusion.to_json();
        self.scores.add_to(&mut value);
        if let Some(found) = &self.false_alarms {
            value["false_alarms_by_run"] = found.to_json();
        }
        value
    }
}

/// Results on the quality of the model.
struct Found {
    held_out: Option<HeldOut>,
    /// Only if no traces were held out.
    cross_validated: Option<Result<Scores, Error>>,
    /// Gates of the first runs on later ones; only if no traces were held out.
    forward: Vec<Forward>,
    ranking: Option<Ranking>,
    orders: Option<Orders>,
}

impl Found {
    fn worth(&self) -> Worth<'_> {
        Worth {
            held_out: self.held_out.as_ref().map(|h| (&h.confusion, h.verdicts.as_slice(), &h.scores)),
            cross_validated: self.cross_validated.as_ref().map(Result::as_ref),
            ranking: self.ranking.as_ref(),
        }
    }
}

/// The channels that the model reads: without the reference, and without the velocity if it is taken from the angle.
fn read_by(trained: &Trained, mut channels: Channels) -> Channels {
    if let (Some(shaft), Some(plan)) = (&mut channels.shaft, &trained.recipe.shaft) {
        shaft.reference = None;
        if plan.velocity == VelocitySource::Angle {
            shaft.velocity = None;
        }
    }
    channels
}

/// Moves the block means into the detector if no decimation follows them; returns the preparation that remains on the
/// host.
fn embed_block_mean(trained: &mut Trained, preparation: Preparation, training: &[LabelledTrace]) -> Preparation {
    if preparation.decimate > 1 || preparation.block_mean > usize::from(MAX_BLOCK_MEAN) {
        return preparation;
    }
    trained.block_mean = preparation.block_mean;
    trained.interval_s = training.iter().find_map(|t| t.trace.interval_s).unwrap_or(0.0);
    Preparation::NONE
}
