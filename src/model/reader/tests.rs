//! Payloads that are written by hand: each value goes where the format has it, and bytes without a meaning are refused.
//! That reader and writer agree would not tell it: they could err alike.

use std::vec::Vec;

use super::*;
use crate::decide::{Background, Law};
use crate::model::TERMS;
use crate::plan::{Load, MAX_HARMONICS, RunTime};
use crate::reason::FrictionTerm;
use crate::shaft::StateVariable;
use crate::signal::Label;

/// Bytes whose numbers are 1, 2, 3 … in their order.
#[derive(Default)]
struct Payload {
    bytes: Vec<u8>,
    count: u16,
}

impl Payload {
    fn next(&mut self) -> u16 {
        self.count += 1;
        self.count
    }

    fn byte(&mut self) {
        let byte = self.next();
        self.bytes.push(byte as u8);
    }

    fn half(&mut self) {
        let half = self.next();
        self.bytes.extend(half.to_le_bytes());
    }

    fn word(&mut self) {
        let word = u32::from(self.next());
        self.bytes.extend(word.to_le_bytes());
    }

    fn floats(&mut self, count: usize) {
        (0..count).for_each(|_| {
            let x = f32::from(self.next());
            self.bytes.extend(x.to_le_bytes());
        });
    }

    fn text(&mut self, text: &str, length: usize) {
        let end = self.bytes.len() + length;
        self.bytes.extend(text.bytes());
        self.bytes.resize(end, 0);
    }
}

/// The numbers of a list from one on.
fn from<const N: usize>(first: u16) -> [f32; N] {
    core::array::from_fn(|k| f32::from(first) + k as f32)
}

fn law(first: u16) -> Law {
    core::array::from_fn(|k| [f32::from(first) + 2.0 * k as f32, f32::from(first) + 2.0 * k as f32 + 1.0])
}

/// Regression, shaft and sizes of a layout; 0xFF is "none".
const LAYOUT: [u8; 37] = [
    3, // channels
    1, 1, 2, 3, 1, 4, 5, // there is a regression; offset; na, nb, nc, nkb, nkc
    1, 2, // instruments, fading
    0, 0xFF, 1, 2, 2, 0xFF, // y, u1 less channel 2, u2
    1, 2, 1, 1, 0xFF, 0xFF, 0xFF, // there is a shaft: current less channel 1, velocity, no load
    4, 0x13, // orders, harmonics and decimation less one
    0x05, 0x01, // averaged channels
    9, 2, 6, 1, 5, 3, // features, covariates, coordinates, rising ones, directions, classes
    1, // quadratic
    0xAA, 0xAA, 0xAA, // not of the layout
];

#[test]
fn each_byte_of_a_layout_has_its_place() {
    let mut input = Input::new(&LAYOUT);
    let signal = |channel, minus| Signal { channel, minus };
    let expected = Layout {
        channels: 3,
        regression: Some(RegressionLayout {
            structure: Structure { na: 2, nb: 3, nc: 1, nkb: 4, nkc: 5, offset: true },
            method: Method::Instruments,
            memory: Memory::Fading,
            y: signal(0, None),
            u1: signal(1, Some(2)),
            u2: signal(2, None),
        }),
        shaft: Some(ShaftLayout {
            current: signal(2, Some(1)),
            velocity: Some(signal(1, None)),
            load: Load::Unknown,
            orders: 4,
            harmonics: 3,
            decimation: 2,
        }),
        averaged: 0x0105,
        features: 9,
        covariates: 2,
        coordinates: 6,
        rising: 1,
        directions: 5,
        classes: 3,
        discriminant: Kind::Quadratic,
    };
    assert_eq!(read_layout(&mut input), Ok(expected));
    assert_eq!((input.array(), input.finish()), ([0xAA; 3], Ok(())));
    let mut without = Input::new(&[2, 0, 0, 4, 0, 1, 0, 1, 0, 1, 2, 0]);
    assert_eq!(read_layout(&mut without).map(|layout| layout.regression), Ok(None));
}

