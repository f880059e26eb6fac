use super::{Conclusion, Detector, Exchange, Monitor, Segment};
use crate::alarm::evidence::{Cause, Evidence};
use crate::model::{Constants, EvidenceConstants, Model};
use crate::plan::Plan;
use crate::reason::Reason;
use crate::report::{Report, Verdict};
use crate::tests::{Drive, MODEL, REFINED, Refined, RefinedSample, SAMPLES, Sample, report, samples};
use std::vec::Vec;

/// Takes one sample; returns a copy of the sums with the sample that closes a segment.
pub(crate) fn collect<P: Plan>(detector: &mut Detector<'_, P>, sample: &P::Sample) -> Option<Segment<P>> {
    detector.take(sample).then(|| {
        let segment = detector.segment(true);
        detector.next_segment();
        segment
    })
}

/// Solves a segment at once.
pub(crate) fn conclude<'a, P: Plan>(monitor: &'a mut Monitor<'_, P>, mut segment: Segment<P>) -> Conclusion<'a, P> {
    monitor.take_from(&mut segment);
    monitor.complete().unwrap()
}

/// The report of a segment without a monitor.
pub(super) fn solved<P: Plan>(model: &Model<P>, mut segment: Segment<P>) -> Report<P> {
    segment.report(model)
}

pub(super) fn segment<P: Plan>(
    detector: &mut Detector<'_, P>,
    mut samples: impl Iterator<Item = P::Sample>,
) -> Segment<P> {
    loop {
        if let Some(segment) = collect(detector, &samples.next().unwrap()) {
            return segment;
        }
    }
}

/// The samples for instrumental variables, which need an auxiliary model.
fn refined(b: f32) -> impl Iterator<Item = RefinedSample> {
    samples(b).map(RefinedSample::from)
}

#[test]
fn at_once_deferred_and_in_steps_give_the_same_reports() {
    let [mut inline, mut whole, mut steps] = [(); 3].map(|()| Detector::new(&REFINED));
    let [mut one, mut two, mut three] = [(); 3].map(|()| refined(1.0));
    for _ in 0..3 {
        let expected = loop {
            if let Some(report) = inline.step(&one.next().unwrap()) {
                break report;
            }
        };
        assert_eq!(expected.verdict, Verdict::Class(1));
        let concluded = solved(&REFINED, segment(&mut whole, &mut two));
        assert!(whole.adopt(&concluded));
        let mut monitor = Monitor::new(&REFINED);
        monitor.take_from(&mut segment(&mut steps, &mut three));
        let mut advances = 1;
        while monitor.advance().is_none() {
            advances += 1;
        }
        assert!((5..20).contains(&advances), "{advances}");
        assert_eq!(monitor.report(), Some(&expected));
        assert!(steps.adopt(&expected) && !steps.adopt(&Report::empty(Refined)));
        assert_eq!(concluded, expected);
    }
}

/// The reports of a stream, whose segments are exchanged; every third place comes back unread, and so not clear.
fn exchanged<P: Plan>(model: &Model<P>, stream: impl Iterator<Item = P::Sample>, discard_at: usize) -> Vec<Report<P>> {
    let [mut first, mut second] = [(); 2].map(|()| Segment::new(model));
    let (mut detector, mut spare) = (Detector::with_place(model, &mut first), Some(&mut second));
    let (mut monitor, mut reports) = (Monitor::new(model), Vec::new());
    for (k, sample) in stream.enumerate() {
        if k == discard_at {
            detector.discard();
        }
        match detector.exchange(&sample, &mut spare) {
            Exchange::Open => continue,
            Exchange::Lost => panic!("no spare place at {k}"),
            Exchange::Closed(place) => {
                if reports.len() % 3 == 2 {
                    monitor.take_from(&mut place.clone());
                } else {
                    monitor.take_from(place);
                }
                spare = Some(place);
            }
        }
        detector.adopt(monitor.complete().expect("a closed segment").report);
        reports.push(monitor.report().expect("a concluded segment").clone());
    }
    reports
}

fn collected<P: Plan>(model: &Model<P>, stream: impl Iterator<Item = P::Sample>, discard_at: usize) -> Vec<Report<P>> {
    let (mut detector, mut monitor, mut reports) = (Detector::new(model), Monitor::new(model), Vec::new());
    for (k, sample) in stream.enumerate() {
        if k == discard_at {
            detector.discard();
        }
        if let Some(segment) = collect(&mut detector, &sample) {
            detector.adopt(conclude(&mut monitor, segment).report);
            reports.push(monitor.report().expect("a concluded segment").clone());
        }
    }
    reports
}

#[test]
fn exchanged_and_copied_segments_give_the_same_reports() {
    let stream = || samples(0.7).take(6 * SAMPLES as usize + 50);
    for discard_at in [usize::MAX, 30, 2 * SAMPLES as usize, 3 * SAMPLES as usize + 120] {
        let expected = collected(&MODEL, stream(), discard_at);
        assert_eq!(expected.len(), 6);
        assert_eq!(exchanged(&MODEL, stream(), discard_at), expected, "{discard_at}");
    }
}

