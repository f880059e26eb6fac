//! The detector on streams that no laboratory would record.

use bearing_watch::{Detector, Model, Part, Reason, Verdict};
use proptest::prelude::*;

use crate::exported::{Drive, MODEL, Sample};

/// A spalled trace.
fn recording() -> Vec<Sample> {
    super::parts::recording().iter().map(super::parts::signals).collect()
}

fn spall() -> Verdict {
    Verdict::Class(1)
}

#[test]
fn a_report_comes_with_the_last_sample_of_a_segment_and_only_then() {
    let mut monitor = Detector::new(&MODEL);
    let recording = recording();
    let (last, rest) = recording.split_last().expect("samples");
    assert!(rest.iter().all(|s| monitor.step(s).is_none()));
    let report = monitor.step(last).expect("a full segment");
    assert_eq!((report.verdict, report.rows, report.counts.rejected), (spall(), 4998, 0));
    let decision = report.decision.expect("decided");
    let total: f32 = decision.posteriors().iter().sum();
    assert!((total - 1.0).abs() < 1e-6); // three roundings of numbers up to one
    assert_eq!(monitor.pending(), 0);
    // The next segment of the stream keeps its lags: every sample is a row.
    assert!(recording[..4999].iter().all(|s| monitor.step(s).is_none()));
    assert_eq!(monitor.step(&recording[4999]).expect("a full segment").rows, 5000);
}

#[test]
fn finish_restart_and_preview() {
    let mut monitor = Detector::new(&MODEL);
    let none = Reason::TooFewRows { part: Part::Regression, rows: 0 };
    assert_eq!(monitor.finish().verdict, Verdict::Undetermined(none));
    let recording = recording();
    recording[..4000].iter().for_each(|s| assert!(monitor.step(s).is_none()));
    let preview = monitor.preview();
    assert_eq!(preview, monitor.preview(), "reading does not change");
    assert_eq!(monitor.finish(), preview);
    assert_eq!((monitor.pending(), monitor.finish().rows), (0, 0));
    recording[..100].iter().for_each(|s| assert!(monitor.step(s).is_none()));
    monitor.restart();
    let fresh = Detector::new(&MODEL);
    recording[..50].iter().for_each(|s| assert!(monitor.step(s).is_none()));
    assert_eq!((monitor.pending(), monitor.preview().rows), (50, 48));
    assert_eq!(fresh.pending(), 0);
}

#[test]
fn bursts_of_nonsense_cost_their_rows_and_nothing_else() {
    let clean = {
        let mut monitor = Detector::new(&MODEL);
        recording().iter().filter_map(|s| monitor.step(s)).next().expect("a full segment")
    };
    for nonsense in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30] {
        let mut samples = recording();
        for k in [100, 101, 102, 2000, 4998] {
            samples[k].current_a = nonsense;
        }
        samples[3000].velocity_ref_rad_s = nonsense;
        samples[3500].load_torque_nm = nonsense;
        let mut monitor = Detector::new(&MODEL);
        let report = samples.iter().filter_map(|s| monitor.step(s)).next().expect("a full segment");
        assert_eq!((report.verdict, report.counts.rejected), (spall(), 7), "{nonsense}");
        // Three gaps of one sample lose three rows each, the one of three loses five, and the last one meets the end.
        assert_eq!(report.rows, 4998 - 3 * 3 - 5 - 2, "{nonsense}");
        let (estimate, clean) = (report.estimate().expect("estimated"), clean.estimate().expect("estimated"));
        for (k, (got, want)) in estimate.delta().iter().zip(clean.delta()).enumerate() {
            let sd = clean.deviation(k);
            // Leaving 16 of 4998 rows out moves an estimate by about sqrt(16/4998) = 0.06 of its deviation.
            assert!((got - want).abs() < 0.3 * sd, "{nonsense}: parameter {k}");
        }
    }
}

#[test]
fn a_wild_sample_does_not_hide_in_a_block_mean() {
    let mut constants = MODEL.constants().clone();
    constants.sampling.block_mean = 10;
    constants.sampling.segment_samples = 500;
    let model = Model::new(Drive, constants).expect("good model");
    let run = |y: f32| {
        let mut monitor = Detector::new(&model);
        let mut samples = recording();
        samples[1234].current_a = y;
        samples.iter().filter_map(|s| monitor.step(s)).next().expect("a full segment").counts
    };
    // The limit is 62.7: a tenth of 600 would pass.
    assert_eq!((run(600.0).rejected, run(1.0).rejected), (1, 0));
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Any bits in, no panic; and whatever is called a verdict is finite.
    #[test]
    fn any_bits_give_a_value(samples in prop::collection::vec(any::<(u32, u32, u32)>(), 0..300)) {
        let mut monitor = Detector::new(&MODEL);
        for (y, u1, u2) in samples {
            let [current_a, velocity_ref_rad_s, load_torque_nm] = [y, u1, u2].map(f32::from_bits);
            let _ = monitor.step(&Sample { current_a, velocity_ref_rad_s, load_torque_nm });
        }
        let report = monitor.finish();
        if let Verdict::Class(_) = report.verdict {
            prop_assert!(report.estimate().is_some_and(|e| e.delta().iter().all(|x| x.is_finite())));
            prop_assert!(report.decision.is_some_and(|d| d.posteriors().iter().all(|p| p.is_finite())));
        }
    }

    /// Finite and believable in, finite out.
    #[test]
    fn believable_samples_give_finite_estimates(
        samples in prop::collection::vec((-60.0_f32..60.0, -400.0_f32..400.0, -4.0_f32..4.0), 20..300),
    ) {
        let mut monitor = Detector::new(&MODEL);
        for (current_a, velocity_ref_rad_s, load_torque_nm) in samples {
            let _ = monitor.step(&Sample { current_a, velocity_ref_rad_s, load_torque_nm });
        }
        let report = monitor.finish();
        prop_assert_eq!(report.counts.rejected, 0);
        prop_assert!(report.estimate().is_some_and(|e| e.delta().iter().all(|x| x.is_finite())));
        prop_assert!(report.estimate().is_some_and(|e| e.variance.is_finite() && e.variance >= 0.0));
    }
}
