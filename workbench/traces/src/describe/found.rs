//! What the files have that `init` looks at.

use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};

use super::asked::Asked;
use super::axes::Axes;
use super::kinds::{LeftOut, kinds, label_of, most};
use super::names::{self, Told};
use super::proposal::Proposal;
use super::raw::{self, Extremes, RawFrontEnd};
use super::report::{self, Column};
use crate::front_end::OWN;
use crate::listing::naming::Naming;
use crate::signal::signs::ByName;
use crate::table::Table;
use crate::turning::Turning;
use crate::{read_labels, reader};
use model::Error;
use model::audit::times::Times;
use model::outputs;
use model::session::Log;
use model::settings::Data;
use model::trace::TextForm;
use model::trace::labels::Labels;

/// What the files have.
pub(super) struct Found {
    /// Number of files of the kind that is described, and the others with the reasons.
    pub(super) files: usize,
    pub(super) left: Vec<LeftOut>,
    /// Columns that are left out of all files, with the reasons.
    pub(super) columns_left: Vec<String>,
    /// They, and what the drive file names.
    pub(super) all: Vec<PathBuf>,
    pub(super) traces: Vec<PathBuf>,
    /// Why the time is not used.
    pub(super) disorder: Option<String>,
    pub(super) names: Vec<String>,
    /// The columns of the first recording, as they are shown.
    pub(super) columns: Vec<Column>,
    /// Rows of the first trace, and rows a second.
    pub(super) rows: usize,
    pub(super) rate_hz: Option<f64>,
    /// Whether the velocity of the first trace is constant.
    pub(super) is_constant: bool,
    /// File and content of the labels, and the classes.
    pub(super) labels: (PathBuf, Labels, Vec<String>),
    /// How the classes of labels were told that were made.
    pub(super) made: Option<Told>,
    pub(super) proposal: Proposal,
    /// The units of angle and velocity.
    pub(super) turning: Turning,
    /// How columns are written whose numbers are signed ones without their sign.
    pub(super) signs: ByName,
    /// Which of several motors in one file is described, and the motors that files are of.
    pub(super) axes: Option<Axes>,
    pub(super) motors: Vec<String>,
    /// What was guessed or is asked of the channels, a sentence each.
    pub(super) doubts: Vec<String>,
    /// The front end of recordings at the control rate, if it was asked for.
    pub(super) front_end: Option<RawFrontEnd>,
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
        let (kinds, mut left) = kinds(files, data, log);
        let Some(own) = most(kinds, &mut left) else { return Err(nothing(&data.traces, &left)) };
        let names = own.names.clone();
        // Files of a folder are found by their columns and labels; those are named beside which others cannot be read.
        let of_kind: HashSet<_> = own.files.iter().map(|file| label_of(file)).collect();
        let of_others = left.iter().any(|other| of_kind.contains(&label_of(&other.file)));
        let single = own.files.len() == 1 && files.len() > 1;
        let traces = if single || of_others { own.files.clone() } else { folders_of(&data.traces, &own.files) };
        let table = Table::open_as(&own.files[0], &data.text_form())?;
        let read = |time: Option<&str>| reader::series(&table, (time, data.rate_hz), &names);
        let (mut series, disorder) = match read(time) {
            // What is wrong with the time says more than what is wrong without it.
            Err(problem) if time.is_none() => match read(Some(reader::NO_TIME)) {
                Ok(series) => (series, Some(problem.to_string())),
                Err(_) => return Err(problem),
            },
            other => (other?, None),
        };
        if let Some(first) = series.first_mut().filter(|_| asked.front_end.is_none()) {
            first.columns.iter_mut().zip(&names).for_each(|(column, name)| {
                if let Some(signs) = own.signs.get(name) {
                    column.iter_mut().for_each(|x| *x = signs.decoded(*x));
                }
            });
        }
        let first = series.first();
        let rows = first.map_or(0, |one| one.columns[0].len());
        let rate_hz = first.and_then(|one| Times::of(one.times_s.as_deref()?)).map(|times| times.rate_hz);
        let rate_hz = rate_hz.or(data.rate_hz);
        let front_end = match (asked.front_end, first) {
            (Some(_), Some(one)) => {
                let problem = |problem: String| Error::content(&own.files[0], "front end", problem);
                let phases = raw::phase_names(&names, &one.columns).map_err(problem)?;
                let all = extremes(&own.files, &phases, data);
                let made = raw::front_end((&names, &one.columns), rate_hz, all).map_err(problem)?;
                let columns = made.file.columns();
                if let Some((name, signs)) = own.signs.iter().find(|(name, _)| columns.contains(&name.as_str())) {
                    let told = signs.told(name);
                    let cure = "a front end reads counts with their sign; write them with convert --columns first";
                    return Err(problem(format!("{told}; {cure}")));
                }
                Some(made)
            }
            _ => None,
        };
        let factor = front_end.as_ref().map_or(1, |front_end| front_end.file.factor);
        let (rows, rate_hz) = (rows / factor, rate_hz.map(|rate_hz| rate_hz / factor as f64));
        let recorded = first.filter(|_| front_end.is_none());
        let axes = recorded.and_then(|one| Axes::of(&names, &one.columns));
        let of_axis = axes.as_ref().map_or(&names, |axes| &axes.kept);
        let (channels, blank) = match (&front_end, first) {
            (Some(front_end), _) => (channels_behind(front_end, &names), vec![]),
            (None, Some(one)) => signals(names.iter().zip(&one.columns).filter(|(name, _)| of_axis.contains(name))),
            (None, None) => (names.clone(), vec![]),
        };
        let mut proposal = Proposal::of(&channels);
        let turning = recorded.map(|one| proposal.turning(&names, &one.columns, rate_hz)).unwrap_or_default();
        let mut doubts: Vec<String> = axes.iter().map(|axes| axes.said.clone()).chain(blank).collect();
        let is_used = |name: &&String| channels.contains(name);
        doubts.extend(own.signs.iter().filter(|(name, _)| is_used(name)).map(|(name, signs)| signs.told(name)));
        doubts.extend(proposal.doubts(front_end.is_some()));
        doubts.extend(turning.told());
        if front_end.is_some() && proposal.by_reference && !proposal.alone {
            // The front end of a drive makes columns, and no difference of them.
            proposal.u1 = proposal.guess.velocity_ref.clone().or(proposal.u1);
        }
        let columns = report::columns(&names, first);
        let is_constant = first.is_some_and(|one| proposal.is_constant(&names, &one.columns));
        let beside = Some(folder.join("labels.csv")).filter(|file| file.is_file());
        let given = asked.labels.map(Path::to_path_buf).or(beside.filter(|_| asked.labels_from_names.is_none()));
        let (file, made) = match given {
            Some(file) => (file, None),
            None => {
                let (text, told) = names::labels(
                    &ids((&own.files, &own.tidy), &names[..1], &data.text_form())?,
                    &Naming::of(&data.traces, files),
                )?;
                let own_file = || outputs::folder_of(out).join("labels.csv");
                let file = asked.labels_from_names.map_or_else(own_file, Path::to_path_buf);
                outputs::plan(&[&file, out], files)?;
                outputs::write(&file, text)?;
                (file, Some(told))
            }
        };
        let labels = read_labels(&file)?;
        let classes = labels.classes(&labels.select(&[])?, &[])?;
        let motors = labels.distinct(names::AXIS);
        let motors = if motors.len() > 1 { motors } else { vec![] };
        let labels = (file, labels, classes);
        let files = own.files.len();
        Ok(Self {
            all: own.files,
            columns_left: own.columns_left,
            files,
            left,
            traces,
            disorder,
            columns,
            names,
            rows,
            rate_hz,
            is_constant,
            labels,
            made,
            proposal,
            turning,
            signs: own.signs,
            axes,
            motors,
            doubts,
            front_end,
        })
    }
}

