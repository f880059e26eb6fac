use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::identify::Structure;
use crate::train::{Alarms, Folds, Scores, Validation, predict};

/// Two classes. Feature f0 = 3 + 0.05 c + 0.001 c² + e with c = T − 60 and e of deviation 0.2, f1 = −0.1 c + e', f2 is
/// noise; the second class adds `shift` to f0. The covariates are T, uniform in 20 … 100, and a number that explains
/// nothing. One value of f0 in three has an error of variance 0.16 more.
fn candidates(rows: usize, shift: f64, seed: u64) -> Candidates {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut table = FeatureTable::exact(vec![], vec![], vec!["healthy".into(), "spall".into()]);
    let mut covariates = table.clone();
    covariates.usual = DVector::zeros(2);
    for k in 0..rows {
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let [e0, e1, e2, extra, useless] = [draw(), draw(), draw(), draw(), draw()];
        let temperature = rng.random_range(20.0..100.0);
        let (c, class) = (temperature - 60.0, k % 2);
        let variance = if k % 3 == 0 { 0.16 } else { 0.0 };
        let own = 3.0 + 0.05 * c + 0.001 * c * c + 0.2 * e0 + f64::sqrt(variance) * extra + shift * class as f64;
        table.rows.push(DVector::from_vec(vec![own, -0.1 * c + e1, e2]));
        table.variances.push(DVector::from_vec(vec![variance, 0.0, 0.0]));
        table.classes.push(class);
        covariates.rows.push(DVector::from_vec(vec![temperature, useless]));
        covariates.variances.push(DVector::zeros(2));
        covariates.classes.push(class);
    }
    table.usual = DVector::zeros(3);
    let features = ["f0", "f1", "f2"].map(String::from).into();
    Candidates { table, features, groups: (0..rows).collect(), covariates: Some(covariates) }
}

fn recipe() -> Recipe {
    Recipe {
        covariates: ["temperature", "useless"].map(String::from).into(),
        alarms: Alarms { healthy: Some(0), ..Alarms::default() },
        ..Recipe::new(Structure::new(1, 1, 1, 1, 1))
    }
}

fn explained(candidates: &Candidates) -> Explained {
    fit(candidates, &recipe()).expect("regular").expect("covariates")
}

#[test]
fn a_known_law_is_recovered() {
    let own = explained(&candidates(400, 5.0, 3));
    let centre = own.covariates[0].centre;
    // The law about the mean of the healthy temperatures.
    let slope = 0.05 + 2.0 * 0.001 * (centre - 60.0);
    for ((found, truth), error) in [(own.map[0][0][0], slope), (own.map[0][0][1], 0.001), (own.map[1][0][0], -0.1)]
        .into_iter()
        .zip([1e-3, 4e-5, 4e-3])
    {
        assert!((found.value - truth).abs() < 4.0 * found.error, "{found:?} {truth}");
        // 200 rows: 0.2…0.45/(√200 · 23) and for the square /(√200 · 480); the bracket is a factor of two.
        assert!((0.5 * error..2.0 * error).contains(&found.error), "{found:?} {error}");
    }
    let none = Coefficient::default();
    assert_eq!((own.map[1][0][1], own.map[2][0], own.map[0][1]), (none, [none; 2], [none; 2]));
    // f0 has the variance 0.05² · 533 + 0.001² · 227 000 = 1.56 beside 0.04; f1 5.33 beside 1.
    assert!((0.95..0.99).contains(&own.parts[0]) && (0.78..0.9).contains(&own.parts[1]), "{:?}", own.parts);
    assert_eq!((own.parts[2], own.fitted()), (0.0, 2));
    let [low, high] = own.covariates[0].range;
    assert!((20.0..22.0).contains(&low) && (98.0..100.0).contains(&high));
    assert!(own.lines().iter().any(|line| line.starts_with("f2: not explained")), "{:?}", own.lines());
}

#[test]
fn standard_errors_are_those_of_repeated_draws() {
    let (mut spread, mut stated) = (0.0, 0.0);
    const DRAWS: u64 = 200;
    for seed in 0..DRAWS {
        let own = explained(&candidates(120, 0.0, 1000 + seed));
        let Coefficient { value, error } = own.map[0][0][1];
        spread += (value - 0.001).powi(2) / DRAWS as f64;
        stated += error * error / DRAWS as f64;
    }
    let ratio = spread / stated;
    // The variance of 200 draws is known to 10 %; four of these.
    assert!((0.6..1.4).contains(&ratio), "{ratio}");
}

