//! Contributions and sizes of directions through the C functions have the bits of Rust, over runs that grow.
#![allow(
    clippy::cast_possible_truncation,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

#[path = "../../examples/support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::mem::MaybeUninit;
use core::ptr::null_mut;

use bearing_watch::alarm::{Contribution, Growth, Interval};
use bearing_watch::model::{
    Channel, Classifier, Constants, Covariates, Direction, Directions, Discriminant, EvidenceConstants, Fall, Feature,
    FeatureValue, Forgetting, KNOTS, Label, Novelty, Projection, Regression, Sampling,
};
use bearing_watch::plan::{Layout, Memory as Rows, Method, RegressionLayout, Structure};
use bearing_watch::telemetry::{Encoder, Source};
use bearing_watch::{Detector, Evidence, Model, Monitor};
use bearing_watch_c::*;

use numbers::Numbers;
use support::{FILE, Memory, alarm, bytes, channels};

bearing_watch::plan! {
    /// The means of two channels are the features, and each has a direction.
    struct Means;
    struct Sample { first: "A", second: "A" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(1, 0, 0, 0, 0),
            method: Method::LeastSquares,
            memory: Rows::Segment,
            y: first,
            u1: first,
            u2: first,
        }),
        averaged: first.mask() | second.mask(),
        features: 2,
        coordinates: 2,
        directions: 2,
        classes: 1,
        ..Layout::EMPTY
    }
}

const SEGMENT: u32 = 50;
const SEGMENTS_A_RUN: u32 = 2;
/// The first direction is that of the second channel.
const DIRECTIONS: [Direction; 2] = [
    Direction { coordinate: 1, between: 0.04, run: 0.01, segment: 0.02, ..Direction::UNIT },
    Direction { coordinate: 0, between: 0.09, run: 0.02, segment: 0.01, skewness: 0.5, ..Direction::UNIT },
];

fn model(interval_s: f32) -> Model<Means> {
    let mut knots = [[0.0; 2]; KNOTS];
    for (k, knot) in (0_u8..).zip(&mut knots) {
        *knot = [2.0 * f32::from(k), f32::from(k)];
    }
    let list = DIRECTIONS;
    let unit = [1.0, 0.0, 1.0];
    Means::model(Constants {
        sampling: Sampling { interval_s, park: None, block_mean: 1, segment_samples: SEGMENT },
        channels: [Channel::within("first", "A", 64.0), Channel::within("second", "A", 64.0)],
        regression: [Regression {
            scale: [1.0, 1.0],
            nominal: [-1.0],
            forgetting: Forgetting { lambda: 0.9999, floor: 100.0 },
            rest: 1e-6,
            settle: 0,
            handover: 0,
        }],
        shaft: [],
        classifier: Classifier {
            features: [Feature::ChannelMean(0), Feature::ChannelMean(1)],
            covariates: Covariates { list: [], map: [] },
            projection: Projection { matrix: [1.0, 0.0, 0.0, 1.0], mean: [0.0; 2], usual: [0.0; 2] },
            discriminant: Discriminant {
                means: [0.0; 2],
                factors: unit,
                log_prior: [0.0],
                costs: [0.0],
                reject_cost: f32::INFINITY,
            },
            novelty: Novelty {
                class: Some(0),
                mean: [0.0; 2],
                factor: unit,
                knots,
                laws: [],
                rises: [],
                freedom: 1.0,
                acceptable: f32::INFINITY,
                limit: f32::INFINITY,
                directions: Directions { list, usual_segments: SEGMENTS_A_RUN as f32, margin: 1.645, most_runs: 60 },
            },
        },
        evidence: EvidenceConstants { limit: 9.0, cap: 5.0, segments_a_run: 1000, ..EvidenceConstants::NONE },
        labels: [Label::constant("healthy")],
    })
    .expect("a good model")
}

