//! The traces of a table with the channels that are looked at: those that are given, or likely ones.

use std::sync::Arc;

use super::audited::Audited;
use crate::describe::guess::{Guess, converted};
use crate::reader::{self, Series};
use crate::table::Table;
use crate::turning::{Column as Turned, Turning};
use crate::units::{Unit, stated};
use model::Error;
use model::audit::column::Column;
use model::audit::times::Times;
use model::settings::{Settings, Signals};
use model::trace::{bridged, trace_name};

/// The columns of a table and what is taken of them.
struct Chosen {
    /// Columns of numbers.
    names: Vec<String>,
    likely: Guess,
    /// Current, velocity, angle, reference of the velocity, load: formulas in A, rad/s and rad.
    channels: [Option<String>; 5],
    /// Whether angle and velocity are likely ones, whose units the values may tell.
    by_values: [bool; 2],
    /// What was left out or guessed.
    left_out: Vec<String>,
}

impl Chosen {
    fn of(table: &Table, time: Option<&str>, given: &Signals) -> Result<Self, Error> {
        let (names, problems) = reader::numeric(table, time)?;
        let of_columns = problems.iter().map(|problem| match problem {
            Error::Content { place, problem, .. } => format!("{place}: left out: {problem}"),
            other => other.to_string(),
        });
        let mut left_out: Vec<String> = table.about().told().chain(of_columns).collect();
        let likely = Guess::of(&names);
        let Signals { current, velocity, angle, velocity_ref, load, .. } = given;
        // A question about a unit is answered by the values, or asked again.
        let answered = |given: &Option<String>| given.clone().filter(|given| !given.contains('?'));
        let channels = [
            (current, &likely.current, "A"),
            (velocity, &likely.velocity, "rad/s"),
            (angle, &likely.angle, "rad"),
            (velocity_ref, &likely.velocity_ref, "rad/s"),
            (load, &likely.load, ""),
        ];
        let channels = channels.map(|(given, likely, unit)| {
            answered(given).or_else(|| likely.clone()).map(|channel| converted(&channel, unit))
        });
        let of_current = channels[0].as_ref().and_then(|name| Some((name, stated(name)?)));
        if let Some((name, unit)) = of_current.filter(|(_, unit)| Unit::named(unit).is_none()) {
            left_out.push(format!("the unit {unit} of {name} is not known: it is taken as A"));
        }
        let by_values = [angle, velocity].map(|given| answered(given).is_none());
        Ok(Self { names, likely, channels, by_values, left_out })
    }

    /// What tells the units of angle and velocity, and their values in the place of the channels where no name tells
    /// the unit; the columns are found by their names.
    fn turning<'a>(
        &'a self,
        of_name: &dyn Fn(&str) -> Option<&'a [f64]>,
        rate_hz: Option<f64>,
    ) -> (Turning, [Option<Vec<f64>>; 2]) {
        let [_, velocity, angle, ..] = &self.channels;
        let turned = |by_values: bool, likely: &'a Option<String>, given: &'a Option<String>, name: &'static str| {
            let likely =
                likely.as_deref().filter(|_| by_values).and_then(|name| Some(Turned { name, values: of_name(name)? }));
            likely.or_else(|| Some(Turned { name, values: of_name(given.as_deref()?)? }))
        };
        let angle = turned(self.by_values[0], &self.likely.angle, angle, "angle_rad");
        let velocity = turned(self.by_values[1], &self.likely.velocity, velocity, "velocity_rad_s");
        let turning = Turning::of(angle, velocity, rate_hz);
        let values = [(&turning.angle, angle), (&turning.velocity, velocity)].map(|(channel, column)| {
            let channel = channel.as_ref().filter(|channel| channel.said.is_some());
            channel.zip(column).map(|(channel, column)| channel.values(&column))
        });
        (turning, values)
    }
}

/// The traces of a table, with the channels that are given.
pub(super) fn look(table: &Table, settings: &Settings, given: &Signals) -> Result<Vec<Audited>, Error> {
    let (time, rate_hz) = (settings.data.time.as_deref(), settings.data.rate_hz);
    let chosen = Chosen::of(table, time, given)?;
    let names = &chosen.names;
    // A channel that is a column is not read again.
    let computed = chosen.channels.iter().flatten().filter(|channel| !names.contains(channel));
    let channels: Vec<String> = names.iter().chain(computed).cloned().collect();
    let read = reader::series(table, (time, rate_hz), &channels)?;
    let recorded = reader::has_time(table, time);
    let each = |series: Series| {
        let all: Vec<Arc<Vec<f64>>> = series.columns.into_iter().map(Arc::new).collect();
        let of_name = |name: &String| Some(&all[channels.iter().position(|own| own == name)?]);
        let times = series.times_s.as_deref().filter(|_| recorded).and_then(Times::of);
        let values = all[..names.len()].to_vec();
        let used: Vec<Arc<Vec<f64>>> = chosen.channels.iter().flatten().filter_map(of_name).cloned().collect();
        let missing = Audited::missing(times.as_ref(), &values, &used);
        let [current, velocity, angle, velocity_ref, load] =
            std::array::from_fn(|k| chosen.channels[k].as_ref().and_then(of_name).map(whole));
        let slice = |name: &str| Some(all[channels.iter().position(|own| own == name)?].as_slice());
        let rate_hz = times.map(|times| times.rate_hz).or(rate_hz);
        let (turning, told) = chosen.turning(&slice, rate_hz);
        let [angle_told, velocity_told] = told.map(|values| values.map(|values| whole(&Arc::new(values))));
        Audited {
            id: trace_name(&series.id).into_owned(),
            names: names.clone(),
            left_out: chosen.left_out.clone(),
            times,
            missing,
            times_s: series.times_s.filter(|_| recorded),
            columns: values.iter().map(|column| Column::of(column)).collect(),
            values,
            current,
            velocity: velocity_told.or(velocity),
            angle: angle_told.or(angle),
            turning,
            velocity_ref,
            load,
        }
    };
    Ok(read.into_iter().map(each).collect())
}

/// A channel in which the last value stands for a missing one.
fn whole(values: &Arc<Vec<f64>>) -> Arc<Vec<f64>> {
    if values.iter().all(|x| x.is_finite()) { Arc::clone(values) } else { Arc::new(bridged(values)) }
}
