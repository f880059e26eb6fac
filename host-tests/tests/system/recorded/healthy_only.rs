//! What a novelty gate of normal strokes alone makes of every fault, on runs that it has not seen, by the core in
//! single precision.
//!
//! Each run of normal strokes is held out in turn: the gate is made of the six others (30 strokes) at a false-alarm
//! rate of 1 % and judges the held-out normal strokes and the strokes of every fault. Strokes of a run are alike and
//! runs drift, so a gate that takes strokes for independent has too small a spread. It is therefore stretched within
//! its own six runs: each is left out of mean and covariance in turn, and where its strokes lie farther out than
//! independent ones would, all distances are divided by the excess,
//!
//! ```text
//! s² = max(1, mean d²(left-out run) / E d²),   E d² = p (n² − 1) / (n (n − p − 2))        (1)
//! ```
//!
//! n strokes in p features. The held-out run and the faults have no part in it.

use host_tests::documents;
use host_tests::strokes::{CONTROLS, FAULTS, LOADS, RUNS, Stroke, detector, fault_name, judge, strokes};
use model::core::Finding;
use model::evaluate::{Rate, TraceVerdict};
use model::identify::Structure;
use model::train::{Alarms, Recipe, Trained};
use nalgebra::{DMatrix, DVector};

/// (1), over the runs that the gate is made of.
fn stretch_squared(trained: &Trained) -> f64 {
    let (rows, groups) = (&trained.coordinates.rows, &trained.candidates.groups);
    let p = rows[0].len() as f64;
    let mut ratios = Vec::new();
    for (left_out, row) in groups.iter().zip(rows) {
        let others: Vec<&DVector<f64>> =
            groups.iter().zip(rows).filter(|(g, _)| *g != left_out).map(|(_, r)| r).collect();
        let n = others.len() as f64;
        let mean = others.iter().copied().sum::<DVector<f64>>() / n;
        let spread: DMatrix<f64> = others.iter().map(|r| (*r - &mean) * (*r - &mean).transpose()).sum();
        let inverse = (spread / (n - 1.0)).cholesky().expect("regular").inverse();
        let off = row - &mean;
        ratios.push(off.dot(&(inverse * &off)) / (p * (n * n - 1.0) / (n * (n - p - 2.0))));
    }
    (ratios.iter().sum::<f64>() / ratios.len() as f64).max(1.0)
}

/// Found novel and all, of each held-out run.
type Runs = Vec<(usize, usize)>;

fn rate(runs: &Runs) -> Rate {
    Rate::wilson(runs.iter().map(|r| r.0).sum(), runs.iter().map(|r| r.1).sum())
}

