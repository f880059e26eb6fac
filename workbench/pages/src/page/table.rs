//! HTML tables from rows of text or counts.

use std::fmt::Write as _;

use super::escape::escape;
use crate::ReportError;
use model::evaluate::Rate;

/// A plain table. Columns with only numeric cells are aligned right; short rows are filled with empty cells.
#[must_use]
pub fn table<H: AsRef<str>, C: AsRef<str>>(header: &[H], rows: &[Vec<C>]) -> String {
    let columns = rows.iter().map(Vec::len).chain([header.len()]).max().unwrap_or(0);
    let cell = |row: &Vec<C>, column: usize| row.get(column).map_or("", AsRef::as_ref).to_owned();
    let numeric: Vec<&str> = (0..columns)
        .map(|column| rows.iter().map(|row| cell(row, column)).all(|text| looks_numeric(&text)))
        .map(|numeric| if numeric && !rows.is_empty() { " class=\"number\"" } else { "" })
        .collect();

    let mut out = String::from("<div class=\"scroll\" tabindex=\"0\"><table><thead><tr>");
    for (column, class) in numeric.iter().enumerate() {
        let text = header.get(column).map_or("", AsRef::as_ref);
        let _ = write!(out, "<th scope=\"col\"{class}>{}</th>", escape(text));
    }
    out.push_str("</tr></thead><tbody>");
    for row in rows {
        out.push_str("<tr>");
        for (column, class) in numeric.iter().enumerate() {
            let _ = write!(out, "<td{class}>{}</td>", escape(&cell(row, column)));
        }
        out.push_str("</tr>");
    }
    out.push_str("</tbody></table></div>");
    out
}

/// Whether the text starts like a number or marks a missing one.
fn looks_numeric(text: &str) -> bool {
    let text = text.trim_start_matches(['−', '-', '+', '±', '<', '>', '≤', '≥', '≈', ' ', '.']);
    text.is_empty() || text == "–" || text == "—" || text.starts_with(|c: char| c.is_ascii_digit())
}

/// Counts of the decisions on the samples of one true class.
#[derive(Debug, Clone, PartialEq)]
pub struct ConfusionRow {
    /// Number of decisions for each class, in the order of the classes.
    pub counts: Vec<u64>,
    /// Number of samples without decision; the column is shown if it is set in some row.
    pub undetermined: Option<u64>,
    /// Share decided correctly, with its interval.
    pub correct: Option<Rate>,
}

/// True classes in rows, decided classes in columns; each cell is tinted by its share of the row.
///
/// # Errors
/// [`ReportError::NoClasses`] without classes, [`ReportError::Length`] if the number of rows or the number of counts in
/// a row differs from the number of classes.
pub fn confusion_table<S: AsRef<str>>(classes: &[S], rows: &[ConfusionRow]) -> Result<String, ReportError> {
    let (title, expected) = ("confusion table".to_owned(), classes.len());
    if expected == 0 {
        return Err(ReportError::NoClasses { title });
    }
    if rows.len() != expected {
        return Err(ReportError::Length { title, row: rows.len(), found: rows.len(), expected });
    }
    if let Some((row, bad)) = rows.iter().enumerate().find(|(_, row)| row.counts.len() != expected) {
        return Err(ReportError::Length { title, row, found: bad.counts.len(), expected });
    }
    let undetermined = rows.iter().any(|row| row.undetermined.is_some());
    let rates = rows.iter().any(|row| row.correct.is_some());
    let mut out = confusion_head(classes, undetermined, rates);
    for (index, (row, class)) in rows.iter().zip(classes).enumerate() {
        let total = row.counts.iter().chain(&row.undetermined).fold(0, |sum: u64, n| sum.saturating_add(*n));
        let _ = write!(out, "<tr><th scope=\"row\">{}</th>", escape(class.as_ref()));
        for (decided, &count) in row.counts.iter().enumerate() {
            out.push_str(&count_cell(count, total, if decided == index { "hit" } else { "miss" }));
        }
        if undetermined {
            out.push_str(&count_cell(row.undetermined.unwrap_or(0), total, "none"));
        }
        let _ = write!(out, "<td class=\"number\">{total}</td>");
        if rates {
            out.push_str(&row.correct.map_or_else(|| "<td class=\"number\">–</td>".to_owned(), rate_cell));
        }
        out.push_str("</tr>");
    }
    out.push_str("</tbody></table></div>");
    Ok(out)
}

