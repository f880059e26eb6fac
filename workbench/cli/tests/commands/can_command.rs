//! Command-line tests of segments over CAN: `dbc` describes the frame, and `listen --can-id` reads logs of a bus.

use std::fmt::Write as _;
use std::path::Path;

use bearing_watch::telemetry::SegmentFrame;
use serde_json::Value;

use crate::common::{refuse, run, succeed};
use crate::form::{fit, schema};

const MODEL: &[u8] = include_bytes!("../../../../examples/support/standard_rig/model.bwm");
/// Segments of 6 s: an hour and a little.
const SEGMENTS: u32 = 660;
/// A spall from this segment on, and its alarm.
const SPALL: u32 = 500;
const ALARM: u32 = 520;

/// An event on the bus.
enum Event {
    /// A data frame: bus, identifier, whether it is an extended one, data.
    Data(u8, u32, bool, Vec<u8>),
    Remote(u32),
    Error,
}

/// The data of a segment by the table of the core's documentation, and how many were undetermined before.
fn segment(number: u32, undetermined: u32) -> ([u8; 8], u32) {
    let stuck = number.is_multiple_of(50);
    let (verdict, reason) = match number {
        _ if stuck => (0, 7),
        ..SPALL => (3, 0),
        _ => (4, 0),
    };
    let undetermined = undetermined + u32::from(stuck);
    let alarm = if number >= ALARM { 3 } else { 0 };
    let distance = if stuck { 0 } else { 4 + verdict };
    ([number as u8, verdict, reason | (undetermined as u8) << 5, u8::from(stuck), alarm, 0, 97, distance], undetermined)
}

/// What the log has, and how many frames it lacks, has twice, and has of other nodes.
fn hour() -> (Vec<(f64, Event)>, [u64; 3]) {
    let (mut events, mut undetermined, mut counts) = (Vec::new(), 0, [0; 3]);
    for number in 1..=SEGMENTS {
        let time = 6.0 * f64::from(number);
        let other = vec![number as u8; number as usize % 9];
        events.push((time - 1.0, Event::Data(0, 0x124, false, other.clone())));
        events.push((time - 0.5, Event::Data(0, 0x123, true, other)));
        counts[2] += 2;
        let (data, after) = segment(number, undetermined);
        undetermined = after;
        if number.is_multiple_of(37) {
            counts[0] += 1;
            continue;
        }
        events.push((time, Event::Data(0, 0x123, false, data.into())));
        if number.is_multiple_of(41) {
            counts[1] += 1;
            events.push((time + 0.001, Event::Data(0, 0x123, false, data.into())));
        }
        if number == 101 {
            undetermined += 1;
            let withdrawn = [101, 0, 15 | (undetermined as u8) << 5, 0, 0, 0, 97, 0];
            events.push((time + 0.5, Event::Data(0, 0x123, false, withdrawn.into())));
            events.push((time + 1.0, Event::Remote(0x123)));
            events.push((time + 1.1, Event::Error));
            events.push((time + 1.2, Event::Data(1, 0x123, false, data.into())));
            events.push((time + 1.3, Event::Data(0, 0x123, false, data[..7].into())));
        }
    }
    (events, counts)
}

fn hexadecimal(data: &[u8], between: &str) -> String {
    data.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(between)
}

fn candump(events: &[(f64, Event)]) -> String {
    let mut text = String::new();
    for (time, event) in events {
        let time = 1.7e9 + time;
        let (bus, frame) = match event {
            Event::Data(bus, id, true, data) => (*bus, format!("{id:08X}##1{}", hexadecimal(data, ""))),
            Event::Data(bus, id, false, data) => (*bus, format!("{id:03X}#{}", hexadecimal(data, ""))),
            Event::Remote(id) => (0, format!("{id:03X}#R8")),
            Event::Error => (0, "20000088#0000000000000000".into()),
        };
        writeln!(text, "({time:.6}) can{bus} {frame}").expect("memory");
    }
    text
}

fn asc(events: &[(f64, Event)]) -> String {
    let mut text = String::from("date Tue Nov 14 10:13:20 am 2023\nbase hex  timestamps absolute\n");
    text += "internal events logged\n// version 9.0.0\n   0.000000 Start of measurement\n";
    for (time, event) in events {
        let frame = match event {
            Event::Data(bus, id, true, data) => {
                let length = data.len();
                format!("CANFD {bus} Rx {id:X}x  1 0 {length:x} {length} {} 0 0", hexadecimal(data, " "))
            }
            Event::Data(bus, id, false, data) => {
                format!("{bus}  {id:<15X} Rx   d {} {}", data.len(), hexadecimal(data, " "))
            }
            Event::Remote(id) => format!("0  {id:<15X} Rx   r 8"),
            Event::Error => "0  ErrorFrame".into(),
        };
        writeln!(text, "{time:>11.6} {frame}").expect("memory");
    }
    text + "End TriggerBlock\n"
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("model.bwm"), MODEL).expect("writable");
    folder
}

