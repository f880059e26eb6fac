//! Labelled traces that are selected, and which of them are alike.

use std::collections::HashSet;
use std::path::PathBuf;

use super::source::{Given, TemperatureColumn, TraceSource};
use crate::Error;
use crate::settings::{Settings, Validation};
use crate::trace::labels::LabelledTrace;
use crate::trace::{Channels, Condition, Labels};

/// The labels, and where their traces are.
#[derive(Debug)]
pub struct Selection {
    labels: Labels,
    file: Option<PathBuf>,
    source: Box<dyn TraceSource>,
    channels: Channels,
    conditions: Vec<Condition>,
    asked: Vec<String>,
}

/// Columns of labels whose rows of one value are of one run. A load or a speed is a condition, not a run.
const RUNS: [&str; 8] = ["run", "session", "unit", "drive", "day", "date", "batch", "serial"];
/// The name of no column: traces are independent.
pub(super) const INDEPENDENT: &str = "none";

/// Class names, and id and class of each trace.
pub type Chosen = (Vec<String>, Vec<(String, String)>);

impl Selection {
    /// What the settings select of what is given.
    #[must_use]
    pub fn new(settings: &Settings, given: Given, channels: Channels) -> Self {
        let Given { labels, file, source, front_end: _ } = given;
        let (conditions, asked) = (settings.data.conditions.clone(), settings.data.classes.clone());
        Self { labels, file, source, channels, conditions, asked }
    }

    /// Returns the files that are read; no output may replace them.
    #[must_use]
    pub fn inputs(&self) -> Vec<PathBuf> {
        self.source.paths().iter().chain(&self.file).cloned().collect()
    }

    /// Returns the class names, and id and class of each trace that meets the common conditions and these further ones.
    ///
    /// # Errors
    /// An unknown column or class, or no such trace.
    pub fn chosen(&self, further: &[Condition]) -> Result<Chosen, Error> {
        let conditions = [&self.conditions, further].concat();
        let mut chosen = self.labels.select(&conditions)?;
        let classes = self.labels.classes(&chosen, &self.asked)?;
        chosen.retain(|(_, name)| classes.contains(name));
        Ok((classes, chosen))
    }

    /// Where the traces are.
    #[must_use]
    pub fn source(&self) -> &dyn TraceSource {
        self.source.as_ref()
    }

