use super::*;
use crate::reason::{ArithmeticFault, FrictionTerm, Implausible, Obstacle, Part};
use crate::tests::{Drive, MODEL, SAMPLES, report, samples};
use std::string::String;
use std::vec::Vec;

fn frame(segment: u8, verdict: u8, reason: u8, index: u8) -> Option<SegmentFrame> {
    SegmentFrame::from_bytes([segment, verdict, reason, index, 0, 0, 0, 0])
}

#[test]
fn each_bit_belongs_to_one_signal_and_the_documented_table_has_them() {
    let mut next = 0;
    for signal in SegmentFrame::SIGNALS {
        assert_eq!(signal.start, next, "{}", signal.name);
        assert!((1..=8).contains(&signal.length), "{}", signal.name);
        assert_eq!(signal.bits(u8::MAX).count_ones(), u32::from(signal.length));
        next += signal.length;
    }
    assert_eq!(next, 64);
    let rows = include_str!("../can.rs").lines().skip_while(|line| !line.starts_with("//! signal ")).skip(1);
    let table: Vec<Vec<String>> = rows
        .take_while(|line| !line.contains("```"))
        .map(|line| line[4..42].split_whitespace().map(String::from).collect())
        .collect();
    let signals = SegmentFrame::SIGNALS.map(|CanSignal { name, start, length, factor, unit, .. }| {
        let cells =
            [name.into(), std::format!("{start}"), std::format!("{length}"), std::format!("{factor}"), unit.into()];
        cells.into_iter().filter(|cell: &String| !cell.is_empty()).collect::<Vec<_>>()
    });
    assert_eq!(table, signals);
}

#[test]
fn a_frame_is_read_as_the_table_says() {
    let bytes = [0x07, 0x00, 0b010_00111, 0x03, 0x82, 0x1A, 0x80 | 61, 0xFF];
    let frame = SegmentFrame::from_bytes(bytes).unwrap();
    assert_eq!((frame.segment(), frame.undetermined(), frame.usable_percent()), (7, 2, 61));
    assert_eq!(frame.verdict(), Verdict::Undetermined(Reason::Stuck { channel: 3 }));
    assert_eq!((frame.alarm(), frame.deviations()), (Some(Cause::Coordinate(2)), 6.5));
    assert_eq!((frame.is_silent(), frame.distance()), (true, 63.75));
    assert_eq!(frame.to_bytes(), bytes);
}

#[test]
fn numbers_of_verdicts_and_causes_come_back() {
    for class in 0..=252 {
        let number = SegmentFrame::verdict_number(Verdict::Class(class));
        assert_eq!(frame(1, number, 0, 0).unwrap().verdict(), Verdict::Class(class));
    }
    for verdict in [Verdict::Novel, Verdict::Ambiguous] {
        assert_eq!(frame(1, SegmentFrame::verdict_number(verdict), 0, 0).unwrap().verdict(), verdict);
    }
    let read = |cause| SegmentFrame { bits: ALARM.bits(SegmentFrame::alarm_number(cause)) }.alarm();
    let causes = (0..=125).map(Cause::Class).chain((0..=63).map(Cause::Coordinate));
    let causes = causes.chain((0..=63).map(Cause::Fallen)).chain([Cause::Unknown]);
    for cause in causes.map(Some).chain([None]) {
        assert_eq!(read(cause), cause);
    }
    assert_eq!(read(Some(Cause::Class(255))), Some(Cause::Class(125)), "the last number");
    assert_eq!(read(Some(Cause::Coordinate(255))), Some(Cause::Coordinate(63)));
    assert_eq!(read(Some(Cause::Fallen(255))), Some(Cause::Fallen(63)));
    assert_eq!(SegmentFrame::verdict_number(Verdict::Class(255)), 255);
}

#[test]
fn every_pattern_is_read_or_refused_and_the_read_ones_are_written_again() {
    let (mut read, mut refused) = (0, 0);
    for verdict in 0..=u8::MAX {
        for reason in 0..=u8::MAX {
            for index in [0, 1, 4, 7, 11, 255] {
                let bytes = [verdict.wrapping_mul(37), verdict, reason, index, reason, verdict, 100, index];
                let Some(frame) = SegmentFrame::from_bytes(bytes) else {
                    refused += 1;
                    continue;
                };
                read += 1;
                assert_eq!(frame.to_bytes(), bytes);
                let undetermined = matches!(frame.verdict(), Verdict::Undetermined(_));
                assert_eq!(undetermined, verdict == 0, "{bytes:?}");
                assert_eq!(SegmentFrame::verdict_number(frame.verdict()), verdict);
                assert_eq!(SegmentFrame::alarm_number(frame.alarm()), reason);
            }
        }
    }
    assert!(read > 2000 && refused > 2000, "{read} {refused}");
    let shares = [100, 101, 127, 228].map(|share| SegmentFrame::from_bytes([0, 3, 0, 0, 0, 0, share, 0]).is_some());
    assert_eq!(shares, [true, false, false, true], "228 is 100 % of a silent drive");
}

