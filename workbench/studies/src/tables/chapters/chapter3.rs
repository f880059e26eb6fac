//! Tables 3.1 and 3.2: the example of chapter 3 (healthy against Defect A), and its order search.

use bearing_watch::plan::Kind;
use nalgebra::SymmetricEigen;

use super::separation;
use crate::demo::FirstInput;
use crate::literal::{Rule, principal};
use crate::tables::draw::{Draw, Model, choose};
use crate::tables::ours;
use crate::tables::published::{
    ERROR_WITH_PCA, ERROR_WITHOUT_PCA, ORDER_WITH_PCA, ORDER_WITHOUT_PCA, TABLE_3_1, written_order,
};
use crate::tables::recorded::{Recorded, Selection};
use crate::tables::result::{Cell, Column, Digits, Figure, Row, Spread, Table};
use model::Error;
use model::identify::{Method, Structure};
use model::structure::{Candidate, Estimator, Grid, Search, search};
use model::train::{ClassStatistics, FeatureTable, ProjectionKind};

const SELECTION: Selection = Selection::CHAPTER_3;
const INPUT: FirstInput = FirstInput::Error;
const CONDITIONS: &str =
    "y = current, u1 = velocity error, u2 = load torque; 25 + 25 traces of healthy and spall (Defect A).";

const fn model(order: Structure, method: Method) -> Model {
    Model { input: INPUT, order, method }
}

/// Headings of the columns of Table 3.1.
const COMPONENT_COLUMNS: [(&str, Digits); 6] = [
    ("published eigenvalue", Digits::Power(2)),
    ("published contribution, %", Digits::Fixed(2)),
    ("eigenvalue", Digits::Power(2)),
    ("contribution, %", Digits::Fixed(3)),
    ("spall from healthy, sd", Digits::Fixed(2)),
    ("traces used, %", Digits::Fixed(1)),
];

/// Smallest fit that the source accepts (§3.3), %.
pub(in crate::tables) const LEAST_FIT: f64 = 85.0;

/// Computes Table 3.1 of one repetition.
///
/// # Errors
/// Returns an error if a trace cannot be estimated.
pub(in crate::tables) fn components(draw: &Draw) -> Result<Table, Error> {
    let mut rows = Vec::new();
    let mut figures = Vec::new();
    for (suffix, method, least_fit) in [
        ("", Method::Iv4, f64::NEG_INFINITY),
        (", traces that fit", Method::Iv4, LEAST_FIT),
        (", LS", Method::Ls, f64::NEG_INFINITY),
    ] {
        let model = model(ORDER_WITH_PCA, method);
        let (_, places) = choose(model, &["a"])?;
        let estimates = draw.estimates(model)?;
        let picked = SELECTION.pick(&estimates.training, |e| e.class);
        let fitting = picked.iter().filter(|e| e.fit_percent >= least_fit);
        let (rows_used, classes) = fitting.map(|e| (e.features.clone(), e.class)).unzip();
        let table = FeatureTable::exact(rows_used, classes, SELECTION.names()).select(&places);
        let used = 100.0 * table.rows.len() as f64 / picked.len() as f64;
        let found = principal_components(&table);
        for (k, (published, contribution)) in TABLE_3_1.iter().enumerate() {
            let source = |value: f64| if suffix.is_empty() { Cell::Published(value) } else { Cell::Empty };
            let [value, part, apart] = found.as_ref().map_or([const { Cell::Measured(vec![]) }; 3], |f| f.cells(k));
            let cells = vec![source(*published), source(*contribution), value, part, apart, Cell::one(used)];
            rows.push(Row { name: format!("e{}{suffix}", k + 1), cells });
        }
        if let (true, Some(found)) = (suffix.is_empty(), found) {
            figures = spreads("principal component", &["z1", "z2", "z3"].map(String::from), &found.coordinates);
        }
    }
    Ok(Table {
        id: "3.1",
        title: format!("Table 3.1: principal components of a1, a2, a3; order {}, iv4", written_order(ORDER_WITH_PCA)),
        conditions: CONDITIONS.to_string(),
        columns: COMPONENT_COLUMNS.map(|(name, digits)| Column::new(name, digits)).to_vec(),
        rows,
        words: vec![],
        figures,
    })
}

/// Eigenvalues of the covariance of all rows, in descending order, and the rows projected on the eigenvectors.
struct Components {
    values: Vec<f64>,
    coordinates: FeatureTable,
}

/// `None` if a class has at most two rows.
fn principal_components(table: &FeatureTable) -> Option<Components> {
    let enough = (0..table.names.len()).all(|class| table.classes.iter().filter(|c| **c == class).count() > 2);
    let total = enough.then(|| ClassStatistics::new(table).total)?;
    let eigen = SymmetricEigen::new(total);
    let mut places: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    places.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let vectors = eigen.eigenvectors.select_columns(&places).transpose();
    let rows = table.rows.iter().map(|row| &vectors * row).collect();
    let values = places.iter().map(|&k| eigen.eigenvalues[k]).collect();
    Some(Components { values, coordinates: FeatureTable::exact(rows, table.classes.clone(), table.names.clone()) })
}

