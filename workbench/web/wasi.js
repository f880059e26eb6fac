// The part of WASI (`wasi_snapshot_preview1`) that the program calls: arguments, clocks, random numbers, and files of a
// tree in memory. There is no network, no other process and no link.

import { Content, Folder } from "./files.js";

const OK = 0, BADF = 8, EXIST = 20, INVAL = 28, IO = 29, ISDIR = 31, NOENT = 44, NOSPC = 51, NOSYS = 52, NOTDIR = 54;
const NOTEMPTY = 55;
/** Kinds of files. */
const UNKNOWN = 0, FOLDER = 3, REGULAR = 4;
/** The folder that the program has from the start: `/`, which is its current one too. */
const ROOT = 3;
/** Flags of an opening. */
const CREATE = 1, DIRECTORY = 2, EXCLUSIVE = 4, TRUNCATE = 8, APPEND = 1;
const ALL_RIGHTS = 0xffffffffffffffffn;

/** Ends the program. */
export class Exit extends Error {
  constructor(code) {
    super(`exit ${code}`);
    this.code = code;
  }
}

/** The error number of what a browser throws: a file that changed or is gone, or no memory. */
function number(error) {
  if (error instanceof Exit) throw error;
  return error instanceof RangeError ? NOSPC : IO;
}

/**
 * The imports of a program with these words over the files below `root`; `print(fd, bytes)` takes what it prints, and
 * `read(length)` promises the next bytes of its standard input, none at the end; without it there is no input.
 * Set `memory` before the start.
 */
export class Wasi {
  constructor(words, root, print, read = null) {
    this.words = words;
    this.print = print;
    this.read = read;
    this.memory = null;
    this.root = root;
    this.open = new Map([[ROOT, { node: root }]]);
    for (const fd of [0, 1, 2]) this.open.set(fd, { stream: fd });
    this.next = ROOT + 1;
    this.numbers = new Map();
  }

  get view() {
    return new DataView(this.memory.buffer);
  }

  bytes(at, length) {
    return new Uint8Array(this.memory.buffer, at, length);
  }

  text(at, length) {
    return new TextDecoder().decode(this.bytes(at, length));
  }

  u32(at, value) {
    this.view.setUint32(at, value, true);
    return OK;
  }

  u64(at, value) {
    this.view.setBigUint64(at, BigInt(value), true);
    return OK;
  }

  /** The buffers of a list. */
  * buffers(list, count) {
    for (let k = 0; k < count; k++) {
      const view = this.view;
      yield [view.getUint32(list + 8 * k, true), view.getUint32(list + 8 * k + 4, true)];
    }
  }

  /** What a path means from an open folder: the folder above, the name, and what it names, if anything. */
  find(fd, at, length) {
    const start = this.open.get(fd)?.node;
    if (!(start instanceof Folder)) return { error: start ? NOTDIR : BADF };
    const above = [];
    let node = start, name = ".";
    for (const part of this.text(at, length).split("/")) {
      if (part === "" || part === ".") continue;
      if (part === "..") {
        if (above.length) ({ node, name } = above.pop());
        continue;
      }
      if (!(node instanceof Folder)) return { error: node ? NOTDIR : NOENT };
      above.push({ node, name });
      name = part;
      node = node.entries.get(part);
    }
    return { folder: above.at(-1)?.node ?? start, name, node };
  }

  /** A number of a file, by which the program tells whether two paths are one file. */
  ino(node) {
    if (!this.numbers.has(node)) this.numbers.set(node, this.numbers.size + 1);
    return this.numbers.get(node);
  }

  stat(at, node) {
    const isFolder = node instanceof Folder, view = this.view;
    this.bytes(at, 64).fill(0);
    view.setBigUint64(at + 8, BigInt(node ? this.ino(node) : 0), true);
    view.setUint8(at + 16, !node ? UNKNOWN : isFolder ? FOLDER : REGULAR);
    view.setBigUint64(at + 24, 1n, true);
    view.setBigUint64(at + 32, BigInt(node && !isFolder ? node.size : 0), true);
    for (const place of [40, 48, 56]) view.setBigUint64(at + place, node?.time ?? 0n, true);
    return OK;
  }

  /** Copies a list of texts that end with a zero. */
  list(pointers, at, texts) {
    for (const text of texts) {
      const bytes = new TextEncoder().encode(`${text}\0`);
      this.u32(pointers, at);
      this.bytes(at, bytes.length).set(bytes);
      pointers += 4;
      at += bytes.length;
    }
    return OK;
  }

  sizes(count, size, texts) {
    this.u32(count, texts.length);
    return this.u32(size, texts.reduce((sum, text) => sum + new TextEncoder().encode(text).length + 1, 0));
  }

