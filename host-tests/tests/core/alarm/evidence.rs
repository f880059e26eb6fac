//! The evidence of runs against an oracle in double precision, which sums e-values and not their logarithms.

use bearing_watch::model::EvidenceConstants;
use bearing_watch::plan::RunTime;
use bearing_watch::{Cause, Evidence, Model};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::novelty::{core, gate_of, plan};
use host_tests::plans::constants;

const CLASSES: usize = 3;

/// A model of three classes in one coordinate with this evidence.
fn model(evidence: EvidenceConstants) -> Model<RunTime> {
    let plan = plan(1, CLASSES as u8);
    let mut constants = constants(plan, 100, &[1.0], &[bearing_watch::model::Feature::Parameter(0)], None);
    constants.classifier.discriminant.means = vec![0.0, 2.0, -2.0];
    let healthy: Vec<_> = (0..40).map(|k| nalgebra::DVector::from_element(1, f64::from(k % 7) - 3.0)).collect();
    constants.classifier.novelty = core(&gate_of(&healthy, 0.01));
    constants.evidence = evidence;
    Model::new(plan, constants).expect("a good model")
}

/// One segment: surprise and log-likelihoods of the classes, or no decision.
type Segment = Option<(f64, [f64; CLASSES])>;

/// The equations of the core's evidence on the segments of runs, each with its number of segments.
struct Oracle {
    constants: EvidenceConstants,
    scores: [f64; CLASSES],
    run: Vec<[f64; CLASSES]>,
}

impl Oracle {
    fn observe(&mut self, segment: Segment) {
        let c = self.constants;
        let Some((surprise, ln)) = segment else { return };
        let most = f64::from(c.cap).exp();
        let novelty = (f64::from(c.bet) * ((1.0 - f64::from(c.bet)) * surprise).exp()).min(most);
        self.run.push([novelty, (ln[1] - ln[0]).exp().min(most), (ln[2] - ln[0]).exp().min(most)]);
        if self.run.len() == c.segments_a_run as usize {
            self.end_run();
        }
    }

    fn end_run(&mut self) {
        let n = self.run.len() as f64;
        if self.run.is_empty() {
            return;
        }
        for (i, score) in self.scores.iter_mut().enumerate() {
            let log_mean = if i == 0 { self.constants.log_mean } else { self.constants.defect_log_mean };
            let e = self.run.iter().map(|own| own[i]).sum::<f64>() / n / f64::from(log_mean).exp();
            *score = (score.exp().max(n) * e).ln().max(0.0);
        }
        self.run.clear();
    }

    fn score(&self) -> f64 {
        self.scores.iter().copied().fold(0.0, f64::max)
    }
}

#[test]
fn scores_are_those_of_the_equations() {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    for segments_a_run in [1, 2, 7, 50, 1000] {
        let (log_mean, defect_log_mean) = (0.3, 0.7);
        let constants =
            EvidenceConstants { bet: 0.2, limit: 60.0, cap: 9.0, segments_a_run, log_mean, defect_log_mean };
        let model = model(constants);
        let (mut evidence, classifier) = (Evidence::new(&model), &model.constants().classifier);
        let mut oracle = Oracle { constants, scores: [0.0; CLASSES], run: vec![] };
        let (mut worst, mut reached, mut resets) = (0.0_f64, 0.0_f64, 0);
        for step in 0..6000 {
            let normal = |random: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(random) };
            // Healthy for a while, then a fault that comes and goes.
            let fault = if step % 1500 > 1200 { 4.0 } else { 0.0 };
            let surprise = (normal(&mut random).powi(2) + fault) as f32;
            let ln = [0.0, -1.0 + fault + normal(&mut random), -2.0 + 30.0 * normal(&mut random)].map(|x| x as f32);
            let segment = (random.random::<f64>() > 0.05).then_some((surprise, ln));
            oracle.observe(segment.map(|(surprise, ln)| (surprise.into(), ln.map(f64::from))));
            let decision = segment.and_then(|(surprise, ln)| classifier.decide(model.plan(), &ln, surprise));
            evidence.observe(decision.as_ref());
            if random.random::<f64>() < 0.02 {
                oracle.end_run();
                evidence.end_run();
            }
            // Sums of e-values overflow beyond 709 nats.
            if oracle.score() > 600.0 {
                (oracle.scores, resets) = ([0.0; CLASSES], resets + 1);
                oracle.run.clear();
                evidence.reset();
            }
            assert!(oracle.score().is_finite());
            reached = reached.max(oracle.score());
            worst = worst.max((f64::from(evidence.score()) - oracle.score()).abs() / reached.max(1.0));
        }
        println!(
            "{segments_a_run} segments a run: error {worst:.1e} of the largest score, up to {reached:.1}, {resets} resets"
        );
        // Some hundred roundings of 1e-7 while a score rises and falls.
        assert!(worst < 2e-5 && reached > 3.0, "{segments_a_run}: {worst} {reached}");
    }
}

#[test]
fn one_segment_a_run_is_the_sum_of_logarithms() {
    let constants = EvidenceConstants { bet: 0.2, limit: 13.8, cap: 6.9, log_mean: -0.0977, ..EvidenceConstants::NONE };
    let model = model(constants);
    let mut random = ChaCha8Rng::seed_from_u64(42);
    let (mut evidence, classifier) = (Evidence::new(&model), &model.constants().classifier);
    let (mut novelty, mut defects) = (0.0_f32, [0.0_f32; 2]);
    for _ in 0..5000 {
        let surprise: f32 = 1.3 * -(1.0 - random.random::<f32>()).ln();
        let ln = [0.0, 2.0 * random.random::<f32>() - 1.2, -30.0 * random.random::<f32>()];
        evidence.observe(classifier.decide(model.plan(), &ln, surprise).as_ref());
        evidence.end_run();
        novelty = (novelty + ((0.2_f32.ln() + 0.8 * surprise).min(6.9) - constants.log_mean)).max(0.0);
        for (score, own) in defects.iter_mut().zip(&ln[1..]) {
            *score = (*score + (own - ln[0]).min(6.9)).max(0.0);
        }
        let expected = defects.into_iter().fold(novelty, f32::max);
        assert_eq!(evidence.score().to_bits(), expected.to_bits(), "the same bits");
    }
    assert!(evidence.alarm().is_none_or(|alarm| alarm.cause != Cause::Class(0)));
}