impl Components {
    /// Eigenvalue, contribution and class separation of one component.
    fn cells(&self, k: usize) -> [Cell; 3] {
        let total: f64 = self.values.iter().sum();
        let apart = separation::of_feature(&self.coordinates, k, 1).abs();
        [self.values[k], 100.0 * self.values[k] / total, apart].map(Cell::one)
    }
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

/// A row of Table 3.2.
struct Case {
    name: String,
    published: Option<f64>,
    model: Model,
    features: &'static [&'static str],
    projection: ProjectionKind,
    kind: Kind,
}

impl Case {
    /// Features without projection.
    fn plain(name: &str, order: Structure, method: Method, features: &'static [&'static str]) -> Self {
        let name = format!("{}, {name}", written_order(order));
        let projection = ProjectionKind::None;
        Self { name, published: None, model: model(order, method), features, projection, kind: Kind::Linear }
    }

    /// Two principal components of the a-parameters.
    fn projected(name: &str, order: Structure, method: Method) -> Self {
        Self { projection: principal(order.na.into()), ..Self::plain(name, order, method, &["a"]) }
    }

    fn published(self, rate: f64) -> Self {
        Self { published: Some(rate), ..self }
    }

    fn quadratic(self) -> Self {
        Self { kind: Kind::Quadratic, ..self }
    }

    fn row(self, draw: &Draw) -> Result<Row, Error> {
        let (names, places) = choose(self.model, self.features)?;
        let estimates = draw.estimates(self.model)?;
        let [training, validation] = estimates.tables(SELECTION, &places);
        let rule = Rule::train(&training, &names, self.projection, self.kind)?;
        let error = |table| Cell::percent(rule.judge(table).all_error());
        let published = self.published.map_or(Cell::Empty, Cell::Published);
        let fit = Cell::one(estimates.healthy_fit(SELECTION));
        Ok(Row { name: self.name, cells: vec![published, error(&training), error(&validation), fit] })
    }
}

/// Computes Table 3.2 of one repetition.
///
/// # Errors
/// Returns an error if a trace cannot be estimated or features are singular.
pub(in crate::tables) fn misclassified(draw: &Draw) -> Result<Table, Error> {
    const TWO: &[&str] = &["a1", "a2"];
    let (low, high) = (ORDER_WITHOUT_PCA, ORDER_WITH_PCA);
    let cases = [
        Case::plain("a1 a2", low, Method::Iv4, TWO).published(ERROR_WITHOUT_PCA),
        Case::projected("z1 z2", high, Method::Iv4).published(ERROR_WITH_PCA),
        Case::plain("a1 a2, quadratic", low, Method::Iv4, TWO).quadratic(),
        Case::projected("z1 z2, quadratic", high, Method::Iv4).quadratic(),
        Case::plain("a1 a2", high, Method::Iv4, TWO),
        Case::plain("a1 a2 a3", high, Method::Iv4, &["a"]),
        Case::projected("z1 z2 by LS", high, Method::Ls),
        Case::plain("a b c by LS", low, Method::Ls, &[]),
    ];
    let mut rows = cases.into_iter().map(|case| case.row(draw)).collect::<Result<Vec<_>, _>>()?;
    let ours = Cell::percent(draw.ours(SELECTION)?.all_error());
    rows.push(Row { name: ours::NAME.to_string(), cells: vec![Cell::Empty, Cell::Empty, ours, Cell::Empty] });
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

/// The order search of one repetition, as in the source's program: models are estimated by iv4 on the first healthy
/// training trace and rated by their simulation of the first healthy validation trace.
///
/// # Errors
/// Returns an error if the search fails.
pub(in crate::tables) fn orders(draw: &Draw) -> Result<Table, Error> {
    let max = Structure::new(3, 6, 3, 2, 2);
    let structures = Grid::up_to(max, false).structures()?;
    let first = |set: &[Recorded]| set.iter().take(1).map(|r| r.labelled(INPUT).trace).collect::<Vec<_>>();
    let found = search(&first(&draw.training), &first(&draw.validation), &structures, Estimator::Iv4)?;
    let of_order = |order: Structure| found.candidates.iter().find(|c| c.fitted.structure == order);
    let best = |na: u8| {
        let of = found.candidates.iter().filter(|c| c.fitted.structure.na == na);
        of.max_by(|x, y| x.fit_percent.total_cmp(&y.fit_percent))
    };
    let named = [
        (format!("{}, the source's second order", written_order(ORDER_WITHOUT_PCA)), of_order(ORDER_WITHOUT_PCA)),
        (format!("{}, its third order", written_order(ORDER_WITH_PCA)), of_order(ORDER_WITH_PCA)),
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
        title: "Structure search behind Table 3.2".to_string(),
        conditions: format!(
            "{} structures up to {} by iv4 on one healthy trace, free-run fit on another; y, u1, u2 as above.",
            structures.len(),
            written_order(max)
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
        // Every repetition has the same cells, so that their values can be collected.
        None => vec![Cell::Measured(vec![]); 3],
    };
    Row { name, cells }
}