#[test]
fn a_weight_has_its_ratio_and_whether_it_changes_behind_the_load() {
    let with = |minus: u8, ratio: &[u8]| [&LAYOUT[..22], &[minus], ratio, &LAYOUT[23..]].concat();
    let load = |bytes: &[u8]| {
        let mut input = Input::new(bytes);
        let layout = read_layout(&mut input)?;
        assert_eq!((input.array(), layout.classes), ([0xAA; 3], 3));
        Ok(layout.shaft.unwrap().load)
    };
    for (flag, changes) in [(0, false), (1, true)] {
        assert_eq!(load(&with(0, &[4, 3, 2, 1, flag])), Ok(Load::Weight { axis_q32: 0x0102_0304, changes }));
    }
    assert_eq!(load(&with(0, &[4, 3, 2, 1, 2])), Err(Fault::OutOfRange(Field::Layout)));
    assert_eq!(load(&with(0xFF, &[])), Ok(Load::Unknown));
    for minus in [1, 2, 0xFE] {
        assert_eq!(load(&with(minus, &[])), Err(Fault::OutOfRange(Field::Layout)), "{minus}");
    }
}

#[test]
fn variants_are_those_of_their_bytes_and_no_others() {
    let at = |index: usize, byte: u8| {
        let mut bytes = LAYOUT;
        bytes[index] = byte;
        let layout = read_layout(&mut Input::new(&bytes))?;
        Ok(layout.regression.map(|regression| (regression.structure.offset, regression.method, regression.memory)))
    };
    let (squares, instruments) = (Method::LeastSquares, Method::Instruments);
    assert_eq!(at(2, 0), Ok(Some((false, instruments, Memory::Fading))));
    assert_eq!(at(8, 0), Ok(Some((true, squares, Memory::Fading))));
    assert_eq!(at(9, 0), Ok(Some((true, instruments, Memory::Segment))));
    // Flags are 0 or 1, memories 0 or 2.
    for (index, byte) in [(1, 2), (2, 2), (8, 2), (16, 2), (33, 2), (9, 1), (9, 3), (1, 0xFF), (9, 0xFF)] {
        assert_eq!(at(index, byte), Err(Fault::OutOfRange(Field::Layout)), "{index} {byte}");
    }
    for length in 0..LAYOUT.len() - 3 {
        assert_eq!(read_layout(&mut Input::new(&LAYOUT[..length])), Err(Fault::Truncated), "{length} bytes");
    }
}

#[test]
fn features_are_those_of_their_bytes_and_no_others() {
    let read = |kind, index| {
        let bytes = [kind, index];
        let mut input = Input::new(&bytes);
        let feature = Feature::get(&mut input);
        input.finish().map(|()| feature)
    };
    let expected = [
        (0, 7, Feature::Parameter(7)),
        (1, 0, Feature::LogVariance),
        (2, 1, Feature::Friction(FrictionTerm::Viscous)),
        (3, 2, Feature::FrictionScore(FrictionTerm::Coulomb)),
        (4, 0, Feature::LogFrictionVariance),
        (5, 3, Feature::OrderScore(3)),
        (6, 2, Feature::LogOrderAmplitude(2)),
        (7, 7, Feature::LogFriction(FrictionTerm::Drag)),
        (8, 4, Feature::ChannelMean(4)),
        (9, 5, Feature::ChannelRms(5)),
    ];
    for (kind, index, feature) in expected {
        assert_eq!(read(kind, index), Ok(feature));
    }
    for (kind, index) in [(2, 8), (3, 0xFF), (7, 8)] {
        assert_eq!(read(kind, index), Err(Fault::OutOfRange(Field::Feature)), "{kind} {index}");
    }
    for kind in [10, 0xFF] {
        assert_eq!(read(kind, 0), Err(Fault::Newer), "{kind}");
    }
}

/// One channel, a regression of two parameters and three columns, a shaft of one order, and a gate with one law.
fn small() -> RunTime {
    let signal = Signal::channel(0);
    RunTime::of(Layout {
        channels: 1,
        regression: Some(RegressionLayout {
            structure: Structure::new(1, 1, 0, 1, 0),
            method: Method::LeastSquares,
            memory: Memory::Segment,
            y: signal,
            u1: signal,
            u2: signal,
        }),
        shaft: Some(ShaftLayout {
            current: signal,
            velocity: None,
            load: Load::Unknown,
            orders: 1,
            harmonics: 1,
            decimation: 1,
        }),
        features: 2,
        covariates: 1,
        coordinates: 1,
        rising: 1,
        directions: 1,
        classes: 2,
        ..Layout::EMPTY
    })
    .expect("a layout")
}

