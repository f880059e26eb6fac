//! Command-line tests of `listen`: frames of a drive become lines and traces.

#[path = "../../../../examples/support/sender.rs"]
mod sender;
#[path = "../../../../examples/support/standard_rig/mod.rs"]
mod standard_rig;

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use bearing_watch::plan::Signals;
use bearing_watch::telemetry::{Encoder, Recorder, Source};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use standard_rig::model::{MODEL, Sample};

use crate::common::{refuse, run, succeed};
use crate::form::{fit, schema};

pub fn frames() -> Vec<Vec<u8>> {
    let mut frames = Vec::new();
    sender::run(|frame| frames.push(frame.to_vec())).expect("frames fit");
    frames
}

/// The rows of a trace without its time, as bits in single precision.
fn bits(file: &Path) -> Vec<Vec<u32>> {
    let text = std::fs::read_to_string(file).expect("a trace");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("t_s,current_a,velocity_ref_rad_s,load_torque_nm"));
    let exact = |cell: &str| {
        let value: f64 = cell.parse().expect("a number");
        assert_eq!(f64::from(value as f32), value, "{cell} is not that of single precision");
        (value as f32).to_bits()
    };
    lines.map(|line| line.split(',').skip(1).map(exact).collect()).collect()
}

fn recorded() -> Vec<Vec<u32>> {
    let bits = |sample| [0, 1, 2].map(|channel| Signals::value(&sample, channel).to_bits()).to_vec();
    standard_rig::samples().map(bits).collect()
}

fn values(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

#[test]
fn reports_are_shown_and_samples_written_bit_for_bit() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    std::fs::write(dir.join("frames.bin"), frames().concat()).expect("writable");
    let text = succeed(dir, "listen frames.bin --out traces");
    for words in [
        "model 00000001, session 1: current_a in A, velocity_ref_rad_s in rad/s, load_torque_nm in N·m every 0.002 s",
        "segment 2  spall  [healthy 0.000, spall 1.000, roughness 0.000]",
        "trace_001.csv: 5000 samples from number 5001 on",
        "381 frames, 0 bad, 0 lost, 0 repeated; 15000 samples written to 3 files",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    let recorded = recorded();
    for (number, part) in recorded.chunks(5000).enumerate() {
        assert!(bits(&dir.join(format!("traces/trace_00{number}.csv"))) == part, "trace {number}");
    }
    // Again, as JSON, through a pipe: the files that are there stay.
    let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    command.current_dir(dir).args(["listen", "-", "--json", "--out", "traces"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("the command starts");
    child.stdin.take().expect("a pipe").write_all(&frames().concat()).expect("the command reads");
    let output = child.wait_with_output().expect("the command ends");
    assert!(output.status.success());
    let found = values(&String::from_utf8_lossy(&output.stdout));
    let kinds: Vec<_> = found.iter().filter_map(|value| value["kind"].as_str()).collect();
    assert_eq!(kinds, ["hello", "report", "trace", "report", "trace", "report", "trace", "end"]);
    assert_eq!((found[3]["class"].as_str(), found[3]["segment"].as_u64()), (Some("spall"), Some(2)));
    assert_eq!(found[6]["file"], "trace_005.csv");
    assert_eq!((found[7]["samples"].as_u64(), found[7]["lost"].as_u64()), (Some(15_000), Some(0)));
    assert_eq!(std::fs::read_dir(dir.join("traces")).expect("folder").count(), 6, "no temporary file is left");
}

#[test]
fn of_a_disturbed_line_only_right_samples_are_written() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut line = frames().concat();
    for _ in 0..60 {
        let place = random.random_range(200..line.len());
        match random.random_range(0..3) {
            0 => line[place] ^= 1 << random.random_range(0..8),
            1 => drop(line.drain(place..(place + random.random_range(1..700)).min(line.len()))),
            _ => {
                let again = line[place..(place + random.random_range(1..700)).min(line.len())].to_vec();
                drop(line.splice(place..place, again));
            }
        }
    }
    std::fs::write(dir.join("frames.bin"), line).expect("writable");
    let found = values(&succeed(dir, "listen frames.bin --out traces --json"));
    let schema = schema("listen");
    found.iter().for_each(|line| fit(&schema, line));
    let recorded = recorded();
    let (mut samples, mut files) = (0, 0);
    for trace in found.iter().filter(|value| value["kind"] == "trace") {
        let rows = bits(&dir.join("traces").join(trace["file"].as_str().expect("a name")));
        let first = trace["first"].as_u64().expect("a number") as usize;
        // The sender skips a number between its traces.
        let start = first - first / 5001;
        assert!(rows == recorded[start..start + rows.len()], "{trace}");
        assert!(first / 5001 == (first + rows.len() - 1) / 5001, "no trace goes over a gap: {trace}");
        samples += rows.len();
        files += 1;
    }
    let end = found.last().expect("the end");
    assert_eq!((end["samples"].as_u64(), end["files"].as_u64()), (Some(samples as u64), Some(files)));
    // Each of 60 errors damages a frame or two of 40 samples, and 60 files at most are cut by them.
    assert!((10_000..15_000).contains(&samples) && (20..=63).contains(&files), "{end}");
    assert!(end["bad"].as_u64() > Some(20) && end["lost"].as_u64() > Some(20), "{end}");
}

/// A frame whose checksum is right, with any numbers and content: the others are received as if it had not come.
#[test]
fn one_forged_frame_drops_no_other_and_acts_on_no_terminal() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let good = frames();
    let receive = |name: &str, line: &[Vec<u8>]| {
        std::fs::write(dir.join("frames.bin"), line.concat()).expect("writable");
        let text = succeed(dir, &format!("listen frames.bin --out {name}"));
        let mut rows = Vec::new();
        let mut files: Vec<_> =
            std::fs::read_dir(dir.join(name)).expect("traces").map(|e| e.expect("one").path()).collect();
        files.sort();
        files.iter().for_each(|file| rows.extend(bits(file)));
        (text, rows)
    };
    let (_, all) = receive("good", &good);
    let hello = contents(&good[0]);
    let (at, samples) = (4, contents(&good[4]));
    for (number, content) in [&hello, &samples].into_iter().enumerate() {
        for stream in [None, Some(0xdead_beef_u32)] {
            for sequence in [200_u32, 1 << 20, u32::MAX] {
                let mut forged = content.clone();
                if let Some(stream) = stream {
                    forged[2..6].copy_from_slice(&stream.to_le_bytes());
                }
                forged[6..10].copy_from_slice(&sequence.to_le_bytes());
                // A letter of a name becomes a control of the terminal.
                if let Some(place) = forged.windows(9).position(|own| own == b"current_a") {
                    forged[place] = 0x1b;
                }
                let mut line = good.clone();
                line.insert(at + 20, framed(forged));
                let name = format!("t{number}_{}_{sequence}", stream.is_some());
                let (text, rows) = receive(&name, &line);
                assert!(!text.contains('\u{1b}'), "{text:?}");
                let received: std::collections::HashSet<_> = rows.iter().collect();
                let lost = all.iter().filter(|row| !received.contains(row)).count();
                assert_eq!(lost, 0, "{name}: of {} rows\n{text}", all.len());
                assert!(rows.len() <= all.len() + 40, "{name}");
                assert_eq!(text.matches("spall  [").count(), 1, "{text}");
            }
        }
    }
}

/// The content of a frame without its checksum.
pub fn contents(frame: &[u8]) -> Vec<u8> {
    let stuffed: Vec<u8> = frame.iter().copied().filter(|byte| *byte != 0).collect();
    let mut content = vec![0; stuffed.len()];
    let length = cobs::decode(&stuffed, &mut content).expect("a frame");
    content.truncate(length - 4);
    content
}

/// A frame of a content.
pub fn framed(mut content: Vec<u8>) -> Vec<u8> {
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&content);
    content.extend(checksum.to_le_bytes());
    let mut stuffed = vec![0; cobs::max_encoding_length(content.len())];
    let length = cobs::encode(&content, &mut stuffed);
    [&[0], &stuffed[..length], &[0]].concat()
}

