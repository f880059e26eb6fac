//! The main job on the simulated standard rig: draws of 20 + 20 traces a class, judged through the core.

use host_tests::documents;
use model::statistics::mean_sd_percent;
use studies::demo::{self, Settings};

/// Draws of the usual test; all of them take half a minute.
const FEW: u32 = 5;

fn drawn(repetitions: u32) -> Vec<demo::Repetition> {
    let settings = Settings { repetitions, traces: 20, seed: 1 };
    let draw = |k| demo::draw(&settings, k, || ()).expect("the standard rig trains").repetition;
    (0..repetitions).map(draw).collect()
}

#[test]
fn a_few_draws_reach_the_figures_of_the_standard_rig() {
    reach(&drawn(FEW));
}

#[test]
#[ignore = "half a minute of statistics"]
fn twenty_draws_reach_the_figures_and_are_those_of_the_documents() {
    let draws = drawn(20);
    reach(&draws);
    documented(&demo::rows(&draws));
}

fn reach(draws: &[demo::Repetition]) {
    let mean = |rate: fn(&demo::Repetition) -> f64| mean_sd_percent(&draws.iter().map(rate).collect::<Vec<_>>());

    let (all, all_sd) = mean(|r| r.all_parameters.error_rate().value);
    println!("LS, all of a b c, LDA: {all:.2} ± {all_sd:.2} % (goal 0 to 0.5)");
    assert!(all <= 0.5, "{all}");

    // A lower end as well: a-parameters hardly feel the defects, so doing better would mean a leak between the sets.
    let (a_only, a_only_sd) = mean(|r| r.a_only.error_rate().value);
    println!("LS, a only, PCA 2, LDA: {a_only:.2} ± {a_only_sd:.2} % (goal 3 to 12)");
    assert!((3.0..=12.0).contains(&a_only), "{a_only}");
    for draw in draws {
        let single = 100.0 * draw.a_only.error_rate().value;
        // Single draws of 60 traces were seen from 2 to 17 %; two more wrong traces either way are 3.3 points.
        assert!(single <= 20.0, "{single}");
    }

    // An independent prototype found 34.7 % (three classes) and 26.0 % (two binary classifiers); a mean of 20 draws
    // scatters by about 1.3 points, one of five by 2.6, and the rigs' random numbers differ.
    let (literal, literal_sd) = mean(|r| r.literal.all_classes.error_rate().value);
    let (binary, binary_sd) = mean(|r| r.literal.binary_error());
    let (fit, _) = mean(|r| r.literal.fit_percent / 100.0);
    println!(
        "source, iv4, a only, PCA 2, LDA: {literal:.1} ± {literal_sd:.1} %; two binary: {binary:.1} ± {binary_sd:.1} %"
    );
    println!("source, healthy fit: {fit:.2} % (published 86.58)");
    assert!((29.0..=41.0).contains(&literal) && (21.0..=31.0).contains(&binary), "{literal} {binary}");
    assert!((86.3..=87.3).contains(&fit), "{fit}");
}

/// The book has these figures as `cargo demo`, and docs/tables.md as part of Table 4.1.
fn documented(rows: &[demo::Row]) {
    let titles = [
        "embedded: least squares, all of a, b, c, linear discriminant",
        "embedded: torque balance and bearing order, quadratic discriminant",
        "embedded: least squares, a only, PCA to 2, linear discriminant",
        "the source's method: iv4, a only, PCA to 2, one decision of three classes",
        "the same with two binary decisions, as published (28.3 %)",
    ];
    let head = ["method, on the same traces", "validation error, mean ± sd of 20 draws"].map(String::from).to_vec();
    let lines = titles.iter().zip(rows).map(|(title, row)| vec![(*title).to_owned(), format!("{} %", row.error())]);
    let table: Vec<_> = std::iter::once(head).chain(lines).collect();
    documents::check("book/src/introduction.md", "demo", table);

    let document = documents::text("docs/tables.md");
    let documented = documents::rows(&document, "Table 4.1: misclassified");
    // The columns of Table 4.1: published, three classes, healthy / spall, healthy / roughness, both pooled.
    let same = [
        ("LS, a b c, no projection", 2, &rows[0]),
        ("ours: ", 2, &rows[1]),
        ("the same, LS in place of iv4", 2, &rows[2]),
        ("validation, with PCA", 2, &rows[3]),
        ("validation, with PCA", 5, &rows[4]),
    ];
    for (name, column, row) in same {
        let found = documented.iter().find(|cells| cells[0].starts_with(name)).expect(name)[column];
        assert_eq!(found, row.error(), "docs/tables.md, {name}: run `cargo xtask docs tables`");
    }
}

#[test]
fn training_and_validation_sets_never_share_a_trace() {
    use rig::trace_seed;
    let settings = Settings { repetitions: 50, traces: 40, seed: 1 };
    let mut seen = std::collections::HashSet::new();
    for repetition in 0..settings.repetitions {
        let (training, validation) = settings.sets(repetition);
        for set in [training, validation] {
            for kind in demo::CLASSES {
                for k in 0..settings.traces {
                    assert!(seen.insert(trace_seed(set, kind, k)), "{repetition} {set} {k}");
                }
            }
        }
    }
    assert_eq!(seen.len(), 50 * 2 * 3 * 40);
}
