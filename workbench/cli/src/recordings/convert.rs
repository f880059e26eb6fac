//! `bearing-watch convert`

use std::path::{Path, PathBuf};

use crate::command_line::jobs::Convert;
use crate::command_line::options::Taken;
use crate::command_line::output;
use model::Error;
use model::outputs::{Staged, folder_of};
use model::trace::trace_name;
use traces::reader::{self, Series};
use traces::resample::{Resampled, at_rate};
use traces::table;
use traces::table::{Table, is_unread};
use traces::units::{Quantity, Unit};
use traces::{Candidate, Listing};

/// The name of the time in files that are written.
const TIME: &str = "t_s";

/// Write traces in another format, with other columns, units or rate
///
/// With --to-hz traces are resampled behind an anti-alias filter; a gap is reported, and the trace is split there.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch convert log.mat --columns \"current_a=Current,velocity_rad_s=Speed\" --out log.csv
  bearing-watch convert log.csv --to-hz 100 --out log_100hz.csv")]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) taken: Taken<Convert>,
    /// Columns to write, e.g. current_a=iq_mA A,"angle_rad=integrate(speed_rpm) rad"; by default all columns of numbers
    #[arg(long, value_name = "NAME=CHANNEL", value_delimiter = ',')]
    columns: Vec<String>,
    /// Rows a second to write, at most the recorded rate; by default the rows as they are
    #[arg(long, value_name = "HZ", value_parser = crate::recordings::reading::rate)]
    to_hz: Option<f64>,
    /// File for one trace, or folder for several
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// Format of the files in a folder: csv, tsv, csv.gz, csv.zst, mat, parquet, arrow, npz
    #[arg(long, value_name = "FORMAT", default_value = "csv")]
    format: String,
}

/// Number of gaps of a trace that are listed; further ones are counted.
const TOLD: usize = 3;

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let Some(rate_hz) = args.to_hz else {
        return args.written(&|_, series| {
            let Series { id, times_s, columns } = series;
            Ok(vec![(trace_name(&id).into_owned(), times_s, columns)])
        });
    };
    args.written(&|names, series| {
        let id = trace_name(&series.id).into_owned();
        let times = series.times_s.as_deref().ok_or_else(|| {
            Error::trace(&id, "no time column with a usual name; name it with --time, or give --rate-hz")
        })?;
        let turns: Vec<Option<f64>> = names.iter().map(|(name, _)| turn(name)).collect();
        let wrong = |problem: Error| Error::trace(&id, problem.to_string());
        let Resampled { pieces, gaps, usual_s, left_out } = at_rate(times, &series.columns, &turns, rate_hz).map_err(wrong)?;
        if left_out > 0 {
            output::warn(format!("trace {id}: {left_out} rows that lack a number are left out"));
        }
        for [start, length] in gaps.iter().take(TOLD) {
            output::warn(format!(
                "trace {id}: gap of {length:.4} s at {start:.4} s (a usual step is {usual_s:.5} s); the trace is cut there"
            ));
        }
        if gaps.len() > TOLD {
            let longest = gaps.iter().map(|[_, length]| *length).fold(0.0, f64::max);
            let more = gaps.len() - TOLD;
            let all = format!("{more} more gaps, the longest of all {longest:.4} s");
            output::warn(format!("trace {id}: {all}; the trace is cut there"));
        }
        if pieces.is_empty() {
            return Err(Error::trace(&id, "no piece between gaps is long enough"));
        }
        let count = pieces.len();
        let named = pieces.into_iter().enumerate().map(|(k, piece)| {
            let rows = piece.columns.first().map_or(0, Vec::len);
            let times = (0..rows).map(|row| piece.start_s + row as f64 / rate_hz).collect();
            (if count == 1 { id.clone() } else { format!("{id}_{}", k + 1) }, Some(times), piece.columns)
        });
        Ok(named.collect())
    })
}

/// The length of a turn of a column whose unit is that of an angle.
fn turn(name: &str) -> Option<f64> {
    let unit = Unit::of_column(name).filter(|unit| unit.quantity == Quantity::Angle)?;
    Unit::named("turn")?.to(&unit).map(|(factor, _)| factor)
}

/// Names and channels of columns.
type Columns = Vec<(String, String)>;

/// Id, times and columns of a trace that is written.
type Written = (String, Option<Vec<f64>>, Vec<Vec<f64>>);

/// Makes what is written of a trace, by the names and channels of its columns.
type Make<'a> = &'a dyn Fn(&[(String, String)], Series) -> Result<Vec<Written>, Error>;

