//! The main job on recorded actuators: strokes of a linear actuator with seeded faults (Cranfield), from CSV through
//! training to the verdicts of the embedded detector.
//!
//! What a pass means: normal strokes are told from those with poor lubrication or heavy backlash of *later runs* at
//! the same load. The spalling figures printed beside them are the floor that recording sessions alone reach.

use std::path::PathBuf;

use bearing_watch::decide::Kind;
use host_tests::data;
use workbench::evaluate::{self, Confusion};
use workbench::identify::{Order, Structure};
use workbench::trace::labels::LabelledTrace;
use workbench::trace::{Channels, Labels, Preparation, Trace, read};
use workbench::train::{Recipe, train};

struct Recording {
    labels: Labels,
    /// As recorded.
    traces: Vec<Trace>,
    /// Block means of four, for training; the detector forms its own.
    prepared: Vec<Trace>,
}

const BLOCK: usize = 4;

fn recording(load: &str) -> Option<Recording> {
    let folder = data("cranfield_ema")?;
    let channels = Channels::new("current_a", "velocity_mm_s", "velocity_ref_mm_s");
    let file: PathBuf = folder.join(format!("strokes_{load}kgf.csv"));
    let traces = read(&[file], &channels).expect("readable strokes");
    let preparation = Preparation { block_mean: BLOCK, decimate: 1 };
    let prepared = traces.iter().map(|t| preparation.apply(t).expect("long enough")).collect();
    Some(Recording { labels: Labels::read(&folder.join("labels.csv")).expect("readable labels"), traces, prepared })
}

impl Recording {
    fn select(&self, load: &str, runs: &str, classes: &[String], prepared: bool) -> Vec<LabelledTrace> {
        let conditions = [format!("load_kgf={load}"), runs.into()].map(|c| c.parse().expect("condition"));
        let chosen = self.labels.select(&conditions).expect("rows");
        let traces = if prepared { &self.prepared } else { &self.traces };
        self.labels.join(&chosen, classes, traces).expect("traces of the labels")
    }

    /// Normal against one other class: trained on runs 1–4, tested on runs 5–7 by the core in single precision.
    fn test(&self, load: &str, other: &str, kind: Kind) -> Confusion {
        let classes = ["normal".to_string(), other.to_string()];
        let structure = Structure { order: Order::new(1, 1, 1, 1, 1), offset: true };
        let features = ["a", "b", "c", "offset", "log_variance"].map(String::from).to_vec();
        let recipe = Recipe { features, discriminant: kind, ..Recipe::new(structure) };
        let training = self.select(load, "run<=4", &classes, true);
        let mut trained = train(&training, &classes, &recipe).expect("regular classes");
        trained.block_mean = BLOCK;
        let held_out = self.select(load, "run>4", &classes, false);
        assert!(held_out.iter().all(|t| training.iter().all(|s| s.trace.id != t.trace.id)), "leakage");
        let model = trained.embed().expect("embeddable");
        let verdicts = evaluate::run(&model, &held_out, || ()).expect("runs");
        evaluate::count(&classes, &verdicts, false)
    }
}

#[test]
fn lubrication_and_backlash_are_told_from_normal() {
    for load in ["20", "40"] {
        let Some(recording) = recording(load) else { return };
        for fault in ["lackLubrication1", "lackLubrication2", "backlash2"] {
            let confusion = recording.test(load, fault, Kind::Quadratic);
            println!("{load} kgf, normal against {fault}: {}", confusion.balanced_accuracy());
            assert_eq!(confusion.total(), 30);
            // 96.6 % is one wrong stroke of thirty, which a plain double-precision prototype also keeps to.
            assert!(confusion.wrong() <= 1, "{load} kgf\n{confusion}");
        }
        // The paper calls these undetectable; what is found is drift between sessions. Printed as the floor, and held
        // only to not being perfect throughout, which would mean that something other than the fault is read.
        let mut perfect = 0;
        for level in 1..=5 {
            let confusion = recording.test(load, &format!("spalling{level}"), Kind::Quadratic);
            println!("{load} kgf, session drift (spalling{level}): {}", confusion.balanced_accuracy());
            perfect += usize::from(confusion.wrong() == 0);
        }
        assert!(perfect < 5, "every negative control is told without error");
    }
}
