//! Columns of a table in memory.

use std::path::Path;

use model::Error;
use model::trace::{Cells, Recorded};

use super::columns::{Columns, Wanted};

/// Reads the wanted columns and rows.
pub(super) fn read(table: &Recorded, wanted: Wanted<'_>) -> Result<Columns, Error> {
    let texts = wanted.text.map(|place| texts(table, place)).transpose()?;
    let keep = |cells: &Vec<String>| (0..cells.len()).filter(|row| (wanted.row)(&cells[*row])).collect();
    let kept: Option<Vec<usize>> = texts.as_ref().map(keep);
    let column = |place: &usize| match (&table.columns()[*place], &kept) {
        ((_, Cells::Numbers(numbers)), None) => Ok(numbers.clone()),
        ((_, Cells::Numbers(numbers)), Some(kept)) => Ok(kept.iter().map(|row| numbers[*row]).collect()),
        ((name, Cells::Texts(_)), _) => Err(table.wrong_kind(name, "numbers", "text")),
        ((name, Cells::Other(kind)), _) => Err(table.wrong_kind(name, "numbers", kind)),
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
        (name, Cells::Numbers(_)) => Err(table.wrong_kind(name, "text or whole numbers", "fractions")),
        (name, Cells::Other(kind)) => Err(table.wrong_kind(name, "text or whole numbers", kind)),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::Table;
    use super::*;

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
