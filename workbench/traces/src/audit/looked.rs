//! The traces of a table with the channels that are looked at: those that are given, or likely ones.

use std::path::Path;
use std::sync::Arc;

use super::audited::Audited;
use crate::describe::axes::Axes;
use crate::describe::found::blank;
use crate::describe::guess::{Guess, converted};
use crate::reader::assemble::{INTEGRAL, elapsed};
use crate::reader::{self, Series};
use crate::signal::signs;
use crate::signal::{Role, Signal};
use crate::table::Table;
use crate::turning::{Column as Turned, Turning};
use crate::units::{Unit, stated};
use model::Error;
use model::audit::column::Column;
use model::audit::signs::Signs;
use model::audit::times::Times;
use model::settings::{Settings, Signals};
use model::trace::{bridged, trace_name};

/// The columns of a table and what is taken of them.
struct Chosen {
    likely: Guess,
    /// Current, velocity, angle, reference of the velocity, load: formulas in A, rad/s and rad.
    channels: [Option<String>; 5],
    /// Whether angle and velocity are likely ones, whose units the values may tell.
    by_values: [bool; 2],
    /// What was left out or guessed.
    said: Vec<String>,
}

impl Chosen {
    fn of(names: &[String], columns: &[Vec<f64>], given: &Signals) -> Self {
        let axes = Axes::of(names, columns);
        let of_axis = axes.as_ref().map_or(names, |axes| &axes.kept);
        let columns = || names.iter().zip(columns).filter(|(name, _)| of_axis.contains(name));
        let (blank, measured): (Vec<_>, Vec<_>) =
            columns().map(|(name, column)| (name.clone(), blank(name, column))).partition(|(_, blank)| blank.is_some());
        let measured: Vec<String> = measured.into_iter().map(|(name, _)| name).collect();
        let likely = Guess::of(if measured.is_empty() { of_axis } else { &measured });
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
        let unknown = |(place, taken): (usize, &str)| {
            let name = channels[place].as_ref()?;
            let unit = stated(name).filter(|unit| Unit::named(unit).is_none())?;
            Some(format!("the unit {unit} of {name} is not known: it is taken as {taken}"))
        };
        let mut said: Vec<String> = [(0, "A"), (4, "it is")].into_iter().filter_map(unknown).collect();
        // Which motor is looked at is known where the user has named its channels.
        let is_given = [current, velocity, angle].iter().any(|given| answered(given).is_some());
        said.extend(axes.filter(|_| !is_given).map(|axes| axes.said));
        said.extend(blank.into_iter().filter_map(|(_, blank)| blank).filter(|_| !is_given));
        let by_values = [angle, velocity].map(|given| answered(given).is_none());
        Self { likely, channels, by_values, said }
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
    let (names, problems) = reader::numeric(table, time)?;
    let of_columns = problems.iter().map(|problem| match problem {
        Error::Content { place, problem, .. } => format!("{place}: left out: {problem}"),
        other => other.to_string(),
    });
    let left_out: Vec<String> = table.about().told().chain(of_columns).collect();
    let recorded = reader::has_time(table, time);
    let each = |mut series: Series| {
        let all = &mut series.columns;
        let signs = names.iter().zip(all).filter_map(|(name, column)| {
            let own = signs::of_column(name, column)?;
            column.iter_mut().for_each(|x| *x = own.decoded(*x));
            Some((name, own))
        });
        let is_decoded = |(name, own): &(&String, Signs)| {
            let word = format!("{}({name}", own.word());
            let Signals { current, velocity, angle, velocity_ref, load, .. } = given;
            let all = [current, velocity, angle, velocity_ref, load];
            let ends = |rest: &str| rest.starts_with([')', '[']);
            all.into_iter().flatten().any(|channel| channel.split(word.as_str()).skip(1).any(ends))
        };
        let signs: Vec<String> = signs.filter(|own| !is_decoded(own)).map(|(name, own)| own.told(name)).collect();
        let chosen = Chosen::of(&names, &series.columns, given);
        audited(
            series,
            (table.path(), &names, &chosen),
            (recorded, rate_hz),
            left_out.iter().chain(&signs).cloned().collect(),
        )
    };
    reader::series(table, (time, rate_hz), &names)?.into_iter().map(each).collect()
}

/// A trace with its channels; whether its times are recorded, and the rate that is given.
fn audited(
    series: Series,
    (path, names, chosen): (&Path, &[String], &Chosen),
    (recorded, rate_hz): (bool, Option<f64>),
    left_out: Vec<String>,
) -> Result<Audited, Error> {
    let Series { id, times_s, columns } = series;
    let values: Vec<Arc<Vec<f64>>> = columns.into_iter().map(Arc::new).collect();
    let rows = values.first().map_or(0, |own| own.len());
    // A channel that is a column is not computed.
    let of_channel = |channel: &String, role: Role| {
        if let Some(place) = names.iter().position(|own| own == channel) {
            return Ok(Arc::clone(&values[place]));
        }
        let signal = Signal::of_role(channel, names, role).or_else(|_| Signal::parse(channel, names));
        let signal = signal.map_err(|problem| Error::content(path, "header", problem))?;
        if times_s.is_none() && signal.integrates() {
            return Err(Error::trace(&id, INTEGRAL));
        }
        Ok(Arc::new(signal.values(rows, &|place| &values[place], &elapsed(times_s.as_deref(), 0.0))))
    };
    let roles = [Role::Current, Role::Velocity, Role::Angle, Role::Velocity, Role::Load];
    let of = |(channel, role): (&Option<String>, Role)| {
        channel.as_ref().map(|channel| of_channel(channel, role)).transpose()
    };
    let channels: Vec<Option<Arc<Vec<f64>>>> =
        chosen.channels.iter().zip(roles).map(of).collect::<Result<_, Error>>()?;
    let times = times_s.as_deref().filter(|_| recorded).and_then(Times::of);
    let used: Vec<Arc<Vec<f64>>> = channels.iter().flatten().cloned().collect();
    let missing = Audited::missing(times.as_ref(), &values, &used);
    let by_name = |name: &str| {
        let channel = chosen.channels.iter().position(|own| own.as_deref() == Some(name));
        let column = || names.iter().position(|own| own == name).map(|place| &values[place]);
        channel.and_then(|place| channels[place].as_ref()).or_else(column).map(|own| own.as_slice())
    };
    let (turning, told) = chosen.turning(&by_name, times.map(|times| times.rate_hz).or(rate_hz));
    let [angle_told, velocity_told] = told.map(|values| values.map(|values| whole(&Arc::new(values))));
    let [current, velocity, angle, velocity_ref, load] =
        std::array::from_fn(|place| channels[place].as_ref().map(whole));
    Ok(Audited {
        id: trace_name(&id).into_owned(),
        names: names.to_vec(),
        left_out: left_out.into_iter().chain(chosen.said.iter().cloned()).collect(),
        times,
        missing,
        columns: values.iter().map(|column| Column::of(column)).collect(),
        current,
        velocity: velocity_told.or(velocity),
        angle: angle_told.or(angle),
        turning,
        velocity_ref,
        load,
        times_s: times_s.filter(|_| recorded),
        values,
    })
}

/// A channel in which the last value stands for a missing one.
fn whole(values: &Arc<Vec<f64>>) -> Arc<Vec<f64>> {
    if values.iter().all(|x| x.is_finite()) { Arc::clone(values) } else { Arc::new(bridged(values)) }
}
