//! Regression and shaft in one detector: alone and together, behind one gate, solved at once or later.

use bearing_watch::model::{Channel, Constants, Feature, Field, Regression, Sampling};
use bearing_watch::plan::{
    Cells, Layout, Load, Memory, Method, Plan, RegressionLayout, RunTime, RunTimeSample, ShaftLayout, Structure,
};
use bearing_watch::{Detector, FrictionTerm, Implausible, Model, ModelError, Monitor, Part, Reason, Report, Verdict};
use host_tests::halves::{Interrupt, conclude};
use host_tests::plans::constants;
use rig::DefectKind;

use crate::exported::{Drive, MODEL, Sample};
use crate::shaft::dc_motor::{LIMITS, Motion, lag, model, motions, shaft, trace};

bearing_watch::plan! {
    /// Both parts. Only the regression takes the load, only the shaft the velocity.
    pub struct Both;
    pub struct All with angle { current_a: "A", velocity_rad_s: "rad/s", reference_rad_s: "rad/s", load_nm: "N·m" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(2, 1, 2, 1, 1),
            method: Method::LeastSquares,
            memory: Memory::Segment,
            y: current_a,
            u1: reference_rad_s,
            u2: load_nm,
        }),
        shaft: Some(ShaftLayout {
            current: current_a,
            velocity: Some(velocity_rad_s),
            load: Load::Unknown,
            orders: 3,
            harmonics: 3,
            decimation: 1,
        }),
        features: 3,
        coordinates: 3,
        classes: 3,
        ..Layout::EMPTY
    }
}

pub const ESTIMATED: [Feature; 3] = [Feature::Parameter(0), Feature::Parameter(1), Feature::LogVariance];
pub const WATCHED: [Feature; 3] =
    [Feature::Friction(FrictionTerm::Drag), Feature::OrderScore(0), Feature::LogOrderAmplitude(0)];
pub const MIXED: [Feature; 3] =
    [Feature::Parameter(0), Feature::Friction(FrictionTerm::Viscous), Feature::OrderScore(0)];

pub fn all(motion: &Motion) -> All {
    let Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle } = *motion;
    All { current_a, velocity_rad_s, reference_rad_s, load_nm, angle }
}

pub fn signals(motion: &Motion) -> Sample {
    let Motion { current_a, reference_rad_s, load_nm, .. } = *motion;
    Sample { current_a, velocity_ref_rad_s: reference_rad_s, load_torque_nm: load_nm }
}

/// A spalled trace, with a seed far from those of the exported model's training.
pub fn recording() -> Vec<Motion> {
    motions(&trace(DefectKind::Spall, 77_777), 14)
}

/// The regression of the exported model, with a handover.
fn regression<P: Plan>(plan: P) -> Regression<P> {
    let own = &MODEL.constants().regression[0];
    let layout = plan.layout();
    Regression {
        scale: Cells::from_fn(layout.columns(), |k| own.scale.get(k).copied().unwrap_or(1.0)),
        nominal: Cells::from_fn(layout.parameters(), |k| own.nominal[k]),
        rest: own.rest,
        handover: 300,
        ..Regression::new(plan)
    }
}

pub fn both(features: [Feature; 3], change: impl Fn(&mut [Channel])) -> Model<Both> {
    let mut constants = constants(Both, 5000, &LIMITS, &features, Some(&shaft(Both, lag(0.7))));
    constants.regression = [regression(Both)];
    change(&mut constants.channels);
    Model::new(Both, constants).expect("a good model")
}

/// The report of the only segment.
pub fn report<P: Plan>(model: &Model<P>, samples: impl IntoIterator<Item = P::Sample>) -> Report<P> {
    let mut detector = Detector::new(model);
    let mut reports = samples.into_iter().filter_map(|sample| detector.step(&sample));
    let report = reports.next().expect("a whole segment");
    assert!(reports.next().is_none());
    report
}

