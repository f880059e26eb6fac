//! The main job on recorded actuators: strokes of a linear actuator with seeded faults (Cranfield), from CSV through
//! training to the verdicts of the embedded detector.
//!
//! What a pass means: normal strokes are told from those with poor lubrication or heavy backlash of *later runs* at
//! the same load. The spalling figures printed beside them are the floor that recording sessions alone reach.

use bearing_watch::plan::Kind;
use host_tests::strokes::{Stroke, detector, judge, strokes};
use model::evaluate::{self, Confusion};
use model::identify::Structure;
use model::train::Recipe;

/// Normal against one other class: trained on runs 1–4, tested on runs 5–7 by the core in single precision.
fn test(strokes: &[Stroke], other: &str, kind: Kind) -> Confusion {
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
            let confusion = test(&strokes, fault, Kind::Quadratic);
            println!("{load} kgf, normal against {fault}: {}", confusion.balanced_accuracy());
            assert_eq!(confusion.total(), 30);
            // 96.6 % is one wrong stroke of thirty, which a plain double-precision prototype also keeps to.
            assert!(confusion.wrong() <= 1, "{load} kgf\n{confusion}");
        }
        // The paper calls these undetectable; what is found is drift between sessions. Printed as the floor, and held
        // only to not being perfect throughout, which would mean that something other than the fault is read.
        let mut perfect = 0;
        for level in 1..=5 {
            let confusion = test(&strokes, &format!("spalling{level}"), Kind::Quadratic);
            println!("{load} kgf, session drift (spalling{level}): {}", confusion.balanced_accuracy());
            perfect += usize::from(confusion.wrong() == 0);
        }
        assert!(perfect < 5, "every negative control is told without error");
    }
}
