//! `bearing-watch validate`

mod estimate_file;

use std::path::PathBuf;

use clap::ValueEnum as _;
use rayon::prelude::*;
use serde_json::json;

use crate::command_line::output;
use crate::identification::fit::FitArgs;
use crate::recordings::reading::complete;
use model::Error;
use model::identify::Options;
use model::trace::Trace;
use model::validate::roots::Root;
use model::validate::{Correlation, Errors, Test, validate};
use pages::validation::{Outcome, cancellation, page};

/// Test the model of each trace: residuals, poles and zeros with 3σ regions, fit, step and frequency response
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch validate trace.csv --y current_a --u1 velocity_ref_rad_s-velocity_rad_s \
--u2 load_torque_nm --order 2,2,2,1,1 --report model.html"
)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) fit: FitArgs,
    /// Test this model instead of estimating one on each trace: the table or JSON of `identify`, of one trace or with
    /// the row --params-of. JSON has the covariance, which widens the bounds
    #[arg(long, value_name = "FILE", conflicts_with_all = ["method", "robust", "instruments"])]
    params: Option<PathBuf>,
    /// The trace on which the model of --params was estimated
    #[arg(long, value_name = "TRACE", requires = "params")]
    params_of: Option<String>,
    /// Largest lag of the correlations, on either side
    #[arg(long, default_value_t = 25, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=500))]
    lags: u16,
    /// Write a page with all plots; details are those of the first trace
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let (structure, method) = (args.fit.structure()?, &args.fit.method);
    let given = args
        .params
        .as_deref()
        .map(|path| estimate_file::read(path, args.params_of.as_deref(), structure))
        .transpose()?;
    let (traces, preparation) = args.fit.read(args.report.as_ref())?;
    complete(&traces)?;
    let bar = output::progress("validating", traces.len());
    let one = |trace: &Trace| {
        let trace = preparation.apply(trace)?;
        let (estimate, errors) = match &given {
            Some(given) => (given.clone(), Errors::Given),
            None => {
                let estimate = method.estimate(&trace, structure, Options::default())?;
                (estimate, Errors::of(method.method))
            }
        };
        let found = validate(&trace, &estimate, errors, usize::from(args.lags))?;
        bar.inc(1);
        Ok(Outcome { trace, estimate, found })
    };
    let outcomes: Vec<Result<Outcome, Error>> = traces.par_iter().map(one).collect();
    bar.finish_and_clear();
    // Collects all results first, so that every run reports the error of the first bad trace.
    let outcomes = outcomes.into_iter().collect::<Result<Vec<_>, Error>>()?;
    if given.is_none() {
        method.warn_of_colour(outcomes.iter().map(|outcome| (outcome.trace.id.as_str(), &outcome.estimate)));
    }
    let unstable = outcomes.iter().filter(|outcome| !outcome.estimate.is_stable()).count();
    if unstable > 0 {
        output::warn(format!(
            "{unstable} of {} models are unstable; their simulation is one with the poles reflected",
            outcomes.len()
        ));
    }
    if let Some(path) = &args.report {
        output::write(path, args.fit.taken.on_page(page(&lead(args, &outcomes[0].trace)?, &outcomes)))?;
    }
    if args.json {
        return output::json("validate", json!(outcomes.iter().map(to_json).collect::<Vec<_>>()));
    }
    for outcome in &outcomes {
        print(outcome)?;
    }
    let passed = outcomes.iter().filter(|outcome| outcome.found.independence.passed()).count();
    if outcomes.len() > 1 {
        output::say(format!("{passed} of {} models pass the independence test", outcomes.len()))?;
    }
    Ok(())
}

fn count(test: &Test) -> String {
    let Test { tested, outside, allowed, largest, limit } = test;
    format!("{outside} of {tested} lags outside, {allowed} allowed; largest {largest:.1} sd, {limit:.1} allowed")
}

fn print(outcome: &Outcome) -> Result<(), Error> {
    let found = &outcome.found;
    let verdict = |test: &Test| if test.passed() { "pass" } else { "FAIL" };
    let feedback = if found.feedback.passed() { "not seen," } else { "seen,    " };
    output::say(&outcome.trace.id)?;
    output::say(format!("  independence  {}  {}", verdict(&found.independence), count(&found.independence)))?;
    output::say(format!("  whiteness     {}  {}", verdict(&found.whiteness), count(&found.whiteness)))?;
    output::say(format!("  feedback      {feedback} {}", count(&found.feedback)))?;
    output::say(format!(
        "  fit           simulation {:.2} %, one-step prediction {:.2} %",
        found.simulation_fit_percent, found.prediction_fit_percent
    ))?;
    output::say(format!("  poles, zeros  {}", cancellation(found)))
}

fn to_json(outcome: &Outcome) -> serde_json::Value {
    let Outcome { trace, found, .. } = outcome;
    let test = |test: &Test| {
        json!({
            "passed": test.passed(), "tested": test.tested, "outside": test.outside, "allowed": test.allowed,
            "largest_sd": test.largest, "largest_allowed_sd": test.limit,
        })
    };
    let correlation = |one: &Correlation| json!({ "lag": one.lags, "value": one.value, "bound_99": one.bound });
    let roots = |roots: &[Root]| {
        let one = |root: &Root| {
            let c = root.covariance;
            json!({
                "re": root.at.re, "im": root.at.im, "separated": root.separated,
                "covariance": [[c[(0, 0)], c[(0, 1)]], [c[(1, 0)], c[(1, 1)]]],
            })
        };
        roots.iter().map(one).collect::<Vec<_>>()
    };
    let map = &found.map;
    json!({
        "trace": trace.id,
        "independence": test(&found.independence),
        "whiteness": test(&found.whiteness),
        "feedback": test(&found.feedback),
        "simulation_fit_percent": found.simulation_fit_percent,
        "prediction_fit_percent": found.prediction_fit_percent,
        "poles": roots(&map.poles),
        "zeros_u1": roots(&map.zeros[0]),
        "zeros_u2": roots(&map.zeros[1]),
        "removable_poles": map.removable,
        "autocorrelation": correlation(&found.autocorrelation),
        "cross_correlation_u1": correlation(&found.cross_correlation[0]),
        "cross_correlation_u2": correlation(&found.cross_correlation[1]),
    })
}

/// Returns the text below the title of the page.
fn lead(args: &Args, first: &Trace) -> Result<String, Error> {
    let (channels, structure) = (args.fit.taken.settings.channels(None)?, args.fit.structure()?);
    let order = structure.orders();
    let by = match &args.params {
        Some(path) => format!("from {}, tested on", path.display()),
        None => {
            let value = args.fit.method.method.to_possible_value();
            let name = value.map_or_else(String::new, |method| method.get_name().to_string());
            format!("estimated by {name} from")
        }
    };
    Ok(format!(
        "y = {}, u1 = {}, u2 = {}; order {order:?}{}, {by} {} samples.",
        channels.y,
        channels.u1,
        channels.u2,
        if structure.offset { " with a constant" } else { "" },
        first.y.len()
    ))
}
