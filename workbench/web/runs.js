// Runs of commands on the files of the session, and what is shown of them.

import { by, download, make, size } from "./dom.js";
import { commandLine, failure, Program } from "./program.js";
import { Session } from "./session.js";

export const DRIVE = "drive.toml", MODEL = "out.bwm";

export const session = new Session();
export const program = new Program(by("program").textContent, by("worker").textContent);

/** Says how it stands, to eyes and to a screen reader. */
export function say(text, isBad = false) {
  by("status").textContent = text;
  by("status").classList.toggle("bad", isBad);
}

function progress(text) {
  const [, what, done, all] = text.match(/^(.*) (\d+)\/(\d+)$/) ?? [];
  if (!what) return;
  by("progress").max = Number(all);
  by("progress").value = Number(done);
}

/** While a command runs, no other one starts. */
function setBusy(isBusy) {
  by("stop").hidden = by("progress").hidden = !isBusy;
  by("progress").removeAttribute("value");
  document.querySelectorAll("[data-run], .drop button").forEach((button) => { button.disabled = isBusy; });
}

/** Runs a command on the files of the session; null while another one goes. */
export async function command(words) {
  if (program.isBusy) return null;
  const started = performance.now();
  say(`${words[0]} …`);
  setBusy(true);
  const run = await program.run(words, [...session.now.files], progress);
  setBusy(false);
  const reason = failure(run), seconds = ((performance.now() - started) / 1000).toFixed(1);
  say(reason ? `${words[0]}: ${reason}` : `${words[0]}: done in ${seconds} s`, Boolean(reason));
  return { ...run, words, reason };
}

/** Of a run what stays in the session. */
export const kept = ({ words, code, out, notes, reason }) => ({ words, code, out, notes, reason });

/** Runs a command; its files and its result under a name become part of the session. */
export async function keep(name, words) {
  const run = await command(words);
  if (!run || run.stopped) return null;
  const files = run.reason ? session.now.files : session.with(run.written, run.removed);
  session.change({ files, runs: { ...session.now.runs, [name]: kept(run) } });
  return run;
}

/** Takes another text of a file, after which the results of the commands no longer hold. */
export function rewrite(path, text) {
  session.change({ files: session.with([[path, text]]), runs: { init: session.now.runs.init } });
}

const urls = new Map();

/** A page that a command has written, apart from this one; its scripts draw the plots. */
function report(path) {
  const blob = session.now.files.get(path);
  if (!blob) return null;
  if (!urls.has(blob)) urls.set(blob, URL.createObjectURL(new Blob([blob], { type: "text/html" })));
  return make("iframe", { src: urls.get(blob), title: `Report ${path}`, sandbox: "allow-scripts", loading: "lazy" });
}

function downloads(paths) {
  const there = paths.filter((path) => session.now.files.has(path));
  const button = (path) => {
    const blob = session.now.files.get(path), name = path.split("/").pop();
    const attributes = { type: "button", "data-file": path, onclick: () => download(blob, name) };
    return make("button", attributes, `Download ${name} (${size(blob.size)})`);
  };
  return there.length ? make("div", { class: "downloads" }, there.map(button)) : null;
}

/** A line of an output: columns that are aligned by blanks stay so, sentences are broken. */
const line = (text) => make("div", { class: /\S {2,}\S/.test(text) ? "aligned" : null }, text || " ");

/** What a run has printed, or another body; its report and its files; and the same command for a terminal. */
export function result(run, { report: page, files = [], body = null } = {}) {
  if (!run) return [];
  const command = [
    make("p", { class: "said" }, "The same in a terminal:"),
    make("div", { class: "command" }, commandLine(run.words)),
  ];
  if (run.reason) return [...command, make("p", { class: "bad", role: "alert" }, run.reason)];
  const notes = run.notes.trim();
  const region = { tabindex: "0", role: "region", "aria-label": `Output of ${run.words[0]}` };
  const printed = make("div", { class: "printed", ...region }, run.out.trimEnd().split("\n").map(line));
  const parts = [
    notes ? make("div", { class: "printed warn" }, notes) : null,
    body ?? printed,
    downloads(files),
    page ? report(page) : null,
  ];
  return [...command, ...parts.filter(Boolean)];
}

/** Shows new elements, unless those of this key are shown: a report would be loaded again. */
export function show(place, key, elements) {
  if (place.shown === key) return;
  place.shown = key;
  place.replaceChildren(...elements());
}
