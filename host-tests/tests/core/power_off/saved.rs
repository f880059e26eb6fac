//! The saved state of the alarm: it continues as if power had not failed, and nothing altered passes.

use bearing_watch::alarm::{SilenceLimits, StateError};
use bearing_watch::model::{EvidenceConstants, Novelty};
use bearing_watch::plan::Plan;
use bearing_watch::{Alarm, Decision, Evidence, Model, Reason};

use crate::exported::{Drive, MODEL};

/// The exported model with a gate and an alarm, which it does not have.
pub fn alarming() -> Model<Drive> {
    let mut constants = MODEL.constants().clone();
    constants.evidence = EvidenceConstants { bet: 0.2, limit: 9.0, cap: 4.0, segments_a_run: 2, ..constants.evidence };
    let factor = core::array::from_fn(|k| constants.classifier.discriminant.factors[k]);
    let knots = core::array::from_fn(|k| [2.0 * k as f32, k as f32]);
    let novelty = constants.classifier.novelty.clone();
    constants.classifier.novelty = Novelty { class: Some(0), factor, knots, limit: 4.6, ..novelty };
    Model::new(MODEL.plan(), constants).expect("a good model")
}

/// A decision whose distance grows.
fn decision<P: Plan>(model: &Model<P>, k: u32) -> Decision<P> {
    let classes = usize::from(model.plan().layout().classes);
    let likelihoods: Vec<f32> = (0..classes).map(|class| 0.1 * (k % 7) as f32 - 0.3 * class as f32).collect();
    let classifier = &model.constants().classifier;
    classifier.decide(model.plan(), &likelihoods, 1.0 + 0.2 * k as f32).expect("finite")
}

/// Evidence after so many segments, every fifth of them undetermined.
pub fn evidence_after<P: Plan>(model: &Model<P>, segments: u32) -> Evidence<P> {
    let mut evidence = Evidence::new(model);
    for k in 0..segments {
        evidence.observe((k % 5 != 4).then(|| decision(model, k)).as_ref());
    }
    evidence
}

fn saved<P: Plan>(model: &Model<P>, evidence: &Evidence<P>) -> Vec<u8> {
    let length = Evidence::saved_len(model);
    let mut bytes = vec![0xA5; length + 3];
    assert_eq!(evidence.save(model, &mut bytes), Ok(length));
    assert_eq!(&bytes[length..], [0xA5; 3]);
    bytes.truncate(length);
    bytes
}

#[test]
fn a_restored_alarm_continues_as_the_saved_one() {
    let model = alarming();
    for segments in [0, 1, 3, 4, 7, 40, 41] {
        let mut own = evidence_after(&model, segments);
        let mut other = Evidence::new(&model);
        assert_eq!(other.restore(&model, &saved(&model, &own)), Ok(()));
        assert_eq!(other, own, "{segments}");
        for k in segments..segments + 60 {
            let decision = decision(&model, k / 2);
            assert_eq!(own.observe(Some(&decision)), other.observe(Some(&decision)));
        }
        assert_eq!(own, other);
        assert!(own.alarm().is_some());
    }
    let Some(Alarm { segment, .. }) = evidence_after(&model, 60).alarm() else { panic!("no alarm") };
    println!("alarm at segment {segment}");
}

/// Refuses to restore these bytes, and changes nothing.
fn refusal<P: Plan>(model: &Model<P>, bytes: &[u8]) -> StateError {
    let mut evidence = evidence_after(model, 5);
    let before = evidence.clone();
    let error = evidence.restore(model, bytes).expect_err("altered");
    assert_eq!(evidence, before);
    error
}

#[test]
fn altered_bytes_other_models_and_other_lengths_are_refused() {
    let model = alarming();
    let bytes = saved(&model, &evidence_after(&model, 40));
    for place in 0..bytes.len() * 8 {
        let mut other = bytes.clone();
        other[place / 8] ^= 1 << (place % 8);
        refusal(&model, &other);
    }
    for length in 0..bytes.len() {
        let error = refusal(&model, &bytes[..length]);
        assert!(matches!(error, StateError::NotAState | StateError::Truncated), "{length}: {error}");
    }
    assert_eq!(refusal(&model, &[&bytes[..], &[0]].concat()), StateError::Truncated);
    assert_eq!(refusal(&model, b"BWMD and so on"), StateError::NotAState);
    let error = Evidence::new(&MODEL).restore(&MODEL, &bytes);
    assert_eq!(error, Err(StateError::OtherModel { saved: model.id(), expected: MODEL.id() }));
    let mut short = vec![0; Evidence::saved_len(&model) - 1];
    assert_eq!(Evidence::new(&model).save(&model, &mut short), Err(StateError::BufferTooSmall));
}