/// A run whose second channel lies so far above zero, in the C interface and in Rust.
fn run(
    state: *mut BwState,
    model: &Model<Means>,
    monitor: &mut Monitor<'_, Means>,
    (numbers, level): (&mut Numbers, f32),
) {
    let mut detector = Detector::new(model);
    let offsets: [f32; 2] = numbers.array();
    for _ in 0..SEGMENTS_A_RUN * SEGMENT {
        let [first, second]: [f32; 2] = numbers.array();
        let sample = Sample { first: first + 0.1 * offsets[0], second: second + 0.1 * offsets[1] + level };
        let values = channels(model, &sample);
        support::step(state, &values, 0);
        monitor.step(&mut detector, &sample);
    }
    monitor.end_run();
    // SAFETY: the state is initialised.
    unsafe {
        assert_eq!(bw_end_run(state, null_mut(), 0, null_mut()), BwCode::Ok);
        assert_eq!(bw_restart(state), BwCode::Ok);
    }
}

/// What a function writes, or its code.
fn result<T>(ask: impl FnOnce(*mut T) -> BwCode) -> Result<T, BwCode> {
    let mut place = MaybeUninit::uninit();
    match ask(place.as_mut_ptr()) {
        // SAFETY: it is written if the code says so.
        BwCode::Ok => Ok(unsafe { place.assume_init() }),
        code => Err(code),
    }
}

fn growth(state: *mut BwState, direction: u8) -> Result<BwGrowth, BwCode> {
    // SAFETY: the state is initialised, and the place is writable.
    result(|place| unsafe { bw_growth(state, direction, place) })
}

fn growth_to(state: *mut BwState, direction: u8, size: f32) -> Result<BwGrowth, BwCode> {
    // SAFETY: the state is initialised, and the place is writable.
    result(|place| unsafe { bw_growth_to(state, direction, size, place) })
}

fn contribution(state: *mut BwState, direction: u8) -> Result<BwContribution, BwCode> {
    // SAFETY: the state is initialised, and the place is writable.
    result(|place| unsafe { bw_contribution(state, direction, place) })
}

const NOTHING: Interval = Interval { value: f32::NAN, low: f32::NAN, high: f32::NAN };

fn bits(Interval { value, low, high }: Interval) -> [u32; 3] {
    [value, low, high].map(f32::to_bits)
}

fn bits_of_c(BwInterval { value, low, high }: BwInterval) -> [u32; 3] {
    [value, low, high].map(f32::to_bits)
}

fn assert_same(from_c: BwGrowth, growth: Growth) {
    let BwGrowth { size, slope, named, growing, runs_left, hours_left, run_hours } = from_c;
    assert_eq!([size, slope].map(bits_of_c), [growth.size, growth.slope].map(bits));
    assert_eq!([named, run_hours].map(f32::to_bits), [growth.named, growth.run_hours].map(f32::to_bits));
    let left = [growth.left, growth.left_hours()].map(|left| bits(left.unwrap_or(NOTHING)));
    assert_eq!(([runs_left, hours_left].map(bits_of_c), growing), (left, growth.is_growing()));
}

