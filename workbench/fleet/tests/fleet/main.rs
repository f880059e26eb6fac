//! Parts, sums and models of small simulated fleets.

mod simulated;

use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector};
use rand::seq::SliceRandom;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use bearing_watch_fleet::*;
use model::train::{Alarms, Recipe};
use simulated::Fleet;

const FEATURES: [&str; 6] = ["a1", "a2", "b1", "c1", "c2", "log_variance"];

/// A fleet of 40 drives with 6 segments in 2 runs, and its rows. Every tenth segment lacks a feature, and all of the
/// last drive.
fn fleet() -> (Plan, Vec<Row>) {
    let fleet = Fleet::new(6, 2, 5).expect("the rig");
    let mut rows: Vec<Row> = (0..40).flat_map(|drive| fleet.drive(drive)).collect();
    let all = rows.len();
    rows.iter_mut().step_by(10).for_each(|row| row.values[5] = f64::NAN);
    rows[all - 6..].iter_mut().for_each(|row| row.values[5] = f64::NAN);
    (fleet.plan, rows)
}

fn write(path: PathBuf, plan: &Plan, rows: &[Row]) -> Part {
    let file = std::fs::File::create(&path).expect("a file");
    let mut writer = Writer::new(file, &path, plan, &[]).expect("a part");
    rows.iter().for_each(|row| writer.add(row.clone()).expect("a row"));
    writer.finish().expect("complete");
    Part::open(&path).expect("a part")
}

fn wanted() -> Wanted {
    Wanted { features: FEATURES.map(String::from).into(), ..Wanted::default() }
}

fn sums(parts: &[Part]) -> Sums {
    fold(parts, &wanted(), &|_| ()).expect("sums")
}

fn fit(sums: &Sums) -> Fit {
    let classes = classes(sums, &[]).expect("classes");
    let alarms = Alarms { healthy: Some(0), by_run: true, ..Alarms::default() };
    let features = vec!["a".into(), "log_variance".into()];
    let recipe = Recipe { features, alarms, ..sums.plan.recipe() };
    Fit::new(sums, &classes, &recipe, Independent::Runs).expect("a fit")
}

/// The bytes of the model of parts.
fn model(parts: &[Part]) -> Vec<u8> {
    let fit = fit(&sums(parts));
    let distances = tails(parts, &fit, &wanted(), &|_| ()).expect("distances");
    fit.train(distances.as_ref()).expect("a model").0.to_bytes("").expect("bytes")
}

#[test]
fn parts_of_any_split_give_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let (plan, rows) = fleet();
    let at = |name: &str| folder.path().join(name);
    let whole = write(at("whole.parquet"), &plan, &rows);
    assert!(whole.sorted);
    let expected = model(std::slice::from_ref(&whole));
    let mut random = ChaCha8Rng::seed_from_u64(9);
    for round in 0..4 {
        // Each row into any of five parts, in any order: drives are in several parts.
        let mut mixed = rows.clone();
        mixed.shuffle(&mut random);
        let mut pieces: Vec<Vec<Row>> = vec![vec![]; 5];
        mixed.into_iter().for_each(|row| pieces[random.random_range(0..5)].push(row));
        let named = pieces.iter().enumerate();
        let parts: Vec<Part> = named.map(|(k, rows)| write(at(&format!("{round}_{k}.parquet")), &plan, rows)).collect();
        assert!(model(&parts) == expected, "round {round}");
    }
    // Ascending parts that share drives: rows of a drive are joined, in one pass and in constant memory.
    let of_month = |month: u32| rows.iter().filter(|row| row.segment % 2 == month).cloned().collect::<Vec<Row>>();
    let months = [0, 1].map(|month| write(at(&format!("month{month}.parquet")), &plan, &of_month(month)));
    assert!(months.iter().all(|part| part.sorted) && model(&months) == expected);
    // Parts that follow each other, given the other way round.
    let halves = [(1, &rows[120..]), (0, &rows[..120])];
    let halves = halves.map(|(k, rows)| write(at(&format!("half{k}.parquet")), &plan, rows));
    assert!(model(&halves) == expected);
}

/// Mean and scatter in two passes.
fn two_passes(rows: &[DVector<f64>]) -> (DVector<f64>, DMatrix<f64>) {
    let mean = rows.iter().sum::<DVector<f64>>() / rows.len() as f64;
    (mean.clone(), rows.iter().map(|row| (row - &mean) * (row - &mean).transpose()).sum())
}

