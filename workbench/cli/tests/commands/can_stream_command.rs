//! Command-line tests of `listen --can-stream`: reports and samples over a CAN bus, as over a serial line, with losses,
//! doubles and other nodes' frames.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use bearing_watch::telemetry::CanPieces;
use serde_json::Value;

use crate::common::{refuse, succeed};
use crate::form::{fit, schema};
use crate::listen_command::frames;

/// A log by `candump` of the sender's frames, and the number of their data frames; other nodes speak between them.
/// `on_bus` says how often a data frame is in the log.
fn log(mut pieces: CanPieces, on_bus: impl Fn(usize) -> usize) -> (String, usize) {
    let (mut text, mut count) = (String::new(), 0);
    for frame in frames() {
        for piece in pieces.cut(&frame) {
            let time = 1.7e9 + 1e-3 * count as f64;
            let data: String = piece.data().iter().map(|byte| format!("{byte:02X}")).collect();
            let mark = if piece.data().len() > 8 { "##1" } else { "#" };
            for _ in 0..on_bus(count) {
                writeln!(text, "({time:.6}) can0 124{mark}{data}").expect("memory");
            }
            if count % 7 == 3 {
                writeln!(text, "({time:.6}) can0 321#0011\n({time:.6}) can1 124#0001").expect("memory");
            }
            count += 1;
        }
    }
    (text, count)
}

fn listen(dir: &Path, source: &str, folder: &str) -> Vec<Value> {
    let stream = if source.ends_with(".log") { "--can-stream 0x124 " } else { "" };
    let text = succeed(dir, &format!("listen {source} {stream}--out {folder} --json"));
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    lines.iter().for_each(|line| fit(&schema("listen"), line));
    lines
}

#[test]
fn a_bus_gives_what_a_serial_line_gives() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    fs::write(dir.join("frames.bin"), frames().concat()).expect("writable");
    let line = listen(dir, "frames.bin", "line");
    for (name, pieces) in [("classic", CanPieces::classic()), ("fd", CanPieces::fd().with_number(200))] {
        // Every tenth data frame comes twice.
        let (text, count) = log(pieces, |place| 1 + usize::from(place % 10 == 5));
        fs::write(dir.join(format!("{name}.log")), text).expect("writable");
        let mut bus = listen(dir, &format!("{name}.log"), name);
        let place = bus.iter().position(|line| line["kind"] == "can").expect("what the bus had");
        let can = bus.remove(place);
        assert_eq!(can["id"], "0x124");
        assert_eq!((can["frames"].as_u64(), can["lost"].as_u64()), (Some(count as u64), Some(0)));
        assert_eq!((can["repeated"].as_u64(), can["bad"].as_u64()), (Some((count as u64 + 4) / 10), Some(0)));
        assert!(can["other_ids"].as_u64() > Some(300) && can["other_buses"] == can["other_ids"], "{can}");
        assert_eq!(bus, line);
        for number in 0..3 {
            let file = format!("trace_00{number}.csv");
            let read = |folder: &str| fs::read(dir.join(folder).join(&file)).expect("a trace");
            assert!(read(name) == read("line"), "{name}/{file}");
        }
    }
}

#[test]
fn each_lost_data_frame_costs_the_frame_that_it_is_of() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    // The hello at the start is whole.
    let is_lost = |place: usize| place > 100 && place.is_multiple_of(997);
    let (text, count) = log(CanPieces::classic(), |place| usize::from(!is_lost(place)));
    fs::write(dir.join("lossy.log"), text).expect("writable");
    let lines = listen(dir, "lossy.log", "traces");
    let lost = (0..count).filter(|place| is_lost(*place)).count() as u64;
    let of_kind = |kind: &str| lines.iter().find(|line| line["kind"] == kind).expect("a line");
    let [can, end] = ["can", "end"].map(of_kind);
    assert_eq!(can["lost"].as_u64(), Some(lost));
    assert!(lost > 20, "{lost}");
    // What is left of a cut frame is one piece before the gap and one behind it.
    assert!(
        end["lost"].as_u64() == Some(lost) && (lost..=2 * lost).contains(&end["bad"].as_u64().expect("bad")),
        "{end}"
    );
    let samples = end["samples"].as_u64().expect("samples");
    assert!((15_000 - 40 * lost..15_000).contains(&samples), "{end}");
}

#[test]
fn a_log_without_the_stream_is_one_line() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    fs::write(dir.join("other.log"), "(1.0) can0 321#0011\n").expect("writable");
    fs::write(dir.join("short.log"), "(1.0) can0 124#00\n").expect("writable");
    refuse(dir, "listen other.log --can-stream 0x124", &["other.log: no frame of 0x124 among 1 others"]);
    refuse(dir, "listen short.log --can-stream 0x124", &["1 frames of 0x124, but none is a piece of a stream"]);
    refuse(dir, "listen other.log --can-stream 0x124 --can-id 0x123", &["--can-id"]);
}
