//! Frames: what is sent arrives bit for bit, and of a disturbed line nothing wrong is taken for right.

#[path = "../../../examples/support/classifier.rs"]
mod classifier;
#[path = "../../../target-tests/examples/support/directed.rs"]
mod directed;
#[path = "../../../target-tests/examples/support/directed_reports.rs"]
mod directed_reports;
#[path = "../../../target-tests/examples/support/law.rs"]
mod law;
#[path = "../../../examples/support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "only its constants are used")]
#[path = "../../../examples/support/refined.rs"]
mod refined;
#[path = "../../../examples/support/sender.rs"]
mod sender;
#[allow(dead_code, reason = "only a model and its plant are used")]
#[path = "../../../target-tests/examples/support/shaft.rs"]
mod shaft;

use crate::exported::MODEL;
use crate::standard_rig;
use bearing_watch::alarm::Contribution;
use bearing_watch::drive::{PhaseCounts, Position, RawSample};
use bearing_watch::model::Feature;
use bearing_watch::plan::Signals;
use bearing_watch::telemetry::{
    Body, Decoder, Encoder, Frame, LinkStats, RawEncoder, RawRecorder, Recorder, Source, TooSmall,
};
use bearing_watch::{Angle, Cause, Detector, Evidence, Verdict};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Frames of the example, and the bits of its samples.
fn sent() -> (Vec<Vec<u8>>, Vec<[u32; 3]>) {
    let mut frames = Vec::new();
    sender::run(|frame| frames.push(frame.to_vec())).expect("frames fit");
    let bits = |sample| [0, 1, 2].map(|channel| Signals::value(&sample, channel).to_bits());
    (frames, standard_rig::samples().map(bits).collect())
}

/// Number of a sample in the recording: the sender skips one number between traces.
fn place(number: u32) -> usize {
    (number - number / (sender::TRACE + 1)) as usize
}

#[test]
fn samples_and_reports_arrive_as_they_were() {
    let (frames, samples) = sent();
    let mut monitor = Detector::new(&MODEL);
    let mut evidence = Evidence::new(&MODEL);
    let mut reports = standard_rig::samples().filter_map(|sample| {
        let report = monitor.step(&sample)?;
        monitor.restart();
        evidence.observe(report.decision.as_ref());
        Some((report, evidence.score()))
    });
    let mut decoder = Decoder::<512>::new();
    let (mut next, mut hellos, mut longest) = (0, 0, [0; 2]);
    for frame in &frames {
        let (last, before) = frame.split_last().expect("a frame");
        assert!(before.iter().all(|byte| decoder.push(*byte).is_none()));
        match decoder.push(*last).expect("a frame").body {
            Body::Hello(hello) => {
                hellos += 1;
                longest[0] = frame.len();
                let channels: Vec<_> = hello.channels().collect();
                assert_eq!(channels[1..], [("velocity_ref_rad_s", "rad/s"), ("load_torque_nm", "N·m")]);
                assert_eq!(hello.classes().collect::<Vec<_>>(), ["healthy", "spall", "roughness"]);
                assert_eq!(hello.features().last(), Some(Some(Feature::Parameter(4))));
                assert_eq!((hello.interval_s, hello.segment_samples, hello.block_mean), (0.002, 5000, 1));
                assert_eq!((hello.with_angle, hello.healthy, hello.source.session), (false, None, 1));
            }
            Body::Samples(block) => {
                for k in 0..block.len() {
                    let found = [0, 1, 2].map(|channel| block.value(k, channel).expect("a value").to_bits());
                    assert_eq!(place(block.first + k as u32), next);
                    assert_eq!(found, samples[next]);
                    next += 1;
                }
            }
            Body::Raw(block) => panic!("the example sends none: {block:?}"),
            Body::Report(summary) => {
                longest[1] = frame.len();
                let (report, score) = reports.next().expect("a report");
                let decision = report.decision.as_ref().expect("a decision");
                assert_eq!(
                    (summary.verdict, summary.counts, summary.rows),
                    (report.verdict, report.counts, report.rows)
                );
                assert_eq!((summary.segment as usize, summary.score), (next / 5000, score));
                assert_eq!(summary.posteriors.iter().collect::<Vec<_>>(), decision.posteriors());
                assert_eq!(summary.features.iter().collect::<Vec<_>>(), report.estimate().expect("estimate").delta());
                assert!(summary.order_scores.is_empty() && summary.alarm.is_none());
            }
        }
    }
    assert_eq!((next, hellos, reports.next()), (15_000, 3, None));
    assert_eq!(decoder.counts(), LinkStats { frames: frames.len() as u32, ..LinkStats::default() });
    println!("bytes of a frame: hello {}, report of 3 classes and 5 features {}", longest[0], longest[1]);
    assert_eq!(longest, [137, 112]);
}

