// Project files: a ZIP archive, stored and not packed, with job.json beside the files that it names, so that an unpacked
// project runs natively. project.json keeps what job.json cannot: the files' own names and what the caller adds.
import { SlicerError } from './errors.js';

const FORMAT = 's3slicer-project';
const LOCAL = 0x04034b50;
const CENTRAL = 0x02014b50;
const END = 0x06054b50;

/**
 * @typedef {{name: string, bytes: Uint8Array}} NamedBytes
 * @typedef {NamedBytes | null} MaybeFile
 * @typedef {{params: any, model: NamedBytes, stress: MaybeFile, loadCase: MaybeFile, criticalRegion: MaybeFile, surfaceRegion: MaybeFile, machine: string | null, extra: unknown}} Project
 */

const encode = (/** @type {unknown} */ json) => new TextEncoder().encode(JSON.stringify(json, null, 2) + '\n');

/**
 * A name for a file in the archive: without folders, and different from those before.
 * @param {string} name
 * @param {Set<string>} taken
 */
function entryName(name, taken) {
  const own = name.split(/[/\\]/).pop() || 'file';
  let entry = own;
  for (let i = 2; taken.has(entry); ++i) entry = `${i}-${own}`;
  taken.add(entry);
  return entry;
}

/** @param {Project} project */
export function packProject({ params, model, stress, loadCase, criticalRegion, surfaceRegion, machine, extra }) {
  const taken = new Set(['job.json', 'project.json']);
  const job = structuredClone(params);
  /** @type {Record<string, {entry: string, name: string}>} */
  const files = {};
  /** @type {NamedBytes[]} */
  const entries = [];
  const add = (/** @type {string} */ role, /** @type {string} */ name, /** @type {Uint8Array} */ bytes) => {
    const entry = entryName(name, taken);
    files[role] = { entry, name };
    entries.push({ name: entry, bytes });
    return entry;
  };
  job.model = add('model', model.name, model.bytes);
  if (stress) job.strength.stress_file = add('stress', stress.name, stress.bytes);
  if (loadCase) job.strength.load_case = add('loadCase', loadCase.name, loadCase.bytes);
  if (criticalRegion) job.strength.critical_region = add('criticalRegion', criticalRegion.name, criticalRegion.bytes);
  if (surfaceRegion) job.objectives.surface_region = add('surfaceRegion', surfaceRegion.name, surfaceRegion.bytes);
  if (machine !== null) job.machine = add('machine', params.machine, new TextEncoder().encode(machine));
  entries.unshift(
    { name: 'job.json', bytes: encode(job) },
    { name: 'project.json', bytes: encode({ format: FORMAT, version: 1, params, files, extra }) },
  );
  return writeZip(entries);
}

/**
 * @param {Uint8Array} bytes
 * @returns {Project}
 */
export function unpackProject(bytes) {
  const entries = readZip(bytes);
  const project = parse(entries.get('project.json'));
  if (project?.format !== FORMAT || project.version !== 1 || typeof project.params !== 'object' || typeof project.files !== 'object')
    throw badFile('is no project of this version');
  const file = (/** @type {string} */ role) => {
    const known = project.files[role];
    if (known === undefined) return null;
    const content = entries.get(known.entry);
    if (content === undefined || typeof known.name !== 'string') throw badFile(`has no file ${known.entry}`);
    return { name: known.name, bytes: content };
  };
  const model = file('model');
  if (model === null) throw badFile('has no model');
  const machine = file('machine');
  return {
    params: project.params,
    model,
    stress: file('stress'),
    loadCase: file('loadCase'),
    criticalRegion: file('criticalRegion'),
    surfaceRegion: file('surfaceRegion'),
    machine: machine && new TextDecoder().decode(machine.bytes),
    extra: project.extra ?? null,
  };
}

/** @param {Uint8Array | undefined} bytes */
function parse(bytes) {
  try {
    return bytes && JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    return undefined;
  }
}

/** @param {string} what */
function badFile(what) {
  return new SlicerError({
    kind: 'input',
    code: 'project.bad_file',
    stage: null,
    message: `The project file ${what}`,
    hint: 'Choose a file that was saved as project',
    places: [],
  });
}

