//! The frames of a CAN interface of Linux, as the lines of `candump -L`.

use std::io::{self, Read};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use socketcan::{CanAnyFrame, CanFdSocket, EmbeddedFrame as _, Frame as _, Socket as _, SocketOptions as _};

/// `ARPHRD_CAN`, the type of an interface of a CAN bus.
const CAN: &str = "280";
/// Digits of an identifier with 11 bits, and flags of longer ones.
const SHORT_DIGITS: usize = 3;
const EXTENDED: u32 = 1 << 31;
const REMOTE: u32 = 1 << 30;
/// An interface returns after this time without a frame.
const SILENCE: Duration = Duration::from_millis(100);

/// Whether the system has a CAN interface of this name.
pub(super) fn is_bus(name: &str) -> bool {
    let about = Path::new("/sys/class/net").join(name).join("type");
    !name.contains('/') && std::fs::read_to_string(about).is_ok_and(|kind| kind.trim() == CAN)
}

/// Lines of the frames that come.
pub(super) struct Bus {
    name: String,
    socket: CanFdSocket,
    /// What is left of the last line.
    line: Vec<u8>,
}

impl Bus {
    pub(super) fn open(name: &str) -> io::Result<Self> {
        let socket = CanFdSocket::open(name)?;
        socket.set_read_timeout(SILENCE)?;
        // Errors of the bus are counted, as in logs.
        socket.set_error_filter_accept_all()?;
        Ok(Self { name: name.to_owned(), socket, line: vec![] })
    }
}

impl Read for Bus {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.line.is_empty() {
            let frame = self.socket.read_frame()?;
            self.line = line(&self.name, SystemTime::now(), &frame).into_bytes();
        }
        let count = self.line.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.line[..count]);
        self.line.drain(..count);
        Ok(count)
    }
}

fn line(bus: &str, time: SystemTime, frame: &CanAnyFrame) -> String {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    let word = frame.id_word();
    let id = word & !(EXTENDED | REMOTE);
    // An error has its bit within the eight digits.
    let digits = if word & EXTENDED != 0 || matches!(frame, CanAnyFrame::Error(_)) { 8 } else { SHORT_DIGITS };
    let data: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
    let content = match frame {
        CanAnyFrame::Normal(_) | CanAnyFrame::Error(_) => format!("#{data}"),
        CanAnyFrame::Remote(_) => "#R".to_owned(),
        CanAnyFrame::Fd(_) => format!("##0{data}"),
    };
    format!("({}.{:06}) {bus} {id:0digits$X}{content}\n", since.as_secs(), since.subsec_micros())
}

#[cfg(test)]
mod tests {
    use socketcan::{CanDataFrame, CanErrorFrame, CanFdFrame, CanRemoteFrame, ExtendedId, StandardId};

    use super::*;

    #[test]
    fn frames_have_the_lines_of_candump() {
        let time = UNIX_EPOCH + Duration::from_micros(1_700_000_000_123_456);
        let (short, long) = (StandardId::new(0x123).expect("11 bits"), ExtendedId::new(0x18FF_0123).expect("29 bits"));
        let of = |frame: CanAnyFrame| line("can0", time, &frame);
        let data = CanDataFrame::new(short, &[1, 2, 0xAB]).expect("three bytes");
        assert_eq!(of(CanAnyFrame::Normal(data)), "(1700000000.123456) can0 123#0102AB\n");
        let data = CanDataFrame::new(long, &[9]).expect("a byte");
        assert_eq!(of(CanAnyFrame::Normal(data)), "(1700000000.123456) can0 18FF0123#09\n");
        let data = CanFdFrame::new(short, &[7; 12]).expect("twelve bytes");
        assert_eq!(of(CanAnyFrame::Fd(data)), format!("(1700000000.123456) can0 123##0{}\n", "07".repeat(12)));
        let remote = CanRemoteFrame::new_remote(short, 4).expect("a length");
        assert_eq!(of(CanAnyFrame::Remote(remote)), "(1700000000.123456) can0 123#R\n");
        let error = CanErrorFrame::new_error(0x88, &[0; 8]).expect("an error");
        assert_eq!(of(CanAnyFrame::Error(error)), "(1700000000.123456) can0 20000088#0000000000000000\n");
    }

    #[test]
    fn other_interfaces_and_files_are_no_bus() {
        assert!(["lo", "", "../net/lo", "recording.csv"].iter().all(|name| !is_bus(name)));
    }
}
