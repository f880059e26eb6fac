// Runs one command in a worker: the page stays alive meanwhile, and ends it by ending the worker.

import { Content, tree, walk } from "./files.js";
import { run } from "./wasi.js";

/** A content that reads a file of the computer when the program does. */
function onDisk(file) {
  const reader = new FileReaderSync();
  const read = (from, to) => new Uint8Array(reader.readAsArrayBuffer(file.slice(from, to)));
  return new Content(file.size, read, file.lastModified ?? Date.now());
}

/** Runs `words` over `files`, a list of paths and blobs; posts what it prints, and what it has written at its end. */
function work({ module, words, files }) {
  const decoders = [1, 2].map(() => new TextDecoder());
  const print = (fd, bytes) => {
    const text = decoders[fd - 1].decode(bytes, { stream: true });
    if (text) postMessage({ kind: "text", fd, text });
  };
  const root = tree(files.map(([path, file]) => [path, onDisk(file)]));
  const before = new Set(files.map(([path]) => path));
  let code;
  try {
    code = run(module, words, root, print);
  } catch (error) {
    // A trap: memory that is full, or a mistake of the program, which has said so.
    postMessage({ kind: "broken", reason: String(error) });
    return;
  }
  const written = [];
  for (const [path, content] of walk(root)) {
    before.delete(path);
    if (content.isChanged) written.push([path, content.all()]);
  }
  postMessage({ kind: "end", code, written, removed: [...before] }, written.map(([, bytes]) => bytes.buffer));
}

onmessage = ({ data }) => {
  try {
    work(data);
  } catch (error) {
    postMessage({ kind: "broken", reason: String(error) });
  }
};
