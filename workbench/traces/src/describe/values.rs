//! The values that `init` proposes: channels, features, classes and gate that the recordings support.

use std::collections::BTreeMap;
use std::path::Path;

use super::found::Found;
use super::guess::Guess;
use super::names::{AXIS, HEALTHY, REFERENCE, is_healthy};
use super::proposal::Proposal;
use crate::reader;
use crate::signal::signs::{ByName, decoded};
use crate::units::Unit;
use model::settings::{Data, from_here, literal as text};
use model::trace::TextForm;
use model::train::novelty;

/// The usual false-alarm rate of a gate.
const RATE: f64 = 0.01;
/// Columns of labels whose rows of one value are of one run.
const GROUPS: [&str; 6] = ["run", "session", "unit", "drive", "day", "batch"];
/// Segments of a few long recordings, and the least samples of one.
pub(super) const SEGMENTS: usize = 40;
pub(super) const LEAST_SAMPLES: usize = 200;

/// What is said of features that stand for those of a bearing.
pub(super) const UNTIL_A_BEARING: &str = "With a bearing, leave this line out: its orders are then the features";

/// Mean and rms of a channel as features.
pub(super) fn mean_and_rms(channel: &str) -> String {
    let names = ["mean", "rms"].map(|word| text(&format!("{word}_{channel}")));
    format!("[{}]", names.join(", "))
}

/// The value of each key that is known, and for keys that are left out why.
#[derive(Clone, Default)]
pub(super) struct Values {
    pub(super) values: BTreeMap<&'static str, String>,
    pub(super) refused: BTreeMap<&'static str, String>,
}

impl Values {
    pub(super) fn of(found: &Found, out: &Path, (data, front_end): (&Data, Option<&Path>)) -> Self {
        let mut own = Self::default();
        own.data(found, out, data);
        if let Some(file) = front_end {
            own.values.insert("front_end", text(&from_here(out, file).to_string_lossy()));
        }
        let features = own.channels(found);
        own.classes(found, features);
        own
    }

    /// These values with an answer in the place of each question about a unit or a number, so that the others can be
    /// tried.
    pub(super) fn answered(&self, found: &Found) -> Self {
        let mut tried = self.clone();
        for channel in [&found.turning.angle, &found.turning.velocity].into_iter().flatten() {
            tried.values.values_mut().for_each(|value| *value = value.replace(&channel.text, &channel.answer));
        }
        // A reference is in the unit of the velocity.
        tried.values.values_mut().for_each(|value| *value = value.replace("[?]", "[rad/s]").replace("/?", "/1"));
        tried
    }

    /// With a question mark in the place of the axis, if several motors move.
    pub(super) fn asked(&mut self, found: &Found) {
        const KEYS: [&str; 9] = ["y", "u1", "u2", "current", "velocity", "velocity_ref", "angle", "load", "features"];
        if let Some(condition) = self.values.get_mut("where").filter(|_| !found.motors.is_empty()) {
            let why = "which one has the bearing? Leave this line out if they are alike";
            *condition = format!("[{}]  # {}: {why}", text(&format!("{AXIS}=?")), found.motors.join(", "));
        }
        let Some(axes) = &found.axes else { return };
        self.values
            .iter_mut()
            .filter(|(key, _)| KEYS.contains(key))
            .for_each(|(_, value)| *value = axes.question(value));
    }

    fn channel(&mut self, key: &'static str, channel: &Option<String>, signs: &ByName) {
        if let Some(channel) = channel {
            self.values.insert(key, text(&decoded(channel, signs)));
        }
    }

    fn data(&mut self, found: &Found, out: &Path, data: &Data) {
        let from_here = |path: &Path| from_here(out, path).to_string_lossy().into_owned();
        let paths: Vec<String> = found.traces.iter().map(|path| text(&from_here(path))).collect();
        self.values.insert("traces", format!("[{}]", paths.join(", ")));
        self.values.insert("labels", text(&from_here(&found.labels.0)));
        if let Some(motor) = found.motors.first() {
            self.values.insert("where", format!("[{}]", text(&format!("{AXIS}={motor}"))));
        }
        let none = found.disorder.as_ref().map(|_| reader::NO_TIME.to_string());
        if let Some(time) = data.time.as_ref().or(none.as_ref()) {
            self.values.insert("time", text(time));
        }
        if let Some(rate) = data.rate_hz {
            self.values.insert("rate_hz", rate.to_string());
        }
        let TextForm { skip, units_row, separator, decimal } = data.text_form();
        let given = [
            ("skip", skip.map(|lines| lines.to_string())),
            ("units_row", units_row.then(|| "true".into())),
            ("separator", separator.map(|own| text(&String::from(own)))),
            ("decimal", decimal.map(|mark| text(mark.name()))),
        ];
        self.values.extend(given.into_iter().filter_map(|(key, value)| Some((key, value?))));
    }

