//! Groups of arrays by the parts of their names, and whether they are records or parts of one.
//!
//! ```text
//! /run_0/motor/i    run_0 │ motor │ i
//! data(2).speed     data │ (2) │ speed
//! ```

use std::collections::{BTreeSet, HashMap};

use crate::time::names;

/// Names of what one recording has several of.
const DEVICES: [&str; 24] = [
    "axis",
    "axes",
    "joint",
    "motor",
    "drive",
    "phase",
    "channel",
    "chan",
    "ch",
    "sensor",
    "actuator",
    "wheel",
    "leg",
    "link",
    "dof",
    "encoder",
    "module",
    "node",
    "slave",
    "amplifier",
    "bearing",
    "signal",
    "arm",
    "imu",
];

/// Names of the values of a signal whose group has its name.
const VALUES: [&str; 8] = ["value", "values", "val", "data", "signal", "samples", "y", "x"];

/// Names and values of arrays.
pub(in crate::table) type Named = Vec<(String, Vec<f64>)>;

/// The parts of the name of an array: groups, fields and numbers of elements, each with the place where it ends.
pub(in crate::table) fn parts(name: &str) -> Vec<(&str, usize)> {
    let bytes = name.as_bytes();
    let is_letter = |at: usize| bytes.get(at).is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_');
    let (mut all, mut start) = (Vec::new(), 0);
    for at in 0..bytes.len() {
        // A point in a number ends no name.
        let is_end = bytes[at] == b'/' || bytes[at] == b'.' && is_letter(at + 1);
        let opens = bytes[at] == b'(' && at > start && number_of_element(&name[at..]).is_some();
        if is_end || opens || at > start && bytes[at] == b')' && bytes[start] == b'(' {
            let end = if bytes[at] == b')' { at + 1 } else { at };
            if end > start {
                all.push((&name[start..end], end));
            }
            start = if is_end { at + 1 } else { end };
        }
    }
    if start < name.len() {
        all.push((&name[start..], name.len()));
    }
    all
}

/// The number of an element such as (3) at the start of a text.
pub(in crate::table) fn number_of_element(text: &str) -> Option<&str> {
    let (number, _) = text.strip_prefix('(')?.split_once(')')?;
    (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(number)
}

/// The parts of the names of all arrays, of which the columns of a matrix in no group have two: `run1` and `_2`.
pub(in crate::table) fn all_parts(arrays: &Named) -> Vec<Vec<(&str, usize)>> {
    let mut matrices: HashMap<&str, Vec<(usize, usize)>> = HashMap::new();
    let column = |name: &str| {
        let (matrix, number) = name.rsplit_once('_')?;
        Some((matrix.len(), number.parse::<usize>().ok()?))
    };
    let mut all: Vec<Vec<(&str, usize)>> = arrays.iter().map(|(name, _)| parts(name)).collect();
    let single = |parts: &Vec<(&str, usize)>| parts.len() == 1;
    for ((name, values), _) in arrays.iter().zip(&all).filter(|(_, parts)| single(parts)) {
        if let Some((end, number)) = column(name) {
            matrices.entry(&name[..end]).or_default().push((number, values.len()));
        }
    }
    // Columns count from 1 on, and have one length.
    let is_matrix = |columns: &Vec<(usize, usize)>| {
        let counts = columns.iter().enumerate().all(|(k, (number, rows))| *number == k + 1 && *rows == columns[0].1);
        columns.len() > 1 && counts
    };
    for ((name, _), parts) in arrays.iter().zip(&mut all).filter(|(_, parts)| single(parts)) {
        if let Some((end, _)) = column(name).filter(|(end, _)| matrices.get(&name[..*end]).is_some_and(is_matrix)) {
            *parts = vec![(&name[..end], end), (&name[end..], name.len())];
        }
    }
    all
}

/// A group of arrays, which may be a record.
pub(in crate::table) struct Group<'a> {
    /// The parts of its name.
    pub(in crate::table) name: Vec<&'a str>,
    /// Names of its arrays within it, and their places.
    pub(in crate::table) arrays: Vec<(&'a str, usize)>,
    /// Names of those with more than one number.
    pub(in crate::table) signals: BTreeSet<&'a str>,
    pub(in crate::table) rows: usize,
}

impl Group<'_> {
    /// Whether at least half of the signals of both are in both.
    pub(in crate::table) fn is_like(&self, signals: &BTreeSet<&str>) -> bool {
        let common = self.signals.intersection(signals).count();
        common > 0 && 2 * common >= self.signals.union(signals).count()
    }

    /// Whether its name ends with a number, and the word before that.
    fn numbered(&self) -> (bool, String) {
        let (elements, names): (Vec<&str>, Vec<&str>) = self.name.iter().partition(|part| part.starts_with('('));
        let name = names.last().copied().unwrap_or_default();
        let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let is_numbered = !elements.is_empty() || word.len() < name.len();
        (is_numbered, word.trim_end_matches(['_', '-', ' ', '.']).to_lowercase())
    }
}

