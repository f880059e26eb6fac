// A drive, live: a simulated one, or one on a serial port. What it sends goes through `listen` of the program, whose
// page is shown.

import { by, download, make, size } from "./dom.js";
import { commandLine, failure } from "./program.js";
import { attempt, take } from "./recordings.js";
import { MODEL, program, say, session } from "./runs.js";
import { LARGEST_FILE } from "./session.js";
import { number } from "./texts.js";

/** Time between two runs of the simulated drive, ms. */
const BETWEEN = 1500;
const NO_BYTES = new Uint8Array(0);
/** Folder of the samples that a drive sends. */
const SAMPLES = "live";

/** What runs: the program that listens, and how its source is ended. */
let current = null;

/** What is set at the sliders, as a line of the drive's standard input. */
function settings() {
  const words = [...new FormData(by("wrong"))].map(([name, value]) => `${name}=${value}`);
  return words.join(" ");
}

function showSettings() {
  for (const input of by("wrong").querySelectorAll("input")) {
    input.labels[0].querySelector("b").textContent = Number(input.value);
  }
}

function setRunning(isRunning, isDemo = false) {
  by("demo-start").hidden = by("port-open").hidden = by("baud").labels[0].hidden = isRunning;
  by("live-end").hidden = !isRunning;
  by("wrong").hidden = !(isRunning && isDemo);
}

/** The page of `listen`, apart from this one; it takes news when it is ready. */
class Shown {
  constructor(place) {
    this.place = place;
    this.frame = null;
    this.isReady = false;
    this.last = null;
    addEventListener("message", ({ source, data }) => {
      if (source !== this.frame?.contentWindow || data !== "ready") return;
      this.isReady = true;
      if (this.last) this.news(this.last);
    });
  }

  page(html) {
    const src = URL.createObjectURL(new Blob([html], { type: "text/html" }));
    const before = this.frame?.src;
    this.frame = make("iframe", { src, title: "The drive, live", sandbox: "allow-scripts" });
    this.isReady = false;
    this.last = null;
    this.place.replaceChildren(this.frame);
    if (before) URL.revokeObjectURL(before);
  }

  news(html) {
    this.last = html;
    if (this.isReady) this.frame.contentWindow.postMessage(html, "*");
  }
}

/** Says how it stands with the drive. */
function tell(text, isAlarm = false) {
  by("live-said").textContent = text;
  by("live-said").className = isAlarm ? "bad" : "";
}

const verdictOf = ({ segment, verdict, undetermined, alarm }) => {
  const told = undetermined ? `no verdict, because ${undetermined}` : verdict;
  return `Segment ${segment}: ${told}. ${alarm ? `ALARM: ${alarm.cause}.` : "No alarm."}`;
};

/** Starts `listen` for a source with this command; returns it, with where its result is shown. */
async function listener(words, files, terminal) {
  const place = make("div", {}), shown = new Shown(place);
  by("live-result").replaceChildren(
    make("p", { class: "said" }, "The same in a terminal:"), make("div", { class: "command" }, terminal), place,
  );
  let rest = "";
  const onOut = (text) => {
    const lines = (rest + text).split("\n");
    rest = lines.pop();
    for (const line of lines.filter(Boolean)) {
      const told = JSON.parse(line);
      if (told.kind === "page") shown.page(told.html);
      else if (told.kind === "news") shown.news(told.html);
      else if (told.kind === "report") tell(verdictOf(told), Boolean(told.alarm));
    }
  };
  return program.start(words, { files, live: "text", onOut });
}

const VIEW = ["--view", "-", "--json"];

async function startDemo() {
  setRunning(true, true);
  tell("The drive learns what is healthy.");
  const terminal = "echo spall=0.5 | bearing-watch demo-drive | bearing-watch listen - --view 0";
  const heard = await listener(["listen", "-", ...VIEW], [], terminal);
  let sent = 0, timer = null;
  const next = () => {
    sent = performance.now();
    drive.write(new TextEncoder().encode(`${settings()}\n`));
  };
  const drive = await program.start(["demo-drive"], {
    live: "bytes",
    onOut: (bytes) => heard.write(bytes),
    onWait: () => { timer = setTimeout(next, Math.max(0, sent + BETWEEN - performance.now())); },
    onProgress: (text) => tell(`The drive is ${text}.`),
  });
  current = { end: drive.stop };
  const ended = drive.ended.then((run) => {
    clearTimeout(timer);
    heard.write(NO_BYTES);
    return run;
  });
  await finished(heard);
  drive.stop();
  const run = await ended;
  // What ended the drive is the reason of what `listen` says.
  if (!run.stopped) say(`demo-drive: ${failure(run)}`, true);
}