#[test]
fn numbers_of_sampling_regression_and_shaft_are_in_the_order_of_the_format() {
    let mut payload = Payload::default();
    payload.floats(1); // 1: interval
    payload.bytes.push(2);
    payload.half(); // 2: samples of a mean
    payload.word(); // 3: samples of a segment
    payload.text("velocity", 32);
    payload.text("rad/s", 8);
    payload.floats(2); // 4, 5: limit, saturation
    payload.half(); // 6: samples of a stuck channel
    payload.floats(3 + 2 + 3); // from 7: scales; 10: nominal; 12: fading, floor, rest
    payload.half(); // 15: settle
    payload.half(); // 16: handover
    payload.floats(7); // from 17: lags of current, velocity, load; interval; gain, damping, rate of the filter
    payload.byte(); // 24: rows
    payload.half(); // 25: settle
    payload.floats(6); // from 26: sign, Stribeck, usual velocity, usual load, spread, deviation
    payload.half(); // 32: rows of its own
    payload.floats(8 + TERMS + TERMS); // from 33: scales; 41: nominal; 48: prior
    payload.bytes.extend(0.25_f32.to_le_bytes()); // largest change of the motion
    payload.word(); // 55: order
    payload.floats(MAX_HARMONICS + 4); // from 56: weights; 59: slip; 60: needed score; 61, 62: limits of the smallest
    payload.word();
    payload.word();
    payload.word();
    payload.word(); // 63 to 66: controls
    payload.byte(); // 67: width of a cell
    payload.floats(4); // from 68: slip, slowest, pole, high-pass
    let mut input = Input::new(&payload.bytes);
    let _without_classifier = read(&mut input, small());
    assert_eq!(input.finish(), Err(Fault::Truncated));
    classifier(&mut payload);
    let mut input = Input::new(&payload.bytes);
    let constants = read(&mut input, small());
    assert_eq!(input.finish(), Ok(()));
    let sampling = Sampling { interval_s: 1.0, park: Some(Park::Thesis), block_mean: 2, segment_samples: 3 };
    assert_eq!(constants.sampling, sampling);
    let channel = &constants.channels[0];
    assert_eq!((channel.name.as_str(), channel.unit.as_str()), ("velocity", "rad/s"));
    assert_eq!((channel.limit, channel.saturation, channel.stuck_samples), (4.0, 5.0, 6));
    let regression = &constants.regression[0];
    assert_eq!((&regression.scale[..], &regression.nominal[..]), (&from::<3>(7)[..], &from::<2>(10)[..]));
    let Forgetting { lambda, floor } = regression.forgetting;
    assert_eq!([lambda, floor, regression.rest], from(12));
    assert_eq!((regression.settle, regression.handover), (15, 16));
    let ShaftConstants { lags, balance, tracking } = &constants.shaft[0];
    let StateVariable { gain, damping, rate_per_s } = balance.filter;
    let Lags { current, velocity, load } = *lags;
    assert_eq!([current, velocity, load, balance.interval_s, gain, damping, rate_per_s], from(17));
    assert_eq!((balance.row_interval, balance.settle, balance.adapt_after_rows), (24, 25, 32));
    let velocities = [balance.sign_velocity_rad_s, balance.stribeck_velocity_rad_s, balance.usual_velocity_rad_s];
    assert_eq!(velocities, from(26));
    assert_eq!([balance.usual_load_nm, balance.row_spread, balance.deviation], from(29));
    assert_eq!((balance.scale, balance.nominal, balance.prior), (from(33), from(41), from(48)));
    assert_eq!(balance.largest_change_rad, 0.25);
    let order = &tracking.orders[0];
    assert_eq!((order.order_q16, order.weights, order.slip_ratio), (55, from(56), 59.0));
    assert_eq!([order.needed_score, order.most_relative, order.most_a], from(60));
    let blocks = &tracking.blocks;
    assert_eq!((blocks.controls.to_vec(), blocks.cell_turns_log2), ([63, 64, 65, 66].to_vec(), 67));
    assert_eq!([blocks.slip, blocks.slowest_rad_s, blocks.pole, blocks.high_pass], from(68));
    let EvidenceConstants { bet, limit, cap, segments_a_run, log_mean, defect_log_mean } = constants.evidence;
    assert_eq!(([bet, limit, cap], segments_a_run, [log_mean, defect_log_mean]), (from(261), 264, from(265)));
    assert_eq!(constants.labels.iter().map(Label::as_str).collect::<Vec<_>>(), ["good", "spall"]);
}