#[test]
fn a_history_that_grows_has_the_bits_of_rust() {
    let (model, mut memory) = (model(36.0), Memory::new());
    let state = memory.state(&bytes(&model)).expect("a model that fits");
    let (mut monitor, mut numbers, mut grew) = (Monitor::new(&model), Numbers(7), vec![]);
    for number in 0..60_u8 {
        let level = 0.05 * f32::from(number.saturating_sub(20));
        run(state, &model, &mut monitor, (&mut numbers, level));
        let evidence = monitor.evidence();
        for direction in [0, 1] {
            let Contribution { deviations, score, since, .. } = evidence.contribution(direction).expect("a direction");
            let coordinate = DIRECTIONS[usize::from(direction)].coordinate;
            let expected = BwContribution { coordinate, deviations, score, since };
            assert_eq!(contribution(state, direction), Ok(expected), "run {number}");
            assert_same(growth(state, direction).expect("a size"), evidence.growth(direction).expect("a size"));
            let to = |size| (growth_to(state, direction, size), evidence.growth_to(direction, size));
            for (from_c, expected) in [5.0, 1e6].map(to) {
                assert_same(from_c.expect("a size"), expected.expect("a size"));
            }
        }
        grew.push([0, 1].map(|direction| growth(state, direction).expect("a size")));
    }
    // Runs of one hour: two segments of 50 samples every 36 s.
    let [first, .., last] = grew[..] else { panic!("60 runs") };
    assert_eq!((last[0].run_hours, first[0].growing, first[0].hours_left.value.is_nan()), (1.0, false, true));
    let ahead = grew.iter().find(|[size, _]| size.growing).expect("it grows")[0];
    assert!(ahead.hours_left.low < ahead.hours_left.value && ahead.hours_left.value < ahead.hours_left.high);
    assert_eq!(ahead.hours_left.value, ahead.runs_left.value);
    assert!(grew.iter().all(|[_, other]| !other.growing), "the first channel is as usual");
    let raised = alarm(state);
    assert!(raised.raised && raised.risen && raised.coordinate == DIRECTIONS[0].coordinate, "{raised:?}");
    assert!(last[0].size.low > 5.0 && last[1].size.low < 1.0, "{last:?}");
}

/// Frames of reports have them, too, byte for byte.
#[test]
fn frames_with_contributions_are_those_of_rust() {
    let (model, mut memory, mut place) = (model(36.0), Memory::new(), [0_u64; BW_TELEMETRY_SIZE / 8]);
    let state = memory.state(&bytes(&model)).expect("a model that fits");
    let (mut line, source) = (null_mut(), Source { model_id: 7, session: 9 });
    // SAFETY: the memory is there as long as the line.
    let code = unsafe { bw_telemetry_init(place.as_mut_ptr().cast(), BW_TELEMETRY_SIZE, state, 7, 9, &raw mut line) };
    assert_eq!(code, BwCode::Ok);
    let (mut monitor, mut numbers) = (Monitor::new(&model), Numbers(7));
    let mut encoder = Encoder::new(&model, source);
    for number in 0..40_u8 {
        run(state, &model, &mut monitor, (&mut numbers, 0.1 * f32::from(number.saturating_sub(20))));
        let (mut from_c, mut length, mut buffer) = ([0; BW_FRAME_SIZE], 0, [0; BW_FRAME_SIZE]);
        // SAFETY: the line is initialised, and the buffer is writable.
        let code = unsafe { bw_telemetry_report(line, from_c.as_mut_ptr(), BW_FRAME_SIZE, &raw mut length) };
        assert_eq!(code, BwCode::Ok);
        let report = monitor.report().expect("a report");
        let expected = encoder.report(report, monitor.evidence(), &mut buffer).expect("fits");
        assert_eq!(&from_c[..length], expected, "run {number}");
    }
    assert!(monitor.evidence().main_contribution().is_some(), "an alarm by a direction");
}

#[test]
fn without_a_sampling_interval_there_are_runs_and_no_hours() {
    let (model, mut memory) = (model(0.0), Memory::new());
    let state = memory.state(&bytes(&model)).expect("a model that fits");
    let (mut monitor, mut numbers) = (Monitor::new(&model), Numbers(7));
    let grown = (0..60_u8).find_map(|number| {
        run(state, &model, &mut monitor, (&mut numbers, 0.1 * f32::from(number.saturating_sub(10))));
        growth(state, 0).ok().filter(|growth| growth.growing)
    });
    let BwGrowth { run_hours, runs_left, hours_left, .. } = grown.expect("it grows");
    assert!(run_hours == 0.0 && runs_left.value > 0.0 && hours_left.value.is_nan(), "{grown:?}");
}