impl Found {
    /// Whether a channel is a column as it is.
    pub(super) fn is_plain(&self, channel: &String) -> bool {
        self.names.contains(channel) && !self.signs.contains_key(channel)
    }
}

/// Of some recordings among all, what no other front end must be made for. Files that were read before are read.
fn extremes(files: &[PathBuf], phases: &[String], data: &Data) -> Extremes {
    /// Files that are read at most.
    const MOST: usize = 64;
    let some = files.iter().step_by(files.len().div_ceil(MOST).max(1));
    some.fold(Extremes::default(), |all, file| {
        let table = Table::open_as(file, &data.text_form());
        let read = table.and_then(|table| reader::series(&table, (Some(reader::NO_TIME), None), phases));
        let series = read.unwrap_or_default();
        series.iter().fold(all, |all, one| all.with(&one.columns.iter().map(Vec::as_slice).collect::<Vec<_>>()))
    })
}

/// The channels behind a front end: its own, and the columns that it does not read.
fn channels_behind(front_end: &RawFrontEnd, names: &[String]) -> Vec<String> {
    let read = front_end.file.columns();
    let further = names.iter().filter(|name| !read.contains(&name.as_str())).cloned();
    OWN.iter().map(ToString::to_string).chain(further).collect()
}

/// The columns that are signals, and what is said of others: those that stand, or count, all the time are none, nor are
/// those that lack most rows. If none is left, all are.
fn signals<'a>(columns: impl Iterator<Item = (&'a String, &'a Vec<f64>)>) -> (Vec<String>, Vec<String>) {
    let is_line = |column: &Vec<f64>| {
        let mut steps = column.windows(2).map(|pair| pair[1] - pair[0]);
        let Some(first) = steps.next() else { return true };
        (first == 0.0 || first == 1.0) && steps.all(|step| step == first)
    };
    // Columns that stand or count are the last choice, those that lack most rows the second.
    let ranked = |(name, column): (&'a String, &'a Vec<f64>)| {
        let blank = blank(name, column);
        (if is_line(column) { 2 } else { u8::from(blank.is_some()) }, name, blank)
    };
    let all: Vec<(u8, &String, Option<String>)> = columns.map(ranked).collect();
    let best = all.iter().map(|(rank, ..)| *rank).min();
    let (kept, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|(rank, ..)| Some(*rank) == best);
    let said = others.into_iter().filter_map(|(.., blank)| blank).collect();
    (kept.into_iter().map(|(_, name, _)| name.clone()).collect(), said)
}

