//! The saved state of alarm and baseline: it continues as if power had not failed, and nothing altered passes.

use bearing_watch::alarm::{Baseline, SilenceLimits, StateError};
use bearing_watch::model::{BaselineConstants, EvidenceConstants, Novelty};
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
    let mut decision = classifier.decide(model.plan(), &likelihoods, 1.0 + 0.2 * k as f32).expect("finite");
    decision.distance = 1.0 + 0.05 * k as f32;
    decision
}

/// Evidence after so many segments, every fifth of them undetermined.
pub fn evidence_after<P: Plan>(model: &Model<P>, segments: u32) -> Evidence<P> {
    let mut evidence = Evidence::new(model);
    for k in 0..segments {
        evidence.observe((k % 5 != 4).then(|| decision(model, k)).as_ref());
    }
    evidence
}

fn saved<P: Plan>(model: &Model<P>, evidence: &Evidence<P>, baseline: Option<&Baseline<P>>) -> Vec<u8> {
    let length = Evidence::saved_len(model);
    let mut bytes = vec![0xA5; length + 3];
    assert_eq!(evidence.save(model, baseline, &mut bytes), Ok(length));
    assert_eq!(&bytes[length..], [0xA5; 3]);
    bytes.truncate(length);
    bytes
}

fn baseline<P: Plan>(model: &Model<P>) -> Baseline<P> {
    Baseline::new(model, BaselineConstants::new(50.0, 2.0)).expect("a healthy class")
}

#[test]
fn a_restored_alarm_continues_as_the_saved_one() {
    let model = alarming();
    for segments in [0, 1, 3, 4, 7, 40, 41] {
        let mut own = evidence_after(&model, segments);
        let mut other = Evidence::new(&model);
        assert_eq!(other.restore(&model, &saved(&model, &own, None), None), Ok(()));
        assert_eq!(other, own, "{segments}");
        for k in segments..segments + 60 {
            let decision = decision(&model, k / 2);
            assert_eq!(own.observe(Some(&decision)), other.observe(Some(&decision)));
        }
        assert_eq!(own, other);
        assert!(own.alarm().is_some() && own.trend().is_some());
    }
    let Some(Alarm { segment, .. }) = evidence_after(&model, 60).alarm() else { panic!("no alarm") };
    println!("alarm at segment {segment}");
}

#[test]
fn a_baseline_is_saved_beside_the_alarm() {
    let model = alarming();
    let mut own = baseline(&model);
    // The narrowest coordinate has a deviation of 0.09, the bound is two.
    let offset: Vec<f32> = own.offset().iter().zip(1_u8..).map(|(_, k)| 0.01 * f32::from(k)).collect();
    assert!(own.restore(&offset, true));
    let bytes = saved(&model, &evidence_after(&model, 9), Some(&own));
    let (mut evidence, mut other) = (Evidence::new(&model), baseline(&model));
    assert_eq!(evidence.restore(&model, &bytes, Some(&mut other)), Ok(()));
    assert_eq!((&evidence, &other), (&evidence_after(&model, 9), &own));
    // A state without a baseline leaves it; a program without one ignores it.
    let without = saved(&model, &Evidence::new(&model), None);
    assert_eq!(without.len(), bytes.len());
    assert_eq!(evidence.restore(&model, &without, Some(&mut other)), Ok(()));
    assert_eq!((&evidence, &other), (&Evidence::new(&model), &own));
    assert_eq!(evidence.restore(&model, &bytes, None), Ok(()));
}

/// Refuses to restore these bytes, and changes nothing.
fn refusal<P: Plan>(model: &Model<P>, bytes: &[u8]) -> StateError {
    let (mut evidence, mut own) = (evidence_after(model, 5), baseline(model));
    let before = (evidence.clone(), own.clone());
    let error = evidence.restore(model, bytes, Some(&mut own)).expect_err("altered");
    assert_eq!((evidence, own), before);
    error
}

#[test]
fn altered_bytes_other_models_and_other_lengths_are_refused() {
    let model = alarming();
    let bytes = saved(&model, &evidence_after(&model, 40), Some(&baseline(&model)));
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
    let error = Evidence::new(&MODEL).restore(&MODEL, &bytes, None);
    assert_eq!(error, Err(StateError::OtherModel { saved: model.id(), expected: MODEL.id() }));
    let mut short = vec![0; Evidence::saved_len(&model) - 1];
    assert_eq!(Evidence::new(&model).save(&model, None, &mut short), Err(StateError::BufferTooSmall));
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
    let own = baseline(&model);
    let bytes = saved(&model, &evidence_after(&model, 40), Some(&own));
    let layout = model.plan().layout();
    let classes = usize::from(layout.classes);
    let words = (bytes.len() - 20) / 4;
    // Each float: counts are the first five words, the count of the trend and the flag of the baseline are whole
    // numbers.
    let trend = 5 + 2 + 3 * classes;
    let floats = (5..words).filter(|place| ![trend, trend + 4].contains(place));
    for place in floats {
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(refusal(&model, &with_word(&bytes, place, bad.to_bits())), StateError::Value, "{place}");
        }
    }
    // More undetermined segments, a longer run than segments; an alarm of no class, of the healthy one, of the future.
    for (place, bad) in [(1, 41), (2, 41), (3, 2), (3, 2 + classes as u32), (3, u32::MAX), (4, 0), (4, 41)] {
        assert_eq!(refusal(&model, &with_word(&bytes, place, bad)), StateError::Value, "{place} {bad}");
    }
    assert_eq!(refusal(&model, &with_word(&bytes, trend, u32::MAX)), StateError::Value);
    assert_eq!(refusal(&model, &with_word(&bytes, trend + 4, 2)), StateError::Value);
    assert_eq!(refusal(&model, &with_word(&bytes, trend + 3, (-1.0_f32).to_bits())), StateError::Value);
}