    /// Writes channels, order and features; returns the number of features, and the channel of the current if its mean
    /// and rms can stand for them.
    fn channels(&mut self, found: &Found) -> (usize, Option<String>) {
        let Proposal { guess, columns, y, u1, by_reference, alone } = &found.proposal;
        let Guess { current, load, .. } = guess;
        let [angle, velocity] = [(&found.turning.angle, &guess.angle), (&found.turning.velocity, &guess.velocity)]
            .map(|(known, named)| known.as_ref().map(|channel| channel.text.clone()).or_else(|| named.clone()));
        let velocity_ref = &guess.velocity_ref.as_ref().map(|name| {
            // A reference without a unit is in that of the velocity.
            let stated = velocity.as_ref().zip(columns.velocity.as_ref()).filter(|_| Unit::of_column(name).is_none());
            stated.map_or_else(|| name.clone(), |(channel, column)| channel.replace(column.as_str(), name))
        });
        // The angle of a shaft whose velocity is constant follows from it.
        let integrated =
            velocity.as_ref().filter(|_| found.is_constant && found.rate_hz.is_some() && current.is_some());
        let integrated = integrated.map(|velocity| format!("integrate({velocity}) rad"));
        let angle = angle.or_else(|| integrated.clone());
        self.channel("angle", &angle, &found.signs);
        let turning = |name: &&String| name.ends_with(")rad/s") || name.to_lowercase().ends_with("rad_s");
        if let (None, Some(velocity), Some(current)) = (&angle, velocity.as_ref().filter(turning), current) {
            let integral = text(&format!("integrate({velocity}) rad"));
            let (velocity, current) = (text(velocity), text(current));
            let shaft =
                format!("{integral}  # with velocity = {velocity} and current = {current}: friction and orders");
            self.refused.insert("angle", shaft);
        }
        if angle.is_some() {
            self.channel("velocity", &velocity, &found.signs);
            self.channel("load", load, &found.signs);
            self.channel("velocity_ref", velocity_ref, &found.signs);
        }
        self.channel("y", y, &found.signs);
        self.channel("u1", u1, &found.signs);
        self.channel("u2", load, &found.signs);
        if angle.is_some() && !by_reference {
            self.channel("current", current, &found.signs);
        }
        let order = match (alone, load.is_some()) {
            (true, false) => "[4, 0, 0, 1, 1]",
            (true, true) => "[4, 0, 2, 1, 1]",
            (false, false) => "[2, 2, 0, 1, 1]",
            (false, true) => "[2, 2, 2, 1, 1]",
        };
        self.values.insert("order", order.into());
        self.values.insert("offset", "true".into());
        if integrated.is_some() {
            // At constant speed nothing else is excited: the line of the rotor shows its balance.
            self.values.insert("orders", "{ unbalance = 1 }  # and those of its bearings".into());
            self.values.insert("features", "[\"orders\"]".into());
            return (1, None);
        }
        (if load.is_some() { 7 } else { 5 }, current.clone().filter(|current| found.is_plain(current)))
    }

    /// Writes the classes of several records, the healthy one, and a gate if the records support one.
    fn classes(&mut self, found: &Found, (features, current): (usize, Option<String>)) {
        let (_, labels, classes) = &found.labels;
        let (several, single): (Vec<&String>, Vec<&String>) = classes.iter().partition(|class| labels.count(class) > 1);
        if classes.len() > 1 && !several.is_empty() && !single.is_empty() {
            let list: Vec<String> = several.iter().map(|class| text(class)).collect();
            let single: Vec<&str> = single.iter().map(|class| class.as_str()).collect();
            self.values.insert("classes", format!("[{}]  # one record only: {}", list.join(", "), single.join(", ")));
        }
        let is_named = |name: &&&String| HEALTHY.contains(&name.to_lowercase().as_str());
        let has_word = |name: &&&String| is_healthy(name);
        let pool: Vec<&String> = if classes.len() > 1 { several } else { classes.iter().collect() };
        let reference = || pool.iter().find(|name| name.as_str() == REFERENCE);
        let known = pool.iter().find(is_named).or_else(|| pool.iter().find(has_word)).or_else(reference).copied();
        let Some(healthy) = known else { return };
        self.values.insert("healthy", text(healthy));
        self.values.insert("nominal", text(healthy));
        // Of labels that were made each record may be a run of its own.
        let is_group = |name: &String| found.made.is_none() || labels.joins(name);
        let group = GROUPS.iter().find(|group| labels.columns().iter().any(|name| name == *group && is_group(name)));
        if let Some(group) = group {
            self.values.insert("group", text(group));
        }
        let mut records = labels.count(healthy);
        if classes.len() == 1 && group.is_none() && records < SEGMENTS {
            let segment = (found.rows * records / SEGMENTS).max(LEAST_SAMPLES).min(found.rows);
            records *= found.rows / segment;
            self.values.insert("segment", format!("{segment}  # samples: {records} segments of a few records"));
        }
        let (count, what) = group.map_or((records, "records"), |group| (labels.distinct(group).len(), "runs"));
        let fewest = |features: usize| match group {
            Some(_) => novelty::runs::fewest(features, RATE),
            None => novelty::fewest(features, RATE),
        };
        if count >= fewest(features) {
            return;
        }
        // More classes need more features than a gate of few records allows. From healthy records with an angle
        // training chooses as many features as their number allows.
        let chosen = self.values.contains_key("angle") && classes.len() == 1;
        match current.filter(|_| count >= fewest(2) && classes.len() < 3 && !chosen) {
            Some(current) => {
                let why = format!(
                    "{count} healthy {what} support a gate of two features; of {features}, {}. {UNTIL_A_BEARING}",
                    fewest(features)
                );
                self.values.insert("features", format!("{}  # {why}", mean_and_rms(&current)));
            }
            None if classes.len() > 1 => {
                self.values.remove("healthy");
                let least = fewest(features);
                let why = format!("{count} {what} support no false-alarm rate of {RATE} with {features} features");
                self.refused.insert("healthy", format!("{}  # {why}; at least {least} do", text(healthy)));
                self.values.insert("novelty", "\"none\"  # until there are enough".into());
            }
            None => {}
        }
    }
}
