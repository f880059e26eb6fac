//! Pages over HTTP on this machine alone, until Ctrl-C.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tiny_http::{Header, Method, Request, Response, Server};

use model::Error;
use pages::page::{Page, paragraph};

/// Requests that are answered at the same time.
const WORKERS: usize = 4;
/// How long a worker waits before it looks whether to stop.
const PATIENCE: Duration = Duration::from_millis(100);

/// What is sent.
pub(super) struct Reply {
    status: u16,
    kind: &'static str,
    body: Vec<u8>,
}

impl Reply {
    pub(super) fn html(body: impl Into<Vec<u8>>) -> Self {
        Self { status: 200, kind: "text/html; charset=utf-8", body: body.into() }
    }

    /// A page that says what is wrong.
    pub(super) fn problem(status: u16, problem: &str) -> Self {
        let title = if status == 404 { "Not found" } else { "This does not work" };
        let page = Page::new(title).section("Problem", &paragraph(problem)).section("Back", BACK);
        Self { status, ..Self::html(page.render()) }
    }

    /// The page, or what is wrong with its files.
    pub(super) fn page(page: Result<Page, Error>) -> Self {
        match page {
            Ok(page) => Self::html(page.render()),
            Err(error) => Self::problem(422, &error.to_string()),
        }
    }
}

const BACK: &str = "<p><a href=\"/\">Back to the index</a></p>";

/// A server of this machine, and its address.
pub(super) struct Local {
    server: Server,
    pub(super) address: SocketAddr,
}

impl Local {
    /// Opens a port; 0 is any free one.
    pub(super) fn open(port: u16) -> Result<Self, Error> {
        let refused = |problem: String| Error::Usage(format!("--port {port}: {problem}; choose another one"));
        let server = Server::http((Ipv4Addr::LOCALHOST, port)).map_err(|error| refused(error.to_string()))?;
        let address = server.server_addr().to_ip().ok_or_else(|| refused("no address".into()))?;
        Ok(Self { server, address })
    }

    /// Answers requests by their path and query until the flag is set.
    pub(super) fn answer(&self, stopped: &AtomicBool, answer: &(impl Fn(&str, &str) -> Reply + Sync)) {
        std::thread::scope(|scope| {
            for _ in 0..WORKERS {
                scope.spawn(|| {
                    while !stopped.load(Ordering::Relaxed) {
                        // A broken connection concerns its page only.
                        if let Ok(Some(request)) = self.server.recv_timeout(PATIENCE) {
                            let reply = reply(&request, answer);
                            let _gone = send(request, reply);
                        }
                    }
                });
            }
        });
    }
}

fn reply(request: &Request, answer: &impl Fn(&str, &str) -> Reply) -> Reply {
    let host = request.headers().iter().find(|header| header.field.equiv("Host"));
    let host =
        host.map(|header| header.value.as_str().rsplit_once(':').map_or(header.value.as_str(), |(name, _)| name));
    // Another name that leads here could belong to a page on the network.
    if !matches!(host, Some("127.0.0.1" | "localhost")) {
        return Reply::problem(403, "Open this by http://127.0.0.1.");
    }
    if *request.method() != Method::Get {
        return Reply::problem(405, "Pages can be read only.");
    }
    let (path, query) = request.url().split_once('?').unwrap_or((request.url(), ""));
    answer(path, query)
}

fn send(request: Request, reply: Reply) -> std::io::Result<()> {
    let mut response = Response::from_data(reply.body).with_status_code(reply.status);
    for (name, value) in [("Content-Type", reply.kind), ("Cache-Control", "no-store")] {
        if let Ok(header) = Header::from_bytes(name, value) {
            response.add_header(header);
        }
    }
    request.respond(response)
}

/// A flag that Ctrl-C sets.
pub(super) fn stop_flag() -> Result<Arc<AtomicBool>, Error> {
    let flag = Arc::new(AtomicBool::new(false));
    let own = Arc::clone(&flag);
    ctrlc::set_handler(move || own.store(true, Ordering::Relaxed))
        .map_err(|error| Error::Usage(format!("Ctrl-C cannot be handled: {error}")))?;
    Ok(flag)
}

/// The text of a part of an address: %20 and + are spaces. `None` if it is no text.
pub(super) fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let digit = |byte: Option<u8>| char::from(byte?).to_digit(16);
                u8::try_from(16 * digit(rest.next())? + digit(rest.next())?).ok()?
            }
            b'+' => b' ',
            other => other,
        });
    }
    String::from_utf8(bytes).ok()
}

/// A text as part of an address.
pub(super) fn encoded(text: &str) -> String {
    let each = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'/' => char::from(byte).to_string(),
        other => format!("%{other:02X}"),
    };
    text.bytes().map(each).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_survive_an_address() {
        let name = "a b/ü+%&?.csv";
        assert_eq!(decoded(&encoded(name)).as_deref(), Some(name));
        assert_eq!((decoded("%4"), decoded("%zz"), decoded("%ff")), (None, None, None));
    }
}
