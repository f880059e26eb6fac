//! Constants out of range: each is refused, by its name, when a model is made.

use bearing_watch::model::{
    Constants, Departure, Directions, EvidenceConstants, Feature, Field, Forgetting, Label, Novelty,
};
use bearing_watch::plan::Structure;
use bearing_watch::plan::{Layout, LayoutError, Memory, Method, Plan, RegressionLayout, RunTime};
use bearing_watch::{Model, ModelError};
use host_tests::plans::{constants, layout};

use crate::exported::{Drive, MODEL};

/// The exported model after a change.
fn changed(change: impl Fn(&mut Constants<Drive>)) -> Result<Model<Drive>, ModelError> {
    let mut constants = MODEL.constants().clone();
    change(&mut constants);
    Model::new(Drive, constants)
}

fn refused(field: Field, change: fn(&mut Constants<Drive>)) {
    assert_eq!(changed(change).map(|_| ()), Err(ModelError::OutOfRange(field)));
}

/// A structure of the exported model's layout with another method or memory, and a change.
fn of(
    change_layout: impl Fn(RegressionLayout) -> RegressionLayout,
    change: impl Fn(&mut Constants<RunTime>),
) -> Result<Model<RunTime>, ModelError> {
    let plain = Drive.layout();
    let layout = Layout { regression: plain.regression.map(change_layout), ..plain };
    let plan = RunTime::of(layout).expect("a plan");
    let features = [0, 1, 2, 3, 4].map(Feature::Parameter);
    let mut constants = constants(plan, 5000, &[60.0, 400.0, 4.0], &features, None);
    change(&mut constants);
    Model::new(plan, constants)
}

/// A field, and how to spoil it.
type Case<P> = (Field, fn(&mut Constants<P>));

#[test]
fn values_out_of_range_are_named() {
    assert!(changed(|_| ()).is_ok());
    refused(Field::SamplingInterval, |c| c.sampling.interval_s = f32::NAN);
    refused(Field::SegmentLength, |c| c.sampling.segment_samples = 0);
    refused(Field::SegmentLength, |c| c.sampling.segment_samples = 1_000_001);
    refused(Field::SegmentLength, |c| c.sampling.segment_samples = 8);
    refused(Field::BlockMean, |c| c.sampling.block_mean = 0);
    refused(Field::BlockMean, |c| c.sampling.block_mean = 1001);
    refused(Field::ColumnScale, |c| c.regression[0].scale[0] = 2.0_f32.powi(61));
    refused(Field::ColumnScale, |c| c.regression[0].scale[0] = 3.0);
    refused(Field::ChannelLimit, |c| c.channels[1].limit = f32::NAN);
    refused(Field::Saturation, |c| c.channels[0].saturation = 1e9);
    refused(Field::StuckSamples, |c| c.channels[0].stuck_samples = 1);
    refused(Field::NominalModel, |c| c.regression[0].nominal[2] = f32::NAN);
    refused(Field::RestThreshold, |c| c.regression[0].rest = -1.0);
    refused(Field::LimitTimesScale, |c| (c.channels[0].limit, c.channels[0].saturation) = (1e18, 1e18));
    refused(Field::Handover, |c| c.regression[0].handover = 2501);
    refused(Field::Feature, |c| c.classifier.features[0] = Feature::Parameter(5));
    refused(Field::Projection, |c| c.classifier.projection.mean[0] = f32::INFINITY);
    refused(Field::Projection, |c| c.classifier.projection.matrix[24] = f32::NAN);
    refused(Field::ClassDensity, |c| c.classifier.discriminant.factors[0] = f32::NAN);
    refused(Field::ClassDensity, |c| c.classifier.discriminant.factors[5] = 0.0);
    refused(Field::ClassDensity, |c| c.classifier.discriminant.factors[14] = -1.0);
    refused(Field::ClassDensity, |c| c.classifier.discriminant.factors[13] = f32::INFINITY);
    refused(Field::ClassDensity, |c| c.classifier.discriminant.means[14] = f32::INFINITY);
    refused(Field::Prior, |c| c.classifier.discriminant.log_prior[0] = f32::NEG_INFINITY);
    refused(Field::Cost, |c| c.classifier.discriminant.costs[1] = -1.0);
    refused(Field::Cost, |c| c.classifier.discriminant.reject_cost = -1.0);
    refused(Field::Cost, |c| c.classifier.discriminant.reject_cost = f32::NAN);
    refused(Field::Label, |c| c.labels[1] = Label::constant("seventeen letters"));
    // Numbers that training does not give, and whose squares or exponentials leave the range of f32.
    refused(Field::SamplingInterval, |c| c.sampling.interval_s = 1e30);
    refused(Field::NominalModel, |c| c.regression[0].nominal[0] = 1e30);
    refused(Field::RestThreshold, |c| c.regression[0].rest = 1e30);
    refused(Field::Projection, |c| c.classifier.projection.matrix[3] = -1e30);
    refused(Field::Projection, |c| c.classifier.projection.mean[1] = 1e30);
    refused(Field::Projection, |c| c.classifier.projection.usual[1] = 1e30);
    refused(Field::ClassDensity, |c| c.classifier.discriminant.means[4] = 1e30);
    refused(Field::ClassDensity, |c| c.classifier.discriminant.factors[0] = 1e37);
    refused(Field::ClassDensity, |c| c.classifier.discriminant.factors[1] = 1e30);
    refused(Field::Prior, |c| c.classifier.discriminant.log_prior[0] = 1e30);
    refused(Field::Prior, |c| c.classifier.discriminant.log_prior[2] = 0.01);
    refused(Field::Prior, |c| c.classifier.discriminant.log_prior[1] = -1e30);
    refused(Field::Cost, |c| c.classifier.discriminant.reject_cost = 1e30);
    let other = changed(|c| c.channels.swap(1, 2));
    assert_eq!(other, Err(ModelError::Channel { index: 1 }), "channels in another order than in the plan");
    // Differences of one signal move on from column to column, so they share one scale.
    let three = |r| RegressionLayout { structure: Structure::new(3, 1, 1, 1, 1), ..r };
    let scaled = of(three, |c| c.regression[0].scale = vec![1.0, 2.0, 4.0, 1.0, 1.0, 1.0]);
    assert_eq!(scaled, Err(ModelError::OutOfRange(Field::ColumnScale)));
    assert!(of(three, |c| c.regression[0].scale = vec![1.0, 4.0, 4.0, 1.0, 1.0, 1.0]).is_ok());
}

