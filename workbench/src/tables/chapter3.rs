//! Tables 3.1 and 3.2: the example of chapter 3, healthy against Defect A, and the order search behind it.

use bearing_watch::decide::Kind;
use nalgebra::SymmetricEigen;

use super::draw::{Draw, Model, Recorded, Selection, choose};
use super::published::{ERROR_WITH_PCA, ERROR_WITHOUT_PCA, ORDER_WITH_PCA, ORDER_WITHOUT_PCA, TABLE_3_1};
use super::result::{Cell, Column, Digits, Figure, Row, Spread, Table};
use super::{ours, separation, words};
use crate::Error;
use crate::demo::FirstInput;
use crate::identify::{Method, Order};
use crate::literal::{Rule, principal};
use crate::structure::{Candidate, Estimator, Grid, Search, search};
use crate::train::{ClassStatistics, FeatureTable, ProjectionKind};

const SELECTION: Selection = Selection::CHAPTER_3;
const INPUT: FirstInput = FirstInput::Error;
const CONDITIONS: &str =
    "y = current, u1 = velocity error, u2 = load torque; 25 + 25 traces of healthy and spall (Defect A).";

const fn model(order: Order, method: Method) -> Model {
    Model { input: INPUT, order, method }
}

/// Table 3.1 of one repetition.
///
/// # Errors
/// Where a trace cannot be estimated.
pub(super) fn components(draw: &Draw) -> Result<Table, Error> {
    let model = model(ORDER_WITH_PCA, Method::Iv4);
    let (names, places) = choose(model, &["a"])?;
    let [training, _] = draw.estimates(model)?.tables(SELECTION, &places);
    let rule = Rule::train(
        &training,
        &names,
        ProjectionKind::Pca { keep: crate::train::Keep::Components(3), standardised: false },
        Kind::Linear,
    )?;
    let mut values: Vec<f64> =
        SymmetricEigen::new(ClassStatistics::new(&training).total).eigenvalues.iter().copied().collect();
    values.sort_by(|x, y| y.total_cmp(x));
    let total: f64 = values.iter().sum();
    let z = training.map(&rule.projection);
    let rows = TABLE_3_1.iter().zip(&values).enumerate().map(|(k, ((published, contribution), value))| Row {
        name: format!("e{}", k + 1),
        cells: vec![
            Cell::Published(*published),
            Cell::Published(*contribution),
            Cell::one(*value),
            Cell::one(100.0 * value / total),
            Cell::one(separation::of_feature(&z, k, 1).abs()),
        ],
    });
    let column = |(name, digits): (&str, Digits)| Column::new(name, digits);
    let columns = [
        ("published eigenvalue", Digits::Power(2)),
        ("published contribution, %", Digits::Fixed(2)),
        ("eigenvalue", Digits::Power(2)),
        ("contribution, %", Digits::Fixed(3)),
        ("spall from healthy, sd", Digits::Fixed(2)),
    ];
    Ok(Table {
        id: "3.1",
        title: format!("Table 3.1: principal components of a1, a2, a3; order {}, iv4", words::order(ORDER_WITH_PCA)),
        conditions: CONDITIONS.to_string(),
        columns: columns.into_iter().map(column).collect(),
        rows: rows.collect(),
        words: vec![],
        figures: spreads("principal component", &["z1", "z2", "z3"].map(String::from), &z),
    })
}

fn spreads(what: &str, names: &[String], table: &FeatureTable) -> Vec<Figure> {
    let of = |k: usize, class: usize| {
        table.rows.iter().zip(&table.classes).filter(move |(_, c)| **c == class).map(move |(row, _)| row[k]).collect()
    };
    let classes = |k| table.names.iter().enumerate().map(|(class, name)| (name.clone(), of(k, class))).collect();
    let one = |(k, name): (usize, &String)| {
        Figure::Spread(Spread {
            title: format!("Distribution of {what} {name}, training traces of the first draw"),
            feature: name.clone(),
            classes: classes(k),
        })
    };
    names.iter().enumerate().map(one).collect()
}

