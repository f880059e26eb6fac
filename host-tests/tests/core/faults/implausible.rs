//! Signals that contradict the model or each other: no verdict, no evidence, and the reason names them.

use bearing_watch::plan::RunTime;
use bearing_watch::{Angle, Detector, Evidence, Implausible, Model, Monitor, Reason, Report, Verdict};
use host_tests::halves::{Interrupt, conclude};
use rig::DefectKind;

use crate::shaft::dc_motor::{Motion, lag, model, model_of_angle, motions, run, trace};

const SEGMENT: u32 = 5000;

/// A healthy record of the rig, changed.
fn recorded(change: impl Fn(&mut Motion)) -> Vec<Motion> {
    let mut all = motions(&trace(DefectKind::Healthy, 77), 14);
    all.iter_mut().for_each(change);
    all
}

pub fn refusal(report: &Report<RunTime>) -> Option<Implausible> {
    match report.verdict {
        Verdict::Undetermined(Reason::Implausible(error)) => Some(error),
        _ => None,
    }
}

/// The reports of a segment at once, deferred, and in steps.
fn three_ways(model: &Model<RunTime>, motions: &[Motion]) -> [Report<RunTime>; 3] {
    let channels = model.constants().channels.len();
    let mut at_once = Detector::new(model);
    let mut deferred = Interrupt::new(model);
    let mut found = None;
    for motion in motions {
        let sample = motion.sample(channels);
        if let (Some(report), Some(segment)) = (at_once.step(&sample), deferred.collect(&sample)) {
            let mut monitor = Monitor::new(model);
            monitor.take_from(&mut segment.clone());
            while monitor.advance().is_none() {}
            let steps = monitor.report().expect("a report").clone();
            found = Some([report, conclude(model, segment), steps]);
        }
    }
    found.expect("a whole segment")
}

#[test]
fn every_way_to_a_report_refuses_and_adds_no_evidence() {
    let model = model(lag(0.7), true, SEGMENT);
    let changed = recorded(|motion| motion.load_nm = -motion.load_nm);
    let reports = three_ways(&model, &changed);
    for report in &reports {
        assert_eq!((refusal(report), report.decision.as_ref()), (Some(Implausible::LoadSign), None));
        assert_eq!(report, &reports[0]);
        let friction = report.shaft().expect("watched").friction;
        let kt = friction.torque_constant_nm_a().expect("a load").0;
        // Table 2.3: 0.05 N·m/A.
        assert!((kt + 0.05).abs() < 1e-3, "{kt}");
    }
    let mut evidence = Evidence::new(&model);
    assert!(evidence.observe(reports[0].decision.as_ref()).is_none());
    assert_eq!(evidence.score(), Evidence::new(&model).score());
    assert!(matches!(three_ways(&model, &recorded(|_| ())).map(|own| own.verdict), [Verdict::Class(0), ..]));
}

#[test]
fn the_signal_with_the_wrong_sign_is_named() {
    use Implausible::{CurrentSign, LoadSign, MotionSign, Sign, VelocitySign};
    let negate_angle = |motion: &mut Motion| motion.angle = motion.angle.negated();
    let negate_velocity = |motion: &mut Motion| motion.velocity_rad_s = -motion.velocity_rad_s;
    let negate_current = |motion: &mut Motion| motion.current_a = -motion.current_a;
    let negate_load = |motion: &mut Motion| motion.load_nm = -motion.load_nm;
    let both = |motion: &mut Motion| {
        negate_angle(motion);
        negate_velocity(motion);
    };
    let of_channel = |change: &dyn Fn(&mut Motion)| refusal(&run(&model(lag(0.7), true, 6000), &recorded(change)));
    let changes: [&dyn Fn(&mut Motion); 6] =
        [&|_| (), &negate_load, &negate_current, &both, &negate_angle, &negate_velocity];
    let found = changes.map(of_channel);
    assert_eq!(
        found,
        [None, Some(LoadSign), Some(CurrentSign), Some(MotionSign), Some(VelocitySign), Some(VelocitySign)]
    );
    let lags = bearing_watch::model::Lags { current: 1.2, velocity: 0.5, load: 0.5 };
    let of_angle = |change: &dyn Fn(&mut Motion)| refusal(&run(&model_of_angle(lags, 6000), &recorded(change)));
    let changes: [&dyn Fn(&mut Motion); 4] = [&|_| (), &negate_load, &negate_current, &negate_angle];
    assert_eq!(changes.map(of_angle), [None, Some(LoadSign), Some(CurrentSign), Some(MotionSign)]);
    // Without a load the model sees the inertia alone.
    let unloaded = |change: &dyn Fn(&mut Motion)| {
        let report = run(&model(lag(0.7), false, 6000), &recorded(change));
        (refusal(&report), report.shaft().expect("watched").friction.inertia)
    };
    let (sign, inertia) = unloaded(&negate_current);
    assert!(matches!(sign, None | Some(Sign)) && inertia.value < 0.0, "{sign:?} {inertia:?}");
    assert_eq!(unloaded(&negate_angle).0, Some(VelocitySign));
}

