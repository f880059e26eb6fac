//! Priors and costs move the embedded decision where two normal densities of one variance say.
//!
//! ```text
//! decide 1 where P(1|x)/P(0|x) > C(1|0)/C(0|1),   C(i|k): deciding i where k is true
//! x* = (μ₀ + μ₁)/2 + σ²/(μ₁ − μ₀) · ln [C(1|0) P₀ / (C(0|1) P₁)]                        (1)
//! ```

use model::core::Embedded;
use model::identify::Structure;
use model::trace::labels::LabelledTrace;
use model::train::{FeatureTable, Recipe, train};
use rig::Scenario;
use studies::demo::{self, FirstInput};

/// Mean of each class and the pooled variance, by themselves.
fn moments(table: &FeatureTable) -> ([f64; 2], f64) {
    let of = |class: usize| -> Vec<f64> {
        table.rows.iter().zip(&table.classes).filter(|(_, c)| **c == class).map(|(row, _)| row[0]).collect()
    };
    let classes = [of(0), of(1)];
    let means = [0, 1].map(|k| classes[k].iter().sum::<f64>() / classes[k].len() as f64);
    let squares: f64 = [0, 1].map(|k| classes[k].iter().map(|x| (x - means[k]).powi(2)).sum::<f64>()).iter().sum();
    (means, squares / (table.rows.len() as f64 - 2.0))
}

/// The coordinate at which the core changes its mind between two values.
fn boundary(model: &Embedded, (mut low, mut high): (f64, f64)) -> f64 {
    let decide = |x: f64| model.decide_at(&[x as f32]).expect("a likelihood");
    let (below, above) = (decide(low), decide(high));
    assert_ne!(below, above, "the boundary lies between");
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        *(if decide(middle) == below { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

#[test]
fn the_boundary_lies_where_theory_says() {
    let names = demo::class_names()[..2].to_vec();
    let scenario = Scenario::STANDARD;
    let all = demo::traces(&scenario, FirstInput::Reference, (901, 8), || ()).expect("simulates");
    let traces: Vec<LabelledTrace> = all.into_iter().filter(|t| t.class < 2).collect();
    let structure = Structure::new(2, 1, 2, 1, 1);
    let mut places = vec![];
    for (priors, missed, alarm) in [
        ([0.5, 0.5], 1.0, 1.0),
        ([0.5, 0.5], 50.0, 1.0),
        ([0.98, 0.02], 1.0, 1.0),
        ([0.98, 0.02], 50.0, 1.0),
        ([0.2, 0.8], 1.0, 10.0),
    ] {
        let recipe = Recipe {
            features: vec!["a1".into()],
            priors: priors.to_vec(),
            // cost[decided][true]: healthy where it is spalled is a missed spall.
            cost: vec![vec![0.0, missed], vec![alarm, 0.0]],
            ..Recipe::new(structure)
        };
        let trained = train(&traces, &names, &recipe).expect("regular");
        let ([healthy, spall], variance) = moments(&trained.coordinates);
        let odds: f64 = alarm * priors[0] / (missed * priors[1]);
        let expected = 0.5 * (healthy + spall) + variance / (spall - healthy) * odds.ln(); // (1)
        let away = 20.0 * (spall - healthy).signum();
        let model = trained.embed().expect("embeddable");
        let found = boundary(&model, (expected - away, expected + away));
        // Single precision: log-likelihoods near 10 to 1e-6, over a slope of about one deviation.
        assert!((found - expected).abs() < 2e-5 * (1.0 + expected.abs()), "{found} {expected}");
        places.push((found - 0.5 * (healthy + spall)) * (spall - healthy).signum());
    }
    // Towards healthy where a missed spall is dear, towards spall where it is rare; both at once nearly cancel.
    assert!(places[0].abs() < 1e-4 && places[1] < -0.5 && places[2] > 0.5, "{places:?}");
    assert!(places[3].abs() < 0.05 * places[2] && places[4] > 0.1, "{places:?}");
}
