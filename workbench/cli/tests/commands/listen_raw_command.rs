//! Command-line tests of `listen`: raw samples of a drive become recordings for `--front-end`.

use std::path::Path;

use bearing_watch::Angle;
use bearing_watch::drive::{PhaseCounts, Position, RawSample};
use bearing_watch::telemetry::{RawEncoder, RawRecorder, Source};

use crate::common::{refuse, succeed};

/// Frames of the samples of a session, without a model.
fn frames<const FURTHER: usize>(
    session: u32,
    rate_hz: f32,
    samples: impl IntoIterator<Item = RawSample<FURTHER>>,
) -> Vec<u8> {
    let mut encoder = RawEncoder::new(Source { model_id: 0, session });
    let mut recorder = RawRecorder::<FURTHER, 400>::new(rate_hz);
    let (mut line, mut buffer) = (Vec::new(), [0; 512]);
    for sample in samples {
        if recorder.push(&sample) {
            line.extend_from_slice(encoder.raw(&recorder.block(), &mut buffer).expect("fits"));
            recorder.clear();
        }
    }
    line.extend_from_slice(encoder.raw(&recorder.block(), &mut buffer).expect("fits"));
    line
}

/// A sample of two currents and a resolver.
fn resolved(number: u32) -> RawSample<1> {
    let position = if number == 2 { Position::Missing } else { Position::Resolver { sin: 0.5, cos: -0.75 } };
    let further = [if number == 1 { f32::NAN } else { 2.5 }];
    RawSample { number, currents: PhaseCounts::Two([2048, 60_000]), position, further }
}

#[test]
fn raw_samples_are_written_with_what_is_missing_and_no_file_goes_over_a_gap() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let numbers = (0..3).chain(7..9);
    std::fs::write(dir.join("frames.bin"), frames(3, 4000.0, numbers.map(resolved))).expect("writable");
    let text = succeed(dir, "listen frames.bin --out traces");
    // The sample that shows the gap is in none of the two blocks.
    for words in ["raw_000.csv: 3 samples from number 0 on", "raw_001.csv: 1 samples from number 8 on"] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    let rows = std::fs::read_to_string(dir.join("traces/raw_000.csv")).expect("a trace");
    let expected = "t_s,phase_a_counts,phase_b_counts,sin,cos,further_1\n\
                    0,2048,60000,0.5,-0.75,2.5\n0.00025,2048,60000,0.5,-0.75,NaN\n0.0005,2048,60000,NaN,NaN,2.5\n";
    assert_eq!(rows, expected);
    refuse(dir, "listen frames.bin --out other --further a,b", &["--further names 2 channels; the raw samples have 1"]);
}

/// The rows of a simulated trace as the drive reads them, with command and load.
fn recorded(file: &Path) -> Vec<RawSample<2>> {
    let text = std::fs::read_to_string(file).expect("a trace");
    let (head, rows) = text.split_once('\n').expect("a heading");
    let place = |name: &str| head.split(',').position(|own| own == name).expect("a column");
    let [a, b, c, counts, command, load] =
        ["phase_a_a", "phase_b_a", "phase_c_a", "resolver_counts", "velocity_ref_rad_s", "load_torque_nm"].map(place);
    let sample = |(number, row): (u32, &str)| {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().expect("a number")).collect();
        // Offset and gain of the rig's front end.
        let phase = |place: usize| (2048.0 + cells[place] / f64::from(0.025_f32)).round() as u16;
        RawSample {
            number,
            currents: PhaseCounts::Three([a, b, c].map(phase)),
            position: Position::Absolute(Angle::from_counts(cells[counts] as u32, 14)),
            further: [command, load].map(|place| cells[place] as f32),
        }
    };
    (0..).zip(rows.lines()).map(sample).collect()
}

#[test]
fn received_raw_samples_have_the_estimates_of_the_recorded_ones() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --rig ema --class healthy,roughness --count 1 --seed 6 --out direct");
    let labels = std::fs::read_to_string(dir.join("direct/labels.csv")).expect("labels");
    let front_end = std::fs::read_to_string(dir.join("direct/front_end.toml")).expect("a front end");
    let counts = front_end
        .replace("phase_a_a", "phase_a_counts")
        .replace("phase_b_a", "phase_b_counts")
        .replace("phase_c_a", "phase_c_counts")
        .replace("\"amperes\"", "\"counts\"")
        .replace("resolver_counts", "angle_counts")
        .replace("bits = 14", "bits = 32");
    std::fs::create_dir(dir.join("received")).expect("a folder");
    std::fs::write(dir.join("received/front_end.toml"), counts).expect("writable");
    let mut line = Vec::new();
    for (session, row) in (0..).zip(labels.lines().skip(1)) {
        let (name, _) = row.split_once(',').expect("a trace and its class");
        line.extend(frames(session, 1200.0, recorded(&dir.join("direct").join(name))));
    }
    std::fs::write(dir.join("frames.bin"), line).expect("writable");
    let text = succeed(dir, "listen frames.bin --further velocity_ref_rad_s,load_torque_nm --out received");
    assert!(text.contains("written to 2 files"), "{text}");
    // The estimates of each trace, without its name.
    let estimates = ["direct", "received"].map(|name| {
        let own = dir.join(name);
        let traces: Vec<String> = std::fs::read_dir(&own)
            .expect("a folder")
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .filter(|name| name.ends_with(".csv") && name != "labels.csv")
            .collect();
        let mut traces = traces;
        traces.sort();
        let signals = "--y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,2,1,1";
        let text = succeed(&own, &format!("identify {} --front-end front_end.toml {signals}", traces.join(" ")));
        traces.iter().fold(text, |text, name| text.replace(name.trim_end_matches(".csv"), "TRACE"))
    });
    println!("{}", estimates[0]);
    assert_eq!(estimates[0], estimates[1]);
}
