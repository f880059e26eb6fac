//! What the files have that `init` looks at.

use std::path::{Path, PathBuf};

use super::asked::Asked;
use super::guess::Guess;
use super::names;
use super::proposal::Proposal;
use crate::table::Table;
use crate::{read_labels, reader};
use model::Error;
use model::audit::times::Times;
use model::outputs;
use model::session::Log;
use model::trace::labels::Labels;

/// Files with the same columns of numbers.
struct Kind {
    names: Vec<String>,
    files: Vec<PathBuf>,
}

impl Kind {
    /// The kinds of files, and the first problem with one.
    fn of(files: &[PathBuf], time: Option<&str>, log: &Log<'_>) -> (Vec<Self>, Option<Error>) {
        let (mut kinds, mut problem): (Vec<Self>, _) = (Vec::new(), None);
        let step = log.steps("files", files.len());
        for file in files {
            match Table::open(file).and_then(|table| reader::numeric(&table, time)) {
                Ok((names, _)) if names.is_empty() => {}
                Ok((names, _)) => match kinds.iter_mut().find(|kind| kind.names == names) {
                    Some(kind) => kind.files.push(file.clone()),
                    None => kinds.push(Self { names, files: vec![file.clone()] }),
                },
                Err(error) => problem = problem.or(Some(error)),
            }
            step(1);
        }
        (kinds, problem)
    }

    /// The kind of most files, with the files of others that have its channels; of equals one with a current, then the
    /// first.
    fn most(kinds: Vec<Self>) -> Option<Self> {
        let current = |kind: &Self| usize::from(Guess::of(&kind.names).current.is_some());
        let most = (0..kinds.len()).rev().max_by_key(|&k| (kinds[k].files.len(), current(&kinds[k])))?;
        let mut kinds = kinds;
        let mut own = kinds.swap_remove(most);
        for other in kinds {
            let shared: Vec<String> = own.names.iter().filter(|name| other.names.contains(name)).cloned().collect();
            if !shared.is_empty() && Proposal::of(&shared).stands_for(&Proposal::of(&own.names)) {
                own.names = shared;
                own.files.extend(other.files);
            }
        }
        own.files.sort_unstable();
        Some(own)
    }
}

/// What the files have.
pub(super) struct Found {
    /// Number of files of the kind that is described, and of others.
    pub(super) files: usize,
    pub(super) others: usize,
    /// What the drive file names.
    pub(super) traces: Vec<PathBuf>,
    /// Why the time is not used.
    pub(super) disorder: Option<String>,
    pub(super) names: Vec<String>,
    /// Rows of the first trace, and rows a second.
    pub(super) rows: usize,
    pub(super) rate_hz: Option<f64>,
    /// Whether the velocity of the first trace is constant.
    pub(super) is_constant: bool,
    /// File and content of the labels, and the classes.
    pub(super) labels: (PathBuf, Labels, Vec<String>),
    /// How the labels were made, if they were.
    pub(super) made: Option<&'static str>,
    pub(super) proposal: Proposal,
}

impl Found {
    pub(super) fn look(
        asked: &Asked<'_>,
        files: &[PathBuf],
        (folder, out): (&Path, &Path),
        log: &Log<'_>,
    ) -> Result<Self, Error> {
        let data = asked.data;
        let time = data.time.as_deref();
        let (kinds, problem) = Kind::of(files, time, log);
        let Some(own) = Kind::most(kinds) else {
            return Err(problem.unwrap_or_else(|| {
                let paths: Vec<String> = data.traces.iter().map(|path| path.display().to_string()).collect();
                Error::Usage(format!("no file with columns of numbers in {}", paths.join(", ")))
            }));
        };
        let (names, proposal) = (own.names.clone(), Proposal::of(&own.names));
        // A single file among others of other kinds is named; several are found by their columns.
        let traces = if own.files.len() == 1 && files.len() > 1 { own.files.clone() } else { data.traces.clone() };
        let table = Table::open(&own.files[0])?;
        let read = |time: Option<&str>| reader::series(&table, (time, data.rate_hz), &names);
        let (series, disorder) = match read(time) {
            Err(problem) if time.is_none() => (read(Some(reader::NO_TIME))?, Some(problem.to_string())),
            other => (other?, None),
        };
        let first = series.first();
        let rows = first.map_or(0, |one| one.columns[0].len());
        let rate_hz = first.and_then(|one| Times::of(one.times_s.as_deref()?)).map(|times| times.rate_hz);
        let is_constant = first.is_some_and(|one| proposal.is_constant(&names, &one.columns));
        let beside = Some(folder.join("labels.csv")).filter(|file| file.is_file());
        let given = asked.labels.map(Path::to_path_buf).or(beside.filter(|_| asked.labels_from_names.is_none()));
        let (file, made) = match given {
            Some(file) => (file, None),
            None => {
                let (text, told) = names::labels(&own.files)?;
                let own_file = || outputs::folder_of(out).join("labels.csv");
                let file = asked.labels_from_names.map_or_else(own_file, Path::to_path_buf);
                outputs::plan(&[&file, out], files)?;
                outputs::write(&file, text)?;
                (
                    file,
                    Some(if told { "by the names of the files" } else { "all healthy, since no name tells a class" }),
                )
            }
        };
        let labels = read_labels(&file)?;
        let classes = labels.classes(&labels.select(&[])?, &[])?;
        let (labels, others) = ((file, labels, classes), files.len() - own.files.len());
        let files = own.files.len();
        Ok(Self { files, others, traces, disorder, names, rows, rate_hz, is_constant, labels, made, proposal })
    }
}
