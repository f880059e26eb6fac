//! Arrays of a file → columns of one length.

use std::path::Path;

use model::Error;

use crate::table::arrays::groups::Named;
use crate::table::columns::About;
use crate::table::limit::Limit;
use crate::table::text::preamble;
use crate::time::names;

/// Names and columns of arrays: the longest ones, and those of one number, which are constant.
pub(in crate::table) fn of_one_length(
    path: &Path,
    arrays: Named,
    about: &mut About,
) -> Result<(Vec<String>, Vec<Vec<f64>>), Error> {
    let Some(rows) = arrays.iter().map(|(_, column)| column.len()).max().filter(|rows| *rows > 0) else {
        let left: Vec<String> = about.omitted.iter().map(|own| format!("{}: {}", own.place, own.reason)).collect();
        let left = if left.is_empty() { String::new() } else { format!("; left out: {}", left.join(", ")) };
        return Err(Error::content(path, "content", format!("no arrays of numbers{left}")));
    };
    // Each constant becomes a column of that length.
    let columns = arrays.iter().filter(|(_, column)| [1, rows].contains(&column.len())).count();
    let claimed = Limit::of_file(path)?.claim_numbers([rows as u64, columns as u64]);
    claimed.map_err(|problem| Error::content(path, "content", format!("as {columns} columns {problem}")))?;
    let each = |(name, column): (String, Vec<f64>)| match column[..] {
        [one] => {
            if rows > 1 && about.step_s.is_none() {
                let own = name.rsplit(['.', '/']).next().unwrap_or_default();
                about.step_s = preamble::of_value(own, one, &name).step_s(&mut about.notes);
            }
            Some((name, vec![one; rows]))
        }
        _ if column.len() == rows => Some((name, column)),
        _ => {
            let count = column.len();
            about.omit(format!("array {name}"), format!("it has {count} values where the longest have {rows}"));
            None
        }
    };
    Ok(arrays.into_iter().filter_map(each).unzip())
}

/// Leaves the name of the only variable out of all names, also of `others`, which are among them.
pub(in crate::table) fn without_variable(found: &mut Named, others: &mut [String]) {
    let Some((first, _)) = found.first().and_then(|(name, _)| name.split_once('.')) else { return };
    let length = first.len() + 1;
    let own = |(name, _): &(String, Vec<f64>)| name.split_once('.').is_some_and(|(own, _)| own == first);
    if found.iter().all(own) {
        let names = found.iter_mut().map(|(name, _)| name).chain(others);
        names.for_each(|name| drop(name.drain(..length)));
    }
}

/// The columns of a matrix, by their numbers.
pub(in crate::table) fn matrix(name: &str, sides: [usize; 2], by_rows: bool, values: &[f64]) -> Named {
    (1..).map(|k| format!("{name}_{k}")).zip(along_longer(sides, by_rows, values)).collect()
}

/// The columns of a matrix of these sides along its longer one; its values are row by row, or column by column.
pub(in crate::table) fn along_longer([rows, across]: [usize; 2], by_rows: bool, values: &[f64]) -> Vec<Vec<f64>> {
    let value = |row: usize, column: usize| values[if by_rows { row * across + column } else { column * rows + row }];
    if rows >= across {
        (0..across).map(|column| (0..rows).map(|row| value(row, column)).collect()).collect()
    } else {
        (0..rows).map(|row| (0..across).map(|column| value(row, column)).collect()).collect()
    }
}

/// Takes the first column of a matrix for the time if no column is called one, it rises in each row and does not count
/// them: matrices have no names.
pub(in crate::table) fn rising_time(names: &[String], columns: &[Vec<f64>], about: &mut About) {
    /// Fewest rows of such a matrix.
    const FEWEST: usize = 16;
    let is_time = names.iter().any(|name| names::usual(name).is_some());
    let (Some(name), Some(first)) = (names.first(), columns.first()) else { return };
    if !is_time
        && about.clocks.is_empty()
        && (name.ends_with("_1") || name == "c1")
        && first.len() >= FEWEST
        && columns.len() > 1
        && names::rises(first)
    {
        about.clocks.push(0);
        about.notes.push(names::by_rise("names", name));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_become_columns_within_the_limit() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let arrays = |constants: usize| {
            let constants = (0..constants).map(|k| (format!("c{k}"), vec![1.0]));
            of_one_length(
                file.path(),
                constants.chain([("t".into(), vec![0.0; 100_000])]).collect(),
                &mut About::default(),
            )
        };
        assert_eq!(arrays(3).map(|(names, _)| names.len()).ok(), Some(4));
        let refused = arrays(3000).expect_err("2.4 GB").to_string();
        assert!(refused.contains("as 3001 columns it claims 2400800000 bytes, more than the limit of"), "{refused}");
    }

    #[test]
    fn an_implausible_rate_of_a_constant_is_told_and_not_taken() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        for (value, step_s, words) in [(8000.0, Some(1.0 / 8000.0), "by log.fs"), (1e-4, None, "no rate is taken")] {
            let mut about = About::default();
            let arrays = vec![("log.fs".into(), vec![value]), ("log.iq".into(), vec![0.0; 50])];
            of_one_length(file.path(), arrays, &mut about).expect("columns");
            assert_eq!(about.step_s, step_s);
            assert!(about.notes.len() == 1 && about.notes[0].contains(words), "{:?}", about.notes);
        }
    }

    #[test]
    fn the_first_row_of_a_matrix_without_names_may_be_the_time() {
        let clocks = |first: fn(usize) -> f64, name: &str| {
            let columns = [(0..50).map(first).collect(), vec![1.0; 50]];
            let mut about = About::default();
            rising_time(&[name.into(), "m_2".into()], &columns, &mut about);
            (about.clocks, about.notes.len())
        };
        assert_eq!(clocks(|k| k as f64 / 16e3, "m_1"), (vec![0], 1));
        for (first, name) in [(|k| k as f64, "m_1"), (|k| (k % 7) as f64, "m_1"), (|k| k as f64 / 16e3, "angle")]
            as [(fn(usize) -> f64, &str); 3]
        {
            assert_eq!(clocks(first, name), (vec![], 0));
        }
    }
}