#[test]
fn parts_give_the_same_bits_alone_and_together() {
    let stream = recording();
    let joint = report(&both(MIXED, |_| ()), stream.iter().map(all));
    assert!(matches!(joint.verdict, Verdict::Class(_)), "{:?}", joint.verdict);
    let mut constants = MODEL.constants().clone();
    constants.regression = [regression(Drive)];
    let alone = report(&Model::new(Drive, constants).expect("good"), stream.iter().map(signals));
    let (one, other) = (alone.estimate().expect("estimated"), joint.estimate().expect("estimated"));
    assert_eq!(
        (one.delta(), one.packed_covariance(), one.rows),
        (other.delta(), other.packed_covariance(), other.rows)
    );
    assert_eq!((alone.rows, joint.rows, alone.shaft()), (4998, 4998, None), "rows of the regression");
    let shaft = joint.shaft().expect("watched");
    assert_eq!((shaft.friction_reason, shaft.orders_reason), (None, None));
    let mut unloaded = model(lag(0.7), false, 5000).constants().clone();
    unloaded.shaft[0].balance.nominal = crate::shaft::dc_motor::NOMINAL;
    let unloaded = Model::new(model(lag(0.7), false, 5000).plan(), unloaded).expect("good");
    let alone = report(&unloaded, stream.iter().map(|motion| motion.sample(2)));
    let own = alone.shaft().expect("watched");
    assert_eq!((own.friction, own.orders()), (shaft.friction, shaft.orders()));
    assert!(alone.estimate().is_none() && alone.decision.is_some());
    assert_eq!(alone.rows, 5000, "usable samples");
}

#[test]
fn the_balance_has_as_many_samples_as_the_blocks_of_a_segment() {
    let features = [Feature::OrderScore(0), Feature::Friction(FrictionTerm::Drag), Feature::Parameter(0)];
    let of = |block_mean: u16, row_interval: u8| {
        let mut constants = both(features, |_| ()).constants().clone();
        constants.sampling = Sampling { block_mean, segment_samples: 50_000, ..constants.sampling };
        constants.shaft[0].balance.row_interval = row_interval;
        Model::new(Both, constants).map(|_| ())
    };
    assert_eq!([of(4, 2), of(5, 2)], [Ok(()), Err(ModelError::OutOfRange(Field::SegmentLength))]);
}

#[test]
fn a_bad_channel_costs_only_the_part_that_uses_it() {
    let model = both(MIXED, |channels| channels[1].saturation = 390.0);
    let clean = recording();
    let hurt = |change: fn(&mut Motion)| {
        let mut stream = clean.clone();
        [700, 1500, 3200].into_iter().for_each(|k| change(&mut stream[k]));
        stream[2000].velocity_rad_s = 395.0;
        report(&model, stream.iter().map(all))
    };
    let whole = report(&model, clean.iter().map(all));
    let velocity = hurt(|motion| motion.velocity_rad_s = f32::NAN);
    assert_eq!(velocity.estimate(), whole.estimate(), "the regression has no velocity");
    let rows = |report: &Report<Both>| report.shaft().map_or(0, |shaft| shaft.friction.rows);
    // Each gap of one sample is bridged: four samples without rows, which are every eighth sample.
    let lost = rows(&whole) - rows(&velocity);
    assert!(velocity.rows == 4998 && (1..=4).contains(&lost), "{lost}");
    assert_eq!((velocity.counts.rejected, velocity.counts.saturated), (3, 1));
    let load = hurt(|motion| motion.load_nm = 1e30);
    assert_eq!(load.shaft(), hurt(|_| ()).shaft(), "the shaft has no load");
    assert_eq!((load.rows, load.counts.rejected, load.counts.saturated), (4998 - 3 * 3, 3, 1));
    let shared = hurt(|motion| (motion.current_a, motion.load_nm) = (-101.0, f32::INFINITY));
    assert_eq!((shared.rows, rows(&shared)), (load.rows, rows(&velocity)));
    assert_eq!((shared.counts.rejected, shared.counts.saturated), (3, 1), "a sample is counted once");
}

/// The plan of both parts by instrumental variables, which need an auxiliary model.
fn refined() -> Model<RunTime> {
    let layout = Both.layout();
    let regression = layout.regression.map(|own| RegressionLayout { method: Method::Instruments, ..own });
    let plan = RunTime::of(Layout { regression, ..layout }).expect("a plan");
    let mut constants = constants(plan, 5000, &LIMITS, &MIXED, Some(&shaft(plan, lag(0.7))));
    constants.regression = vec![self::regression(plan)];
    Model::new(plan, constants).expect("good")
}

fn values(motion: &Motion) -> RunTimeSample {
    let Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle } = *motion;
    RunTimeSample { values: vec![current_a, velocity_rad_s, reference_rad_s, load_nm], angle }
}

