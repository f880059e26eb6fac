// The second step: columns, questions, bearing and classes, which become lines of drive.toml and labels.csv.

import { by, course, make, range, short, table } from "./dom.js";
import { DRIVE, rewrite, say, session, show } from "./runs.js";
import { answered, classesOf, isOpen, number, withClasses, withKey } from "./texts.js";

/** Rows of a table that are shown. */
const SHOWN = 200;
const ROLES = { velocity_ref: "velocity, reference", current_ref: "current, reference", phase: "phase current" };

/** The texts of the files that the step changes. */
const texts = { drive: "", labels: "" };

/** Shows the description; `drive` and `labels` are the texts of these files. */
export function showDescription(drive, labels) {
  Object.assign(texts, { drive, labels });
  const { seen } = session.now;
  if (!seen) return;
  show(by("columns"), seen, () => [columns(seen)]);
  if (by("drive").value !== drive) by("drive").value = drive;
  const open = openQuestions();
  show(by("questions"), JSON.stringify(open), () => (open.length ? [questions(open)] : []));
  const bearing = drive.match(/^bearing = (.*)$/m)?.[1];
  const none = "No bearing yet: friction alone is watched.";
  by("bearing-said").textContent = bearing ? `The bearing is ${bearing}.` : none;
  show(by("classes").lastElementChild, labels, classes);
}

function columns(seen) {
  const span = (parts) => (parts.length ? range(parts).map(short).join(" … ") : "no number");
  const rows = seen.columns.map((own) => [
    own.name, ROLES[own.role] ?? own.role, own.quantity, own.unit, span(own.course),
    own.course.length ? course(own.course, `Course of ${own.name}`) : null,
  ]);
  const rate = seen.rate_hz ? `, ${short(seen.rate_hz)} a second` : "";
  const heads = ["Column", "Taken as", "Quantity", "Unit", "Range", "Course"];
  return table(`Columns of the first recording: ${seen.rows} rows${rate}`, heads, rows);
}

const openQuestions = () => session.now.seen.questions.filter((own) => isOpen(own, texts.drive, texts.labels));

function questions(open) {
  const field = ({ answers }, id) => {
    if (!answers.length) return make("input", { id, inputmode: "decimal", size: "8" });
    const choices = answers.map((answer) => make("option", {}, answer));
    return make("select", { id }, make("option", { value: "" }, "choose"), choices);
  };
  const one = (question, k) => {
    const id = `question-${k}`, text = make("label", { for: id }, question.question);
    return make("div", { class: "question" }, text, make("div", {}, field(question, id)));
  };
  const name = () => {
    by("classes").open = true;
    by("class-words").focus();
  };
  const ofClasses = (question) => make("div", { class: "question" },
    make("p", {}, question.question), make("button", { type: "button", onclick: name }, "Name the classes"));
  const others = open.filter((question) => question.key !== "labels");
  const button = others.length ? make("button", { class: "first" }, "Write the answers") : null;
  const labels = open.filter((question) => question.key === "labels");
  return make("fieldset", {}, make("legend", {}, "Questions"), others.map(one), button, labels.map(ofClasses));
}

/** Writes the answers. With the rate of the rows the recordings are described anew: it tells what the channels are. */
function answer(event, look) {
  event.preventDefault();
  let text = texts.drive, rate = null;
  for (const [k, question] of openQuestions().filter((own) => own.key !== "labels").entries()) {
    const word = by(`question-${k}`).value.trim(), value = question.answers.length ? word : number(word);
    if (word === "") continue;
    if (Number.isNaN(value)) {
      say(`“${word}” is no number; write 12.5 or 12,5.`, true);
      by(`question-${k}`).focus();
      return;
    }
    if (question.key) rate = value;
    else text = answered(text, question.marks, value);
  }
  if (rate) {
    session.change({ rate });
    look();
    return;
  }
  rewrite(DRIVE, text);
  say("The answers are in drive.toml.");
}

function takeBearing(event) {
  event.preventDefault();
  const designation = by("designation").value.trim(), places = ["balls", "ball", "pitch", "contact"];
  const numbers = places.map((id) => number(by(id).value)), wrong = numbers.findIndex(Number.isNaN);
  if (!designation && wrong >= 0) {
    say("Give the designation, or all four numbers; write 12.5 or 12,5.", true);
    by(places[wrong]).focus();
    return;
  }
  const value = designation ? JSON.stringify(designation) : `[${numbers.join(", ")}]`;
  rewrite(DRIVE, withKey(texts.drive, "bearing", "bearing", value));
  say("The bearing is in drive.toml.");
}

function classes() {
  const all = classesOf(texts.labels), counts = new Map(), path = session.now.seen.labels;
  all.forEach(([, name]) => counts.set(name, (counts.get(name) ?? 0) + 1));
  const set = (event) => {
    event.preventDefault();
    const words = by("class-words").value.trim().toLowerCase(), name = by("class-name").value.trim();
    if (!name) {
      by("class-name").focus();
      return;
    }
    const classOf = (trace, before) => (trace.toLowerCase().includes(words) ? name : before);
    rewrite(path, withClasses(texts.labels, classOf));
    say(`The class ${name} is in ${path}.`);
    by("class-words").focus();
  };
  const words = make("input", { id: "class-words", size: "14", autocomplete: "off" });
  const name = make("input", { id: "class-name", size: "12", list: "class-names", autocomplete: "off" });
  const known = [...new Set(["healthy", ...counts.keys()])].map((value) => make("option", { value }));
  const form = make("form", { class: "row", onsubmit: set },
    make("label", {}, "Recordings with this in their names", words), make("label", {}, "are of the class", name),
    make("datalist", { id: "class-names" }, known), make("button", {}, "Set the class"));
  const counted = [...counts].map(([own, count]) => `${count} ${own}`).join(", ");
  const caption = `Recordings with their classes${all.length > SHOWN ? `, the first ${SHOWN}` : ""}`;
  return [make("p", {}, counted), form, table(caption, ["Recording", "Class"], all.slice(0, SHOWN))];
}

/** `look` has the recordings described. */
export function listen(look) {
  by("questions").addEventListener("submit", (event) => answer(event, look));
  by("bearing").addEventListener("submit", takeBearing);
  by("drive").addEventListener("change", () => rewrite(DRIVE, by("drive").value));
}
