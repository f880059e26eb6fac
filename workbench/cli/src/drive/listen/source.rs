//! The bytes of a serial port, a CAN interface, a file or a pipe, read by a thread of their own.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread;
#[cfg(not(target_family = "wasm"))]
use std::time::Duration;

#[cfg(target_os = "linux")]
use super::bus;

/// Bytes read at once, and how many such chunks wait.
const CHUNK: usize = 4096;
const WAITING: usize = 64;
/// A serial port returns after this time without a byte.
#[cfg(not(target_family = "wasm"))]
const SILENCE: Duration = Duration::from_millis(100);

type Chunk = io::Result<Vec<u8>>;

/// Returns the chunks of a source. The channel closes at its end; an error is the last chunk.
pub(super) fn open(source: &str, baud: u32) -> Receiver<Chunk> {
    let (sender, receiver) = mpsc::sync_channel(WAITING);
    let source = source.to_string();
    // Not joined: a pipe may be silent forever, and the thread ends with the program.
    thread::spawn(move || {
        let read = match source.as_str() {
            "-" => Ok(Box::new(io::stdin()) as Box<dyn Read>),
            name if is_serial(name) => serial(name, baud),
            #[cfg(target_os = "linux")]
            name if bus::is_bus(name) => bus::Bus::open(name).map(|bus| Box::new(bus) as Box<dyn Read>),
            name => File::open(name).map(|file| Box::new(file) as Box<dyn Read>),
        };
        let outcome = read.and_then(|mut reader| pass_on(reader.as_mut(), &sender));
        if let Err(error) = outcome {
            let _listener_gone = sender.send(Err(error));
        }
    });
    receiver
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
