// Texts that the page changes, and the archive of a session: `node --test workbench/web/tests/`.

import assert from "node:assert/strict";
import test from "node:test";

import { answered, classesOf, hasKey, isOpen, number, withClasses, withKey } from "../texts.js";
import { pack, unpack } from "../zip.js";
import { placed, refusal } from "../session.js";
import { commandLine, failure } from "../program.js";

const DRIVE = `# Files
[data]
traces = ["runs"]
# rate_hz = 1000  # if the files have no time
[channels]
angle = "position[?]"
# u2 = "load_nm"
[bearing]
# bearing = [9, 3, 17, 10]  # balls
`;

test("numbers are read in English and in German", () => {
  assert.deepEqual(["12.5", " 12,5 ", "-3", ",5", "1e3"].map(number), [12.5, 12.5, -3, 0.5, 1000]);
  for (const text of ["", "1.234,5", "1,234.5", "12 mm", "--1"]) assert.ok(Number.isNaN(number(text)), text);
});

test("a key takes the place of its example, or stands below its heading", () => {
  const text = withKey(withKey(DRIVE, "bearing", "bearing", '"6205"'), "data", "rate_hz", 1919);
  assert.ok(text.includes('\nbearing = "6205"\n') && text.includes("\nrate_hz = 1919\n"));
  assert.ok(!text.includes("# bearing"));
  assert.ok(withKey(text, "bearing", "slip", 0.01).includes("[bearing]\nslip = 0.01\n"));
  assert.ok(withKey("", "model", "offset", true).endsWith("[model]\noffset = true\n"));
  assert.ok(hasKey(text, "rate_hz") && !hasKey(DRIVE, "rate_hz"));
});

test("a question is open until its mark is gone", () => {
  const question = { marks: ["position[?]"], key: null, answers: ["rad", "deg"] };
  assert.ok(isOpen(question, DRIVE, ""));
  const text = answered(DRIVE, question.marks, "deg");
  assert.ok(text.includes('angle = "position[deg]"') && !isOpen(question, text, ""));
  const rate = { marks: [], key: "rate_hz" };
  assert.ok(isOpen(rate, DRIVE, "") && !isOpen(rate, withKey(DRIVE, "data", "rate_hz", 10), ""));
  const classes = { marks: [], key: "labels" }, labels = "trace,class_name\na.csv,reference\n";
  assert.ok(isOpen(classes, DRIVE, labels) && !isOpen(classes, DRIVE, withClasses(labels, () => "healthy")));
});

test("classes are cells of a table, with commas and quotes", () => {
  const labels = 'trace,run,class_name\r\n"a,1.csv",,reference\n"b ""2"".csv",3,reference\n';
  assert.deepEqual(classesOf(labels), [["a,1.csv", "reference"], ['b "2".csv', "reference"]]);
  const changed = withClasses(labels, (trace, before) => (trace.startsWith("a") ? "healthy, new" : before));
  assert.equal(changed, 'trace,run,class_name\n"a,1.csv",,"healthy, new"\n"b ""2"".csv",3,reference\n');
});

test("a session is packed and unpacked", async () => {
  const bytesOfModel = new Uint8Array([0, 255, 7]);
  const files = [["runs/ä 1.csv", new Blob(["1,2\n".repeat(1000)])], ["out.bwm", new Blob([bytesOfModel])]];
  const archive = await pack(files);
  assert.ok(archive.size < 1500);
  const again = await unpack(archive);
  assert.deepEqual(again.map(([name]) => name), ["runs/ä 1.csv", "out.bwm"]);
  assert.deepEqual(new Uint8Array(await again[1][1].arrayBuffer()), bytesOfModel);
  const bytes = new Uint8Array(await archive.arrayBuffer());
  bytes[60] ^= 1;
  await assert.rejects(unpack(new Blob([bytes])));
  await assert.rejects(unpack(new Blob(["no archive"])), /no archive/);
});

test("files have folders, and what does not fit is refused", () => {
  const taken = new Map([["runs/a.csv", { size: 1 }]]);
  const own = placed([["runs/b.csv", 1], ["runs/.DS_Store", 2]], "recordings", taken);
  assert.deepEqual(own, { files: [["runs-2/b.csv", 1]], folders: ["runs-2"] });
  assert.deepEqual(placed([["c.csv", 1]], "recordings", taken).files, [["recordings/c.csv", 1]]);
  assert.match(refusal([["a.csv", { size: 2.1e9 }]], taken), /a.csv has 2.1 GB.*up to 1 GB/);
  assert.match(refusal([1, 2, 3].map((k) => [`${k}.csv`, { size: 9e8 }]), taken), /2.7 GB/);
  assert.equal(refusal([["a.csv", { size: 1e6 }]], taken), "");
});

test("a command is written as a terminal takes it, and a failure in a sentence", () => {
  const line = commandLine(["init", "my runs", "--out", "drive.toml"]);
  assert.equal(line, 'bearing-watch init "my runs" --out drive.toml');
  const full = { kind: "broken", notes: "memory allocation of 8 bytes failed", reason: "unreachable" };
  assert.match(failure(full), /memory of the browser is full/);
  assert.equal(failure({ code: 2, notes: "error: a.csv: no rows\n", out: "" }), "a.csv: no rows");
  assert.equal(failure({ code: 1, notes: "", out: "" }), "");
});
