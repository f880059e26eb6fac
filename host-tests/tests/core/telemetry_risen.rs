//! Reports say which direction has risen, by how much and since when.

#[path = "../../../target-tests/examples/support/directed.rs"]
mod directed;
#[path = "../../../target-tests/examples/support/directed_reports.rs"]
mod directed_reports;

use bearing_watch::Cause;
use bearing_watch::alarm::Contribution;
use bearing_watch::telemetry::{Body, Decoder, Encoder, Frame, Source};

use crate::telemetry::law;

/// Lets a decoder take a frame.
fn receive(decoder: &mut Decoder<512>, frame: &[u8], look: &mut dyn FnMut(Frame<'_>)) {
    for byte in frame {
        if let Some(frame) = decoder.push(*byte) {
            look(frame);
        }
    }
}

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