/// The bytes with another word behind the header, and the checksum that fits.
fn with_word(bytes: &[u8], place: usize, word: u32) -> Vec<u8> {
    let mut other = bytes.to_vec();
    other[16 + 4 * place..][..4].copy_from_slice(&word.to_le_bytes());
    let end = other.len() - 4;
    let mut crc = u32::MAX;
    for byte in &other[..end] {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = (crc >> 1) ^ (0xEDB8_8320 * (crc & 1)));
    }
    other[end..].copy_from_slice(&(!crc).to_le_bytes());
    other
}

#[test]
fn numbers_that_a_state_cannot_have_are_refused() {
    let model = alarming();
    let bytes = saved(&model, &evidence_after(&model, 40));
    let layout = model.plan().layout();
    let classes = usize::from(layout.classes);
    let words = (bytes.len() - 20) / 4;
    // A float must be finite, and no count or code is so large.
    for place in 5..words {
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(refusal(&model, &with_word(&bytes, place, bad.to_bits())), StateError::Value, "{place}");
        }
    }
    // More undetermined segments, a longer run than segments; an alarm of no class, of the healthy one, of the future.
    for (place, bad) in [(1, 41), (2, 41), (3, 2), (3, 2 + classes as u32), (3, u32::MAX), (4, 0), (4, 41)] {
        assert_eq!(refusal(&model, &with_word(&bytes, place, bad)), StateError::Value, "{place} {bad}");
    }
}

#[test]
fn numbers_that_segments_of_this_model_cannot_leave_are_refused() {
    let model = alarming();
    let classes = usize::from(model.plan().layout().classes);
    let quiet = saved(&model, &evidence_after(&model, 3));
    let loud = saved(&model, &evidence_after(&model, 40));
    assert!(evidence_after(&model, 3).alarm().is_none() && evidence_after(&model, 40).alarm().is_some());
    let float = |x: f32| x.to_bits();
    let (novelty, defect, support) = (5, 5 + 2 + 2, 5 + 2 + 2 * classes);
    let cases = [
        ("a score above the limit without an alarm", &quiet, novelty, float(9.5)),
        ("a score that so few segments cannot have", &loud, novelty, float(1e30)),
        ("a negative score", &quiet, defect, float(-1.0)),
        ("a score of the healthy class", &quiet, 7, float(1.0)),
        ("a sum of a run that has no segment", &loud, novelty + 1, float(-1.0)),
        ("support above the likeliest", &quiet, support + 1, float(0.5)),
        ("support of the healthy class", &quiet, support, float(-0.5)),
        ("support below what segments can leave", &quiet, support + 1, float(-1e6)),
        ("a run as long as a whole one", &quiet, 2, 2),
        ("an alarm that was raised before the first segment", &loud, 4, 0),
    ];
    for (what, bytes, place, word) in cases {
        assert_eq!(refusal(&model, &with_word(bytes, place, word)), StateError::Value, "{what}");
    }
    // The state of a run that is not over is good as it is.
    let (mut evidence, open) = (Evidence::new(&model), evidence_after(&model, 4));
    assert_eq!(evidence.restore(&model, &saved(&model, &open)), Ok(()));
    assert_eq!(evidence, open);
}

#[test]
fn a_silence_goes_on_after_power_off() {
    let model = alarming();
    let silent = |evidence: &mut Evidence<Drive>| {
        evidence.limit_silence(SilenceLimits { segments: 6, hours: 0.0 });
        (0..4).for_each(|_| _ = evidence.observe_outcome(Err(Reason::Stuck { channel: 2 })));
        evidence.silence()
    };
    let mut quiet = Evidence::new(&model);
    assert_eq!(silent(&mut quiet), None);
    let mut other = Evidence::new(&model);
    assert_eq!(other.restore(&model, &saved(&model, &quiet)), Ok(()));
    let silence = silent(&mut other).expect("eight segments");
    assert_eq!((silence.segments, silence.with_reason, silence.reason), (8, 8, Some(Reason::Stuck { channel: 2 })));
}
