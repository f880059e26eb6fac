//! A plan that is fixed when compiling and the same layout at run time give the same bits.

use bearing_watch::model::{Feature, Lags, ShaftConstants};
use bearing_watch::plan::Structure;
use bearing_watch::plan::{
    Cells, Kind, Layout, Load, Memory, Method, Plan, RegressionLayout, RunTime, RunTimeSample, ShaftLayout, Signals,
};
use bearing_watch::{Detector, FrictionTerm, Model, ModelError, Report};
use host_tests::plans::constants;
use host_tests::plants::PLANTS;
use rig::DefectKind;

use crate::shaft::dc_motor::{Motion, lag, motions, shaft, trace};

const SEGMENT: u32 = 5000;
const SEGMENTS: usize = 4;

/// All numbers of a report. A number is printed with as many digits as tell it from its neighbours.
fn printed<P: Plan>(report: &Report<P>) -> String {
    let estimate = report.estimate().map(|e| {
        let (delta, covariance) = (e.delta(), e.packed_covariance());
        format!("{delta:?} {covariance:?} {:?} {:?} {} {} {:?}", e.raw(), e.variance, e.rows, e.stable, e.reason)
    });
    let shaft = report.shaft().map(|shaft| {
        let (friction, orders) = (&shaft.friction, shaft.orders());
        format!("{friction:?} {:?} {orders:?} {:?} {}", shaft.friction_reason, shaft.orders_reason, shaft.usable)
    });
    let decision = report.decision.as_ref().map(|d| {
        let (likelihoods, posteriors, costs) = (d.log_likelihoods(), d.posteriors(), d.expected_costs());
        let (outside, missing) = (d.outside(), d.missing());
        format!(
            "{} {likelihoods:?} {posteriors:?} {costs:?} {:?} {:?} {outside:?} {missing:?}",
            d.class, d.distance, d.surprise
        )
    });
    format!("{:?} {:?} {} {estimate:?} {shaft:?} {decision:?}", report.verdict, report.counts, report.rows)
}

/// Trains nothing: plausible constants, the same for every plan.
fn model<P: Plan>(plan: P, features: &[Feature], shaft: Option<&ShaftConstants<P>>) -> Model<P> {
    let mut constants = constants(plan, SEGMENT, &[90.0; 4], features, shaft);
    let structure = plan.layout().regression.map_or(Structure::new(0, 0, 0, 0, 0), |own| own.structure);
    let (na, nb) = (structure.na as usize, structure.nb as usize);
    if let Some(regression) = constants.regression.part_mut() {
        // A stable auxiliary model that the inputs excite.
        let nominal = |k: usize| match (k, na) {
            (0, 1) => -0.2,
            (0, 2..) => -0.01,
            (1, 2..) => 0.6,
            _ if k < na => 0.0,
            _ if k < na + nb => 0.01,
            _ => -0.01,
        };
        // The output changes slowly.
        let n = plan.layout().parameters();
        let scale = |k: usize| if k == n || (1..na).contains(&k) { 16.0 } else { 1.0 };
        regression.scale = Cells::from_fn(plan.layout().columns(), scale);
        regression.nominal = Cells::from_fn(plan.layout().parameters(), nominal);
        (regression.rest, regression.settle, regression.handover) = (1e-9, 80, 4);
        regression.forgetting.lambda = 0.999;
        regression.forgetting.floor = 1e-3;
    }
    for channel in constants.channels.cells_mut() {
        (channel.saturation, channel.stuck_samples) = (80.0, 400);
    }
    Model::new(plan, constants).expect("a good model")
}

/// The reports of samples through both, and the two models through their binary forms.
pub fn same_bits<P: Plan>(fixed: &Model<P>, samples: impl Iterator<Item = P::Sample>) -> Vec<Report<P>> {
    let mut buffer = vec![0; 1 << 14];
    let length = fixed.to_bytes("notes", &mut buffer).expect("fits");
    assert_eq!(Model::from_bytes(&buffer[..length]).as_ref(), Ok(fixed));
    let loose = Model::<RunTime>::from_bytes(&buffer[..length]).expect("any layout");
    assert_eq!(loose.plan().layout(), fixed.plan().layout());
    let mut again = vec![0; length];
    assert_eq!((loose.to_bytes("notes", &mut again), &again), (Ok(length), &buffer[..length].to_vec()));

    let (mut one, mut other) = (Detector::new(fixed), Detector::new(&loose));
    let (mut reports, channels) = (vec![], fixed.plan().layout().channels.into());
    for (k, sample) in samples.enumerate() {
        let values = (0..channels).map(|place| sample.value(place)).collect();
        let loose = RunTimeSample { values, angle: sample.angle() };
        let pair = (one.step(&sample), other.step(&loose));
        assert_eq!(pair.0.as_ref().map(printed), pair.1.as_ref().map(printed), "sample {k}");
        if k % 997 == 0 {
            assert_eq!(printed(&one.preview()), printed(&other.preview()), "sample {k}");
        }
        reports.extend(pair.0);
    }
    reports
}

