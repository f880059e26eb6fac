//! The file of labels: the class of each trace, and further columns by which traces are selected.

use std::collections::HashSet;
use std::io::Read as _;
use std::path::Path;

use model::Error;
use model::outputs::text_of;
use model::trace::{Labels, extensions, file_name};

use crate::reader::names_of_rows;
use crate::table::{Table, csv_error};

/// Bytes of a text that are looked at to know whether it has labels: its columns, and names of traces.
const HEAD: u64 = 1 << 16;
/// Formats of columns that may be texts; arrays of numbers have no labels.
const WITH_TEXTS: [&str; 4] = ["parquet", "arrow", "arrows", "feather"];

/// Whether a file has labels: a row for each trace with its class, or the files in which signals are. A table of traces
/// may have their classes too, but repeats the name of a trace in each of its rows.
pub(crate) fn has_labels(file: &Path) -> bool {
    let (extension, compressed) = extensions(&file_name(file)).unwrap_or_default();
    let (columns, ids) = if compressed || WITH_TEXTS.contains(&extension.as_str()) {
        let Ok(table) = Table::open(file) else { return false };
        (table.names().to_vec(), names_of_rows(&table).unwrap_or_default())
    } else if ["csv", "tsv", "txt", "dat"].contains(&extension.as_str()) {
        head_of(file).unwrap_or_default()
    } else {
        return false;
    };
    let has = |wanted: &str| columns.iter().any(|name| name == wanted);
    let mut seen = HashSet::new();
    let mut names = ids.iter().filter(|id| !id.is_empty());
    has("signal_id") && has("signal_file") || has("trace") && has("class_name") && names.all(|id| seen.insert(id))
}

/// The columns and the first names of traces of a text, whose cells may have blanks.
fn head_of(file: &Path) -> Option<(Vec<String>, Vec<String>)> {
    let mut bytes = Vec::new();
    std::fs::File::open(file).ok()?.take(HEAD).read_to_end(&mut bytes).ok()?;
    let text = String::from_utf8_lossy(&bytes);
    let header = text.lines().find(|line| !line.trim().is_empty())?;
    let separator = [b',', b';', b'\t'].into_iter().max_by_key(|mark| header.matches(char::from(*mark)).count())?;
    let mut reader = csv::ReaderBuilder::new();
    let mut reader = reader.trim(csv::Trim::All).flexible(true).delimiter(separator).from_reader(text.as_bytes());
    let columns: Vec<String> = reader.headers().ok()?.iter().map(String::from).collect();
    let Some(place) = columns.iter().position(|name| name == "trace") else { return Some((columns, vec![])) };
    let rows = reader.records().map_while(Result::ok);
    let ids = rows.filter_map(|row| row.get(place).map(String::from));
    Some((columns, ids.collect()))
}

/// Reads a labels file.
///
/// # Errors
/// Unreadable file, missing `trace` or `class_name`, ragged rows, a trace that occurs twice.
pub fn read_labels(path: &Path) -> Result<Labels, Error> {
    let file = std::fs::File::open(path).map_err(Error::io(path))?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let problem = |error: csv::Error| match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, len, expected_len } => {
            let line = pos.as_ref().map_or_else(|| "content".into(), |p| format!("line {}", p.line()));
            Error::content(path, line, format!("{len} cells where the header has {expected_len}; complete the row"))
        }
        _ => csv_error(path, &error),
    };
    let text = |cell: &str| text_of(cell).to_string();
    let columns: Vec<String> = reader.headers().map_err(problem)?.iter().map(text).collect();
    let rows = reader.records().map(|r| Ok(r.map_err(problem)?.iter().map(text).collect()));
    Labels::of_cells(path, columns, rows.collect::<Result<_, Error>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_known_by_their_header_whatever_is_in_the_names() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text, expected) in [
            ("blanks.csv", "trace,class_name\nrun 0 a.csv,healthy\nrun 1 a b c.csv,outer race\n", true),
            ("few.txt", "\u{feff}class_name;trace;load\nhealthy;a 1;3\n", true),
            ("tabs.tsv", "trace\tclass_name\nmy file 1\thealthy\n", true),
            ("quoted.csv", "\"trace\",\"class_name\"\n\"a, b.csv\",\"x y\"\n", true),
            ("signals.csv", "signal_id,signal_file\n1,a.csv\n", true),
            ("rows.csv", "trace,class_name,t_s,i\na,healthy,0,1\na,healthy,1,2\n", false),
            ("recording.csv", "t_s,i,class_name\n0,1,healthy\n", false),
            ("words.csv", "trace class_name\n", false),
            ("long.csv", &format!("class_name,{},trace\nhealthy,1,a\n", "x".repeat(8192)), true),
        ] {
            let file = folder.path().join(name);
            std::fs::write(&file, text).expect("writable");
            assert_eq!(has_labels(&file), expected, "{name}");
        }
        assert!(!has_labels(&folder.path().join("none.csv")));
    }
}
