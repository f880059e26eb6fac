//! `bearing-watch listen`

mod live;
mod names;
mod raw;
pub(super) mod receiver;
mod source;
mod traces;
mod words;

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use bearing_watch::telemetry::Decoder;

use super::serve::stop_flag;
use live::View;
use model::Error;
use receiver::{Output, Receiver};
use traces::Traces;

/// Longest content of a frame.
const LONGEST: usize = 16_384;
/// How long to wait for bytes before the end of time is checked.
const PATIENCE: Duration = Duration::from_millis(50);

/// Show the reports of a drive as they come, and write its recorded samples as traces
///
/// Takes the frames of the core's `telemetry`. Lost, doubled and damaged frames are counted. Samples become one CSV
/// file for each uninterrupted series, with the channels' names as columns: at a missing sample, and at one that is no
/// number, a new file starts. Raw samples at the control rate become files raw_000.csv and so on, for --front-end of
/// `train`, with the columns phase_a_counts, phase_b_counts and, of a third sensor, phase_c_counts; angle_counts (32
/// bits a turn), or sin and cos; and those of --further. The end of the source, --seconds or Ctrl-C ends it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch listen /dev/ttyUSB0 --baud 921600 --out traces")]
pub(super) struct Args {
    /// Serial port, file, or - for standard input
    source: String,
    /// Bits a second of a serial port
    #[arg(long, default_value_t = 115_200, value_parser = clap::value_parser!(u32).range(1..))]
    baud: u32,
    /// Folder for the traces, trace_000.csv and so on; existing files stay
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Names of the further channels of raw samples, in their order; by default further_1 and so on
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    further: Vec<String>,
    /// Also serve a page with the reports and samples as they come, on this port of 127.0.0.1; 0 is any free one. The
    /// page stays after the end of the source, until --seconds or Ctrl-C
    #[arg(long, value_name = "PORT")]
    view: Option<u16>,
    /// End after this time
    #[arg(long)]
    seconds: Option<f64>,
    /// Print one JSON object a line
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let deadline = args.deadline()?;
    let traces = args.out.as_deref().map(Traces::new).transpose()?;
    let stopped = stop_flag()?;
    let chunks = source::open(&args.source, args.baud);
    let mut decoder = Box::new(Decoder::<LONGEST>::new());
    let view = args.view.map(|port| View::open(port, &stopped)).transpose()?;
    let mut receiver = Receiver::new(Output::printed(args.json), traces, args.further.clone());
    if let Some((view, address)) = view {
        receiver.show(view, &address)?;
    }
    let mut failure = None;
    let goes_on = || !stopped.load(Ordering::Relaxed) && deadline.is_none_or(|end| Instant::now() < end);
    while goes_on() {
        match chunks.recv_timeout(PATIENCE) {
            Ok(Ok(bytes)) => {
                feed(&mut decoder, &bytes, &mut receiver)?;
            }
            Ok(Err(error)) => failure = Some(error),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    while args.view.is_some() && failure.is_none() && goes_on() {
        std::thread::sleep(PATIENCE);
    }
    let counts = decoder.counts();
    if let Some(error) = failure {
        // What came before the failure is kept.
        if counts.frames > 0 {
            receiver.end(counts)?;
        }
        return Err(Error::io(&args.source)(error));
    }
    if counts.frames == 0 {
        return Err(Error::Usage(format!("{}: {}", args.source, words::nothing(counts))));
    }
    receiver.end(counts)
}

/// Takes what came over a line, writes its samples to this folder, and shows it by `output`; for attacks.
pub(super) fn taken(bytes: &[u8], folder: &Path, output: Output) -> Result<(), Error> {
    let mut decoder = Box::new(Decoder::<LONGEST>::new());
    let mut receiver = Receiver::new(output, Some(Traces::new(folder)?), vec![]);
    receiver.show(View::unserved(), "")?;
    feed(&mut decoder, bytes, &mut receiver)?;
    receiver.end(decoder.counts())
}

/// Gives the receiver the frames that these bytes complete.
fn feed(decoder: &mut Decoder<LONGEST>, bytes: &[u8], receiver: &mut Receiver) -> Result<(), Error> {
    for byte in bytes {
        if let Some(frame) = decoder.push(*byte) {
            receiver.take(&frame)?;
        }
    }
    Ok(())
}

impl Args {
    fn deadline(&self) -> Result<Option<Instant>, Error> {
        let Some(seconds) = self.seconds else { return Ok(None) };
        let length = Duration::try_from_secs_f64(seconds).ok().filter(|length| !length.is_zero());
        let end = length.and_then(|length| Instant::now().checked_add(length));
        let refusal = || Error::Usage("--seconds is a number above 0".into());
        end.map(Some).ok_or_else(refusal)
    }
}