/// The same of four segments that are spoilt.
fn same_bits_of_spoilt<P: Plan>(fixed: &Model<P>, samples: impl Iterator<Item = P::Sample>) {
    let reports = same_bits(fixed, samples.take(SEGMENTS * SEGMENT as usize));
    for (k, report) in reports.iter().enumerate() {
        // Where the record starts again, the angle makes a step.
        let steps = u32::from(k > 0 && fixed.plan().layout().needs_angle());
        assert!(report.decision.is_some() && report.counts.saturated == 8, "{report:?}");
        assert_eq!(report.counts.rejected, 8 + steps, "{report:?}");
    }
    assert_eq!(reports.len(), SEGMENTS);
}

/// Spoils some values: the first of a sample or the second.
fn spoil(k: usize, first: &mut f32, second: &mut f32) {
    match k % 625 {
        350 => *first = f32::NAN,
        500 => *second = 85.0,
        600 => *first += 3.0,
        _ => {}
    }
}

/// A rig with a spall.
fn spoilt_motions() -> impl Iterator<Item = Motion> {
    let stream = motions(&trace(DefectKind::Spall, 971), 14).into_iter().cycle().enumerate();
    stream.map(|(k, mut motion)| {
        spoil(k, &mut motion.current_a, &mut motion.reference_rad_s);
        motion
    })
}

macro_rules! regressions {
    ($($name:ident, $plan:ident, $sample:ident: $structure:expr, $method:ident, $memory:ident;)+) => { $(
        bearing_watch::plan! {
            struct $plan;
            struct $sample { y: "A", u1: "rad/s", u2: "N·m" }
            layout: Layout {
                regression: Some(RegressionLayout {
                    structure: $structure,
                    method: Method::$method,
                    memory: Memory::$memory,
                    y,
                    u1,
                    u2,
                }),
                features: 2,
                coordinates: 2,
                classes: 2,
                ..Layout::EMPTY
            }
        }

        #[test]
        fn $name() {
            let model = model($plan, &[Feature::Parameter(1), Feature::LogVariance], None);
            let source = PLANTS[1].source(PLANTS[1].noise(20.0), 5).enumerate();
            same_bits_of_spoilt(&model, source.map(|(k, mut inputs)| {
                spoil(k, &mut inputs.y, &mut inputs.u1);
                $sample { y: inputs.y, u1: inputs.u1, u2: inputs.u2 }
            }));
        }
    )+ };
}

regressions! {
    least_squares, Squares, SquaresSample: Structure::new(2, 1, 2, 1, 1), LeastSquares, Segment;
    least_squares_with_a_constant, Constant, ConstantSample: Structure::new(2, 2, 1, 1, 2).with_offset(), LeastSquares, Segment;
    least_squares_that_fade, Fades, FadesSample: Structure::new(2, 1, 1, 1, 1).with_offset(), LeastSquares, Fading;
    an_output_without_terms, Moving, MovingSample: Structure::new(0, 3, 2, 0, 5), LeastSquares, Segment;
    many_columns, Many, ManySample: Structure::new(6, 9, 8, 1, 3).with_offset(), LeastSquares, Segment;
    instruments, Refined, RefinedSample: Structure::new(2, 2, 1, 1, 2), Instruments, Segment;
    instruments_that_fade, Later, LaterSample: Structure::new(1, 2, 3, 4, 7).with_offset(), Instruments, Fading;
}

bearing_watch::plan! {
    /// Both parts, by differences of channels, with a quadratic discriminant.
    struct Joint;
    struct JointSample with angle { current_a: "A", velocity_rad_s: "rad/s", reference_rad_s: "rad/s", load_nm: "N·m" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(1, 1, 1, 1, 1),
            method: Method::Instruments,
            memory: Memory::Segment,
            y: current_a,
            u1: reference_rad_s.minus(velocity_rad_s),
            u2: load_nm,
        }),
        shaft: Some(ShaftLayout {
            current: current_a,
            velocity: Some(velocity_rad_s),
            load: Load::Measured(load_nm),
            orders: 3,
            harmonics: 3,
            decimation: 1,
        }),
        features: 5,
        coordinates: 3,
        classes: 2,
        discriminant: Kind::Quadratic,
        ..Layout::EMPTY
    }
}