#[test]
fn sums_have_the_moments_of_two_passes() {
    let folder = tempfile::tempdir().expect("a folder");
    let (plan, rows) = fleet();
    let found = sums(&[write(folder.path().join("a.parquet"), &plan, &rows)]);
    assert_eq!(found.rows, 240);
    let own: Vec<&Row> = rows.iter().filter(|row| row.texts[1] == "healthy").collect();
    let values = |keep: &dyn Fn(&Row) -> bool| -> Vec<DVector<f64>> {
        own.iter().filter(|row| keep(row)).map(|row| DVector::from_column_slice(&row.values)).collect()
    };
    let complete = |row: &Row| !row.values[5].is_nan();
    let class = found.of_class("healthy").expect("a class");
    let patterns = class.patterns(&[0, 1, 2, 3, 4, 5]);
    assert_eq!((patterns.len(), patterns[0].mask, patterns[1].mask), (2, 31, 63));
    let near = |found: &DMatrix<f64>, expected: &DMatrix<f64>| {
        let scale = expected.diagonal().map(f64::sqrt);
        let relative = |i, j, x: f64| x / (scale[i] * scale[j]);
        // Means are up to 100 deviations from zero, of which two passes lose the square's digits.
        (found - expected).map_with_location(relative).amax() < 1e-10
    };
    let (mean, scatter) = two_passes(&values(&complete));
    assert!((&patterns[1].rows.mean - mean).amax() < 1e-12 && near(&patterns[1].rows.scatter, &scatter));
    let some = values(&|row| !complete(row)).iter().map(|row| row.rows(0, 5).into_owned()).collect::<Vec<_>>();
    assert!(near(&patterns[0].rows.scatter, &two_passes(&some).1) && patterns[0].rows.count == some.len() as u64);
    for (level, name) in [(&class.runs, "run"), (&class.units, "unit")] {
        let key = |row: &Row| if name == "run" { row.texts[2..].to_vec() } else { vec![row.texts[2].clone()] };
        let mut keys: Vec<Vec<String>> = own.iter().map(|row| key(row)).collect();
        keys.dedup();
        let groups = keys.iter().map(|own| two_passes(&values(&|row| complete(row) && key(row) == *own)));
        let (means, scatters): (Vec<_>, Vec<_>) = groups.unzip();
        assert_eq!((level.count as usize, level.rows), (keys.len(), values(&complete).len() as u64), "{name}");
        assert!(near(&level.within(), &scatters.iter().sum()), "{name}");
        assert!(near(&level.means().scatter, &two_passes(&means).1), "{name}");
    }
}

#[test]
fn a_part_gives_back_the_bits_of_its_features_and_the_detector_of_its_plan() {
    let folder = tempfile::tempdir().expect("a folder");
    let (plan, rows) = fleet();
    let part = write(folder.path().join("a.parquet"), &plan, &rows);
    assert_eq!(part.plan.difference(&plan), None);
    let mut back = vec![];
    let wanted = wanted();
    for group in 0..part.row_groups() {
        for batch in part.read(group, &wanted).expect("rows") {
            let batch = batch.expect("rows");
            batch.stretches().flatten().for_each(|row| back.push(batch.values(row).to_vec()));
        }
    }
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let missing = |row: &&Row| row.values.iter().any(|x| x.is_nan());
    assert_eq!(rows.iter().filter(missing).count(), 30);
    assert!(rows.iter().zip(&back).all(|(row, back)| bits(&row.values) == bits(back)) && rows.len() == back.len());
    let [one, other] = [&plan, &part.plan].map(|plan| format!("{:?}", plan.parts().expect("a detector")));
    assert_eq!(one, other);
}

#[test]
fn what_is_no_part_of_the_same_plan_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let (plan, rows) = fleet();
    let at = |name: &str| folder.path().join(name);
    let mut other = plan.clone();
    other.usual[0] = 1.0;
    let parts = [write(at("one"), &plan, &rows[..6]), write(at("three"), &other, &rows[..6])];
    let different = fold(&parts, &wanted(), &|_| ()).expect_err("two plans").to_string();
    assert!(different.contains("three have different plans: usual [0.0,"), "{different}");
    let text = plan.to_json().replace("\"version\":1", "\"version\":7");
    assert!(Plan::parse(&text).expect_err("a later one").contains("version 7, not 1"));
    assert!(Part::open(Path::new("Cargo.toml")).expect_err("no part").to_string().contains("not readable as Parquet"));
    let empty = write(at("empty"), &plan, &[]);
    assert_eq!(sums(std::slice::from_ref(&empty)).rows, 0);
    assert!(classes(&sums(&[empty]), &[]).expect("no class").is_empty());
}
