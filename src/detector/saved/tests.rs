//! A state that is saved and read by the small drive, and bytes that are none of its states.

use std::vec::Vec;

use super::*;
use crate::alarm::{EvidenceConstants, SilenceLimits};
use crate::decide::{Decision, Novelty};
use crate::reason::Reason;
use crate::tests::{Drive, MODEL};

/// The drive's model with a gate around its first class, and with an alarm.
fn model() -> Model<Drive> {
    let mut constants = MODEL.constants().clone();
    let novelty = constants.classifier.novelty;
    let knots = core::array::from_fn(|k| [2.0 * k as f32, k as f32]);
    constants.classifier.novelty =
        Novelty { class: Some(0), mean: [0.5], factor: [0.0025], knots, limit: 4.6, ..novelty };
    constants.evidence = EvidenceConstants { bet: 0.2, limit: 9.0, cap: 4.0, ..constants.evidence };
    Model::new(Drive, constants).unwrap()
}

/// After three healthy segments with a surprise below all scores, and two without a verdict.
fn evidence(model: &Model<Drive>) -> Evidence<Drive> {
    let mut evidence = Evidence::new(model);
    let decision: Decision<Drive> = model.constants().classifier.decide(Drive, &[0.0, -9.0], 0.5).unwrap();
    (0..3).for_each(|_| _ = evidence.observe(Some(&decision)));
    (0..2).for_each(|_| _ = evidence.observe_outcome(Err(Reason::Stuck { channel: 1 })));
    evidence
}

/// The bytes, in a buffer that was in use.
fn saved(model: &Model<Drive>) -> Vec<u8> {
    let mut bytes = Vec::from([0xA5; 200]);
    let length = evidence(model).save(model, &mut bytes).unwrap();
    bytes.truncate(length);
    bytes
}

/// The content with a checksum that fits.
fn checked(content: &[u8]) -> Vec<u8> {
    [content, &crc32(content).to_le_bytes()].concat()
}

/// The bytes with another one at a place, under a checksum that fits.
fn with(bytes: &[u8], index: usize, byte: u8) -> Vec<u8> {
    let mut content = bytes[..bytes.len() - 4].to_vec();
    content[index] = byte;
    checked(&content)
}

/// The error, after which nothing has changed.
fn refusal(model: &Model<Drive>, bytes: &[u8]) -> StateError {
    let mut evidence = Evidence::new(model);
    let before = evidence.clone();
    let error = evidence.restore(model, bytes).unwrap_err();
    assert_eq!(evidence, before, "{error:?}");
    error
}

/// Of header and words of two classes without directions: counts, alarm, scores, support, silence, what raised the
/// alarm, and runs learned.
const HEAD: usize = 16;
const SCORES: usize = HEAD + 4 * 5;
const MAIN: usize = SCORES + 4 * (2 + 3 * 2 + 3);

#[test]
fn header_and_counts_are_where_the_format_has_them() {
    let model = model();
    let bytes = saved(&model);
    assert_eq!(bytes.len(), MAIN + 4 * 6 + 4);
    let [i0, i1, i2, i3] = model.id().to_le_bytes();
    assert_eq!(bytes[..HEAD], [b'B', b'W', b'S', b'T', 4, 0, 0, 0, 22, 0, 0, 0, i0, i1, i2, i3]);
    assert_eq!(bytes[HEAD..HEAD + 8], [5, 0, 0, 0, 2, 0, 0, 0], "segments, and those without a verdict");
    assert_eq!(bytes, checked(&bytes[..bytes.len() - 4]));
    assert_eq!(bytes[MAIN..MAIN + 24], [0; 24], "no directions");
}

#[test]
fn the_limits_of_a_silence_are_those_of_the_program() {
    let model = model();
    let mut evidence = Evidence::new(&model);
    evidence.limit_silence(SilenceLimits { segments: 2, hours: 0.0 });
    assert_eq!(evidence.restore(&model, &saved(&model)), Ok(()));
    let silence = evidence.silence().expect("two segments without a verdict");
    assert_eq!((silence.segments, silence.reason), (2, Some(Reason::Stuck { channel: 1 })));
}

#[test]
fn each_refusal_has_its_reason() {
    let model = model();
    let bytes = saved(&model);
    let end = bytes.len();
    let mut damaged = bytes.clone();
    damaged[SCORES] ^= 1;
    assert_eq!(refusal(&model, &damaged), StateError::Checksum);
    assert_eq!(refusal(&model, &bytes[..end - 1]), StateError::Truncated);
    assert_eq!(refusal(&model, &checked(&bytes[..end - 8])), StateError::Truncated, "a word less");
    assert_eq!(refusal(&model, &checked(&[&bytes[..end - 4], &[0; 4]].concat())), StateError::Truncated, "one more");
    assert_eq!(refusal(&model, &checked(&[&bytes[..end - 4], &[0]].concat())), StateError::Truncated, "a byte more");
    assert_eq!(refusal(&model, &with(&bytes, 8, 28)), StateError::Truncated, "another number of words");
    assert_eq!(refusal(&model, &with(&bytes, 3, b'D')), StateError::NotAState);
    for given in [1, 2, 3, 5] {
        assert_eq!(refusal(&model, &with(&bytes, 4, given)), StateError::Version { given: given.into(), supported: 4 });
    }
    assert_eq!(refusal(&model, &with(&bytes, 6, 1)), StateError::Truncated, "a number that is zero");
    let (saved, expected) = (model.id(), MODEL.id());
    assert_eq!(Evidence::new(&MODEL).restore(&MODEL, &bytes), Err(StateError::OtherModel { saved, expected }));
}

#[test]
fn numbers_that_no_segments_leave_are_refused() {
    let model = model();
    let bytes = saved(&model);
    assert_eq!(refusal(&model, &with(&bytes, SCORES + 3, 0xBF)), StateError::Value, "a negative score");
    for index in MAIN..MAIN + 24 {
        assert_eq!(refusal(&model, &with(&bytes, index, 1)), StateError::Value, "{index}: without directions");
    }
}
