// The program, and its runs: each in a new worker, whose end is also how it is stopped.

/** Bytes of a part of the page, which are packed by gzip and written in base64. */
async function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** Lines of standard error that are progress, such as `reading 3/20` behind this sign. */
const PROGRESS = "\r";

export class Program {
  constructor(packed, workerSource) {
    this.module = unpacked(packed).then((bytes) => WebAssembly.compile(bytes));
    this.workerUrl = URL.createObjectURL(new Blob([workerSource], { type: "text/javascript" }));
    this.current = null;
    this.isBusy = false;
  }

  /**
   * Runs a command over a list of paths and blobs. Returns its exit code, what it has printed on both streams, and
   * the files that it has written and removed; of a run that breaks or is stopped, `code` is null.
   */
  async run(words, files, onProgress = () => {}) {
    this.isBusy = true;
    this.current = await this.start(words, { files, onProgress });
    const run = await this.current.ended;
    this.current = null;
    this.isBusy = false;
    return run;
  }

  /**
   * Starts a command. With `live`, `write` gives it bytes of standard input, none for its end; `onOut` takes what it
   * prints, `text` or `bytes`, and `onWait` is called when it waits for input. `ended` promises the run as above.
   */
  async start(words, { files = [], live = null, onOut = null, onWait = () => {}, onProgress = () => {} }) {
    const module = await this.module;
    const worker = new Worker(this.workerUrl);
    const printed = ["", "", ""];
    const take = (fd, text) => {
      if (fd === 2 && text.startsWith(PROGRESS)) onProgress(text.split(PROGRESS).pop().trim());
      else if (fd === 1 && onOut) onOut(text);
      else printed[fd] += text;
    };
    let end;
    const ended = new Promise((resolve) => {
      end = (outcome) => {
        worker.terminate();
        resolve({ code: null, written: [], removed: [], out: printed[1], notes: printed[2], ...outcome });
      };
    });
    worker.onmessage = ({ data }) => {
      if (data.kind === "text") take(data.fd, data.text);
      else if (data.kind === "bytes") onOut(data.bytes);
      else if (data.kind === "waits") onWait();
      else end(data);
    };
    worker.onerror = (event) => {
      event.preventDefault();
      end({ kind: "broken", reason: event.message });
    };
    worker.postMessage({ module, words, files, live });
    return { ended, write: (input) => worker.postMessage({ input }), stop: () => end({ stopped: true }) };
  }

  stop() {
    this.current?.stop();
  }
}

/** Words as a terminal takes them. */
export function commandLine(words) {
  const quoted = (word) => (/^[\w./=:,+%@-]+$/.test(word) ? word : `"${word.replace(/(["\\$`])/g, "\\$1")}"`);
  return ["bearing-watch", ...words].map(quoted).join(" ");
}

/** What to say of a file of the computer that is not there any more. */
export const GONE = "A file cannot be read any more: it was changed, moved or removed. Take it again.";

/** What to say of a run that has failed; empty if it has not. */
export function failure(run) {
  if (run.stopped) return "Stopped. Nothing was changed.";
  if (run.kind === "broken") {
    const isMemory = /memory allocation|out of memory|unreachable.*memory/i.test(`${run.notes} ${run.reason}`);
    const cure = "take fewer or shorter recordings, or the installed program";
    return isMemory || /RangeError/.test(run.reason)
      ? `The memory of the browser is full: ${cure}. Nothing was changed.`
      : `The program has ended early: ${run.notes.trim() || run.reason}. Nothing was changed.`;
  }
  if (run.code < 2) return "";
  const text = run.notes.trim().replace(/^error: /, "");
  return /input\/output error|I\/O error/i.test(text) ? `${text}. ${GONE}` : text;
}