/// The places of the arrays of groups.
pub(in crate::table) fn places(groups: &[&Group<'_>]) -> BTreeSet<usize> {
    groups.iter().flat_map(|group| group.arrays.iter().map(|(_, place)| *place)).collect()
}

/// The last part of a name.
pub(in crate::table) fn last(name: &str) -> &str {
    parts(name).last().map_or(name, |(part, _)| *part)
}

/// The groups at a depth, with what is below them.
pub(in crate::table) fn groups<'a>(arrays: &'a Named, all: &[Vec<(&'a str, usize)>], depth: usize) -> Vec<Group<'a>> {
    let (mut groups, mut places) = (Vec::<Group<'a>>::new(), HashMap::<Vec<&str>, usize>::new());
    for (place, ((name, values), parts)) in arrays.iter().zip(all).enumerate() {
        let Some((_, end)) = parts.get(depth - 1).filter(|_| parts.len() > depth) else { continue };
        let group: Vec<&str> = parts[..depth].iter().map(|(part, _)| *part).collect();
        let at = *places.entry(group.clone()).or_insert_with(|| {
            groups.push(Group { name: group, arrays: vec![], signals: BTreeSet::new(), rows: 0 });
            groups.len() - 1
        });
        let inside = name[*end..].trim_start_matches(['/', '.']);
        groups[at].arrays.push((inside, place));
        if values.len() > 1 {
            groups[at].signals.insert(inside);
        }
        groups[at].rows = groups[at].rows.max(values.len());
    }
    groups
}

/// Whether groups that are alike are records, not parts of one.
pub(in crate::table) fn are_records(groups: &[&Group<'_>], arrays: &Named) -> bool {
    let is_time = |name: &&str| names::usual(last(name)).is_some();
    let rows = groups[0].rows;
    let names: Vec<(bool, String)> = groups.iter().map(|group| group.numbered()).collect();
    let are_numbered = names.iter().all(|(is_numbered, word)| *is_numbered && *word == names[0].1);
    let are_devices = names.iter().any(|(_, word)| DEVICES.contains(&word.as_str()));
    // A group with the values of one signal has its name, if that is no number of a record.
    let signals = |group: &&Group<'_>| group.signals.iter().filter(|name| !is_time(name)).count();
    let is_value = |name: &&str| VALUES.contains(&last(name).to_lowercase().as_str());
    let of_signal = groups[0].signals.iter().any(is_value) && !are_numbered;
    if groups.iter().all(|group| signals(group) < 2) && (are_devices || of_signal) {
        return false;
    }
    // Matrices have no names that tell what is in them, and those of one length may have one time.
    let are_matrices = groups[0].signals.iter().all(|name| name.starts_with('_'));
    if are_matrices && (!are_numbered || are_devices || groups.iter().all(|group| group.rows == rows)) {
        return false;
    }
    if groups.iter().any(|group| group.rows != rows) {
        return true;
    }
    let inside = places(groups);
    let mut outside = arrays.iter().enumerate().filter(|(place, _)| !inside.contains(place));
    let is_simultaneous = outside.any(|(_, (_, values))| values.len() == rows);
    let have_times = groups.iter().all(|group| group.signals.iter().any(is_time));
    !are_devices && (have_times || are_numbered && !is_simultaneous)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_parts() {
        for (name, expected) in [
            ("run_0/t", "run_0|t"),
            ("data(12).current", "data|(12)|current"),
            ("runs(1)_2", "runs|(1)|_2"),
            ("s.a(1)(2).b", "s|a|(1)|(2)|b"),
            ("v1.5/log.a", "v1.5|log|a"),
            ("i (A)", "i (A)"),
            ("", ""),
        ] {
            assert_eq!(parts(name).iter().map(|(part, _)| *part).collect::<Vec<_>>().join("|"), expected, "{name}");
            assert!(parts(name).iter().all(|(part, end)| name[..*end].ends_with(part)), "{name}");
        }
        assert_eq!((last("run_0/motor/i"), last("i")), ("i", "i"));
    }
}
