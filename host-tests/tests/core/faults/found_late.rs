//! Faults that the front end finds late, replayed: reports and evidence are those of the drive.

use bearing_watch::drive::Alignment;
use bearing_watch::{Detector, Implausible, Monitor, Reason, Verdict};
use model::core::{Embedded, SegmentReport};
use model::trace::{MotionTrace, Trace};
use rig::DefectKind;

use crate::shaft::dc_motor::{Motion, lag, model, motions, trace};

const SEGMENT: usize = 1000;

/// The rows as a trace.
fn recorded(rows: &[Motion]) -> Trace {
    let column = |pick: fn(&Motion) -> f32| rows.iter().map(|row| f64::from(pick(row))).collect::<Vec<_>>();
    let motion = MotionTrace {
        current_a: column(|row| row.current_a),
        velocity_rad_s: column(|row| row.velocity_rad_s),
        load_nm: column(|row| row.load_nm),
        // In double precision: an angle of many turns would be rounded.
        angle_rad: rows
            .iter()
            .map(|row| f64::from(row.angle.bits()) * std::f64::consts::TAU / 4_294_967_296.0)
            .collect(),
        reference_rad_s: vec![],
    };
    let (y, u1, u2) = (vec![0.0; rows.len()], vec![0.0; rows.len()], vec![0.0; rows.len()]);
    Trace { y, u1, u2, motion: Some(motion), ..Trace::default() }
}

#[test]
fn a_replay_discards_and_withdraws_as_the_drive_does() {
    let rows = motions(&trace(DefectKind::Healthy, 77), 14);
    let rig_model = model(lag(0.7), true, SEGMENT as u32);
    let embedded = Embedded::new(rig_model.clone()).expect("known columns");
    let recorded = recorded(&rows);
    // In the first and in the second half of a segment, twice in one, and at the first row of one.
    for found_late in [vec![], vec![1100], vec![1700], vec![2100, 2300], vec![3000]] {
        let recorded = Trace { found_late: found_late.clone(), ..recorded.clone() };
        let mut stream = embedded.stream();
        let replayed: Vec<_> = stream.run(&recorded, false).into_iter().map(|(segment, _)| segment.reason).collect();
        // The drive: the report before is withdrawn where the detector says so.
        let (mut detector, mut monitor) = (Detector::new(&rig_model), Monitor::new(&rig_model));
        let mut reports: Vec<Option<Reason>> = Vec::new();
        for (k, row) in rows.iter().enumerate() {
            if found_late.contains(&k)
                && let Some(number) = detector.discard()
                && monitor.withdraw(number)
            {
                *reports.last_mut().expect("a report") = Some(Reason::FoundLate);
            }
            if let Some(now) = monitor.step(&mut detector, &row.sample(3)) {
                reports.push(match now.report.verdict {
                    Verdict::Undetermined(reason) => Some(reason),
                    _ => None,
                });
            }
        }
        assert_eq!(replayed, reports, "{found_late:?}");
        let withdrawn = replayed.iter().filter(|reason| **reason == Some(Reason::FoundLate)).count();
        let expected = found_late.iter().filter(|row| *row % SEGMENT < SEGMENT / 2).count().min(1);
        assert_eq!(withdrawn, expected, "{found_late:?}: {replayed:?}");
    }
}

#[test]
fn a_replay_waits_for_the_wiring_once_a_run_and_a_record_by_itself_does_not() {
    let rig_model = model(lag(0.7), true, SEGMENT as u32);
    let embedded = Embedded::new(rig_model).expect("known columns");
    let wiring = vec![(0, Alignment::Undecided), (SEGMENT + SEGMENT / 2, Alignment::Aligned)];
    let recorded = Trace { wiring, ..recorded(&motions(&trace(DefectKind::Healthy, 77), 14)) };
    let undecided = Some(Reason::Implausible(Implausible::WiringUndecided));
    let waits = |segments: Vec<SegmentReport>| -> Vec<bool> {
        segments.iter().take(3).map(|segment| segment.reason == undecided).collect()
    };
    let mut stream = embedded.stream();
    let mut replay = |ends| waits(stream.run(&recorded, ends).into_iter().map(|(segment, _)| segment).collect());
    assert_eq!(replay(false), [true, false, false]);
    assert_eq!(replay(true), [false; 3], "the run goes on");
    assert_eq!(replay(false), [true, false, false], "the next run");
    assert_eq!(waits(embedded.run(&recorded)), [false; 3]);
}
