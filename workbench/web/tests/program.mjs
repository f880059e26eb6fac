// Runs the program of the page in Node.js on a folder of the disk:
//
//     node program.mjs PROGRAM.wasm FOLDER WORD…
//
// Files that it writes are written to the folder when it ends.

import fs from "node:fs";
import path from "node:path";
import process from "node:process";

import { Content, tree, walk } from "../files.js";
import { run } from "../wasi.js";

const [program, folder, ...words] = process.argv.slice(2);

function* onDisk(place, prefix = "") {
  for (const entry of fs.readdirSync(place, { withFileTypes: true })) {
    const own = path.join(place, entry.name), about = fs.statSync(own);
    if (about.isDirectory()) yield* onDisk(own, `${prefix}${entry.name}/`);
    else yield [prefix + entry.name, new Content(about.size, part(own), about.mtimeMs)];
  }
}

function part(file) {
  return (from, to) => {
    const fd = fs.openSync(file), bytes = new Uint8Array(to - from);
    const length = fs.readSync(fd, bytes, 0, bytes.length, from);
    fs.closeSync(fd);
    return bytes.subarray(0, length);
  };
}

/** Writes all of it: a pipe that is full takes a part, or nothing yet. */
function print(fd, bytes) {
  for (let at = 0; at < bytes.length;) {
    try {
      at += fs.writeSync(fd, bytes, at);
    } catch (error) {
      if (error.code !== "EAGAIN") throw error;
    }
  }
}

const root = tree(onDisk(folder)), before = new Set([...walk(root)].map(([name]) => name));
const module = new WebAssembly.Module(fs.readFileSync(program));
const code = run(module, words, root, print);
for (const [name, content] of walk(root)) {
  before.delete(name);
  if (!content.isChanged) continue;
  const own = path.join(folder, name);
  fs.mkdirSync(path.dirname(own), { recursive: true });
  fs.writeFileSync(own, content.all());
}
for (const name of before) fs.rmSync(path.join(folder, name));
process.exitCode = code;
