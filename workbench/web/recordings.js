// Recordings that come in: those of which a model is made, and others that it judges.

import { by, make, short, size, table } from "./dom.js";
import { GONE } from "./program.js";
import { command, DRIVE, keep, kept, MODEL, result, say, session, show } from "./runs.js";
import { chosen, dropped, placed, refusal } from "./session.js";

/** Verdicts that are shown, and up to how many the list is open. */
const VERDICTS = 200, OPEN = 40;
const EXAMPLE = ["--class", "healthy,spall,roughness", "--count", "12", "--condition", "mix", "--severity", "0.5"];

/** Takes files for the model, or for it to judge. */
export async function take(files, isOther) {
  if (!files.length) return;
  const refused = refusal(files, session.now.files);
  const { files: own, folders } = placed(files, isOther ? "others" : "recordings", session.now.files);
  if (refused || !own.length) {
    say(refused || "There are no files in this.", true);
    return;
  }
  const all = session.with(own);
  if (isOther) {
    session.change({ files: all, others: folders[0], runs: { ...session.now.runs, replay: null, evaluate: null } });
    await judge();
  } else {
    session.change({ files: all, recordings: [...session.now.recordings, ...folders], seen: null, runs: {} });
    await look();
  }
}

/** Has the recordings described. */
export async function look() {
  const { recordings, rate } = session.now, time = rate ? ["--rate-hz", String(rate)] : [];
  const run = await command(["init", ...recordings, ...time, "--out", DRIVE, "--json", "--force"]);
  if (!run || run.stopped) return;
  const seen = run.reason ? null : JSON.parse(run.out);
  const files = run.reason ? session.now.files : session.with(run.written, run.removed);
  session.amend({ files, seen, runs: { init: kept(run) } });
  if (seen) by("h-description").scrollIntoView({ block: "start" });
}

/** Other recordings through the detector; and counted, if their classes can be told. */
async function judge() {
  const { others } = session.now;
  const replay = ["replay", "--model", MODEL, others, "--report", "replay.html", "--no-drive", "--json"];
  if (!await keep("replay", replay)) return;
  const described = await command(["init", others, "--out", `${others}/drive.toml`, "--json", "--force"]);
  if (!described || described.reason) return;
  const { labels, classes } = JSON.parse(described.out);
  if (classes.length === 1 && classes[0] === "reference") return;
  session.amend({ files: session.with(described.written, described.removed) });
  const evaluate = ["evaluate", "--model", MODEL, "--labels", labels, "--report", "evaluate.html", "--no-drive"];
  await keep("evaluate", evaluate);
}

async function simulate(seed, folder, isOther) {
  const run = await command(["simulate", ...EXAMPLE, "--seed", seed, "--out", folder]);
  if (!run || run.reason) return;
  await take(run.written.map(([path, bytes]) => [path, new Blob([bytes])]), isOther);
}

/** Takes the recordings out, to begin with others. */
function clear() {
  const { files: all, recordings } = session.now;
  const isOne = (path) => recordings.some((folder) => path.startsWith(`${folder}/`));
  const files = new Map([...all].filter(([path]) => !isOne(path) && path !== DRIVE));
  session.change({ files, recordings: [], rate: null, seen: null, runs: {} });
  by("choose-folder").focus();
}

export function showRecordings() {
  const { files, recordings, seen, runs } = session.now;
  const own = [...files].filter(([path]) => recordings.some((folder) => path.startsWith(`${folder}/`)));
  const bytes = own.reduce((sum, [, file]) => sum + file.size, 0);
  const button = (text, onclick) => make("button", { type: "button", "data-run": "", onclick }, text);
  show(by("list"), `${own.length} ${bytes} ${recordings} ${!seen}`, () => (own.length
    ? [make("p", { class: "row" }, make("span", {}, `${own.length} files in ${recordings.join(", ")}, ${size(bytes)}`),
      seen ? null : button("Look at them again", look), button("Take others in their place", clear))]
    : []));
  const told = seen ? make("p", {}, seen.told.replace(/^[^:]*: /, "")) : null;
  const refused = seen?.refused ? make("p", { class: "warn" }, `Training refuses this so far: ${seen.refused}`) : "";
  show(by("init"), runs.init, () => result(runs.init, { body: told && make("div", {}, told, refused) }));
}

function verdicts(run) {
  if (!run || run.reason) return null;
  const all = JSON.parse(run.out), alarm = all.find((own) => own.alarm)?.alarm;
  const distance = ({ distance: own }) => (own === null ? "" : short(own));
  const rows = all.slice(0, VERDICTS).map((own) => [
    own.trace, String(own.segment), own.verdict, distance(own), short(own.score),
    own.alarm ? `alarm: ${own.alarm.cause}` : "",
  ]);
  const more = all.length > VERDICTS ? `, the first ${VERDICTS} of ${all.length}` : "";
  const heads = ["Recording", "Segment", "Verdict", "Distance", "Evidence", "Alarm"];
  const said = alarm ? `Alarm at segment ${alarm.segment}: ${alarm.cause}` : "No alarm";
  return make("div", {}, make("p", { class: alarm ? "bad" : "good" }, said),
    make("details", { open: all.length <= OPEN }, make("summary", {}, `${all.length} verdicts`),
      table(`Verdicts${more}`, heads, rows)));
}

export function showOthers() {
  const { runs, recordings, files } = session.now;
  by("judge").hidden = !files.has(MODEL) || !runs.train;
  by("other-example").hidden = !recordings.includes("example");
  show(by("replay"), runs.replay, () =>
    result(runs.replay, { report: "replay.html", files: ["replay.html"], body: verdicts(runs.replay) }));
  show(by("evaluate"), runs.evaluate, () =>
    result(runs.evaluate, { report: "evaluate.html", files: ["evaluate.html"] }));
}

/** Does a work; what goes wrong is said. */
export async function attempt(work) {
  try {
    await work();
  } catch (error) {
    const isGone = ["NotFoundError", "NotReadableError"].includes(error.name);
    say(isGone ? GONE : error.message, true);
  }
}

function chooser(button, input, isOther) {
  by(button).addEventListener("click", () => by(input).click());
  by(input).addEventListener("change", () => attempt(async () => {
    const files = chosen(by(input).files);
    by(input).value = "";
    await take(files, isOther);
  }));
}

function dropZone(zone, isOther) {
  const mark = (isOver) => zone.classList.toggle("over", isOver);
  zone.addEventListener("dragover", (event) => { event.preventDefault(); mark(true); });
  zone.addEventListener("dragleave", () => mark(false));
  zone.addEventListener("drop", (event) => {
    event.preventDefault();
    event.stopPropagation();
    mark(false);
    attempt(async () => take(await dropped(event.dataTransfer.items), isOther));
  });
}

chooser("choose-folder", "folder", false);
chooser("choose-files", "files", false);
chooser("choose-other-folder", "other-folder", true);
chooser("choose-other-files", "other-files", true);
dropZone(by("drop"), false);
dropZone(by("drop-others"), true);
by("example").addEventListener("click", () => attempt(() => simulate("1", "example", false)));
by("other-example").addEventListener("click", () => attempt(() => simulate("2", "more", true)));
