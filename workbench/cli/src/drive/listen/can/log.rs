//! Lines of the logs of a CAN bus: those of `candump -L` and `-l`, and Vector's ASC files.
//!
//! ```text
//! candump   (1700000000.123456) can0 123#0102030405060708     data; 123##1… of CAN FD, 123#R8 remote
//!           (1700000000.123456) can0 20000088#0000000000000000  an error frame: bit 29 of the identifier
//! ASC       base hex  timestamps absolute
//!           0.015991 1  123  Rx  d 8 01 02 03 04 05 06 07 08    data; x behind an extended identifier; r: remote
//!           0.016201 1  ErrorFrame
//!           0.020000 CANFD 1 Rx 123 Name 1 0 8 8 01 02 …        BRS, ESI, code and number of bytes; the name may lack
//! ```

use crate::drive::can_id::CanId;

/// The bit of an error frame in an identifier of candump.
const ERROR: u32 = 1 << 29;
/// Digits of an extended identifier of candump.
const EXTENDED_DIGITS: usize = 8;
/// Bytes of a frame of CAN FD.
const MOST_BYTES: usize = 64;

/// What a line is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Event {
    /// A data frame that was on this bus.
    Data {
        bus: String,
        time_s: f64,
        id: CanId,
        data: Vec<u8>,
    },
    Remote,
    Error,
    /// A heading, a remark, or an event that is no frame.
    Nothing,
    Unread,
}

/// What a log had besides segments.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Frames of the identifier whose data are no segment.
    pub(super) bad: u64,
    /// Data frames of other identifiers.
    pub(super) others: u64,
    /// Frames of the identifier on another bus than the first one.
    pub(super) other_buses: u64,
    pub(super) remote: u64,
    pub(super) errors: u64,
    /// Lines that are no event of a known format.
    pub(super) unread: u64,
}

/// The numbers of an ASC file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Log {
    radix: u32,
    /// Whether a time counts from the line before.
    is_relative: bool,
    time_s: f64,
}

impl Default for Log {
    fn default() -> Self {
        Self { radix: 16, is_relative: false, time_s: 0.0 }
    }
}

impl Log {
    /// Reads a line of either format.
    pub(super) fn read(&mut self, line: &str) -> Event {
        let words: Vec<&str> = line.split_whitespace().collect();
        let event = match words[..] {
            [] => Some(Event::Nothing),
            [time, bus, frame, ..] if time.starts_with('(') => candump(time, bus, frame),
            [first, ..] if first.starts_with(|letter: char| letter.is_ascii_digit()) => self.asc(&words),
            ["base", base, ref rest @ ..] => {
                self.radix = if base == "dec" { 10 } else { 16 };
                self.is_relative = rest.contains(&"relative");
                Some(Event::Nothing)
            }
            _ => is_heading(line).then_some(Event::Nothing),
        };
        event.unwrap_or(Event::Unread)
    }

    fn asc(&mut self, words: &[&str]) -> Option<Event> {
        let (time, rest) = words.split_first()?;
        let time = seconds(time)?;
        self.time_s = if self.is_relative { self.time_s + time } else { time };
        if rest.contains(&"ErrorFrame") {
            return Some(Event::Error);
        }
        match *rest {
            ["CANFD", bus, direction, id, ref after @ ..] => self.asc_fd([bus, direction, id], after),
            [bus, id, direction, kind @ ("d" | "r"), ref after @ ..] if is_on_bus(direction) => {
                let id = self.asc_id(id)?;
                if kind == "r" {
                    return Some(Event::Remote);
                }
                let (length, data) = after.split_first()?;
                self.data(bus, id, data, usize::from_str_radix(length, 16).ok()?.min(8))
            }
            _ => Some(Event::Nothing),
        }
    }

    fn asc_fd(&self, [bus, direction, id]: [&str; 3], after: &[&str]) -> Option<Event> {
        if !is_on_bus(direction) {
            return Some(Event::Nothing);
        }
        let is_flag = |word: &&str| ["0", "1"].contains(word);
        let after = if after.first().is_some_and(is_flag) { after } else { after.get(1..)? };
        let [_bit_rate, _error_state, _code, length, data @ ..] = after else { return None };
        self.data(bus, self.asc_id(id)?, data, length.parse().ok()?)
    }

    fn asc_id(&self, text: &str) -> Option<CanId> {
        let digits = text.strip_suffix(['x', 'X']);
        let number = number(digits.unwrap_or(text), self.radix)?;
        CanId::new(number, digits.is_some())
    }

    fn data(&self, bus: &str, id: CanId, words: &[&str], length: usize) -> Option<Event> {
        let bytes = words.get(..length)?.iter().map(|word| byte(word, self.radix));
        Some(Event::Data { bus: bus.into(), time_s: self.time_s, id, data: bytes.collect::<Option<_>>()? })
    }
}

fn seconds(text: &str) -> Option<f64> {
    text.parse().ok().filter(|time: &f64| time.is_finite())
}

/// Digits alone, without a sign.
fn number(text: &str, radix: u32) -> Option<u32> {
    let signed = text.starts_with('+');
    u32::from_str_radix(text, radix).ok().filter(|_| !signed)
}

fn byte(text: &str, radix: u32) -> Option<u8> {
    u8::try_from(number(text, radix)?).ok()
}

/// Not a request to send, which a frame on the bus follows.
fn is_on_bus(direction: &str) -> bool {
    ["Rx", "Tx"].contains(&direction)
}