/// Solved with the last sample, as a whole after it, and in steps, one a sample; whether each estimate is adopted.
fn same_in_three_ways<P: Plan>(model: &Model<P>, sample: impl Fn(&Motion) -> P::Sample, adopts: bool) {
    let mut inline = Detector::new(model);
    let [mut whole, mut steps] = [(); 2].map(|()| Interrupt::new(model));
    let (mut monitor, mut expected, mut count, mut most) = (Monitor::new(model), None, 0, 0);
    for (t, motion) in recording().iter().cycle().take(20_290).enumerate() {
        let sample = sample(motion);
        if let Some(now) = monitor.advance() {
            assert_eq!(Some(now.report), expected.as_ref());
            assert_eq!(steps.detector.adopt(now.report), adopts);
            (count, most) = (count + 1, most.max(t % 5000));
        }
        let report = inline.step(&sample);
        let concluded = whole.collect(&sample).map(|segment| conclude(model, segment));
        concluded.iter().for_each(|report| assert_eq!(whole.detector.adopt(report), adopts));
        assert_eq!(report, concluded);
        if let Some(mut segment) = steps.collect(&sample) {
            monitor.take_from(&mut segment);
            expected = report.inspect(|report| {
                let (estimate, shaft) = (report.estimate().expect("estimated"), report.shaft().expect("watched"));
                assert_eq!((estimate.reason, shaft.friction_reason, shaft.orders_reason), (None, None, None));
                assert!(matches!(report.verdict, Verdict::Class(_)) && report.counts.refused == 0, "{report:?}");
            });
        }
    }
    assert_eq!((count, whole.detector.preview()), (4, inline.preview()));
    assert_eq!(steps.detector.preview(), inline.preview());
    println!("{most} samples from the end of a segment to its report in steps");
}

#[test]
fn a_deferred_report_has_the_same_bits() {
    same_in_three_ways(&both(MIXED, |_| ()), all, false);
    same_in_three_ways(&refined(), values, true);
}

#[test]
fn a_report_is_adopted_before_the_handover_only() {
    let (model, stream) = (refined(), recording());
    let mut adopted = Vec::new();
    for late in [0, 299, 300] {
        let mut detector = Interrupt::new(&model);
        let segment = stream.iter().find_map(|motion| detector.collect(&values(motion))).expect("a segment");
        let report = conclude(&model, segment);
        // A refused sample does not count.
        let _ = detector.collect(&values(&Motion { current_a: f32::NAN, ..stream[0] }));
        stream[..late].iter().for_each(|motion| assert!(detector.collect(&values(motion)).is_none()));
        adopted.push(detector.detector.adopt(&report));
        // The next segment needs its own.
        let rest = stream.iter().cycle().skip(late).find_map(|motion| detector.collect(&values(motion)));
        assert!(rest.is_some() && !detector.detector.adopt(&report));
    }
    assert_eq!(adopted, [true, true, false]);
    let shaft = crate::shaft::dc_motor::model(lag(0.7), true, 5000);
    let mut detector = Interrupt::new(&shaft);
    let segment = stream.iter().find_map(|motion| detector.collect(&motion.sample(3))).expect("a segment");
    assert!(!detector.detector.adopt(&conclude(&shaft, segment)), "no regression takes it over");
}

#[test]
fn a_model_that_lives_shorter_than_the_program_can_be_replaced() {
    let stream = recording();
    let mut bytes = vec![0; 4096];
    let length = MODEL.to_bytes("", &mut bytes).expect("fits");
    let mut current = MODEL.clone();
    let mut verdicts = Vec::new();
    for round in 0..2 {
        verdicts.push(report(&current, stream.iter().map(signals)).verdict);
        if round == 0 {
            let read: Model<Drive> = Model::from_bytes(&bytes[..length]).expect("good");
            let mut constants: Constants<Drive> = read.constants().clone();
            // Spalls may be called healthy for nothing.
            constants.classifier.discriminant.costs = [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0];
            current = Model::new(Drive, constants).expect("good");
        }
    }
    assert_eq!(verdicts, [Verdict::Class(1), Verdict::Class(0)]);
}

#[test]
fn reasons_name_the_term_the_channel_and_the_part() {
    for (reason, text) in [
        (Reason::TermNotExcited(FrictionTerm::Coulomb), "Coulomb friction"),
        (Reason::TermNotExcited(FrictionTerm::InverseTorqueConstant), "torque constant"),
        (Reason::ParameterNotExcited(2), "δ-parameter 3"),
        (Reason::Stuck { channel: 2 }, "channel 3"),
        (Reason::TooFewRows { part: Part::Orders, rows: 7 }, "bearing orders have too few blocks (7)"),
        (Reason::TooFewRows { part: Part::TorqueBalance, rows: 3 }, "torque balance has too few usable rows (3)"),
        (Reason::ShortSegment { rows: 2499 }, "2499 rows"),
        (Reason::WeakInstruments(Part::TorqueBalance), "instruments of the torque balance"),
        (Reason::NotFinite(Part::Classifier), "classifier"),
        (Reason::AtRest, "at rest"),
        (Reason::Implausible(Implausible::LoadSign), "the load has the wrong sign"),
    ] {
        assert!(reason.to_string().contains(text), "{reason}");
    }
}
