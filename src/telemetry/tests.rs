use super::sink::Sink;
use super::*;
use crate::alarm::Evidence;
use crate::model::Model;
use crate::plan::{Layout, Load, Memory, Method, Plan, RunTime, RunTimeSample, ShaftLayout, Structure, testing};
use crate::report::{Report, Verdict};
use crate::signal::Angle;
use crate::tests::{Drive, MODEL, report, samples};
use std::vec::Vec;

crate::plan! {
    struct Turning;
    struct Sample with angle { current_a: "A", velocity_rad_s: "rad/s" }
    layout: Layout {
        shaft: Some(ShaftLayout {
            current: current_a,
            velocity: Some(velocity_rad_s),
            load: Load::Unknown,
            orders: 1,
            harmonics: 3,
            decimation: 1,
        }),
        features: 1,
        coordinates: 1,
        classes: 1,
        ..Layout::EMPTY
    }
}

/// A frame with this content.
fn frame(header: Header, rest: &[u8]) -> Vec<u8> {
    let mut buffer = [0; 600];
    let mut sink = Sink::frame(&mut buffer);
    sink.fields(&header).unwrap();
    sink.bytes(rest).unwrap();
    let end = sink.close().unwrap();
    buffer[..=end].to_vec()
}

/// A block of samples of one channel, as fields and list.
fn block(samples: usize) -> Vec<u8> {
    let mut bytes = Vec::from([3, 0, 0, 0, 1, 0]);
    bytes.resize(6 + 4 * samples, 0);
    bytes
}

fn header(sequence: u32) -> Header {
    Header { version: VERSION, kind: SAMPLES, stream: 5, sequence }
}

#[test]
fn counts_tell_what_is_wrong() {
    let mut decoder = Decoder::<64>::new();
    let mut feed = |bytes: &[u8]| bytes.iter().filter(|byte| decoder.push(**byte).is_some()).count();
    assert_eq!(feed(&frame(header(0), &block(2))), 1);
    assert_eq!(feed(&frame(header(1), &block(30))), 0, "too long");
    for version in [VERSION - 1, VERSION + 1] {
        assert_eq!(feed(&frame(Header { version, ..header(2) }, &block(2))), 0);
    }
    assert_eq!(feed(&frame(Header { kind: 9, ..header(2) }, &block(2))), 0);
    assert_eq!(feed(&frame(header(3), &block(2)[..13])), 0, "half a sample");
    assert_eq!(feed(&frame(header(3), &[3, 0, 0, 0, 1, 7])), 0, "7 is neither false nor true");
    assert_eq!(feed(&frame(header(3), &[3, 0, 0, 0, 0, 0])), 0, "no channel");
    assert_eq!(feed(&[0, 0, 0]), 0, "nothing between zeros");
    assert_eq!(feed(&[7, 1, 2, 0]), 0, "cut short");
    assert_eq!(feed(&[1, 1, 1, 1, 1, 0]), 0, "nothing, and its checksum");
    assert_eq!(feed(&frame(header(4), &block(2))), 1);
    assert_eq!(feed(&frame(header(4), &block(2))), 0);
    let expected = LinkStats { frames: 2, bad: 5, oversize: 1, unknown: 3, lost: 3, repeated: 1 };
    assert_eq!(decoder.counts(), expected);
}

#[test]
fn no_single_wrong_bit_passes() {
    let good = frame(header(0), &block(5));
    for bit in 0..8 * good.len() {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes.push(0);
        let mut decoder = Decoder::<64>::new();
        let frames = bytes.iter().filter(|byte| decoder.push(**byte).is_some()).count();
        // A wrong last byte is no zero: the frame ends one byte late, and its checksum does not match.
        assert_eq!((frames, decoder.counts().frames), (0, 0), "bit {bit}");
        assert!(decoder.counts().bad > 0, "bit {bit}");
    }
}

#[test]
fn a_full_block_waits_and_the_next_one_shows_the_gap() {
    let mut recorder = Recorder::<_, 30>::new(Turning);
    let sample = |k: u32| Sample {
        current_a: f32::from_bits(0x7FC0_1234 + k),
        velocity_rad_s: -(k as f32),
        angle: Angle::from_bits(0xFFFF_0000 + k),
    };
    assert_eq!((0..4).map(|k| recorder.push(&sample(k))).collect::<Vec<_>>(), [false, true, true, true]);
    let whole = recorder.take();
    let block = whole.block();
    assert_eq!((block.first, block.len(), block.channels), (0, 2, 2));
    for k in 0..2_u32 {
        let (index, expected) = (k as usize, sample(k));
        assert_eq!(block.value(index, 0).unwrap().to_bits(), expected.current_a.to_bits(), "NaN keeps its bits");
        assert_eq!(block.value(index, 1), Some(expected.velocity_rad_s));
        assert_eq!(block.angle(index), Some(expected.angle));
    }
    assert_eq!((block.value(0, 2), block.value(2, 0), block.angle(2)), (None, None, None));
    assert!(!recorder.push(&sample(4)));
    assert_eq!(recorder.block().first, 4);
    recorder.skip(10);
    assert!(recorder.push(&sample(15)), "samples on both sides of a gap are not in one block");
    assert_eq!(recorder.block().len(), 1);
    recorder.clear();
    assert!(!recorder.push(&sample(16)));
    assert_eq!(recorder.block().first, 16);
}

