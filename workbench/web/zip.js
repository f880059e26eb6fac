// A session as one file: an archive in the format ZIP, which every computer opens.

const TABLE = Uint32Array.from({ length: 256 }, (_, k) => {
  let sum = k;
  for (let bit = 0; bit < 8; bit++) sum = sum & 1 ? 0xedb88320 ^ (sum >>> 1) : sum >>> 1;
  return sum;
});

function crc32(bytes) {
  let sum = ~0;
  for (const byte of bytes) sum = TABLE[(sum ^ byte) & 255] ^ (sum >>> 8);
  return ~sum >>> 0;
}

const through = (bytes, stream) => new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer();

/** Fields of little endian: pairs of a size and a value. */
function fields(...all) {
  const bytes = new Uint8Array(all.reduce((sum, [size]) => sum + size, 0)), view = new DataView(bytes.buffer);
  let at = 0;
  for (const [size, value] of all) {
    if (size === 2) view.setUint16(at, value, true);
    else view.setUint32(at, value, true);
    at += size;
  }
  return bytes;
}

const LOCAL = 0x04034b50, CENTRAL = 0x02014b50, END = 0x06054b50, DEFLATE = 8, UTF8 = 0x800, DATE = 0x21;

/** Packs a list of paths and blobs; `onFile(count)` says how many are done. */
export async function pack(files, onFile = () => {}) {
  const parts = [], central = [];
  let at = 0;
  for (const [path, blob] of files) {
    const name = new TextEncoder().encode(path), bytes = new Uint8Array(await blob.arrayBuffer());
    const packed = new Uint8Array(await through(bytes, new CompressionStream("deflate-raw")));
    const about = [[2, 20], [2, UTF8], [2, DEFLATE], [2, 0], [2, DATE], [4, crc32(bytes)]];
    about.push([4, packed.length], [4, bytes.length], [2, name.length], [2, 0]);
    parts.push(fields([4, LOCAL], ...about), name, new Blob([packed]));
    central.push(fields([4, CENTRAL], [2, 20], ...about, [2, 0], [2, 0], [2, 0], [4, 0], [4, at]), name);
    at += 30 + name.length + packed.length;
    onFile(central.length / 2);
  }
  const size = central.reduce((sum, part) => sum + part.length, 0);
  const count = Math.min(files.length, 0xffff);
  parts.push(...central, fields([4, END], [2, 0], [2, 0], [2, count], [2, count], [4, size], [4, at], [2, 0]));
  return new Blob(parts, { type: "application/zip" });
}

/** Unpacks an archive into a list of paths and blobs. */
export async function unpack(blob) {
  const bytes = new Uint8Array(await blob.arrayBuffer()), view = new DataView(bytes.buffer);
  let end = bytes.length - 22;
  while (end >= 0 && view.getUint32(end, true) !== END) end--;
  if (end < 0) throw new Error("this is no archive of a session");
  const files = [];
  for (let at = view.getUint32(end + 16, true); at < end && view.getUint32(at, true) === CENTRAL;) {
    const method = view.getUint16(at + 10, true);
    const [sum, size] = [16, 20].map((place) => view.getUint32(at + place, true));
    const [name, extra, comment] = [28, 30, 32].map((place) => view.getUint16(at + place, true));
    const path = new TextDecoder().decode(bytes.subarray(at + 46, at + 46 + name));
    const local = view.getUint32(at + 42, true);
    const start = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true);
    const own = bytes.subarray(start, start + size);
    at += 46 + name + extra + comment;
    if (path.endsWith("/")) continue;
    const whole = method === DEFLATE ? new Uint8Array(await through(own, new DecompressionStream("deflate-raw"))) : own;
    if (crc32(whole) !== sum) throw new Error(`the archive is damaged at ${path}`);
    files.push([path, new Blob([whole])]);
  }
  return files;
}