#[test]
fn every_reason_comes_back_without_its_rows_and_has_a_name() {
    let parts = [Part::Regression, Part::TorqueBalance, Part::Orders, Part::Classifier];
    let plain = [Reason::ShortSegment { rows: 0 }, Reason::AtRest, Reason::OtherModel, Reason::FoundLate];
    let placed = [Reason::ParameterNotExcited(14), Reason::Stuck { channel: 15 }, Reason::LostSamples { channel: 2 }];
    let of_parts = parts.into_iter().flat_map(|part| {
        [Reason::TooFewRows { part, rows: 0 }, Reason::WeakInstruments(part), Reason::NotFinite(part)]
    });
    let all = of_parts
        .chain(plain)
        .chain(placed)
        .chain([Reason::OutOfRange { covariate: 9 }])
        .chain(FrictionTerm::ALL.map(Reason::TermNotExcited))
        .chain(Implausible::ALL.map(Reason::Implausible))
        .chain(ArithmeticFault::ALL.map(Reason::Arithmetic))
        .chain(Obstacle::ALL.map(Reason::Unseen));
    let mut kinds = Vec::new();
    for reason in all {
        let code = reason.code();
        assert_eq!(frame(9, 0, code.kind, code.index).unwrap().verdict(), Verdict::Undetermined(reason));
        kinds.push(usize::from(code.kind));
    }
    for (kind, name) in SegmentFrame::REASONS.iter().enumerate() {
        assert_eq!(!name.is_empty(), kind == 0 || kinds.contains(&kind), "{kind} {name}");
    }
    assert!(REASON.largest() as usize >= Reason::KINDS - 1);
}

#[test]
fn numbers_beyond_a_signal_are_its_last_one() {
    let steps = [0.0, 0.12, 0.13, 63.6, 63.7, 1e9, f32::INFINITY, -3.0, f32::NAN].map(|value| DISTANCE.steps(value));
    assert_eq!(steps, [0, 0, 1, 254, 255, 255, 255, 0, 0]);
}

#[test]
fn a_report_gives_its_frame() {
    let (mut report, mut evidence) = (report(samples(1.0)), Evidence::new(&MODEL));
    evidence.observe_outcome(report.outcome());
    let frame = SegmentFrame::of(&MODEL, &report, &evidence);
    assert_eq!((frame.segment(), frame.undetermined(), frame.verdict()), (1, 0, Verdict::Class(1)));
    assert_eq!((frame.alarm(), frame.deviations(), frame.is_silent(), frame.distance()), (None, 0.0, false, 0.0));
    let share = 100.0 * f64::from(report.rows) / f64::from(SAMPLES);
    assert!((f64::from(frame.usable_percent()) - share).abs() <= 0.5 && share > 90.0, "{share}");
    if let Some(decision) = &mut report.decision {
        decision.distance = 3.3;
    }
    assert_eq!(SegmentFrame::of(&MODEL, &report, &evidence).distance(), 3.25);
    // Withdrawn: the same number, another verdict.
    report.withdraw();
    let mut evidence = Evidence::new(&MODEL);
    evidence.observe_outcome(report.outcome());
    let withdrawn = SegmentFrame::of(&MODEL, &report, &evidence);
    assert_eq!((withdrawn.segment(), withdrawn.undetermined()), (1, 1));
    assert_eq!(withdrawn.verdict(), Verdict::Undetermined(Reason::FoundLate));
    assert_eq!(SegmentFrame::from_bytes(withdrawn.to_bytes()), Some(withdrawn));
    for _ in 0..256 {
        evidence.observe_outcome(report.outcome());
    }
    assert_eq!(SegmentFrame::of(&MODEL, &report, &evidence).segment(), 1, "it wraps");
}

/// Rows of more than a segment, as a fading memory has, are no share above 100 %.
#[test]
fn silence_and_rows_are_told() {
    let mut report = Report::<Drive>::empty(MODEL.plan());
    report.rows = 7 * SAMPLES;
    let mut evidence = Evidence::new(&MODEL);
    evidence.limit_silence(crate::alarm::SilenceLimits { segments: 2, hours: 0.0 });
    let mut told = || {
        evidence.observe_outcome(report.outcome());
        let frame = SegmentFrame::of(&MODEL, &report, &evidence);
        assert_eq!(SegmentFrame::from_bytes(frame.to_bytes()), Some(frame));
        (frame.segment(), frame.undetermined(), frame.is_silent(), frame.usable_percent())
    };
    assert_eq!([told(), told()], [(1, 1, false, 100), (2, 2, true, 100)]);
}
