// A tree of files in memory, of which the program sees nothing else.
//
// A file has its bytes, or a function that reads a part of them from where they are: a recording of gigabytes is not
// copied to be listed.

export class Folder {
  constructor() {
    this.entries = new Map();
    this.time = BigInt(Date.now()) * 1000000n;
  }
}

/** Bytes that are read or written. */
export class Content {
  /** `read(from, to)` returns bytes of a source; without it the file is empty. */
  constructor(size = 0, read = null, time = Date.now()) {
    this.size = size;
    this.read = read;
    this.time = BigInt(Math.round(time)) * 1000000n;
    this.bytes = read ? null : new Uint8Array(0);
    this.block = null;
    this.isChanged = !read;
  }

  static of(bytes) {
    const content = new Content();
    content.bytes = bytes;
    content.size = bytes.length;
    content.isChanged = false;
    return content;
  }

  /** The bytes from a place on, at most `length` of them; of a source through a block that is kept. */
  part(from, length) {
    const to = Math.min(this.size, from + length);
    if (from >= to) return new Uint8Array(0);
    if (this.bytes) return this.bytes.subarray(from, to);
    if (!this.block || from < this.block.from || to > this.block.from + this.block.bytes.length) {
      const end = Math.min(this.size, Math.max(to, from + Content.BLOCK));
      const bytes = this.read(from, end);
      if (bytes.length !== end - from) throw new Error("the file has changed");
      this.block = { from, bytes };
    }
    return this.block.bytes.subarray(from - this.block.from, to - this.block.from);
  }

  /** Takes the bytes of a source into memory, to be changed. */
  own() {
    if (this.bytes) return;
    this.bytes = this.read(0, this.size).slice();
    this.read = this.block = null;
  }

  write(at, bytes) {
    this.own();
    const end = at + bytes.length;
    this.reserve(end);
    this.bytes.set(bytes, at);
    this.size = Math.max(this.size, end);
    this.touch();
  }

  resize(size) {
    this.own();
    this.reserve(size);
    this.bytes.fill(0, Math.min(size, this.size));
    this.size = size;
    this.touch();
  }

  reserve(size) {
    if (size <= this.bytes.length) return;
    const larger = new Uint8Array(Math.max(size, 2 * this.bytes.length, 4096));
    larger.set(this.bytes.subarray(0, this.size));
    this.bytes = larger;
  }

  touch() {
    this.isChanged = true;
    this.time = BigInt(Date.now()) * 1000000n;
  }

  /** All bytes. */
  all() {
    return this.bytes ? this.bytes.slice(0, this.size) : this.read(0, this.size);
  }
}

/** Bytes that are read from a source at once. */
Content.BLOCK = 1 << 22;

/** A tree of the files of a list of paths and contents. */
export function tree(files) {
  const root = new Folder();
  for (const [path, content] of files) {
    const names = path.split("/").filter(Boolean);
    const last = names.pop();
    let folder = root;
    for (const name of names) {
      if (!folder.entries.has(name)) folder.entries.set(name, new Folder());
      folder = folder.entries.get(name);
    }
    folder.entries.set(last, content);
  }
  return root;
}

/** All files of a tree: paths and contents. */
export function* walk(folder, prefix = "") {
  for (const [name, entry] of folder.entries) {
    if (entry instanceof Folder) yield* walk(entry, `${prefix}${name}/`);
    else yield [prefix + name, entry];
  }
}
