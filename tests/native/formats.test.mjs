// Model files of every format through s3slice: as other programs write them, damaged, and hostile.
// Needs the native build: the folder of the programs in S3_BUILD, or build/native.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import path from "node:path";
import { test } from "node:test";
import { deflateRawSync, gzipSync } from "node:zlib";
import { s3slice, testFolder } from "./program.mjs";

const folder = testFolder("formats");

/** `s3slice inspect` with a second of processor time and 200 MB of memory. */
function inspect(name, bytes) {
  writeFileSync(path.join(folder, name), bytes);
  const limited = 'ulimit -t 1 -v 204800 && exec "$@"';
  return spawnSync("bash", ["-c", limited, "bash", s3slice, "inspect", "--json", name], {
    cwd: folder,
    encoding: "utf8",
    timeout: 120000,
  });
}

function inspectWell(name, bytes) {
  const result = inspect(name, bytes);
  assert.equal(result.status, 0, `${name}: ${result.stderr}`);
  return JSON.parse(result.stdout);
}

/** A result, or one line that names the file. */
function assertStands(name, bytes) {
  const result = inspect(name, bytes);
  assert.equal(result.signal, null, `${name} ended by ${result.signal}`);
  assert.ok(result.status === 0 || result.status === 2, `${name}: ${result.status} ${result.stderr}`);
  if (result.status === 0) return;
  const lines = result.stderr.trimEnd().split("\n");
  assert.equal(lines.length, 1, result.stderr);
  assert.ok(lines[0].startsWith("s3slice: "), lines[0]);
}

function assertRefused(name, bytes, part) {
  const result = inspect(name, bytes);
  assert.equal(result.status, 2, `${name}: ${result.signal} ${result.stderr}`);
  assert.ok(result.stderr.includes(name), result.stderr);
  assert.ok(result.stderr.includes(part), `"${part}" is not in: ${result.stderr}`);
}

// --- a box of 3 × 2 × 1 in every format --------------------------------------------------------

const corners = [...Array(8).keys()].map((c) => [3 * (c & 1), 2 * ((c >> 1) & 1), c >> 2]);
const quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
const triangles = quads.flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]]);
// One tet for each way from corner 0 to corner 7 along the axes.
const tets = [[1, 2], [2, 1], [1, 4], [4, 1], [2, 4], [4, 2]].map(([a, b]) => [0, a, a + b, 7]);

/** Binary numbers one after the other; each value is [kind, number]. */
function packed(values, littleEndian = true) {
  const sizes = { u1: 1, i4: 4, u4: 4, u8: 8, f4: 4, f8: 8 };
  const bytes = Buffer.alloc(values.reduce((size, [kind]) => size + sizes[kind], 0));
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  let at = 0;
  for (const [kind, value] of values) {
    if (kind === "u1") view.setUint8(at, value);
    if (kind === "i4") view.setInt32(at, value, littleEndian);
    if (kind === "u4") view.setUint32(at, value, littleEndian);
    if (kind === "u8") view.setBigUint64(at, BigInt(value), littleEndian);
    if (kind === "f4") view.setFloat32(at, value, littleEndian);
    if (kind === "f8") view.setFloat64(at, value, littleEndian);
    at += sizes[kind];
  }
  return bytes;
}
const all = (kind, values) => values.map((value) => [kind, value]);

function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/** A ZIP archive of deflated files, as Node's zlib packs them. */
function zip(files) {
  const u2 = (value) => Buffer.from([value & 255, value >> 8]);
  const u4 = (value) => packed([["u4", value]]);
  let archive = Buffer.alloc(0);
  let directory = Buffer.alloc(0);
  for (const [name, text] of Object.entries(files)) {
    const content = Buffer.from(text);
    const small = deflateRawSync(content, { level: 9 });
    const common = Buffer.concat([u2(20), u2(0), u2(8), u4(0), u4(crc32(content)), u4(small.length),
      u4(content.length), u2(name.length)]);
    directory = Buffer.concat([directory, Buffer.from("PK\x01\x02"), u2(20), common,
      Buffer.alloc(12), u4(archive.length), Buffer.from(name)]);
    archive = Buffer.concat([archive, Buffer.from("PK\x03\x04"), common, u2(0), Buffer.from(name),
      small]);
  }
  const count = u2(Object.keys(files).length);
  return Buffer.concat([archive, directory, Buffer.from("PK\x05\x06"), u4(0), count, count,
    u4(directory.length), u4(archive.length), u2(0)]);
}

const relations =
  '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">' +
  '<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>';

function model3mf(inside, unit = "millimeter") {
  return zip({
    "_rels/.rels": relations,
    "3D/3dmodel.model":
      `<?xml version="1.0" encoding="UTF-8"?>\n<model unit="${unit}" ` +
      `xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">${inside}</model>`,
  });
}