/// The hello of the example, put together by hand from the list of the module's documentation.
#[test]
fn the_format_is_the_documented_one() {
    let fields = [1_u32.to_le_bytes(), 1_u32.to_le_bytes(), 0.002_f32.to_le_bytes()].concat();
    let lists =
        [&[1, 0, 0x88, 0x13, 0, 0, 3, 0, 3, 0, 5, 5, 0][..], &[0, 0, 0, 1, 0, 2, 0, 3, 0, 4], &[255, 1, 2, 255, 255]]
            .concat();
    let texts = "current_a\0A\0velocity_ref_rad_s\0rad/s\0load_torque_nm\0N·m\0healthy\0spall\0roughness\0";
    let content = [fields, lists, texts.as_bytes().to_vec()].concat();
    let stream = crc32(&content);
    let mut whole = [&[3, 0][..], &stream.to_le_bytes(), &0_u32.to_le_bytes(), &content].concat();
    whole.extend(crc32(&whole).to_le_bytes());
    assert_eq!(sent().0[0], stuffed(&whole));
}

/// Raw samples put together by hand, as the module's documentation has them.
#[test]
fn the_format_of_raw_samples_is_the_documented_one() {
    let source = Source { model_id: 5, session: 9 };
    let mut recorder = RawRecorder::<1, 100>::new(8000.0);
    let angle = Position::Absolute(Angle::from_bits(0x8000_0001));
    let three = RawSample { number: 300, currents: PhaseCounts::Three([1, 258, 3]), position: angle, further: [0.5] };
    let two = RawSample { number: 301, currents: PhaseCounts::Two([4, 5]), position: Position::Missing, ..three };
    assert!(!recorder.push(&three) && !recorder.push(&two));
    let mut buffer = [0; 100];
    let mut encoder = RawEncoder::new(source);
    let frame = encoder.raw(&recorder.block(), &mut buffer).expect("fits").to_vec();
    let stream = crc32(&[5, 0, 0, 0, 9, 0, 0, 0]);
    let fields = [&300_u32.to_le_bytes()[..], &8000_f32.to_le_bytes(), &[0, 1]].concat();
    let samples = [
        &[1, 0, 2, 1, 3, 0, 0, 0, 1, 0, 0, 0x80][..],
        &0.5_f32.to_le_bytes(),
        &[4, 0, 5, 0, 0, 0, 3, 0, 0, 0, 0, 0],
        &0.5_f32.to_le_bytes(),
    ];
    let mut whole = [&[3, 3][..], &stream.to_le_bytes(), &0_u32.to_le_bytes(), &fields, &samples.concat()].concat();
    whole.extend(crc32(&whole).to_le_bytes());
    assert_eq!(frame, stuffed(&whole));
    // Beside a model they are frames of its stream.
    let mut encoder = Encoder::new(&MODEL, source);
    let mut decoder = Decoder::<200>::new();
    let mut line = encoder.hello(&mut [0; 200]).expect("fits").to_vec();
    line.extend_from_slice(encoder.raw(&recorder.block(), &mut buffer).expect("fits"));
    let arrived = |byte: &u8| decoder.push(*byte).map(|frame| (frame.stream, frame.sequence));
    let found: Vec<(u32, u32)> = line.iter().filter_map(arrived).collect();
    assert_eq!((found.len(), found[0].0 == found[1].0, found[1].1), (2, true, 1));
}

/// CRC-32/ISO-HDLC bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    })
}

/// COBS of bytes with fewer than 254 between zeros: each zero becomes the distance to the next.
fn stuffed(bytes: &[u8]) -> Vec<u8> {
    let parts = bytes.split(|byte| *byte == 0);
    let each = parts.flat_map(|part| std::iter::once(part.len() as u8 + 1).chain(part.iter().copied()));
    each.chain([0]).collect()
}

