//! `bearing-watch structure`

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::command_line::jobs::Structures;
use crate::command_line::options::Taken;
use crate::command_line::output;
use crate::recordings::reading;
use model::Error;
use model::identify::{Structure, Terms, parse_order};
use model::structure::{Candidate, Estimator, Grid, Search, search};
use model::trace::{Channels, FrontEndFile, Trace};
use pages::structure::{name, page};

/// Search the model structure: every na,nb,nc,nkb,nkc up to maxima, estimated on training traces and scored by the
/// free-run fit on validation traces
#[derive(Debug, clap::Args)]
#[command(after_help = "Terms and delays run from 1 (--min) to --max: --max 4,4,4,4,4 is 1024 structures.\n\n\
Example:\n  bearing-watch structure train.csv validate.csv --y current_a --u1 velocity_ref_rad_s-velocity_rad_s \
--u2 load_torque_nm --max 4,4,4,3,3 --compare 2,2,2,1,1 --report page.html")]
pub(crate) struct Args {
    /// Trace file or folder to estimate on; several traces give one model
    #[arg(value_name = "TRAIN")]
    train: PathBuf,
    /// Trace file or folder to score on
    #[arg(value_name = "VALIDATE")]
    validate: PathBuf,
    #[command(flatten)]
    pub(crate) taken: Taken<Structures>,
    /// Greatest na,nb,nc,nkb,nkc; nc = 0 without a second input
    #[arg(long, value_parser = numbers, value_name = "ORDER")]
    max: Structure,
    /// Least na,nb,nc,nkb,nkc; with a delay of 0 the output depends on the present input
    #[arg(long, value_parser = numbers, value_name = "ORDER", default_value = "1,1,1,1,1")]
    min: Structure,
    /// Estimator
    #[arg(long, value_enum, default_value = "ls")]
    method: Estimator,
    /// A structure of your choice, to compare with the best
    #[arg(long, value_parser = parse_order, value_name = "ORDER")]
    compare: Option<Structure>,
    /// Write a page with plots and tables
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON, every structure in it
    #[arg(long)]
    json: bool,
}

/// Parses five numbers up to 32; the grid checks that the ranges are valid.
fn numbers(text: &str) -> Result<Structure, String> {
    let wrong = || format!("\"{text}\": write na,nb,nc,nkb,nkc, whole numbers up to 32, e.g. 4,4,4,3,3");
    let numbers = text.split(',').map(|part| part.trim().parse::<u8>().ok().filter(|n| *n <= 32));
    let numbers: Vec<u8> = numbers.collect::<Option<_>>().ok_or_else(wrong)?;
    numbers.try_into().map(Structure::from_orders).map_err(|_| wrong())
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let grid = Grid { min: args.min, max: args.max, offset: args.offset() };
    let structures = grid.structures()?;
    structures
        .iter()
        .chain(&args.compare)
        .try_for_each(|structure| args.taken.settings.channels.require(*structure))?;
    let inputs = [args.train.clone(), args.validate.clone()];
    output::plan(&args.report.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &inputs)?;
    let (train, validate) = (args.read(&args.train)?, args.read(&args.validate)?);
    if validate.iter().any(|v| train.iter().any(|t| t.y == v.y)) {
        output::warn("a validation trace is also a training trace: its fit flatters wide structures");
    }
    let found = search(&train, &validate, &structures, args.method)?;
    let Some(best) = found.best_fit() else {
        let reason = found.refused.first().map(|r| format!("{}: {}", name(r.structure), r.reason)).unwrap_or_default();
        let problem =
            format!("none of {} structures can be estimated ({reason}); use a richer command", structures.len());
        return Err(Error::Usage(problem));
    };
    let pick = args.pick(&train, &validate, &found)?;
    if let Some(path) = &args.report {
        let lead = args.lead(structures.len(), &train, &validate)?;
        let page = page("Structure selection", &lead, &found, pick.as_ref()).render();
        output::write(path, args.taken.on_page(page))?;
    }
    if args.json {
        output::json("structure", to_json(&found, pick.as_ref()))
    } else {
        print(&found, best, pick.as_ref())
    }
}

impl Args {
    /// Whether a constant term is estimated.
    const fn offset(&self) -> bool {
        self.taken.settings.model.offset
    }

    fn read(&self, path: &Path) -> Result<Vec<Trace>, Error> {
        let settings = &self.taken.settings;
        let preparation = settings.model.preparation()?;
        let front_end = settings.data.front_end.as_deref().map(FrontEndFile::read).transpose()?;
        let traces = reading::read(&[path.to_path_buf()], &settings.channels(front_end)?)?;
        traces.iter().map(|trace| preparation.apply(trace)).collect()
    }