  /** Reads into buffers from a place of a file, or from where it stands. */
  input(fd, list, count, read, place = null) {
    const file = this.open.get(fd);
    if (!file) return BADF;
    if (file.stream !== undefined) return this.u32(read, 0);
    if (file.node instanceof Folder) return ISDIR;
    let at = place ?? file.at, total = 0;
    for (const [to, length] of this.buffers(list, count)) {
      const part = file.node.part(at, length);
      this.bytes(to, part.length).set(part);
      at += part.length;
      total += part.length;
      if (part.length < length) break;
    }
    if (place === null) file.at = at;
    return this.u32(read, total);
  }

  /** The same of standard input, for whose bytes the program waits. */
  async waited(list, count, read) {
    const [[to, length]] = [...this.buffers(list, Math.min(count, 1))];
    const part = await this.read(length);
    this.bytes(to, part.length).set(part);
    return this.u32(read, part.length);
  }

  output(fd, list, count, written, place = null) {
    const file = this.open.get(fd);
    if (!file) return BADF;
    let total = 0;
    for (const [from, length] of this.buffers(list, count)) {
      if (file.stream !== undefined) {
        this.print(file.stream, this.bytes(from, length).slice());
      } else {
        if (file.flags & APPEND) file.at = file.node.size;
        file.node.write((place ?? file.at) + (place === null ? 0 : total), this.bytes(from, length));
        if (place === null) file.at += length;
      }
      total += length;
    }
    return this.u32(written, total);
  }

  opened(fd, at, length, flags, fdFlags, result) {
    const { error, folder, name, node } = this.find(fd, at, length);
    if (error) return error;
    let own = node;
    if (own && flags & CREATE && flags & EXCLUSIVE) return EXIST;
    if (own && flags & DIRECTORY && !(own instanceof Folder)) return NOTDIR;
    if (!own) {
      if (!(flags & CREATE)) return NOENT;
      own = new Content();
      folder.entries.set(name, own);
    }
    if (flags & TRUNCATE && own instanceof Content) own.resize(0);
    this.open.set(this.next, { node: own, at: 0, flags: fdFlags });
    return this.u32(result, this.next++);
  }

  renamed(fd, at, length, toFd, toAt, toLength) {
    const from = this.find(fd, at, length), to = this.find(toFd, toAt, toLength);
    if (from.error || to.error) return from.error || to.error;
    if (!from.node) return NOENT;
    if (to.node instanceof Folder && !(from.node instanceof Folder)) return ISDIR;
    from.folder.entries.delete(from.name);
    to.folder.entries.set(to.name, from.node);
    if (from.node instanceof Content) from.node.isChanged = true;
    return OK;
  }

  removed(fd, at, length, isFolder) {
    const { error, folder, name, node } = this.find(fd, at, length);
    if (error) return error;
    if (!node) return NOENT;
    if (isFolder !== node instanceof Folder) return isFolder ? NOTDIR : ISDIR;
    if (isFolder && node.entries.size) return NOTEMPTY;
    folder.entries.delete(name);
    return OK;
  }

  made(fd, at, length) {
    const { error, folder, name, node } = this.find(fd, at, length);
    if (error) return error;
    if (node) return EXIST;
    folder.entries.set(name, new Folder());
    return OK;
  }

  listed(fd, at, length, cookie, used) {
    const node = this.open.get(fd)?.node;
    if (!(node instanceof Folder)) return NOTDIR;
    const entries = [...node.entries];
    let end = 0;
    for (let k = Number(cookie); k < entries.length && end < length; k++) {
      const [name, entry] = entries[k], bytes = new TextEncoder().encode(name);
      const one = new Uint8Array(24 + bytes.length), view = new DataView(one.buffer);
      view.setBigUint64(0, BigInt(k + 1), true);
      view.setBigUint64(8, BigInt(this.ino(entry)), true);
      view.setUint32(16, bytes.length, true);
      view.setUint8(20, entry instanceof Folder ? FOLDER : REGULAR);
      one.set(bytes, 24);
      const part = one.subarray(0, length - end);
      this.bytes(at + end, part.length).set(part);
      end += part.length;
    }
    return this.u32(used, end);
  }

  seek(fd, offset, whence, result) {
    const file = this.open.get(fd);
    if (!(file?.node instanceof Content)) return file ? INVAL : BADF;
    const at = [0, file.at, file.node.size][whence] + Number(offset);
    if (at < 0) return INVAL;
    file.at = at;
    return this.u64(result, at);
  }

  describe(fd, at) {
    const file = this.open.get(fd);
    if (!file) return BADF;
    const kind = file.stream !== undefined ? UNKNOWN : file.node instanceof Folder ? FOLDER : REGULAR;
    this.bytes(at, 24).fill(0);
    this.view.setUint8(at, kind);
    this.view.setUint16(at + 2, file.flags ?? 0, true);
    this.u64(at + 8, ALL_RIGHTS);
    return this.u64(at + 16, ALL_RIGHTS);
  }

  time(clock, result) {
    const since = clock === 0 ? Date.now() * 1e6 : performance.now() * 1e6;
    return this.u64(result, Math.round(since));
  }

