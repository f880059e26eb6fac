//! Which fault a recorded actuator has: normal, poor lubrication, backlash or spalling, at loads seen in training and
//! at one that was not, by the core in single precision.
//!
//! Spalling is taken from level 6 on and the other faults at both levels, which is what the recording's authors call
//! detectable. Trained on runs 1–4, judged on runs 5–7; structure, features and discriminant are chosen by
//! cross-validation among the training runs alone, a run at a time. The two levels of a fault may lie on either side of
//! normal (the cruise current falls with backlash 1 and rises with backlash 2), so a class is a level, and costs make
//! the core decide between families.
//!
//! With two classes, the detector separates normal strokes from strokes of *later runs* at the same load with poor
//! lubrication or heavy backlash. The figures for spalling beside them show what the difference between recording
//! sessions alone reaches.

use bearing_watch::plan::Kind;
use host_tests::documents;
use host_tests::strokes::{LOADS, Stroke, detector, judge, strokes};
use model::core::Finding;
use model::evaluate::{self, Confusion};
use model::identify::Structure;
use model::train::{Folds, Recipe, Shrink, Trained, predict};

const STATES: [(&str, usize); 8] = [
    ("normal", 0),
    ("lackLubrication1", 1),
    ("lackLubrication2", 1),
    ("backlash1", 2),
    ("backlash2", 2),
    ("spalling6", 3),
    ("spalling7", 3),
    ("spalling8", 3),
];
const ORDERS: [[u8; 5]; 3] = [[1, 1, 1, 1, 1], [2, 2, 2, 1, 1], [2, 0, 2, 1, 0]];
const SETS: [&[&str]; 4] = [
    &["a", "b", "c", "offset", "log_variance"],
    &["a", "b", "c", "offset"],
    &["a", "offset", "log_variance"],
    &["a", "offset"],
];
const DISCRIMINANTS: [(&str, Kind, Shrink); 3] = [
    ("linear", Kind::Linear, Shrink::Not),
    ("quadratic", Kind::Quadratic, Shrink::Not),
    ("shrunk", Kind::Quadratic, Shrink::Chosen),
];

fn families() -> Vec<String> {
    ["normal", "lubrication", "backlash", "spalling"].map(String::from).to_vec()
}

fn structure(o: [u8; 5]) -> Structure {
    Structure::new(o[0], o[1], o[2], o[3], o[4]).with_offset()
}

fn state(name: &str) -> Option<usize> {
    STATES.iter().position(|s| s.0 == name)
}

/// Families are equally likely, and so are the levels of one; a wrong level of the right family costs nothing.
fn recipe(order: [u8; 5], set: &[&str], (_, discriminant, shrink): (&str, Kind, Shrink)) -> Recipe {
    let levels = |family: usize| STATES.iter().filter(|s| s.1 == family).count() as f64;
    let cost = |i: &(&str, usize)| STATES.iter().map(|k| f64::from(u8::from(i.1 != k.1))).collect();
    Recipe {
        features: set.iter().filter(|name| order[1] > 0 || **name != "b").map(|name| (*name).to_string()).collect(),
        discriminant,
        shrink,
        priors: STATES.iter().map(|s| 0.25 / levels(s.1)).collect(),
        cost: STATES.iter().map(cost).collect(),
        ..Recipe::new(structure(order))
    }
}

/// Cross-validated guarded log score of the families and their error.
fn score(trained: &Trained) -> (f64, f64) {
    let all = &trained.candidates;
    let places: Vec<usize> =
        trained.feature_names.iter().filter_map(|n| all.features.iter().position(|f| f == n)).collect();
    let candidates = all.select(&places);
    let folds = Folds::new(&candidates, &trained.recipe.validation).expect("several runs");
    let (mut score, mut wrong, mut weight) = (0.0, 0.0, 0.0);
    for p in predict(&candidates, &trained.recipe, &folds).expect("every class in every fold") {
        let mut family = [0.0; 4];
        STATES.iter().zip(&p.log_posteriors).for_each(|(s, log)| family[s.1] += log.exp());
        let truth = family[STATES[p.truth].1];
        score -= p.weight * (0.99 * truth + 0.01 * 0.25_f64).ln();
        wrong += p.weight * f64::from(u8::from(family.iter().any(|f| *f > truth)));
        weight += p.weight;
    }
    (score / weight, wrong / weight)
}

const DOCUMENT: &str = "docs/recorded.md";

fn cells(cells: &[&str]) -> Vec<String> {
    cells.iter().map(ToString::to_string).collect()
}