fn confusion_head<S: AsRef<str>>(classes: &[S], undetermined: bool, rates: bool) -> String {
    let decided = classes.len() + usize::from(undetermined);
    let mut out = format!(
        "<div class=\"scroll\" tabindex=\"0\"><table class=\"confusion\"><thead><tr><th rowspan=\"2\" scope=\"col\">true class</th>\
         <th colspan=\"{decided}\" scope=\"colgroup\">decided</th>\
         <th rowspan=\"2\" scope=\"col\" class=\"number\">total</th>"
    );
    if rates {
        out.push_str("<th rowspan=\"2\" scope=\"col\">correct, 95 % interval</th>");
    }
    out.push_str("</tr><tr>");
    for class in classes {
        let _ = write!(out, "<th scope=\"col\" class=\"number\">{}</th>", escape(class.as_ref()));
    }
    if undetermined {
        out.push_str("<th scope=\"col\" class=\"number\"><i>undeter&shy;mined</i></th>");
    }
    out.push_str("</tr></thead><tbody>");
    out
}

#[expect(clippy::cast_precision_loss, reason = "a share of a count; three digits are shown")]
fn count_cell(count: u64, total: u64, kind: &str) -> String {
    if count == 0 {
        return "<td class=\"number zero\">0</td>".to_owned();
    }
    let share = count as f64 / total.max(1) as f64;
    // The tint is a colour of the style sheet with this opacity, so that it suits light and dark pages.
    let opacity = 0.08 + 0.5 * share;
    format!("<td class=\"number {kind}\" style=\"--share:{opacity:.2}\">{count}</td>")
}

/// The rate as text and as a mark on a scale from 0 to 100 %.
fn rate_cell(rate: Rate) -> String {
    if !(rate.value.is_finite() && rate.low.is_finite() && rate.high.is_finite()) {
        return "<td class=\"number\">–</td>".to_owned();
    }
    let percent = [rate.value, rate.low, rate.high].map(|r| 100.0 * r.clamp(0.0, 1.0));
    let [value, low, high] = percent;
    format!(
        "<td class=\"rate\"><span class=\"interval\" style=\"--value:{value:.1}%;--low:{low:.1}%;--high:{high:.1}%\"></span> \
         {value:.1} % ({low:.1}–{high:.1})</td>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;

    fn row(counts: &[u64]) -> ConfusionRow {
        ConfusionRow { counts: counts.into(), undetermined: None, correct: None }
    }

    #[test]
    fn cells_are_escaped_and_rows_filled_up() {
        let html = table(&["file", "n"], &[vec!["<x>.csv", "12"], vec!["a&b"]]);
        assert_eq!(check(&html), Ok(()));
        assert!(html.contains("&lt;x&gt;.csv") && html.contains("a&amp;b") && html.contains("<td class=\"number\">12"));
        assert_eq!(html.matches("<td").count(), 4);
        assert_eq!(check(&table::<&str, &str>(&[], &[])), Ok(()));
    }

    #[test]
    fn numbers_are_recognised() {
        assert!(["12", "−3.5 A", "95 % (90–97)", "< 0.1", "–", ""].into_iter().all(looks_numeric));
        assert!(!["run-3.csv", "outer race", "a1"].into_iter().any(looks_numeric));
    }

    #[test]
    fn confusion_shows_totals_and_rates() {
        let correct = Some(Rate { value: 0.9, low: 0.82, high: 0.95 });
        let first = ConfusionRow { undetermined: Some(2), correct, ..row(&[90, 8]) };
        let html = confusion_table(&["good", "<bad>"], &[first, row(&[0, 0])]).expect("consistent");
        assert_eq!(check(&html), Ok(()));
        assert!(html.contains("90.0 % (82.0–95.0)") && html.contains(">100</td>") && html.contains("&lt;bad&gt;"));
        assert!(html.contains("<i>undeter"));
    }

    #[test]
    fn inconsistent_tables_are_errors() {
        assert!(matches!(confusion_table::<&str>(&[], &[]), Err(ReportError::NoClasses { .. })));
        let error = confusion_table(&["a", "b"], &[row(&[1, 2]), row(&[1])]);
        assert!(matches!(error, Err(ReportError::Length { row: 1, found: 1, expected: 2, .. })));
        assert!(confusion_table(&["a"], &[]).is_err());
    }

    #[test]
    fn rates_that_are_not_finite_are_dashes() {
        assert_eq!(rate_cell(Rate { value: f64::NAN, low: 0.0, high: 1.0 }), "<td class=\"number\">–</td>");
    }
}
