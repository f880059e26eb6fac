//! The page of an audit, and that of one file with the usual settings.

use std::path::Path;

use super::asked::Args;
use super::audited::{Audited, Line, Outcome};
use model::Error;
use pages::Page;
use pages::audit::{LineLevels, Recording, Spectrum, page};

/// Traces whose signals and spectra are on the page.
const SHOWN: usize = 4;

/// The page of one file with the usual settings.
pub(crate) fn page_of(file: &Path) -> Result<Page, Error> {
    let args = Args::usual(file);
    Ok(args.page(&args.audit(&[file.to_path_buf()])?))
}

impl Args {
    pub(super) fn page(&self, found: &Outcome) -> Page {
        let shown: Vec<Recording> = found.traces.iter().take(SHOWN).map(|trace| self.recording(trace, found)).collect();
        let findings: Vec<(&str, &[String])> =
            found.findings.iter().map(|finding| (finding.what.as_str(), finding.traces.as_slice())).collect();
        let levels = |line: &Line| (line.floor, line.smallest, line.first);
        let lines = found.lines.iter().map(|line| (line.trace.as_str(), levels(line)));
        let lines = lines.map(|(trace, (floor, smallest, first))| LineLevels { trace, floor, smallest, first });
        page(found.traces.len(), &findings, &shown, (&lines.collect::<Vec<_>>(), &found.terms))
    }

    fn recording<'a>(&self, trace: &'a Audited, found: &Outcome) -> Recording<'a> {
        let line = found.lines.iter().find(|line| line.trace == trace.id);
        let over_angle = line.zip(self.with_angle(trace, found.rotor));
        Recording {
            id: &trace.id,
            names: &trace.names,
            times_s: trace.times_s.as_deref(),
            rate_hz: self.rate_of(trace, found.rotor),
            values: &trace.values,
            columns: &trace.columns,
            spectrum: over_angle.map(|(line, (y, angle))| Spectrum::of(y, &angle, line.smallest)),
        }
    }
}