#[test]
fn layouts_that_do_not_fit_are_named() {
    let plain = layout(Structure::new(2, 1, 2, 1, 1), Method::LeastSquares, Memory::Segment);
    let with = |structure: Structure, method: Method| {
        let regression = plain.regression.map(|own| RegressionLayout { structure, method, ..own });
        Layout { regression, ..plain }.check()
    };
    assert_eq!(with(Structure::new(0, 0, 0, 1, 1), Method::LeastSquares), Err(LayoutError::Terms));
    assert_eq!(with(Structure::new(200, 30, 24, 1, 1), Method::LeastSquares), Err(LayoutError::Terms));
    assert_eq!(with(Structure::new(5, 1, 1, 1, 1), Method::Instruments), Err(LayoutError::OutputTerms));
    assert_eq!(Layout { classes: 0, ..plain }.check(), Err(LayoutError::Classifier));
    // A model for a run-time plan whose layout says otherwise cannot be made either.
    assert_eq!(RunTime::of(Layout { coordinates: 0, ..plain }), None);
}

#[test]
fn lists_of_another_length_are_named() {
    let cases: [Case<RunTime>; 12] = [
        (Field::ChannelName, |c| c.channels.truncate(2)),
        (Field::ColumnScale, |c| c.regression[0].scale.push(1.0)),
        (Field::NominalModel, |c| c.regression[0].nominal.truncate(4)),
        (Field::Feature, |c| c.classifier.features.truncate(4)),
        (Field::Projection, |c| c.classifier.projection.matrix.push(0.0)),
        (Field::Projection, |c| c.classifier.projection.mean.truncate(1)),
        (Field::ClassDensity, |c| c.classifier.discriminant.means.push(0.0)),
        (Field::ClassDensity, |c| c.classifier.discriminant.factors.truncate(14)),
        (Field::Prior, |c| c.classifier.discriminant.log_prior.push(0.0)),
        (Field::Cost, |c| c.classifier.discriminant.costs.truncate(8)),
        (Field::HealthyDensity, |c| c.classifier.novelty.mean.truncate(0)),
        (Field::Label, |c| c.labels.truncate(2)),
    ];
    for (field, change) in cases {
        assert_eq!(of(|r| r, change), Err(ModelError::Length(field)));
    }
    assert!(of(|r| r, |_| ()).is_ok());
    assert!(matches!(of(|r| r, |c| c.regression.clear()), Err(ModelError::Length(_))));
}