/// Numbers from 69 on.
fn classifier(payload: &mut Payload) {
    payload.bytes.extend([8, 0, 5, 0]); // the features
    payload.bytes.extend([9, 0]); // the covariate
    payload.floats(4); // from 69: centre, low, high, usual
    payload.floats(4); // from 73: map of the covariate, two numbers a feature
    payload.floats(2 + 2 + 2); // from 77: matrix; 79: means; 81: usual values
    payload.floats(2 + 1 + 2 + 4 + 1); // from 83: means; 85: factor; 86: priors; 88: costs; 92: of a rejection
    payload.bytes.push(1); // the healthy class
    payload.floats(1 + 1 + 2 * KNOTS + 1); // from 93: mean; 94: factor; 95: law; 143: limit
    payload.floats(2 + 2 * 2); // 144: freedom; 145: acceptable; from 146: falls and reaches
    payload.floats(2 * 2 * KNOTS); // from 150: two laws
    payload.floats(2); // from 246: segments of a usual run, margin
    payload.bytes.extend([3, 4]); // runs that are learned
    payload.bytes.extend([7, 1]); // the coordinate of the direction, and that it is an order
    for index in 1..=4 {
        payload.bytes.push(index);
        payload.floats(1); // from 248: weight in the background
    }
    payload.floats(6); // from 252: centre, and the law
    payload.floats(3); // from 258: bet, limit, cap
    payload.word(); // 261: segments a run
    payload.floats(2); // from 262: means of the logarithms
    payload.text("good", 16);
    payload.text("spall", 16);
}

#[test]
fn numbers_of_classifier_and_alarm_are_in_the_order_of_the_format() {
    let mut payload = Payload { count: 68, ..Payload::default() };
    classifier(&mut payload);
    let classifier = read_classifier(&mut Input::new(&payload.bytes), small());
    assert_eq!(classifier.features, [Feature::ChannelMean(0), Feature::OrderScore(0)]);
    let Covariate { feature, centre, low, high, usual } = classifier.covariates.list[0];
    assert_eq!((feature, [centre, low, high, usual]), (Feature::ChannelRms(0), from(69)));
    assert_eq!(classifier.covariates.map, [[73.0, 74.0], [75.0, 76.0]]);
    let Projection { matrix, mean, usual } = &classifier.projection;
    assert_eq!((&matrix[..], &mean[..], &usual[..]), (&from::<2>(77)[..], &from::<2>(79)[..], &from::<2>(81)[..]));
    let Discriminant { means, factors, log_prior, costs, reject_cost } = &classifier.discriminant;
    assert_eq!(
        (&means[..], &factors[..], &log_prior[..]),
        (&from::<2>(83)[..], &from::<1>(85)[..], &from::<2>(86)[..])
    );
    assert_eq!((&costs[..], *reject_cost), (&from::<4>(88)[..], 92.0));
    let Novelty { class, mean, factor, knots, limit, freedom, laws, directions, rises, acceptable } =
        &classifier.novelty;
    assert_eq!((*class, &mean[..], &factor[..]), (Some(1), &from::<1>(93)[..], &from::<1>(94)[..]));
    assert_eq!((*knots, *limit, *freedom), (law(95), 143.0, 144.0));
    assert_eq!(
        (*acceptable, &rises[..]),
        (145.0, &[Rise { fall: 146.0, reach: 147.0 }, Rise { fall: 148.0, reach: 149.0 }][..])
    );
    assert_eq!(laws[..], [law(150), law(150 + 48)]);
    assert_eq!((directions.usual_segments, directions.margin, directions.most_runs), (246.0, 247.0, 0x0403));
    let background = |k: u8| Background { coordinate: k, weight: 247.0 + f32::from(k) };
    let expected = crate::decide::Direction {
        coordinate: 7,
        order: true,
        background: [1, 2, 3, 4].map(background),
        centre: 252.0,
        between: 253.0,
        run: 254.0,
        segment: 255.0,
        skewness: 256.0,
        correlation: 257.0,
    };
    assert_eq!(directions.list, [expected]);
}
