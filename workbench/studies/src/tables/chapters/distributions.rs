//! Table 2.2 on the standard rig: distribution of the features in each class, and distance between the classes.

use super::separation;
use crate::demo::FirstInput;
use crate::tables::draw::{Draw, Estimated, Model, choose};
use crate::tables::published::{CHAPTER_4, TABLE_2_2, written_order};
use crate::tables::recorded::Selection;
use crate::tables::result::{Cell, Column, Digits, Figure, Row, Spread, Table};
use model::Error;
use model::identify::{Method, Structure};

const SELECTION: Selection = Selection::CHAPTER_4;
const FIRST_ORDER: Structure = Structure::new(1, 1, 1, 1, 1);

const fn input_name(input: FirstInput) -> &'static str {
    match input {
        FirstInput::Reference => "reference",
        FirstInput::Error => "error",
    }
}

/// The published layout: a and b of a first-order model, by class.
///
/// # Errors
/// Returns an error if a trace cannot be estimated.
pub(in crate::tables) fn first_order(draw: &Draw) -> Result<Table, Error> {
    let mut rows: Vec<Row> = TABLE_2_2.iter().map(published).collect();
    let mut figures = Vec::new();
    for input in [FirstInput::Reference, FirstInput::Error] {
        let model = Model { input, order: FIRST_ORDER, method: Method::Iv4 };
        let estimates = draw.estimates(model)?;
        let picked = SELECTION.pick(&estimates.training, |e| e.class);
        let of_class = |class: usize| picked.iter().filter(|e| e.class == class).copied().collect::<Vec<_>>();
        let input = input_name(input);
        for (class, name) in SELECTION.names().iter().enumerate() {
            rows.push(Row { name: format!("{input}: {name}"), cells: cells(&of_class(class)) });
        }
        for (k, feature) in ["a1", "b1"].into_iter().enumerate() {
            let of = |class| of_class(class).iter().map(|e| e.features[k]).collect();
            figures.push(Figure::Spread(Spread {
                title: format!("u1 = velocity {input}: {feature} of [1 1 1 1 1], training traces of the first draw"),
                feature: feature.to_string(),
                classes: SELECTION.names().into_iter().enumerate().map(|(k, name)| (name, of(k))).collect(),
            }));
        }
    }
    let columns = [
        ("a", Digits::Deviation(5)),
        ("σa²", Digits::Power(1)),
        ("σa² stated", Digits::Power(1)),
        ("b", Digits::Deviation(5)),
        ("σb²", Digits::Power(1)),
        ("σb² stated", Digits::Power(1)),
        ("fit, %", Digits::Fixed(2)),
    ];
    Ok(Table {
        id: "2.2",
        title: "Table 2.2: distribution of a first-order model's parameters by class".to_string(),
        conditions: "Published: motor module in open loop, one record each. Below: standard rig, y = current, order [1 1 1 1 1] \
                     by iv4, u2 = load torque, 20 training traces a class; σ² over the traces, and as each estimate states it."
            .to_string(),
        columns: columns.map(|(name, digits)| Column::new(name, digits)).to_vec(),
        rows,
        words: vec![],
        figures,
    })
}

fn published(brake: &crate::tables::published::Brake) -> Row {
    let cells = vec![
        Cell::Published(brake.a),
        Cell::Empty,
        Cell::Published(brake.a_variance),
        Cell::Published(brake.b),
        Cell::Empty,
        Cell::Published(brake.b_variance),
        Cell::Published(brake.fit_percent),
    ];
    Row { name: format!("published: {}", brake.name), cells }
}

fn cells(traces: &[&Estimated]) -> Vec<Cell> {
    let n = traces.len() as f64;
    let mean = |of: &dyn Fn(&Estimated) -> f64| traces.iter().map(|e| of(e)).sum::<f64>() / n;
    let parameter = |k: usize| {
        let centre = mean(&|e| e.features[k]);
        let variance = mean(&|e| (e.features[k] - centre).powi(2)) * n / (n - 1.0);
        [centre, variance, mean(&|e| e.deviations[k].powi(2))]
    };
    let fit = mean(&|e| e.fit_percent);
    [&parameter(0)[..], &parameter(1), &[fit]].concat().into_iter().map(Cell::one).collect()
}

/// Shift of each feature of the models of chapter 4 with each defect, and of all features together.
///
/// # Errors
/// Returns an error if a trace cannot be estimated.
pub(in crate::tables) fn separations(draw: &Draw) -> Result<Table, Error> {
    let mut rows = Vec::new();
    for simulation in &CHAPTER_4 {
        for method in [Method::Iv4, Method::Ls] {
            let model = Model { input: simulation.input, order: simulation.order, method };
            let estimates = draw.estimates(model)?;
            let name = if method == Method::Ls { "LS" } else { "iv4" };
            let head = format!("{} {}, {name}:", input_name(model.input), written_order(model.order));
            let (names, places) = choose(model, &["a"])?;
            if method == Method::Iv4 {
                let [training, _] = estimates.tables(SELECTION, &places);
                for (k, feature) in names.iter().enumerate() {
                    let cells = [1, 2].map(|defect| Cell::one(separation::of_feature(&training, k, defect)));
                    rows.push(Row { name: format!("{head} {feature}"), cells: cells.to_vec() });
                }
            }
            for (group, asked) in [("all a", &["a"][..]), ("all a b c", &[])] {
                let (_, places) = choose(model, asked)?;
                let [training, validation] = estimates.tables(SELECTION, &places);
                let cell = |defect| {
                    let found = separation::of_combination(&training, &validation, defect);
                    Cell::Measured(found.into_iter().collect())
                };
                rows.push(Row { name: format!("{head} {group}"), cells: [1, 2].map(cell).to_vec() });
            }
        }
    }
    let columns = ["spall from healthy, sd", "roughness from healthy, sd"];
    Ok(Table {
        id: "2.2",
        title: "Distance of the classes along the features of Tables 4.1–4.4".to_string(),
        conditions: "Difference of class means over the spread of one class. Single features: training traces. All \
                     together: the best combination of the training traces, measured on the validation traces."
            .to_string(),
        columns: columns.map(|name| Column::new(name, Digits::Fixed(2))).to_vec(),
        rows,
        words: vec![],
        figures: vec![],
    })
}
