//! `view` and the page of `listen` over a real socket, and in a browser.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::browser::{self, Opened};
use crate::common::{refuse, succeed};
use crate::listen_command::frames;

/// A command that serves pages, until it is dropped.
struct Served {
    child: Child,
    address: String,
}

impl Served {
    /// Starts it and waits for the line with its address.
    fn start(folder: &Path, arguments: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
        command.current_dir(folder).args(arguments.split_whitespace()).stdout(Stdio::piped());
        let mut child = command.spawn().expect("the command starts");
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().expect("piped")).read_line(&mut line).expect("a line");
        let address = line.split_whitespace().find_map(|word| word.strip_prefix("http://")).expect("an address");
        Self { address: address.trim_end_matches('/').to_owned(), child }
    }

    /// The status and the body of the answer to a request.
    fn ask(&self, method: &str, path: &str, host: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.address).expect("connects");
        write!(stream, "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").expect("sent");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let status = answer.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
        (status, answer)
    }

    fn get(&self, path: &str) -> (u16, String) {
        self.ask("GET", path, &self.address)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _gone = self.child.kill();
        let _reaped = self.child.wait();
    }
}

/// A folder with traces, a model, a page and a broken file; a secret beside it.
fn recordings(dir: &Path) {
    succeed(dir, "simulate --class healthy,spall --count 12 --seed 1 --out in");
    let signals = "--y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm";
    succeed(dir, &format!("train --labels in/labels.csv {signals} --order 2,1,2,1,1 --model in/m.bwm"));
    std::fs::write(dir.join("in/z broken & <b>.csv"), "t_s,i\n0,1\n1,2,3\n").expect("written");
    std::fs::write(dir.join("in/z_bad.bwm"), "no model").expect("written");
    std::fs::write(dir.join("in/saved.html"), "<p>a saved page</p>").expect("written");
    std::fs::write(dir.join("secret.csv"), "t_s,i\n0,12345\n").expect("written");
}

#[test]
fn a_folder_is_served_and_nothing_else() {
    let folder = tempfile::tempdir().expect("folder");
    recordings(folder.path());
    let served = Served::start(folder.path(), "view in --port 0");
    let (status, index) = served.get("/");
    assert_eq!(status, 200);
    for words in ["/trace/spall_1_003.csv", "/model/m.bwm", "/page/saved.html", "broken &amp; &lt;b&gt;.csv"] {
        assert!(index.contains(words), "{words} in {index}");
    }
    assert!(!index.contains("labels.csv") && !index.contains("secret"), "{index}");
    for (path, status, words) in [
        ("/page/saved.html", 200, "a saved page"),
        ("/model/m.bwm", 200, "healthy, spall"),
        ("/model/z_bad.bwm", 422, "train it again"),
        ("/trace/z%20broken%20%26%20%3Cb%3E.csv", 422, "3 cells where the header has 2"),
        ("/trace/none.csv", 404, "no trace of this name"),
        ("/trace/../secret.csv", 404, "no trace"),
        ("/trace/..%2fsecret.csv", 404, "no trace"),
        ("/trace/%2e%2e/secret.csv", 404, "no trace"),
        ("/trace/%zz", 404, "no trace"),
        ("/trace/m.bwm", 404, "no trace"),
        ("/replay?model=m.bwm&trace=../secret.csv", 404, "Choose one model"),
        ("/replay?model=z_bad.bwm&trace=spall_1_003.csv", 422, "train it again"),
        ("/replay?model=m.bwm", 404, "Choose one model"),
        ("/other", 404, "no such page"),
    ] {
        let (found, body) = served.get(path);
        assert!(found == status && body.contains(words), "{path}: {found}\n{body}");
        assert!(!body.contains("12345"), "{path}");
    }
    assert_eq!(served.ask("GET", "/", "evil.example:80").0, 403);
    assert_eq!(served.ask("POST", "/", &served.address).0, 405);
    refuse(folder.path(), "view nowhere", &["nowhere is no folder"]);
    let port = served.address.rsplit_once(':').expect("a port").1;
    refuse(folder.path(), &format!("view in --port {port}"), &["--port", "choose another one"]);
}

