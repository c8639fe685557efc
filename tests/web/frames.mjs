// Frame times of the page in headless Chromium, which draws in software: ./dev bench web. One JSON object a line.
// script_ms is what the page itself takes of a frame, frame_ms ends when all is drawn.
//   node tests/web/frames.mjs [--model models/teapot.stl] [--waypoints 250000] [--steps 300] [--seconds 120]
import { readFileSync } from 'node:fs';
import { basename } from 'node:path';
import { parseArgs } from 'node:util';
import { drop, open, prepared, root, shut, sliced } from './page.mjs';

const { values } = parseArgs({ options: {
  model: { type: 'string', default: `${root}models/teapot.stl` }, waypoints: { type: 'string', default: '250000' }, steps: { type: 'string', default: '300' },
  seconds: { type: 'string', default: '120' },  // at most, for a view: a software renderer may need minutes
} });
const wanted = Number(values.waypoints), steps = Number(values.steps), seconds = Number(values.seconds);
const print = (line) => console.log(JSON.stringify(line));

const { page, close } = await open();
await drop(page, basename(values.model), readFileSync(values.model));
await prepared(page);
await page.evaluate(() => window.s3.app.setParams({ 'mesh.target_tets': 12000, 'nozzle.diameter': 1 }));
await page.click('#slice');
await sliced(page, 900000);
const first = await page.evaluate(async () => (await window.s3.app.result('waypoints', 'curved')).count);
if (first < wanted) {
  // The same paths with more points on them.
  const spacing = await page.evaluate(() => Number(window.s3.app.fields.find((field) => field.key === 'toolpath.spacing').default));
  await page.evaluate((value) => window.s3.app.setParams({ 'toolpath.spacing': value }), Math.max(0.05, (0.9 * spacing * first) / wanted));
  await page.waitForFunction(() => window.s3.app.stages.find((one) => one.stage === 'waypoints').state === 'stale');
  await page.click('#slice');
  await sliced(page, 900000);
}
const count = await page.evaluate(async () => (await window.s3.app.result('waypoints', 'curved')).count);
const renderer = await page.evaluate(() => {
  const gl = window.s3.workspace.viewer.canvas.getContext('webgl2');
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  return info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : gl.getParameter(gl.RENDERER);
});
print({ model: basename(values.model), waypoints: count, renderer, viewport: page.viewportSize() });

const quantile = (times, share) => Math.round(100 * [...times].sort((a, b) => a - b)[Math.floor(share * (times.length - 1))]) / 100;
for (const view of ['Part', 'Mesh', 'Shape', 'Field', 'Layers', 'Toolpaths']) {
  await page.getByRole('radio', { name: view, exact: true }).click();
  await page.waitForFunction((name) => document.querySelector('#views [aria-checked=true]')?.textContent === name && !window.s3.workspace.loading, view);
  const scrubbed = view === 'Layers' || view === 'Toolpaths';
  // Layers are scrubbed to places that any number of steps spreads evenly; elsewhere the part is turned.
  const measured = await page.evaluate(({ steps, seconds, scrubbed }) => {
    const { viewer } = window.s3.workspace;
    const gl = viewer.canvas.getContext('webgl2'), pixel = new Uint8Array(4);
    const slider = document.querySelector('[aria-label="Last piece shown"]');
    const script = [], whole = [];
    let most = 0;
    const end = performance.now() + 1000 * seconds;
    for (let step = 0; step < steps && performance.now() < end; ++step) {
      const begin = performance.now();
      if (scrubbed) {
        slider.value = String(1 + Math.floor(Number(slider.max) * ((0.6180339887 * step) % 1)));
        slider.dispatchEvent(new Event('input'));
      } else {
        viewer.scene.rotateZ(0.01);
      }
      viewer.draw();
      script.push(performance.now() - begin);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);  // waits until all is drawn
      whole.push(performance.now() - begin);
      most = Math.max(most, viewer.figures.drawCalls);
    }
    if (!scrubbed) viewer.scene.rotation.set(0, 0, 0);
    return { script, whole, most, triangles: viewer.figures.triangles };
  }, { steps, seconds, scrubbed });
  print({
    view: view.toLowerCase(), steps: measured.whole.length, scrubbed, draw_calls: measured.most, triangles: measured.triangles,
    frame_ms: { median: quantile(measured.whole, 0.5), p95: quantile(measured.whole, 0.95) },
    script_ms: { median: quantile(measured.script, 0.5), p95: quantile(measured.script, 0.95) },
  });
}
await close();
await shut();
