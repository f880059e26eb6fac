//! Prints the shaft's estimates of simulated records.
use bearing_watch::FrictionTerm;
use rayon::prelude::*;
use workbench::rig::{Condition, Defect, DefectKind, Scenario, simulate};
use workbench::study::campaign::{Cell, Purpose, Recording};
use workbench::study::campaign::run::labelled;
use workbench::trace::labels::LabelledTrace;
use workbench::train::train;

fn set(condition: Condition, purpose: Purpose, defect: Defect, count: u32, rep: u32) -> Vec<LabelledTrace> {
    let cell = Cell { purpose, repetition: rep, condition, defect };
    (0..count).into_par_iter().map(|k| {
        let seed = cell.seed(k).expect("fits");
        let trace = simulate(&cell.scenario(&Scenario::STANDARD, seed), seed).expect("valid");
        labelled(Recording { cell, number: k, seed, trace }, 0)
    }).collect()
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let slip: f64 = args[2].parse().expect("slip");
    for name in args[1].split(',') {
        let condition = Condition::named(name).expect("condition");
        let train_set = set(condition, Purpose::Training, Defect::HEALTHY, 150, 0);
        let mut recipe = workbench::study::campaign::run::ours(0.01);
        if let Some(shaft) = &mut recipe.shaft {
            shaft.slip = slip;
            shaft.load = name != "no-load-sensor";
        }
        recipe.features = vec!["drag_score".into(), "order_outer".into()];
        if let Ok(n) = std::env::var("DUMP") { let _ = n; }
        let model = match train(&train_set, &["healthy".into()], &recipe) { Ok(t) => t.embed().expect("embeds"), Err(e) => { eprintln!("{name}: {e}"); continue } };
        let shaft = &model.model().constants().shaft[0];
        eprintln!("{name}: lags {:?} pole {} cell {} sign {} nominal {:?} prior {:?} controls {:?}", shaft.lags, shaft.tracking.blocks.pole, shaft.tracking.blocks.cell_turns_log2, shaft.balance.sign_velocity_rad_s, shaft.balance.nominal, shaft.balance.prior, shaft.tracking.blocks.controls.map(|c| c as f32/65536.0));
        let spall = |s: f64| Defect { kind: DefectKind::Spall, severity: s };
        let rough = |s: f64| Defect { kind: DefectKind::Roughness, severity: s };
        let cells = [("train", Purpose::Training, Defect::HEALTHY, 150), ("h", Purpose::Validation, Defect::HEALTHY, 300), ("s1", Purpose::Validation, spall(1.0), 60), ("s2", Purpose::Validation, spall(0.5), 60), ("s4", Purpose::Validation, spall(0.25), 60), ("s8", Purpose::Validation, spall(0.125), 60), ("r8", Purpose::Validation, rough(0.125), 60), ("r32", Purpose::Validation, rough(1.0/32.0), 60)];
        for (tag, purpose, defect, count) in cells {
            let traces = set(condition, purpose, defect, count, 0);
            let rows: Vec<String> = traces.par_iter().map(|t| {
                let report = model.whole(&t.trace);
                let s = report.shaft().expect("watched");
                let mut row = format!("{name},{tag}");
                for term in FrictionTerm::ALL {
                    let p = s.friction.parameter(term).unwrap_or_default();
                    row += &format!(",{},{}", p.value, p.deviation);
                }
                let o = s.orders()[0];
                row += &format!(",{},{},{},{},{},{},{},{}", o.prominence, o.score, o.amplitude, o.deviation, o.slip, o.slip_deviation, u8::from(s.friction_reason.is_some()), u8::from(s.orders_reason.is_some()));
                row
            }).collect();
            for r in rows { println!("{r}"); }
        }
    }
}