    /// What is left out of the traces, in lines.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn left_out(&self) -> Result<Vec<String>, Error> {
        self.source.left_out(&self.channels, &self.labels.names())
    }

    /// The labels.
    #[must_use]
    pub const fn labels(&self) -> &Labels {
        &self.labels
    }

    /// Returns the class names and the traces of the rows that meet the common conditions and these further ones.
    ///
    /// # Errors
    /// Those of [`Selection::chosen`] and [`Selection::read`].
    pub fn rows(&self, further: &[Condition]) -> Result<(Vec<String>, Vec<LabelledTrace>), Error> {
        self.rows_of(further, &self.channels)
    }

    /// The same with these channels instead of its own.
    ///
    /// # Errors
    /// Those of [`Selection::rows`].
    pub fn rows_of(
        &self,
        further: &[Condition],
        channels: &Channels,
    ) -> Result<(Vec<String>, Vec<LabelledTrace>), Error> {
        let (classes, chosen) = self.chosen(further)?;
        let traces = self.read_of(&classes, &chosen, channels)?;
        Ok((classes, traces))
    }

    /// Reads these of the chosen traces.
    ///
    /// # Errors
    /// Traces that cannot be read, or are not there.
    pub fn read(&self, classes: &[String], chosen: &[(String, String)]) -> Result<Vec<LabelledTrace>, Error> {
        self.read_of(classes, chosen, &self.channels)
    }

    fn read_of(
        &self,
        classes: &[String],
        chosen: &[(String, String)],
        channels: &Channels,
    ) -> Result<Vec<LabelledTrace>, Error> {
        let wanted = ids(chosen);
        let traces = self.source.read_wanted(channels, &|id| wanted.contains(id))?;
        self.labels.join(chosen, classes, &traces)
    }

    /// Returns the columns that are temperatures by name or unit, of the traces that [`Selection::chosen`] gives for
    /// any of these conditions.
    ///
    /// # Errors
    /// Those of [`Selection::chosen`], and a folder that cannot be read.
    pub fn temperatures(&self, further: &[&[Condition]]) -> Result<Vec<TemperatureColumn>, Error> {
        let mut all = vec![];
        for further in further {
            all.extend(self.chosen(further)?.1);
        }
        let wanted = ids(&all);
        self.source.temperatures(&self.channels, &|id| wanted.contains(id))
    }

    /// Returns the cells of a column of the labels, one for each trace.
    ///
    /// # Errors
    /// An unknown column.
    pub fn cells(&self, column: &str, traces: &[LabelledTrace]) -> Result<Vec<String>, Error> {
        self.labels.cells(column, traces.iter().map(|t| t.trace.id.as_str()))
    }

    /// Returns the columns of the labels that may tell runs: those with several values, one for several traces each.
    ///
    /// # Errors
    /// Those of [`Selection::cells`].
    pub fn columns(&self, traces: &[LabelledTrace]) -> Result<Vec<(String, Vec<String>)>, Error> {
        let further = self.labels.columns().iter().filter(|name| RUNS.contains(&name.to_lowercase().as_str()));
        let mut columns = vec![];
        for name in further {
            let cells = self.cells(name, traces)?;
            let values: HashSet<&String> = cells.iter().collect();
            if values.len() > 1 && 2 * values.len() <= cells.len() {
                columns.push((name.clone(), cells));
            }
        }
        Ok(columns)
    }

    /// Returns the run and the unit of each trace.
    ///
    /// # Errors
    /// An unknown column, or a trace without a unit.
    pub fn groups(&self, by: &Validation, traces: &[LabelledTrace]) -> Result<Groups, Error> {
        let column = |name: &Option<String>| {
            name.as_ref().filter(|name| *name != INDEPENDENT).map(|name| self.cells(name, traces)).transpose()
        };
        let (runs, units) = (column(&by.group)?, column(&by.unit)?);
        let empty = units.iter().flatten().position(String::is_empty);
        if let (Some(place), Some(column)) = (empty, &by.unit) {
            return Err(Error::trace(&traces[place].trace.id, format!("no unit in column {column} of the labels")));
        }
        let runs = match (runs, &units) {
            (Some(runs), Some(units)) if by.group != by.unit => {
                Some(units.iter().zip(&runs).map(|(unit, run)| format!("{unit}/{run}")).collect())
            }
            (runs, units) => runs.or_else(|| units.clone()),
        };
        Ok(Groups { runs, units })
    }
}

/// The ids of chosen traces.
fn ids(chosen: &[(String, String)]) -> HashSet<&str> {
    chosen.iter().map(|(id, _)| id.as_str()).collect()
}

/// The run and the unit of each trace, if they are known; the name of a run starts with that of its unit.
#[derive(Debug)]
pub struct Groups {
    /// Runs.
    pub runs: Option<Vec<String>>,
    /// Units.
    pub units: Option<Vec<String>>,
}

impl Groups {
    /// What intervals count: units, or runs without them.
    pub(crate) fn clusters(&self) -> Option<&[String]> {
        self.units.as_deref().or(self.runs.as_deref())
    }

    /// Returns an error if a unit is among those of the training.
    ///
    /// # Errors
    /// One is.
    pub(crate) fn refuse_known(&self, trained: &[String]) -> Result<(), Error> {
        let shared = self.units.iter().flatten().find(|unit| trained.contains(unit));
        shared.map_or(Ok(()), |unit| {
            let problem = format!("unit {unit} is both in training and in test; give other units to one of them");
            Err(Error::Usage(format!("{problem}, or leave out --unit to judge later runs of known drives")))
        })
    }
}
