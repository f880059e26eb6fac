//! Comparison of piece-wise estimation (§6.2.1) with one model of the whole record.

use bearing_watch::plan::Kind;
use nalgebra::DVector;
use rayon::prelude::*;

use crate::demo::FirstInput;
use crate::literal::{Judged, Rule};
use crate::tables::draw::{Draw, Model, choose};
use crate::tables::ours;
use crate::tables::recorded::{Recorded, Selection};
use crate::tables::result::{Cell, Column, Digits, Row, Table};
use model::Error;
use model::identify::{Method, iv4};
use model::piecewise::{Cutting, Pieces, STRUCTURE, estimate};
use model::trace::Trace;
use model::train::{ClassStatistics, FeatureTable, ProjectionKind};

const SELECTION: Selection = Selection::CHAPTER_4;
const INPUT: FirstInput = FirstInput::Reference;

/// Headings of the columns, in order.
const COLUMNS: [(&str, Digits); 7] = [
    ("runs a trace", Digits::Fixed(1)),
    ("traces without", Digits::Fixed(1)),
    ("sd of b1", Digits::Power(1)),
    ("three classes", Digits::Fixed(1)),
    ("healthy / spall", Digits::Fixed(1)),
    ("healthy / roughness", Digits::Fixed(1)),
    ("both pooled", Digits::Fixed(1)),
];

/// Computes the table of one repetition.
///
/// # Errors
/// Returns an error if a class has too few traces with runs, or if features are singular.
pub(in crate::tables) fn measure(draw: &Draw) -> Result<Table, Error> {
    let cutting = |threshold, min_samples, cutoff_ratio| Cutting { threshold, min_samples, cutoff_ratio };
    let mut rows = Vec::new();
    let source = Cut::new(draw, Cutting::default());
    rows.push(source.row("as the source: 0.8, ≥ 200, iv4, each run a1 b1", &source.by_run(&literal_runs)?));
    rows.push(source.row("the same cut, LS, each run a1 b1", &source.by_run(&|_, p| p.theta.clone())?));
    rows.push(source.row("the same cut, LS, medians a1 b1", &source.by_median(2)?));
    for (threshold, least) in [(0.8, 200), (0.5, 150), (0.3, 150)] {
        let cut = Cut::new(draw, cutting(threshold, least, 3.0));
        let name = format!("{threshold}, ≥ {least}, copy to 3 f0, LS, medians");
        rows.push(cut.row(&format!("{name} a1 b1"), &cut.by_median(2)?));
        if threshold < 0.4 {
            rows.push(cut.row(&format!("{name} a1 b1 c1"), &cut.by_median(3)?));
        }
    }
    for (name, method, asked) in [
        ("whole record, iv4, a1 b1", Method::Iv4, &["a", "b"][..]),
        ("whole record, LS, a1 b1", Method::Ls, &["a", "b"]),
        ("whole record, LS, a1 b1 c1", Method::Ls, &[]),
    ] {
        let model = Model { input: INPUT, order: STRUCTURE, method };
        let (names, places) = choose(model, asked)?;
        let [training, validation] = draw.estimates(model)?.tables(SELECTION, &places);
        let rule = Rule::train(&training, &names, ProjectionKind::None, Kind::Linear)?;
        let cutting = [Cell::Empty, Cell::Empty, Cell::one(spread(&training))];
        rows.push(row(name, cutting, &rule.judge(&validation)));
    }
    rows.push(row(ours::NAME, [const { Cell::Empty }; 3], &draw.ours(SELECTION)?));
    Ok(Table {
        id: "piecewise",
        title: "Piece-wise estimation (§6.2.1) against whole records: misclassified, %".to_string(),
        conditions: "u1 = velocity reference, y = current, u2 = load torque, order [1 1 1 1 1], linear discriminant; \
                     20 + 20 traces of each class; slope threshold and samples of the shortest run as named. The \
                     source prints a scatter plot (Fig. 6.1) and no rates. sd of b1: over the healthy training rows."
            .to_string(),
        columns: COLUMNS.map(|(name, digits)| Column::new(name, digits)).to_vec(),
        rows,
        words: vec![],
        figures: vec![],
    })
}

/// All traces of a draw, cut with the same settings.
struct Cut {
    training: Vec<Piece>,
    validation: Vec<Piece>,
}

/// A trace with its runs, if it has any.
struct Piece {
    class: usize,
    trace: Trace,
    pieces: Option<Pieces>,
}

/// Decisions on a validation set, and the standard deviation of b₁ over the healthy training rows.
struct Found {
    judged: Judged,
    spread: f64,
}

/// Function that returns the parameters of every run of a trace.
type Runs<'a> = &'a (dyn Fn(&Trace, &Pieces) -> Vec<[f64; 3]> + Sync);

