//! What a healthy verdict says: the smallest defect that the segment would have shown, and no verdict where nothing
//! was looked at. Models of the default recipe on the rig.

use std::sync::LazyLock;

use bearing_watch::model::Most;
use model::core::{Embedded, Finding, SegmentReport};
use model::trace::Trace;
use model::train::train;
use rig::noise::{NoiseSource, Stream};
use rig::{Condition, Defect, DefectKind, RigTrace, Scenario};
use studies::campaign::run::labelled;
use studies::campaign::{Cell, Purpose, Recording, map_traces};
use studies::field::limits::{amplitude_a, stated};
use studies::recipes::{default_recipe, default_settings};

/// A number far from those of the documents, so that these are other records.
const REPETITION: u32 = 710;
const HEALTHY: Finding = Finding::Class(0);

fn records(condition: &str, purpose: Purpose, defect: Defect, count: u32) -> Vec<Recording> {
    let condition = Condition::named(condition).expect("a known condition");
    let cell = Cell { purpose, repetition: REPETITION, condition, defect };
    map_traces(&Scenario::WITH_RESOLVER, &[cell], count, Ok).expect("the rig")
}

fn healthy(condition: &str, count: u32) -> Vec<Recording> {
    records(condition, Purpose::Validation, Defect::HEALTHY, count)
}

fn trained(condition: &str, load: bool) -> Embedded {
    let set: Vec<_> = records(condition, Purpose::Training, Defect::HEALTHY, 100);
    let set: Vec<_> = set.into_iter().map(|own| labelled(own, 0)).collect();
    let recipe = default_recipe(&default_settings(load, 0.01), &["healthy".into()]).expect("a recipe");
    train(&set, &["healthy".into()], &recipe).and_then(|trained| trained.embed()).expect("trains")
}

static LOADED: LazyLock<Embedded> = LazyLock::new(|| trained("mix", true));
static UNLOADED: LazyLock<Embedded> = LazyLock::new(|| trained("no-load-sensor", false));

fn judged(model: &Embedded, recording: Recording) -> SegmentReport {
    let trace: Trace = labelled(recording, 0).trace;
    model.run(&trace).into_iter().next().expect("a segment")
}

/// The smallest amplitude at the outer race that the segment would have shown, A.
fn outer_a(model: &Embedded, segment: &SegmentReport) -> f64 {
    stated(model, segment, &["order_outer"]).unwrap_or(f64::INFINITY)
}

/// Of spalls near the stated limit of their own record nine in ten are called.
#[test]
fn spalls_at_the_stated_limit_are_called() {
    for (condition, model) in [("mix", &*LOADED), ("no-load-sensor", &*UNLOADED)] {
        let mut limits: Vec<f64> =
            healthy(condition, 20).into_iter().map(|own| outer_a(model, &judged(model, own))).collect();
        limits.sort_unstable_by(f64::total_cmp);
        let usual = limits[limits.len() / 2] / amplitude_a(1.0);
        let called = |part: f64| {
            // Severities are multiples of 1/1920.
            let severity = (usual * part * 1920.0).round() / 1920.0;
            let spall = Defect { kind: DefectKind::Spall, severity };
            let all = records(condition, Purpose::Validation, spall, 60);
            let near = all.into_iter().map(|own| judged(model, own)).filter(|segment| {
                let ratio = amplitude_a(severity) / outer_a(model, segment);
                (part * 0.85..part * 1.15).contains(&ratio)
            });
            let (found, all) = near.fold((0, 0), |(found, all), segment| {
                let novel = segment.verdict == Ok(Finding::Novel);
                (found + usize::from(novel), all + 1)
            });
            assert!(all >= 20, "{condition}: {all} records near the limit");
            100.0 * found as f64 / all as f64
        };
        let [at, half] = [1.0, 0.5].map(called);
        println!("{condition}: size {usual:.3}: {at:.0} % at the limit, {half:.0} % at half of it");
        // 90 % of 40 records within 10 %; the spall also raises friction. At half the size the score is below the gate.
        assert!((78.0..=100.0).contains(&at) && half < 60.0, "{condition}: {at} {half}");
    }
}

