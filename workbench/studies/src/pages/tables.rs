//! Finished tables as one self-contained page with the plots of the first repetition.

use nalgebra::DVector;

use crate::tables::render::written;
use crate::tables::result::{Cell, Curve, Curves, Figure, Plane, PlaneClass, Row, Spread};
use crate::tables::{Settings, Table};
use pages::page::{Page, or_reason, paragraph};
use pages::palette::Color;
use pages::plot::{self, Density, Panel, ScatterClass, Series};
use pages::{Class, ReportError, table};

/// Creates the page.
#[must_use]
pub fn page(settings: &Settings, intro: &[String], tables: &[Table]) -> String {
    let lead = format!(
        "Simulated rigs, {} draws of training and validation sets, seeds from {}; mean ± standard deviation of \
         one draw.",
        settings.repetitions, settings.seed
    );
    let mut page =
        Page::new("bearing-watch: the source's tables beside ours").conclusion(conclusion(tables)).lead(lead);
    page = page.section("How to read the tables", &intro.iter().map(|words| paragraph(words)).collect::<String>());
    for one in tables {
        page = page.section(&one.title, &section(one));
    }
    page.render()
}

/// How the reproduced errors lie beside the published ones, and the largest of ours.
#[must_use]
pub fn conclusion(tables: &[Table]) -> String {
    let Some(overview) = tables.iter().find(|table| table.id == "overview") else {
        return "None of these tables has rates of wrong decisions: their notes say how the figures compare.".into();
    };
    let place = |name: &str| overview.columns.iter().position(|column| column.name == name);
    let cell = |row: &Row, name: &str| place(name).and_then(|place| row.cells.get(place)).cloned();
    let mean = |row: &Row, name: &str| cell(row, name).and_then(|own| own.statistic()).map(|own| own.mean);
    let published = |row: &Row| match cell(row, "published") {
        Some(Cell::Published(value)) => Some(value),
        _ => None,
    };
    let pairs: Vec<(f64, f64)> =
        overview.rows.iter().filter_map(|row| Some((published(row)?, mean(row, "source's method")?))).collect();
    let more = pairs.iter().filter(|(published, found)| found > published).count();
    let ours = overview.rows.iter().filter_map(|row| Some((mean(row, "ours")?, row.name.as_str())));
    let ours = ours.max_by(|one, other| one.0.total_cmp(&other.0)).map_or_else(String::new, |(worst, name)| {
        format!(" The largest error of ours is {worst:.1} %, in {}.", name.split(':').next().unwrap_or(name))
    });
    format!(
        "Of {} published rates of wrong decisions, the source's method exceeds {more} on the simulated rigs.{ours} The \
         note below each table says how far a difference is more than chance: read it before you compare.",
        pairs.len()
    )
}

fn section(one: &Table) -> String {
    let head: Vec<&str> = std::iter::once("").chain(one.columns.iter().map(|c| c.name.as_str())).collect();
    let rows: Vec<Vec<String>> = one.rows.iter().map(|row| cells(written(row, &one.columns))).collect();
    let words: String = one.words.iter().map(|words| paragraph(words)).collect();
    let figures: String = one.figures.iter().map(figure).collect();
    paragraph(&one.conditions) + &table::table(&head, &rows) + &words + &figures
}

/// Minus signs and no-break spaces keep numbers and order vectors on one line.
fn cells(mut row: Vec<String>) -> Vec<String> {
    if let Some((before, rest)) = row[0].split_once('[')
        && let Some((order, after)) = rest.split_once(']')
    {
        row[0] = format!("{before}[{}]{after}", order.replace(' ', "\u{a0}"));
    }
    for cell in row.iter_mut().skip(1) {
        *cell = cell.replace('-', "−").replace(' ', "\u{a0}");
    }
    row
}

fn figure(figure: &Figure) -> String {
    match figure {
        Figure::Curves(curves) => or_reason(plot::signals(&curves.title, &curves.x_label, &panels(curves))),
        Figure::Spread(spread) => or_reason(densities(spread)),
        Figure::Plane(plane) => or_reason(scatter(plane)),
    }
}

fn panels(curves: &Curves) -> Vec<Panel> {
    let panel = |(label, curves): &(String, Vec<_>)| {
        let series =
            |(k, curve): (usize, &Curve)| Series::new(curve.name.clone(), Color::of(k), curve.points.iter().copied());
        Panel::new(label.clone(), curves.iter().enumerate().map(series).collect())
    };
    curves.panels.iter().map(panel).collect()
}

fn densities(spread: &Spread) -> Result<String, ReportError> {
    let Spread { title, feature, classes } = spread;
    let one = |(k, (name, samples)): (usize, &(String, Vec<f64>))| Density {
        class: Class::new(k, name.clone()),
        samples: samples.clone(),
    };
    plot::densities(title, feature, &classes.iter().enumerate().map(one).collect::<Vec<_>>())
}

fn scatter(plane: &Plane) -> Result<String, ReportError> {
    let one = |(k, one): (usize, &PlaneClass)| ScatterClass {
        class: Class::new(k, one.name.clone()),
        training: one.training.clone(),
        held_out: one.held_out.clone(),
        novel: vec![],
    };
    let classes: Vec<ScatterClass> = plane.classes.iter().enumerate().map(one).collect();
    let decide = |x, y| plane.rule.decide(&DVector::from_vec(vec![x, y]));
    plot::scatter_regions(&plane.title, "z1", "z2", &classes, decide)
}