/// Whether a line of an ASC file is no event.
fn is_heading(line: &str) -> bool {
    let starts = ["date ", "internal events", "no internal events", "//", "begin trigger", "end trigger"];
    let line = line.trim_start().to_ascii_lowercase();
    starts.iter().any(|start| line.starts_with(start))
}

fn candump(time: &str, bus: &str, frame: &str) -> Option<Event> {
    let time_s = seconds(time.strip_prefix('(')?.strip_suffix(')')?)?;
    let (id, content) = frame.split_once('#')?;
    let number = number(id, 16)?;
    let extended = id.len() == EXTENDED_DIGITS;
    if extended && number & ERROR != 0 {
        return Some(Event::Error);
    }
    let id = CanId::new(number, extended)?;
    if content.starts_with(['R', 'r']) {
        return Some(Event::Remote);
    }
    let digits = match content.strip_prefix('#') {
        // Flags of CAN FD.
        Some(content) => content.get(1..)?,
        // Behind a line is a code of more than 8 bytes.
        None => content.split('_').next()?,
    };
    let pair = |pair: &[u8]| byte(std::str::from_utf8(pair).ok()?, 16);
    let whole = digits.len() % 2 == 0 && digits.len() <= 2 * MOST_BYTES;
    let data = whole.then(|| digits.as_bytes().chunks(2).map(pair).collect::<Option<_>>())??;
    Some(Event::Data { bus: bus.into(), time_s, id, data })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(time_s: f64, bus: &str, id: &str, data: &[u8]) -> Event {
        Event::Data { bus: bus.into(), time_s, id: CanId::parse(id).expect("an identifier"), data: data.into() }
    }

    const BYTES: [u8; 8] = [1, 2, 3, 4, 5, 6, 7, 0xFF];

    #[test]
    fn lines_of_candump() {
        let read = |frame: &str| Log::default().read(&format!("(1700000000.250000) can0 {frame}\r"));
        let time_s = 1_700_000_000.25;
        assert_eq!(read("123#01020304050607ff"), data(time_s, "can0", "0x123", &BYTES));
        assert_eq!(read("00000123#01020304050607FF R"), data(time_s, "can0", "0x00000123", &BYTES));
        assert_eq!(read("123##101020304050607FF"), data(time_s, "can0", "0x123", &BYTES));
        assert_eq!(read("123#01020304050607FF_E"), data(time_s, "can0", "0x123", &BYTES));
        assert_eq!(read("123#"), data(time_s, "can0", "0x123", &[]));
        assert_eq!([read("123#R"), read("123#R8")], [Event::Remote, Event::Remote]);
        assert_eq!(read("20000088#0000000000000000"), Event::Error);
        for wrong in ["123", "123#0", "123#0g", "#00", "123##", "123#+1", "FFF#00", "0123456789#00", "123#é0"] {
            assert_eq!(read(wrong), Event::Unread, "{wrong}");
        }
        for wrong in ["(never) can0 123#00", "(nan) can0 123#00", "(1.0) can0"] {
            assert_eq!(Log::default().read(wrong), Event::Unread, "{wrong}");
        }
    }

    #[test]
    fn lines_of_asc_files() {
        let mut log = Log::default();
        for line in [
            "date Tue Nov 14 10:13:20 am 2023",
            "internal events logged",
            "no internal events logged",
            "// version 9.0.0",
            "",
        ] {
            assert_eq!(log.read(line), Event::Nothing, "{line}");
        }
        assert_eq!(log.read("base hex  timestamps absolute"), Event::Nothing);
        let classic = "   0.015991 1  123             Rx   d 8 01 02 03 04 05 06 07 FF  Length = 240000 ID = 291";
        assert_eq!(log.read(classic), data(0.015_991, "1", "0x123", &BYTES));
        assert_eq!(log.read("1.5 2 18FF1234x Tx d 1 AB"), data(1.5, "2", "0x18FF1234", &[0xAB]));
        let fd = "2.5 CANFD   1 Rx        123  Segment_123   1 0 8  8 01 02 03 04 05 06 07 FF   0 0 1000 0";
        assert_eq!(log.read(fd), data(2.5, "1", "0x123", &BYTES));
        assert_eq!(log.read(&fd.replace("Segment_123", "")), data(2.5, "1", "0x123", &BYTES));
        assert_eq!(log.read("3.0 1 123 Rx r 8"), Event::Remote);
        assert_eq!(log.read("3.0 1  ErrorFrame"), Event::Error);
        for line in
            ["3.0 1 123 TxRq d 1 00", "0.0 Start of measurement", "4.0 1  Statistic: D 0 R 0 XD 0", "End TriggerBlock"]
        {
            assert_eq!(log.read(line), Event::Nothing, "{line}");
        }
        for line in
            ["3.0 1 123 Rx d 8 01 02", "3.0 1 123 Rx d 1 GG", "3.0 1 FFF Rx d 1 00", "no log", "3.0 CANFD 1 Rx 1 1"]
        {
            assert_eq!(log.read(line), Event::Unread, "{line}");
        }
    }

    #[test]
    fn decimal_numbers_and_relative_times() {
        let mut log = Log::default();
        log.read("base dec  timestamps relative");
        assert_eq!(log.read("0.5 1 291 Rx d 2 1 255"), data(0.5, "1", "0x123", &[1, 255]));
        assert_eq!(log.read("0.25 1  ErrorFrame"), Event::Error);
        assert_eq!(log.read("0.25 1 291 Rx d 1 16"), data(1.0, "1", "0x123", &[16]));
    }
}
