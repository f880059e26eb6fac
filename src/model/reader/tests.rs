//! Payloads that are written by hand: each value goes where the format has it, and bytes without a meaning are refused.
//! That reader and writer agree would not tell it: they could err alike.

use std::vec::Vec;

use super::*;
use crate::decide::{Law, Rise};
use crate::plan::RunTime;
use crate::reason::FrictionTerm;

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
    let mut reader = Reader(&LAYOUT);
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
            load: None,
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
    assert_eq!(reader.layout(), Ok(expected));
    assert_eq!(reader.0, [0xAA; 3]);
    assert_eq!(Reader(&[2, 0, 0, 4, 0, 1, 0, 1, 0, 1, 2, 0]).layout().map(|layout| layout.regression), Ok(None));
}

#[test]
fn variants_are_those_of_their_bytes_and_no_others() {
    let at = |place: usize, byte: u8| {
        let mut bytes = LAYOUT;
        bytes[place] = byte;
        let layout = Reader(&bytes).layout()?;
        Ok(layout.regression.map(|regression| (regression.structure.offset, regression.method, regression.memory)))
    };
    let (squares, instruments) = (Method::LeastSquares, Method::Instruments);
    assert_eq!(at(2, 0), Ok(Some((false, instruments, Memory::Fading))));
    assert_eq!(at(8, 0), Ok(Some((true, squares, Memory::Fading))));
    assert_eq!(at(9, 0), Ok(Some((true, instruments, Memory::Segment))));
    // Flags are 0 or 1, memories 0 or 2.
    for (place, byte) in [(1, 2), (2, 2), (8, 2), (16, 2), (33, 2), (9, 1), (9, 3), (1, 0xFF), (9, 0xFF)] {
        assert_eq!(at(place, byte), Err(ModelError::OutOfRange(Field::Layout)), "{place} {byte}");
    }
    for length in 0..LAYOUT.len() - 3 {
        assert_eq!(Reader(&LAYOUT[..length]).layout(), Err(ModelError::Truncated), "{length} bytes");
    }
}