/// A load as the document writes it.
fn kgf(load: &str) -> String {
    format!("{} kgf", load.replace('-', "−"))
}

/// The row of the document with the least score of each discriminant, and the chosen recipe.
fn score_row(name: &str, scores: &[f64], trained: &Trained) -> Vec<String> {
    let shown: Vec<String> = scores.iter().map(|score| format!("{score:.3}")).collect();
    let least = shown.iter().min().expect("several").clone();
    let bold = shown.into_iter().map(|score| if score == least { format!("**{score}**") } else { score });
    let order = trained.recipe.structure.orders().map(|n| n.to_string()).join(" ");
    let features = trained.recipe.features.join(", ").replace('_', " ");
    std::iter::once(name.to_owned()).chain(bold).chain([format!("[{order}], {features}")]).collect()
}

/// The best recipe by the score, and the best score with each discriminant.
fn chosen(name: &str, training: &[&Stroke]) -> (Trained, Vec<f64>) {
    let classes: Vec<String> = STATES.iter().map(|s| s.0.to_string()).collect();
    let mut best: Option<(f64, String, Trained)> = None;
    let mut scores = Vec::new();
    for discriminant in DISCRIMINANTS {
        let mut least: Option<(f64, f64, String)> = None;
        for (order, set) in ORDERS.iter().flat_map(|order| SETS.iter().map(move |set| (*order, *set))) {
            let recipe = recipe(order, set, discriminant);
            let what = format!("{order:?} {}, {}", recipe.features.join(" "), discriminant.0);
            let trained = detector(training, &classes, state, &recipe).expect("regular classes");
            let (score, error) = score(&trained);
            if least.as_ref().is_none_or(|l| score < l.0) {
                least = Some((score, error, what.clone()));
            }
            if best.as_ref().is_none_or(|b| score < b.0) {
                best = Some((score, what, trained));
            }
        }
        let (score, error, what) = least.expect("several");
        scores.push(score);
        println!("{name}, within the training runs: {what}: log score {score:.3}, error {:.1} %", 100.0 * error);
    }
    let (_, what, trained) = best.expect("several");
    println!("{name}: chosen {what}");
    (trained, scores)
}

/// The row of the document with the rates of four families.
fn family_row(name: &str, found: &Confusion) -> Vec<String> {
    let judged: usize = found.counts.iter().flatten().sum();
    let right = found.counts.iter().enumerate().map(|(k, row)| {
        let all: usize = row.iter().sum();
        format!("{:.0} %", 100.0 * row[k] as f64 / all as f64)
    });
    let error = format!("{} of {judged}", found.error_rate());
    let balanced = format!("{:.1} %", 100.0 * found.balanced_accuracy().value);
    [name.to_owned(), error, balanced].into_iter().chain(right).collect()
}

fn confusion(trained: &Trained, held_out: &[&Stroke]) -> Confusion {
    let mut confusion = Confusion::new(&families());
    for verdict in judge(trained, held_out, state) {
        let decided = verdict.decided.and_then(Finding::class).map(|k| STATES[k].1);
        confusion.add(STATES[verdict.class].1, decided);
    }
    confusion
}

fn every_load() -> Option<Vec<Vec<Stroke>>> {
    LOADS.iter().map(|load| strokes(load)).collect()
}

#[test]
fn families_of_later_runs_at_loads_seen() {
    let Some(all) = every_load() else { return };
    let mut sum = Confusion::new(&families());
    let mut scored = vec![cells(&["load", "linear", "quadratic", "shrunk", "chosen"])];
    let head = ["load", "family error", "balanced accuracy", "right: normal", "lubrication", "backlash", "spalling"];
    let mut rates = vec![cells(&head)];
    for (load, strokes) in LOADS.iter().zip(&all) {
        let (training, held_out): (Vec<&Stroke>, Vec<&Stroke>) = strokes.iter().partition(|s| s.run <= 4);
        let (trained, scores) = chosen(&format!("{load} kgf"), &training);
        let found = confusion(&trained, &held_out);
        scored.push(score_row(&kgf(load), &scores, &trained));
        rates.push(family_row(&kgf(load), &found));
        println!("{load} kgf, a model of this load, runs 5–7\n{found}\n");
        let cells = sum.counts.iter_mut().flatten().zip(found.counts.iter().flatten());
        cells.for_each(|(cell, more)| *cell += more);
    }
    println!("a model for each load, all three\n{sum}\n");
    // Measured 23.4 %; with 355 strokes and another choice among nearly equal recipes five points either way. Far below
    // would mean that runs leak or that the set-up is read.
    assert!((0.18..0.29).contains(&sum.error_rate().value), "{}", sum.error_rate());
    // Lubrication and normal are hardly ever taken for each other.
    assert!(sum.counts[0][1] + sum.counts[1][0] <= 9, "{sum}");
    let (training, held_out): (Vec<&Stroke>, Vec<&Stroke>) = all.iter().flatten().partition(|s| s.run <= 4);
    let (trained, scores) = chosen("all loads", &training);
    let found = confusion(&trained, &held_out);
    scored.push(score_row("one model for all", &scores, &trained));
    rates.extend([family_row("a model for each, all three", &sum), family_row("one model for all", &found)]);
    println!("one model for all loads\n{found}\n");
    // Measured 28.2 %: states of one load fall on other states of another.
    assert!((0.23..0.34).contains(&found.error_rate().value), "{}", found.error_rate());
    documents::check_all(DOCUMENT, &[("recorded-scores", scored), ("recorded-families", rates)]);
}

