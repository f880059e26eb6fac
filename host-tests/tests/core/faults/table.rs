//! Faults of signals on a healthy and on a spalled drive, and what a segment with them says: the table of the book.

use bearing_watch::model::Lags;
use bearing_watch::plan::RunTime;
use bearing_watch::{Model, Reason, Report, Verdict};
use host_tests::documents;
use model::trace::front_end::words;
use rig::DefectKind;

use super::electronics::scattered;
use super::rigs::{Fault as RawFault, drives};
use crate::shaft::dc_motor::{Motion, lag, model as of_velocity, model_of_angle, motions, run, trace};

/// A fault of a recorded stream, row by row.
type Fault = fn(&[Motion]) -> Vec<Motion>;

/// The rows, changed one by one.
fn each(rows: &[Motion], change: impl Fn(usize, &mut Motion)) -> Vec<Motion> {
    let mut changed = rows.to_vec();
    changed.iter_mut().enumerate().for_each(|(k, row)| change(k, row));
    changed
}

/// The rows without some of them, in parts of a thousand.
fn without(rows: &[Motion], a_thousand: u32) -> Vec<Motion> {
    rows.iter().zip(0_u32..).filter(|(_, k)| scattered(*k) % 1000 >= a_thousand).map(|(row, _)| *row).collect()
}

const STREAM: [(&str, Fault); 10] = [
    ("none", |rows| rows.to_vec()),
    ("encoder stuck from the start", |rows| each(rows, |_, row| row.angle = rows[0].angle)),
    ("encoder stuck from half of the segment on", |rows| {
        each(rows, |k, row| row.angle = rows[k.min(rows.len() / 2)].angle)
    }),
    ("rows lost without numbers, 0.1 %", |rows| without(rows, 1)),
    ("rows lost without numbers, 1 %", |rows| without(rows, 10)),
    ("rows lost without numbers, 10 %", |rows| without(rows, 100)),
    ("velocity × 0.7153", |rows| each(rows, |_, row| row.velocity_rad_s *= 0.7153)),
    ("velocity × 0.9", |rows| each(rows, |_, row| row.velocity_rad_s *= 0.9)),
    ("velocity × 1.1", |rows| each(rows, |_, row| row.velocity_rad_s *= 1.1)),
    ("velocity reversed", |rows| each(rows, |_, row| row.velocity_rad_s = -row.velocity_rad_s)),
];

/// What a report says of the signals.
fn said(report: &Report<RunTime>) -> String {
    match report.verdict {
        Verdict::Undetermined(Reason::Implausible(error)) => format!("no verdict: `{error:?}`"),
        Verdict::Undetermined(reason) => format!("no verdict: {reason}"),
        _ if report.counts.rejected > 0 => format!("verdict; {} samples refused", report.counts.rejected),
        _ => "verdict".into(),
    }
}

/// What healthy and spalled drives say; once, if it is the same.
fn of_both(healthy: String, spalled: String) -> String {
    if healthy == spalled { healthy } else { format!("{healthy}; spalled: {spalled}") }
}

fn streams() -> Vec<Vec<String>> {
    let lags = Lags { current: 1.2, velocity: 0.5, load: 0.5 };
    let models: [Model<RunTime>; 3] =
        [of_velocity(lag(0.7), true, 6000), of_velocity(lag(0.7), false, 6000), model_of_angle(lags, 6000)];
    let records = [DefectKind::Healthy, DefectKind::Spall].map(|kind| motions(&trace(kind, 77), 14));
    let row = |(name, fault): &(&str, Fault)| {
        let cells = models.iter().map(|model| {
            let [healthy, spalled] = [0, 1].map(|k| said(&run(model, &fault(&records[k]))));
            of_both(healthy, spalled)
        });
        std::iter::once((*name).to_string()).chain(cells).collect()
    };
    let head = ["fault", "own velocity and load", "own velocity", "velocity of the angle, load"].map(String::from);
    std::iter::once(head.to_vec()).chain(STREAM.iter().map(row)).collect()
}

/// Faults of counts: 14 bits of the angle.
const RAW: [(&str, &RawFault<'static>); 8] = [
    ("none", &|_, _, _| ()),
    ("phase a clipped at 1 A", &|_, phases, _| phases[0] = phases[0].clamp(-1.0, 1.0)),
    ("phase b without negative half waves", &|_, phases, _| phases[1] = phases[1].max(0.0)),
    ("offset of phase c of 0.5 A", &|_, phases, _| phases[2] += 0.5),
    ("the same, followed by the current loop", &|_, phases, _| phases.iter_mut().for_each(|own| *own += 0.5 / 3.0)),
    ("offset of phase c of 2 A", &|_, phases, _| phases[2] += 2.0),
    ("bit 5 of the encoder always set", &|_, _, counts| *counts |= 1 << 5),
    ("bit 12 of the encoder always clear", &|_, _, counts| *counts &= !(1 << 12)),
];

fn counts() -> Vec<Vec<String>> {
    let row = |(name, fault): &(&str, &RawFault<'static>)| {
        let cells = drives().into_iter().map(|drive| {
            let [healthy, spalled] = [DefectKind::Healthy, DefectKind::Spall].map(|kind| {
                let (samples, faults) = drive.clean(kind, 7, fault);
                let missing = samples.iter().filter(|own| own.is_missing()).count();
                let offsets = faults.offsets_a.map(|offset| format!("{offset:.1}"));
                let told = match (faults.is_clear(), offsets.iter().any(|own| own != "0.0" && own != "-0.0")) {
                    (true, false) => String::new(),
                    (true, true) => format!("; offsets removed, A: {}", offsets.join(", ")),
                    (false, _) => format!("; {}", words(&faults)),
                };
                format!("{:.0} % of the samples{told}", 100.0 * (1.0 - missing as f64 / samples.len() as f64))
            });
            of_both(healthy, spalled)
        });
        std::iter::once((*name).to_string()).chain(cells).collect()
    };
    let head = ["fault", "actuator", "DC-motor rig"].map(String::from);
    std::iter::once(head.to_vec()).chain(RAW.iter().map(row)).collect()
}

#[test]
fn faults_of_signals_are_those_of_the_book() {
    documents::check_all("book/src/faults.md", &[("faults-signals", streams()), ("faults-counts", counts())]);
}
