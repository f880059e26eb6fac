//! Finished tables as text, tidy rows and JSON.

use serde_json::{Value, json};

use super::result::{Cell, Column, Row, Statistic};
use super::{Settings, Table};

/// Width of running text.
const WIDTH: usize = 110;

/// A table with its notes as plain text.
#[must_use]
pub fn text(table: &Table) -> String {
    let mut grid = vec![std::iter::once(String::new()).chain(table.columns.iter().map(|c| c.name.clone())).collect()];
    grid.extend(table.rows.iter().map(|row| written(row, &table.columns)));
    let widths: Vec<usize> = (0..=table.columns.len())
        .map(|k| grid.iter().map(|row: &Vec<String>| width(&row[k])).max().unwrap_or(0))
        .collect();
    let mut out = format!("{}\n{}\n", table.title, wrap(&table.conditions));
    for row in &grid {
        let mut line = format!("  {}{}", row[0], " ".repeat(widths[0] - width(&row[0])));
        for (cell, wide) in row.iter().zip(&widths).skip(1) {
            line += &format!("  {}{cell}", " ".repeat(wide - width(cell)));
        }
        out += &line;
        out.push('\n');
    }
    for words in &table.words {
        out += &wrap(words);
        out.push('\n');
    }
    out
}

/// Name and cells of a row as text.
#[must_use]
pub fn written(row: &Row, columns: &[Column]) -> Vec<String> {
    let cells = row.cells.iter().zip(columns).map(|(cell, column)| cell.write(column.digits));
    std::iter::once(row.name.clone()).chain(cells).collect()
}

fn width(text: &str) -> usize {
    text.chars().count()
}

/// Wraps the text to lines of at most 110 characters.
#[must_use]
pub fn wrap(text: &str) -> String {
    let mut out = String::new();
    let mut used = 0;
    for word in text.split_whitespace() {
        if used > 0 && used + 1 + width(word) > WIDTH {
            out.push('\n');
            used = 0;
        }
        if used > 0 {
            out.push(' ');
            used += 1;
        }
        out += word;
        used += width(word);
    }
    out
}

/// One row per figure: table, title, row, column, source (published or measured), mean, sd, repetitions.
#[must_use]
pub fn tidy(tables: &[Table]) -> Vec<Vec<String>> {
    let head = ["table", "title", "row", "column", "source", "mean", "sd", "repetitions"];
    let mut rows = vec![head.map(String::from).to_vec()];
    for table in tables {
        for row in &table.rows {
            for (cell, column) in row.cells.iter().zip(&table.columns) {
                let figures = match (cell, cell.statistic()) {
                    (Cell::Published(value), _) => {
                        ["published".into(), value.to_string(), String::new(), String::new()]
                    }
                    (_, Some(Statistic { mean, sd, count })) => {
                        let sd = sd.map_or_else(String::new, |sd| sd.to_string());
                        ["measured".into(), mean.to_string(), sd, count.to_string()]
                    }
                    _ => continue,
                };
                let names = [table.id, &table.title, &row.name, &column.name].map(String::from);
                rows.push([&names[..], &figures].concat());
            }
        }
    }
    rows
}

/// All content except the plots.
#[must_use]
pub fn to_json(settings: &Settings, tables: &[Table]) -> Value {
    json!({
        "repetitions": settings.repetitions,
        "seed": settings.seed,
        "ours": super::ours::DESCRIPTION,
        "tables": tables.iter().map(one).collect::<Vec<_>>(),
    })
}

fn one(table: &Table) -> Value {
    let cell = |cell: &Cell| match (cell, cell.statistic()) {
        (Cell::Published(value), _) => json!({ "published": value }),
        (_, Some(Statistic { mean, sd, count })) => json!({ "mean": mean, "sd": sd, "repetitions": count }),
        _ => Value::Null,
    };
    let row = |row: &Row| json!({ "name": row.name, "cells": row.cells.iter().map(cell).collect::<Vec<_>>() });
    json!({
        "id": table.id,
        "title": table.title,
        "conditions": table.conditions,
        "columns": table.columns.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "rows": table.rows.iter().map(row).collect::<Vec<_>>(),
        "words": table.words,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_wrapped_between_words() {
        let text = wrap(&"σσσσ ".repeat(50));
        assert!(text.lines().all(|line| width(line) <= WIDTH && !line.ends_with(' ')));
        assert_eq!(text.lines().map(width).collect::<Vec<_>>(), [109, 109, 29]); // 22 words of 4 and 21 spaces
    }
}
