// Changes of the texts that a user would make in an editor: drive.toml and labels.csv. What they mean, and whether they
// are right, the program says.

/** A number as people write it, 12.5 or 12,5; NaN of another text. */
export function number(text) {
  const plain = text.trim().replace(/^([+-]?\d*),(\d+)$/, "$1.$2");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
}

/** drive.toml with a value for a key, whose line is there, if only as a comment. */
export function withKey(text, section, key, value) {
  const line = `${key} = ${value}`, own = new RegExp(`^(# )?${key} = .*$`, "m");
  if (own.test(text)) return text.replace(own, () => line);
  const head = new RegExp(`^\\[${section}\\]$`, "m");
  return head.test(text) ? text.replace(head, (found) => `${found}\n${line}`) : `${text}\n[${section}]\n${line}\n`;
}

/** Whether drive.toml has a value for a key. */
export const hasKey = (text, key) => new RegExp(`^${key} = `, "m").test(text);

/** drive.toml with an answer in the place of the question mark of each of these texts. */
export function answered(text, marks, answer) {
  return marks.reduce((all, mark) => all.replaceAll(mark, mark.replaceAll("?", answer)), text);
}

/** A question is open as long as its texts are in drive.toml, in a line that is no comment. */
export function isOpen(question, drive, labels) {
  const lines = drive.split("\n").filter((line) => !line.startsWith("#"));
  if (question.marks.length) return lines.some((line) => question.marks.some((mark) => line.includes(mark)));
  if (question.key === "labels") return classesOf(labels).every(([, name]) => name === "reference");
  return !hasKey(drive, question.key);
}

function cells(line) {
  const all = line.match(/("([^"]|"")*"|[^,]*)(,|$)/g) ?? [];
  const last = line.endsWith(",") ? all.length : Math.max(all.length - 1, 1);
  return all.slice(0, last).map((cell) => cell.replace(/,$/, "").replace(/^"(.*)"$/, "$1").replaceAll('""', '"'));
}

const written = (cell) => (/[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);

/** The recordings of labels.csv with their classes. */
export function classesOf(labels) {
  const [head, ...lines] = labels.replace(/^\ufeff/, "").trimEnd().split(/\r?\n/);
  const names = cells(head), trace = names.indexOf("trace"), own = names.indexOf("class_name");
  return trace < 0 || own < 0 ? [] : lines.map(cells).map((row) => [row[trace] ?? "", row[own] ?? ""]);
}

/** labels.csv with other classes; `classOf(trace, before)` names them. */
export function withClasses(labels, classOf) {
  const [head, ...lines] = labels.replace(/^\ufeff/, "").trimEnd().split(/\r?\n/);
  const names = cells(head), trace = names.indexOf("trace"), own = names.indexOf("class_name");
  const rows = lines.map(cells).map((row) => {
    row[own] = classOf(row[trace], row[own]);
    return row.map(written).join(",");
  });
  return `${[head, ...rows].join("\n")}\n`;
}