fn listened(dir: &Path, log: &str) -> Vec<Value> {
    let text = succeed(dir, &format!("listen {log} --can-id 0x123 --model model.bwm --json"));
    text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

#[test]
fn of_a_recorded_hour_every_report_is_right_or_counted() {
    let folder = folder();
    let dir = folder.path();
    let (events, [lost, repeated, others]) = hour();
    let schema = schema("listen");
    for (name, log) in [("bus.log", candump(&events)), ("bus.asc", asc(&events))] {
        std::fs::write(dir.join(name), log).expect("writable");
        let lines = listened(dir, name);
        lines.iter().for_each(|line| fit(&schema, line));
        let (end, segments) = lines.split_last().expect("an end");
        let numbers: Vec<u64> = segments.iter().filter_map(|line| line["segment"].as_u64()).collect();
        let sent = (1..=SEGMENTS).filter(|number| !number.is_multiple_of(37)).map(u64::from);
        let mut expected: Vec<u64> = sent.collect();
        let place = expected.iter().position(|number| *number == 101).expect("sent");
        expected.insert(place, 101);
        assert_eq!(numbers, expected, "{name}");
        let mut undetermined = 0;
        for line in segments.iter().filter(|line| line["again"] == false) {
            let number = line["segment"].as_u64().expect("a number") as u32;
            let stuck = number.is_multiple_of(50);
            let verdict = if stuck { "undetermined" } else { ["healthy", "spall"][usize::from(number >= SPALL)] };
            assert_eq!(line["verdict"], verdict, "{line}");
            assert_eq!(line["alarm"]["cause"] == "spall", number >= ALARM, "{line}");
            assert_eq!(line["undetermined"] == "the sensor of channel 2 is stuck", stuck, "{line}");
            undetermined += u64::from(stuck);
        }
        let counts = [&end["segments"], &end["lost"], &end["repeated"], &end["other_ids"]].map(|n| n.as_u64());
        let all = u64::from(SEGMENTS) - lost;
        assert_eq!(counts, [all, lost, repeated, others].map(Some), "{end}");
        assert_eq!([&end["withdrawn"], &end["again"], &end["remote"], &end["error_frames"]], [1; 4], "{end}");
        assert_eq!([&end["bad"], &end["other_buses"], &end["restarts"], &end["unread_lines"]], [1, 1, 0, 0], "{end}");
        let spalls = end["verdicts"]["spall"].as_u64().expect("a number");
        assert_eq!(end["verdicts"]["undetermined"].as_u64(), Some(undetermined + 1), "with the withdrawn one");
        assert_eq!(end["verdicts"]["healthy"].as_u64(), Some(all - undetermined - 1 - spalls));
        assert_eq!(end["alarm"]["segment"], ALARM);
    }
}

#[test]
fn lines_tell_verdict_reason_alarm_and_the_end() {
    let folder = folder();
    let dir = folder.path();
    std::fs::write(dir.join("bus.log"), candump(&hour().0) + "a line of another program\n").expect("writable");
    let text = succeed(dir, "listen bus.log --can-id 0x123 --model model.bwm");
    for words in [
        "1700000006.000 s  segment 1  healthy, distance 1.75, 97 % usable\n",
        "segment 50  undetermined: the sensor of channel 2 is stuck, 97 % usable\n",
        "segment 101 again  undetermined: a fault that was found after the segment may have begun in it",
        "ALARM at segment 520, 1700003120.000 s: spall\n",
        "643 segments of 0x123: healthy 476, spall 153, undetermined 14; ALARM since segment 520: spall; 17 lost, 16 \
         repeated, 1 withdrawn, 1 frames that are no segment, 1 frames on another bus, 1320 frames of other \
         identifiers, 1 remote frames, 1 error frames, 1 lines that were not read\n",
    ] {
        assert!(text.contains(words), "{words}\n{}", text.lines().last().unwrap_or_default());
    }
    assert_eq!(text.matches("ALARM at").count(), 1);
    // Without a model classes have numbers.
    assert!(
        succeed(dir, "listen bus.log --can-id 0x123").contains("ALARM at segment 520, 1700003120.000 s: class 2\n")
    );
    // The frame does not contain the number of rows that a reason has, so the text does not print one.
    std::fs::write(dir.join("few.log"), "(1.0) can0 123#0100210300008000\n(2.0) can0 123#0200420000008000")
        .expect("writable");
    let text = succeed(dir, "listen few.log --can-id 0x123");
    for words in [
        "segment 1  undetermined: the bearing orders has too few usable rows, 0 % usable\n",
        "segment 2  undetermined: less than half of the segment was usable, 0 % usable\n",
        "SILENCE at segment 1: no verdict for too long\n",
        "2 segments of 0x123: undetermined 2; no alarm; 0 lost",
    ] {
        assert!(
            text.contains(&words.replace("orders has too few usable rows", "orders have too few blocks")),
            "{text}"
        );
    }
}

#[test]
fn logs_without_the_identifier_are_refused() {
    let folder = folder();
    let dir = folder.path();
    for (name, text) in [
        ("bus.log", candump(&hour().0)),
        ("text", "no log\n".repeat(9)),
        ("empty", String::new()),
        ("zeros.log", "(1.0) can0 123#0000000000000000\n".repeat(3)),
    ] {
        std::fs::write(dir.join(name), text).expect("writable");
    }
    refuse(dir, "listen bus.log --can-id 0x125", &["bus.log: no frame of 0x125 among 19", "check the identifier"]);
    refuse(dir, "listen text --can-id 0x123", &["text: none of 9 lines is of a log by candump -L or of an ASC file"]);
    refuse(dir, "listen empty --can-id 0x123", &["empty: no frame of 0x123; the log is empty"]);
    refuse(dir, "listen zeros.log --can-id 0x123", &["3 frames of 0x123, but none is a segment"]);
    refuse(dir, "listen absent.log --can-id 0x123", &["absent.log: No such file"]);
    refuse(dir, "listen bus.log --can-id 0x123 --model absent.bwm", &["absent.bwm"]);
    refuse(dir, "listen bus.log", &["bus.log: no frame came", "the log of a CAN bus needs --can-id"]);
    for wrong in ["--can-id 291", "--can-id 0x800", "--can-id 0x123 --out t"] {
        assert_eq!(run(dir, &format!("listen bus.log {wrong}")).status.code(), Some(2), "{wrong}");
    }
}

/// The lines of a DBC file as its grammar has them; `python/tests/test_can.py` reads the file by another program.
#[test]
fn a_dbc_file_has_the_signals_of_the_core_and_the_names_of_the_model() {
    let folder = folder();
    let dir = folder.path();
    let text = succeed(dir, "dbc --model model.bwm --id 0x123");
    succeed(dir, "dbc --model model.bwm --id 0x123 --out drive.dbc");
    assert_eq!(std::fs::read_to_string(dir.join("drive.dbc")).expect("a file"), text);
    assert!(text.contains("BU_: Drive_123\n\nBO_ 291 Segment_123: 8 Drive_123\n"), "{text}");
    let signals: Vec<&str> = text.lines().filter(|line| line.starts_with(" SG_ ")).collect();
    assert_eq!(signals.len(), SegmentFrame::SIGNALS.len());
    for line in [
        " SG_ Undetermined : 21|3@1+ (1,0) [0|7] \"\" Vector__XXX",
        " SG_ Usable : 48|7@1+ (1,0) [0|127] \"%\" Vector__XXX",
        " SG_ Distance : 56|8@1+ (0.25,0) [0|63.75] \"sd\" Vector__XXX",
        "VAL_ 291 Verdict 0 \"undetermined\" 1 \"novel\" 2 \"ambiguous\" 3 \"healthy\" 4 \"spall\" 5 \"roughness\" ;",
        "VAL_ 291 Alarm 0 \"none\" 1 \"unknown\" 2 \"healthy\" 3 \"spall\" 4 \"roughness\" ;",
    ] {
        assert!(text.lines().any(|own| own == line), "{line}\n{text}");
    }
    assert!(text.contains(" 7 \"stuck sensor\" ") && !text.contains(" 11 \""), "{text}");
    assert!(text.contains("Channel: 0 current_a, 1 velocity_ref_rad_s"), "{text}");
    assert!(text.is_ascii() && text.lines().all(|line| line.matches('"').count().is_multiple_of(2)), "{text}");
    let extended = succeed(dir, "dbc --model model.bwm --id 0x18FF1234");
    assert!(extended.contains("BO_ 2566853172 Segment_18FF1234: 8 Drive_18FF1234\n"), "{extended}");
    refuse(dir, "dbc --model absent.bwm --id 0x123", &["absent.bwm"]);
    refuse(dir, "dbc --model model.bwm --id 0x123 --out model.bwm", &["model.bwm"]);
}

/// The table of the book is that of the core.
#[test]
fn the_book_has_the_signals_of_the_core() {
    let book = include_str!("../../../../book/src/firmware.md");
    let (_, table) = book.split_once("| signal | first bit |").expect("the table");
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split('|').skip(1).take(4).map(str::trim).collect()).collect();
    let signals = SegmentFrame::SIGNALS.map(|signal| {
        let step = format!("{} {}", signal.factor, signal.unit).trim().to_string();
        [format!("`{}`", signal.name), signal.start.to_string(), signal.length.to_string(), step]
    });
    assert_eq!(rows, signals);
}
