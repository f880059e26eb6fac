//! Columns of several motors in one recording, and which of them is described.
//!
//! ```text
//! axis1_iq, axis1_speed, axis2_iq, axis2_speed      parts of names that stand at one place of alike names: 1, 2
//! iq_L, speed_L, iq_R, speed_R                      L, R
//! /motor_a/iq, /motor_a/pos, /motor_b/iq, …         a, b
//! ```
//!
//! A part is an axis if its columns without it are a current and a motion. If one axis moves it is taken, and said;
//! of several the user is asked: its part of the names is a question mark.

use std::collections::{BTreeMap, BTreeSet};

use super::guess::{Guess, is_current};
use model::statistics::mean_sd;
use model::trace::bridged;

/// Part of the largest motion below which an axis rests.
const RESTS: f64 = 0.05;
/// Parts of names that do not distinguish motors: components of a vector, and statistics of a signal.
const NO_AXES: [&str; 41] = [
    "d",
    "q",
    "alpha",
    "beta",
    "ref",
    "cmd",
    "set",
    "soll",
    "ist",
    "act",
    "actual",
    "meas",
    "measured",
    "raw",
    "filt",
    "filtered",
    "lp",
    "est",
    "estimated",
    "obs",
    "sim",
    "model",
    "min",
    "max",
    "mean",
    "avg",
    "rms",
    "std",
    "peak",
    "error",
    "err",
    "diff",
    "bus",
    "dc",
    "supply",
    "in",
    "phase",
    "sin",
    "cos",
    "old",
    "new",
];

/// Parts of names by which alike currents are the phases of one motor.
const PHASES: [&str; 6] = ["phase", "phases", "phasen", "phasenstrom", "strang", "winding"];

/// A part of a name: its text in lower case, and where it is.
struct Part {
    text: String,
    start: usize,
    end: usize,
}

/// The letters and the numbers of a name, one after another.
fn parts(name: &str) -> Vec<Part> {
    let mut all: Vec<Part> = Vec::new();
    let mut before = ' ';
    for (start, c) in name.char_indices() {
        let joins = c.is_alphanumeric()
            && before.is_alphanumeric()
            && c.is_numeric() == before.is_numeric()
            && !(c.is_uppercase() && before.is_lowercase());
        match all.last_mut().filter(|_| joins) {
            Some(part) => {
                part.text.extend(c.to_lowercase());
                part.end = start + c.len_utf8();
            }
            None if c.is_alphanumeric() => {
                all.push(Part { text: c.to_lowercase().collect(), start, end: start + c.len_utf8() });
            }
            None => {}
        }
        before = c;
    }
    all
}

/// The columns of an axis: their places, and where its part of the name is.
type Columns = BTreeMap<usize, (usize, usize)>;

/// The columns of each part that stands with others at one place of alike names, where these have letters beside it.
fn families(names: &[String]) -> BTreeMap<String, Columns> {
    let mut alike: BTreeMap<(String, String), Vec<(usize, Part)>> = BTreeMap::new();
    for (place, name) in names.iter().enumerate() {
        for part in parts(name) {
            let ends = (name[..part.start].to_string(), name[part.end..].to_string());
            let has_letters = ends.0.contains(char::is_alphabetic) || ends.1.contains(char::is_alphabetic);
            if has_letters && !NO_AXES.contains(&part.text.as_str()) {
                alike.entry(ends).or_default().push((place, part));
            }
        }
    }
    let mut of: BTreeMap<String, Columns> = BTreeMap::new();
    for (place, part) in alike.into_values().filter(|own| own.len() > 1).flatten() {
        of.entry(part.text).or_default().insert(place, (part.start, part.end));
    }
    of
}

/// The name with this text in the place of its part.
fn with(name: &str, (start, end): (usize, usize), text: &str) -> String {
    format!("{}{text}{}", &name[..start], &name[end..])
}

/// The columns without their part.
fn without(names: &[String], columns: &Columns) -> Vec<String> {
    columns.iter().map(|(place, part)| with(&names[*place], *part, "")).collect()
}

