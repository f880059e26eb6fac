//! Pages over HTTP on this machine alone, until Ctrl-C.
//!
//! A connection has one request. Its head is bounded in bytes, its waits in time, the connections and the answers that
//! are made at the same time in number: other clients get the pages although one does not send or read.

mod address;
mod request;

use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use model::Error;
use pages::page::{POLICY, Page, paragraph};
use request::{Connection, Refused, Request};

pub(crate) use address::{decoded, encoded};

/// Largest number of connections at the same time; further ones get the status 503.
const CLIENTS: usize = 64;
/// Answers that are made at the same time.
const WORKERS: usize = 4;
/// How long to wait before it is looked for connections again.
const PATIENCE: Duration = Duration::from_millis(10);

/// What is sent.
pub(crate) struct Reply {
    status: u16,
    policy: String,
    body: Vec<u8>,
}

impl Reply {
    /// A page of this program. Its script may ask the server, and its form go to it.
    pub(crate) fn html(body: impl Into<Vec<u8>>) -> Self {
        let policy = format!("{POLICY}; connect-src 'self'; form-action 'self'; frame-ancestors 'none'");
        Self { status: 200, policy, body: body.into() }
    }

    /// A page of a file, which anyone may have written: its scripts reach no other page.
    pub(crate) fn saved(body: impl Into<Vec<u8>>) -> Self {
        let policy =
            format!("{POLICY}; form-action 'none'; frame-ancestors 'none'; sandbox allow-scripts allow-downloads");
        Self { policy, ..Self::html(body) }
    }

    /// A page that says what is wrong.
    pub(crate) fn problem(status: u16, problem: &str) -> Self {
        let title = if status == 404 { "Not found" } else { "This does not work" };
        let page = Page::new(title).section("Problem", &paragraph(problem)).section("Back", BACK);
        Self { status, ..Self::html(page.render()) }
    }

    /// The page, or what is wrong with its files.
    pub(crate) fn page(page: Result<Page, Error>) -> Self {
        match page {
            Ok(page) => Self::html(page.render()),
            Err(error) => Self::problem(422, &error.to_string()),
        }
    }

    fn bytes(self) -> Vec<u8> {
        let Self { status, policy, body } = self;
        let head = format!(
            "HTTP/1.1 {status} {}\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {}\r\n\
             Cache-Control: no-store\r\nContent-Security-Policy: {policy}\r\nX-Content-Type-Options: nosniff\r\n\
             Cross-Origin-Resource-Policy: same-origin\r\nReferrer-Policy: no-referrer\r\nConnection: close\r\n\r\n",
            reason(status),
            body.len()
        );
        [head.into_bytes(), body].concat()
    }
}

const BACK: &str = "<p><a href=\"/\">Back to the index</a></p>";

const fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        422 => "Unprocessable Content",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Bad Request",
    }
}

/// A server of this machine, and its address.
pub(crate) struct Local {
    listener: TcpListener,
    pub(crate) address: SocketAddr,
}

impl Local {
    /// Opens a port; 0 is any free one.
    pub(crate) fn open(port: u16) -> Result<Self, Error> {
        let refused = |error: std::io::Error| Error::Usage(format!("--port {port}: {error}; choose another one"));
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        Ok(Self { listener, address })
    }

    /// Answers requests by their path and query until the flag is set.
    pub(crate) fn answer(&self, stopped: &AtomicBool, answer: &(impl Fn(&str, &str) -> Reply + Sync)) {
        let (clients, places) = (AtomicUsize::new(0), Places::new(WORKERS));
        let stops = || stopped.load(Ordering::Relaxed);
        std::thread::scope(|scope| {
            while !stops() {
                let Ok((stream, _)) = self.listener.accept() else {
                    std::thread::sleep(PATIENCE);
                    continue;
                };
                let is_full = clients.fetch_add(1, Ordering::Relaxed) >= CLIENTS;
                if is_full {
                    clients.fetch_sub(1, Ordering::Relaxed);
                    refuse(stream);
                    continue;
                }
                let (clients, places, stops) = (&clients, &places, &stops);
                scope.spawn(move || {
                    // A broken connection concerns its page only.
                    let _gone = serve(stream, stops, |request| places.with(|| reply(request, answer)));
                    clients.fetch_sub(1, Ordering::Relaxed);
                });
            }
        });
    }
}

/// Too many clients: said if that goes at once.
fn refuse(stream: TcpStream) {
    let busy = Reply::problem(503, "Too many pages are open; close some and try again.").bytes();
    let _told = stream.set_nonblocking(true).and_then(|()| std::io::Write::write(&mut &stream, &busy));
}

/// Answers the request of a connection.
fn serve(
    stream: TcpStream,
    stops: &(dyn Fn() -> bool + Sync),
    reply: impl FnOnce(&Request) -> Reply,
) -> std::io::Result<()> {
    let mut connection = Connection::new(stream, stops)?;
    let Some(request) = connection.request() else { return Ok(()) };
    connection.send(&answered(request, reply).bytes())
}

fn answered(request: Result<Request, Refused>, reply: impl FnOnce(&Request) -> Reply) -> Reply {
    request.map_or_else(|(status, problem)| Reply::problem(status, problem), |request| reply(&request))
}

/// The answer to these bytes without a connection, if they have a whole head; for attacks.
pub(crate) fn answer_to(bytes: &[u8], answer: &impl Fn(&str, &str) -> Reply) -> Option<Vec<u8>> {
    let head = bytes.get(..request::head_length(bytes)?)?;
    Some(answered(request::parse(head), |request| reply(request, answer)).bytes())
}

fn reply(request: &Request, answer: &impl Fn(&str, &str) -> Reply) -> Reply {
    // Another name that leads here could belong to a page on the network.
    if !matches!(&*request.host, "127.0.0.1" | "localhost") {
        return Reply::problem(403, "Open this by http://127.0.0.1.");
    }
    if request.method != "GET" {
        return Reply::problem(405, "Pages can be read only.");
    }
    let (path, query) = request.target.split_once('?').unwrap_or((&request.target, ""));
    answer(path, query)
}

/// Places of those who work at the same time.
struct Places {
    free: Mutex<usize>,
    left: Condvar,
}

impl Places {
    const fn new(count: usize) -> Self {
        Self { free: Mutex::new(count), left: Condvar::new() }
    }

    /// Works when a place is free.
    fn with<T>(&self, work: impl FnOnce() -> T) -> T {
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let mut free = self.left.wait_while(free, |free| *free == 0).unwrap_or_else(PoisonError::into_inner);
        *free -= 1;
        drop(free);
        let _place = Place(self);
        work()
    }
}

/// A place, which is free again when this is dropped.
struct Place<'p>(&'p Places);

impl Drop for Place<'_> {
    fn drop(&mut self) {
        *self.0.free.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.0.left.notify_one();
    }
}

/// A flag that Ctrl-C sets; in a browser, which has no Ctrl-C, the page ends the program.
pub(crate) fn stop_flag() -> Result<Arc<AtomicBool>, Error> {
    let flag = Arc::new(AtomicBool::new(false));
    #[cfg(not(target_family = "wasm"))]
    {
        let set = Arc::clone(&flag);
        ctrlc::set_handler(move || set.store(true, Ordering::Relaxed))
            .map_err(|error| Error::Usage(format!("Ctrl-C cannot be handled: {error}")))?;
    }
    Ok(flag)
}
