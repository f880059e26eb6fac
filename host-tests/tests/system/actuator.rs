//! What the detector reaches on the simulated actuator, from phase currents and resolver counts: a few records of the
//! campaign `--ema`.

use host_tests::documents;
use studies::ema::Settings;
use studies::ema::experiments;
use studies::ema::run::draw;

#[test]
fn classes_are_told_apart_behind_the_front_end_where_the_source_guesses() {
    let all = experiments::all();
    let wanted: Vec<_> =
        all.iter().filter(|own| own.name == "MIX" || own.name.starts_with("healthy:")).cloned().collect();
    // A number far from those of the documented campaign.
    let settings = Settings { draws: 1, first: 500, records: 8, default: false };
    let judged = draw(&wanted, (500, &settings), || ()).expect("the actuator");
    let [classes, alarms] = judged.counts[..] else { panic!("two experiments") };
    println!(
        "MIX: {} of {} wrong, {} of {} false alarms",
        classes.counted, classes.judged, alarms.counted, alarms.judged
    );
    assert_eq!((classes.judged, alarms.judged), (24, 8));
    // Chance would be 16 of 24. With eight training records a class one wrong one is allowed.
    assert!(classes.counted <= 1 && alarms.counted <= 2, "{classes:?} {alarms:?}");
    for source in &judged.source {
        let error = source.all_error();
        println!("source's method: {:.1} %", 100.0 * error);
        // Documented 60 to 80 %; a draw of 24 records has a standard deviation of 10 %.
        assert!((0.3..=0.95).contains(&error), "{error}");
    }
}

#[test]
fn the_document_has_the_experiments_and_goals_of_the_code() {
    let document = documents::text("docs/ema.md");
    let all = experiments::all();
    let mut sections: Vec<&str> = all.iter().map(|experiment| experiment.section).collect();
    sections.dedup();
    for section in sections {
        let rows = documents::rows(&document, section);
        let wanted: Vec<_> = all.iter().filter(|experiment| experiment.section == section).collect();
        // The first row has the headings.
        assert_eq!(rows.len(), wanted.len() + 1, "{section}");
        for (row, experiment) in rows[1..].iter().zip(wanted) {
            assert_eq!(row[0], experiment.name, "{section}");
            let goal = row.iter().find(|cell| cell.starts_with(['≤', '≥'])).map(ToString::to_string);
            assert_eq!(goal, experiment.goal.map(|goal| goal.to_string()), "{section}: {}", experiment.name);
        }
    }
}