// --- ZIP ---------------------------------------------------------------------------------------------------------------

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let bit = 0; bit < 8; ++bit) n = n & 1 ? (n >>> 1) ^ 0xedb88320 : n >>> 1;
  return n;
});

/** @param {Uint8Array} bytes */
function crc32(bytes) {
  let crc = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) crc = CRC_TABLE[(crc ^ bytes[i]) & 0xff] ^ (crc >>> 8);
  return ~crc >>> 0;
}

const DOS_DATE = (1 << 5) | 1;  // 1 January 1980: equal projects give equal files
const UTF8 = 0x0800;

/** @type {typeof import('./index.d.ts').writeZip} */
export function writeZip(entries) {
  const names = entries.map(({ name }) => new TextEncoder().encode(name));
  const total = entries.reduce((sum, { bytes }, i) => sum + 30 + 46 + 2 * names[i].length + bytes.length, 22);
  const out = new Uint8Array(total);
  const view = new DataView(out.buffer);
  let at = 0;
  const u16 = (/** @type {number} */ value) => (view.setUint16(at, value, true), (at += 2));
  const u32 = (/** @type {number} */ value) => (view.setUint32(at, value, true), (at += 4));
  const raw = (/** @type {Uint8Array} */ bytes) => (out.set(bytes, at), (at += bytes.length));
  // What a local header and an entry of the directory have in common.
  const common = (/** @type {number} */ i, /** @type {number} */ crc) => {
    u16(20), u16(UTF8), u16(0), u16(0), u16(DOS_DATE);
    u32(crc), u32(entries[i].bytes.length), u32(entries[i].bytes.length), u16(names[i].length), u16(0);
  };
  const crcs = entries.map(({ bytes }) => crc32(bytes));
  const offsets = entries.map(({ bytes }, i) => {
    const offset = at;
    u32(LOCAL), common(i, crcs[i]), raw(names[i]), raw(bytes);
    return offset;
  });
  const directory = at;
  entries.forEach((_, i) => {
    u32(CENTRAL), u16(20), common(i, crcs[i]), u16(0), u16(0), u16(0), u32(0), u32(offsets[i]), raw(names[i]);
  });
  const size = at - directory;
  u32(END), u16(0), u16(0), u16(entries.length), u16(entries.length), u32(size), u32(directory), u16(0);
  return out;
}

/**
 * @param {Uint8Array} bytes
 * @returns {Map<string, Uint8Array>}
 */
function readZip(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const inside = (/** @type {number} */ at, /** @type {number} */ size) => {
    if (at + size > bytes.length) throw badFile('is cut off');
    return at;
  };
  // The end of the directory is followed by a comment of at most 64 kB.
  let end = bytes.length - 22;
  while (end >= 0 && end > bytes.length - 22 - 65536 && view.getUint32(end, true) !== END) --end;
  if (end < 0 || view.getUint32(end, true) !== END) throw badFile('is no ZIP archive');
  const count = view.getUint16(end + 10, true);
  /** @type {Map<string, Uint8Array>} */
  const entries = new Map();
  for (let i = 0, at = view.getUint32(end + 16, true); i < count; ++i) {
    if (view.getUint32(inside(at, 46), true) !== CENTRAL) throw badFile('has a damaged directory');
    const [method, crc, size] = [view.getUint16(at + 10, true), view.getUint32(at + 16, true), view.getUint32(at + 20, true)];
    const nameLength = view.getUint16(at + 28, true);
    const local = inside(view.getUint32(at + 42, true), 30);
    const name = new TextDecoder().decode(bytes.subarray(inside(at + 46, nameLength), at + 46 + nameLength));
    if (method !== 0) throw badFile(`has ${name} packed; projects are stored without packing`);
    const start = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true);
    const content = bytes.slice(inside(start, size), start + size);
    if (crc32(content) !== crc) throw badFile(`has damage in ${name}`);
    entries.set(name, content);
    at += 46 + nameLength + view.getUint16(at + 30, true) + view.getUint16(at + 32, true);
  }
  return entries;
}