/// The axes of these columns, each with its columns; empty if there are not several.
fn axes(names: &[String]) -> BTreeMap<String, Columns> {
    let mut families = families(names);
    let phases = Guess::of(names).phases;
    families.values_mut().for_each(|own| own.retain(|place, _| !phases.contains(&names[*place])));
    let whole = |own: &Columns| {
        let guess = Guess::of(&without(names, own));
        guess.current.is_some() && (guess.velocity.is_some() || guess.angle.is_some())
    };
    let several: BTreeMap<String, Columns> =
        families.iter().filter(|(_, own)| whole(own)).map(|(part, own)| (part.clone(), own.clone())).collect();
    if several.len() > 1 {
        return several;
    }
    // Of several motors the motion may be in one column, or not recorded.
    let is_short = |part: &String| part.chars().count() == 1 || ["left", "right"].contains(&part.as_str());
    let is_phase = |name: &str| parts(name).iter().any(|part| PHASES.contains(&part.text.as_str()));
    let of_current = |(part, own): (String, Columns)| {
        let currents: Columns = own
            .into_iter()
            .filter(|(place, part)| !is_phase(&names[*place]) && is_current(&with(&names[*place], *part, "")))
            .collect();
        (is_short(&part) && !currents.is_empty()).then_some((part, currents))
    };
    let currents: BTreeMap<String, Columns> = families.into_iter().filter_map(of_current).collect();
    // Three alike are the phases.
    if currents.len() == 2 || currents.len() > 3 { currents } else { BTreeMap::new() }
}

/// Which axis is described.
#[derive(Debug)]
pub(crate) struct Axes {
    /// The columns of this axis and those of none.
    pub(crate) kept: Vec<String>,
    /// What is said or asked.
    pub(crate) said: String,
    /// The parts of the names of the axes that move.
    pub(crate) moving: Vec<String>,
    /// The columns of this axis, and as they are asked for; empty if the others rest.
    asked: Vec<(String, String)>,
}

impl Axes {
    /// Of a recording with these columns; `None` if there are not several axes.
    pub(crate) fn of(names: &[String], columns: &[Vec<f64>]) -> Option<Self> {
        let all = axes(names);
        if all.is_empty() {
            return None;
        }
        let deviation = |name: &String| {
            let place = names.iter().position(|own| own == name)?;
            Some(mean_sd(&bridged(columns.get(place)?)).1)
        };
        let motion = |own: &Columns| {
            let list: Vec<String> = own.keys().map(|place| names[*place].clone()).collect();
            let guess = Guess::of(&list);
            deviation(guess.velocity.as_ref().or(guess.angle.as_ref()).or(guess.current.as_ref())?)
        };
        let motions: Vec<(&String, f64)> = all.iter().map(|(part, own)| (part, motion(own).unwrap_or(0.0))).collect();
        let largest = motions.iter().map(|(_, deviation)| *deviation).fold(0.0, f64::max);
        let moving: Vec<&String> =
            motions.iter().filter(|(_, own)| *own > RESTS * largest).map(|(part, _)| *part).collect();
        let taken = *moving.first()?;
        let others: BTreeSet<usize> =
            all.iter().filter(|(part, _)| *part != taken).flat_map(|(_, own)| own.keys().copied()).collect();
        let kept = (0..names.len()).filter(|place| !others.contains(place)).map(|place| names[place].clone()).collect();
        let written = |part: &String| {
            let (place, (start, end)) = all[part].iter().next().map(|(place, own)| (*place, *own)).unwrap_or_default();
            names[place][start..end].to_string()
        };
        let list = moving.iter().map(|part| written(part)).collect::<Vec<_>>().join(", ");
        let mark = |(place, part): (&usize, &(usize, usize))| (names[*place].clone(), with(&names[*place], *part, "?"));
        let is_asked = moving.len() > 1;
        let said = if is_asked {
            format!("several motors move: which one has the bearing, {list}?")
        } else {
            format!("axis {list} is taken: the others rest")
        };
        let asked = if is_asked { all[taken].iter().map(mark).collect() } else { vec![] };
        let moving = moving.iter().map(|part| written(part)).collect();
        Some(Self { kept, said, moving, asked })
    }

    /// The names with a question mark.
    pub(crate) fn marks(&self) -> Vec<String> {
        self.asked.iter().map(|(_, mark)| mark.clone()).collect()
    }

    /// Whether the user is asked.
    pub(crate) fn is_question(&self) -> bool {
        !self.asked.is_empty()
    }

