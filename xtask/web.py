"""The whole way in the page, by clicks in Chromium, beside the native program.

    web.py PAGE PROGRAM CHROMIUM DRIVER FOLDER [RECORDINGS]

Recordings are dropped, questions answered, a model trained and downloaded, other recordings judged, and the session
saved and opened; then what is wrong is refused. Pictures for people are written to FOLDER. With RECORDINGS only the
time is printed that the page takes to train a model of them.
"""

import base64
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

PAGE, PROGRAM, CHROMIUM, DRIVER, OUT = (pathlib.Path(word).absolute() for word in sys.argv[1:6])
PATIENCE_S = 180
WIDTHS = {375: 812, 1400: 900}


def native(folder, line, sent=None):
    done = subprocess.run([PROGRAM, *line.split()], cwd=folder, capture_output=True, input=sent)
    assert done.returncode < 2, f"{line}: {done.stderr}"
    return done.stdout


def browser(downloads, profile):
    options = webdriver.ChromeOptions()
    options.binary_location = str(CHROMIUM)
    flags = ["headless", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run", "disable-background-networking"]
    flags += ["disable-component-update", "disable-sync", f"user-data-dir={profile}", "window-size=1400,900"]
    for flag in flags:
        options.add_argument(f"--{flag}")
    options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(service=Service(str(DRIVER)), options=options)


class Way:
    """The page, and what a user does in it."""

    def __init__(self, driver, downloads):
        self.driver, self.downloads, self.wait = driver, downloads, WebDriverWait(driver, PATIENCE_S)
        self.requests = []

    def element(self, css):
        return self.driver.find_element(By.CSS_SELECTOR, css)

    def all(self, css):
        return self.driver.find_elements(By.CSS_SELECTOR, css)

    def click(self, css):
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", self.element(css))
        self.element(css).click()

    def status(self):
        return self.element("#status").text

    def until(self, what, condition):
        self.wait.until(lambda _: condition(), f"{what}: the page says “{self.status()}”")

    def ended(self, command):
        self.until(command, lambda: self.status().startswith(f"{command}:") or not self.element("#stop").is_displayed())

    def drop(self, zone, paths):
        """Drags files and folders of the computer onto a place."""
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", self.element(zone))
        box = self.element(zone).rect
        y = box["y"] - self.driver.execute_script("return scrollY")
        point = {"x": box["x"] + box["width"] / 2, "y": y + 10}
        data = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}
        for kind in ["dragEnter", "dragOver", "drop"]:
            self.driver.execute_cdp_cmd("Input.dispatchDragEvent", {"type": kind, **point, "data": data})

    def downloaded(self, name):
        self.click(f"button[data-file='{name}']")
        file = self.downloads / pathlib.Path(name).name
        self.until(name, lambda: file.is_file())
        content = file.read_bytes()
        file.unlink()
        return content

    def commands(self):
        return [own.text.removeprefix("bearing-watch ") for own in self.all(".command") if own.is_displayed()]

    def picture(self, name, dark=False):
        media = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media})
        for width, height in WIDTHS.items():
            metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
            self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
            time.sleep(0.5)
            wide = self.driver.execute_script("return document.documentElement.scrollWidth")
            assert wide <= width, f"{name}: the page is {wide} wide at {width}"
            whole = self.driver.execute_script("return document.documentElement.scrollHeight")
            self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {**metrics, "height": min(whole, 6000)})
            time.sleep(1)
            self.driver.save_screenshot(str(OUT / f"{name}-{width}.png"))
        self.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        media[0]["value"] = ""
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media})

    def check_names(self):
        """Every control that a screen reader meets has a name."""
        nodes = self.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
        roles = {"button", "link", "textbox", "combobox", "checkbox", "spinbutton", "Iframe", "image", "img", "table",
                 "region", "progressbar", "group", "listbox", "searchbox", "slider"}
        for node in nodes:
            role = node.get("role", {}).get("value")
            if node.get("ignored") or role not in roles or role == "group":
                continue
            assert node.get("name", {}).get("value", "").strip(), f"a {role} without a name: {json.dumps(node)[:400]}"

    def check_log(self):
        """No error, and no request but for the page itself."""
        errors = [own["message"] for own in self.driver.get_log("browser") if own["level"] in ("SEVERE", "WARNING")]
        assert not errors, errors
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                url = message["params"]["request"]["url"]
                # The browser starts with a page of its own.
                assert url.split(":")[0] in ("file", "blob", "data", "chrome"), url


def prepare(folder):
    """Recordings without a time, so that the page asks for their rate."""
    native(folder, "simulate --class healthy,spall --count 10 --seed 1 --condition mix --severity 0.5 --out bench")
    native(folder, "simulate --class healthy,spall --count 3 --seed 2 --condition mix --severity 0.5 --out more")
    for file in [*folder.glob("bench/*.csv"), *folder.glob("more/*.csv")]:
        if file.name == "labels.csv":
            file.unlink()
            continue
        rows = (line.split(",", 1)[1] for line in file.read_text().splitlines())
        file.write_text("\n".join(rows) + "\n")


