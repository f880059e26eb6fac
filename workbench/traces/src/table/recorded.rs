//! Columns of a table in memory.

use std::borrow::Cow;
use std::path::Path;

use model::Error;
use model::trace::{Cells, Recorded};

use crate::table::columns::{Columns, Wanted};
use crate::table::from_first::{FromFirst, HEAD, TEXTS, are_dates};

/// Places of the columns that are times, the best first.
pub(super) fn clocks(table: &Recorded) -> Vec<usize> {
    let rank = |(place, (name, cells)): (usize, &(String, Cells))| match cells {
        Cells::Times(times) => Some((times.rank?, place)),
        Cells::Texts(texts) if name != "trace" && are_dates(&texts[..texts.len().min(HEAD)]) => Some((TEXTS, place)),
        _ => None,
    };
    let mut clocks: Vec<(u8, usize)> = table.columns().iter().enumerate().filter_map(rank).collect();
    clocks.sort_unstable();
    clocks.into_iter().map(|(_, place)| place).collect()
}

/// Reads the wanted columns and rows; texts at these places are times.
pub(super) fn read(table: &Recorded, clocks: &[usize], wanted: Wanted<'_>) -> Result<Columns, Error> {
    let texts = wanted.text.map(|place| texts(table, place)).transpose()?;
    let keep = |cells: &Vec<String>| (0..cells.len()).filter(|row| (wanted.row)(&cells[*row])).collect();
    let kept: Option<Vec<usize>> = texts.as_ref().map(keep);
    let column = |place: &usize| {
        let (name, cells) = &table.columns()[*place];
        let numbers = match cells {
            Cells::Numbers(numbers) => Cow::Borrowed(numbers),
            Cells::Times(times) => Cow::Borrowed(&times.seconds),
            Cells::Texts(texts) if clocks.contains(place) => {
                let seconds = FromFirst::default().of_texts(texts);
                let wrong = |(row, problem)| {
                    Error::content(Path::new(table.name()), format!("row {}, column {name}", row + 1), problem)
                };
                Cow::Owned(seconds.map_err(wrong)?)
            }
            Cells::Texts(_) => return Err(table.wrong_kind(name, "numbers", "text")),
            Cells::Other(kind) => return Err(table.wrong_kind(name, "numbers", kind)),
        };
        Ok(match &kept {
            None => numbers.into_owned(),
            Some(kept) => kept.iter().map(|row| numbers[*row]).collect(),
        })
    };
    let numbers: Vec<Vec<f64>> = wanted.numbers.iter().map(column).collect::<Result<_, _>>()?;
    if texts.is_none() && numbers.first().is_some_and(Vec::is_empty) {
        return Err(Error::content(Path::new(table.name()), "content", "no rows"));
    }
    let texts = texts.zip(kept).map(|(cells, kept)| kept.iter().map(|row| cells[*row].clone()).collect());
    Ok(Columns { numbers, texts, ..Columns::default() })
}

/// The cells of a column of text, or of whole numbers as text.
fn texts(table: &Recorded, place: usize) -> Result<Vec<String>, Error> {
    match &table.columns()[place] {
        (_, Cells::Texts(texts)) => Ok(texts.clone()),
        (_, Cells::Numbers(numbers)) if numbers.iter().all(|x| x.fract() == 0.0) => {
            Ok(numbers.iter().map(ToString::to_string).collect())
        }
        (name, Cells::Times(_)) => Err(table.wrong_kind(name, "text or whole numbers", "times")),
        (name, Cells::Numbers(_)) => Err(table.wrong_kind(name, "text or whole numbers", "fractions")),
        (name, Cells::Other(kind)) => Err(table.wrong_kind(name, "text or whole numbers", kind)),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use model::trace::Times;

    use super::*;
    use crate::table::Table;
    use crate::table::from_first::{POINTS, SPANS};

    fn numbers(values: &[f64]) -> Cells {
        Cells::Numbers(values.to_vec())
    }

    #[test]
    fn a_tidy_table_gives_the_rows_of_wanted_traces() {
        let ids = Cells::Texts(["b", "a", "b"].map(String::from).to_vec());
        let columns = vec![("trace".into(), ids), ("i".into(), numbers(&[1.0, 2.0, 3.0]))];
        let table = Table::of(&Arc::new(Recorded::new("bench", columns).expect("equal lengths")));
        let wanted = |row: &str| row == "b";
        let found = table.read(Wanted { numbers: &[1], text: Some(0), row: &wanted }).expect("numbers");
        assert_eq!((found.numbers, found.texts), (vec![vec![1.0, 3.0]], Some(vec!["b".into(), "b".into()])));
        let text = table.read(Wanted { numbers: &[0], text: None, row: &wanted }).expect_err("text").to_string();
        assert_eq!(text, "bench, column trace: no numbers but text");
    }

    #[test]
    fn the_best_column_of_times_is_the_first() {
        let times = |rank| Cells::Times(Times { seconds: vec![0.0, f64::NAN, 0.25], rank });
        let dates = ["2026-11-26 00:00:00", "", "2026-11-26T00:00:00.5Z"].map(String::from).to_vec();
        let columns = vec![
            ("day".into(), times(None)),
            ("span".into(), times(Some(SPANS))),
            ("said".into(), Cells::Texts(dates)),
            ("at".into(), times(Some(POINTS))),
        ];
        let table = Table::of(&Arc::new(Recorded::new("bench", columns).expect("equal lengths")));
        assert_eq!(table.about().clocks, [3, 2, 1]);
        let found = table.read(Wanted { numbers: &[2, 3], text: None, row: &|_| true }).expect("times").numbers;
        assert!(found[0][1].is_nan() && found[1][1].is_nan(), "{found:?}");
        assert_eq!([found[0][2], found[1][2]], [0.5, 0.25]);
        let mut said = vec!["2026-11-26 00:00:00".to_string(); HEAD];
        said.push("later".into());
        let table = Table::of(&Arc::new(Recorded::new("x", vec![("said".into(), Cells::Texts(said))]).expect("one")));
        let refused = table.read(Wanted { numbers: &[0], text: None, row: &|_| true }).expect_err("a word").to_string();
        assert_eq!(refused, "x, row 65, column said: \"later\" is no date with a time, as other rows have");
    }

    #[test]
    fn bad_tables_are_refused() {
        let columns = vec![("i".into(), numbers(&[1.0, 2.0])), ("v".into(), numbers(&[1.0]))];
        let uneven = Recorded::new("x", columns).expect_err("uneven").to_string();
        assert_eq!(uneven, "x, column v: 1 values, but column i has 2; give columns of one length");
        let read = |values: &[f64]| {
            let table = Table::of(&Arc::new(Recorded::new("x", vec![("i".into(), numbers(values))]).expect("one")));
            table.read(Wanted { numbers: &[0], text: None, row: &|_| true }).expect_err("refused").to_string()
        };
        assert_eq!(read(&[]), "x, content: no rows");
        assert!(read(&[1.0, -1e300]).starts_with("x, row 2, column i: -1000000000"));
    }
}
