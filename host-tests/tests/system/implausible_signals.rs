//! Signals with a wrong sign, scale or sampling rate have no verdict, and the reason names them; healthy and defective
//! records of the rigs are never refused.

use bearing_watch::{Implausible, Reason, Verdict};
use workbench::core::Embedded;
use workbench::rig::{Condition, Defect, DefectKind, RigTrace, Scenario};
use workbench::study::campaign::run::labelled;
use workbench::study::campaign::{Cell, Purpose, Recording, map_traces};
use workbench::study::field::recipe::recipe;
use workbench::trace::labels::LabelledTrace;
use workbench::train::{VelocitySource, train};

/// A number far from those of the documents, so that these are other records.
const REPETITION: u32 = 700;

fn records(condition: Condition, purpose: Purpose, defect: Defect, count: u32) -> Vec<Recording> {
    let cell = Cell { purpose, repetition: REPETITION, condition, defect };
    map_traces(&Scenario::WITH_RESOLVER, &[cell], count, Ok).expect("the rig")
}

/// The gate of the field, trained on healthy records of a condition.
fn trained(condition: Condition, velocity: VelocitySource) -> Embedded {
    let mut recipe = recipe(&condition, &[]);
    if let Some(shaft) = &mut recipe.shaft {
        shaft.velocity = velocity;
    }
    let healthy = records(condition, Purpose::Training, Defect::HEALTHY, 40);
    let set: Vec<LabelledTrace> = healthy.into_iter().map(|own| labelled(own, 0)).collect();
    train(&set, &["healthy".into()], &recipe).and_then(|trained| trained.embed()).expect("trains")
}

/// What is wrong with a record.
fn refusal(model: &Embedded, recording: Recording) -> Option<Implausible> {
    match model.whole(&labelled(recording, 0).trace).verdict {
        Verdict::Undetermined(Reason::Implausible(error)) => Some(error),
        _ => None,
    }
}

const KINDS: [Defect; 4] = [
    Defect::HEALTHY,
    Defect::full(DefectKind::Spall),
    Defect::full(DefectKind::Roughness),
    Defect::full(DefectKind::WeakMagnet),
];

#[test]
fn no_record_of_the_rigs_is_refused() {
    let names = std::env::var("CONDITIONS").unwrap_or_else(|_| "mix".into());
    let count: u32 = std::env::var("COUNT").map_or(5, |x| x.parse().unwrap());
    let all: Vec<&str> = Condition::FIELD.iter().map(|c| c.name).collect();
    let names: Vec<&str> = if names == "all" { all } else { names.split(',').collect() };
    for name in names {
        let condition = Condition::named(name).expect("known");
        for source in [VelocitySource::Channel, VelocitySource::Angle] {
            let model = trained(condition, source);
            let balance = model.shaft().unwrap().balance;
            println!("{name} {source:?} nominal {:?} prior {:?}", balance.nominal, balance.prior);
            let mut range = [[f32::MAX, f32::MIN]; 5];
            let mut refused = 0;
            for defect in KINDS {
                for recording in records(condition, Purpose::Validation, defect, count) {
                    let report = model.whole(&labelled(recording, 0).trace);
                    let shaft = report.shaft().unwrap();
                    let f = &shaft.friction;
                    let k = f.inverse_torque_constant.unwrap_or_default();
                    for (r, x) in range.iter_mut().zip([
                        f.inertia.value / balance.nominal[0],
                        f.inertia.deviation / balance.nominal[0],
                        k.value / balance.nominal[3],
                        k.deviation / balance.nominal[3],
                        shaft.velocity_ratio.unwrap_or(1.0),
                    ]) {
                        *r = [r[0].min(x), r[1].max(x)];
                    }
                    if let Verdict::Undetermined(Reason::Implausible(error)) = report.verdict {
                        refused += 1;
                        println!(
                            "   {defect:?} {error:?} {:?} {:?} {:?} {:?}",
                            f.inertia, k, shaft.velocity_ratio, shaft.friction_reason
                        );
                    }
                }
            }
            println!(
                "  J {:?} ± {:?}  1/Kt {:?} ± {:?} ratio {:?}: refused {refused}",
                range[0], range[1], range[2], range[3], range[4]
            );
            let faults: [(&str, fn(&mut RigTrace)); 10] = [
                ("load", |t| t.load_torque_nm.iter_mut().for_each(|x| *x = -*x)),
                ("current", |t| t.current_a.iter_mut().for_each(|x| *x = -*x)),
                ("current x2", |t| t.current_a.iter_mut().for_each(|x| *x *= 2.0)),
                ("load x2", |t| t.load_torque_nm.iter_mut().for_each(|x| *x *= 2.0)),
                ("angle", |t| t.angle_rad.iter_mut().for_each(|x| *x = -*x)),
                ("velocity", |t| t.velocity_rad_s.iter_mut().for_each(|x| *x = -*x)),
                ("angle and velocity", |t| {
                    t.angle_rad.iter_mut().for_each(|x| *x = -*x);
                    t.velocity_rad_s.iter_mut().for_each(|x| *x = -*x)
                }),
                ("rpm", |t| t.velocity_rad_s.iter_mut().for_each(|x| *x *= 60.0 / std::f64::consts::TAU)),
                ("half", |t| {
                    for c in [
                        &mut t.current_a,
                        &mut t.load_torque_nm,
                        &mut t.angle_rad,
                        &mut t.velocity_rad_s,
                        &mut t.velocity_ref_rad_s,
                        &mut t.t_s,
                        &mut t.temperature_c,
                    ] {
                        let mut k = 0;
                        c.retain(|_| {
                            k += 1;
                            k % 2 == 0
                        });
                    }
                }),
                ("double", |t| {
                    for c in [
                        &mut t.current_a,
                        &mut t.load_torque_nm,
                        &mut t.angle_rad,
                        &mut t.velocity_rad_s,
                        &mut t.velocity_ref_rad_s,
                        &mut t.t_s,
                        &mut t.temperature_c,
                    ] {
                        *c = c.iter().flat_map(|x| [*x, *x]).collect::<Vec<_>>();
                        let n = c.len();
                        for k in (1..n.max(2) - 1).step_by(2) {
                            c[k] = 0.5 * (c[k - 1] + c[k + 1]);
                        }
                    }
                }),
            ];
            for (fault, change) in faults {
                let mut found = std::collections::BTreeMap::<String, u32>::new();
                for mut recording in records(condition, Purpose::Validation, Defect::HEALTHY, count) {
                    change(&mut recording.trace);
                    *found.entry(format!("{:?}", refusal(&model, recording))).or_default() += 1;
                }
                println!("  {fault}: {found:?}");
            }
        }
    }
}