def train(way, folder):
    """From the drop to the model; returns the commands of the page."""
    way.drop("#drop", [folder / "bench"])
    way.until("init", lambda: way.element("#columns table").is_displayed())
    way.ended("init")
    way.picture("described")
    assert "how many rows a second" in way.element("#questions").text, way.element("#questions").text
    way.element("#questions input").send_keys("500,0")
    way.click("#questions button.first")
    way.until("answers", lambda: not way.all("#questions .question") and way.status().startswith("init: done"))
    for place, value in [("balls", "9"), ("ball", "3,0"), ("pitch", "17"), ("contact", "10.0")]:
        way.element(f"#{place}").send_keys(value)
    way.element("#contact").send_keys(Keys.ENTER)
    way.until("bearing", lambda: "[9, 3, 17, 10]" in way.element("#bearing-said").text)
    for step in ["audit", "train"]:
        way.click(f"button[data-run={step}]")
        way.until(step, lambda: way.status().startswith(f"{step}: "))
        assert "done" in way.status(), way.status()
        way.until(step, lambda: way.all(f"#{step} iframe"))
    return way.commands()


def judge(way, folder):
    way.element("#other-files").send_keys("\n".join(str(file) for file in sorted((folder / "more").glob("*.csv"))))
    way.until("evaluate", lambda: way.all("#evaluate .command"))
    assert "verdicts" in way.element("#replay").text, way.element("#replay").text
    assert "error rate" in way.element("#evaluate .printed:not(.warn)").text


def compare(way, folder, lines):
    """The commands that the page shows, in a terminal: the same files."""
    drive = way.downloaded("drive.toml")
    native(folder, lines[0])
    (folder / "drive.toml").write_bytes(drive)
    for line in lines[1:]:
        native(folder, line)
    for name in ["out.bwm", "model.rs", "model.h", "train.html", "audit.html"]:
        assert way.downloaded(name) == (folder / name).read_bytes(), f"{name} differs from the native one"
    (folder / "others").mkdir()
    for file in (folder / "more").glob("*.csv"):
        shutil.copy(file, folder / "others")
    for line in way.commands():
        if line.startswith(("replay", "evaluate")):
            if line.startswith("evaluate"):
                native(folder, "init others --out others/drive.toml --json --force")
            native(folder, line)
            name = line.split()[0] + ".html"
            assert way.downloaded(name) == (folder / name).read_bytes(), f"{name} differs from the native one"


def session(way):
    """A session that is saved, opened in another page and undone."""
    model = way.downloaded("out.bwm")
    way.click("#save")
    archive = way.downloads / "session.zip"
    way.until("session", lambda: archive.is_file() and "session.zip" in way.status())
    way.driver.get(PAGE.as_uri())
    way.element("#open-file").send_keys(str(archive))
    way.until("session", lambda: way.all("button[data-file='out.bwm']"))
    assert way.downloaded("out.bwm") == model
    way.click("#undo")
    way.until("undo", lambda: not way.element("#judge").is_displayed())


def told(way):
    """What the page of a drive says now."""
    way.driver.switch_to.frame(way.element("#live iframe"))
    text = " ".join(own.text for own in way.all("#news"))
    way.driver.switch_to.default_content()
    return text


def demo(way):
    """A newcomer damages the simulated drive, and sees the alarm; returns the seconds until then."""
    way.driver.get(PAGE.as_uri())
    started = time.monotonic()
    way.click("#demo-start")
    said = lambda: way.element("#live-said").text
    way.until("a healthy verdict", lambda: "healthy. No alarm" in said())
    move = "const own = document.querySelector('[name=spall]'); own.focus(); return own"
    way.driver.execute_script(move).send_keys(Keys.PAGE_UP * 5)
    way.until("an alarm", lambda: "ALARM" in said())
    seconds = time.monotonic() - started
    way.until("the reason", lambda: "order has risen" in told(way))
    way.check_names()
    way.picture("live")
    way.click("#live-end")
    way.until("the end", lambda: "no longer listened to" in way.status())
    return seconds


# A port as the browser gives it, that sends what the test has, and then nothing more.
PORT = """
const bytes = Uint8Array.from(atob(arguments[0]), (c) => c.charCodeAt(0));
const parts = () => new ReadableStream({ start(to) {
  for (let at = 0; at < bytes.length; at += 5000) to.enqueue(bytes.slice(at, at + 5000));
} });
window.opened = null;
const port = { open: async (about) => { window.opened = about; port.readable = parts(); }, close: async () => {} };
Object.defineProperty(navigator, "serial", { value: { requestPort: async () => port }, configurable: true });
"""


