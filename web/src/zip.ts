// ZIP files whose entries are stored, not packed.

const CRC = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});

export function crc32(bytes: Uint8Array): number {
  let c = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) c = CRC[(c ^ bytes[i]!) & 255]! ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

/** One file that holds the given ones, below 4 GB together. */
export function zipStored(files: { name: string; bytes: Uint8Array }[]): Uint8Array<ArrayBuffer> {
  const entries = files.map(({ name, bytes }) => ({ name: new TextEncoder().encode(name), bytes, crc: crc32(bytes) }));
  const size = entries.reduce((sum, { name, bytes }) => sum + 30 + 46 + 2 * name.length + bytes.length, 22);
  const out = new Uint8Array(size), view = new DataView(out.buffer);
  const offsets: number[] = [];
  let at = 0;
  // What local and central headers share, from "version needed" to the length of the extra field.
  const common = ({ name, bytes, crc }: (typeof entries)[number]): void => {
    for (const [offset, value, wide] of [[0, 20, 2], [2, 0x800, 2], [4, 0, 2], [6, 0, 2], [8, 0x21, 2], [10, crc, 4], [14, bytes.length, 4], [18, bytes.length, 4], [22, name.length, 2], [24, 0, 2]] as const) {
      if (wide === 2) view.setUint16(at + offset, value, true);
      else view.setUint32(at + offset, value, true);
    }
    at += 26;
  };
  for (const entry of entries) {
    offsets.push(at);
    view.setUint32(at, 0x04034b50, true);
    at += 4;
    common(entry);
    out.set(entry.name, at);
    out.set(entry.bytes, at + entry.name.length);
    at += entry.name.length + entry.bytes.length;
  }
  const directory = at;
  entries.forEach((entry, i) => {
    view.setUint32(at, 0x02014b50, true);
    view.setUint16(at + 4, 20, true);
    at += 6;
    common(entry);
    view.setUint32(at + 10, offsets[i]!, true);  // after comment length, disk, two kinds of attributes
    at += 14;
    out.set(entry.name, at);
    at += entry.name.length;
  });
  view.setUint32(at, 0x06054b50, true);
  view.setUint16(at + 8, entries.length, true);
  view.setUint16(at + 10, entries.length, true);
  view.setUint32(at + 12, at - directory, true);
  view.setUint32(at + 16, directory, true);
  return out;
}
