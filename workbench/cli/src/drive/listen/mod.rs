//! `bearing-watch listen`

mod alarm;
#[cfg(target_os = "linux")]
mod bus;
mod can;
mod live;
mod names;
mod raw;
pub(crate) mod receiver;
mod report_text;
mod source;
mod traces;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use bearing_watch::telemetry::Decoder;

use crate::server::stop_flag;

use crate::drive::can_id::CanId;
use can::{Listener, Stream};
use live::{Place, View};
use model::Error;
use model::session::ModelFile;
use names::Names;
use receiver::{Output, Receiver};
use source::Chunks;
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
///
/// With --can-id or --can-stream the source is a CAN interface of Linux such as can0, or the log of a CAN bus, as
/// `candump -L` prints it or as an ASC file. The frames of --can-id are segments (SegmentFrame, bw_can_frame): they are
/// shown with their alarm, and lost, repeated and withdrawn ones are counted. A drive that counts from 1 again has
/// started again. The frames of --can-stream are pieces of the telemetry (CanPieces, bw_can_stream): reports and
/// recordings as over a serial line.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  bearing-watch listen /dev/ttyUSB0 --baud 921600 --out traces\n  \
                  bearing-watch listen can0 --can-id 0x123 --model model.bwm\n  \
                  bearing-watch listen can0 --can-stream 0x124 --out traces")]
pub(crate) struct Args {
    /// Serial port, CAN interface of Linux, file, or - for standard input
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
    /// page stays after the end of the source, until --seconds or Ctrl-C. Instead of a port, - prints the page and its
    /// news as JSON
    #[arg(long, value_name = "PORT")]
    view: Option<Place>,
    /// Identifier of the frames of segments on a CAN bus; more than three digits are an extended one
    #[arg(long, value_name = "ID", value_parser = CanId::parse)]
    #[arg(conflicts_with_all = ["baud", "out", "further", "view"])]
    can_id: Option<CanId>,
    /// Identifier of the pieces of the telemetry on a CAN bus
    #[arg(long, value_name = "ID", value_parser = CanId::parse, conflicts_with_all = ["baud", "can_id"])]
    can_stream: Option<CanId>,
    /// The model of the drive, which has the names of its bearing orders, and on a CAN bus, whose frames have numbers
    /// only, those of classes and features
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// End after this time
    #[arg(long)]
    seconds: Option<f64>,
    /// Print one JSON object a line
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    #[cfg(target_os = "linux")]
    if args.can_id.or(args.can_stream).is_none() && bus::is_bus(&args.source) {
        return Err(Error::Usage(format!(
            "{} is a CAN interface: give the identifier of the drive, --can-id of its segments or --can-stream",
            args.source
        )));
    }
    let line = Line { args, deadline: args.deadline()?, stopped: stop_flag()? };
    let file = args.model.as_deref().map(ModelFile::read).transpose()?;
    let names = file.as_ref().map(Names::of_model);
    match args.can_id {
        Some(id) => segments(&line, id, names.unwrap_or_default()),
        None => frames(&line, names),
    }
}

/// Segments from the log of a CAN bus.
fn segments(line: &Line<'_>, id: CanId, names: Names) -> Result<(), Error> {
    let mut listener = Listener::new(id, names, Output::printed(line.args.json));
    if let Some(error) = line.receive(|bytes| listener.take(bytes))? {
        // What came before the failure is kept.
        if listener.has_segments() {
            listener.end(&line.args.source)?;
        }
        return Err(error);
    }
    listener.end(&line.args.source)
}

/// Frames of a serial line, or of a CAN bus that carries its bytes.
fn frames(line: &Line<'_>, names: Option<Names>) -> Result<(), Error> {
    let args = line.args;
    let traces = args.out.as_deref().map(Traces::new).transpose()?;
    let mut decoder = Box::new(Decoder::<LONGEST>::new());
    let view = args.view.map(|place| View::open(place, &line.stopped)).transpose()?;
    let mut receiver = Receiver::new(Output::printed(args.json), traces, args.further.clone()).with_model(names);
    if let Some((view, address)) = view {
        receiver.show(view, address)?;
    }
    let mut stream = args.can_stream.map(Stream::of);
    let failure = line.receive(|bytes| match &mut stream {
        Some(stream) => feed(&mut decoder, &stream.take(bytes), &mut receiver),
        None => feed(&mut decoder, bytes, &mut receiver),
    })?;
    if let Some(stream) = &mut stream {
        feed(&mut decoder, &stream.rest(), &mut receiver)?;
    }
    while matches!(args.view, Some(Place::Port(_))) && failure.is_none() && line.goes_on() {
        std::thread::sleep(PATIENCE);
    }
    let counts = decoder.counts();
    if let Some(error) = failure {
        // What came before the failure is kept.
        if counts.frames > 0 {
            receiver.end(counts)?;
        }
        return Err(error);
    }
    if let Some(stream) = &stream {
        if let Some(reason) = stream.nothing() {
            return Err(Error::Usage(format!("{}: {reason}", args.source)));
        }
        receiver.tell(stream.line(), stream.value())?;
    }
    if counts.frames == 0 {
        let log = [".log", ".asc"].iter().any(|end| args.source.to_ascii_lowercase().ends_with(end));
        let hint = if log { "; the log of a CAN bus needs --can-id or --can-stream" } else { "" };
        return Err(Error::Usage(format!("{}: {}{hint}", args.source, report_text::nothing(counts))));
    }
    receiver.end(counts)
}

/// A source, and until when it is listened to.
struct Line<'a> {
    args: &'a Args,
    deadline: Option<Instant>,
    stopped: Arc<AtomicBool>,
}

impl Line<'_> {
    fn goes_on(&self) -> bool {
        !self.stopped.load(Ordering::Relaxed) && self.deadline.is_none_or(|end| Instant::now() < end)
    }

    /// Takes the bytes of the source until its end, or the set one; returns why the source failed.
    fn receive(&self, mut take: impl FnMut(&[u8]) -> Result<(), Error>) -> Result<Option<Error>, Error> {
        let mut chunks = Chunks::open(&self.args.source, self.args.baud);
        let mut failure = None;
        while self.goes_on() {
            match chunks.next(PATIENCE) {
                Ok(Ok(bytes)) => take(&bytes)?,
                Ok(Err(error)) => failure = Some(Error::io(&self.args.source)(error)),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        Ok(failure)
    }
}

/// Takes the log of a CAN bus, and shows the segments of the identifier 0x123 by `output`; for attacks.
pub(crate) fn taken_log(bytes: &[u8], output: Output) -> Result<(), Error> {
    let id = CanId { number: 0x123, extended: false };
    let mut listener = Listener::new(id, Names::default(), output);
    listener.take(bytes)?;
    listener.end("log")
}

/// Takes what came over a line, writes its samples to this folder, and shows it by `output`; for attacks.
pub(crate) fn taken(bytes: &[u8], folder: &Path, output: Output) -> Result<(), Error> {
    let mut decoder = Box::new(Decoder::<LONGEST>::new());
    let mut receiver = Receiver::new(output, Some(Traces::new(folder)?), vec![]);
    receiver.show(View::unserved(), None)?;
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