#[test]
fn features_are_those_of_their_bytes_and_no_others() {
    let read = |kind, place| Reader(&[kind, place]).feature();
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
    for (kind, place, feature) in expected {
        assert_eq!(read(kind, place), Ok(feature));
    }
    for (kind, place) in [(2, 8), (3, 0xFF), (7, 8)] {
        assert_eq!(read(kind, place), Err(ModelError::OutOfRange(Field::Feature)), "{kind} {place}");
    }
    for kind in [10, 0xFF] {
        assert_eq!(read(kind, 0), Err(ModelError::Version { given: 12, supported: 11 }), "{kind}");
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
            load: None,
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
    payload.floats(3 + 2 + 5); // from 7: scales; 10: nominal; 12: deviation, fading, floor, Huber, rest
    payload.half(); // 17: settle
    payload.half(); // 18: handover
    payload.floats(7); // from 19: lags of current, velocity, load; interval; gain, damping, rate of the filter
    payload.byte(); // 26: rows
    payload.half(); // 27: settle
    payload.floats(6); // from 28: sign, Stribeck, usual velocity, usual load, spread, deviation
    payload.half(); // 34: rows of its own
    payload.floats(8 + TERMS + TERMS); // from 35: scales; 43: nominal; 50: prior
    payload.bytes.extend(0.25_f32.to_le_bytes()); // largest change of the motion
    payload.word(); // 57: order
    payload.floats(MAX_HARMONICS + 4); // from 58: weights; 61: slip; 62: needed score; 63, 64: limits of the smallest
    payload.word();
    payload.word();
    payload.word();
    payload.word(); // 65 to 68: controls
    payload.byte(); // 69: width of a cell
    payload.floats(4); // from 70: slip, slowest, pole, high-pass
    let mut reader = Reader(&payload.bytes);
    // The classifier is missing.
    assert_eq!(read(&mut reader, small()).err(), Some(ModelError::Truncated));
    assert!(reader.0.is_empty());
    classifier(&mut payload);
    let constants = read(&mut Reader(&payload.bytes), small()).expect("numbers");
    let sampling = Sampling { interval_s: 1.0, park: Some(Park::Thesis), block_mean: 2, segment_samples: 3 };
    assert_eq!(constants.sampling, sampling);
    let channel = &constants.channels[0];
    assert_eq!((channel.name.as_str(), channel.unit.as_str()), ("velocity", "rad/s"));
    assert_eq!((channel.limit, channel.saturation, channel.stuck_samples), (4.0, 5.0, 6));
    let regression = &constants.regression[0];
    assert_eq!((&regression.scale[..], &regression.nominal[..]), (&from::<3>(7)[..], &from::<2>(10)[..]));
    let Forgetting { lambda, floor } = regression.forgetting;
    assert_eq!([regression.deviation, lambda, floor, regression.huber, regression.rest], from(12));
    assert_eq!((regression.settle, regression.handover), (17, 18));
    let ShaftConstants { lags, balance, tracking } = &constants.shaft[0];
    let StateVariable { gain, damping, rate_per_s } = balance.filter;
    let Lags { current, velocity, load } = *lags;
    assert_eq!([current, velocity, load, balance.interval_s, gain, damping, rate_per_s], from(19));
    assert_eq!((balance.row_interval, balance.settle, balance.own_from_rows), (26, 27, 34));
    let velocities = [balance.sign_velocity_rad_s, balance.stribeck_velocity_rad_s, balance.usual_velocity_rad_s];
    assert_eq!(velocities, from(28));
    assert_eq!([balance.usual_load_nm, balance.row_spread, balance.deviation], from(31));
    assert_eq!((balance.scale, balance.nominal, balance.prior), (from(35), from(43), from(50)));
    assert_eq!(balance.largest_change_rad, 0.25);
    let order = &tracking.orders[0];
    assert_eq!((order.order_q16, order.weights, order.slip_ratio), (57, from(58), 61.0));
    assert_eq!([order.needed_score, order.most_relative, order.most_a], from(62));
    let blocks = &tracking.blocks;
    assert_eq!((blocks.controls.to_vec(), blocks.cell_turns_log2), ([65, 66, 67, 68].to_vec(), 69));
    assert_eq!([blocks.slip, blocks.slowest_rad_s, blocks.pole, blocks.high_pass], from(70));
    let EvidenceConstants { bet, limit, cap, segments_a_run, log_mean, defect_log_mean } = constants.evidence;
    assert_eq!(([bet, limit, cap], segments_a_run, [log_mean, defect_log_mean]), (from(263), 266, from(267)));
    assert_eq!(constants.labels.iter().map(Label::as_str).collect::<Vec<_>>(), ["good", "spall"]);
}

/// Numbers from 71 on.
fn classifier(payload: &mut Payload) {
    payload.bytes.extend([8, 0, 5, 0]); // the features
    payload.bytes.extend([9, 0]); // the covariate
    payload.floats(4); // from 71: centre, low, high, usual
    payload.floats(4); // from 75: map of the covariate, two numbers a feature
    payload.floats(2 + 2 + 2); // from 79: matrix; 81: means; 83: usual values
    payload.floats(2 + 1 + 2 + 4 + 1); // from 85: means; 87: factor; 88: priors; 90: costs; 94: of a rejection
    payload.bytes.push(1); // the healthy class
    payload.floats(1 + 1 + 2 * KNOTS + 1); // from 95: mean; 96: factor; 97: law; 145: limit
    payload.floats(2 + 2 * 2); // 146: freedom; 147: acceptable; from 148: falls and reaches
    payload.floats(2 * 2 * KNOTS); // from 152: two laws
    payload.floats(2); // from 248: segments of a usual run, margin
    payload.bytes.extend([3, 4]); // runs that are learned
    payload.bytes.extend([7, 1]); // the coordinate of the direction, and that it is an order
    for place in 1..=4 {
        payload.bytes.push(place);
        payload.floats(1); // from 250: weight in the background
    }
    payload.floats(6); // from 254: centre, and the law
    payload.floats(3); // from 260: bet, limit, cap
    payload.word(); // 263: segments a run
    payload.floats(2); // from 264: means of the logarithms
    payload.text("good", 16);
    payload.text("spall", 16);
}

#[test]
fn numbers_of_classifier_and_alarm_are_in_the_order_of_the_format() {
    let mut payload = Payload { count: 70, ..Payload::default() };
    classifier(&mut payload);
    let classifier = read_classifier(&mut Reader(&payload.bytes), small()).expect("numbers");
    assert_eq!(classifier.features, [Feature::ChannelMean(0), Feature::OrderScore(0)]);
    let Covariate { feature, centre, low, high, usual } = classifier.covariates.list[0];
    assert_eq!((feature, [centre, low, high, usual]), (Feature::ChannelRms(0), from(71)));
    assert_eq!(classifier.covariates.map, [[75.0, 76.0], [77.0, 78.0]]);
    let Projection { matrix, mean, usual } = &classifier.projection;
    assert_eq!((&matrix[..], &mean[..], &usual[..]), (&from::<2>(79)[..], &from::<2>(81)[..], &from::<2>(83)[..]));
    let Discriminant { means, factors, log_prior, costs, reject_cost } = &classifier.discriminant;
    assert_eq!(
        (&means[..], &factors[..], &log_prior[..]),
        (&from::<2>(85)[..], &from::<1>(87)[..], &from::<2>(88)[..])
    );
    assert_eq!((&costs[..], *reject_cost), (&from::<4>(90)[..], 94.0));
    let Novelty { class, mean, factor, knots, limit, freedom, laws, directions, rises, acceptable } =
        &classifier.novelty;
    assert_eq!((*class, &mean[..], &factor[..]), (Some(1), &from::<1>(95)[..], &from::<1>(96)[..]));
    assert_eq!((*knots, *limit, *freedom), (law(97), 145.0, 146.0));
    assert_eq!(
        (*acceptable, &rises[..]),
        (147.0, &[Rise { fall: 148.0, reach: 149.0 }, Rise { fall: 150.0, reach: 151.0 }][..])
    );
    assert_eq!(laws[..], [law(152), law(152 + 48)]);
    assert_eq!((directions.usual_segments, directions.margin, directions.most_runs), (248.0, 249.0, 0x0403));
    let background = |k: u8| Background { coordinate: k, weight: 249.0 + f32::from(k) };
    let expected = crate::decide::Direction {
        coordinate: 7,
        order: true,
        background: [1, 2, 3, 4].map(background),
        centre: 254.0,
        between: 255.0,
        run: 256.0,
        segment: 257.0,
        skewness: 258.0,
        correlation: 259.0,
    };
    assert_eq!(directions.list, [expected]);
}
