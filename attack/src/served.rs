//! What comes to the workbench from outside while it runs: requests of clients, and the line of a drive.

use std::path::PathBuf;

use crate::core::telemetry;
use crate::input::Input;
use crate::readers::folder;

/// What no answer may have: the text of files outside the served folder, and of hidden ones.
const SECRET: &str = "only the owner reads this";
/// Parts of requests.
const WORDS: [&str; 24] = [
    "GET ",
    "POST ",
    "/",
    "/page/a.html",
    "/page/deep/b.html",
    "/page/link.html",
    "/page/.hidden.html",
    "/page/../secret.html",
    "/replay?model=m.bwm&trace=t.csv",
    "%2e%2e/",
    "%2f",
    "%00",
    "..",
    "secret.html",
    " HTTP/1.1\r\n",
    " HTTP/1.0\n",
    "Host: 127.0.0.1:8600\r\n",
    "hOST: localhost\r\n",
    "Host: evil\r\n",
    "Content-Length: 99\r\n",
    "\r\n",
    "\r\n\r\n",
    "?",
    "/page/",
];

/// Parts of logs of a CAN bus, by `candump -L` and as ASC files.
const LOGGED: [&str; 24] = [
    "(1.500000) can0 123#",
    "(1700000000.250000) can1 123##1",
    "(2.5) can0 00000123#",
    "(nan) can0 123#R",
    "20000088#0000000000000000",
    "0103000000006404",
    "0200470300006180",
    "03040000820A6410",
    "\n",
    "\r\n",
    "base hex  timestamps absolute\n",
    "base dec  timestamps relative\n",
    "date Tue Nov 14 10:13:20 am 2023\n",
    "   0.015991 1  123             Rx   d 8 ",
    "2.5 CANFD   1 Rx        123  Segment   1 0 8  8 ",
    "3.0 1  ErrorFrame\n",
    "3.0 1 123 Rx r 8\n",
    "01 04 00 00 82 07 64 FF",
    "05 00 47 03 00 00 61 00",
    "  Length = 240000 ID = 291\n",
    "123",
    "x",
    " ",
    "_E",
];

thread_local! {
    /// A folder that is served, of this thread.
    static SERVED: PathBuf = served();
}

fn served() -> PathBuf {
    let outer = folder().join("served");
    let inner = outer.join("in");
    std::fs::create_dir_all(inner.join("deep")).expect("folders");
    for (name, text) in
        [("in/a.html", "a"), ("in/deep/b.html", "b"), ("in/.hidden.html", SECRET), ("secret.html", SECRET)]
    {
        std::fs::write(outer.join(name), text).expect("a file");
    }
    #[cfg(unix)]
    if !inner.join("link.html").exists() {
        std::os::unix::fs::symlink(outer.join("secret.html"), inner.join("link.html")).expect("a link");
    }
    inner
}

/// A request of any bytes, or of words that requests have: a whole answer, which has nothing from elsewhere.
pub fn request(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let head = match input.byte() % 4 {
        0 => input.bytes(usize::MAX).to_vec(),
        1 => {
            let target = target(&mut input);
            [b"GET /".as_slice(), &target, b" HTTP/1.1\r\nHost: localhost\r\n\r\n"].concat()
        }
        _ => {
            let head = target(&mut input);
            [&head, b"\r\n\r\n".as_slice()].concat()
        }
    };
    let answer = SERVED.with(|folder| workbench::untrusted::request(folder, &head)).expect("a folder");
    let Some(answer) = answer else { return };
    let text = String::from_utf8(answer).expect("pages are text");
    assert!(!text.contains(SECRET), "a file from elsewhere");
    let (head, body) = text.split_once("\r\n\r\n").expect("a head");
    assert!(!head.contains("\n\n") && head.starts_with("HTTP/1.1 "), "{head}");
    let length = head.lines().find_map(|line| line.strip_prefix("Content-Length: ")).expect("a length");
    assert_eq!(length.parse(), Ok(body.len()));
}

/// Words of requests, and any bytes between them.
fn target(input: &mut Input<'_>) -> Vec<u8> {
    spelt(&WORDS, input)
}

/// These words, and any bytes between them.
fn spelt(words: &[&str], input: &mut Input<'_>) -> Vec<u8> {
    let mut bytes = vec![];
    while !input.is_empty() {
        match input.byte() {
            place @ 0..=199 => bytes.extend(words[usize::from(place) % words.len()].bytes()),
            count => bytes.extend(input.bytes(usize::from(count - 199))),
        }
    }
    bytes
}

/// A line of any bytes, as `listen` takes it: nothing acts on a terminal, and traces are complete.
pub fn line(bytes: &[u8]) {
    let line = telemetry::line(&mut Input::new(bytes));
    let traces = folder().join("listen");
    let done = workbench::untrusted::line(&traces, &line);
    if let Err(error) = done {
        assert!(!error.to_string().is_empty(), "a message");
    }
    let Ok(files) = std::fs::read_dir(&traces) else { return };
    for file in files.map(|file| file.expect("an entry").path()) {
        let text = std::fs::read_to_string(&file).expect("a trace is text");
        assert!(text.ends_with('\n'), "{} is complete", file.display());
        std::fs::remove_file(&file).expect("removed");
    }
}

/// A log of any bytes, or of words that logs have: nothing acts on a terminal, and what is no log has a message.
pub fn can_log(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let log = match input.byte() % 4 {
        0 => input.bytes(usize::MAX).to_vec(),
        _ => spelt(&LOGGED, &mut input),
    };
    if let Err(error) = workbench::untrusted::can_log(&log) {
        assert!(!error.to_string().is_empty(), "a message");
    }
}