#[test]
fn without_a_spare_place_a_segment_is_lost_and_the_next_one_is_whole() {
    // A place of another model, which is not clear.
    let other = changed(|c| c.classifier.discriminant.means = [0.5, 1.1]);
    let mut foreign = segment(&mut Detector::new(&other), samples(2.0));
    let mut first = Segment::new(&MODEL);
    let (mut detector, mut spare) = (Detector::with_place(&MODEL, &mut first), None);
    let (mut next, mut again, mut copied) = (samples(0.7), samples(0.7), Detector::new(&MODEL));
    let lost = (1..).find(|_| matches!(detector.exchange(&next.next().unwrap(), &mut spare), Exchange::Lost));
    assert_eq!(lost, Some(SAMPLES));
    segment(&mut copied, again.by_ref());
    spare = Some(&mut foreign);
    for number in 0..2 {
        let closed = loop {
            match detector.exchange(&next.next().unwrap(), &mut spare) {
                Exchange::Open => {}
                Exchange::Closed(place) => break place,
                Exchange::Lost => panic!("there is a spare place"),
            }
        };
        assert_eq!(*closed, segment(&mut copied, again.by_ref()), "{number}");
        spare = Some(closed);
    }
}

#[test]
fn the_gain_decides() {
    for (gain, class) in [(0.5, 0), (1.0, 1)] {
        let report = report(samples(gain));
        assert_eq!(report.verdict, Verdict::Class(class));
        // The noise of 6e-4 leaves less than a hundredth of a gain.
        assert!((report.estimate().unwrap().delta()[1] - gain).abs() < 0.01, "{report:?}");
    }
}

#[test]
fn a_stuck_channel_is_named() {
    let report = report(samples(0.5).map(|sample| Sample { current_a: 0.25, ..sample }));
    assert_eq!(report.verdict, Verdict::Undetermined(Reason::Stuck { channel: 0 }));
    assert!(report.decision.is_none());
}

#[test]
fn half_a_segment_of_rows_is_needed() {
    let spoiled = |limit: u32| {
        (0_u32..).zip(samples(0.5)).map(move |(t, sample)| {
            let velocity_rad_s = if t < limit { f32::NAN } else { sample.velocity_rad_s };
            Sample { velocity_rad_s, ..sample }
        })
    };
    assert_eq!(report(spoiled(80)).verdict, Verdict::Class(0));
    let rows = report(spoiled(120)).rows;
    assert!(rows < SAMPLES / 2);
    assert_eq!(report(spoiled(120)).verdict, Verdict::Undetermined(Reason::ShortSegment { rows }));
}

#[test]
fn a_preview_changes_nothing() {
    let mut detector = Detector::new(&MODEL);
    for sample in samples(0.5).take(150) {
        assert!(detector.step(&sample).is_none());
    }
    let before = detector.clone();
    assert_eq!(detector.preview().verdict, Verdict::Class(0));
    assert_eq!(detector, before);
    assert_eq!(detector.finish().verdict, Verdict::Class(0));
    assert_eq!(detector, Detector::new(&MODEL));
}

/// The model with a constant changed.
fn changed(change: impl Fn(&mut Constants<Drive>)) -> Model<Drive> {
    let mut constants = MODEL.constants().clone();
    change(&mut constants);
    Model::new(Drive, constants).unwrap()
}

/// Classes at 0.5, healthy, and 1; distances up to three deviations are healthy.
pub(super) fn gated() -> Model<Drive> {
    changed(|c| {
        let novelty = &mut c.classifier.novelty;
        (novelty.class, novelty.mean, novelty.factor, novelty.limit) = (Some(0), [0.5], [0.0025], 4.5);
        for (k, knot) in (0_u8..).zip(&mut novelty.knots) {
            *knot = [2.0 * f32::from(k), f32::from(k)];
        }
        c.evidence = EvidenceConstants { bet: 0.2, limit: 9.0, cap: 6.0, ..EvidenceConstants::NONE };
    })
}

