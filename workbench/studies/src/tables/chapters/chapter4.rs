//! Tables 4.1–4.4: the source's method as printed, variants with one change each, and our method.

use bearing_watch::plan::Kind;

use crate::demo::FirstInput;
use crate::literal::{Judged, Rule, principal};
use crate::tables::draw::{Draw, Model, choose};
use crate::tables::ours;
use crate::tables::published::{Simulation, written_order};
use crate::tables::recorded::Selection;
use crate::tables::result::{Cell, Column, Digits, Figure, Plane, PlaneClass, Row, Table};
use model::Error;
use model::identify::Method;
use model::train::{FeatureTable, ProjectionKind};

/// Headings of the columns, in order.
pub(in crate::tables) const COLUMNS: [&str; 7] =
    ["published", "three classes", "healthy / spall", "healthy / roughness", "both pooled", "traces", "healthy fit"];

/// The source's validation with PCA, on which its conclusions are based.
pub(in crate::tables) const LITERAL: &str = "validation, with PCA";

const SELECTION: Selection = Selection::CHAPTER_4;

/// Computes the table of one repetition.
///
/// # Errors
/// Returns an error if a trace cannot be estimated or features are singular.
pub(in crate::tables) fn measure(published: &Simulation, draw: &Draw) -> Result<Table, Error> {
    let model = |method| Model { input: published.input, order: published.order, method };
    let iv4 = Features::new(draw, model(Method::Iv4))?;
    let ls = Features::new(draw, model(Method::Ls))?;
    let a = &iv4.a;
    let without = a.first_two().rule(ProjectionKind::None, Kind::Linear)?;
    let with = a.rule(a.to_two(), Kind::Linear)?;

    let mut rows = Vec::new();
    let [training, validation] = a.first_two().judge(&without);
    rows.push(row("training, without PCA", Some(published.without_pca[0]), &training));
    rows.push(row("validation, without PCA", Some(published.without_pca[1]), &validation));
    let [training, validation] = a.judge(&with);
    rows.push(row("training, with PCA", Some(published.with_pca[0]), &training));
    rows.push(row(LITERAL, Some(published.with_pca[1]), &validation).fit(iv4.fit));
    let held_out = |set: &Chosen, projection, kind| -> Result<Judged, Error> {
        let [_, validation] = set.judge(&set.rule(projection, kind)?);
        Ok(validation)
    };
    let two = a.to_two();
    rows.push(row("the same, quadratic", None, &held_out(a, two, Kind::Quadratic)?));
    rows.push(row("the same, LS in place of iv4", None, &held_out(&ls.a, two, Kind::Linear)?).fit(ls.fit));
    rows.push(row("iv4, a b c, PCA to 2", None, &held_out(&iv4.all, principal(2), Kind::Linear)?));
    rows.push(row("iv4, a b c, no projection", None, &held_out(&iv4.all, ProjectionKind::None, Kind::Linear)?));
    rows.push(row("LS, a b c, no projection", None, &held_out(&ls.all, ProjectionKind::None, Kind::Linear)?));
    rows.push(row(ours::NAME, None, &draw.ours(SELECTION)?));

    let columns = COLUMNS.iter().map(|name| Column::new(*name, Digits::Fixed(1))).collect();
    let input = match published.input {
        FirstInput::Reference => "velocity reference",
        FirstInput::Error => "velocity error",
    };
    let order = written_order(published.order);
    Ok(Table {
        id: published.number,
        title: format!("Table {}: misclassified, %; u1 = {input}, order {order}", published.number),
        conditions: format!(
            "y = current, u2 = load torque; {} + {} traces of healthy, spall and roughness; published fit {} %.",
            SELECTION.traces, SELECTION.traces, published.fit_percent
        ),
        columns,
        rows: rows.into_iter().map(|row| row.0).collect(),
        words: vec![],
        figures: vec![plane(published, a, with)],
    })
}

/// Feature sets of one model.
struct Features {
    a: Chosen,
    all: Chosen,
    fit: f64,
}

impl Features {
    fn new(draw: &Draw, model: Model) -> Result<Self, Error> {
        let estimates = draw.estimates(model)?;
        let chosen = |asked: &[&str]| -> Result<Chosen, Error> {
            let (names, places) = choose(model, asked)?;
            let [training, validation] = estimates.tables(SELECTION, &places);
            Ok(Chosen { names, training, validation })
        };
        Ok(Self { a: chosen(&["a"])?, all: chosen(&[])?, fit: estimates.healthy_fit(SELECTION) })
    }
}

struct Filled(Row);

impl Filled {
    fn fit(mut self, fit_percent: f64) -> Self {
        if let Some(last) = self.0.cells.last_mut() {
            *last = Cell::one(fit_percent);
        }
        self
    }
}

fn row(name: &str, published: Option<f64>, judged: &Judged) -> Filled {
    let rates =
        [judged.all_error(), judged.pair_error(1), judged.pair_error(2), judged.pooled_error(), judged.row_error()];
    let published = published.map_or(Cell::Empty, Cell::Published);
    let cells = std::iter::once(published).chain(rates.map(Cell::percent)).chain([Cell::Empty]);
    Filled(Row { name: name.to_string(), cells: cells.collect() })
}

fn plane(published: &Simulation, a: &Chosen, rule: Rule) -> Figure {
    let points = |table: &FeatureTable, class: usize| -> Vec<(f64, f64)> {
        let rows = table.rows.iter().zip(&table.classes).filter(|(_, c)| **c == class);
        rows.map(|(row, _)| rule.projection.apply(row)).map(|z| (z[0], z[1])).collect()
    };
    let class = |(class, name): (usize, &String)| PlaneClass {
        name: name.clone(),
        training: points(&a.training, class),
        held_out: points(&a.validation, class),
    };
    let classes = a.training.names.iter().enumerate().map(class).collect();
    let title = format!("Table {}: principal components of the a-parameters by iv4, first draw", published.number);
    Figure::Plane(Box::new(Plane { title, classes, rule }))
}

/// Selected features of both sets.
pub(in crate::tables) struct Chosen {
    pub(in crate::tables) names: Vec<String>,
    pub(in crate::tables) training: FeatureTable,
    pub(in crate::tables) validation: FeatureTable,
}

impl Chosen {
    /// The first two features, as the source takes without PCA (§3.3).
    pub(in crate::tables) fn first_two(&self) -> Self {
        let select = |table: &FeatureTable| table.select(&[0, 1]);
        Self { names: self.names[..2].to_vec(), training: select(&self.training), validation: select(&self.validation) }
    }

    /// The source's projection of these features.
    pub(in crate::tables) fn to_two(&self) -> ProjectionKind {
        principal(self.names.len())
    }

    pub(in crate::tables) fn rule(&self, projection: ProjectionKind, kind: Kind) -> Result<Rule, Error> {
        Rule::train(&self.training, &self.names, projection, kind)
    }

    /// Decisions on the training and on the validation set.
    pub(in crate::tables) fn judge(&self, rule: &Rule) -> [Judged; 2] {
        [rule.judge(&self.training), rule.judge(&self.validation)]
    }
}
