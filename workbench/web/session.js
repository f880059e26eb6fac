// The session: files and results of commands. Each change can be undone; a session is saved as an archive.

import { pack, unpack } from "./zip.js";

/** Changes that can be undone. */
const MOST = 50;
/** What a page takes: the program has 4 GB of memory, of which the numbers of the recordings take a part. */
export const LARGEST_FILE = 1e9, LARGEST_SET = 2e9;
const NOTES = "session.json";

export class Session {
  constructor() {
    this.now = { files: new Map(), recordings: [], rate: null, others: null, seen: null, runs: {} };
    this.past = [];
    this.isSaved = true;
    this.listeners = [];
  }

  /** Takes another state; the one before can be had again. */
  change(patch) {
    this.past.push(this.now);
    if (this.past.length > MOST) this.past.shift();
    this.now = { ...this.now, ...patch };
    this.isSaved = false;
    this.tell();
  }

  /** The same without a place to go back to: it belongs to the change before. */
  amend(patch) {
    this.now = { ...this.now, ...patch };
    this.tell();
  }

  undo() {
    this.now = this.past.pop() ?? this.now;
    this.tell();
  }

  tell() {
    this.listeners.forEach((listener) => listener());
  }

  /** The files with others in their place or beside them, and without those that were removed. */
  with(files, removed = []) {
    const all = new Map(this.now.files);
    removed.forEach((path) => all.delete(path));
    files.forEach(([path, content]) => all.set(path, content instanceof Blob ? content : new Blob([content])));
    return all;
  }

  text(path) {
    return this.now.files.get(path)?.text() ?? Promise.resolve("");
  }

  async packed(onFile) {
    const { files, ...others } = this.now;
    const notes = JSON.stringify(others);
    const blob = await pack([...files, [NOTES, new Blob([notes])]], onFile);
    this.isSaved = true;
    return blob;
  }

  async open(blob) {
    const files = new Map(await unpack(blob)), notes = files.get(NOTES);
    if (!notes) throw new Error("this archive is none of a session: it has no session.json");
    files.delete(NOTES);
    this.change({ ...JSON.parse(await notes.text()), files });
    this.isSaved = true;
  }
}

/** Why files cannot be taken; empty if they can. */
export function refusal(files, taken) {
  const large = files.find(([, file]) => file.size > LARGEST_FILE);
  const cure = "Cut or decimate it, or use the installed program, which has no such limit.";
  if (large) {
    const gigabytes = (large[1].size / 1e9).toPrecision(2);
    return `${large[0]} has ${gigabytes} GB; a page takes files of up to 1 GB. It was not read. ${cure}`;
  }
  const all = [...taken.values(), ...files.map(([, file]) => file)].reduce((sum, file) => sum + file.size, 0);
  return all > LARGEST_SET
    ? `With these files the session has ${(all / 1e9).toPrecision(2)} GB; a page takes up to 2 GB. They were not read.`
    : "";
}

/** Files and folders of a drop: paths and files, at any depth. */
export async function dropped(items) {
  const all = [...items].filter((item) => item.kind === "file"), files = [];
  // Before anything is waited for: the list is empty afterwards. A page of a file has no entries, but handles.
  if (all[0]?.getAsFileSystemHandle) {
    const visit = async (handle, prefix) => {
      const path = prefix + handle.name;
      if (handle.kind === "file") files.push([path, await handle.getFile()]);
      else for await (const one of handle.values()) await visit(one, `${path}/`);
    };
    for (const handle of await Promise.all(all.map((item) => item.getAsFileSystemHandle()))) await visit(handle, "");
    return files.sort(([one], [other]) => (one < other ? -1 : 1));
  }
  const entries = all.map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  const once = (call) => new Promise((resolve, reject) => { call(resolve, reject); });
  const visit = async (entry, prefix) => {
    const path = prefix + entry.name;
    if (entry.isFile) {
      files.push([path, await once((resolve, reject) => entry.file(resolve, reject))]);
      return;
    }
    const reader = entry.createReader();
    // A reader returns some entries at a time.
    for (let some; (some = await once((resolve, reject) => reader.readEntries(resolve, reject))).length;) {
      for (const one of some) await visit(one, `${path}/`);
    }
  };
  for (const entry of entries) await visit(entry, "");
  return files.sort(([one], [other]) => (one < other ? -1 : 1));
}

/** Files of a chooser. */
export const chosen = (list) => [...list].map((file) => [file.webkitRelativePath || file.name, file]);

/** Loose files in a folder, and folders with a name that is not taken. */
export function placed(files, folder, taken) {
  const tops = new Set(files.map(([path]) => (path.includes("/") ? path.split("/")[0] : "")));
  const isTaken = (name) => [...taken.keys()].some((path) => path.startsWith(`${name}/`));
  const names = new Map([...tops].map((top) => {
    const start = (top || folder).replace(/^[.-]+/, "") || folder;
    let name = start;
    for (let k = 2; isTaken(name); k++) name = `${start}-${k}`;
    return [top, name];
  }));
  // Files such as .DS_Store are of the system, not of the user.
  const visible = files.filter(([path]) => !path.split("/").some((name) => name.startsWith(".")));
  const whole = ([path, file]) => {
    const top = path.includes("/") ? path.split("/")[0] : "";
    return [`${names.get(top)}/${top ? path.slice(top.length + 1) : path}`, file];
  };
  return { files: visible.map(whole), folders: [...names.values()] };
}
