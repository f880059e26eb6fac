//! Pages in a headless Chromium, which is spoken to over pipes by its debugging protocol.

use std::cell::{Cell, RefCell};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// How long a page may take.
const PATIENCE: Duration = Duration::from_secs(120);

/// A running Chromium; it ends with this value.
pub struct Browser {
    child: Child,
    messages: Receiver<Value>,
    last: Cell<u64>,
    events: RefCell<Vec<Value>>,
    _profile: tempfile::TempDir,
}

/// Starts Chromium. Without one the test is skipped with a printed line, except in continuous integration.
pub fn start() -> Option<Browser> {
    let Some(program) = installed() else {
        assert!(std::env::var("CI").as_deref() != Ok("true"), "no Chromium; install it: cargo xtask setup");
        println!("skipped: no Chromium on the search path");
        return None;
    };
    let profile = tempfile::tempdir().expect("folder");
    let mut child = Command::new("sh")
        // The protocol uses descriptors 3 and 4.
        .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1"])
        .arg(program)
        // Chromium's own sandbox does not work for root; the pages are ours.
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--window-size=1000,1200"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a shell");
    let mut from = BufReader::new(child.stdout.take().expect("piped"));
    let (sender, messages) = mpsc::channel();
    std::thread::spawn(move || {
        let mut message = Vec::new();
        while from.read_until(0, &mut message).is_ok_and(|count| count > 0) {
            message.pop();
            let Ok(value) = serde_json::from_slice(&message) else { return };
            if sender.send(value).is_err() {
                return;
            }
            message.clear();
        }
    });
    Some(Browser { child, messages, last: Cell::new(0), events: RefCell::default(), _profile: profile })
}

fn installed() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _gone = self.child.kill();
        let _reaped = self.child.wait();
    }
}

impl Browser {
    /// Calls a method of the protocol and returns its result.
    fn call(&self, session: Option<&str>, method: &str, parameters: Value) -> Value {
        self.last.set(self.last.get() + 1);
        let mut message = json!({ "id": self.last.get(), "method": method, "params": parameters });
        if let Some(session) = session {
            message["sessionId"] = session.into();
        }
        let mut to = self.child.stdin.as_ref().expect("piped");
        to.write_all(format!("{message}\0").as_bytes()).expect("Chromium reads");
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let answer = self.messages.recv_timeout(left).unwrap_or_else(|_| panic!("no answer to {method}"));
            if answer["id"] == self.last.get() {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.borrow_mut().push(answer);
        }
    }
}

/// An open page.
pub struct Opened<'a> {
    browser: &'a Browser,
    session: String,
    target: Value,
}

impl<'a> Opened<'a> {
    /// Opens an address and waits until its figures are drawn.
    pub fn new(browser: &'a Browser, address: &str) -> Self {
        let opened = Self::new_plain(browser, address);
        opened.wait("document.documentElement?.dataset.plots === 'drawn'");
        opened
    }

    /// Opens a page, with figures or without.
    pub fn new_plain(browser: &'a Browser, address: &str) -> Self {
        let target = browser.call(None, "Target.createTarget", json!({ "url": "about:blank" }))["targetId"].clone();
        let attached = browser.call(None, "Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        let session = attached["sessionId"].as_str().expect("a session").to_owned();
        let opened = Self { browser, session, target };
        for domain in ["Runtime", "Log", "Network"] {
            opened.call(&format!("{domain}.enable"), json!({}));
        }
        opened.call("Page.navigate", json!({ "url": address }));
        opened.wait(&format!("location.href === '{address}' && document.readyState === 'complete'"));
        opened
    }

    fn call(&self, method: &str, parameters: Value) -> Value {
        self.browser.call(Some(&self.session), method, parameters)
    }

    /// The value of an expression.
    pub fn value(&self, script: &str) -> Value {
        let parameters = json!({ "expression": script, "returnByValue": true, "awaitPromise": true });
        let found = self.call("Runtime.evaluate", parameters);
        assert!(found["exceptionDetails"].is_null(), "{script}: {}", found["exceptionDetails"]);
        found["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub fn wait(&self, script: &str) {
        let end = Instant::now() + PATIENCE;
        while self.value(script) != true {
            assert!(Instant::now() < end, "never true: {script}; {:?}", self.errors());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Clicks the middle of an element, as a mouse does.
    pub fn click(&self, selector: &str) {
        let at = self.hover(selector);
        for kind in ["mousePressed", "mouseReleased"] {
            let event = json!({ "type": kind, "x": at[0], "y": at[1], "button": "left", "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", event);
        }
    }

    /// Moves the mouse to the middle of an element, and returns where that is.
    pub fn hover(&self, selector: &str) -> Value {
        let at = self.value(&format!(
            "(e => {{ e.scrollIntoView({{ block: 'center' }}); const r = e.getBoundingClientRect(); \
             return [r.x + r.width / 2, r.y + r.height / 2]; }})(document.querySelector('{selector}'))"
        ));
        let event = json!({ "type": "mouseMoved", "x": at[0], "y": at[1] });
        self.call("Input.dispatchMouseEvent", event);
        at
    }

    /// Chooses dark colours as a system setting does.
    pub fn darken(&self) {
        let dark = json!({ "name": "prefers-color-scheme", "value": "dark" });
        self.call("Emulation.setEmulatedMedia", json!({ "features": [dark] }));
    }

    /// Gives the page the width of a phone.
    pub fn narrow(&self) {
        let phone = json!({ "width": 390, "height": 800, "deviceScaleFactor": 1, "mobile": true });
        self.call("Emulation.setDeviceMetricsOverride", phone);
    }

    /// Errors on the console, and exceptions.
    pub fn errors(&self) -> Vec<String> {
        let is_error = |event: &Value| match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Runtime.consoleAPICalled") => event["params"]["type"] == "error",
            Some("Log.entryAdded") => event["params"]["entry"]["level"] == "error",
            _ => false,
        };
        self.events(is_error).map(|event| event["params"].to_string()).collect()
    }

    /// Addresses that were requested, other than data within the page.
    pub fn requests(&self) -> Vec<String> {
        let sent = |event: &Value| event["method"] == "Network.requestWillBeSent";
        let address = |event: Value| event["params"]["request"]["url"].as_str().map(String::from);
        let own = self.events(sent).filter_map(address);
        own.filter(|url| !url.starts_with("data:") && !url.starts_with("blob:")).collect()
    }

    fn events(&self, chosen: impl Fn(&Value) -> bool) -> impl Iterator<Item = Value> {
        let all = self.browser.events.borrow();
        let own = all.iter().filter(|event| event["sessionId"] == self.session.as_str() && chosen(event));
        own.cloned().collect::<Vec<_>>().into_iter()
    }

    pub fn close(self) {
        self.browser.call(None, "Target.closeTarget", json!({ "targetId": self.target }));
    }
}
