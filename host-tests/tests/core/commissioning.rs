//! A healthy class learned on the drive, from samples to a model in its binary form.

use bearing_watch::alarm::{CommissioningError, StateError};
use bearing_watch::model::{CommissioningConstants, EvidenceConstants};
use bearing_watch::{Commissioning, Detector, Evidence, Model, Reason, Report, Verdict};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::exported::{Drive, Sample};
use crate::saved::alarming;

/// Reports of a plant that is driven by noise; of every fourth segment most samples are lost.
fn reports(model: &Model<Drive>, count: usize, losing: bool) -> Vec<Report<Drive>> {
    let (mut random, mut detector) = (ChaCha8Rng::seed_from_u64(5), Detector::new(model));
    let [mut current_a, mut velocity] = [0.0_f32; 2];
    let mut found = Vec::new();
    while found.len() < count {
        velocity = 0.98 * velocity + random.random_range(-1.0..1.0);
        let load_torque_nm = random.random_range(-0.1..0.1);
        current_a = 0.9 * current_a + 0.1 * velocity + load_torque_nm + 0.01 * random.random_range(-1.0..1.0);
        let lost = losing && found.len() % 4 == 3 && random.random_range(0..3) > 0;
        let current_a = if lost { f32::NAN } else { current_a };
        found.extend(detector.step(&Sample { current_a, velocity_ref_rad_s: velocity, load_torque_nm }));
    }
    found
}

/// Far from the trained class, which is that of another rig.
const CONSTANTS: CommissioningConstants =
    CommissioningConstants { farthest: 1e6, widest: 1e6, ..CommissioningConstants::new(12, 2.0) };

#[test]
fn a_commissioned_model_is_a_model_with_another_healthy_class() {
    let model = alarming();
    let evidence = EvidenceConstants { log_mean: 0.7, ..model.constants().evidence };
    let constants = CommissioningConstants { evidence: Some(evidence), ..CONSTANTS };
    let mut commissioning = Commissioning::new(&model, constants).expect("good constants");
    let reports = reports(&model, 17, true);
    let outcomes: Vec<_> = reports.iter().map(|report| commissioning.take(report)).collect();
    for (outcome, report) in outcomes.iter().zip(&reports) {
        match (outcome, report.verdict) {
            (Err(CommissioningError::NoVerdict(reason)), Verdict::Undetermined(own)) => {
                assert!(*reason == own && matches!(own, Reason::ShortSegment { .. }), "{reason}");
            }
            (found, verdict) => assert!(found.is_ok() && !matches!(verdict, Verdict::Undetermined(_)), "{found:?}"),
        }
    }
    assert_eq!((commissioning.gathered(), commissioning.far()), (13, 0));
    let commissioned = commissioning.model().expect("enough");
    assert_eq!(commissioned.constants().classifier.novelty.mean, *commissioning.mean());
    assert_eq!(commissioned.constants().evidence, evidence);
    // Only healthy class, class means and alarm differ.
    let mut expected = model.constants().clone();
    expected.evidence = evidence;
    expected.classifier.novelty = commissioned.constants().classifier.novelty.clone();
    expected.classifier.discriminant.means = commissioned.constants().classifier.discriminant.means;
    assert_eq!(*commissioned.constants(), expected);
    // The drive is nearer to its own healthy class than to that of another rig.
    let distance = |model: &Model<Drive>| {
        let decisions = self::reports(model, 3, false).into_iter().map(|report| report.decision.expect("a verdict"));
        decisions.map(|decision| decision.distance).fold(0.0, f32::max)
    };
    let [trained, learned] = [&model, &commissioned].map(distance);
    println!("largest distance: {trained:.1} from the trained class, {learned:.1} from its own");
    assert!(learned < 6.0 && trained > 3.0 * learned, "{trained} {learned}");
    let mut buffer = vec![0; 4096];
    let length = commissioned.to_bytes("learned on the drive", &mut buffer).expect("fits");
    assert_eq!(Model::from_sector(&buffer), Ok(commissioned.clone()));
    assert!(length < buffer.len());
    // The evidence of the model before does not continue.
    let mut state = vec![0; Evidence::saved_len(&model)];
    Evidence::new(&model).save(&model, &mut state).expect("fits");
    let error = Evidence::new(&commissioned).restore(&commissioned, &state);
    assert_eq!(error, Err(StateError::OtherModel { saved: model.id(), expected: commissioned.id() }));
}

#[test]
fn too_few_segments_are_refused_by_their_number() {
    let model = alarming();
    let mut commissioning = Commissioning::new(&model, CONSTANTS).expect("good constants");
    for report in reports(&model, 11, false) {
        commissioning.take(&report).expect("usable");
    }
    let error = commissioning.model().expect_err("one is missing");
    assert_eq!(error, CommissioningError::TooFew { gathered: 11, needed: 12 });
    assert_eq!(error.to_string(), "11 segments were gathered, 12 are needed");
}