#[test]
fn of_noise_hardly_any_coefficient_is_kept() {
    let kept = |seed: u64| {
        let mut none = candidates(100, 0.0, seed);
        let mut rng = ChaCha8Rng::seed_from_u64(7000 + seed);
        none.table.rows.iter_mut().for_each(|row| *row = DVector::from_fn(3, |_, _| StandardNormal.sample(&mut rng)));
        explained(&none).fitted() > 0
    };
    let count = (0..300).filter(|&seed| kept(seed)).count();
    // Set to at most 1 %, 3 of 300; nine is three standard deviations more.
    assert!(count <= 9, "{count}");
}

#[test]
fn outside_the_range_what_is_explained_is_missing() {
    let mut one = candidates(200, 5.0, 5);
    let own = explained(&one);
    let covariates = one.covariates.as_mut().expect("covariates");
    (covariates.rows[1][0], covariates.rows[3][0], covariates.rows[5][0]) = (109.0, 106.0, 60.0);
    covariates.variances[5][0] = f64::INFINITY;
    let table = own.corrected(&one);
    let missing = |row: usize| table.variances[row].map(|v| !v.is_finite());
    assert_eq!(missing(1).as_slice(), [true, true, false]);
    assert_eq!(missing(3).as_slice(), [false; 3], "within the margin");
    assert_eq!(missing(5).as_slice(), [true, true, false]);
}

#[test]
fn cross_validation_learns_nothing_from_held_out_rows() {
    // Less what the temperature explains, a shift of 1 is 3 to 5 deviations; else less than one.
    let with = candidates(300, 1.0, 9);
    let error = |candidates: &Candidates, recipe: &Recipe| {
        let folds = Folds::new(candidates, &Validation::default()).expect("rows");
        Scores::new(&predict(candidates, recipe, &folds).expect("regular"), &[0.5, 0.5]).error
    };
    let known = error(&with, &recipe());
    let without = Candidates { covariates: None, ..with.clone() };
    let unknown = error(&without, &Recipe { covariates: vec![], ..recipe() });
    assert!((0.005..0.12).contains(&known) && unknown > 0.15, "{known} {unknown}");
    // Nonsense in one healthy row does not reach the other rows that are held out with it.
    let folds = Folds::new(&with, &Validation::default()).expect("rows");
    let held = |row: &usize| folds.of_row[*row] == folds.of_row[0];
    let mut spoiled = with.clone();
    spoiled.table.rows[0] = DVector::from_element(3, 1e3);
    let both = [&with, &spoiled].map(|own| predict(own, &recipe(), &folds).expect("regular"));
    let changed = |row: &usize| both[0][*row] != both[1][*row];
    assert!((1..300).filter(held).all(|row| !changed(&row)) && (1..300).any(|row| changed(&row)));
}

#[test]
fn rows_of_one_run_count_once() {
    // Six runs with a temperature each, and an error common to the run: within runs nothing is learned.
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut by_run = candidates(240, 0.0, 6);
    by_run.table.classes.fill(0);
    let covariates = by_run.covariates.as_mut().expect("covariates");
    covariates.classes.fill(0);
    for run in 0..12 {
        let (common, temperature): (f64, f64) = (StandardNormal.sample(&mut rng), 20.0 + 6.0 * f64::from(run));
        for row in 20 * run as usize..20 * (run as usize + 1) {
            let own: f64 = StandardNormal.sample(&mut rng);
            by_run.table.rows[row] = DVector::from_element(3, common + 0.1 * own);
            covariates.rows[row] = DVector::from_vec(vec![temperature + 0.1 * own, own]);
            by_run.groups[row] = run as usize;
        }
    }
    let mut recipe = Recipe { covariates: vec!["temperature".into()], ..recipe() };
    by_run.covariates = by_run.covariates.as_ref().map(|table| table.select(&[0]));
    let count = |recipe: &Recipe| fit(&by_run, recipe).expect("regular").expect("covariates").fitted();
    let by_rows = count(&recipe);
    recipe.alarms.by_run = true;
    recipe.validation.groups = by_run.groups.iter().map(ToString::to_string).collect();
    assert!(by_rows > 0 && count(&recipe) == 0, "{by_rows}");
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let message = |candidates: &Candidates, recipe: &Recipe| fit(candidates, recipe).expect_err("refused").to_string();
    let good = candidates(60, 0.0, 8);
    let unknown = Recipe { alarms: Alarms::default(), ..recipe() };
    assert!(message(&good, &unknown).contains("--covariates needs --healthy"));
    let mut constant = good.clone();
    constant.covariates.iter_mut().flat_map(|table| &mut table.rows).for_each(|row| row[1] = 7.0);
    assert!(message(&constant, &recipe()).contains("covariate useless is the same"));
    let mut copied = good.clone();
    copied.covariates.iter_mut().flat_map(|table| &mut table.rows).for_each(|row| row[1] = 2.0 * row[0] + 1.0);
    assert!(message(&copied, &recipe()).contains("depend on each other"));
    assert!(message(&good.rows(&[0, 1, 2, 4, 6, 8]), &recipe()).contains("too few"));
}