#[test]
fn received_traces_train_the_model_of_the_sent_ones() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    succeed(dir, "simulate --class healthy,spall --count 5 --seed 4 --out simulated");
    let simulated = std::fs::read_to_string(dir.join("simulated/labels.csv")).expect("labels");
    let mut encoder = Encoder::new(&MODEL, Source::default());
    let mut recorder = Recorder::<_, 480>::new(MODEL.plan());
    let (mut line, mut buffer, mut labels) = (Vec::new(), [0; 512], String::from("trace,class_name\n"));
    line.extend_from_slice(encoder.hello(&mut buffer).expect("fits"));
    std::fs::create_dir(dir.join("direct")).expect("a folder");
    for (number, row) in simulated.lines().skip(1).enumerate() {
        let mut cells = row.split(',');
        let (name, class) = (cells.next().expect("a trace"), cells.next().expect("a class"));
        labels += &format!("trace_{number:03},{class}\n");
        let file = dir.join("simulated").join(name).with_extension("csv");
        let mut text = String::from("t_s,current_a,velocity_ref_rad_s,load_torque_nm\n");
        for (k, sample) in samples(&file).into_iter().enumerate() {
            let Sample { current_a, velocity_ref_rad_s, load_torque_nm } = sample;
            let [i, v, load] = [current_a, velocity_ref_rad_s, load_torque_nm].map(f64::from);
            text += &format!("{},{i},{v},{load}\n", 0.002 * k as f64);
            if recorder.push(&sample) {
                line.extend_from_slice(encoder.samples(&recorder.block(), &mut buffer).expect("fits"));
                recorder.clear();
            }
        }
        recorder.skip(1);
        std::fs::write(dir.join(format!("direct/trace_{number:03}.csv")), text).expect("writable");
    }
    std::fs::write(dir.join("frames.bin"), line).expect("writable");
    succeed(dir, "listen frames.bin --out received");
    let models = ["direct", "received"].map(|name| {
        let own = dir.join(name);
        std::fs::write(own.join("labels.csv"), &labels).expect("writable");
        let signals = "--y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm --order 2,1,2,1,1";
        succeed(&own, &format!("train --labels labels.csv {signals} --model m.bwm"));
        std::fs::read(own.join("m.bwm")).expect("a model")
    });
    assert!(models[0] == models[1], "the models differ");
}

