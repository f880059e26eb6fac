//! Parts and sums that are summed or trained on.

use std::path::PathBuf;

use crate::beside::files;
use crate::{Part, Plan, Sums, Units, Wanted};
use model::Error;
use model::session::Log;

/// Files that are trained on.
pub(super) struct Inputs {
    pub(super) parts: Vec<Part>,
    pub(super) sums: Vec<(PathBuf, Sums)>,
}

impl Inputs {
    /// Opens parts and reads sums, also all of a folder.
    pub(super) fn open(paths: &[PathBuf]) -> Result<Self, Error> {
        let mut inputs = Self { parts: vec![], sums: vec![] };
        for path in &files(paths)? {
            let mut head = [0; 16];
            let mut file = std::fs::File::open(path).map_err(Error::io(path))?;
            let read = std::io::Read::read(&mut file, &mut head).map_err(Error::io(path))?;
            if Sums::are_sums(&head[..read]) || path.extension().is_some_and(|end| end == "sums") {
                let bytes = std::fs::read(path).map_err(Error::io(path))?;
                let sums = Sums::from_bytes(&bytes).map_err(|problem| Error::content(path, "content", problem))?;
                inputs.sums.push((path.clone(), sums));
            } else {
                inputs.parts.push(Part::open(path)?);
            }
        }
        Ok(inputs)
    }

    /// The plan of the first of them.
    pub(super) fn plan(&self) -> Result<&Plan, Error> {
        let first = self.parts.first().map(|part| &part.plan).or_else(|| self.sums.first().map(|(_, sums)| &sums.plan));
        first.ok_or_else(|| Error::Usage("no part is given".into()))
    }

    /// Sums everything; the features are those of the parts.
    pub(super) fn sums(self, wanted: &Wanted, units: Units, log: &Log<'_>) -> Result<Sums, Error> {
        self.folded(wanted, units, log).map(|(sums, _)| sums)
    }

    /// The same, with the parts.
    pub(super) fn folded(self, wanted: &Wanted, units: Units, log: &Log<'_>) -> Result<(Sums, Vec<Part>), Error> {
        let Self { parts, sums } = self;
        let mut all = None;
        if !parts.is_empty() {
            all = Some((PathBuf::new(), fold(&parts, wanted, units, log)?));
        }
        for (path, more) in sums {
            match &mut all {
                None => all = Some((path, more)),
                Some((first, all)) => all.merge(more).map_err(|problem| {
                    let with =
                        if first.as_os_str().is_empty() { "the parts".into() } else { first.display().to_string() };
                    Error::Usage(format!("{} and {with}: {problem}", path.display()))
                })?,
            }
        }
        let (_, sums) = all.ok_or_else(|| Error::Usage("no part is given".into()))?;
        Ok((sums, parts))
    }
}

/// The segments of parts.
pub(super) fn rows_of(parts: &[Part]) -> usize {
    parts.iter().map(Part::rows).sum::<u64>() as usize
}

fn fold(parts: &[Part], wanted: &Wanted, units: Units, log: &Log<'_>) -> Result<Sums, Error> {
    crate::fold(parts, wanted, units, &*log.steps("summing", rows_of(parts)))
}