#[test]
fn the_velocity_must_be_that_of_the_angle() {
    let model = model(lag(0.7), true, 6000);
    for factor in [0.5, 2.0, 60.0 / std::f32::consts::TAU, 0.7153, 0.9, 1.1] {
        let changed = recorded(|motion| motion.velocity_rad_s *= factor);
        let report = run(&model, &changed);
        let ratio = report.shaft().expect("watched").velocity_ratio.expect("motion");
        // The velocity's noise of 0.55 rad/s over more than 40 turns, and lags that cancel.
        assert!((ratio / factor - 1.0).abs() < 0.01, "{factor}: {ratio}");
        assert_eq!(refusal(&report), Some(Implausible::VelocityScale));
    }
    for factor in [0.95, 1.05] {
        assert_eq!(refusal(&run(&model, &recorded(|motion| motion.velocity_rad_s *= factor))), None, "{factor}");
    }
    // At rest the velocity is noise, and is not compared with the angle.
    let rest = recorded(|motion| {
        motion.angle = Angle::from_counts(u32::from(motion.current_a > 0.0), 14);
        motion.velocity_rad_s *= 0.01;
    });
    assert_eq!(run(&model, &rest).shaft().expect("watched").velocity_ratio, None);
    // Other samples than those of both channels do not count.
    let mut lost = recorded(|_| ());
    lost.iter_mut().skip(1000).step_by(7).for_each(|motion| motion.velocity_rad_s = f32::NAN);
    let report = run(&model, &lost);
    assert!(report.shaft().expect("watched").velocity_ratio.is_none_or(|ratio| (ratio - 1.0).abs() < 0.05));
    assert_eq!(refusal(&report), None);
}

/// Two models: velocity and angle of their own, and the velocity of the angle.
pub fn both_models() -> [(&'static str, Model<RunTime>); 2] {
    let lags = bearing_watch::model::Lags { current: 1.2, velocity: 0.5, load: 0.5 };
    [("own velocity", model(lag(0.7), true, 6000)), ("velocity of the angle", model_of_angle(lags, 6000))]
}

#[test]
fn a_single_step_spoils_its_neighbours_only() {
    let whole = recorded(|_| ());
    for (name, model) in both_models() {
        let usual = run(&model, &whole);
        let mut slipped = whole.clone();
        slipped[3000..].iter_mut().for_each(|motion| motion.angle = motion.angle.plus(Angle::from_bits(1 << 27)));
        let report = run(&model, &slipped);
        assert_eq!((refusal(&report), report.counts.rejected), (None, 1), "{name}");
        let [one, other] = [&usual, &report].map(|own| own.shaft().expect("watched").friction);
        // Forty of 5000 rows are missing, and the filters bridge a sample.
        let off = (one.drag.value - other.drag.value).abs();
        assert!(off > 0.0 && off < 2.0 * one.drag.deviation, "{name}: {off} {}", one.drag.deviation);
    }
}