#[test]
fn a_segment_far_from_every_class_is_novel() {
    let verdict = |model: &Model<Drive>, gain| {
        let mut detector = Detector::new(model);
        samples(gain).find_map(|sample| detector.step(&sample)).unwrap().verdict
    };
    let model = gated();
    let of = |gain| verdict(&model, gain);
    // The gate of the defect is at nine deviations of 0.05.
    assert_eq!([of(0.5), of(1.0), of(1.4)], [Verdict::Class(0), Verdict::Class(1), Verdict::Class(1)]);
    assert_eq!([of(1.5), of(9.0), of(-9.0)], [Verdict::Novel; 3]);
    // Without a healthy class, or if nothing is to be novel, there is no gate.
    let endless = changed(|c| {
        *c = gated().constants().clone();
        c.classifier.novelty.limit = f32::INFINITY;
    });
    assert_eq!([verdict(&MODEL, 9.0), verdict(&endless, 9.0)], [Verdict::Class(1); 2]);
    // Costs may decide for another class than the one that the segment is near.
    let cheap = changed(|c| {
        *c = gated().constants().clone();
        c.classifier.discriminant.costs = [0.0, 1.0, 0.0, 0.0];
    });
    assert_eq!(verdict(&cheap, 0.5), Verdict::Class(1));
    let decision = cheap.constants().classifier.decide_at(Drive, &[0.5], &[]).unwrap();
    assert!(decision.beyond()[1] && !decision.beyond()[0]);
}

#[test]
fn an_alarm_by_segments_far_from_every_class_names_no_defect() {
    let model = gated();
    let cause = |gain| {
        let (mut detector, mut evidence) = (Detector::new(&model), Evidence::new(&model));
        for sample in samples(gain).take(3 * SAMPLES as usize) {
            if let Some(report) = detector.step(&sample) {
                evidence.observe_outcome(report.outcome());
            }
        }
        evidence.alarm().map(|alarm| alarm.cause)
    };
    assert_eq!([cause(0.5), cause(1.0), cause(40.0)], [None, Some(Cause::Class(1)), Some(Cause::Unknown)]);
}

#[test]
fn a_discarded_segment_closes_where_it_would_have_with_means_of_blocks() {
    let model = changed(|c| c.sampling.block_mean = 4);
    for before in 0..13_usize {
        let mut detector = Detector::new(&model);
        let stream = || samples(0.5);
        stream().take(before).for_each(|sample| assert!(detector.step(&sample).is_none()));
        detector.discard();
        let closes = (before + 1..).zip(stream().skip(before)).find_map(|(k, sample)| {
            let report = detector.step(&sample)?;
            Some((k, report.rows))
        });
        // The open block is spoilt, and a row needs the sample before it.
        assert_eq!(closes, Some((4 * SAMPLES as usize, SAMPLES - (before as u32).div_ceil(4) - 1)), "{before}");
    }
}

#[test]
fn a_report_from_before_a_restart_is_not_adopted() {
    let mut detector = Detector::new(&REFINED);
    let old = solved(&REFINED, segment(&mut detector, refined(0.5)));
    for again in 0..300 {
        detector.restart();
        let report = solved(&REFINED, segment(&mut detector, refined(0.5)));
        assert!(!detector.adopt(&old) && detector.adopt(&report), "{again}");
    }
    // Nor one of so many segments ago that a byte would have counted around.
    let mut detector = Detector::new(&REFINED);
    for k in 0..512_u32 {
        segment(&mut detector, refined(0.5));
        if k == 0 || k == 256 {
            assert_eq!(detector.adopt(&old), k == 0, "{k}");
        }
    }
}

#[test]
fn a_report_from_before_a_discarded_part_is_not_adopted() {
    let mut detector = Detector::new(&REFINED);
    let report = solved(&REFINED, segment(&mut detector, refined(0.5)));
    assert!(detector.clone().adopt(&report));
    detector.discard();
    assert!(!detector.adopt(&report));
}

#[test]
fn what_another_model_made_is_refused() {
    let (model, other) = (gated(), changed(|c| c.classifier.discriminant.means = [0.5, 1.1]));
    let collect = |model: &Model<Drive>| {
        let mut detector = Detector::new(model);
        samples(1.0).find_map(|sample| collect(&mut detector, &sample)).unwrap()
    };
    let report = solved(&other, collect(&other));
    assert_eq!(report.verdict, Verdict::Class(1));
    let mut evidence = Evidence::new(&model);
    evidence.limit_silence(crate::alarm::SilenceLimits { segments: 1, hours: 0.0 });
    evidence.observe(report.decision.as_ref());
    let reason = Some(Reason::OtherModel);
    assert_eq!((evidence.segments(), evidence.silence().and_then(|silence| silence.reason)), ((1, 1), reason));
    assert_eq!(solved(&model, collect(&other)).verdict, Verdict::Undetermined(Reason::OtherModel));
    let mut constants = REFINED.constants().clone();
    constants.classifier.discriminant.means = [0.5, 1.1];
    let other = Model::new(Refined, constants).unwrap();
    let [mut one, mut two] = [&REFINED, &other].map(Detector::new);
    let report = solved(&REFINED, segment(&mut one, refined(1.0)));
    segment(&mut two, refined(1.0));
    assert!(!two.adopt(&report) && one.adopt(&report));
    // The same numbers are the same model, wherever they are.
    let mut evidence = Evidence::new(&gated());
    evidence.observe(solved(&model, collect(&gated())).decision.as_ref());
    assert_eq!(evidence.segments(), (1, 0));
}
