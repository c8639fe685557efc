// The native program for the tests of this folder, each with a folder of its own to run it in.
// Needs the native build: the folder of the programs in S3_BUILD, or build/native.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { after } from "node:test";
import { fileURLToPath } from "node:url";

export const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
export const s3slice = path.join(process.env.S3_BUILD ?? path.join(root, "build/native"), "s3slice");
assert.ok(existsSync(s3slice), `${s3slice} is missing: build the native programs first`);

/** An empty folder that is gone after the tests of the file that asks for it. */
export function testFolder(name) {
  const folder = mkdtempSync(path.join(tmpdir(), `s3slice-${name}-`));
  after(() => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

/** s3slice in a folder: `run` with any end, `runWell` with a good one. */
export function runnerIn(folder) {
  const run = (...args) => {
    const result = spawnSync(s3slice, args, { cwd: folder, encoding: "utf8", timeout: 300000 });
    assert.equal(result.error, undefined);
    return result;
  };
  const runWell = (...args) => {
    const result = run(...args);
    assert.equal(result.status, 0, result.stderr);
    return result;
  };
  return { run, runWell };
}

/** One line that begins with the program's name, and the exit code of wrong input. */
export function assertInputError(result, ...parts) {
  assert.equal(result.status, 2, result.stderr);
  const lines = result.stderr.trimEnd().split("\n");
  assert.equal(lines.length, 1, result.stderr);
  assert.match(lines[0], /^s3slice: /);
  for (const part of parts) assert.ok(lines[0].includes(part), `"${part}" is not in: ${lines[0]}`);
}