/// Mean of the current while the nut moves faster than half its fastest, with its deviation over strokes.
fn cruise_current_a(strokes: &[Stroke], state: &str) -> (f64, f64) {
    let of = |s: &Stroke| {
        let fast = 0.5 * s.prepared.u1.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let moving = s.prepared.y.iter().zip(&s.prepared.u1).filter(|(_, v)| v.abs() > fast).map(|(y, _)| *y);
        let moving: Vec<f64> = moving.collect();
        moving.iter().sum::<f64>() / moving.len() as f64
    };
    let each: Vec<f64> = strokes.iter().filter(|s| s.state == state).map(of).collect();
    let mean = each.iter().sum::<f64>() / each.len() as f64;
    let squares = each.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    (mean, (squares / (each.len() - 1) as f64).sqrt())
}

#[test]
#[ignore = "half a minute of training"]
fn a_load_that_training_did_not_see() {
    let Some(all) = every_load() else { return };
    let two = ["normal", "lackLubrication2"].map(String::from);
    let class = |state: &str| two.iter().position(|name| name == state);
    let mut rates = vec![cells(&["judged at", "linear", "quadratic", "shrunk", "four families, error"])];
    let head = ["load", "normal", "lubrication 1, 2", "backlash 1, 2", "spalling 6, 7, 8"];
    let mut currents = vec![cells(&head)];
    for (held, load) in LOADS.iter().enumerate() {
        let training: Vec<&Stroke> = all.iter().enumerate().filter(|(k, _)| *k != held).flat_map(|(_, s)| s).collect();
        let held_out: Vec<&Stroke> = all[held].iter().collect();
        let families = confusion(&chosen(&format!("without {load} kgf"), &training).0, &held_out);
        let mut row = vec![kgf(load)];
        println!("trained without {load} kgf, judged there\n{families}\n");
        // Measured 38.6, 46.9 and 65.8 %: the load moves the features as far as the faults do. Much less would mean
        // that the model knows the load.
        assert!((0.30..0.75).contains(&families.error_rate().value), "{load} kgf: {}", families.error_rate());
        for discriminant in DISCRIMINANTS {
            let recipe = Recipe { priors: vec![], cost: vec![], ..recipe(ORDERS[0], SETS[0], discriminant) };
            let trained = detector(&training, &two, class, &recipe).expect("regular classes");
            let found = evaluate::count(&two, &judge(&trained, &held_out, class), None, false).balanced_accuracy();
            println!("without {load} kgf, normal against lackLubrication2, {}: {found}", discriminant.0);
            // An independent prototype: 100, 100 and 82 %; at −40 kgf a linear border finds nothing.
            let wanted = match (*load, discriminant.1) {
                ("-40", Kind::Linear) => 0.45..0.60,
                ("-40", Kind::Quadratic) => 0.70..0.90,
                _ => 0.98..1.01,
            };
            assert!(wanted.contains(&found.value), "{load} kgf, {}: {found}", discriminant.0);
            row.push(format!("{:.1} %", 100.0 * found.value));
        }
        row.push(families.error_rate().to_string());
        rates.push(row);
        let means = STATES.map(|(state, _)| {
            let (mean, sd) = cruise_current_a(&all[held], state);
            println!("{load} kgf, cruise current, {state}: {mean:.3} ± {sd:.3} A");
            mean
        });
        let range_a = means.iter().fold(f64::MIN, |m, x| m.max(*x)) - means.iter().fold(f64::MAX, |m, x| m.min(*x));
        // Measured 0.27, 0.35 and 0.02 A between the states, where strokes of one scatter by 0.005–0.035 A.
        assert!(if *load == "-40" { range_a < 0.03 } else { (0.2..0.4).contains(&range_a) }, "{load} kgf: {range_a}");
        let family = |k: usize| {
            let own = STATES.iter().zip(means).filter(|(state, _)| state.1 == k);
            own.map(|(_, mean)| format!("{mean:.3}")).collect::<Vec<_>>().join(", ")
        };
        currents.push(std::iter::once(kgf(load)).chain((0..4).map(family)).collect());
    }
    documents::check_all(DOCUMENT, &[("recorded-loads", rates), ("recorded-currents", currents)]);
}