const mesh3mf = `<mesh><vertices>${corners
  .map(([x, y, z]) => `<vertex x="${x}" y="${y}" z="${z}"/>`)
  .join("")}</vertices><triangles>${triangles
  .map(([a, b, c]) => `<triangle v1="${a}" v2="${b}" v3="${c}"/>`)
  .join("")}</triangles></mesh>`;

const lines = (rows) => rows.map((row) => row.join(" ") + "\n").join("");

function ply(vertexCount = 8, faceCount = 6) {
  const header = (format) =>
    Buffer.from(`ply\nformat ${format} 1.0\nelement vertex ${vertexCount}\nproperty float x\n` +
      `property float y\nproperty double z\nelement face ${faceCount}\n` +
      "property list uchar int vertex_indices\nend_header\n");
  const values = [
    ...corners.flatMap(([x, y, z]) => [["f4", x], ["f4", y], ["f8", z]]),
    ...quads.flatMap((quad) => [["u1", 4], ...all("i4", quad)]),
  ];
  return {
    text: Buffer.concat([header("ascii"),
      Buffer.from(lines(corners) + lines(quads.map((q) => [4, ...q])))]),
    little: Buffer.concat([header("binary_little_endian"), packed(values)]),
    big: Buffer.concat([header("binary_big_endian"), packed(values, false)]),
  };
}

function msh(nodeCount = 8) {
  const binary = [
    ...["u8", "u8", "u8", "u8"].map((kind, i) => [kind, [1, nodeCount, 1, 8][i]]),
    ...all("i4", [3, 1, 0]), ["u8", nodeCount],
    ...corners.map((_, i) => ["u8", i + 1]), ...all("f8", corners.flat()),
  ];
  const elements = [...all("u8", [1, 6, 1, 6]), ...all("i4", [3, 1, 4]), ["u8", 6],
    ...tets.flatMap((tet, i) => all("u8", [i + 1, ...tet.map((c) => c + 1)]))];
  return {
    old: Buffer.from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + nodeCount + "\n" +
      lines(corners.map((p, i) => [i + 1, ...p])) + "$EndNodes\n$Elements\n6\n" +
      lines(tets.map((tet, i) => [i + 1, 4, 2, 1, 1, ...tet.map((c) => c + 1)])) +
      "$EndElements\n"),
    binary: Buffer.concat([Buffer.from("$MeshFormat\n4.1 1 8\n"), packed([["i4", 1]]),
      Buffer.from("\n$EndMeshFormat\n$Nodes\n"), packed(binary),
      Buffer.from("\n$EndNodes\n$Elements\n"), packed(elements), Buffer.from("\n$EndElements\n")]),
  };
}

function stl(count = 12) {
  return Buffer.concat([Buffer.alloc(80, " "), packed([["u4", count]]),
    ...triangles.map((t) => Buffer.concat([
      packed(all("f4", [0, 0, 0, ...t.flatMap((c) => corners[c])])), Buffer.alloc(2)]))]);
}

const obj = Buffer.from(lines(corners.map((p) => ["v", ...p])) +
  lines(quads.map((q) => ["f", ...q.map((c) => c + 1)])));

function off(vertexCount = 8, faceCount = 6) {
  return Buffer.from(`OFF\n${vertexCount} ${faceCount} 0\n` + lines(corners) +
    lines(quads.map((q) => [4, ...q])));
}

function tet(vertexCount = 8, tetCount = 6) {
  return Buffer.from(`${vertexCount} vertices\n${tetCount} tets\n` + lines(corners) +
    lines(tets.map((t) => [4, ...t])));
}