bearing_watch::plan! {
    /// The torque balance without load and orders.
    struct Friction;
    struct FrictionSample { current_a: "A", velocity_rad_s: "rad/s" }
    layout: Layout {
        shaft: Some(ShaftLayout {
            current: current_a,
            velocity: Some(velocity_rad_s),
            load: Load::Unknown,
            orders: 0,
            harmonics: 1,
            decimation: 1,
        }),
        features: 2,
        coordinates: 1,
        classes: 1,
        ..Layout::EMPTY
    }
}

bearing_watch::plan! {
    /// The torque balance of a drive that measures nothing but current and angle.
    struct Resolver;
    struct ResolverSample with angle { current_a: "A" }
    layout: Layout {
        shaft: Some(ShaftLayout { current: current_a, velocity: None, load: Load::Unknown, orders: 0, harmonics: 1, decimation: 1 }),
        features: 2,
        coordinates: 1,
        classes: 1,
        ..Layout::EMPTY
    }
}

#[test]
fn both_parts() {
    let features = [
        Feature::Parameter(0),
        Feature::LogVariance,
        Feature::FrictionScore(FrictionTerm::InverseTorqueConstant),
        Feature::OrderScore(2),
        Feature::LogOrderAmplitude(0),
    ];
    let model = model(Joint, &features, Some(&shaft(Joint, lag(1.3))));
    let sample = |Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle }| JointSample {
        current_a,
        velocity_rad_s,
        reference_rad_s,
        load_nm,
        angle,
    };
    same_bits_of_spoilt(&model, spoilt_motions().map(sample));
}

#[test]
fn the_torque_balance_alone() {
    let features = [Feature::Friction(FrictionTerm::Drag), Feature::LogFrictionVariance];
    let model = model(Friction, &features, Some(&shaft(Friction, lag(0.0))));
    // The plan has no reference: what is spoilt of it is here spoilt of the velocity.
    let sample = |Motion { current_a, velocity_rad_s, reference_rad_s, .. }| {
        let spoilt = reference_rad_s > 84.0;
        FrictionSample { current_a, velocity_rad_s: if spoilt { reference_rad_s } else { velocity_rad_s } }
    };
    same_bits_of_spoilt(&model, spoilt_motions().map(sample));
}

#[test]
fn the_torque_balance_with_the_velocity_of_the_angle() {
    let features = [Feature::Friction(FrictionTerm::Drag), Feature::LogFrictionVariance];
    let lags = Lags { velocity: 0.5, ..lag(0.9) };
    let model = model(Resolver, &features, Some(&shaft(Resolver, lags)));
    // Here it is the current that is spoilt.
    let sample = |Motion { current_a, reference_rad_s, angle, .. }| ResolverSample {
        current_a: if reference_rad_s > 84.0 { reference_rad_s } else { current_a },
        angle,
    };
    same_bits_of_spoilt(&model, spoilt_motions().map(sample));
}

#[test]
fn a_model_of_another_plan_is_refused() {
    let features = [Feature::Parameter(1), Feature::LogVariance];
    let mut buffer = vec![0; 1 << 14];
    let length = model(Squares, &features, None).to_bytes("", &mut buffer).expect("fits");
    let bytes = &buffer[..length];
    assert!(Model::<Squares>::from_bytes(bytes).is_ok());
    // Another structure, memory, method; other parts; and the same layout with channels of other names.
    assert_eq!(Model::<Constant>::from_bytes(bytes), Err(ModelError::OtherPlan));
    assert_eq!(Model::<Fades>::from_bytes(bytes), Err(ModelError::OtherPlan));
    assert_eq!(Model::<Refined>::from_bytes(bytes), Err(ModelError::OtherPlan));
    assert_eq!(Model::<Joint>::from_bytes(bytes), Err(ModelError::OtherPlan));
    assert_eq!(Model::<Renamed>::from_bytes(bytes), Err(ModelError::Channel { index: 1 }));
    let length = model(Renamed, &features, None).to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Model::<Squares>::from_bytes(&buffer[..length]), Err(ModelError::Channel { index: 1 }));
    let text = ModelError::Channel { index: 1 }.to_string();
    assert!(text.starts_with("channel 2 of the model has another name or unit"), "{text}");
}

bearing_watch::plan! {
    /// The layout of `Squares`, its first input in another unit.
    struct Renamed;
    struct RenamedSample { y: "A", u1: "1/min", u2: "N·m" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(2, 1, 2, 1, 1),
            method: Method::LeastSquares,
            memory: Memory::Segment,
            y,
            u1,
            u2,
        }),
        features: 2,
        coordinates: 2,
        classes: 2,
        ..Layout::EMPTY
    }
}
