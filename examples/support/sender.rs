//! A monitor that sends its reports and all its samples as frames: what a drive does with a serial port.

use bearing_watch::telemetry::{Encoder, Recorder, Source, TooSmall};
use bearing_watch::{Detector, Evidence};

use super::standard_rig;
use super::standard_rig::model::MODEL;

/// Bytes of a block: 40 samples of 12 bytes.
const BLOCK: usize = 480;
/// Samples of a recorded trace.
pub const TRACE: u32 = 5000;

/// Sends a hello before each of the recorded traces, their samples, and a report of each.
pub fn run(mut send: impl FnMut(&[u8])) -> Result<(), TooSmall> {
    let mut monitor = Detector::new(&MODEL);
    let mut evidence = Evidence::new(&MODEL);
    // A drive counts its power-ups.
    let mut encoder = Encoder::new(&MODEL, Source { model_id: 1, session: 1 });
    let mut recorder = Recorder::<_, BLOCK>::new(MODEL.plan());
    let mut buffer = [0; 512];
    for (number, sample) in (0_u32..).zip(standard_rig::samples()) {
        if number % TRACE == 0 {
            // The recordings do not continue each other; a drive's samples do.
            recorder.skip(u32::from(number > 0));
            send(encoder.hello(&mut buffer)?);
        }
        if recorder.push(&sample) {
            send(encoder.samples(&recorder.block(), &mut buffer)?);
            recorder.clear();
        }
        if let Some(report) = monitor.step(&sample) {
            evidence.observe(report.decision.as_ref());
            send(encoder.report(&report, &evidence, &mut buffer)?);
            monitor.restart();
        }
    }
    Ok(())
}
