//! From what is asked to what is printed.

use std::path::PathBuf;

use super::asked::Args;
use super::audited::Outcome;
use super::words::{print, to_json};
use crate::output;
use model::Error;
use model::audit::friction::Excited;
use model::settings::Settings;

/// Runs the audit; returns whether something was found.
pub(crate) fn run(args: &Args) -> Result<bool, Error> {
    let Settings { data, .. } = &args.taken.settings;
    if !(1e-9..=0.5).contains(&args.false_alarm()) {
        return Err(Error::Usage("--false-alarm: give a rate from 1e-9 to 0.5".into()));
    }
    if data.labels.is_none() && (data.traces.is_empty() || !data.conditions.is_empty()) {
        let missing = if data.traces.is_empty() { "TRACES, or --labels" } else { "--labels, for --where" };
        return Err(Error::Usage(format!("the following required arguments were not provided: {missing}")));
    }
    let folder = data.labels.iter().map(|labels| output::folder_of(labels).to_path_buf());
    let paths: Vec<PathBuf> = if data.traces.is_empty() { folder.collect() } else { data.traces.clone() };
    output::plan(&args.report.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &paths)?;
    let found = args.audit(&traces::files(&paths)?)?;
    if let Some(path) = &args.report {
        output::write(path, args.taken.on_page(args.page(&found).render()))?;
    }
    let Outcome { traces, findings, rotor, lines, terms } = &found;
    if args.json {
        let mut value = to_json(traces, findings, *rotor, lines);
        value["friction"] = terms.iter().map(Excited::to_json).collect();
        output::json("audit", value)?;
    } else {
        print(traces, findings, *rotor, (lines, terms, args.false_alarm()))?;
    }
    Ok(!findings.is_empty())
}
