//! The head of a request, read within limits of size and time.
//!
//! ```text
//! METHOD SP TARGET SP VERSION CRLF, NAME: VALUE CRLF …, CRLF          RFC 9112
//! ```

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Bytes of the longest head.
const LONGEST: usize = 16 << 10;
/// How long a client may take to send its head, and to take the answer.
const TO_ASK: Duration = Duration::from_secs(5);
const TO_READ: Duration = Duration::from_secs(20);
/// What a refused client may still send before the connection is closed, so that it reads why.
const REST: usize = 1 << 20;
const TO_END: Duration = Duration::from_millis(300);
/// How long one call waits before it is looked whether to stop.
const PATIENCE: Duration = Duration::from_millis(100);

/// What a client asks for.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Request {
    pub(super) method: String,
    /// Path and query.
    pub(super) target: String,
    /// Name of the server without its port; empty if there is not exactly one.
    pub(super) host: String,
}

/// Why a head is refused: status and words.
pub(super) type Refused = (u16, &'static str);

/// A connection whose every wait is bounded.
pub(super) struct Connection<'s> {
    stream: TcpStream,
    /// Whether the server ends.
    stops: &'s (dyn Fn() -> bool + Sync),
}

impl<'s> Connection<'s> {
    pub(super) fn new(stream: TcpStream, stops: &'s (dyn Fn() -> bool + Sync)) -> io::Result<Self> {
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        Ok(Self { stream, stops })
    }

    /// Reads the head of the request; `None` if the client is gone.
    pub(super) fn request(&mut self) -> Option<Result<Request, Refused>> {
        let (end, mut head, mut buffer) = (Instant::now() + TO_ASK, Vec::new(), [0; 2048]);
        loop {
            if let Some(length) = head_length(&head) {
                return Some(parse(head.get(..length).unwrap_or_default()));
            }
            if head.len() > LONGEST {
                return Some(Err((431, "The head of the request is too long.")));
            }
            match self.within(end, |stream| stream.read(&mut buffer)) {
                Ok(0) => return None,
                Ok(count) => head.extend_from_slice(buffer.get(..count).unwrap_or_default()),
                Err(error) if error.kind() == ErrorKind::TimedOut => {
                    return Some(Err((408, "The request was not complete in time.")));
                }
                Err(_) => return None,
            }
        }
    }

    /// Sends the answer, and closes the connection.
    pub(super) fn send(mut self, mut answer: &[u8]) -> io::Result<()> {
        let end = Instant::now() + TO_READ;
        while !answer.is_empty() {
            match self.within(end, |stream| stream.write(answer))? {
                0 => return Err(ErrorKind::WriteZero.into()),
                count => answer = answer.get(count..).unwrap_or_default(),
            }
        }
        self.stream.shutdown(std::net::Shutdown::Write)?;
        // A connection that is closed before all is read is reset, and the answer may be lost.
        let (end, mut left, mut buffer) = (Instant::now() + TO_END, REST, [0; 4096]);
        while left > 0 {
            match self.within(end, |stream| stream.read(&mut buffer))? {
                0 => break,
                count => left = left.saturating_sub(count),
            }
        }
        Ok(())
    }

    /// Repeats a call until it is done or time is up.
    fn within<T>(&mut self, end: Instant, mut call: impl FnMut(&mut TcpStream) -> io::Result<T>) -> io::Result<T> {
        loop {
            match call(&mut self.stream) {
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) =>
                {
                    if Instant::now() >= end || (self.stops)() {
                        return Err(ErrorKind::TimedOut.into());
                    }
                }
                // One that always takes a byte would never run into the limit of a call.
                Ok(_) if Instant::now() >= end => return Err(ErrorKind::TimedOut.into()),
                other => return other,
            }
        }
    }
}

/// Length of a head with the empty line that ends it.
pub(super) fn head_length(bytes: &[u8]) -> Option<usize> {
    let at = |end: &[u8]| bytes.windows(end.len()).position(|own| own == end).map(|at| at + end.len());
    at(b"\r\n\r\n").into_iter().chain(at(b"\n\n")).min().filter(|length| *length <= LONGEST)
}

pub(super) fn parse(head: &[u8]) -> Result<Request, Refused> {
    let wrong = (400, "This is no request.");
    let text = std::str::from_utf8(head).map_err(|_| wrong)?;
    let mut lines = text.lines();
    let words: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
    let [method, target, version] = words[..] else { return Err(wrong) };
    if !version.starts_with("HTTP/1.") || !target.starts_with('/') {
        return Err(wrong);
    }
    let named = lines.filter_map(|line| line.split_once(':')).filter(|(name, _)| name.eq_ignore_ascii_case("host"));
    let hosts: Vec<&str> = named.map(|(_, value)| value.trim()).collect();
    let host = if let [host] = hosts[..] { host.rsplit_once(':').map_or(host, |(name, _)| name) } else { "" };
    Ok(Request { method: method.into(), target: target.into(), host: host.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_understood_or_refused() {
        let asked = |text: &str| parse(text.as_bytes());
        let good = Request { method: "GET".into(), target: "/a?b=c".into(), host: "localhost".into() };
        assert_eq!(asked("GET /a?b=c HTTP/1.1\r\nX: y\r\nhost: localhost:80\r\n\r\n"), Ok(good));
        let host = |text: &str| asked(text).map(|own| own.host);
        assert_eq!(host("GET / HTTP/1.0\r\n\r\n").as_deref(), Ok(""));
        assert_eq!(host("GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil\r\n\r\n").as_deref(), Ok(""));
        for bad in ["", "GET /", "GET http://x/ HTTP/1.1", "GET / SPDY/3", "GET / a HTTP/1.1", "\r\n\r\n"] {
            assert!(asked(bad).is_err(), "{bad:?}");
        }
        assert!(parse(b"GET /\xff HTTP/1.1\r\n\r\n").is_err());
        assert_eq!(head_length(b"GET / HTTP/1.1\r\n\r\nbody"), Some(18));
        assert_eq!((head_length(b"a\n\nb"), head_length(b"a\r\n")), (Some(3), None));
    }
}