impl Cut {
    fn new(draw: &Draw, cutting: Cutting) -> Self {
        let set = |set: &[Recorded]| {
            let each = |recorded: &&Recorded| {
                let labelled = recorded.labelled(INPUT);
                let pieces = estimate(&labelled.trace, &cutting).ok();
                Piece { class: labelled.class, trace: labelled.trace, pieces }
            };
            SELECTION.pick(set, |r| r.class).par_iter().map(each).collect()
        };
        Self { training: set(&draw.training), validation: set(&draw.validation) }
    }

    /// One row per trace: medians over its runs. A validation trace without runs is undetermined.
    fn by_median(&self, count: usize) -> Result<Found, Error> {
        let (rule, spread) = train(&self.training, count, |p| p.pieces.iter().map(|p| p.median).collect())?;
        let mut judged = Judged::new(&SELECTION.names());
        for piece in &self.validation {
            match &piece.pieces {
                Some(pieces) => add(&mut judged, rule.judge(&table([(piece.class, pieces.median)], count))),
                None => judged.add(piece.class, None, |_| None),
            }
        }
        Ok(Found { judged, spread })
    }

    /// One row per run, as in the source: the decisions on runs are counted.
    fn by_run(&self, runs: Runs<'_>) -> Result<Found, Error> {
        let of = |piece: &Piece| piece.pieces.as_ref().map_or_else(Vec::new, |p| runs(&piece.trace, p));
        let (rule, spread) = train(&self.training, 2, of)?;
        let held_out: Vec<_> = self.validation.par_iter().map(|piece| (piece.class, of(piece))).collect();
        let rows = held_out.into_iter().flat_map(|(class, runs)| runs.into_iter().map(move |theta| (class, theta)));
        Ok(Found { judged: rule.judge(&table(rows, 2)), spread })
    }

    fn row(&self, name: &str, found: &Found) -> Row {
        let count = self.validation.len() as f64;
        let runs: usize = self.validation.iter().filter_map(|p| p.pieces.as_ref()).map(|p| p.runs.len()).sum();
        let without = self.validation.iter().filter(|p| p.pieces.is_none()).count();
        let cutting = [Cell::one(runs as f64 / count), Cell::percent(without as f64 / count), Cell::one(found.spread)];
        row(name, cutting, &found.judged)
    }
}

/// iv4 on the signals of each run; runs without a solution are skipped.
fn literal_runs(trace: &Trace, pieces: &Pieces) -> Vec<[f64; 3]> {
    let of = |run: &std::ops::Range<usize>| {
        let cut = |x: &[f64]| x[run.clone()].to_vec();
        let signals = [&trace.y, &trace.u1, &trace.u2].map(|x| cut(x));
        let theta = iv4(&trace.with_signals(signals), STRUCTURE).ok()?.theta;
        Some([theta[0], theta[1], theta[2]])
    };
    pieces.runs.iter().filter_map(of).collect()
}

fn train(set: &[Piece], count: usize, rows: impl Fn(&Piece) -> Vec<[f64; 3]> + Sync) -> Result<(Rule, f64), Error> {
    let all: Vec<_> = set.par_iter().map(|piece| (piece.class, rows(piece))).collect();
    let table = table(all.into_iter().flat_map(|(class, rows)| rows.into_iter().map(move |row| (class, row))), count);
    for (class, name) in table.names.iter().enumerate() {
        let found = table.classes.iter().filter(|label| **label == class).count();
        if found <= count {
            let problem =
                format!("piecewise: class {name} has {found} training traces with straight runs; try another --seed");
            return Err(Error::Training(problem));
        }
    }
    let names = ["a1", "b1", "c1"].map(String::from);
    let rule = Rule::train(&table, &names[..count], ProjectionKind::None, Kind::Linear)?;
    Ok((rule, spread(&table)))
}

/// Standard deviation of the second feature, b₁, over the healthy rows.
fn spread(table: &FeatureTable) -> f64 {
    ClassStatistics::new(table).covariances[0][(1, 1)].sqrt()
}

fn table(rows: impl IntoIterator<Item = (usize, [f64; 3])>, count: usize) -> FeatureTable {
    let (classes, rows) =
        rows.into_iter().map(|(class, theta)| (class, DVector::from_column_slice(&theta[..count]))).unzip();
    FeatureTable::exact(rows, classes, SELECTION.names())
}

fn row(name: &str, cutting: [Cell; 3], judged: &Judged) -> Row {
    let rates = [judged.all_error(), judged.pair_error(1), judged.pair_error(2), judged.pooled_error()];
    Row { name: name.to_string(), cells: cutting.into_iter().chain(rates.map(Cell::percent)).collect() }
}

/// Adds the counts of `more` to `sum`.
fn add(sum: &mut Judged, more: Judged) {
    let pairs = sum.pairs.iter_mut().zip(more.pairs);
    for (to, from) in pairs.chain([(&mut sum.all_classes, more.all_classes)]) {
        for (to, from) in to.counts.iter_mut().flatten().zip(from.counts.into_iter().flatten()) {
            *to += from;
        }
    }
    sum.rows_wrong += more.rows_wrong;
}