/** Waits for the end of `listen`, and says what was wrong. */
async function finished(heard) {
  const run = await heard.ended;
  current = null;
  setRunning(false);
  const reason = failure(run);
  say(reason ? `listen: ${reason}` : "The drive is no longer listened to.", Boolean(reason));
  return run;
}

async function connect() {
  const baudRate = number(by("baud").value);
  if (!(baudRate > 0)) {
    say("Bits a second is a number such as 115200; of a USB cable it does not matter.", true);
    by("baud").focus();
    return;
  }
  const port = await navigator.serial.requestPort().catch((error) => {
    // None was chosen.
    if (error.name !== "NotFoundError") throw error;
  });
  if (!port) return;
  await port.open({ baudRate });
  setRunning(true);
  tell("Nothing has come yet.");
  const model = session.now.files.get(MODEL), named = model ? ["--model", MODEL] : [];
  const words = ["listen", "-", "--out", SAMPLES, ...named];
  const terminal = commandLine(["listen", "/dev/ttyACM0", "--baud", String(baudRate), "--view", "0", ...words.slice(2)]);
  const heard = await listener([...words, ...VIEW], model ? [[MODEL, model]] : [], terminal);
  const received = [];
  let reader = null, isEnding = false;
  const end = () => {
    isEnding = true;
    reader?.cancel();
  };
  current = { end };
  heard.ended.then(end);
  let bytes = 0, lost = "";
  while (port.readable && !isEnding) {
    reader = port.readable.getReader();
    try {
      for (;;) {
        const { value, done } = await reader.read();
        if (done || isEnding) break;
        heard.write(value);
        bytes += value.length;
        if (bytes <= LARGEST_FILE) received.push(value);
      }
    } catch (error) {
      // A parity error or an overrun: the port goes on. If it does not, the cable is out.
      lost = error.message;
    } finally {
      reader.releaseLock();
      reader = null;
    }
  }
  const isOut = !port.readable;
  await port.close().catch(() => {});
  heard.write(NO_BYTES);
  const run = await finished(heard);
  if (isOut) say(`The drive was disconnected. ${lost}`, true);
  results(received, bytes, run.written);
}

/** Offers what was received. */
function results(received, bytes, written) {
  const raw = new Blob(received), samples = written.filter(([path]) => path.startsWith(`${SAMPLES}/`));
  if (!raw.size) return;
  const save = () => download(raw, "received.bin");
  const files = samples.map(([path, content]) => [path, new Blob([content])]);
  const full = bytes > raw.size ? make("p", { class: "warn" },
    `Of ${size(bytes)} the first ${size(raw.size)} are kept as they came; the samples and reports are of all.`) : null;
  by("live-result").append(...[full, make("div", { class: "downloads" },
    make("button", { type: "button", "data-file": "received.bin", onclick: save }, `Download received.bin (${size(raw.size)})`),
    files.length ? make("button", { type: "button", id: "live-take", onclick: () => attempt(() => take(files, false)) },
      `Take the samples as ${files.length} recordings`) : null)].filter(Boolean));
}

/** Why there is no live drive in this browser; empty if there is. */
function hindrance(isPort) {
  const newer = "Chrome or Edge from version 137 on";
  if (typeof WebAssembly.Suspending !== "function") {
    return `In this browser a program cannot wait for what comes; take ${newer}, or the installed program.`;
  }
  return isPort && !navigator.serial
    ? `This browser reads no serial ports; take ${newer} on a desktop, or the installed program.` : "";
}

const start = (isPort) => attempt(async () => {
  const why = hindrance(isPort);
  if (why) say(why, true);
  else if (!current) await (isPort ? connect() : startDemo());
});

export function listenLive() {
  by("demo-start").addEventListener("click", () => start(false));
  by("port-open").addEventListener("click", () => start(true));
  by("live-end").addEventListener("click", () => current?.end());
  by("wrong").addEventListener("input", showSettings);
  by("wrong").addEventListener("submit", (event) => event.preventDefault());
  showSettings();
}
