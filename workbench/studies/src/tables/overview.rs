//! The misclassification rates of all tables in one table.

use super::chapters::chapter4::LITERAL;
use super::chapters::chapter5;
use super::ours;
use super::result::{Cell, Column, Digits, Row, Table};

/// Published rate, the source's method and ours for each table of rates; `None` if `tables` contains no table of rates.
pub(super) fn of(tables: &[Table]) -> Option<Table> {
    let rows: Vec<Row> = tables.iter().flat_map(rows).collect();
    let columns = ["published", "source's method", "the same, traces", "ours"];
    (!rows.is_empty()).then(|| Table {
        id: "overview",
        title: "Overview: misclassified in validation, %".to_string(),
        conditions: "Table 3.2: healthy and spall. Tables 4.1–4.4: one decision among three classes; traces: wrong \
                     where one of the source's two binary classifiers errs. Tables 5.2–5.13: a healthy and a degraded \
                     actuator, with PCA."
            .to_string(),
        columns: columns.map(|name| Column::new(name, Digits::Fixed(1))).to_vec(),
        rows,
        words: vec![],
        figures: vec![],
    })
}

fn rows(table: &Table) -> Vec<Row> {
    let cell = |row: &str, column: &str| table.cell(row, column).cloned().unwrap_or(Cell::Empty);
    match table.id {
        // The order search has no published rates.
        "3.2" => {
            let published = table.rows.iter().filter(|row| matches!(row.cells.first(), Some(Cell::Published(_))));
            let one = |row: &Row| Row {
                name: format!("Table 3.2: {}", row.name),
                cells: vec![
                    cell(&row.name, "published"),
                    cell(&row.name, "validation"),
                    Cell::Empty,
                    cell(ours::NAME, "validation"),
                ],
            };
            published.map(one).collect()
        }
        id if id.starts_with('4') => {
            let cells = vec![
                cell(LITERAL, "published"),
                cell(LITERAL, "three classes"),
                cell(LITERAL, "traces"),
                cell(ours::NAME, "three classes"),
            ];
            vec![Row { name: format!("Table {id}: {}", table.title.split("; ").nth(1).unwrap_or_default()), cells }]
        }
        "5.35" => vec![],
        id if id.starts_with('5') => {
            let cells = vec![
                cell(LITERAL, "published"),
                cell(LITERAL, "misclassified"),
                Cell::Empty,
                cell(chapter5::OURS, "misclassified"),
            ];
            vec![Row { name: format!("Table {id}: {}", table.title.split("; ").nth(1).unwrap_or_default()), cells }]
        }
        _ => vec![],
    }
}