#[test]
fn an_alarm_names_the_coordinate_that_has_risen_or_fallen() {
    let (model, mut memory) = (model(0.5), Memory::new());
    let state = memory.state(&bytes(&model)).expect("a model that fits");
    // Of two runs, by the core: what the first direction watches has risen, or the second coordinate has fallen.
    let told = |risen: f32, fall: Fall| {
        let (mut evidence, mut buffer) = (Evidence::new(&model), [0; 1024]);
        for _ in 0..2 {
            let mut decision = model.constants().classifier.decide(Means, &[0.0], 0.0).expect("a likelihood");
            decision.set_directed(&[risen, 0.0].map(|value| FeatureValue { value, variance: 0.0 }));
            decision.fall = fall;
            (0..SEGMENTS_A_RUN).for_each(|_| _ = evidence.observe(Some(&decision)));
            evidence.end_run();
        }
        let length = evidence.save(&model, &mut buffer).expect("fits");
        // SAFETY: the state is initialised, and the bytes are there.
        assert_eq!(unsafe { bw_restore(state, buffer.as_ptr(), length) }, BwCode::Ok);
        let BwAlarm { raised, known, risen, fallen, coordinate, .. } = alarm(state);
        (raised, known, risen, fallen, coordinate)
    };
    assert_eq!(told(0.0, Fall::default()), (false, false, false, false, 0));
    assert_eq!(told(5.0, Fall::default()), (true, false, true, false, 1));
    assert_eq!(told(0.0, Fall { surprise: 30.0, coordinate: 1 }), (true, false, false, true, 1));
}

#[test]
fn directions_that_a_model_does_not_have_and_wrong_sizes_are_out_of_range() {
    let (mut memory, mut other) = (Memory::new(), Memory::new());
    let state = memory.state(&bytes(&model(0.5))).expect("a model that fits");
    let none = other.state(FILE).expect("good model");
    for (state, direction) in [(state, 2), (state, u8::MAX), (none, 0)] {
        assert_eq!(growth(state, direction), Err(BwCode::OutOfRange));
        assert_eq!(growth_to(state, direction, 9.0), Err(BwCode::OutOfRange));
        assert_eq!(contribution(state, direction), Err(BwCode::OutOfRange));
    }
    for size in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(growth_to(state, 0, size), Err(BwCode::OutOfRange), "{size}");
    }
    assert!(growth(state, 0).is_ok_and(|growth| !growth.growing), "before the first run");
}

#[test]
fn wrong_pointers_are_refused() {
    let (mut memory, mut empty) = (Memory::new(), Memory::new());
    let state = memory.state(&bytes(&model(0.5))).expect("a model that fits");
    let no_state = empty.address();
    for (state, code) in [
        (null_mut(), BwCode::Null),
        (no_state.wrapping_byte_add(1).cast(), BwCode::Misaligned),
        (no_state.cast(), BwCode::NotInitialised),
    ] {
        assert_eq!((growth(state, 0), growth_to(state, 0, 9.0)), (Err(code), Err(code)));
        assert_eq!(contribution(state, 0), Err(code));
    }
    // Larger than both structures, and aligned.
    let (mut numbers, mark) = ([[1.5_f32; 40]; 2], [[1.5_f32; 40]; 2]);
    let misaligned = numbers.as_mut_ptr().wrapping_byte_add(1);
    for (growth, contribution, code) in
        [(null_mut(), null_mut(), BwCode::Null), (misaligned.cast(), misaligned.cast(), BwCode::Misaligned)]
    {
        // SAFETY: the state is initialised, and the places are NULL or not aligned.
        unsafe {
            assert_eq!([bw_growth(state, 0, growth), bw_growth_to(state, 0, 9.0, growth)], [code; 2]);
            assert_eq!(bw_contribution(state, 0, contribution), code);
        }
    }
    assert_eq!(numbers, mark);
}