    /// Returns the candidate for the user's structure: from the search, or from a search of its own if it is outside
    /// the grid.
    fn pick(&self, train: &[Trace], validate: &[Trace], found: &Search) -> Result<Option<Candidate>, Error> {
        let Some(order) = self.compare else { return Ok(None) };
        let structure = Structure { offset: self.offset(), ..order };
        if let Some(candidate) = found.find(structure) {
            return Ok(Some(candidate.clone()));
        }
        let mut alone = search(train, validate, &[structure], self.method)?;
        if let Some(refusal) = alone.refused.pop() {
            return Err(Error::Usage(format!("--compare {}: {}", name(structure), refusal.reason)));
        }
        Ok(alone.candidates.pop())
    }

    fn lead(&self, count: usize, train: &[Trace], validate: &[Trace]) -> Result<String, Error> {
        let Channels { y, u1, u2, .. } = self.taken.settings.channels(None)?;
        let ids = |traces: &[Trace]| match traces {
            [one] => one.id.clone(),
            [first, ..] => format!("{} traces from {}", traces.len(), first.id),
            [] => String::new(),
        };
        let method = if self.method == Estimator::Ls { "least squares" } else { "iv4" };
        Ok(format!(
            "y = {y}, u1 = {u1}, u2 = {u2}. {count} structures by {method}, estimated on {}, scored by free-run \
             simulation on {}.",
            ids(train),
            ids(validate)
        ))
    }
}

fn to_json(found: &Search, pick: Option<&Candidate>) -> Value {
    json!({
        "best_fit": found.best_fit().map(row),
        "best_aic": found.best_aic().map(row),
        "best_mdl": found.best_mdl().map(row),
        "best_by_parameters": found.best_by_count().into_iter().map(row).collect::<Vec<_>>(),
        "compare": pick.map(|c| {
            let mut value = row(c);
            value["place_by_fit"] = found.rank(c.fit_percent).into();
            value
        }),
        "structures": found.candidates.iter().map(row).collect::<Vec<_>>(),
        "refused": found.refused.iter()
            .map(|r| json!({ "order": r.structure.orders(), "reason": r.reason }))
            .collect::<Vec<_>>(),
    })
}

fn row(candidate: &Candidate) -> Value {
    let fitted = &candidate.fitted;
    let names = fitted.structure.names();
    let theta: serde_json::Map<_, _> = names.into_iter().zip(fitted.theta.iter().map(|x| json!(x))).collect();
    json!({
        "order": fitted.structure.orders(),
        "parameters": fitted.parameters(),
        "fit_percent": candidate.fit_percent,
        "aic": fitted.aic(),
        "mdl": fitted.mdl(),
        "variance": fitted.variance(),
        "rows": fitted.rows,
        "stable": candidate.stable,
        "theta": theta,
    })
}

fn print(found: &Search, best: &Candidate, pick: Option<&Candidate>) -> Result<(), Error> {
    let line = |by: &str, c: &Candidate| {
        let fitted = &c.fitted;
        let (name, d) = (name(fitted.structure), fitted.parameters());
        let poles = if c.stable { "" } else { "  unstable" };
        let (fit, aic, mdl) = (c.fit_percent, fitted.aic(), fitted.mdl());
        output::say(format!("{by:12} {name:22} {d:>10} {fit:>9.3} {aic:>10.5} {mdl:>10.5}{poles}"))
    };
    output::say(format!(
        "{:12} {:22} {:>10} {:>9} {:>10} {:>10}",
        "", "na,nb,nc,nkb,nkc", "parameters", "fit / %", "AIC", "MDL"
    ))?;
    for candidate in found.best_by_count() {
        line("best of count", candidate)?;
    }
    line("best fit", best)?;
    for (by, candidate) in [("least AIC", found.best_aic()), ("least MDL", found.best_mdl()), ("your pick", pick)] {
        if let Some(candidate) = candidate {
            line(by, candidate)?;
        }
    }
    if let Some(pick) = pick {
        let less = best.fit_percent - pick.fit_percent;
        let (place, of) = (found.rank(pick.fit_percent), found.candidates.len());
        let more = best.fitted.parameters() as i64 - pick.fitted.parameters() as i64;
        output::say(format!(
            "your pick is {less:.3} points below the best, place {place} of {of}; the best has {more:+} parameters"
        ))?;
    }
    let unstable = found.candidates.iter().filter(|c| !c.stable).count();
    if unstable > 0 {
        output::say(format!(
            "{unstable} of {} models are unstable; their fit is that of reflected poles",
            found.candidates.len()
        ))?;
    }
    match found.refused.first() {
        Some(first) => {
            let (count, example) = (found.refused.len(), name(first.structure));
            output::say(format!("{count} structures have no estimate; {example}: {}", first.reason))
        }
        None => Ok(()),
    }
}
