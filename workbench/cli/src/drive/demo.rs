//! `bearing-watch demo-drive`

use std::io::{BufRead as _, Write};

use bearing_watch::plan::RunTime;
use bearing_watch::telemetry::{Encoder, Recorder, Source, TooSmall};

use crate::command_line::output;
use model::Error;
use model::core::{Embedded, Stream};
use model::trace::Trace;
use studies::demo_drive::{TRAINING, Wrong, learn, run as simulated};

/// Bytes of a block of samples, and of a frame.
const BLOCK: usize = 480;
const FRAME: usize = 16_384;

/// Simulate a drive with the detector in it, which sends its telemetry to standard output
///
/// The drive first learns from healthy runs of other drives what is usual. Then each line of standard input is a run,
/// from power-up to power-up, of two segments of ten seconds, and says what is wrong in it and how the drive is used:
/// spall=0…2 and roughness=0…2 (1 is a full defect), load=0…3 (1 is usual), temperature=20…100 in °C, and
/// fault=none, stuck-angle, no-load, reversed-current or current-gain. An empty line is a healthy run. At the end of
/// the input the drive ends.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  printf 'spall=0\\nspall=0.5\\nspall=0.5\\n' | bearing-watch demo-drive | bearing-watch listen -"
)]
pub(crate) struct Args {}

pub(crate) fn run() -> Result<(), Error> {
    let model = output::logged(|log| {
        let steps = log.steps("learning what is healthy", TRAINING as usize);
        learn(|| steps(1))
    })?;
    let mut drive = Sender::new(&model, std::io::stdout().lock());
    drive.hello()?;
    for (number, line) in (0..).zip(std::io::stdin().lock().lines()) {
        let line = line.map_err(Error::io("standard input"))?;
        let wrong: Wrong = line.parse().map_err(|error| Error::Usage(format!("line {}: {error}", number + 1)))?;
        let records = simulated(&wrong, number)?;
        for (k, record) in records.iter().enumerate() {
            drive.take(record, k + 1 == records.len())?;
        }
    }
    Ok(())
}

/// Detector, and what the drive sends of it.
struct Sender<'m, W: Write> {
    model: &'m Embedded,
    stream: Stream<'m>,
    encoder: Encoder<'m, RunTime>,
    recorder: Recorder<RunTime, BLOCK>,
    buffer: Vec<u8>,
    out: W,
}

impl<'m, W: Write> Sender<'m, W> {
    fn new(model: &'m Embedded, out: W) -> Self {
        let encoder = Encoder::new(model.model(), Source { model_id: 1, session: 1 });
        let recorder = Recorder::new(model.model().plan());
        Self { model, stream: model.stream(), encoder, recorder, buffer: vec![0; FRAME], out }
    }

    fn hello(&mut self) -> Result<(), Error> {
        send(&mut self.out, self.encoder.hello(&mut self.buffer))
    }

    /// A record through the detector: its samples and the report are sent.
    fn take(&mut self, record: &Trace, run_ends: bool) -> Result<(), Error> {
        let mut feed = self.model.feed(record);
        for k in 0..record.y.len() {
            if self.recorder.push(feed.at(k)) {
                send(&mut self.out, self.encoder.samples(&self.recorder.block(), &mut self.buffer))?;
                self.recorder.clear();
            }
        }
        self.stream.run(record, run_ends);
        let (Some(report), evidence) = (self.stream.report(), self.stream.evidence()) else { return Ok(()) };
        send(&mut self.out, self.encoder.report(report, evidence, &mut self.buffer))?;
        self.out.flush().map_err(Error::io("standard output"))
    }
}

fn send(out: &mut impl Write, frame: Result<&[u8], TooSmall>) -> Result<(), Error> {
    let frame = frame.map_err(|_| Error::Usage("a frame is too long".into()))?;
    out.write_all(frame).map_err(Error::io("standard output"))
}