    /// A channel or a list of features with a question mark in the place of the axis.
    pub(crate) fn question(&self, text: &str) -> String {
        let mut own: Vec<&(String, String)> = self.asked.iter().collect();
        own.sort_by_key(|(name, _)| usize::MAX - name.len());
        own.into_iter().fold(text.to_string(), |text, (name, asked)| text.replace(name.as_str(), asked))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str], motions: &[f64]) -> Option<Axes> {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        let wave = |size: &f64| (0..500).map(|k| size * (0.05 * f64::from(k)).sin()).collect();
        Axes::of(&names, &motions.iter().map(wave).collect::<Vec<_>>())
    }

    #[test]
    fn the_axis_that_moves_is_taken() {
        for (names, motions, first) in [
            (&["iq1_A", "vel1", "iq2_A", "vel2", "t_motor"][..], &[1.0, 1e-3, 1.0, 40.0, 0.1][..], "iq2_A"),
            (&["Current_J0", "Speed_J0", "Current_J1", "Speed_J1"], &[1.0, 0.0, 1.0, 3.0], "Current_J1"),
            (
                &["axis3.current", "axis3.position", "axis1.current", "axis1.position"],
                &[1.0, 9.0, 1.0, 0.01],
                "axis3.current",
            ),
        ] {
            let axes = of(names, motions).expect("several axes");
            assert_eq!(axes.kept[0], first);
            assert!(axes.said.ends_with("the others rest") && !axes.is_question(), "{axes:?}");
        }
    }

    #[test]
    fn of_several_that_move_the_user_is_asked() {
        for (names, channel, asked, list) in [
            (&["iq1", "vel1", "iq2", "vel2"][..], "iq1", "iq?", "1, 2?"),
            (&["axis1_iq_A", "axis1_speed", "axis2_iq_A", "axis2_speed"], "axis1_iq_A", "axis?_iq_A", "1, 2?"),
            (&["iq_L", "iq_R", "speed_L", "speed_R", "theta_L", "theta_R"], "speed_L[rpm]", "speed_?[rpm]", "L, R?"),
            (&["/motor_a/iq", "/motor_a/pos", "/motor_b/iq", "/motor_b/pos"], "/motor_a/iq", "/motor_?/iq", "a, b?"),
            (&["X_Current [A]", "X_Pos", "Z_Current [A]", "Z_Pos"], "X_Pos", "?_Pos", "X, Z?"),
            (&["J1Current", "J1Speed", "J6Current", "J6Speed"], "J1Speed", "J?Speed", "1, 6?"),
            (&["left.current", "left.speed", "right.current", "right.speed"], "left.speed", "?.speed", "left, right?"),
            (
                &["Strom Hauptspindel [A]", "Drehzahl Hauptspindel", "Strom Vorschub [A]", "Drehzahl Vorschub"],
                "Drehzahl Hauptspindel",
                "Drehzahl ?",
                "Hauptspindel, Vorschub?",
            ),
            (&["iq_1", "iq_2", "speed"], "iq_1", "iq_?", "1, 2?"),
            (&["current_1", "current_2", "current_3", "current_4", "rpm"], "current_1", "current_?", "1, 2, 3, 4?"),
        ] {
            let axes = of(names, &vec![1.0; names.len()]).unwrap_or_else(|| panic!("{names:?}"));
            assert_eq!(axes.question(channel), asked);
            assert!(axes.said.contains(list) && axes.is_question(), "{axes:?}");
        }
        let robots = ["R1_J1_iq", "R1_J1_w", "R1_J2_iq", "R1_J2_w", "R2_J1_iq", "R2_J1_w", "R2_J2_iq", "R2_J2_w"];
        let axes = of(&robots, &[1.0; 8]).expect("several robots");
        assert_eq!(axes.kept, ["R1_J1_iq", "R1_J1_w"]);
    }

    #[test]
    fn one_motor_is_not_several() {
        for names in [
            &["iq1_A", "vel1", "torque2"][..],
            &["current_a", "velocity_rad_s"],
            &["i_d", "i_q", "v_d", "v_q", "w"],
            &["ia_A", "ib_A", "ic_A", "speed"],
            &["current_1", "current_2", "current_3", "speed"],
            &["phase_current_1", "phase_current_2", "vibration_1"],
            &["Phasenstrom 1", "Phasenstrom 2", "Drehzahl"],
            &["iq_ref", "iq_act", "speed_ref", "speed_act"],
            &["iq_raw", "iq_filtered", "speed_raw", "speed_filtered"],
            &["iq_mean", "speed_mean", "iq_max", "speed_max"],
            &["current_a", "velocity_mm_s", "velocity_ref_mm_s", "position_mm", "position_ref_mm"],
            &["iq_A", "id_A", "speed_rpm", "angle_deg", "load_torque_nm", "temperature_c"],
            &["motor_iq", "motor_speed", "bus_current"],
            &["current", "speed", "temp1", "temp2"],
        ] {
            assert!(of(names, &vec![1.0; names.len()]).is_none(), "{names:?}");
        }
    }
}
