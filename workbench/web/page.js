// The page: the session is shown, and buttons run commands. What recordings, models and verdicts are worth,
// the commands say.

import { listen, showDescription } from "./description.js";
import { by, download } from "./dom.js";
import { listenLive } from "./live.js";
import { attempt, look, showOthers, showRecordings } from "./recordings.js";
import { DRIVE, keep, MODEL, program, result, say, session, show } from "./runs.js";

const COMMANDS = {
  audit: ["audit", DRIVE, "--report", "audit.html"],
  train: ["train", DRIVE, "--model", MODEL, "--rust", "model.rs", "--c", "model.h", "--report", "train.html"],
};
const FILES = { audit: ["audit.html"], train: [MODEL, "model.rs", "model.h", DRIVE, "train.html"] };

async function render() {
  const { files, seen, runs } = session.now;
  const [drive, labels] = await Promise.all([session.text(DRIVE), seen ? session.text(seen.labels) : ""]);
  by("undo").disabled = !session.past.length;
  by("save").disabled = !files.size;
  by("description").hidden = by("audit").hidden = by("train").hidden = !seen;
  showRecordings();
  showDescription(drive, labels);
  for (const [name, files] of Object.entries(FILES)) {
    const place = by(name).lastElementChild;
    show(place, runs[name], () => result(runs[name], { report: `${name}.html`, files }));
  }
  showOthers();
}

by("undo").addEventListener("click", () => {
  session.undo();
  say("The last change is undone.");
});
by("stop").addEventListener("click", () => program.stop());
by("save").addEventListener("click", () => attempt(async () => {
  const count = session.now.files.size;
  download(await session.packed((done) => say(`packing ${done}/${count}`)), "session.zip");
  say("The session is in session.zip.");
}));
by("open").addEventListener("click", () => by("open-file").click());
by("open-file").addEventListener("change", () => attempt(async () => {
  const [file] = by("open-file").files;
  await session.open(file);
  by("open-file").value = "";
  say("The session is open.");
}));
for (const [name, words] of Object.entries(COMMANDS)) {
  document.querySelector(`[data-run=${name}]`).addEventListener("click", () => attempt(() => keep(name, words)));
}
listen(() => attempt(look));
listenLive();
// Beside the place for files, a drop would leave the page.
for (const kind of ["dragover", "drop"]) addEventListener(kind, (event) => event.preventDefault());
addEventListener("beforeunload", (event) => { if (!session.isSaved) event.preventDefault(); });
session.listeners.push(render);
render();
