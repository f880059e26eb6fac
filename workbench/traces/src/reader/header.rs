//! What the columns of a table are: traces, the time, and signals.

use std::collections::HashMap;

use crate::reader::assemble::NO_TIME;
use crate::signal::{Role, Signal};
use crate::table::{About, Table};
use crate::time::names::{seconds, usual};
use model::Error;
use model::near::among;
use model::trace::{Channels, ShaftChannels, composed, trace_name};

/// The names of the columns.
pub(crate) struct Header {
    names: Vec<String>,
    /// Place of the ids of the traces.
    pub(crate) trace: Option<usize>,
    /// Place of the time, and the factor to seconds.
    pub(crate) time: Option<(usize, f64)>,
    /// Places of columns that repeat the time.
    pub(crate) twins: Vec<usize>,
    /// Place of the part of a second that the time lacks, and the seconds of its unit.
    pub(crate) fraction: Option<(usize, f64)>,
}

impl Header {
    /// Of these columns; `time` is the column that was asked for, and the table tells which others are times.
    ///
    /// # Errors
    /// There is no such column.
    pub(crate) fn of(names: Vec<String>, time: Option<&str>, about: &About) -> Result<Self, String> {
        let factor =
            |place: usize| if about.clocks.contains(&place) { 1.0 } else { seconds(&names[place]).unwrap_or(1.0) };
        let time = match time {
            Some(NO_TIME) => None,
            Some(wanted) => {
                let place = names.iter().position(|name| *name == composed(wanted));
                let place = place.ok_or_else(|| format!("no column {wanted} for the time{}", among(wanted, &names)))?;
                Some((place, factor(place)))
            }
            None => {
                let is_time = |place: &usize| usual(&names[*place]).is_some() && !about.counters.contains(place);
                // Dates and the like are a time whatever their column is called.
                let place = (0..names.len()).find(is_time).or_else(|| about.clocks.first().copied());
                let unit = |place: usize| usual(&names[place]).flatten().filter(|_| !about.clocks.contains(&place));
                place.map(|place| (place, unit(place).unwrap_or_else(|| factor(place))))
            }
        };
        let twins = about.twins.clone();
        let fraction = about.fraction.filter(|(place, _)| time.is_some_and(|(time, _)| time + 1 == *place));
        Ok(Self { fraction, trace: names.iter().position(|name| name == "trace"), time, twins, names })
    }

    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    pub(crate) fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|column| column == name)
    }

    /// Whether a column holds the time or repeats it, or a part of it.
    pub(crate) fn is_time(&self, place: usize) -> bool {
        self.time() == Some(place)
            || self.twins.contains(&place)
            || self.fraction.is_some_and(|(fraction, _)| fraction == place)
    }

    /// Place of the time.
    pub(crate) fn time(&self) -> Option<usize> {
        self.time.map(|(place, _)| place)
    }

    /// A wanted column whose name occurs twice.
    pub(crate) fn doubled(&self, places: &[usize]) -> Option<&str> {
        let wanted = places.iter().copied().chain(self.trace).chain(self.time());
        let mut counts: HashMap<&str, usize> = HashMap::new();
        let single = self.names.iter().enumerate().filter(|(place, _)| !self.twins.contains(place));
        single.for_each(|(_, name)| *counts.entry(name).or_default() += 1);
        wanted.map(|place| self.names[place].as_str()).find(|name| counts[name] > 1)
    }

    /// Signals of y, u1, u2, of the further columns, and, if the shaft is watched, of current and angle, and of
    /// velocity, load and reference if they are given.
    pub(crate) fn signals(&self, channels: &Channels) -> Result<Vec<Signal>, String> {
        if self.names.iter().all(String::is_empty) {
            return Err("the file is empty".into());
        }
        let all = channels.in_order();
        let of_shaft = channels.shaft.as_ref().map_or_else(Vec::new, roles);
        let first = all.len() - of_shaft.len();
        let parsed = all.into_iter().enumerate().map(|(k, channel)| match k.checked_sub(first) {
            Some(place) => Signal::of_role(channel, &self.names, of_shaft[place]),
            None => Signal::parse(channel, &self.names),
        });
        parsed.collect()
    }
}

/// What the channels of a shaft are, in their order.
fn roles(ShaftChannels { velocity, load, reference, .. }: &ShaftChannels) -> Vec<Role> {
    let further = [(velocity, Role::Velocity), (load, Role::Load), (reference, Role::Velocity)];
    let given = further.into_iter().filter(|(channel, _)| channel.is_some()).map(|(_, role)| role);
    [Role::Current, Role::Angle].into_iter().chain(given).collect()
}

/// The header of a table.
pub(crate) fn header_of(table: &Table, time: Option<&str>) -> Result<Header, Error> {
    Header::of(table.names().to_vec(), time, table.about())
        .map_err(|problem| Error::content(table.path(), "header", problem))
}

/// Whether a table may have wanted traces: its only one is, or it has several.
pub(crate) fn is_wanted(header: &Header, table: &Table, wanted: &(dyn Fn(&str) -> bool + Sync)) -> bool {
    header.trace.is_some() || wanted(&trace_name(&table.id()))
}