/// The words of a state behind its header.
fn words(bytes: &[u8]) -> Vec<u32> {
    bytes[16..bytes.len() - 4].chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().expect("four"))).collect()
}

#[test]
fn numbers_that_segments_of_this_model_cannot_leave_are_refused() {
    let model = alarming();
    let classes = usize::from(model.plan().layout().classes);
    let quiet = saved(&model, &evidence_after(&model, 3), None);
    let loud = saved(&model, &evidence_after(&model, 40), None);
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
        ("more decided segments in the trend than there are", &quiet, support + classes, 4),
        ("a run as long as a whole one", &quiet, 2, 2),
        ("an alarm that was raised before the first segment", &loud, 4, 0),
    ];
    for (what, bytes, place, word) in cases {
        assert_eq!(refusal(&model, &with_word(bytes, place, word)), StateError::Value, "{what}");
    }
    // The state of a run that is not over is good as it is.
    let (mut evidence, open) = (Evidence::new(&model), evidence_after(&model, 4));
    assert_eq!(evidence.restore(&model, &saved(&model, &open, None), None), Ok(()));
    assert_eq!(evidence, open);
}

#[test]
fn words_and_flags_without_a_meaning_are_refused() {
    let model = alarming();
    let without = saved(&model, &evidence_after(&model, 9), None);
    let baseline = baseline(&model);
    let with = saved(&model, &evidence_after(&model, 9), Some(&baseline));
    let differ = words(&without).len();
    let first = 5 + 2 + 3 * usize::from(model.plan().layout().classes) + 4;
    let coordinates = baseline.offset().len();
    for place in (first..=first + coordinates).chain(differ - 3..differ) {
        let float = 0.5_f32.to_bits();
        assert_eq!(refusal(&model, &with_word(&without, place, float)), StateError::Value, "{place}: no baseline");
    }
    let flagged = |flags: u16| {
        let mut bytes = with.clone();
        bytes[6..8].copy_from_slice(&flags.to_le_bytes());
        let word = words(&bytes)[0];
        with_word(&bytes, 0, word)
    };
    assert_eq!(flagged(1), with);
    for flags in [2, 3, 0x100, 0x8001] {
        assert_eq!(refusal(&model, &flagged(flags)), StateError::Value, "{flags}");
    }
    assert_eq!(refusal(&model, &flagged(0)), StateError::Value, "the constants of a baseline without one");
}

#[test]
fn a_baseline_beyond_its_bound_or_of_other_constants_is_refused() {
    let model = alarming();
    let mut wide = Baseline::new(&model, BaselineConstants::new(50.0, 5.0)).expect("good constants");
    let mut narrow = Baseline::new(&model, BaselineConstants::new(50.0, 1.0)).expect("good constants");
    let mut offset = vec![0.0; wide.offset().len()];
    let last = offset.len() - 1;
    // Its deviation given those before it is 0.087: 4.6 deviations.
    offset[last] = 0.4;
    assert!(wide.restore(&offset, false) && !narrow.restore(&offset, false));
    assert!(narrow.offset().iter().all(|x| *x == 0.0));
    offset[last] = 1e30;
    assert!(!wide.restore(&offset, false));
    let bytes = saved(&model, &evidence_after(&model, 9), Some(&wide));
    let mut evidence = evidence_after(&model, 5);
    let before = (evidence.clone(), narrow.clone());
    let error = evidence.restore(&model, &bytes, Some(&mut narrow));
    assert!(matches!(error, Err(StateError::Value | StateError::OtherBaseline)), "{error:?}");
    assert_eq!((&evidence, &narrow), (&before.0, &before.1));
    // Other constants under an offset that fits both.
    wide.reset();
    let bytes = saved(&model, &evidence_after(&model, 9), Some(&wide));
    assert_eq!(evidence.restore(&model, &bytes, Some(&mut narrow)), Err(StateError::OtherBaseline));
    assert_eq!(evidence.restore(&model, &bytes, Some(&mut wide)), Ok(()));
}

#[test]
fn a_state_of_the_first_version_is_read() {
    let model = alarming();
    let before = evidence_after(&model, 9);
    let bytes = saved(&model, &before, None);
    // Without the last ten words.
    let mut old = bytes[..bytes.len() - 4 - 40].to_vec();
    old[4] = 1;
    let count = ((old.len() - 16) / 4) as u32;
    old[8..12].copy_from_slice(&count.to_le_bytes());
    old.extend([0; 4]);
    let first = words(&old)[0];
    let old = with_word(&old, 0, first);
    let mut evidence = Evidence::new(&model);
    assert_eq!(evidence.restore(&model, &old, None), Ok(()));
    assert_eq!(
        (evidence.score(), evidence.segments(), evidence.trend()),
        (before.score(), before.segments(), before.trend())
    );
    let mut later = bytes;
    later[4] = 3;
    let error = refusal(&model, &later);
    assert_eq!(error, StateError::Version { given: 3, supported: 2 });
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
    assert_eq!(other.restore(&model, &saved(&model, &quiet, None), None), Ok(()));
    let silence = silent(&mut other).expect("eight segments");
    assert_eq!((silence.segments, silence.with_reason, silence.reason), (8, 8, Some(Reason::Stuck { channel: 2 })));
}