#[test]
fn orders_and_angles_arrive_too() {
    let model = &shaft::MODEL;
    let mut plant = shaft::Plant::new(3);
    let mut detector = Detector::new(model);
    let mut evidence = Evidence::new(model);
    let mut encoder = Encoder::new(model, Source { model_id: 0xFFFF_FFFF, session: 0 });
    let mut recorder = Recorder::<_, 800>::new(model.plan());
    let mut decoder = Decoder::<1000>::new();
    let mut buffer = [0; 1000];
    let mut receive = |bytes: &[u8], check: &mut dyn FnMut(Body<'_>)| {
        let (last, before) = bytes.split_last().expect("a frame");
        assert!(before.iter().all(|byte| decoder.push(*byte).is_none()));
        check(decoder.push(*last).expect("a frame").body);
    };
    receive(encoder.hello(&mut buffer).expect("fits"), &mut |body| {
        let Body::Hello(hello) = body else { panic!("{body:?}") };
        let trained: Vec<f32> = shaft::ORDERS.iter().map(|order| order.order()).collect();
        assert_eq!(hello.orders.iter().collect::<Vec<_>>(), trained);
        assert!(hello.with_angle && hello.healthy == Some(0));
        let features: Vec<Feature> = hello.features().flatten().collect();
        assert_eq!(features, model.constants().classifier.features);
    });
    let (mut samples, mut reports) = (Vec::<shaft::Sample>::new(), 0);
    for _ in 0..4000 {
        let sample: shaft::Sample = plant.motion().into();
        samples.push(sample);
        if recorder.push(&sample) {
            receive(encoder.samples(&recorder.block(), &mut buffer).expect("fits"), &mut |body| {
                let Body::Samples(block) = body else { panic!("{body:?}") };
                for k in 0..block.len() {
                    let own = &samples[block.first as usize + k];
                    assert_eq!(block.angle(k), Some(own.angle));
                    let same =
                        |channel| block.value(k, channel).map(f32::to_bits) == Some(own.value(channel).to_bits());
                    assert!((0..4).all(same));
                }
            });
            recorder.clear();
        }
        if let Some(report) = detector.step(&sample) {
            evidence.observe(report.decision.as_ref());
            let bytes = encoder.report(&report, &evidence, &mut buffer).expect("fits");
            reports += 1;
            if reports == 2 {
                println!("bytes of a report of 3 classes, 9 features and 4 orders: {}", bytes.len());
            }
            receive(bytes, &mut |body| {
                let Body::Report(summary) = body else { panic!("{body:?}") };
                let orders = report.shaft().expect("a shaft").orders();
                let scores: Vec<f32> = orders.iter().map(|order| order.score).collect();
                assert_eq!(summary.order_scores.iter().collect::<Vec<_>>(), scores);
                assert_eq!((summary.features.len(), summary.verdict), (9, report.verdict));
            });
        }
    }
    assert_eq!(reports, 2);
}

#[test]
fn a_missing_feature_is_nan_and_a_reason_comes_back() {
    let mut detector = Detector::new(&MODEL);
    let mut evidence = Evidence::new(&MODEL);
    let report = detector.finish();
    evidence.observe(report.decision.as_ref());
    let mut buffer = [0; 512];
    let mut encoder = Encoder::new(&MODEL, Source::default());
    let bytes = encoder.report(&report, &evidence, &mut buffer).expect("fits");
    let mut decoder = Decoder::<512>::new();
    let mut found = 0;
    for byte in bytes {
        let Some(frame) = decoder.push(*byte) else { continue };
        let Body::Report(summary) = frame.body else { panic!("{frame:?}") };
        assert!(matches!(summary.verdict, Verdict::Undetermined(_)) && summary.verdict == report.verdict);
        assert!(summary.features.iter().all(f32::is_nan) && summary.features.len() == 5);
        assert_eq!((summary.posteriors.len(), summary.undetermined, summary.segment), (0, 1, 1));
        found += 1;
    }
    assert_eq!(found, 1);
}

#[test]
fn a_buffer_too_small_costs_no_number() {
    let mut encoder = Encoder::new(&MODEL, Source::default());
    let mut whole = [0; 512];
    let length = encoder.clone().hello(&mut whole).expect("fits").len();
    for short in 0..length {
        assert_eq!(encoder.hello(&mut whole[..short]).err(), Some(TooSmall));
    }
    let exact = encoder.hello(&mut whole[..length]).expect("fits").to_vec();
    let mut decoder = Decoder::<512>::new();
    let sequence = exact.iter().find_map(|byte| decoder.push(*byte).map(|frame| frame.sequence));
    assert_eq!(sequence, Some(0));
}

/// A line that disturbs what it carries.
fn disturbed(frames: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut line = Vec::new();
    for frame in frames {
        let copies = if random.random_bool(0.02) { 2 } else { 1 };
        for _ in 0..copies {
            let cut = if random.random_bool(0.01) { random.random_range(0..frame.len()) } else { frame.len() };
            for byte in &frame[..cut] {
                match random.random_range(0..4000) {
                    0 => line.push(byte ^ (1 << random.random_range(0..8))),
                    1 => {}
                    2 => line.extend([*byte; 2]),
                    3 => line.push(random.random()),
                    _ => line.push(*byte),
                }
            }
        }
    }
    line
}

