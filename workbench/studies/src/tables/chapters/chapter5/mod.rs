//! Tables 5.2–5.15: the source's method on the simulated actuator, and ours.

pub mod draw;
pub(in crate::tables) mod park;
pub mod published;

use bearing_watch::plan::Kind;

use super::chapter4::{Chosen, LITERAL};
use crate::ema::recipe;
use crate::ema::source::{self, Estimated};
use crate::tables::published::written_order;
use crate::tables::result::{Cell, Column, Digits, Row, Table};
use draw::Draw;
use model::Error;
use model::core::Finding;
use model::evaluate::{self, Confusion};
use model::identify::Method;
use model::train::{ProjectionKind, train};
use published::Published;

/// Headings of the columns, in order.
pub(in crate::tables) const COLUMNS: [&str; 5] =
    ["published", "misclassified", "published fit", "healthy fit", "worst healthy fit"];

/// Name of the row with the results of our method.
pub const OURS: &str = "ours: torque balance, orders of both races, QDA, the core in f32";

/// Description of our method in one sentence.
pub const OURS_DESCRIPTION: &str = "Ours, for the actuator: drag from the torque balance, and the scores of \
     the orders of both races; at RIT from phase currents and resolver counts through the core's front end.";

/// Computes the table of one repetition.
///
/// # Errors
/// Returns an error if a trace cannot be estimated or features are singular.
pub(in crate::tables) fn measure(published: &Published, draw: &Draw) -> Result<Table, Error> {
    Ok(Table {
        id: published.number,
        title: title(published),
        conditions: conditions(published, draw),
        columns: COLUMNS.iter().map(|name| Column::new(*name, Digits::Fixed(1))).collect(),
        rows: rows(published, draw)?,
        words: vec![],
        figures: vec![],
    })
}

fn rows(published: &Published, draw: &Draw) -> Result<Vec<Row>, Error> {
    let iv4 = draw.estimates(published, Method::Iv4)?;
    let ls = draw.estimates(published, Method::Ls)?;
    let asked = source::groups(published.order);
    let a = chosen(published, &iv4, asked)?;
    let without = errors(&a.first_two(), ProjectionKind::None, Kind::Linear)?;
    let with = errors(&a, a.to_two(), Kind::Linear)?;
    let [training, validation] = [0, 1].map(|set| published.without_pca.map(|rates| rates[set]));
    let mut rows = vec![
        row("training, without PCA", training, without[0]),
        row("validation, without PCA", validation, without[1]),
    ];
    let [training, validation] = [0, 1].map(|set| published.with_pca.map(|rates| rates[set]));
    rows.push(row("training, with PCA", training, with[0]));
    rows.push(fits(row(LITERAL, validation, with[1]), Some(published.fit_percent), &iv4[1]));
    rows.push(row("the same, quadratic", None, errors(&a, a.to_two(), Kind::Quadratic)?[1]));
    let squares = chosen(published, &ls, asked)?;
    let name = "the same, LS in place of iv4";
    rows.push(fits(row(name, None, errors(&squares, squares.to_two(), Kind::Linear)?[1]), None, &ls[1]));
    rows.push(all_parameters(&chosen(published, &ls, &[])?));
    rows.push(row(OURS, None, ours(draw)?.error_rate().value));
    Ok(rows)
}

/// The row of all parameters. Of a command that stands most of the time they may be linearly dependent over the
/// training set; then there is no discriminant, and the cell is empty.
fn all_parameters(chosen: &Chosen) -> Row {
    let mut row = row("LS, a b c, no projection", None, f64::NAN);
    row.cells[1] = match errors(chosen, ProjectionKind::None, Kind::Linear) {
        Ok([_, validation]) => Cell::percent(validation),
        Err(_) => Cell::Empty,
    };
    row
}

fn title(published: &Published) -> String {
    let Published { number, with, input, order, .. } = published;
    let with = with.map_or_else(String::new, |with| format!(" and Table {with} (with PCA)"));
    format!("Table {number}{with}: misclassified, %; u1 = {}, order {}", input.name(), written_order(*order))
}

fn conditions(published: &Published, draw: &Draw) -> String {
    let (condition, traces) = (draw.condition(), draw::traces(draw.condition()));
    let [healthy, degraded] = draw::classes(condition);
    let output = if published.with.is_some() { "position, as recorded" } else { "quadrature current, 400 Hz" };
    let unused = if published.without_pca.is_some() { "" } else { " The source did not use this model." };
    format!(
        "Condition {}: {}; y = {output}, u2 = load torque; {traces} + {traces} traces of {} and {}.{unused}",
        condition.name,
        condition.about,
        healthy.name(),
        degraded.name()
    )
}

fn row(name: &str, published: Option<f64>, rate: f64) -> Row {
    let published = published.map_or(Cell::Empty, Cell::Published);
    Row { name: name.into(), cells: vec![published, Cell::percent(rate), Cell::Empty, Cell::Empty, Cell::Empty] }
}

/// The row with published fit, median and least fit of the healthy traces.
fn fits(mut row: Row, published: Option<f64>, estimated: &Estimated) -> Row {
    let fits = &estimated.fits;
    let cell = |place: usize| fits.get(place).copied().map_or(Cell::Empty, Cell::one);
    row.cells.truncate(2);
    row.cells.extend([published.map_or(Cell::Empty, Cell::Published), cell(fits.len() / 2), cell(0)]);
    row
}

/// The named features of both sets.
fn chosen(published: &Published, [training, validation]: &[Estimated; 2], asked: &[&str]) -> Result<Chosen, Error> {
    let (names, places) = source::choose(published.order, asked)?;
    Ok(Chosen { names, training: training.table.select(&places), validation: validation.table.select(&places) })
}

/// Error rates in training and in validation.
fn errors(chosen: &Chosen, projection: ProjectionKind, kind: Kind) -> Result<[f64; 2], Error> {
    Ok(chosen.judge(&chosen.rule(projection, kind)?).map(|judged| judged.all_error()))
}

/// Decisions on the validation set by the embedded detector that was trained on the training set.
fn ours(draw: &Draw) -> Result<Confusion, Error> {
    let [training, validation] = draw.ours();
    let names = draw.names();
    let model = train(&training, &names, &recipe::classes_alone())?.embed()?;
    let mut confusion = Confusion::new(&names);
    for verdict in evaluate::run(&model, &validation, || ())? {
        confusion.add(verdict.class, verdict.decided.and_then(Finding::class));
    }
    Ok(confusion)
}