#[test]
fn samples_that_were_passed_over_before_a_block_are_in_its_number() {
    let mut recorder = Recorder::<_, 30>::new(Turning);
    let sample = Sample { current_a: 1.0, velocity_rad_s: 2.0, angle: Angle::ZERO };
    recorder.skip(7);
    assert!(!recorder.is_complete(), "nothing is in it");
    assert_eq!([recorder.push(&sample), recorder.push(&sample)], [false, true]);
    assert_eq!((recorder.block().first, recorder.block().len()), (7, 2));
}

#[test]
fn a_sample_without_an_angle_has_none() {
    let layout = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
    let plan = RunTime::of(layout).unwrap();
    let values = |first: f32| (0..layout.channels).map(|k| first + f32::from(k)).collect::<Vec<f32>>();
    let sample = |first| RunTimeSample { values: values(first), angle: Angle::from_bits(7) };
    let bytes = 4 * usize::from(layout.channels);
    let mut recorder = Recorder::<_, 24>::new(plan);
    let fit = 24 / bytes;
    assert_eq!((0..fit).map(|k| recorder.push(&sample(10.0 * k as f32))).filter(|full| *full).count(), 1);
    let block = recorder.block();
    assert_eq!((block.len(), block.value(1, 0), block.angle(1)), (fit, Some(10.0), None));
    let mut small = Recorder::<_, 7>::new(plan);
    assert!(small.push(&sample(1.0)), "less than a sample");
    assert!(small.block().is_empty());
}

/// What a listener reads of a report: posteriors, features and scores of orders.
fn sent(report: &Report<Drive>, evidence: &Evidence<Drive>, look: impl FnOnce(Summary<'_>)) -> Option<[Vec<f32>; 3]> {
    let mut encoder = Encoder::new(&MODEL, Source { model_id: 1, session: 2 });
    let (mut buffer, mut decoder, mut lists) = ([0; 300], Decoder::<256>::new(), None);
    let mut look = Some(look);
    for byte in encoder.report(report, evidence, &mut buffer).unwrap() {
        let Some(Frame { body: Body::Report(summary), .. }) = decoder.push(*byte) else { continue };
        lists = Some([summary.posteriors, summary.features, summary.order_scores].map(|list| list.iter().collect()));
        if let Some(look) = look.take() {
            look(summary);
        }
    }
    lists
}

#[test]
fn a_report_is_what_the_detector_found() {
    let (report, mut evidence) = (report(samples(1.0)), Evidence::new(&MODEL));
    evidence.observe_outcome(report.outcome());
    let lists = sent(&report, &evidence, |summary| {
        assert_eq!((summary.segment, summary.undetermined, summary.verdict), (1, 0, Verdict::Class(1)));
        assert_eq!((summary.rows, summary.counts, summary.alarm), (report.rows, report.counts, None));
    });
    let [posteriors, features, orders] = lists.unwrap();
    // The model is y = 0.8 y₁ + u₁, whose δ-parameters are −0.2 and 1; the classes are at ½ and 1, 0.05 wide.
    assert!(posteriors.len() == 2 && posteriors[1] > 0.999 && (posteriors.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    assert!((features[0] + 0.2).abs() < 0.01 && (features[1] - 1.0).abs() < 0.01, "{features:?}");
    assert!(features.len() == 2 && orders.is_empty());
}

#[test]
fn a_report_without_a_verdict_has_a_reason_and_no_numbers_of_a_verdict() {
    let (report, mut evidence) = (Report::<Drive>::empty(MODEL.plan()), Evidence::new(&MODEL));
    evidence.observe_outcome(report.outcome());
    let lists = sent(&report, &evidence, |summary| {
        assert_eq!((summary.verdict, summary.segment, summary.undetermined), (report.verdict, 1, 1));
        assert_eq!([summary.distance, summary.distance_surprise, summary.surprise, summary.score], [0.0; 4]);
    });
    let [posteriors, features, _] = lists.unwrap();
    assert!(posteriors.is_empty() && features.len() == 2 && features.iter().all(|x| x.is_nan()), "{features:?}");
}

#[test]
fn a_report_that_goes_on_behind_its_lists_is_none() {
    let mut evidence = Evidence::new(&MODEL);
    evidence.observe(None);
    let model: &Model<Drive> = &MODEL;
    let mut content = [0; 300];
    let mut sink = Sink::frame(&mut content);
    summary::write(model, &Report::empty(model.plan()), &evidence, &mut sink).unwrap();
    let end = sink.close().unwrap();
    let mut plain = [0; 300];
    let length = cobs::decode(&content[..end], &mut plain).unwrap();
    let fields = &plain[..length - 4];
    let read = |bytes| Summary::read(bytes).is_some();
    assert!(read(fields) && !read(&plain[..length - 3]) && !read(&fields[..fields.len() - 1]));
}