/// The rate, Wilson's interval and the standard error of the rate between runs.
fn shown(runs: &Runs) -> String {
    let each: Vec<f64> = runs.iter().map(|(k, n)| *k as f64 / *n as f64).collect();
    let n = each.len() as f64;
    let mean = each.iter().sum::<f64>() / n;
    let error = (each.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
    format!("{} ± {:.1} between runs", rate(runs), 100.0 * error)
}

struct Found {
    stretches: Vec<f64>,
    plain_false_alarms: Runs,
    false_alarms: Runs,
    faults: Vec<Runs>,
    /// Of each fault's strokes from the mean of normal ones, in deviations.
    distances: Vec<Vec<f32>>,
}

fn held_out_in_turn(strokes: &[Stroke], o: [u8; 5], features: &[&str]) -> Found {
    let structure = Structure::new(o[0], o[1], o[2], o[3], o[4]).with_offset();
    let normal = ["normal".to_string()];
    let alarms = Alarms { healthy: Some(0), false_alarm: 0.01, required: true, ..Alarms::default() };
    let features = features.iter().map(|name| (*name).to_string()).collect();
    let recipe = Recipe { features, alarms, ..Recipe::new(structure) };
    let class = |state: &str| (state == "normal").then_some(0);
    let mut found = Found {
        stretches: vec![],
        plain_false_alarms: vec![],
        false_alarms: vec![],
        faults: vec![vec![]; FAULTS.len()],
        distances: vec![vec![]; FAULTS.len()],
    };
    for held in RUNS {
        let training: Vec<&Stroke> = strokes.iter().filter(|s| s.run != held).collect();
        let mut trained = detector(&training, &normal, class, &recipe).expect("a gate");
        let run = |trained: &Trained, state: &str| {
            let of: Vec<&Stroke> = strokes.iter().filter(|s| s.run == held && s.state == state).collect();
            judge(trained, &of, |_| Some(0))
        };
        let novel = |verdicts: &[TraceVerdict]| {
            (verdicts.iter().filter(|v| v.decided == Some(Finding::Novel)).count(), verdicts.len())
        };
        found.plain_false_alarms.push(novel(&run(&trained, "normal")));
        let stretch = stretch_squared(&trained).sqrt();
        found.stretches.push(stretch);
        trained.watch.gate.as_mut().expect("a gate").covariance *= stretch * stretch;
        found.false_alarms.push(novel(&run(&trained, "normal")));
        for (k, state) in FAULTS.iter().enumerate() {
            let verdicts = run(&trained, state);
            if !verdicts.is_empty() {
                found.faults[k].push(novel(&verdicts));
            }
            found.distances[k].extend(verdicts.iter().flat_map(|v| &v.segments).map(|s| s.distance));
        }
    }
    found
}

/// Structures and features. The first is that of 31 sets whose faults stand out most from the negative controls at
/// 20 kgf, the third the same of a few structures at −40 kgf: there the figures flatter, at the other loads not. The
/// second shows that more can hurt.
const CHOICES: [([u8; 5], &[&str]); 3] = [
    ([1, 1, 1, 1, 1], &["a", "offset"]),
    ([1, 1, 1, 1, 1], &["a", "b", "c", "offset", "log_variance"]),
    ([1, 0, 2, 1, 0], &["a", "c"]),
];

/// What is published for all loads together: Q and T² in percent.
const PUBLISHED: [(&str, f64, f64); 4] = [
    ("lackLubrication1", 88.0, 48.6),
    ("lackLubrication2", 100.0, 64.7),
    ("backlash1", 88.0, 40.7),
    ("backlash2", 100.0, 16.0),
];

fn median(distances: &[f32]) -> f32 {
    let mut sorted = distances.to_vec();
    sorted.sort_by(f32::total_cmp);
    sorted[sorted.len() / 2]
}

fn print(found: &Found) {
    println!("  mean stretch {:.2}", found.stretches.iter().sum::<f64>() / found.stretches.len() as f64);
    println!("  false alarms, strokes as independent: {}", shown(&found.plain_false_alarms));
    println!("  false alarms, stretched by run:       {}", shown(&found.false_alarms));
    for ((state, runs), distances) in FAULTS.iter().zip(&found.faults).zip(&found.distances) {
        let published = PUBLISHED.iter().find(|p| p.0 == *state);
        let published = published.map_or(String::new(), |(_, q, t)| format!("   (published: Q {q} %, T² {t} %)"));
        println!("  {state:<17} {}, median distance {:.1}{published}", shown(runs), median(distances));
    }
}

/// Every load's table of one choice, by load.
fn tables((order, features): ([u8; 5], &[&str])) -> Option<Vec<Found>> {
    let mut all = Vec::new();
    for load in LOADS {
        let found = held_out_in_turn(&strokes(load)?, order, features);
        println!("{load} kgf, {order:?} {}", features.join(" "));
        print(&found);
        all.push(found);
    }
    let of_all = |pick: &dyn Fn(&Found) -> Runs| all.iter().flat_map(pick).collect::<Runs>();
    let pooled = Found {
        stretches: all.iter().flat_map(|f| f.stretches.clone()).collect(),
        plain_false_alarms: of_all(&|f| f.plain_false_alarms.clone()),
        false_alarms: of_all(&|f| f.false_alarms.clone()),
        faults: (0..FAULTS.len()).map(|k| of_all(&|f| f.faults[k].clone())).collect(),
        distances: (0..FAULTS.len()).map(|k| all.iter().flat_map(|f| f.distances[k].clone()).collect()).collect(),
    };
    println!("all loads, a gate each, {order:?} {}", features.join(" "));
    print(&pooled);
    all.push(pooled);
    Some(all)
}

/// The rate in percent, and its standard error between runs.
fn of_load(runs: &Runs) -> String {
    let text = shown(runs);
    let error = text.split("± ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap_or_default();
    format!("{:.1} ± {error}", 100.0 * rate(runs).value)
}

/// Rows of the document: what is called novel at each load and at all together.
fn novel_table(found: &[Found]) -> Vec<Vec<String>> {
    let [loads @ .., pooled] = found else { panic!("three loads and all") };
    let head = ["", "20 kgf", "40 kgf", "−40 kgf", "all", "published Q", "T²"];
    let row = |name: &str, pick: &dyn Fn(&Found) -> &Runs| {
        let all = rate(pick(pooled)).to_string().replace(" %", "");
        let cells = loads.iter().map(|load| of_load(pick(load))).chain([all]);
        std::iter::once(name.to_owned()).chain(cells).collect::<Vec<_>>()
    };
    let mut rows = vec![head.map(String::from).to_vec()];
    let none = [String::new(), String::new()];
    rows.push([row("normal, unseen runs (false alarms)", &|f| &f.false_alarms), none.to_vec()].concat());
    for (k, state) in FAULTS.iter().enumerate() {
        let published = PUBLISHED.iter().find(|p| p.0 == *state);
        let published = published.map_or(none.clone(), |(_, q, t)| [q.to_string(), t.to_string()]);
        rows.push([row(&fault_name(k), &|f| &f.faults[k]), published.to_vec()].concat());
    }
    rows
}

/// Rows of the document: median distances from normal.
fn distance_table(loads: &[Found]) -> Vec<Vec<String>> {
    let head = ["", "lubrication 1, 2", "backlash 1, 2", "spalling 6, 7, 8", "controls, up to"];
    let rows = LOADS.iter().zip(loads).map(|(load, found)| {
        let medians: Vec<f32> = found.distances.iter().map(|distances| median(distances)).collect();
        let listed = |range: std::ops::Range<usize>| {
            medians[range].iter().map(|median| format!("{median:.1}")).collect::<Vec<_>>().join(", ")
        };
        let controls = medians[FAULTS.len() - CONTROLS..].iter().copied().fold(0.0, f32::max);
        vec![
            format!("{} kgf", load.replace('-', "−")),
            listed(0..2),
            listed(2..4),
            listed(4..7),
            format!("{controls:.1}"),
        ]
    });
    std::iter::once(head.map(String::from).to_vec()).chain(rows).collect()
}

impl Found {
    fn percent(&self, state: &str) -> f64 {
        let place = FAULTS.iter().position(|s| *s == state).expect("a fault");
        100.0 * rate(&self.faults[place]).value
    }

    fn distance(&self, state: &str) -> f32 {
        median(&self.distances[FAULTS.iter().position(|s| *s == state).expect("a fault")])
    }

    /// The most that is found in any negative control.
    fn control_percent(&self) -> f64 {
        FAULTS[FAULTS.len() - CONTROLS..].iter().map(|s| self.percent(s)).fold(0.0, f64::max)
    }
}

#[test]
fn faults_beyond_a_gate_of_normal_strokes() {
    let Some(found) = tables(CHOICES[0]) else { return };
    let written = [("recorded-healthy", novel_table(&found)), ("recorded-distances", distance_table(&found))];
    documents::check_all("docs/recorded.md", &written);
    let [low, high, negative, pooled] = &found[..] else { panic!("three loads and all") };
    // One of 105 unseen strokes; three would still agree with 1 %, none of the faults' figures would mean anything at
    // more.
    let false_alarms: usize = pooled.false_alarms.iter().map(|r| r.0).sum();
    assert!(false_alarms <= 3, "{false_alarms} of 105");
    for load in [low, high] {
        for state in ["lackLubrication1", "lackLubrication2", "backlash2"] {
            // All of 35 are found.
            assert!(load.percent(state) > 97.0, "{state}");
        }
    }
    assert!(low.percent("spalling7") > 97.0 && low.control_percent() < 40.0);
    // Where the cruise current hardly differs, nothing may be found: a gate that does so reads something else.
    assert!(negative.percent("lackLubrication2") < 15.0 && negative.control_percent() < 10.0);
    // More features hurt: 54 % at 20 kgf with all. None at all would be no fair comparison.
    let Some(all_features) = tables(CHOICES[1]) else { return };
    let hurt = all_features[0].percent("lackLubrication1");
    assert!((30.0..75.0).contains(&hurt), "{hurt}");
    // At 40 kgf two negative controls are as far out as spalling 6 and backlash 1: sessions, not damage.
    assert!(high.control_percent() > 80.0, "{}", high.control_percent());
    // What is found there counts by its distance: 8.5–15 deviations against 5.6 of the farthest control.
    let farthest = FAULTS[FAULTS.len() - CONTROLS..].iter().map(|s| high.distance(s)).fold(0.0, f32::max);
    for state in ["lackLubrication1", "lackLubrication2", "backlash2", "spalling7", "spalling8"] {
        let ratio = high.distance(state) / farthest;
        assert!((1.4..3.5).contains(&ratio), "{state} {ratio}");
    }
}

#[test]
fn another_choice_where_the_current_does_not_differ() {
    let Some(found) = tables(CHOICES[2]) else { return };
    let negative = &found[2];
    // 94 % against 17 % of the worst control; lubrication's 31 % is no clear margin over it.
    assert!(negative.percent("backlash2") > 85.0 && negative.control_percent() < 30.0);
    assert!(negative.percent("lackLubrication2") < 45.0, "{}", negative.percent("lackLubrication2"));
}
