//! Words that are no known ones: the nearest that is, and what there is.
//!
//! ```text
//! no column curent_a (did you mean current_a?); there are time_s, current_a, velocity_rad_s
//! ```

use std::path::Path;

/// Names in a list of what there is.
const MOST: usize = 12;

/// "; did you mean …?", if a known word is near.
pub(crate) fn did_you_mean<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> String {
    nearest(word, known).first().map_or_else(String::new, |near| format!("; did you mean {near}?"))
}

/// What to say behind an unknown word: the nearest known one, and the known ones.
#[must_use]
pub fn among(word: &str, known: &[impl AsRef<str>]) -> String {
    let near = nearest(word, known.iter().map(AsRef::as_ref));
    let near = near.first().map_or_else(String::new, |near| format!(" (did you mean {near}?)"));
    format!("{near}; there are {}", list(known))
}

/// The first names of a list, and how many more there are.
#[must_use]
pub fn list(known: &[impl AsRef<str>]) -> String {
    let all: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
    match all.len().checked_sub(MOST) {
        // One more name is no longer than the words on it.
        None | Some(0 | 1) => all.join(", "),
        Some(more) => format!("{} and {more} more", all[..MOST].join(", ")),
    }
}

/// The known words that are near, the nearest first: by letters that are changed, added, left out or exchanged,
/// whatever their case is, or as its beginning or end.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let word = word.trim().to_lowercase();
    let changes = |other: &str| {
        let other = other.to_lowercase();
        let (changes, length) =
            (strsim::damerau_levenshtein(&word, &other), word.chars().count().max(other.chars().count()));
        let is_part = word.len() > 2 && (other.starts_with(&word) || other.ends_with(&word));
        let is_near = 3 * changes <= length || is_part || strsim::jaro_winkler(&word, &other) > 0.88;
        is_near.then_some(changes)
    };
    let mut near: Vec<(usize, &str)> = known.filter_map(|other| Some((changes(other)?, other))).collect();
    near.sort_by_key(|(changes, _)| *changes);
    near.dedup();
    near.into_iter().map(|(_, other)| other).collect()
}

/// What to say behind a file that does not exist: its folder neither, or the nearest name in it.
pub(crate) fn of_file(path: &Path) -> String {
    let folder = path.parent().filter(|own| !own.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Some(name) = path.file_name().map(|own| own.to_string_lossy()) else { return String::new() };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return if folder.exists() { String::new() } else { format!("; there is no folder {}", folder.display()) };
    };
    let mut names: Vec<String> =
        entries.filter_map(|own| Some(own.ok()?.file_name().to_string_lossy().into_owned())).collect();
    names.sort();
    let near = nearest(&name, names.iter().map(String::as_str));
    near.first().map_or_else(String::new, |near| format!("; did you mean {}?", folder.join(near).display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: [&str; 4] = ["time_s", "current_a", "velocity_rad_s", "iq_A"];

    #[test]
    fn the_nearest_word_is_that_with_the_fewest_changes() {
        for (word, near) in [
            ("curent_a", Some("current_a")),
            ("Current_A", Some("current_a")),
            ("velocity", Some("velocity_rad_s")),
            ("vel", Some("velocity_rad_s")),
            ("iq_a", Some("iq_A")),
            ("tiem_s", Some("time_s")),
            ("torque", None),
            ("x", None),
        ] {
            assert_eq!(nearest(word, COLUMNS.into_iter()).first().copied(), near, "{word}");
        }
        let classes = ["healthy", "spall", "spalled"];
        assert_eq!(nearest("spal", classes.into_iter()), ["spall", "spalled"]);
    }

    #[test]
    fn a_list_is_short() {
        let said = among("curent_a", &COLUMNS[..2]);
        assert_eq!(said, " (did you mean current_a?); there are time_s, current_a");
        assert_eq!(among("torque", &COLUMNS[..2]), "; there are time_s, current_a");
        let many: Vec<String> = (0..42).map(|k| format!("c{k:02}")).collect();
        let said = list(&many);
        assert!(said.ends_with("c10, c11 and 30 more"), "{said}");
        assert!(list(&many[..13]).ends_with("c11, c12"));
    }

    #[test]
    fn files_are_looked_for_in_their_folder() {
        let folder = tempfile::tempdir().expect("folder");
        std::fs::write(folder.path().join("labels.csv"), "").expect("write");
        let said = |name: &str| of_file(&folder.path().join(name));
        assert!(said("label.csv").ends_with("labels.csv?"), "{}", said("label.csv"));
        assert_eq!(said("drive.toml"), "");
        assert!(said("none/labels.csv").starts_with("; there is no folder "), "{}", said("none/labels.csv"));
    }
}