  random(at, length) {
    // A call takes at most so many bytes.
    for (let k = 0; k < length; k += 65536) crypto.getRandomValues(this.bytes(at + k, Math.min(65536, length - k)));
    return OK;
  }

  resized(fd, size) {
    this.open.get(fd).node.resize(Number(size));
    return OK;
  }

  pathStat(fd, at, length, result) {
    const { error, node } = this.find(fd, at, length);
    return error ?? (node ? this.stat(result, node) : NOENT);
  }

  isLink(fd, at, length) {
    const { error, node } = this.find(fd, at, length);
    return error ?? (node ? INVAL : NOENT);
  }

  /** The functions that the program imports; of those without an entry it is told that there are none. */
  imports() {
    const known = {
      args_get: (list, at) => this.list(list, at, this.words),
      args_sizes_get: (count, size) => this.sizes(count, size, this.words),
      environ_get: () => OK,
      environ_sizes_get: (count, size) => this.sizes(count, size, []),
      clock_res_get: (_clock, at) => this.u64(at, 1000),
      clock_time_get: (clock, _precision, at) => this.time(clock, at),
      random_get: (at, length) => this.random(at, length),
      proc_exit: (code) => { throw new Exit(code); },
      sched_yield: () => OK,
      fd_close: (fd) => (this.open.delete(fd) ? OK : BADF),
      fd_read: (fd, list, count, read) => this.input(fd, list, count, read),
      fd_pread: (fd, list, count, at, read) => this.input(fd, list, count, read, Number(at)),
      fd_write: (fd, list, count, written) => this.output(fd, list, count, written),
      fd_pwrite: (fd, list, count, at, written) => this.output(fd, list, count, written, Number(at)),
      fd_seek: (fd, offset, whence, at) => this.seek(fd, offset, whence, at),
      fd_tell: (fd, at) => this.seek(fd, 0n, 1, at),
      fd_sync: () => OK,
      fd_datasync: () => OK,
      fd_advise: () => OK,
      fd_fdstat_get: (fd, at) => this.describe(fd, at),
      fd_fdstat_set_flags: (fd, flags) => { this.open.get(fd).flags = flags; return OK; },
      fd_filestat_get: (fd, at) => (this.open.has(fd) ? this.stat(at, this.open.get(fd).node) : BADF),
      fd_filestat_set_size: (fd, size) => this.resized(fd, size),
      fd_filestat_set_times: () => OK,
      fd_prestat_get: (fd, at) => (fd === ROOT ? this.u32(at, 0) || this.u32(at + 4, 1) : BADF),
      fd_prestat_dir_name: (_fd, at) => { this.bytes(at, 1)[0] = "/".charCodeAt(0); return OK; },
      fd_readdir: (fd, at, length, cookie, used) => this.listed(fd, at, length, cookie, used),
      path_open: (fd, _follow, at, length, flags, _rights, _inherited, fdFlags, result) =>
        this.opened(fd, at, length, flags, fdFlags, result),
      path_filestat_get: (fd, _follow, at, length, result) => this.pathStat(fd, at, length, result),
      path_filestat_set_times: () => OK,
      path_create_directory: (fd, at, length) => this.made(fd, at, length),
      path_remove_directory: (fd, at, length) => this.removed(fd, at, length, true),
      path_unlink_file: (fd, at, length) => this.removed(fd, at, length, false),
      path_rename: (fd, at, length, toFd, toAt, toLength) => this.renamed(fd, at, length, toFd, toAt, toLength),
      path_readlink: (fd, at, length) => this.isLink(fd, at, length),
    };
    const guarded = (call) => (...values) => {
      try {
        return call(...values);
      } catch (error) {
        return number(error);
      }
    };
    const all = Object.fromEntries(Object.entries(known).map(([name, call]) => [name, guarded(call)]));
    if (this.read) {
      const { fd_read: now } = all;
      all.fd_read = new WebAssembly.Suspending((fd, list, count, read) =>
        (fd === 0 && count > 0 ? this.waited(list, count, read) : now(fd, list, count, read)));
    }
    return new Proxy(all, { get: (own, name) => own[name] ?? (() => NOSYS) });
  }
}

function instance(module, wasi) {
  const { exports } = new WebAssembly.Instance(module, { wasi_snapshot_preview1: wasi.imports() });
  wasi.memory = exports.memory;
  return exports;
}

function code(error) {
  if (error instanceof Exit) return error.code;
  throw error;
}

/** Runs the program to its end; returns its exit code. A trap is thrown. */
export function run(module, words, root, print) {
  const wasi = new Wasi(["bearing-watch", ...words], root, print);
  try {
    instance(module, wasi)._start();
    return 0;
  } catch (error) {
    return code(error);
  }
}

/** The same of a program that reads its standard input by `read(length)`; promises its exit code. */
export async function runWaiting(module, words, root, print, read) {
  const wasi = new Wasi(["bearing-watch", ...words], root, print, read);
  try {
    await WebAssembly.promising(instance(module, wasi)._start)();
    return 0;
  } catch (error) {
    return code(error);
  }
}