/// The model with a gate on its first class, and an alarm.
fn gated(c: &mut Constants<Drive>) {
    c.classifier.novelty = Novelty {
        class: Some(0),
        mean: [0.5, -1.0, 2.0, 0.0, 1.0],
        factor: std::array::from_fn(|k| 1.0 / (1 + k) as f32),
        knots: std::array::from_fn(|k| [2.0 * k as f32, k as f32]),
        laws: [],
        rises: [],
        freedom: 1.0,
        acceptable: f32::INFINITY,
        limit: 4.6,
        directions: Directions::NONE,
    };
    c.classifier.discriminant.reject_cost = 0.25;
    c.evidence = EvidenceConstants {
        bet: 0.2,
        limit: 13.9,
        cap: 6.95,
        segments_a_run: 70_000,
        log_mean: 0.25,
        defect_log_mean: -0.125,
    };
}

#[test]
fn gate_and_alarm_are_read_back_by_either_plan() {
    let model = changed(gated).expect("good");
    let mut buffer = vec![0; 4096];
    let length = model.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Model::<Drive>::from_bytes(&buffer[..length]).as_ref(), Ok(&model));
    let loose = Model::<RunTime>::from_bytes(&buffer[..length]).expect("any layout");
    let (own, other) = (model.constants(), loose.constants());
    assert_eq!((other.evidence, other.classifier.discriminant.reject_cost), (own.evidence, 0.25));
    let z = [0.3, -0.2, 1.0, 0.7, -1.5];
    assert_eq!(other.classifier.novelty.judge(&z, &[]), own.classifier.novelty.judge(&z, &[]), "the same bits");
    let mut again = vec![0; length];
    assert_eq!(loose.to_bytes("", &mut again), Ok(length));
    assert_eq!(again, buffer[..length]);
}

#[test]
fn gates_and_alarms_out_of_range_are_named() {
    let cases: [Case<Drive>; 30] = [
        (Field::HealthyClass, |c| c.classifier.novelty.class = Some(3)),
        (Field::HealthyDensity, |c| c.classifier.novelty.mean[2] = f32::NAN),
        (Field::HealthyDensity, |c| c.classifier.novelty.factor[10] = f32::INFINITY),
        (Field::HealthyDensity, |c| c.classifier.novelty.factor[5] = -0.1),
        (Field::SurpriseCurve, |c| c.classifier.novelty.knots[3][0] = 4.0),
        (Field::SurpriseCurve, |c| c.classifier.novelty.knots[3][1] = 2.0),
        (Field::SurpriseCurve, |c| c.classifier.novelty.knots[0][0] = -1.0),
        (Field::SurpriseCurve, |c| c.classifier.novelty.knots[23][1] = f32::NAN),
        (Field::NoveltyLimit, |c| c.classifier.novelty.limit = 0.0),
        (Field::NoveltyLimit, |c| c.classifier.novelty.limit = f32::NAN),
        (Field::Evidence, |c| c.evidence.bet = 1.0),
        (Field::Evidence, |c| c.evidence.bet = f32::NAN),
        (Field::Evidence, |c| c.evidence.limit = 0.0),
        (Field::Evidence, |c| c.evidence.limit = f32::NAN),
        (Field::Evidence, |c| c.evidence.cap = f32::INFINITY),
        (Field::Evidence, |c| c.evidence.cap = -1.0),
        (Field::Evidence, |c| c.evidence.segments_a_run = 0),
        (Field::Evidence, |c| c.evidence.log_mean = f32::NAN),
        (Field::Evidence, |c| c.evidence.defect_log_mean = f32::INFINITY),
        (Field::HealthyDensity, |c| c.classifier.novelty.mean[0] = 1e30),
        (Field::HealthyDensity, |c| c.classifier.novelty.factor[0] = 1e38),
        // A gate that no segment reaches, by its limit or by its law.
        (Field::NoveltyLimit, |c| c.classifier.novelty.limit = 40.1),
        (Field::SurpriseCurve, |c| (5..24).for_each(|k| c.classifier.novelty.knots[k][0] = 1e20 * k as f32)),
        (Field::SurpriseCurve, |c| (0..24).for_each(|k| c.classifier.novelty.knots[k][1] = 1e-20 * (1 + k) as f32)),
        (Field::Evidence, |c| c.evidence.limit = 1e30),
        (Field::Evidence, |c| c.evidence.cap = 1e30),
        (Field::Evidence, |c| c.evidence.log_mean = 1e30),
        (Field::Evidence, |c| c.evidence.log_mean = -1e30),
        (Field::Evidence, |c| c.evidence.defect_log_mean = 7.0),
        (Field::Evidence, |c| c.evidence.defect_log_mean = -1e30),
    ];
    for (field, change) in cases {
        let error = changed(|c| {
            gated(c);
            change(c);
        });
        assert_eq!(error, Err(ModelError::OutOfRange(field)));
    }
    let never = changed(|c| {
        gated(c);
        (c.classifier.novelty.limit, c.evidence.limit) = (f32::INFINITY, f32::INFINITY);
    });
    assert!(never.is_ok(), "a distance without a gate, and no alarm");
    // Without a healthy class nothing of it has an effect.
    let none = changed(|c| {
        gated(c);
        c.classifier.novelty.class = None;
    });
    let none = none.expect("good");
    assert_eq!(none.constants().classifier.novelty.judge(&[9.0; 5], &[]), Departure::default());
}