/// Correlation of the changes of current with the next changes of velocity: its sign near half the full rate tells the
/// acquisition set-up.
fn fast_correlation(y: &[f64], u: &[f64]) -> f64 {
    let second = |x: &[f64]| x.windows(3).map(|w| w[2] - 2.0 * w[1] + w[0]).collect::<Vec<_>>();
    second(y).iter().zip(second(u).iter().skip(1)).map(|(a, b)| a * b).sum()
}

#[test]
fn block_means_hide_the_acquisition_set_up() {
    let Some(all) = every_load() else { return };
    // Full rate, block means; of each set-up, strokes told right and all.
    let mut counts = [[(0, 0); 2]; 2];
    for s in all.iter().flatten() {
        // One set-up recorded normal, backlash 1 and spalling, the other the rest.
        let other = matches!(s.state.as_str(), "lackLubrication1" | "lackLubrication2" | "backlash2");
        for (counts, trace) in counts.iter_mut().zip([&s.trace, &s.prepared]) {
            let (right, of) = &mut counts[usize::from(other)];
            *right += usize::from((fast_correlation(&trace.y, &trace.u1) > 0.0) == other);
            *of += 1;
        }
    }
    let balanced =
        counts.map(|c| 50.0 * c.iter().map(|(right, of)| f64::from(*right as u32) / *of as f64).sum::<f64>());
    println!("the set-up told by the sign: {:.1} % at full rate, {:.1} % of block means", balanced[0], balanced[1]);
    // Always told at full rate; of block means about two in three, which lubrication itself may bring about.
    assert!(balanced[0] > 99.0 && (50.0..75.0).contains(&balanced[1]), "{balanced:?}");
}

/// Normal against one other class: trained on runs 1–4, tested on runs 5–7 by the core in single precision.
fn against_normal(strokes: &[Stroke], other: &str, kind: Kind) -> Confusion {
    let classes = ["normal".to_string(), other.to_string()];
    let class = |state: &str| classes.iter().position(|name| name == state);
    let structure = Structure::new(1, 1, 1, 1, 1).with_offset();
    let features = ["a", "b", "c", "offset", "log_variance"].map(String::from).to_vec();
    let recipe = Recipe { features, discriminant: kind, ..Recipe::new(structure) };
    let (training, held_out): (Vec<&Stroke>, Vec<&Stroke>) = strokes.iter().partition(|s| s.run <= 4);
    assert!(held_out.iter().all(|t| training.iter().all(|s| s.trace.id != t.trace.id)), "leakage");
    let trained = detector(&training, &classes, class, &recipe).expect("regular classes");
    evaluate::count(&classes, &judge(&trained, &held_out, class), None, false)
}

#[test]
fn lubrication_and_backlash_are_told_from_normal() {
    for load in ["20", "40"] {
        let Some(strokes) = strokes(load) else { return };
        for fault in ["lackLubrication1", "lackLubrication2", "backlash2"] {
            let confusion = against_normal(&strokes, fault, Kind::Quadratic);
            println!("{load} kgf, normal against {fault}: {}", confusion.balanced_accuracy());
            assert_eq!(confusion.total(), 30);
            // 96.6 % is one wrong stroke of thirty, which a plain double-precision prototype also keeps to.
            assert!(confusion.wrong() <= 1, "{load} kgf\n{confusion}");
        }
        // The paper calls these undetectable; what is found is drift between sessions. Printed as the floor, and held
        // only to not being perfect throughout, which would mean that something other than the fault is read.
        let mut perfect = 0;
        for level in 1..=5 {
            let confusion = against_normal(&strokes, &format!("spalling{level}"), Kind::Quadratic);
            println!("{load} kgf, session drift (spalling{level}): {}", confusion.balanced_accuracy());
            perfect += usize::from(confusion.wrong() == 0);
        }
        assert!(perfect < 5, "every negative control is told without error");
    }
}