impl Args {
    fn written(&self, make: Make<'_>) -> Result<(), Error> {
        let data = &self.taken.settings.data;
        let candidates = self.candidates()?;
        let files: Vec<PathBuf> = candidates.iter().map(|own| own.file.clone()).collect();
        let into_folder = self.out.is_dir() || self.out.extension().is_none();
        if !into_folder {
            output::plan(&[&self.out], &files)?;
        }
        let bar = output::progress("traces", files.len());
        let (mut count, mut alone, mut left_out) = (0, None, Vec::new());
        for own in &candidates {
            let (table, names) = match self.open(own)? {
                Ok(opened) => opened,
                Err(reason) => {
                    left_out.push(reason);
                    bar.inc(1);
                    continue;
                }
            };
            let channels: Vec<String> = names.iter().map(|(_, channel)| channel.clone()).collect();
            let times = (data.time.as_deref(), data.rate_hz);
            for series in reader::series(&table, times, &channels)? {
                for (id, times, columns) in make(&names, series)? {
                    count += 1;
                    if into_folder {
                        let path = self.out.join(format!("{id}.{}", self.format));
                        self.make_folder(&path)?;
                        output::plan(&[&path], &files)?;
                        save(&path, &names, times, columns)?;
                    } else if alone.replace((names.clone(), times, columns)).is_some() {
                        let out = self.out.display();
                        return Err(Error::Usage(format!(
                            "{out} is one file for several traces; give a folder: a name without an ending"
                        )));
                    }
                }
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        if count == 0 {
            return Err(self.nothing(&candidates));
        }
        left_out.iter().take(TOLD).for_each(|reason| output::warn(format!("left out {reason}")));
        if left_out.len() > TOLD {
            output::warn(format!("left out {} more files", left_out.len() - TOLD));
        }
        if let Some((names, times, columns)) = alone {
            save(&self.out, &names, times, columns)?;
        }
        output::say(format!("{count} traces in {}", self.out.display()))
    }

    /// Why nothing is converted: the problem of the first file.
    fn nothing(&self, candidates: &[Candidate]) -> Error {
        let data = &self.taken.settings.data;
        let read = |own: &Candidate| {
            let channels: Vec<String> = self.given_columns().into_iter().map(|(_, channel)| channel).collect();
            reader::series(&own.open(&data.text_form())?, (data.time.as_deref(), data.rate_hz), &channels)
        };
        let problem = candidates.iter().find_map(|own| read(own).err());
        let given: Vec<String> = data.traces.iter().map(|path| path.display().to_string()).collect();
        problem.unwrap_or_else(|| Error::Usage(format!("no recording in {}", given.join(", "))))
    }

    /// The files that are converted. What was written below the recordings before is left out.
    fn candidates(&self) -> Result<Vec<Candidate>, Error> {
        let given = &self.taken.settings.data.traces;
        let Listing { mut candidates, left_out } = Listing::without_labels(given, None)?;
        left_out.iter().for_each(output::warn);
        let whole = |path: &Path| path.canonicalize().ok();
        let Some(out) = whole(&self.out).filter(|out| !given.iter().any(|path| whole(path).as_ref() == Some(out)))
        else {
            return Ok(candidates);
        };
        let count = candidates.len();
        candidates.retain(|own| !(own.is_of_folder() && whole(&own.file).is_some_and(|file| file.starts_with(&out))));
        if candidates.len() < count {
            let out = self.out.display();
            output::warn(format!("left out {} files: {out}: traces are written there", count - candidates.len()));
        }
        Ok(candidates)
    }

    /// Opens a file; of a file in a folder that has no such recordings it returns why.
    fn open(&self, own: &Candidate) -> Result<Result<(Table, Columns), String>, Error> {
        let data = &self.taken.settings.data;
        let table = match own.open(&data.text_form()) {
            // Such as a workbook of labels beside the traces of a folder.
            Err(problem) if own.is_of_folder() && is_unread(&own.file) => return Ok(Err(problem.to_string())),
            table => table?,
        };
        let channels: Vec<String> = self.given_columns().into_iter().map(|(_, channel)| channel).collect();
        if own.is_of_folder() && !reader::has_channels(&table, data.time.as_deref(), &channels) {
            return Ok(Err(format!("{}: it lacks columns of {}", own.file.display(), channels.join(", "))));
        }
        let names = self.names(&table)?;
        if names.is_empty() {
            let problem = Error::content(table.path(), "header", "no column of numbers");
            return if own.is_of_folder() { Ok(Err(problem.to_string())) } else { Err(problem) };
        }
        Ok(Ok((table, names)))
    }

    /// Makes the folder of a file: the one of all, and those that are in the name of a trace.
    fn make_folder(&self, path: &Path) -> Result<(), Error> {
        let folder = folder_of(path);
        if folder.is_dir() {
            return Ok(());
        }
        if !self.out.is_dir() {
            std::fs::create_dir(&self.out).map_err(Error::io(&self.out))?;
        }
        std::fs::create_dir_all(folder).map_err(Error::io(folder))
    }

    /// Names and channels of the columns that are given.
    fn given_columns(&self) -> Columns {
        let pair = |text: &String| {
            let (name, channel) = text.split_once('=').unwrap_or((text, text));
            (name.trim().to_string(), channel.trim().to_string())
        };
        self.columns.iter().map(pair).collect()
    }

    /// Names and channels of the columns of a file: those that are given, or all of numbers.
    fn names(&self, table: &Table) -> Result<Columns, Error> {
        if !self.columns.is_empty() {
            return Ok(self.given_columns());
        }
        let (names, left_out) = reader::numeric(table, self.taken.settings.data.time.as_deref())?;
        for problem in left_out {
            output::warn(format!("{problem}; the column is left out"));
        }
        Ok(names.into_iter().map(|name| (name.clone(), name)).collect())
    }
}

/// Writes a trace, completely or not at all.
fn save(path: &Path, names: &[(String, String)], times: Option<Vec<f64>>, columns: Vec<Vec<f64>>) -> Result<(), Error> {
    let timed = times.is_some() && !names.iter().any(|(name, _)| name == TIME);
    let own = names.iter().map(|(name, _)| name.clone());
    let names: Vec<String> = timed.then(|| TIME.to_string()).into_iter().chain(own).collect();
    let columns: Vec<Vec<f64>> = times.filter(|_| timed).into_iter().chain(columns).collect();
    // The format is chosen by the ending, which the temporary file has too.
    let staged = Staged::new(path)?;
    table::write(staged.path(), &names, &columns)?;
    staged.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_have_the_unit_of_the_column() {
        assert_eq!((turn("angle_deg"), turn("position_mm"), turn("angle")), (Some(360.0), None, None));
        assert!(turn("angle_rad").is_some_and(|turn| (turn - std::f64::consts::TAU).abs() < 1e-12));
    }
}