#[test]
fn sums_that_would_degrade_are_refused() {
    let memory = |memory: Memory| move |r| RegressionLayout { memory, ..r };
    let long = |c: &mut Constants<RunTime>| c.sampling.segment_samples = 100_001;
    assert_eq!(of(memory(Memory::Segment), long), Err(ModelError::OutOfRange(Field::SegmentLength)));
    let fading = |lambda: f32, floor: f32, rest: f32| {
        of(memory(Memory::Fading), |c| {
            long(c);
            (c.regression[0].forgetting, c.regression[0].rest) = (Forgetting { lambda, floor }, rest);
        })
        .map(|_| ())
    };
    assert_eq!(fading(0.999, 10.0, 1e-4), Ok(()));
    let refused = |field: Field| Err(ModelError::OutOfRange(field));
    assert_eq!(fading(0.999, 10.0, 0.0), refused(Field::RestThreshold), "it would forget at rest");
    assert_eq!(fading(1.0, 1.0, 1e-4), refused(Field::ForgettingFactor));
    assert_eq!(fading(0.99995, 1.0, 1e-4), refused(Field::ForgettingFactor));
    assert_eq!(fading(f32::NAN, 1.0, 1e-4), refused(Field::ForgettingFactor));
    assert_eq!(fading(0.9, 1.0, 1e-4), refused(Field::ForgettingFactor), "ten rows for five parameters");
    assert_eq!(fading(0.999, 0.0, 1e-4), refused(Field::ForgettingFloor));
}

#[test]
fn the_column_of_the_output_keeps_its_sums_finite() {
    let limit = MODEL.constants().channels[0].limit;
    assert!(limit > 2.0, "a limit that matters");
    let largest = (1e14 / limit).log2().floor().exp2();
    let scaled = |scale: f32| {
        changed(|c| {
            let last = c.regression[0].scale.len() - 1;
            c.regression[0].scale[last] = scale;
        })
    };
    assert_eq!(scaled(largest).map(|_| ()), Ok(()));
    assert_eq!(scaled(2.0 * largest).map(|_| ()), Err(ModelError::OutOfRange(Field::LimitTimesScale)));
}

#[test]
fn instruments_need_a_stable_nominal_model_and_time_to_settle() {
    let instruments = |r| RegressionLayout { method: Method::Instruments, ..r };
    let unstable = of(instruments, |c| c.regression[0].nominal[0] = 0.1);
    assert_eq!(unstable, Err(ModelError::OutOfRange(Field::NominalStability)));
    let stable = |c: &mut Constants<RunTime>| c.regression[0].nominal = vec![-0.1, 0.2, 0.1, 0.1, 0.1];
    let model = of(instruments, stable).expect("good");
    let mut buffer = [0; 4096];
    let length = model.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Model::<RunTime>::from_bytes(&buffer[..length]).as_ref(), Ok(&model));
    assert_eq!(Model::<Drive>::from_bytes(&buffer[..length]), Err(ModelError::OtherPlan));
    let hurried = of(instruments, |c| {
        stable(c);
        c.sampling.segment_samples = 399;
    });
    assert_eq!(hurried, Err(ModelError::OutOfRange(Field::Settling)));
}