#[test]
fn healthy_records_that_move_have_a_verdict_with_finite_sizes() {
    for (condition, model) in [("mix", &*LOADED), ("no-load-sensor", &*UNLOADED)] {
        let all: Vec<_> = healthy(condition, 40).into_iter().map(|own| judged(model, own)).collect();
        let undetermined = all.iter().filter(|segment| segment.verdict.is_err()).count();
        assert!(undetermined == 0, "{condition}: {:?}", all.iter().find_map(|own| own.verdict.as_ref().err()));
        let sizes = all.iter().flat_map(|segment| &segment.smallest);
        assert!(sizes.clone().count() > 0 && sizes.clone().all(|(_, size)| *size > 0.0 && size.is_finite()));
    }
}

/// A change of a record after which nothing of the bearing is to be seen.
type Change = (&'static str, fn(&mut RigTrace, &mut NoiseSource));

fn rest(trace: &mut RigTrace, noise: &mut NoiseSource, velocity_rad_s: f64, current_a: impl Fn(f64, f64) -> f64) {
    for k in 0..trace.t_s.len() {
        trace.velocity_ref_rad_s[k] = velocity_rad_s;
        // The noise of the rig's velocity and current.
        trace.velocity_rad_s[k] = velocity_rad_s + 0.55 * noise.gaussian();
        trace.angle_rad[k] = 1.2 + velocity_rad_s * trace.t_s[k];
        trace.current_a[k] = current_a(trace.load_torque_nm[k], noise.gaussian());
    }
}

const CHANGES: [Change; 6] = [
    ("rest without current", |t, n| rest(t, n, 0.0, |_, noise| 0.02 * noise)),
    ("rest under load", |t, n| rest(t, n, 0.0, |load, noise| load / 0.05 + 0.13 * noise)),
    ("a creeping shaft", |t, n| rest(t, n, 0.05, |load, noise| load / 0.05 + 0.13 * noise)),
    ("exact rest", |t, _| {
        for column in [&mut t.velocity_ref_rad_s, &mut t.velocity_rad_s] {
            column.fill(0.0);
        }
        t.angle_rad.fill(0.5);
    }),
    ("hardly any turn", |t, _| {
        // A hundredth of the motion: 0.4 rad/s.
        for column in [&mut t.velocity_ref_rad_s, &mut t.velocity_rad_s, &mut t.angle_rad] {
            column.iter_mut().for_each(|x| *x *= 0.01);
        }
    }),
    ("no power", |t, n| t.current_a.iter_mut().for_each(|current| *current = 0.02 * n.gaussian())),
];

#[test]
fn a_segment_in_which_nothing_was_looked_at_has_no_verdict() {
    for (condition, model) in [("mix", &*LOADED), ("no-load-sensor", &*UNLOADED)] {
        for (name, change) in CHANGES {
            // Without a load sensor nothing says how much current a motion needs.
            if (condition, name) == ("no-load-sensor", "no power") {
                continue;
            }
            for mut recording in healthy(condition, 4) {
                let mut noise = NoiseSource::new(recording.seed, Stream::CurrentNoise);
                change(&mut recording.trace, &mut noise);
                let segment = judged(model, recording);
                assert!(segment.verdict.is_err(), "{condition}, {name}: {:?}", segment.verdict);
            }
        }
    }
}

/// A belt that comes off: friction at a third, by what the current lacks.
#[test]
fn a_fall_is_as_much_a_finding_as_a_rise() {
    let names = LOADED.coordinate_names(&["outer", "inner", "ball", "cage"].map(String::from));
    for mut recording in healthy("mix", 6) {
        let RigTrace { current_a, velocity_rad_s, .. } = &mut recording.trace;
        // Two thirds of the rig's friction, B ω/Kt, and as much again, as of a belt at the usual speed of 28 rad/s.
        for (current, velocity) in current_a.iter_mut().zip(velocity_rad_s.iter()) {
            *current -= 1e-4 / 0.05 * (2.0 / 3.0) * velocity;
        }
        let segment = judged(&LOADED, recording);
        assert_eq!(segment.verdict, Ok(Finding::Novel));
        let Some(Most { coordinate, falls }) = segment.most else { panic!("nothing departs") };
        let name = &names[usize::from(coordinate)];
        assert!(falls && ["viscous", "viscous_log", "drag"].contains(&name.as_str()), "{name} {falls}");
    }
    let usual = healthy("mix", 6).into_iter().filter(|own| judged(&LOADED, own.clone()).verdict == Ok(HEALTHY));
    assert!(usual.count() >= 4);
}
