//! Sections of a page with the figures and tables of a structure search.

use crate::conclusion::models;
use crate::page::table::table;
use crate::page::{or_reason, paragraph};
use crate::plot::{Series, lines, lines_within};
use crate::{Color, Marker, Page};
use model::identify::Structure;
use model::structure::{Candidate, Search};

/// Number of rows in the table of the best structures.
const TOP: usize = 20;

/// The structure as `2,2,2,1,1`, with `+offset` if there is a constant term.
#[must_use]
pub fn name(structure: Structure) -> String {
    let numbers = structure.orders().map(|n| n.to_string()).join(",");
    if structure.offset { numbers + " + offset" } else { numbers }
}

/// The page of a search: best per number of parameters, criteria, the best structures, and the user's choice.
#[must_use]
pub fn page(title: &str, lead: &str, search: &Search, pick: Option<&Candidate>) -> Page {
    let counted = search.best_by_count();
    let mut page = Page::new(title)
        .conclusion(models::searched(search, |own| name(own.fitted.structure)))
        .lead(lead)
        .section("Best fit by number of parameters", &(fits(search, &counted, pick) + &rows(&counted)))
        .section("Criteria by number of parameters", &criteria(search));
    let picks = [
        ("best fit", search.best_fit()),
        ("least AIC", search.best_aic()),
        ("least MDL", search.best_mdl()),
        ("your pick", pick),
    ];
    let picks: Vec<_> = picks.into_iter().filter_map(|(by, c)| Some((by, c?))).collect();
    let cells: Vec<Vec<String>> = picks
        .iter()
        .map(|(by, c)| [vec![(*by).to_string(), search.rank(c.fit_percent).to_string()], cells(c)].concat())
        .collect();
    let header = [&["by", "place by fit"][..], &HEADER].concat();
    page = page.section("Choices", &table(&header, &cells));
    let mut ranked: Vec<&Candidate> = search.candidates.iter().collect();
    ranked.sort_by(|a, b| b.fit_percent.total_cmp(&a.fit_percent));
    ranked.truncate(TOP);
    let mut best = rows(&ranked);
    if let Some(first) = search.refused.first() {
        let (count, example) = (search.refused.len(), name(first.structure));
        best += &paragraph(&format!("{count} structures have no estimate; {example}: {}.", first.reason));
    }
    page.section("Best structures by fit", &best)
}

const HEADER: [&str; 6] = ["na,nb,nc,nkb,nkc", "parameters", "fit / %", "AIC", "MDL", "poles"];

fn cells(candidate: &Candidate) -> Vec<String> {
    let fitted = &candidate.fitted;
    vec![
        name(fitted.structure),
        fitted.parameters().to_string(),
        format!("{:.3}", candidate.fit_percent),
        format!("{:.5}", fitted.aic()),
        format!("{:.5}", fitted.mdl()),
        if candidate.stable { "stable".into() } else { "unstable: reflected for the fit".into() },
    ]
}

fn rows(candidates: &[&Candidate]) -> String {
    let cells: Vec<Vec<String>> = candidates.iter().map(|c| cells(c)).collect();
    table(&HEADER, &cells)
}

fn fits(search: &Search, counted: &[&Candidate], pick: Option<&Candidate>) -> String {
    let point = |c: &Candidate| (c.fitted.parameters() as f64, c.fit_percent);
    let counts = |of: f64| search.candidates.iter().filter(move |c| c.fitted.parameters() as f64 == of);
    let median = |d: f64| {
        let mut fits: Vec<f64> = counts(d).map(|c| c.fit_percent).collect();
        fits.sort_by(f64::total_cmp);
        (d, fits[fits.len() / 2])
    };
    let best = counted.iter().map(|c| point(c));
    let mut series = vec![
        Series::new("best", Color::of(0), best.clone()).marked(Marker::Circle),
        Series::new("median", Color::of(6), best.map(|(d, _)| median(d))).dashed().marked(Marker::Square),
    ];
    series.extend(pick.map(|c| Series::new("your pick", Color::of(1), [point(c)]).marked(Marker::Diamond)));
    // A fit below zero is worse than the mean of the output, however far below.
    let view = [0.0, f64::INFINITY];
    or_reason(lines_within(view, "Free-run fit on the validation traces", "number of parameters", "fit / %", &series))
}

fn criteria(search: &Search) -> String {
    let most = search.candidates.iter().map(|c| c.fitted.parameters()).max().unwrap_or(0);
    let least = |key: fn(&Candidate) -> f64| {
        (1..=most).filter_map(move |d| {
            let of = search.candidates.iter().filter(|c| c.fitted.parameters() == d);
            of.map(key).min_by(f64::total_cmp).map(|value| (d as f64, value))
        })
    };
    let series = [
        Series::new("AIC", Color::of(0), least(|c| c.fitted.aic())).marked(Marker::Circle),
        Series::new("MDL", Color::of(1), least(|c| c.fitted.mdl())).marked(Marker::TriangleUp),
    ];
    or_reason(lines("Least AIC and MDL on the training traces", "number of parameters", "criterion", &series))
}