def cable(way, folder):
    """A drive on a serial port: its verdicts, what it sent as a file, and its samples as recordings."""
    frames = native(folder, "demo-drive", b"spall=0\nfault=stuck-angle\n")
    (folder / "frames.bin").write_bytes(frames)
    lines = [json.loads(line) for line in native(folder, "listen frames.bin --json --out live").splitlines()]
    reports = [line for line in lines if line["kind"] == "report"]
    way.driver.get(PAGE.as_uri())
    way.driver.execute_script(PORT, base64.b64encode(frames).decode())
    way.element("#baud").clear()
    way.element("#baud").send_keys("921600")
    way.click("#port-open")
    last = f"Segment {reports[-1]['segment']}: no verdict, because {reports[-1]['undetermined']}"
    way.until("the last report", lambda: last in way.element("#live-said").text)
    assert way.driver.execute_script("return window.opened.baudRate") == 921600
    way.until("the page", lambda: reports[-1]["undetermined"] in told(way))
    way.click("#live-end")
    way.until("the end", lambda: "no longer listened to" in way.status())
    assert way.downloaded("received.bin") == frames
    way.click("#live-take")
    way.until("init", lambda: way.all("#columns table"))
    way.ended("init")
    samples = sum(line["samples"] for line in lines if line["kind"] == "trace")
    assert f"{samples} rows" in way.element("#columns caption").text, way.element("#columns caption").text
    # A port that is refused, or given no rate, is said.
    way.driver.get(PAGE.as_uri())
    refuse = "throw new DOMException('Failed to open serial port.', 'NetworkError')"
    script = f"const port = {{ open: async () => {{ {refuse} }} }};"
    script += "Object.defineProperty(navigator, 'serial', { value: { requestPort: async () => port } });"
    way.driver.execute_script(script)
    way.click("#port-open")
    way.until("the refusal", lambda: "Failed to open serial port" in way.status())
    way.element("#baud").clear()
    way.click("#port-open")
    way.until("the rate", lambda: "Bits a second is a number" in way.status())


def wrong(way, folder):
    """What cannot be used is said in a sentence, and nothing is lost."""
    way.driver.get(PAGE.as_uri())
    (folder / "huge.csv").touch()
    os.truncate(folder / "huge.csv", 2_100_000_000)
    (folder / "image.csv").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 8)
    way.element("#files").send_keys(str(folder / "huge.csv"))
    way.until("size", lambda: "huge.csv has 2.1 GB" in way.status())
    way.element("#files").send_keys(str(folder / "image.csv"))
    way.until("format", lambda: way.status().startswith("init: ") and "no recording can be read" in way.status())
    way.click("#undo")
    changed = folder / "changed.csv"
    shutil.copy(next((folder / "bench").glob("healthy*.csv")), changed)
    way.element("#files").send_keys(str(changed))
    way.until("init", lambda: way.all("#columns table"))
    way.ended("init")
    changed.write_text("other\n1\n")
    way.click("button[data-run=audit]")
    way.until("change", lambda: "was changed, moved or removed" in way.status())
    assert way.element("#drive").get_attribute("value"), "the description is lost"
    # A run that is stopped leaves everything as it was.
    way.click("#example")
    way.until("stop", lambda: way.element("#stop").is_displayed())
    way.click("#stop")
    way.until("stop", lambda: "Stopped" in way.status())


def keyboard(way):
    """Each control is reached by the tabulator, in the order of the page, and its focus is seen."""
    way.driver.get(PAGE.as_uri())
    time.sleep(0.5)
    names = []
    for _ in range(11):
        way.element("body").send_keys(Keys.TAB)
        names.append(way.driver.execute_script("return document.activeElement.id"))
    wanted = ["open", "demo-start", "port-open", "baud", "choose-folder", "choose-files", "example"]
    assert [name for name in names if name in wanted] == wanted, names


def measure(way, recordings):
    way.drop("#drop", [recordings])
    way.until("init", lambda: way.all("#columns table"))
    way.ended("init")
    times = []
    for _ in range(3):
        way.click("button[data-run=train]")
        way.ended("train")
        way.until("train", lambda: way.status().startswith("train: done in "))
        times.append(float(way.status().split()[3]))
    print(min(times))


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        folder, downloads = pathlib.Path(place), pathlib.Path(place, "downloads")
        downloads.mkdir()
        recordings = pathlib.Path(sys.argv[6]).absolute() if len(sys.argv) > 6 else None
        if not recordings:
            prepare(folder)
        driver = browser(downloads, folder / "profile")
        try:
            way = Way(driver, downloads)
            driver.get(PAGE.as_uri())
            if recordings:
                measure(way, recordings)
                return
            way.picture("start")
            keyboard(way)
            way.driver.get(PAGE.as_uri())
            started = time.monotonic()
            lines = train(way, folder)
            print(f"from the drop to the model: {time.monotonic() - started:.1f} s")
            judge(way, folder)
            way.check_names()
            way.picture("judged")
            way.picture("judged-dark", dark=True)
            compare(way, folder, lines)
            session(way)
            wrong(way, folder)
            print(f"from the closed page to the alarm of the demo drive: {demo(way):.1f} s")
            cable(way, folder)
            way.check_log()
            print("passed")
        except BaseException:
            driver.save_screenshot(str(OUT / "failed.png"))
            raise
        finally:
            driver.quit()


main()