/// The samples of a simulated trace in single precision.
fn samples(file: &Path) -> Vec<Sample> {
    let text = std::fs::read_to_string(file).expect("a trace");
    let (head, rows) = text.split_once('\n').expect("a heading");
    let place = |name: &str| head.split(',').position(|own| own == name).expect("a column");
    let places = ["current_a", "velocity_ref_rad_s", "load_torque_nm"].map(place);
    let sample = |row: &str| {
        let cells: Vec<&str> = row.split(',').collect();
        let value = |place: usize| cells[place].parse::<f64>().expect("a number") as f32;
        let [current_a, velocity_ref_rad_s, load_torque_nm] = places.map(value);
        Sample { current_a, velocity_ref_rad_s, load_torque_nm }
    };
    rows.lines().map(sample).collect()
}

#[test]
fn samples_that_are_no_numbers_and_samples_without_names_are_not_written() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let mut encoder = Encoder::new(&MODEL, Source::default());
    let mut recorder = Recorder::<_, 120>::new(MODEL.plan());
    let (mut line, mut buffer) = (Vec::new(), [0; 512]);
    for k in 0..40 {
        let current_a = if k == 27 { f32::NAN } else { 0.1 * k as f32 };
        if recorder.push(&Sample { current_a, velocity_ref_rad_s: 1.0, load_torque_nm: -0.0 }) {
            line.extend_from_slice(encoder.samples(&recorder.block(), &mut buffer).expect("fits"));
            recorder.clear();
        }
        if k == 10 {
            line.extend_from_slice(encoder.hello(&mut buffer).expect("fits"));
        }
    }
    std::fs::write(dir.join("frames.bin"), line).expect("writable");
    let text = succeed(dir, "listen frames.bin --out traces");
    assert!(text.contains("trace_000.csv: 17 samples from number 10 on\n"), "{text}");
    assert!(text.contains("trace_001.csv: 12 samples from number 28 on\n"), "{text}");
    assert!(text.contains("29 samples written to 2 files, 1 not numbers, 10 before the names"), "{text}");
}

#[test]
fn what_is_no_telemetry_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    std::fs::write(dir.join("text"), "no frames\n".repeat(100)).expect("writable");
    std::fs::write(dir.join("damaged"), frames().concat().iter().map(|byte| byte ^ 4).collect::<Vec<_>>())
        .expect("writable");
    std::fs::write(dir.join("empty"), "").expect("writable");
    refuse(dir, "listen absent", &["error: absent: No such file"]);
    refuse(dir, "listen .", &["error: .: Is a directory"]);
    refuse(dir, "listen empty", &["empty: no frame came; check the line"]);
    refuse(dir, "listen text", &["text: no frame came"]);
    refuse(dir, "listen damaged --out traces", &["damaged: no frame among", "check --baud"]);
    refuse(dir, "listen text --out empty", &["--out empty is a file"]);
    refuse(dir, "listen text --seconds 0", &["--seconds is a number above 0"]);
    refuse(dir, "listen text --baud 0", &["--baud"]);
}

/// A pair of pseudo-terminals stands for a serial port.
#[cfg(target_os = "linux")]
#[test]
fn a_serial_port_is_read_until_the_time_is_over() {
    use std::os::fd::AsRawFd as _;
    let (drive, port) = serial2::SerialPort::pair().expect("pseudo-terminals");
    let name = std::fs::read_link(format!("/proc/self/fd/{}", port.as_raw_fd())).expect("a name");
    let folder = tempfile::tempdir().expect("folder");
    // Less than the 4 kB that wait in a terminal.
    drive.write_all(&frames()[..4].concat()).expect("writable");
    let text = succeed(folder.path(), &format!("listen {} --baud 921600 --seconds 0.6 --out t", name.display()));
    assert!(text.contains("4 frames, 0 bad, 0 lost, 0 repeated; 120 samples written to 1 files"), "{text}");
    let output = run(folder.path(), "listen /dev/null");
    assert_eq!(output.status.code(), Some(2), "a device that is no serial port");
}