function vtu(pointCount = 8) {
  const array = (name, kind, values, components = 1) =>
    `<DataArray type="${kind}" Name="${name}" NumberOfComponents="${components}" format="ascii">` +
    `${values.join(" ")}</DataArray>\n`;
  return Buffer.from('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" ' +
    'byte_order="LittleEndian" header_type="UInt64">\n<UnstructuredGrid>\n' +
    `<Piece NumberOfPoints="${pointCount}" NumberOfCells="6">\n<Points>\n` +
    array("Points", "Float64", corners.flat(), 3) + "</Points>\n<Cells>\n" +
    array("connectivity", "Int64", tets.flat()) +
    array("offsets", "Int64", tets.map((_, i) => 4 * i + 4)) +
    array("types", "UInt8", tets.map(() => 10)) +
    "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

const one3mf = `<resources><object id="1" name="box">${mesh3mf}</object></resources>` +
  '<build><item objectid="1"/></build>';

const files = {
  "box.stl": [stl(), "stl-binary"],
  "box.obj": [obj, "obj"],
  "box.off": [off(), "off"],
  "text.ply": [ply().text, "ply"],
  "little.ply": [ply().little, "ply"],
  "big.ply": [ply().big, "ply"],
  "box.3mf": [model3mf(one3mf), "3mf"],
  "box.obj.gz": [gzipSync(obj), "obj"],
  "box.tet": [tet(), "tet"],
  "text.msh": [msh().old, "msh"],
  "binary.msh": [msh().binary, "msh"],
  "box.vtu": [vtu(), "vtu"],
};

// --- tests ----------------------------------------------------------------------------------------

test("the same box comes out of every format, within 200 MB", () => {
  for (const [name, [bytes, format]] of Object.entries(files)) {
    const report = inspectWell(name, bytes);
    assert.equal(report.format, format, name);
    assert.ok(Math.abs(report.volume_mm3 - 6) < 1e-6, `${name}: ${report.volume_mm3}`);
    assert.deepEqual(report.size_mm, [3, 2, 1], name);
  }
});

test("a 3MF plate of several objects in inches is in mm, with its parts", () => {
  const inside =
    `<resources><object id="1" name="first">${mesh3mf}</object>` +
    `<object id="2" name="second"><components><component objectid="1" ` +
    `transform="0 1 0 -1 0 0 0 0 2 0 0 0"/></components></object></resources>` +
    '<build><item objectid="1"/><item objectid="2" transform="1 0 0 0 1 0 0 0 1 10 0 0"/></build>';
  const report = inspectWell("plate.3mf", model3mf(inside, "inch"));
  assert.deepEqual(report.parts, ["first", "first"]);
  assert.equal(report.shells.length, 2);
  assert.ok(Math.abs(report.volume_mm3 - 18 * 25.4 ** 3) < 1e-6 * report.volume_mm3);
  assert.ok(Math.abs(report.size_mm[0] - 10 * 25.4) < 1e-9 * 254);  // from 0 to 10 inches
  assert.ok(Math.abs(report.size_mm[2] - 2 * 25.4) < 1e-9 * 254);
  assert.ok(report.warnings.some((text) => text.includes("inch") && text.includes("input.scale")));
});

test("files of four billion elements are refused in a second and 200 MB", () => {
  const huge = 4294967295;
  assertRefused("huge.stl", stl(huge), "promises 4294967295 triangles");
  assertRefused("huge.off", off(huge), "too short for 4294967295 vertices");
  assertRefused("faces.off", off(8, huge), "too short for 4294967295 faces");
  for (const [kind, bytes] of Object.entries(ply(huge)))
    assertRefused(`huge_${kind}.ply`, bytes, "too short for 4294967295 rows of 'vertex'");
  for (const [kind, bytes] of Object.entries(ply(8, huge)))
    assertRefused(`faces_${kind}.ply`, bytes, "too short for 4294967295 rows of 'face'");
  assertRefused("huge.tet", tet(huge), "too short for 4294967295 vertices");
  assertRefused("tets.tet", tet(8, huge), "too short for 4294967295 tets");
  assertRefused("huge.msh", msh(huge).old, "too short for 4294967295 nodes");
  assertRefused("binary.msh", msh(huge).binary, "too short for 4294967295 nodes");
  assertRefused("huge.vtu", vtu(huge), "no usable NumberOfPoints");
  assertRefused("index.obj", Buffer.concat([obj, Buffer.from(`f 1 2 ${huge}\n`)]), "4294967295");
  const index = mesh3mf.replace('v1="0"', `v1="${huge}"`);
  assertRefused("index.3mf", model3mf(one3mf.replace(mesh3mf, index)), "v1 = '4294967295'");
});

test("archives that would unpack to far more than a mesh are refused", () => {
  assertRefused("spaces.3mf", model3mf(" ".repeat(100e6)), "which no model does");
  assertRefused("spaces.obj.gz", gzipSync(Buffer.alloc(100e6, " ")), "which no model does");
  let objects = `<object id="1">${mesh3mf}</object>`;
  for (let id = 2; id < 12; ++id)
    objects += `<object id="${id}"><components>${`<component objectid="${id - 1}"/>`.repeat(10)}` +
      "</components></object>";
  assertRefused("components.3mf",
    model3mf(`<resources>${objects}</resources><build><item objectid="11"/></build>`), "too often");
  assertRefused("deep.3mf", model3mf(`<resources>${"<a>".repeat(1e6)}`), "closes what was not opened");
});

test("a file of any format cut short or with a bit turned gives a result or one line", () => {
  let state = 1;
  const random = (bound) => (state = (state * 48271) % 2147483647) % bound;
  for (const [name, [bytes]] of Object.entries(files)) {
    for (let i = 0; i < 6; ++i) assertStands(`cut.${name}`, bytes.subarray(0, random(bytes.length)));
    for (let i = 0; i < 6; ++i) {
      const damaged = Buffer.from(bytes);
      damaged[random(damaged.length)] ^= 1 << random(8);
      assertStands(`turned.${name}`, damaged);
    }
  }
});
