// The rule of dependencies as a test: a folder of core includes itself and earlier folders only.
//   node tests/check_includes.mjs    prints the offending lines
//   node --test tests/               runs it with the other tests, and checks that it finds violations
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { dirname, join, relative } from 'node:path';
import { fileURLToPath } from 'node:url';
import test from 'node:test';
import assert from 'node:assert/strict';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');

/** The folders of core in the order of the pipeline. */
const ORDER = [
  'base', 'params', 'math', 'mesh', 'tetrahedralize', 'fea', 'objectives', 'quaternion_field', 'deformation',
  'scalar_field', 'outer_loop', 'layers', 'toolpaths', 'waypoints', 'motion', 'export', 'metrics', 'pipeline',
];
/** Of `params`, the folders between `params` and `pipeline` may see this header only. */
const PARAM_INFO = 'params/param_info.h';
/** Headers that one place alone may include. */
const ONLY_IN = [
  { header: /^tetgen\.h$/, place: /^core\/tetrahedralize\/tetgen_backend\.cpp$/ },
  { header: /^emscripten(\/|\.h$)/, place: /^wasm\/bindings\.cpp$/ },
  { header: /^(imgui|GLFW\/|GL\/|glad\/)/, place: /^native\/viewer\// },
];

/**
 * @param {string} path  of the file, relative to the root, with slashes
 * @param {string} text
 * @returns {string[]} one "path:line: what is wrong" for each bad include
 */
export function badIncludes(path, text) {
  const problems = [];
  const folder = /^core\/([^/]+)\//.exec(path)?.[1];
  if (folder !== undefined && !ORDER.includes(folder)) problems.push(`${path}:1: folder ${folder} is not in the order of the pipeline`);
  text.split('\n').forEach((line, index) => {
    const match = /^\s*#\s*include\s*[<"]([^>"]+)[>"]/.exec(line);
    if (!match) return;
    const header = match[1];
    const complain = (reason) => problems.push(`${path}:${index + 1}: ${line.trim()}: ${reason}`);
    for (const { header: pattern, place } of ONLY_IN)
      if (pattern.test(header) && !place.test(path)) complain(`only ${place.source.replace(/[\\^$]/g, '')} may include it`);
    if (folder === undefined) return;
    if (header.startsWith('.')) complain('name the folder instead of a relative path');
    const target = header.split('/')[0];
    if (!header.includes('/') || !ORDER.includes(target)) return;
    const from = ORDER.indexOf(folder);
    const to = ORDER.indexOf(target);
    if (to > from) complain(`${target} comes after ${folder}`);
    const isStage = from > ORDER.indexOf('params') && folder !== 'pipeline';
    if (isStage && target === 'params' && header !== PARAM_INFO) complain(`stages include only ${PARAM_INFO} of params`);
  });
  return problems;
}

/** @returns {Generator<string>} */
function* sourceFiles(folder) {
  for (const name of readdirSync(folder).sort()) {
    const path = join(folder, name);
    if (statSync(path).isDirectory()) yield* sourceFiles(path);
    else if (/\.(h|hpp|cpp)$/.test(name)) yield path;
  }
}

export function checkTree() {
  const problems = [];
  for (const folder of ['core', 'native', 'wasm', 'tests']) {
    const path = join(root, folder);
    if (!statSync(path, { throwIfNoEntry: false })) continue;
    for (const file of sourceFiles(path))
      problems.push(...badIncludes(relative(root, file).replaceAll('\\', '/'), readFileSync(file, 'utf8')));
  }
  return problems;
}

if (process.env.NODE_TEST_CONTEXT) {
  test('every include of the tree follows the order of the pipeline', () => assert.deepEqual(checkTree(), []));

  test('an include of a later stage is found, with its line', () => {
    const problems = badIncludes('core/layers/a.cpp', '#include "layers/a.h"\n\n#include "metrics/metrics.h"\n');
    assert.equal(problems.length, 1);
    assert.match(problems[0], /^core\/layers\/a\.cpp:3: .*metrics comes after layers/);
  });

  test('earlier stages, own folder and libraries may be included', () => {
    const text = '#include "mesh/tet_mesh.h"\n#include "layers/b.h"\n#include <vector>\n#include <Eigen/Core>\n#include "params/param_info.h"\n';
    assert.deepEqual(badIncludes('core/layers/a.h', text), []);
  });

  test('stages see one header of params, the pipeline all of them', () => {
    const line = '#include "params/param_visitors.h"\n';
    assert.equal(badIncludes('core/mesh/a.cpp', line).length, 1);
    assert.equal(badIncludes('core/pipeline/a.cpp', line).length, 0);
  });

  test('TetGen, Emscripten and the viewer\'s libraries stay in their places', () => {
    assert.equal(badIncludes('core/mesh/a.cpp', '#include <tetgen.h>').length, 1);
    assert.equal(badIncludes('core/tetrahedralize/tetgen_backend.cpp', '#include <tetgen.h>').length, 0);
    assert.equal(badIncludes('core/base/a.cpp', '#include <emscripten/bind.h>').length, 1);
    assert.equal(badIncludes('native/cli/main.cpp', '#include <GLFW/glfw3.h>').length, 1);
  });

  test('a folder outside the order is refused', () => {
    assert.equal(badIncludes('core/misc/a.cpp', '').length, 1);
  });
} else if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const problems = checkTree();
  for (const problem of problems) console.error(problem);
  console.log(problems.length ? `${problems.length} includes against the order` : 'includes: ok');
  process.exit(problems.length ? 1 : 0);
}