/// What is said of a column that lacks most rows.
pub(crate) fn blank(name: &str, column: &[f64]) -> Option<String> {
    /// Part of the rows.
    const MOST: f64 = 0.5;
    let part = column.iter().filter(|x| !x.is_finite()).count() as f64 / column.len().max(1) as f64;
    (part > MOST).then(|| {
        format!("column {name} has no number in {:.0} % of the rows: it is not taken as a channel", 100.0 * part)
    })
}

/// The files, and of a tidy table its traces in its place.
fn ids(
    (files, tidy): (&[PathBuf], &BTreeSet<PathBuf>),
    channels: &[String],
    form: &TextForm,
) -> Result<Vec<PathBuf>, Error> {
    let mut all = Vec::new();
    for file in files {
        if tidy.contains(file) {
            // Only the ids are wanted, whatever the times are.
            let series = reader::series(&Table::open_as(file, form)?, (Some(reader::NO_TIME), None), channels)?;
            all.extend(series.into_iter().map(|one| file.with_file_name(one.id)));
        } else {
            all.push(file.clone());
        }
    }
    Ok(all)
}

/// Why there is nothing to describe.
fn nothing(paths: &[PathBuf], left: &[LeftOut]) -> Error {
    /// Files that are named.
    const NAMED: usize = 5;
    let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let reasons: Vec<String> = left.iter().take(NAMED).map(LeftOut::told).collect();
    let more = left.len().saturating_sub(NAMED);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    let reasons = if reasons.is_empty() { "no file of a known format".into() } else { reasons.join("; ") };
    Error::Usage(format!("no recording can be read in {}: {reasons}{more}", paths.join(", ")))
}

/// The paths as they were given, or the folders below them in which the files are.
fn folders_of(given: &[PathBuf], files: &[PathBuf]) -> Vec<PathBuf> {
    let is_in = |file: &PathBuf| given.iter().any(|path| file.starts_with(path));
    if files.iter().all(is_in) {
        return given.to_vec();
    }
    let folders: BTreeSet<PathBuf> = files.iter().filter_map(|file| file.parent().map(Path::to_path_buf)).collect();
    folders.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_constants_and_columns_that_lack_most_rows_are_no_signals() {
        type Of = fn(u32) -> f64;
        let columns: [(&str, Of); 5] = [
            ("X", |k| f64::from(k)),
            ("gain", |_| 3.0),
            ("iq", |k| (0.1 * f64::from(k)).sin()),
            ("load", |k| if k % 5 < 2 { f64::from(k % 7) } else { f64::NAN }),
            ("speed", |k| if k % 5 < 3 { f64::from(k % 7) } else { f64::NAN }),
        ];
        let all: Vec<(String, Vec<f64>)> =
            columns.iter().map(|(name, of)| ((*name).to_string(), (0..500).map(of).collect())).collect();
        let of = |own: &[(String, Vec<f64>)]| signals(own.iter().map(|(name, column)| (name, column)));
        let (kept, said) = of(&all);
        assert_eq!(kept, ["iq", "speed"]);
        assert_eq!(said, ["column load has no number in 60 % of the rows: it is not taken as a channel"]);
        // Where nothing else is left, they are.
        assert_eq!(of(&all[3..4]), (vec!["load".into()], vec![]));
        assert_eq!(of(&all[..2]).0, ["X", "gain"]);
    }
}
