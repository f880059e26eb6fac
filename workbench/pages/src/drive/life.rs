//! The nominal life of a bearing and its load collective.

use crate::page::paragraph;
use crate::page::table::table;
use model::life::Collective;

/// The figures, where they do not hold, and the turns by load.
#[must_use]
pub fn html(collective: &Collective) -> String {
    let text: String = collective.lines().iter().map(|line| paragraph(line.trim())).collect();
    let rows: Vec<Vec<String>> = collective
        .classes()
        .filter(|(.., turns)| *turns > 0.0)
        .map(|(from, to, turns)| {
            let to = if to.is_finite() { format!("{to:.0}") } else { "–".into() };
            vec![format!("{from:.0}"), to, format!("{turns:.1}")]
        })
        .collect();
    if rows.is_empty() { text } else { text + &table(&["load from / N", "to / N", "turns"], &rows) }
}
