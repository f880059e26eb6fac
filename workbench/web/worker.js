// Runs one command in a worker: the page stays alive meanwhile, and ends it by ending the worker.

import { Content, tree, walk } from "./files.js";
import { run, runWaiting } from "./wasi.js";

/** A content that reads a file of the computer when the program does. */
function onDisk(file) {
  const reader = new FileReaderSync();
  const read = (from, to) => new Uint8Array(reader.readAsArrayBuffer(file.slice(from, to)));
  return new Content(file.size, read, file.lastModified ?? Date.now());
}

/** What the page gives to standard input: pieces in a row, of which an empty one is the end. */
class Input {
  constructor() {
    this.pieces = [];
    this.wake = () => {};
  }

  push(piece) {
    this.pieces.push(piece);
    this.wake();
  }

  async read(length) {
    if (!this.pieces.length) postMessage({ kind: "waits" });
    while (!this.pieces.length) await new Promise((resolve) => { this.wake = resolve; });
    const [first] = this.pieces;
    if (first.length > length) this.pieces[0] = first.subarray(length);
    else if (first.length) this.pieces.shift();
    return first.subarray(0, length);
  }
}

const input = new Input();

/**
 * Runs `words` over `files`, a list of paths and blobs; posts what it prints, and what it has written at its end. With
 * `live` it also reads what comes later; its standard output is `text` or `bytes`.
 */
async function work({ module, words, files, live }) {
  const decoders = [1, 2].map(() => new TextDecoder());
  const print = (fd, bytes) => {
    if (fd === 1 && live === "bytes") {
      postMessage({ kind: "bytes", bytes }, [bytes.buffer]);
      return;
    }
    const text = decoders[fd - 1].decode(bytes, { stream: true });
    if (text) postMessage({ kind: "text", fd, text });
  };
  const root = tree(files.map(([path, file]) => [path, onDisk(file)]));
  const before = new Set(files.map(([path]) => path));
  let code;
  try {
    code = live ? await runWaiting(module, words, root, print, (length) => input.read(length))
      : run(module, words, root, print);
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
  if (data.input) input.push(data.input);
  else work(data).catch((error) => postMessage({ kind: "broken", reason: String(error) }));
};
