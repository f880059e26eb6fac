//! `bearing-watch audit`, and the page of one file.

use std::path::{Path, PathBuf};

use crate::command_line::options::Taken;
use crate::command_line::{jobs, output};
use model::Error;
use pages::Page;
use pages::audit::{LineLevels, Recording, Spectrum, page};
use traces::Candidate;
use traces::audit::{Audit, Audited, Line, Outcome};

/// What recordings are worth: rate, gaps, held and saturated samples, lags, equal traces, the smallest line of an order
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Ends with exit code 1 if it finds something.\n\nExample:\n  bearing-watch audit drive.toml --json"
)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) taken: Taken<jobs::Audit>,
    /// Write a page with signals, spectra over orders and the smallest lines
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the audit; returns whether something was found.
pub(crate) fn run(args: &Args) -> Result<bool, Error> {
    let audit = Audit { settings: args.taken.settings.clone() };
    let paths = audit.paths()?;
    output::plan(&args.report.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &paths)?;
    let outcome = output::logged(|log| audit.audit(&audit.listing(log)?, log))?;
    if let Some(path) = &args.report {
        output::write(path, args.taken.on_page(page_with(&audit, &outcome).render()))?;
    }
    if args.json {
        output::json("audit", outcome.to_json())?;
    } else {
        outcome.lines(audit.false_alarm()).iter().try_for_each(output::say)?;
    }
    Ok(!outcome.findings.is_empty())
}

/// Traces whose signals and spectra are on the page.
const SHOWN: usize = 4;

/// The page of one file with the usual settings.
pub(crate) fn page_of(file: &Path) -> Result<Page, Error> {
    let audit = Audit::usual(file);
    let outcome = output::logged(|log| audit.audit(&[Candidate::given(file)], log))?;
    Ok(page_with(&audit, &outcome))
}

fn page_with(audit: &Audit, outcome: &Outcome) -> Page {
    let shown: Vec<Recording<'_>> =
        outcome.traces.iter().take(SHOWN).map(|trace| recording(audit, trace, outcome)).collect();
    let findings: Vec<(&str, &[String])> =
        outcome.findings.iter().map(|finding| (finding.what.as_str(), finding.traces.as_slice())).collect();
    let levels = |line: &Line| (line.floor, line.smallest, line.first);
    let lines = outcome.lines.iter().map(|line| (line.trace.as_str(), levels(line)));
    let lines = lines.map(|(trace, (floor, smallest, first))| LineLevels { trace, floor, smallest, first });
    page(outcome.traces.len(), &findings, &shown, (&lines.collect::<Vec<_>>(), &outcome.terms))
}

fn recording<'a>(audit: &Audit, trace: &'a Audited, outcome: &Outcome) -> Recording<'a> {
    let line = outcome.lines.iter().find(|line| line.trace == trace.id);
    let over_angle = line.zip(audit.with_angle(trace, outcome.rotor));
    Recording {
        id: &trace.id,
        names: &trace.names,
        times_s: trace.times_s.as_deref(),
        rate_hz: audit.rate_of(trace, outcome.rotor),
        values: trace.signals(),
        columns: &trace.columns,
        spectrum: over_angle.map(|(line, (y, angle))| Spectrum::of(y, &angle, line.smallest)),
    }
}
