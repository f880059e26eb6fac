//! Sections on what training chose, and on what it doubts.

use model::train::{Automatic, Dependence, Detected, Doubted, Rival, Trained};

use crate::page::table::table;
use crate::page::{or_reason, paragraph};
use crate::plot::{self, Panel, Series};
use crate::{Color, Marker};

/// Why these features: in words, as a table of the compared sets, and the share found over the size of defects.
#[must_use]
pub fn choice(automatic: &Automatic) -> String {
    let words: String = automatic.lines().iter().map(|line| paragraph(&sentence(line))).collect();
    words + &figure(automatic) + &compared(automatic)
}

/// What is unusual about the healthy records; `None` if nothing is.
#[must_use]
pub fn doubts(trained: &Trained) -> Option<String> {
    let doubted = trained.doubted.iter().flat_map(Doubted::lines);
    let lines: Vec<String> = trained.dependence.iter().map(Dependence::line).chain(doubted).collect();
    (!lines.is_empty()).then(|| lines.iter().map(|line| paragraph(&sentence(line))).collect())
}

/// The line with a capital letter and a full stop.
fn sentence(line: &str) -> String {
    let mut letters = line.chars();
    let first = letters.next().map(char::to_uppercase).into_iter().flatten();
    let end = if line.ends_with('.') { "" } else { "." };
    first.chain(letters).collect::<String>() + end
}

/// Share found over the size: the chosen set solid, the next best dashed.
fn figure(automatic: &Automatic) -> String {
    let own = automatic.winner();
    if own.detected.is_empty() {
        return String::new();
    }
    let series = |one: &Detected, set: &str, color: usize| {
        let points = one.sizes_a.iter().zip(&one.found).map(|(size, found)| (*size, 100.0 * found));
        Series::new(format!("{}, {set}", one.kind), Color::of(color), points).marked(Marker::of(color))
    };
    let color = |kind: &str| own.detected.iter().position(|one| one.kind == kind).unwrap_or(own.detected.len());
    let chosen = own.detected.iter().map(|one| series(one, "chosen", color(&one.kind)));
    let next = automatic.next().map_or(&[][..], |other| &other.detected);
    let next = next.iter().map(|one| series(one, "next best", color(&one.kind)).dashed());
    let panel = Panel::new("found / %", chosen.chain(next).collect());
    or_reason(plot::sweeps("Records in which an added defect is found", "size of the defect / A", &[panel]))
}

/// The compared sets of features.
fn compared(automatic: &Automatic) -> String {
    let kinds: Vec<&str> = automatic.winner().detected.iter().map(|one| one.kind.as_str()).collect();
    let half = |rival: &Rival, kind: &str| match rival.detected.iter().find(|one| one.kind == kind) {
        Some(one) if one.sizes_a.last().is_some_and(|last| one.half_a <= *last) => format!("{:.2e}", one.half_a),
        Some(one) => format!("> {:.2e}", one.sizes_a.last().copied().unwrap_or(0.0)),
        None => "–".into(),
    };
    let row = |(k, rival): (usize, &Rival)| {
        let rate = if rival.refused.is_some() { "–".into() } else { format!("{:.1}", 100.0 * rival.rate) };
        let place = if k == automatic.chosen { "chosen" } else { "" };
        let sizes = kinds.iter().map(|kind| half(rival, kind).replace('-', "−"));
        let ends = [rival.refused.clone().unwrap_or_default()];
        [vec![rival.words(), place.into(), rate], sizes.collect(), ends.to_vec()].concat()
    };
    let rows: Vec<Vec<String>> = automatic.rivals.iter().enumerate().map(row).collect();
    let rate = if automatic.by_classes { "wrong / %" } else { "healthy novel / %" };
    let sizes = kinds.iter().map(|kind| format!("{kind}: half found from / A"));
    let header: Vec<String> = ["features", "", rate].map(String::from).into_iter().chain(sizes).collect();
    let refused = automatic.rivals.iter().any(|rival| rival.refused.is_some());
    let header = [header, if refused { vec!["not possible, because".into()] } else { vec![] }].concat();
    let rows: Vec<Vec<String>> = rows.into_iter().map(|row| row[..header.len()].to_vec()).collect();
    table(&header, &rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;

    fn rival(name: &str, half_a: f64, refused: Option<&str>) -> Rival {
        let sizes_a = vec![0.001, 0.01, 0.1];
        let one = Detected { kind: "outer".into(), sizes_a, found: vec![0.0, 0.5, 1.0], half_a };
        Rival {
            features: vec![name.into()],
            covariates: vec![],
            rate: 0.01,
            detected: vec![one],
            refused: refused.map(String::from),
        }
    }

    fn automatic() -> Automatic {
        let rivals = vec![rival("order_outer", 0.01, None), rival("a1", 0.05, None), rival("c1", 1.0, Some("<flat>"))];
        Automatic {
            rivals,
            chosen: 0,
            held_out: true,
            by_classes: false,
            notes: vec!["no load is measured".into()],
            temperatures: vec![],
        }
    }

    #[test]
    fn the_chosen_set_is_solid_and_the_next_one_dashed() {
        let html = choice(&automatic());
        assert_eq!(check(&html), Ok(()));
        assert!(
            html.contains("outer, chosen") && html.contains("outer, next best") && html.contains("\"dash\":\"dash\"")
        );
        assert!(
            html.contains("\"type\":\"log\"") && html.contains("&lt;flat&gt;") && html.contains("No load is measured.")
        );
        assert!(html.contains("<td>chosen</td>") && html.contains("&gt; 1.00e−1"), "{html}");
    }

    #[test]
    fn classes_have_rates_and_no_figure() {
        let mut own = automatic();
        own.by_classes = true;
        own.rivals.iter_mut().for_each(|rival| rival.detected.clear());
        let html = choice(&own);
        assert!(!html.contains("class=\"plot\"") && html.contains("wrong / %"), "{html}");
    }
}
