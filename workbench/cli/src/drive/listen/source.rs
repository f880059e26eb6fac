//! The bytes of a serial port, a CAN interface, a file or a pipe, read by a thread of their own. In a browser there are
//! no threads: the page waits with the program.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;
use std::sync::mpsc::RecvTimeoutError;
#[cfg(not(target_family = "wasm"))]
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::time::Duration;

#[cfg(target_os = "linux")]
use super::bus;

/// Bytes read at once, and how many such chunks wait.
const CHUNK: usize = 4096;
#[cfg(not(target_family = "wasm"))]
const WAITING: usize = 64;
/// A serial port returns after this time without a byte.
#[cfg(not(target_family = "wasm"))]
const SILENCE: Duration = Duration::from_millis(100);

type Chunk = io::Result<Vec<u8>>;

/// The chunks of a source: [`RecvTimeoutError::Disconnected`] is its end, after an error too.
#[cfg(not(target_family = "wasm"))]
pub(super) struct Chunks(Receiver<Chunk>);

#[cfg(not(target_family = "wasm"))]
impl Chunks {
    pub(super) fn open(source: &str, baud: u32) -> Self {
        let (sender, receiver) = mpsc::sync_channel(WAITING);
        let source = source.to_string();
        // Not joined: a pipe may be silent forever, and the thread ends with the program.
        std::thread::spawn(move || {
            let outcome = reader(&source, baud).and_then(|mut reader| pass_on(reader.as_mut(), &sender));
            if let Err(error) = outcome {
                let _listener_gone = sender.send(Err(error));
            }
        });
        Self(receiver)
    }

    pub(super) fn next(&mut self, patience: Duration) -> Result<Chunk, RecvTimeoutError> {
        self.0.recv_timeout(patience)
    }
}

/// The same of a page's program.
#[cfg(target_family = "wasm")]
pub(super) struct Chunks(Option<io::Result<Box<dyn Read>>>);

#[cfg(target_family = "wasm")]
impl Chunks {
    pub(super) fn open(source: &str, baud: u32) -> Self {
        Self(Some(reader(source, baud)))
    }

    pub(super) fn next(&mut self, _patience: Duration) -> Result<Chunk, RecvTimeoutError> {
        let mut buffer = vec![0; CHUNK];
        let read = match self.0.take().ok_or(RecvTimeoutError::Disconnected)? {
            Err(error) => return Ok(Err(error)),
            Ok(mut reader) => reader.read(&mut buffer).map(|count| (count, reader)),
        };
        match read {
            Ok((0, _)) => Err(RecvTimeoutError::Disconnected),
            Ok((count, reader)) => {
                self.0 = Some(Ok(reader));
                buffer.truncate(count);
                Ok(Ok(buffer))
            }
            Err(error) => Ok(Err(error)),
        }
    }
}

fn reader(source: &str, baud: u32) -> io::Result<Box<dyn Read>> {
    match source {
        "-" => Ok(Box::new(io::stdin())),
        name if is_serial(name) => serial(name, baud),
        #[cfg(target_os = "linux")]
        name if bus::is_bus(name) => bus::Bus::open(name).map(|bus| Box::new(bus) as Box<dyn Read>),
        name => File::open(name).map(|file| Box::new(file) as Box<dyn Read>),
    }
}

#[cfg(target_family = "wasm")]
fn serial(_name: &str, _baud: u32) -> io::Result<Box<dyn Read>> {
    Err(ErrorKind::Unsupported.into())
}

#[cfg(not(target_family = "wasm"))]
fn serial(name: &str, baud: u32) -> io::Result<Box<dyn Read>> {
    let mut port = serial2::SerialPort::open(name, baud)?;
    port.set_read_timeout(SILENCE)?;
    Ok(Box::new(port))
}

#[cfg(unix)]
fn is_serial(name: &str) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    std::fs::metadata(Path::new(name)).is_ok_and(|about| about.file_type().is_char_device())
}

#[cfg(not(unix))]
fn is_serial(name: &str) -> bool {
    !Path::new(name).exists() && name.to_ascii_uppercase().contains("COM")
}

#[cfg(not(target_family = "wasm"))]
fn pass_on(reader: &mut dyn Read, sender: &SyncSender<Chunk>) -> io::Result<()> {
    let mut buffer = vec![0; CHUNK];
    loop {
        match reader.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(count) => {
                if sender.send(Ok(buffer[..count].to_vec())).is_err() {
                    return Ok(());
                }
            }
            Err(error)
                if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(error) => return Err(error),
        }
    }
}