#[test]
fn a_disturbed_line_is_counted_and_nothing_wrong_arrives() {
    let (frames, samples) = sent();
    let mut total = LinkStats::default();
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (last, middle) = frames[1..].split_last().expect("frames");
        let mut line = frames[0].clone();
        line.extend(disturbed(middle, &mut random));
        line.push(0);
        line.extend(last);
        let mut decoder = Decoder::<512>::new();
        for byte in line {
            let Some(frame) = decoder.push(byte) else { continue };
            if let Body::Samples(block) = frame.body {
                for k in 0..block.len() {
                    let found = [0, 1, 2].map(|channel| block.value(k, channel).expect("a value").to_bits());
                    assert_eq!(found, samples[place(block.first + k as u32)], "seed {seed}");
                }
            }
        }
        let counts = decoder.counts();
        assert_eq!(counts.frames + counts.lost, frames.len() as u32, "seed {seed}: {counts:?}");
        assert_eq!(counts.unknown, 0, "no damaged frame has a right checksum");
        total.bad += counts.bad;
        total.lost += counts.lost;
        total.repeated += counts.repeated;
        total.frames += counts.frames;
    }
    println!("{} frames, of which {total:?}", 20 * frames.len());
    // Of 7620 frames of about 500 bytes and an error each 1000 bytes, four in ten are damaged; two in a hundred come
    // twice.
    assert!((1500..4500).contains(&total.lost) && total.bad > 1000 && (30..200).contains(&total.repeated), "{total:?}");
}

#[test]
fn random_bytes_are_no_frames() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut decoder = Decoder::<64>::new();
    let bytes = 400_000_u32;
    for k in 0..bytes {
        // Runs with many zeros, with small distances between them, and without a preference.
        let byte = match k / 1000 % 3 {
            0 => random.random_range(0..4),
            1 => random.random_range(0..20),
            _ => random.random(),
        };
        assert!(decoder.push(byte).is_none());
    }
    let LinkStats { frames, bad, oversize, unknown, lost, repeated } = decoder.counts();
    assert_eq!([frames, unknown, lost, repeated], [0; 4]);
    assert!(bad > 10_000 && oversize > 100 && bad + oversize < bytes, "{bad} {oversize}");
}

/// Lets a decoder take a frame.
fn receive(decoder: &mut Decoder<512>, frame: &[u8], look: &mut dyn FnMut(Frame<'_>)) {
    for byte in frame {
        if let Some(frame) = decoder.push(*byte) {
            look(frame);
        }
    }
}

/// Reports say which direction has risen, by how much and since when.
#[test]
fn contributions_arrive_as_the_evidence_has_them() {
    let mut encoder = Encoder::new(&directed::MODEL, Source::default());
    let (mut decoder, mut buffer) = (Decoder::<512>::new(), [0; 512]);
    let (mut reports, mut raised, mut longest) = (0, None, 0);
    directed_reports::run(|report, evidence| {
        let frame = encoder.report(report, evidence, &mut buffer).expect("fits");
        longest = longest.max(frame.len());
        receive(&mut decoder, frame, &mut |frame| {
            let Body::Report(summary) = frame.body else { panic!("{frame:?}") };
            let expected: Vec<(u8, Contribution)> =
                (0..5).map(|k| (k, evidence.contribution(k).expect("a direction"))).collect();
            assert_eq!(summary.contributions.iter().collect::<Vec<_>>(), expected);
            assert_eq!((summary.alarm, summary.risen), (evidence.alarm(), evidence.main_contribution()));
            if let (Some(alarm), None) = (summary.alarm, raised) {
                raised = Some((alarm, summary.risen.expect("a direction")));
            }
            reports += 1;
        });
    });
    println!("bytes of a report of 1 class, 5 features and 5 directions: {longest}");
    assert_eq!(reports, directed_reports::RUNS * directed_reports::RUN);
    let (alarm, risen) = raised.expect("an alarm");
    let before = directed_reports::RISES.1 * directed_reports::RUN;
    assert_eq!((alarm.cause, risen.direction, risen.since), (Cause::Coordinate(2), 2, before));
    // Two runs, as one is never enough.
    assert!(alarm.segment == before + 2 * directed_reports::RUN && risen.deviations > 5.0, "{alarm:?} {risen:?}");
}