/// Table 3.2 of one repetition.
///
/// # Errors
/// Where a trace cannot be estimated or features are singular.
pub(super) fn misclassified(draw: &Draw) -> Result<Table, Error> {
    let two = |order| format!("{}, a1 a2", words::order(order));
    let none = ProjectionKind::None;
    let (low, high) = (ORDER_WITHOUT_PCA, ORDER_WITH_PCA);
    let pair: &[&str] = &["a1", "a2"];
    let cases: [(String, Option<f64>, Model, &[&str], ProjectionKind, Kind); 8] = [
        (two(low), Some(ERROR_WITHOUT_PCA), model(low, Method::Iv4), pair, none, Kind::Linear),
        (
            format!("{}, z1 z2", words::order(high)),
            Some(ERROR_WITH_PCA),
            model(high, Method::Iv4),
            &["a"],
            principal(3),
            Kind::Linear,
        ),
        (format!("{}, quadratic", two(low)), None, model(low, Method::Iv4), pair, none, Kind::Quadratic),
        (
            format!("{}, z1 z2, quadratic", words::order(high)),
            None,
            model(high, Method::Iv4),
            &["a"],
            principal(3),
            Kind::Quadratic,
        ),
        (two(high), None, model(high, Method::Iv4), pair, none, Kind::Linear),
        (format!("{}, a1 a2 a3", words::order(high)), None, model(high, Method::Iv4), &["a"], none, Kind::Linear),
        (
            format!("{}, z1 z2 by LS", words::order(high)),
            None,
            model(high, Method::Ls),
            &["a"],
            principal(3),
            Kind::Linear,
        ),
        (format!("{}, a b c by LS", words::order(low)), None, model(low, Method::Ls), &[], none, Kind::Linear),
    ];
    let mut rows = Vec::new();
    for (name, published, model, asked, projection, kind) in cases {
        let (names, places) = choose(model, asked)?;
        let estimates = draw.estimates(model)?;
        let [training, validation] = estimates.tables(SELECTION, &places);
        let rule = Rule::train(&training, &names, projection, kind)?;
        let error = |table| Cell::percent(rule.judge(table).all_error());
        let published = published.map_or(Cell::Empty, Cell::Published);
        let cells = vec![published, error(&training), error(&validation), Cell::one(estimates.healthy_fit(SELECTION))];
        rows.push(Row { name, cells });
    }
    let ours = draw.ours(SELECTION)?;
    let cells = vec![Cell::Empty, Cell::Empty, Cell::percent(ours.all_error()), Cell::Empty];
    rows.push(Row { name: ours::NAME.to_string(), cells });
    let columns = ["published", "training", "validation", "healthy fit"];
    Ok(Table {
        id: "3.2",
        title: "Table 3.2: healthy against spall, misclassified, %; iv4 and LDA where not said otherwise".to_string(),
        conditions: CONDITIONS.to_string(),
        columns: columns.map(|name| Column::new(name, Digits::Fixed(1))).to_vec(),
        rows,
        words: vec![],
        figures: vec![],
    })
}

/// The order search of one repetition: estimated on the first healthy training trace by iv4, scored by simulation of
/// the first healthy validation trace, as the source's program does.
///
/// # Errors
/// Where the search fails.
pub(super) fn orders(draw: &Draw) -> Result<Table, Error> {
    let max = Order::new(3, 6, 3, 2, 2);
    let structures = Grid::up_to(max, false).structures()?;
    let first = |set: &[Recorded]| set.iter().take(1).map(|r| r.labelled(INPUT).trace).collect::<Vec<_>>();
    let found = search(&first(&draw.training), &first(&draw.validation), &structures, Estimator::Iv4)?;
    let of_order = |order: Order| found.candidates.iter().find(|c| c.fitted.structure.order == order);
    let best = |na: u8| {
        let of = found.candidates.iter().filter(|c| c.fitted.structure.order.na == na);
        of.max_by(|x, y| x.fit_percent.total_cmp(&y.fit_percent))
    };
    let named = [
        (format!("{}, the source's second order", words::order(ORDER_WITHOUT_PCA)), of_order(ORDER_WITHOUT_PCA)),
        (format!("{}, its third order", words::order(ORDER_WITH_PCA)), of_order(ORDER_WITH_PCA)),
        ("best fit with na = 1".to_string(), best(1)),
        ("best fit with na = 2".to_string(), best(2)),
        ("best fit with na = 3".to_string(), best(3)),
        ("least AIC".to_string(), found.best_aic()),
        ("least MDL".to_string(), found.best_mdl()),
    ];
    let rows = named.into_iter().map(|(name, candidate)| row(&found, name, candidate)).collect();
    let columns = [("fit, %", 2), ("place by fit", 0), ("parameters", 1)];
    Ok(Table {
        id: "3.2",
        title: "Order search behind Table 3.2".to_string(),
        conditions: format!(
            "{} structures up to {} by iv4 on one healthy trace, free-run fit on another; y, u1, u2 as above.",
            structures.len(),
            words::order(max)
        ),
        columns: columns.map(|(name, places)| Column::new(name, Digits::Fixed(places))).to_vec(),
        rows,
        words: vec![],
        figures: vec![],
    })
}

fn row(found: &Search, name: String, candidate: Option<&Candidate>) -> Row {
    let cells = match candidate {
        Some(c) => vec![
            Cell::one(c.fit_percent),
            Cell::one(found.rank(c.fit_percent) as f64),
            Cell::one(c.fitted.parameters() as f64),
        ],
        // The same cells in every repetition, so that they can be gathered.
        None => vec![Cell::Measured(vec![]); 3],
    };
    Row { name, cells }
}
