// The built page in headless Chromium, for the browser tests.
import { existsSync, mkdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';
import { serve } from '../../web/serve.mjs';

const require = createRequire(new URL('../../web/package.json', import.meta.url));
const ARGS = [
  '--headless', '--no-sandbox', '--disable-gpu', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--disable-quic',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
];

export const root = fileURLToPath(new URL('../../', import.meta.url));
/** Pictures of the run are kept here. */
export const pictures = `${root}build/web-pictures/`;
mkdirSync(pictures, { recursive: true });

let browser;
export async function launch() {
  if (!existsSync(`${root}web/dist/index.html`)) throw new Error('There is no web/dist: ./dev build web');
  browser ??= await require('playwright-core').chromium.launch({ executablePath: '/usr/bin/chromium', args: ARGS });
  return browser;
}
export async function shut() {
  await browser?.close();
  browser = undefined;
}

/** What Chromium says of its own software rendering, and Playwright of service workers that a test does without. */
const HARMLESS = /GPU stall due to ReadPixels|Service Worker registration blocked/;

/**
 * A page of its own, on a server of its own.
 * @param {{ isolation?: boolean, width?: number, height?: number, theme?: 'light' | 'dark', query?: string, serviceWorkers?: 'allow' | 'block' }} options
 */
export async function open({ isolation = true, width = 1280, height = 800, theme = 'light', query = '', serviceWorkers = 'block' } = {}) {
  const server = await serve({ root: `${root}web/dist`, isolation });
  const context = await (await launch()).newContext({ viewport: { width, height }, colorScheme: theme, serviceWorkers, acceptDownloads: true });
  const page = await context.newPage();
  /** What the console and uncaught errors said. */
  const complaints = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !HARMLESS.test(message.text())) complaints.push(message.text());
  });
  page.on('pageerror', (error) => complaints.push(error.stack ?? String(error)));
  // What moves without a person's doing: the sum of Chromium's layout shifts.
  await page.addInitScript(() => {
    window.layoutShift = 0;
    new PerformanceObserver((list) => {
      for (const entry of list.getEntries()) if (!entry.hadRecentInput) window.layoutShift += entry.value;
    }).observe({ type: 'layout-shift', buffered: true });
  });
  await page.goto(server.url + query);
  await page.waitForFunction(() => window.s3?.app.engine, null, { timeout: 30000 });
  return { page, context, server, complaints, close: async () => { await context.close(); await server.close(); } };
}

/** Gives the page a model as a person would drop it. */
export async function drop(page, name, bytes) {
  const transfer = await page.evaluateHandle(({ name, base64 }) => {
    const data = new DataTransfer();
    data.items.add(new File([Uint8Array.from(atob(base64), (char) => char.charCodeAt(0))], name));
    return data;
  }, { name, base64: Buffer.from(bytes).toString('base64') });
  for (const type of ['dragenter', 'dragover', 'drop']) await page.dispatchEvent('#canvas', type, { dataTransfer: transfer });
}

/** Until the part is placed, and inspected where it can be. */
export async function prepared(page, timeout = 60000) {
  await page.waitForFunction(() => {
    const { app } = window.s3;
    return app.model && !app.running && (app.inspection || document.querySelector('.message.bad'));
  }, null, { timeout });
}

/** Settings for runs of seconds. */
export async function coarse(page, params = {}) {
  await page.evaluate((values) => window.s3.app.setParams(values), { 'mesh.target_tets': 1500, 'nozzle.diameter': 3, ...params });
}

export async function sliced(page, timeout = 120000) {
  await page.waitForFunction(() => {
    const { app } = window.s3;
    return !app.running && app.stages.length > 0 && app.stages.every((stage) => stage.state === 'done');
  }, null, { timeout });
}

/** What the messages say. */
export const messages = (page) => page.locator('.message').allInnerTexts();

/** The 3D view's pixels, and how many of them differ between two of them. */
export async function pixels(page) {
  await page.evaluate(() => window.s3.workspace.viewer.draw());
  const data = await page.evaluate(() => {
    const { viewer } = window.s3.workspace;
    viewer.draw();
    const { canvas } = viewer;
    const copy = new OffscreenCanvas(canvas.width, canvas.height), context = copy.getContext('2d');
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
    let text = '';
    for (let i = 0; i < data.length; i += 0x8000) text += String.fromCharCode(...data.subarray(i, i + 0x8000));
    return btoa(text);
  });
  return Buffer.from(data, 'base64');
}
export function difference(a, b) {
  let count = 0;
  for (let i = 0; i < Math.min(a.length, b.length); i += 4) {
    if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 24) ++count;
  }
  return count / (a.length / 4);
}

/** A closed block as text STL: a test's own model. */
export function blockStl(x, y, z) {
  const v = (i) => [i & 1 ? x : 0, i & 2 ? y : 0, i & 4 ? z : 0];
  const faces = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]];
  const facet = (face) => `facet normal 0 0 0\nouter loop\n${face.map((i) => `vertex ${v(i).join(' ')}`).join('\n')}\nendloop\nendfacet`;
  return Buffer.from(`solid block\n${faces.map(facet).join('\n')}\nendsolid block\n`);
}
/** The block without one of its triangles. */
export const openStl = (x, y, z) => Buffer.from(blockStl(x, y, z).toString().replace(/facet[\s\S]*?endfacet\n/, ''));
