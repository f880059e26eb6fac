//! `bearing-watch identify`

use std::path::PathBuf;

use rayon::prelude::*;
use serde_json::json;

use crate::command_line::output;
use crate::identification::fit::FitArgs;
use model::Error;
use model::identify::{Estimate, Noise, Options, Structure, Terms};
use model::trace::tally::told;

/// Estimate the difference model of each trace
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch identify traces --y current_a --u1 velocity_ref_rad_s-velocity_rad_s \
--u2 load_torque_nm --order 2,2,2,1,1 --out params.csv"
)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) fit: FitArgs,
    /// Passes of --method iv, 1 to 3
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=3))]
    passes: u8,
    /// Terms of the noise polynomial of --method armax; na (at least one) if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=32))]
    noise_order: Option<u8>,
    /// Write the table here instead of to standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print JSON instead of CSV
    #[arg(long, conflicts_with = "out")]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let (traces, preparation) = args.fit.read(args.out.as_ref())?;
    let (structure, method) = (args.fit.structure()?, &args.fit.method);
    let options = Options { passes: args.passes.into(), noise_order: args.noise_order.map(usize::from) };
    let bar = output::progress("estimating", traces.len());
    let estimates = traces
        .par_iter()
        .map(|trace| {
            let prepared = preparation.apply(trace)?;
            let estimate = method.estimate(&prepared, structure, options)?;
            bar.inc(1);
            let undetermined = estimate.undetermined(&prepared);
            Ok((trace.id.as_str(), estimate, undetermined))
        })
        .collect::<Vec<_>>();
    bar.finish_and_clear();
    // Collects all results first, so that every run reports the error of the first bad trace.
    let estimates = estimates.into_iter().collect::<Result<Vec<_>, Error>>()?;
    told(traces.iter()).iter().for_each(output::warn);
    let unsure = estimates.iter().filter(|(_, _, undetermined)| !undetermined.is_empty());
    if let Some((id, _, undetermined)) = unsure.clone().next() {
        output::warn(format!(
            "the signals hardly determine some parameters of {} of {} models, first {id}: {}; \
             use a richer command than a sine, or fewer terms",
            unsure.count(),
            estimates.len(),
            undetermined.join(", ")
        ));
    }
    let estimates: Vec<(&str, Estimate)> = estimates.into_iter().map(|(id, estimate, _)| (id, estimate)).collect();
    warn_of_trouble(&estimates);
    method.warn_of_colour(estimates.iter().map(|(id, estimate)| (*id, estimate)));
    if args.json {
        let rows: Vec<_> = estimates.iter().map(|(id, estimate)| row_json(id, estimate)).collect();
        return output::json("identify", json!(rows));
    }
    let table = csv(structure, &estimates)?;
    match &args.out {
        Some(path) => {
            output::write(path, table)?;
            output::say(format!("{} estimates in {}", estimates.len(), path.display()))
        }
        None => output::say(table.trim_end()),
    }
}

fn warn_of_trouble(estimates: &[(&str, Estimate)]) {
    let total = estimates.len();
    let of = |bad: &dyn Fn(&Estimate) -> bool| {
        let mut ids = estimates.iter().filter(|(_, estimate)| bad(estimate)).map(|(id, _)| *id);
        ids.next().map(|first| (1 + ids.count(), first))
    };
    if let Some((count, first)) = of(&|estimate| !estimate.convergence.stable) {
        output::warn(format!(
            "{count} of {total} models are unstable, first {first}; their fit is that of a simulation with the poles reflected"
        ));
    }
    if let Some((count, first)) = of(&|estimate| !estimate.convergence.converged) {
        output::warn(format!(
            "{count} of {total} estimates did not converge, first {first}; each is the last good iterate: \
             try a lower order or another --method"
        ));
    }
}

fn row_json(id: &str, estimate: &Estimate) -> serde_json::Value {
    let names = estimate.structure.names();
    let convergence = estimate.convergence;
    let named = |values: &[f64]| -> serde_json::Map<String, serde_json::Value> {
        names.iter().cloned().zip(values.iter().map(|v| json!(v))).collect()
    };
    json!({
        "trace": id,
        "parameters": named(estimate.theta.as_slice()),
        "sd": named(&estimate.deviations()),
        "covariance": estimate.covariance.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>(),
        "variance": estimate.variance,
        "rows": estimate.rows,
        "fit_percent": estimate.fit_percent,
        "prediction_fit_percent": estimate.prediction_fit_percent,
        "noise": noise_json(&estimate.noise),
        "convergence": {
            "converged": convergence.converged,
            "iterations": convergence.iterations,
            "reflected": convergence.reflected,
            "stable": convergence.stable,
        },
    })
}

/// Returns the noise model that the method assumes, with its polynomial if it has one.
fn noise_json(noise: &Noise) -> serde_json::Value {
    match noise {
        Noise::Equation => json!({"kind": "equation"}),
        Noise::Output => json!({"kind": "output"}),
        Noise::Autoregressive(terms) => json!({"kind": "autoregressive", "polynomial": terms}),
        Noise::MovingAverage { terms, deviations } => {
            json!({"kind": "moving_average", "polynomial": terms, "sd": deviations})
        }
    }
}

fn csv(structure: Structure, estimates: &[(&str, Estimate)]) -> Result<String, Error> {
    let names = structure.names();
    let deviation_names = names.iter().map(|name| format!("sd_{name}"));
    let fixed = |name: &str| std::iter::once(name.to_string());
    let header = fixed("trace").chain(names.iter().cloned()).chain(fixed("fit_percent")).chain(deviation_names);
    let mut rows = vec![header.collect::<Vec<_>>()];
    for (id, estimate) in estimates {
        let numbers = estimate.theta.iter().copied().chain([estimate.fit_percent]).chain(estimate.deviations());
        rows.push(fixed(id).chain(numbers.map(|x| x.to_string())).collect());
    }
    output::csv(&rows)
}