/// Clients that send nothing, that send without end, and that do not read.
#[test]
fn no_client_keeps_others_from_the_pages() {
    let folder = tempfile::tempdir().expect("folder");
    // Larger than what the system takes for a client that does not read.
    let large = "<p>a saved page</p>".repeat(2_000_000);
    std::fs::write(folder.path().join("large.html"), large).expect("written");
    std::fs::write(folder.path().join(".hidden.html"), "hidden").expect("written");
    let served = Served::start(folder.path(), "view . --port 0");
    let connect = || TcpStream::connect(&served.address).expect("connects");
    let silent: Vec<TcpStream> = (0..10).map(|_| connect()).collect();
    let unread: Vec<TcpStream> = (0..10)
        .map(|_| {
            let mut stream = connect();
            write!(stream, "GET /page/large.html HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n").expect("sent");
            stream
        })
        .collect();
    let start = Instant::now();
    let (status, page) = served.get("/");
    assert!(status == 200 && page.contains("/page/large.html"));
    assert!(start.elapsed() < Duration::from_secs(3), "{:?}", start.elapsed());
    // A request whose head never ends. The system buffers tens of MB that the server does not read (`tcp_rmem`).
    let mut stream = connect();
    let line = format!("X: {}\r\n", "y".repeat(1000));
    let sent = (0..100_000).map_while(|_| stream.write_all(line.as_bytes()).ok()).count();
    assert!(sent < 100_000, "100 MB of header were taken");
    assert_eq!(served.ask("GET", "/", &format!("127.0.0.1\r\nX: {}", "y".repeat(20_000))).0, 431);
    // One that sends a byte now and then is answered by the end of its time.
    let mut slow = connect();
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(20) && slow.write_all(b"G").is_ok() {
        std::thread::sleep(Duration::from_millis(200));
    }
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    assert_eq!(served.get("/page/.hidden.html").0, 404);
    drop((silent, unread));
}

#[test]
fn what_is_served_has_a_content_policy() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("saved.html"), "<script>fetch('/')</script>").expect("written");
    let served = Served::start(folder.path(), "view . --port 0");
    for path in ["/", "/none", "/page/saved.html"] {
        let (_, answer) = served.get(path);
        let head = answer.split("\r\n\r\n").next().expect("a head").to_lowercase();
        for words in ["content-security-policy: default-src 'none'; ", "frame-ancestors 'none'", "base-uri 'none'"] {
            assert!(head.contains(words), "{path}: {words} in {head}");
        }
        assert!(head.contains("x-content-type-options: nosniff"), "{head}");
        // A file may have come from anywhere: its scripts have no origin, and ask for nothing.
        let is_file = path.starts_with("/page");
        assert_eq!(head.contains("sandbox allow-scripts"), is_file, "{path}: {head}");
        assert_eq!(head.contains("connect-src 'self'"), !is_file, "{path}: {head}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_it() {
    let folder = tempfile::tempdir().expect("folder");
    let mut served = Served::start(folder.path(), "view . --port 0");
    let interrupt = Command::new("kill").args(["-INT", &served.child.id().to_string()]).status();
    assert!(interrupt.is_ok_and(|status| status.success()));
    assert_eq!(served.child.wait().expect("ends").code(), Some(0));
}

#[test]
fn a_trace_is_replayed_in_the_browser_and_a_drive_is_shown_live() {
    let Some(browser) = browser::start() else { return };
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    recordings(dir);
    let served = Served::start(dir, "view in --port 0");
    let index = Opened::new_plain(&browser, &format!("http://{}/", served.address));
    index.click("form button");
    index.wait("location.pathname === '/replay' && document.documentElement?.dataset.plots === 'drawn'");
    assert!(index.value("document.querySelectorAll('.plot .scatterlayer .trace').length").as_u64() > Some(3));
    index.value("location = '/trace/spall_1_003.csv'");
    index.wait("location.pathname.startsWith('/trace') && document.documentElement?.dataset.plots === 'drawn'");
    assert!(index.errors().is_empty(), "{:?}", index.errors());

    // Half of what the drive sends, and later the rest.
    let frames = frames();
    let (first, rest) = frames.split_at(frames.len() / 2);
    let (reader, mut writer) = std::io::pipe().expect("a pipe");
    let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    command.args(["listen", "-", "--view", "0"]).stdin(reader).stdout(Stdio::piped());
    let mut child = command.spawn().expect("the command starts");
    drop(command);
    let mut line = String::new();
    let mut out = BufReader::new(child.stdout.take().expect("piped"));
    out.read_line(&mut line).expect("a line");
    let served =
        Served { address: line.trim().trim_start_matches("page at http://").trim_end_matches('/').into(), child };
    std::thread::spawn(move || std::io::copy(&mut out, &mut std::io::sink()));
    writer.write_all(&first.concat()).expect("sent");
    let live = Opened::new(&browser, &format!("http://{}/", served.address));
    let distances = "(document.querySelector('.plot').data.find(t => t.name === 'distance') || { x: [] }).x.length";
    live.wait(&format!("{distances} >= 2"));
    let before = live.value(distances).as_u64();
    writer.write_all(&rest.concat()).expect("sent");
    live.wait(&format!("{distances} > {}", before.unwrap_or(0)));
    live.wait("document.querySelector('#news > p').textContent.startsWith('segment')");
    live.wait("document.querySelector('#news .conclusion').textContent.trim().endsWith('.')");
    assert!(live.errors().is_empty(), "{:?}", live.errors());
}
